"""Recorded states with their descriptors, as the learned parts of ICD are trained on them."""

from __future__ import annotations

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


class Described(NamedTuple):
    """States, and where they come from.

    Attributes:
        states: with descriptors.
        about: for the records of what is trained on them.
    """

    states: States
    about: dict[str, Any]


def read_demonstrations(env_id: str, folder: Path) -> Demonstrations:
    """Read demonstrations that must be of one task.

    Args:
        env_id: of the task, as ``gymnasium.make`` takes it: the module of ``module:ID`` is
            imported, here as at recording it may be any that registers the id.
        folder: of the demonstrations.

    Raises:
        InvalidOptionError: an id that is not registered.
        DemonstrationsError: missing, damaged, or of another task.
    """
    check_env_id(env_id)
    found = read_header(folder).env_id
    if found.rpartition(":")[2] != env_id.rpartition(":")[2]:
        raise DemonstrationsError(f"{folder} holds demonstrations of {found}, not {env_id}")
    return Demonstrations(folder)


def describe(env_id: str, data: Path, field: Path | None, episodes: int) -> Described:
    """Descriptors of recorded states; kept in a folder beside the data, by field.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        field: folder of the field; None is the one that the package's chains are generated in.
        episodes: how many are used, at most.

    Raises:
        IcdError: missing, damaged or unfitting demonstrations or weights.
    """

    def descriptors(network: SceneField, scene: Float32Array) -> tuple[Features, SceneTokens]:
        return exact_features(network, scene), scene_tokens(network, scene)

    folder = part(env_id, FIELD, field)
    return _describe(env_id, data, folder, episodes, descriptors, "descriptors")


def describe_places(env_id: str, data: Path, field: Path | None, episodes: int) -> Described:
    """The same with places of the object's points, in the frame that their episode begins in.

    Args:
        env_id: what the demonstrations must be of.
        data: folder of the demonstrations.
        field: folder of the field, which describes scenes; None is the package's local one.
        episodes: how many are used, at most.

    Raises:
        IcdError: missing, damaged or unfitting demonstrations or weights.
    """

    def places(network: SceneField, scene: Float32Array) -> tuple[Features, SceneTokens]:
        tokens = scene_tokens(network, scene)

        def features(clouds: FloatArray) -> FloatArray:
            return placed_in(tokens.frame(clouds[0].mean(axis=0)))(clouds)

        return features, tokens

    folder = local_field(env_id, field)
    states, about = _describe(env_id, data, folder, episodes, places, "places")
    begun = states.middle[states.first[states.episode]]
    return Described(states._replace(middle=begun), about)


def _describe(
    env_id: str,
    data: Path,
    field: Path,
    episodes: int,
    look: Callable[[SceneField, Float32Array], tuple[Features, SceneTokens]],
    kind: Literal["descriptors", "places"],
) -> Described:
    demonstrations = read_demonstrations(env_id, data)
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
    header = demonstrations.header
    about = {"env": env_id, "options": dict(header.options), "seed": header.seed, "field": weights}
    return Described(states, about)
