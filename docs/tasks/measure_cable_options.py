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
    """One row: scenes solved, mean complete rate, steps it took, divergences."""
    task = CableRouting(num_fixtures, cable)
    runs = [demonstrate_task(task, seed=seed, split="test") for seed in range(scenes)]
    steps = [run.steps for run in runs if run.success]
    cells = (
        num_fixtures,
        cable,
        f"{sum(run.success for run in runs)} / {scenes}",
        f"{np.mean([run.complete_rate for run in runs]):.2f}",
        f"{np.median(steps):.0f}, {max(steps)} of {task.max_steps}",
        sum(run.diverged for run in runs),
    )
    return "| " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--fixtures", type=int, nargs="*", default=[1, 2, 3, 4])
    parser.add_argument("--cables", nargs="*", default=[*CABLES])
    options = parser.parse_args()
    for cable in options.cables:
        for num_fixtures in options.fixtures:
            print(measure(num_fixtures, cable, options.scenes), flush=True)
