"""``icd-bench train``, ``diagnose`` and ``render``: the networks that methods are made of."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from benchmarks.console import (
    AsJson,
    TaskOptions,
    TrustPickle,
    errors_in_one_line,
    import_from_working_directory,
    say,
)
from benchmarks.training_order import TrainingOrder

GROUPS: Final = {
    "train": typer.Typer(help="Train a network from recorded demonstrations."),
    "diagnose": typer.Typer(help="Measure a network in test scenes."),
    "render": typer.Typer(help="Draw what a network has learned, or an episode."),
}
Env = Annotated[str, typer.Option(help="Environment id; of your own, module:ID.")]
Weights = Annotated[
    Path | None,
    typer.Option(help="Folder of a trained network.", show_default="those of the package"),
]
WeightsOfAgent = Annotated[
    Path | None,
    typer.Option(help="Folder of field, latent and diffusion.", show_default="the package's"),
]
AS_SHIPPED: Final = "as for the package's weights"
Seed = Annotated[int, typer.Option(min=0, help="Of every draw.")]
Data = Annotated[Path, typer.Option(help="Folder that icd-bench collect has filled.")]
Out = Annotated[Path, typer.Option(help="Folder of the run; a killed one goes on.")]
Picture = Annotated[Path, typer.Option(help="PNG file to write.")]
Device = Annotated[str, typer.Option(help="cpu, or cuda.")]
Field = Annotated[
    Path | None, typer.Option(help="Folder of a trained field.", show_default="the package's")
]
Latent = Annotated[
    Path | None,
    typer.Option(help="Folder of a trained autoencoder.", show_default="the package's"),
]
Scenes = Annotated[int, typer.Option(min=1, help="Test scenes.")]
Episodes = Annotated[int, typer.Option(min=1, help="Episodes that are used, at most.")]
Steps = Annotated[int, typer.Option(min=1, help="Optimiser steps.")]


@GROUPS["train"].callback()
@GROUPS["diagnose"].callback()
@GROUPS["render"].callback()
def _group() -> None:
    """Find ids of the user's own in modules beside them; a group keeps its only command's name."""
    import_from_working_directory()


@GROUPS["train"].command("field")
def train_field(
    env: Env,
    data: Data,
    out: Out,
    device: Device = "cpu",
    steps: Annotated[
        int | None, typer.Option(min=1, help="Optimiser steps.", show_default=AS_SHIPPED)
    ] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Episodes whose scenes are used.")] = 1500,
    seed: Seed = 0,
    scope: Annotated[
        Literal["local", "global"], typer.Option(help="global: one code for the whole scene.")
    ] = "local",
    length_scale: Annotated[
        float | None,
        typer.Option(help="Metres beyond which distances count less.", show_default=AS_SHIPPED),
    ] = None,
    outlook_scale: Annotated[
        float | None,
        typer.Option(help="Metres a point at a surface looks out.", show_default=AS_SHIPPED),
    ] = None,
    near_spread: Annotated[
        float | None,
        typer.Option(help="Metres around surfaces to learn about.", show_default=AS_SHIPPED),
    ] = None,
    anchors: Annotated[
        int | None,
        typer.Option(min=1, help="Points that carry features.", show_default=AS_SHIPPED),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Train the scene descriptor field."""
    with errors_in_one_line():
        from benchmarks.train_field import Scales, scales_of, train

        usual = scales_of(env, scope)
        scales = Scales(
            usual.length if length_scale is None else length_scale,
            usual.outlook if outlook_scale is None else outlook_scale,
            usual.near if near_spread is None else near_spread,
            usual.anchors if anchors is None else anchors,
            usual.steps if steps is None else steps,
        )
        values = train(env, data, out, scope, scales, device=device, scenes=scenes, seed=seed)
        say(values, as_json)


@GROUPS["train"].command("latent")
def train_latent(
    env: Env,
    data: Data,
    out: Out,
    field: Field = None,
    device: Device = "cpu",
    steps: Steps = 4000,
    episodes: Episodes = 1500,
    seed: Seed = 0,
    decoder_width: Annotated[int, typer.Option(min=1, help="Of its outermost hidden layers.")] = 64,
    as_json: AsJson = False,
) -> None:
    """Train the autoencoder of object states and the prediction of steps between them."""
    with errors_in_one_line():
        from benchmarks.train_latent import latent

        order = TrainingOrder(env, data, out, device, steps, episodes, seed)
        say(latent(order, field=field, decoder_width=decoder_width), as_json)


