"""What ``icd-bench render chain`` does: a generated chain beside what the expert did."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from benchmarks.contact_env import contact_env
from benchmarks.figures import Colours, new_figure, save_figure
from benchmarks.parts import check_places
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.generate import Generator
from icd_agent.field.space import ExactFieldSpace
from icd_agent.field.supervision import above_floor
from icd_agent.mppi.costs import squared_distance
from icd_agent.networks import load_networks, load_shipped
from icd_agent.presets import PRESETS
from icd_envs.api import Float32Array, FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d.axes3d import Axes3D

COLUMNS: Final = 4
"""Of two rows of subgoals that are drawn as objects."""


def render(env_id: str, out: Path, *, seed: int, weights: Path | None) -> None:
    """Draw a generated chain of one test scene.

    Args:
        env_id: which environment.
        out: PNG file.
        seed: of the scene and of the chain.
        weights: folder of field, latent and diffusion; None is the package's.

    Raises:
        InvalidOptionError: unknown environment, a file that is no PNG, or no Matplotlib.
        CheckpointError: missing or damaged weights.
    """
    with contact_env(env_id) as env:
        figure = new_figure(out, (14, 9))
        networks = load_shipped(env_id) if weights is None else load_networks(weights, env_id)
        check_places(networks.diffusion)
        observation, _ = env.reset(seed=seed)
        episode = env.episode(oracle=True)
    assert episode.oracle is not None
    clouds: Float32Array = episode.oracle.points
    scene = observation["scene"]
    placed = ExactFieldSpace(networks.encoded).place(observation, foreign=episode.foreign_goal)
    generator = Generator(networks.diffusion, networks.latent, PRESETS["improved"].chain)
    source = DiffusedSource(networks.encoded, networks.latent, generator)
    rng = np.random.default_rng(seed)
    chain = source.chain(episode, observation, placed, rng)
    assert chain.begin is not None
    assert chain.clouds is not None
    made = np.concatenate([chain.begin[None], chain.features])
    places = np.concatenate([observation["achieved_goal"][None], chain.clouds])
    times = np.rint(np.linspace(0, len(clouds) - 1, len(made))).astype(int)
    done = placed.here(clouds[times])
    nearest = squared_distance(made[:, None], placed.here(clouds))[:, 0].argmin(axis=1)

    colours = Colours(np.concatenate([done, made]).reshape(-1, made.shape[-1]))
    fixtures = above_floor(scene, networks.field.config.floor_margin)
    everything = np.concatenate([fixtures, places.reshape(-1, 3)])
    box = np.stack([everything.min(axis=0), everything.max(axis=0)])
    half = COLUMNS // 2
    grid = figure.add_gridspec(3, COLUMNS)
    left, right = figure.add_subplot(grid[0, :half]), figure.add_subplot(grid[0, half:])
    _draw_map(left, colours(done), "the expert's states at equal times")
    _draw_map(right, colours(made), "generated subgoals")
    shown = np.unique(np.linspace(0, len(made) - 1, 2 * COLUMNS).astype(int))
    for place, i in enumerate(shown):
        where = grid[1 + place // COLUMNS, place % COLUMNS]
        axis = figure.add_subplot(where, projection="3d")
        title = f"subgoal {i}: most like step {nearest[i]}"
        _draw_object(axis, fixtures, places[i], box, colours(made[i]), title)
    figure.suptitle(f"{env_id}, test scene {seed}: descriptors of a chain")
    save_figure(figure, out)


def _draw_map(axis: Axes, picture: FloatArray, title: str) -> None:
    axis.imshow(picture, aspect="auto", interpolation="nearest")
    axis.set_title(title)
    axis.set_xlabel("point of the object")
    axis.set_ylabel("subgoal")
    axis.set_yticks(range(0, len(picture), 4))


def _draw_object(
    axis: Axes3D,
    fixtures: FloatArray,
    cloud: FloatArray,
    box: FloatArray,
    shown: FloatArray,
    title: str,
) -> None:
    """Where a subgoal is, in the colours of its descriptors."""
    axis.scatter(*fixtures.T, s=1, color="0.8")
    axis.scatter(*cloud.T, s=9, c=shown, depthshade=False)
    for low, high, limit in zip(*box, (axis.set_xlim, axis.set_ylim, axis.set_zlim), strict=True):
        limit(low, high)
    axis.set_box_aspect(box[1] - box[0], zoom=1.1)
    axis.view_init(elev=40, azim=-70)
    axis.set_axis_off()
    axis.set_title(title, fontsize=9)
