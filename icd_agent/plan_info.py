"""What a planner did in its last step, and what of it can be drawn."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from icd_agent.mppi.planner import Status
from icd_envs.api import Float64Array, FloatArray, PlanView, Rollout

BEST: Final = 5
"""Samples that a view shows."""


@dataclass(frozen=True)
class PlanInfo:
    """What the last ``act`` did. Times are for reports only; nothing is decided by them.

    The arrays are the planner's own, not copies: they cost nothing while nobody looks.

    Attributes:
        status: "ok", or why the agent held still.
        subgoal: index of the next subgoal in the chain.
        chain_length: L.
        best_cost: lowest cost of a valid sample; inf if there is none.
        mean_cost: mean cost of the valid samples.
        effective_samples: 1 / sum of squared weights, 0 to K.
        invalid_samples: samples that diverged or whose cost was not finite.
        rollout_seconds: [s] in the simulator.
        cost_seconds: [s] for features, distances and collisions.
        update_seconds: [s] for drawing samples and updating the plan.
        actions: (H, 3) the plan; its first action is the one returned.
        subgoals: (L, N, 3) [m] the chain as object clouds; None if its source has none.
        rollout: where the K samples led.
        costs: (K,) of the samples; inf where the physics diverged.
        steps: (L,) predicted control steps to each subgoal from the one before, to the first from
            where the chain began; None if its source predicts none.
    """

    status: Status
    subgoal: int
    chain_length: int
    best_cost: float
    mean_cost: float
    effective_samples: float
    invalid_samples: int
    rollout_seconds: float
    cost_seconds: float
    update_seconds: float
    actions: Float64Array = field(repr=False)
    subgoals: FloatArray | None = field(repr=False)
    rollout: Rollout = field(repr=False)
    costs: Float64Array = field(repr=False)
    steps: FloatArray | None = field(repr=False)

    def view(self) -> PlanView:
        """What can be drawn: subgoals, the plan and the best few samples."""
        order = np.argsort(self.costs, kind="stable")[:BEST]
        best = order[np.isfinite(self.costs[order])]
        return PlanView(
            status=f"{self.status}, subgoal {self.subgoal + 1} of {self.chain_length}",
            subgoals=self.subgoals,
            subgoal=self.subgoal,
            actions=self.actions,
            paths=self.rollout.gripper[best],
            ends=self.rollout.points[best, -1],
        )
