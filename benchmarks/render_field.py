"""What ``icd-bench render field`` does: slices of the field, and the object in two scenes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
import torch

from benchmarks.fields import field_in_test_scenes
from benchmarks.figures import Colours, new_figure, save_figure
from icd_agent.field.baked import ask
from icd_agent.field.field import FieldOutput, SceneField
from icd_agent.field.supervision import above_floor
from icd_envs.api import Float32Array, FloatArray
from icd_envs.tasks.env import ContactEnv

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d.axes3d import Axes3D

SPACING: Final = 0.004
"""[m] between the pixels of a slice."""
ARROWS: Final = 8
"""Pixels between arrows."""
MARGIN: Final = 0.08
"""[m] around the fixtures that a slice shows."""
BELOW = 0.75
"""Share of the median height of surfaces, which is often just that of a table's top."""


class _Scene(NamedTuple):
    """A test scene: its cloud (M, 3), its fixtures' (F, 3) and the object's (T, N, 3), [m]."""

    cloud: Float32Array
    fixtures: FloatArray
    states: Float32Array


def render(env_id: str, out: Path, *, seed: int, weights: Path | None) -> None:
    """Draw the field of two test scenes into one picture.

    Args:
        env_id: which environment.
        out: PNG file.
        seed: of the first scene; the second follows.
        weights: folder of the field; None is the package's.

    Raises:
        InvalidOptionError: unknown environment, a file that is no PNG, or no Matplotlib.
        CheckpointError: missing or damaged weights.
    """
    figure = new_figure(out, (13, 10))
    with field_in_test_scenes(env_id, weights) as (field, env):
        scenes = [_draw_scene(env, i, field.config.floor_margin) for i in (seed, seed + 1)]
    objects = [_ask(field, scene.cloud, scene.states[::10].reshape(-1, 3)) for scene in scenes]
    colours = Colours(np.concatenate([found.descriptor[0].numpy() for found in objects]))
    for place, upright in ((1, False), (2, True)):
        _draw_slice(figure.add_subplot(2, 2, place), field, scenes[0], colours, upright=upright)
    for place, scene, name in zip((3, 4), scenes, ("this scene", "another scene"), strict=True):
        axis = figure.add_subplot(2, 2, place, projection="3d")
        _draw_object(axis, field, scene, colours, name)
    figure.suptitle(f"{env_id}: descriptors by their first three principal components")
    save_figure(figure, out)


def _draw_scene(env: ContactEnv[Any], seed: int, margin: float) -> _Scene:
    observation, _ = env.reset(seed=seed)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    cloud = observation["scene"]
    return _Scene(cloud, above_floor(cloud, margin), oracle.points)


def _ask(field: SceneField, cloud: Float32Array, points: FloatArray) -> FieldOutput:
    with torch.no_grad():
        code = field.encoder(torch.from_numpy(cloud)[None])
    return ask(field, code, points)


def _draw_slice(
    axis: Axes, field: SceneField, scene: _Scene, colours: Colours, *, upright: bool
) -> None:
    """A level slice below the tops of most fixtures, or an upright one along x."""
    low, high = scene.fixtures.min(axis=0) - MARGIN, scene.fixtures.max(axis=0) + MARGIN
    across, fixed = (2, 1) if upright else (1, 2)
    middle = float(np.median(scene.fixtures[:, fixed]))
    if not upright:
        middle *= BELOW
    low[2] = max(low[2], 0.0)
    u = np.arange(low[0], high[0], SPACING)
    v = np.arange(low[across], high[across], SPACING)
    points = np.full((len(v), len(u), 3), middle, np.float32)
    points[..., 0], points[..., across] = u, v[:, None]
    found = _ask(field, scene.cloud, points.reshape(-1, 3))
    picture = colours(found.descriptor[0].numpy()).reshape(len(v), len(u), 3)
    extent = (float(u[0]), float(u[-1]), float(v[0]), float(v[-1]))
    axis.imshow(picture, origin="lower", extent=extent, aspect="equal")
    inside = found.occupancy[0].numpy().reshape(len(v), len(u))
    axis.contour(u, v, inside, levels=[0.0], colors="black", linewidths=1.2)
    gradient = found.gradient[0].numpy().reshape(len(v), len(u), 3)[::ARROWS, ::ARROWS]
    axis.quiver(
        u[::ARROWS], v[::ARROWS], gradient[..., 0], gradient[..., across], color="white",
        scale=45, width=0.002,
    )  # fmt: skip
    axis.set_title(f"slice at {'y' if upright else 'z'} = {middle:.2f} m; surface, gradient")
    axis.set_xlabel("x [m]")
    axis.set_ylabel(f"{'z' if upright else 'y'} [m]")


def _draw_object(
    axis: Axes3D, field: SceneField, scene: _Scene, colours: Colours, name: str
) -> None:
    """The object at the goal, among the fixtures."""
    points = scene.states[-1]
    shown = colours(_ask(field, scene.cloud, points).descriptor[0].numpy())
    axis.scatter(*scene.fixtures.T, s=1, color="0.8")
    axis.scatter(*points.T, s=22, c=shown, depthshade=False)
    axis.set_aspect("equal")
    axis.view_init(elev=40, azim=-70)
    axis.set_title(f"the object at its goal, {name}")