@GROUPS["train"].command("diffusion")
def train_diffusion(
    env: Env,
    data: Data,
    out: Out,
    field: Field = None,
    latent: Latent = None,
    device: Device = "cpu",
    steps: Steps = 8000,
    episodes: Episodes = 1500,
    seed: Seed = 0,
    places: Annotated[
        int, typer.Option(min=0, help="Numbers for places beside each latent; 0: contacts only.")
    ] = 16,
    as_json: AsJson = False,
) -> None:
    """Train the denoiser of chains of subgoals."""
    with errors_in_one_line():
        from benchmarks.train_latent import diffusion

        order = TrainingOrder(env, data, out, device, steps, episodes, seed)
        say(diffusion(order, field=field, latent=latent, places=places), as_json)


@GROUPS["train"].command("bank")
def train_bank(
    env: Env,
    data: Data,
    out: Annotated[Path, typer.Option(help="Folder to write.")],
    field: Field = None,
    latent: Latent = None,
    episodes: Episodes = 1500,
    as_json: AsJson = False,
) -> None:
    """Keep recorded chains, for the agent ladder:retrieved-chain; nothing is optimised."""
    with errors_in_one_line():
        from benchmarks.train_bank import bank

        values = bank(env, data, out, field=field, latent=latent, episodes=episodes)
        say(values, as_json)


@GROUPS["diagnose"].command("field")
def diagnose_field(
    env: Env,
    scenes: Scenes = 10,
    seed: Seed = 0,
    weights: Weights = None,
    as_json: AsJson = False,
) -> None:
    """Measure the scene descriptor field: truth, invariance, interpolation, ranking of plans."""
    with errors_in_one_line():
        from benchmarks.diagnose_field import diagnose

        values = diagnose(env, scenes, seed=seed, weights=weights)
        say(values, as_json)


@GROUPS["diagnose"].command("latent")
def diagnose_latent(
    env: Env,
    scenes: Scenes = 20,
    seed: Seed = 0,
    field: Field = None,
    weights: Weights = None,
    as_json: AsJson = False,
) -> None:
    """Measure the autoencoder on unseen states: what comes back, and steps between states."""
    with errors_in_one_line():
        from benchmarks.diagnose_latent import diagnose

        say(diagnose(env, scenes, seed=seed, field=field, weights=weights), as_json)


@GROUPS["diagnose"].command("diffusion")
def diagnose_diffusion(
    env: Env,
    scenes: Scenes = 20,
    seed: Seed = 0,
    field: Field = None,
    latent: Latent = None,
    weights: Weights = None,
    as_json: AsJson = False,
) -> None:
    """Measure generated chains against what the expert did in unseen scenes."""
    with errors_in_one_line():
        from benchmarks.diagnose_diffusion import diagnose

        values = diagnose(env, scenes, seed=seed, field=field, latent=latent, weights=weights)
        say(values, as_json)


@GROUPS["diagnose"].command("ends")
def diagnose_ends(
    env: Env,
    scenes: Scenes = 20,
    seed: Seed = 0,
    agent: Annotated[
        Literal["icd", "subgoal-diffuser"], typer.Option(help="Who generates it.")
    ] = "icd",
    chains: Annotated[int, typer.Option(min=1, help="Chains per scene.")] = 6,
    weights: WeightsOfAgent = None,
    options: TaskOptions = None,
    as_json: AsJson = False,
) -> None:
    """Measure how often the last subgoal, generated for a goal of another scene, is right."""
    with errors_in_one_line():
        from benchmarks.diagnose_ends import diagnose

        values = diagnose(
            env,
            scenes,
            agent=agent,
            seed=seed,
            chains=chains,
            weights=weights,
            options=options or (),
        )
        say(values, as_json)


@GROUPS["render"].command("field")
def render_field(
    env: Env,
    out: Picture,
    seed: Seed = 0,
    weights: Weights = None,
) -> None:
    """Draw slices of the field, its gradients, and the object coloured by descriptor."""
    with errors_in_one_line():
        from benchmarks.render_field import render

        render(env, out, seed=seed, weights=weights)


@GROUPS["render"].command("chain")
def render_chain(
    env: Env,
    out: Picture,
    seed: Seed = 0,
    weights: WeightsOfAgent = None,
) -> None:
    """Draw a generated chain of subgoals beside what the expert did."""
    with errors_in_one_line():
        from benchmarks.render_chain import render

        render(env, out, seed=seed, weights=weights)


@GROUPS["render"].command("episode")
def render_episode(
    agent: Annotated[str, typer.Option(help="Agent, as icd-bench run takes it.")],
    env: Env,
    out: Annotated[Path, typer.Option(help="PNG file for a strip of pictures, GIF for a film.")],
    options: TaskOptions = None,
    seed: Annotated[
        int,
        typer.Option(min=0, help="Of scene and agent, as for reset; a row's draws its episode."),
    ] = 0,
    trust_pickle: TrustPickle = False,
) -> None:
    """Draw one test episode."""
    with errors_in_one_line():
        from benchmarks.render_episode import render

        render(agent, env, out, seed=seed, options=options or (), trust_pickle=trust_pickle)
