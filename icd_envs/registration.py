"""Ids under which Gymnasium makes the environments. Imports Gymnasium only."""

from __future__ import annotations

import importlib
from typing import Final

import gymnasium as gym
from gymnasium.envs.registration import WrapperSpec

from icd_envs.errors import InvalidOptionError, unknown_name

ENTRY_POINTS: Final = {
    "ICDCableRouting-v0": "icd_envs.tasks.cable_routing:make_cable_routing",
    "ICDNotebookFolding-v0": "icd_envs.tasks.notebook_folding:make_notebook_folding",
    "ICDCableRoutingAdaptation-v0": "icd_envs.tasks.cable_routing:make_cable_routing_adaptation",
    "ICDNotebookFoldingAdaptation-v0": (
        "icd_envs.tasks.notebook_folding:make_notebook_folding_adaptation"
    ),
}
ENV_IDS: Final[tuple[str, ...]] = tuple(ENTRY_POINTS)
OWN_BUDGET: Final = WrapperSpec("OwnBudget", "icd_envs.tasks.budget:take_budget", {})


def register_envs() -> None:
    """Register every environment of this package; a second call does nothing."""
    for env_id, entry_point in ENTRY_POINTS.items():
        register_env(env_id, entry_point)


def register_env(env_id: str, entry_point: str) -> None:
    """Register an environment built on ``icd_envs.tasks.env.ContactEnv``, ours or your own.

    No ``max_episode_steps``: the budget depends on the options of an environment, which keeps it
    itself and shows it in its ``spec``.

    Args:
        env_id: the ``env_id`` of its task; an id that is registered already stays as it is.
        entry_point: ``module:name`` of an ``icd_envs.tasks.factory.EnvFactory``.
    """
    if env_id not in gym.registry:
        gym.register(
            env_id,
            entry_point=entry_point,
            order_enforce=False,  # our own error names the fix
            disable_env_checker=True,  # it breaks once a first step has raised
            additional_wrappers=(OWN_BUDGET,),
        )


def check_env_id(env_id: str) -> None:
    """Make sure that ``gymnasium.make`` will know an environment.

    Args:
        env_id: its id, or ``module:ID``, where importing the module registers it.

    Raises:
        InvalidOptionError: it will not.
    """
    module, _, name = env_id.rpartition(":")
    try:
        if module:
            importlib.import_module(module)
        gym.spec(name)
    except (Exception, SystemExit) as error:
        why = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise InvalidOptionError(
            f"{unknown_name('environment id', env_id, ENV_IDS)}; one of your own is module:ID, "
            f"where importing the module registers it ({why})"
        ) from error
