"""Ids under which Gymnasium makes the environments. Imports Gymnasium only."""

from __future__ import annotations

from typing import Final

import gymnasium as gym

MAX_STEPS: Final = {"ICDCableRouting-v0": 300, "ICDNotebookFolding-v0": 150}
ENTRY_POINTS: Final = {
    "ICDCableRouting-v0": "icd_envs.tasks.cable_routing:CableRoutingEnv",
    "ICDNotebookFolding-v0": "icd_envs.tasks.notebook_folding:NotebookFoldingEnv",
}
ENV_IDS: Final[tuple[str, ...]] = tuple(ENTRY_POINTS)


def register_envs() -> None:
    """Register every environment; a second call does nothing."""
    for env_id, entry_point in ENTRY_POINTS.items():
        if env_id not in gym.registry:
            gym.register(
                env_id,
                entry_point=entry_point,
                max_episode_steps=MAX_STEPS[env_id],
                order_enforce=False,  # our own error names the fix
                disable_env_checker=True,  # it breaks once a first step has raised
            )
