"""How the scripted expert does with each option: python docs/tasks/measure_cable_options.py.

Raw test scenes, none rejected. Prints the rows of the table in docs/tasks/cable-routing.md.
"""

from __future__ import annotations

import argparse

import numpy as np

from icd_envs.demonstrations import demonstrate_task
from icd_envs.scenes.cable import CABLES, CableKind
from icd_envs.tasks.cable_routing import CableRouting


def measure(num_fixtures: int, cable: CableKind, scenes: int) -> str:
    """One row: clean expert, steps it took, noisy expert, divergences."""
    task = CableRouting(num_fixtures, cable)
    clean = [demonstrate_task(task, seed=seed, split="test") for seed in range(scenes)]
    noisy = [demonstrate_task(task, seed=seed, noisy=True) for seed in range(scenes)]
    steps = [run.steps for run in clean if run.success]
    cells = (
        num_fixtures,
        cable,
        f"{sum(run.success for run in clean)} / {scenes}",
        f"{np.mean([run.complete_rate for run in clean]):.2f}",
        f"{np.median(steps):.0f}, {max(steps)} of {task.max_steps}",
        f"{sum(run.success for run in noisy)} / {scenes}",
        sum(run.diverged for run in clean + noisy),
    )
    return "| " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--fixtures", type=int, nargs="*", default=[1, 2, 3, 4])
    options = parser.parse_args()
    for cable in CABLES:
        for num_fixtures in options.fixtures:
            print(measure(num_fixtures, cable, options.scenes), flush=True)
