"""Draw why notebook folding's threshold is where it is: python -m docs.tasks.render_threshold.

Histograms of the mean distance to the goal at the end of noisy expert episodes: repeats of the
scene with another speed and noise, the notebook left open, and the notebook folded beside the
table (about two minutes on one core; needs Matplotlib).
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np

from docs.tasks.filming import FOLDER
from icd_envs.api import FloatArray
from icd_envs.experts.notebook_folding import Fault, NotebookFoldingExpert, Style
from icd_envs.geometry.folding import fold_gap
from icd_envs.tasks.base import run_expert
from icd_envs.tasks.notebook_folding import GOAL_DISTANCE, NotebookFolding
from icd_envs.tasks.problem import scene_rng

UPRIGHT = 0.12
"""[m] gap between the covers when they are at right angles."""
KINDS: dict[str, Fault | None] = {
    "folded on the table (noisy repeats)": None,
    "on the table, left open": "open",
    "folded beside the table": "beside",
}


def distance(points: FloatArray, goal: FloatArray) -> float:
    """Mean distance [m] of corresponding points."""
    return float(np.linalg.norm(points - goal, axis=-1).mean())


def measure(scenes: int) -> dict[str, list[float]]:
    """Distances [m] to the goal of the clean expert, by what happened."""
    task = NotebookFolding()
    found: dict[str, list[float]] = defaultdict(list)
    for seed in range(scenes):
        rng = scene_rng("train", 10_000 + seed)
        scene = task.draw_scenes(rng).scene
        plant = task.make_plant(scene)
        start = plant.get_state()
        clean = run_expert(task, scene, plant, task.make_expert(scene))
        if not clean.success:
            continue
        goal = clean.points[-1]
        gaps = fold_gap(clean.points)
        laid = int(np.max(np.flatnonzero(gaps > 0.98 * gaps.max())))
        upright = laid + int(np.argmax(gaps[laid:] < UPRIGHT))
        found["clean expert: laid down flat, not yet folded"].append(
            distance(clean.points[laid], goal)
        )
        found["clean expert: covers at right angles"].append(distance(clean.points[upright], goal))
        for kind, fault in KINDS.items():
            for _ in range(3 if fault is None else 1):
                plant.set_state(start)
                style = Style(fault, rng.uniform(0.018, 0.03), rng.uniform(0.0, 0.01))
                expert = NotebookFoldingExpert(scene, task.action_scale, style, rng)
                run = run_expert(task, scene, plant, expert)
                if run.success == (fault is None):
                    found[kind].append(distance(run.points[-1], goal))
    return found


def draw_histograms(scenes: int) -> None:
    """The three histograms with the threshold, and their quantiles as text."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    found = measure(scenes)
    figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
    for kind in KINDS:
        label = f"{kind}, n={len(found[kind])}"
        axes.hist(found[kind], bins=np.arange(0, 0.6, 0.01).tolist(), alpha=0.7, label=label)
    axes.axvline(GOAL_DISTANCE, color="black", linestyle="--", label=f"threshold {GOAL_DISTANCE} m")
    axes.set(xlabel="mean distance to the goal cloud [m]", ylabel="episodes")
    axes.legend(fontsize=8)
    figure.savefig(FOLDER / "notebook-folding-threshold.png", dpi=110)
    for kind, values in found.items():
        shares = np.percentile(values, [0, 5, 50, 95, 100]).round(3)
        below = float(np.mean(np.array(values) < GOAL_DISTANCE))
        print(
            f"{kind}: n={len(values)} 0/5/50/95/100 %: {shares}, below the threshold: {below:.2f}"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=60)
    draw_histograms(parser.parse_args().scenes)
