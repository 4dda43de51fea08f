"""Recorded states with their descriptors, as the learned parts of ICD are trained on them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

from benchmarks.parts import local_field, part
from benchmarks.training_progress import training
from icd_agent.chain import Features
from icd_agent.checkpoints import weights_sha256
from icd_agent.field.field import SceneField
from icd_agent.field.space import exact_features
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.scene_points import placed_in
from icd_agent.scene_tokens import SceneTokens, scene_tokens
from icd_agent.states import States, describe_states
from icd_envs.api import Float32Array, FloatArray
from icd_envs.demonstrations import Demonstrations
from icd_envs.demonstrations.header import read_header
from icd_envs.errors import DemonstrationsError
from icd_envs.registration import check_env_id
from icd_envs.tasks.problem import Split


class Described(NamedTuple):
    """States, and where they come from.

    Attributes:
        states: with descriptors.
        about: for the records of what is trained on them.
    """

    states: States
    about: dict[str, Any]


def read_demonstrations(env_id: str, folder: Path, split: Split = "train") -> Demonstrations:
    """Read demonstrations that must be of one task.

    Args:
        env_id: of the task, as ``gymnasium.make`` takes it: the module of ``module:ID`` is
            imported, here as at recording it may be any that registers the id.
        folder: of the demonstrations.
        split: the scenes that they must be of.

    Raises:
        InvalidOptionError: an id that is not registered.
        DemonstrationsError: missing, damaged, of another task or of other scenes.
    """
    check_env_id(env_id)
    header = read_header(folder)
    if header.env_id.rpartition(":")[2] != env_id.rpartition(":")[2]:
        raise DemonstrationsError(f"{folder} holds demonstrations of {header.env_id}, not {env_id}")
    if header.split != split:
        raise DemonstrationsError(
            f"{folder} has split={header.split!r}, expected {split!r}: what learns from test "
            "scenes cannot be measured in them: collect others, or say in Python that "
            f"split={header.split!r} is meant"
        )
    return Demonstrations(folder)


def about_of(demonstrations: Demonstrations, episodes: int) -> dict[str, Any]:
    """What demonstrations are, for the record of what is trained on them and for going on with it.

    Args:
        demonstrations: all that are in their folder, which may be filled further.
        episodes: the first so many are used, at most.

    Returns:
        JSON: task, options, base seed, split, whether the expert was noisy, ``most_steps`` of an
        episode, and the sha256 of the poses and actions of the first so many.
    """
    header, count = demonstrations.header, min(episodes, len(demonstrations))
    digest = hashlib.sha256(demonstrations.nodes[: demonstrations.first_state[count]].tobytes())
    digest.update(demonstrations.actions[: demonstrations.first_step[count]].tobytes())
    return {
        "env": header.env_id,
        "options": dict(header.options),
        "seed": header.seed,
        "split": header.split,
        "noisy": header.noisy,
        "most_steps": header.steps,
        "sha256": digest.hexdigest(),
    }


def describe(
    env_id: str, data: Path, field: Path | None, episodes: int, split: Split = "train"
) -> Described:
    """Descriptors of recorded states; kept in a folder beside the data, by field.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        field: folder of the field; None is the one that the package's chains are generated in.
        episodes: how many are used, at most.
        split: the scenes that they must be of.

    Raises:
        IcdError: missing, damaged or unfitting demonstrations or weights.
    """

    def descriptors(network: SceneField, scene: Float32Array) -> tuple[Features, SceneTokens]:
        return exact_features(network, scene), scene_tokens(network, scene)

    folder = part(env_id, FIELD, field)
    demonstrations = read_demonstrations(env_id, data, split)
    return _describe(demonstrations, data, folder, episodes, descriptors, "descriptors")


def describe_places(
    env_id: str, data: Path, field: Path | None, episodes: int, split: Split = "train"
) -> Described:
    """The same with places of the object's points, in the frame that their episode begins in.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        field: folder of the field, which describes scenes; None is the package's local one.
        episodes: how many are used, at most.
        split: the scenes that they must be of.

    Raises:
        IcdError: missing, damaged or unfitting demonstrations or weights.
    """

    def places(network: SceneField, scene: Float32Array) -> tuple[Features, SceneTokens]:
        tokens = scene_tokens(network, scene)

        def features(clouds: FloatArray) -> FloatArray:
            return placed_in(tokens.frame(clouds[0].mean(axis=0)))(clouds)

        return features, tokens

    folder = local_field(env_id, field)
    demonstrations = read_demonstrations(env_id, data, split)
    states, about = _describe(demonstrations, data, folder, episodes, places, "places")
    begun = states.middle[states.first[states.episode]]
    return Described(states._replace(middle=begun), about)


def _describe(
    demonstrations: Demonstrations,
    data: Path,
    field: Path,
    episodes: int,
    look: Callable[[SceneField, Float32Array], tuple[Features, SceneTokens]],
    kind: Literal["descriptors", "places"],
) -> Described:
    data = data.resolve()
    network, weights = load_field(field), weights_sha256(field)
    count = min(episodes, len(demonstrations))
    space = weights if kind == "descriptors" else f"{kind}-{weights}"
    name = space.replace(weights, weights[:8])
    with training(f"{kind} of recorded states, by episode", count) as seen:
        states = describe_states(
            demonstrations,
            partial(look, network),
            data.with_name(f"{data.name}-{count}-{name}"),
            space=space,
            episodes=count,
            seen=lambda done: seen(done, {}),
        )
    return Described(states, {**about_of(demonstrations, episodes), "field": weights})
