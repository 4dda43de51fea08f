"""What ``icd-bench diagnose diffusion`` does: generated chains against what really happened."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from scipy.stats import kendalltau
from torch import Tensor

from benchmarks.console import Values
from benchmarks.held_out import held_out, other_runs
from benchmarks.parts import chain_parts, check_places, part
from icd_agent.checkpoints import check_made_with
from icd_agent.diffusion.config import LONGEST, ChainConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.generate import Generated, Generator, Task
from icd_agent.diffusion.train import KIND as DIFFUSION
from icd_agent.diffusion.train import encode_states, load_diffusion
from icd_agent.encoded import encode
from icd_agent.field.field import SceneField
from icd_agent.field.space import exact_features
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.latent.model import LatentModel
from icd_agent.latent.train import KIND as LATENT
from icd_agent.latent.train import load_latent
from icd_agent.options import require
from icd_agent.scene_tokens import Frame
from icd_agent.states import States
from icd_envs.api import Float32Array, FloatArray

RUNS = 20
"""Noisy experts per scene whose states are called possible."""


def diagnose(
    env_id: str,
    scenes: int,
    *,
    seed: int,
    field: Path | None,
    latent: Path | None,
    weights: Path | None,
) -> Values:
    """Measure a denoiser: chains of 17 from first to last states of the noisy expert.

    Args:
        env_id: which environment.
        scenes: how many test scenes, at least 2: the next one's goal and tokens are the others.
        seed: of scenes and chains.
        field: folder of the field; None is the package's.
        latent: folder of the autoencoder; None is the package's.
        weights: folder of the denoiser; None is the package's.

    Returns:
        All distances are between latents divided by one number, so that they have unit variance,
        root mean square per number: ``nearest_state``, of generated subgoals to the nearest real
        state of their scene; ``step_distance``, between consecutive states of a real chain, to
        compare it with; ``off_possible``, of generated subgoals to the nearest state of many other
        noisy experts in the same scene, which tells whether they can be, beside
        ``off_possible_asked`` of what the field says at their places, ``off_possible_real`` of real
        states and ``off_possible_line`` of a straight line;
        ``order``, Kendall's tau of the subgoals' places in the chain and the times of these
        states; ``endpoint_error``, of a last subgoal generated for a goal of another scene, to the
        last state of its own; ``goal_distance``, of that foreign goal itself; and mean squared
        errors of the whole chain against states at equal distances: ``chain_mse``, beside
        ``line_mse`` of a straight line between the ends and ``other_scene_mse`` of a chain
        generated with another scene's tokens.

    Raises:
        IcdError: unknown environment, a single scene, missing or damaged weights, or such as were
            not trained on one another.
    """
    require(scenes >= 2, "scenes", scenes, "at least 2: chains are compared between scenes")
    parts, weights = chain_parts(env_id, field, latent), part(env_id, DIFFUSION, weights)
    for name, used in ((FIELD, parts.field), (LATENT, parts.latent)):
        check_made_with(weights, name, used)
    denoiser = load_diffusion(weights)
    check_places(denoiser)
    network, model = load_field(parts.field), load_latent(parts.latent)
    generator = Generator(denoiser, model, ChainConfig(reachable=None))
    states, seeds, clouds = held_out(env_id, scenes, seed=seed, field=parts.field)
    latents = encode_states(states, model)
    rng = np.random.default_rng([seed])
    found = []
    for i in range(len(seeds)):
        describe = _Describe(network, model, clouds[i], states.canonical)
        possible = describe(other_runs(env_id, seeds[i], RUNS))
        found.append(_chain(states, latents, possible, describe, i, denoiser, generator, rng))
    return {
        "scenes": len(seeds),
        **{name: float(np.mean([each[name] for each in found])) for name in found[0]},
    }


class _Describe(NamedTuple):
    """Clouds in one scene -> latents."""

    field: SceneField
    model: LatentModel
    scene: Float32Array
    canonical: Float32Array

    def __call__(self, clouds: FloatArray) -> Tensor:
        features = exact_features(self.field, self.scene)(clouds)
        return encode(self.model, features, self.canonical)


def _chain(
    states: States,
    latents: Tensor,
    possible: Tensor,
    describe: _Describe,
    i: int,
    denoiser: Denoiser,
    generator: Generator,
    rng: np.random.Generator,
) -> dict[str, float]:
    code = denoiser.code

    def normal(values: Tensor) -> Tensor:
        latent = code.latent
        return (values - code.mean[:latent]) / code.deviation[:latent].square().mean().sqrt()

    first, end = states.first[i : i + 2]
    other = (i + 1) % (len(states.first) - 1)
    real = normal(latents[first:end])
    size = denoiser.config.scene_size

    frames = states.frame(states.first[i : i + 1])
    frame = Frame(frames.origin[0], frames.along[0])

    def placed(row: int) -> Tensor:
        return torch.from_numpy(frame.place(states.clouds[row]).astype(np.float32))

    def generate(scene_of: int, goal_of: int) -> Generated:
        foreign = goal_of != i
        last = states.first[goal_of + 1] - 1
        tokens = torch.from_numpy(states.seen_from(states.first[[scene_of]], size)[0])
        task = Task(
            code.join(latents[first], placed(first)),
            code.join(latents[last], None if foreign else placed(last)),
            foreign,
            tokens,
        )
        return generator.generate(task, rng)

    made, elsewhere = generate(i, i), normal(generate(other, i).latents)
    assert made.clouds is not None
    chain, foreign = normal(made.latents), normal(generate(i, other).latents)
    asked = normal(describe(frame.back(made.clouds.numpy())))
    places = np.rint(np.linspace(0, len(real) - 1, LONGEST)).astype(np.int64)
    true = real[torch.from_numpy(places)]
    share = torch.linspace(0.0, 1.0, LONGEST)[:, None]
    line = true[0] + share * (true[-1] - true[0])
    others = normal(possible)

    def off(subgoals: Tensor) -> float:
        between = subgoals[1:-1]
        return float((between[:, None] - others[None]).square().mean(-1).sqrt().amin(dim=1).mean())

    apart = (chain[:, None] - real[None]).square().mean(-1).sqrt()
    goal = normal(latents[states.first[other + 1] - 1])
    return {
        "nearest_state": float(apart.amin(dim=1)[1:-1].mean()),
        "step_distance": float((true[1:] - true[:-1]).square().mean(-1).sqrt().mean()),
        "off_possible": off(chain),
        "off_possible_asked": off(asked),
        "off_possible_real": off(true),
        "off_possible_line": off(line),
        "order": float(kendalltau(np.arange(LONGEST), apart.argmin(dim=1).numpy()).statistic),
        "endpoint_error": float((foreign[-1] - real[-1]).square().mean().sqrt()),
        "goal_distance": float((goal - real[-1]).square().mean().sqrt()),
        "chain_mse": float((chain - true).square().mean()),
        "line_mse": float((line - true).square().mean()),
        "other_scene_mse": float((elsewhere - true).square().mean()),
    }
