"""Agents and environments by name; nothing is imported before it is asked for."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable

from icd_envs.api import Agent
from icd_envs.errors import InvalidOptionError, unknown_name

AgentFactory = Callable[[], Agent]

AGENTS: dict[str, str] = {
    "random": "baselines.random_agent:RandomAgent",
    "expert": "baselines.expert:ExpertAgent",
    "pc-mppi": "baselines.pc_mppi:make_pc_mppi",
    "ladder:oracle-points": "baselines.ladder:make_oracle_points",
    "ladder:transferred-points": "baselines.ladder:make_transferred_points",
}


def agent_factory(name: str) -> AgentFactory:
    """Import what makes the agent of that name.

    Args:
        name: a name of ``AGENTS``, or ``module:attr`` of a class or factory without arguments.

    Raises:
        InvalidOptionError: unknown name, broken import, or nothing that could make an agent.
    """
    module_name, colon, attribute = AGENTS.get(name, name).partition(":")
    if not (module_name and colon and attribute):
        raise InvalidOptionError(f"{unknown_name('agent', name, AGENTS)}; or module:attr of yours")
    factory = getattr(_import(name, module_name), attribute, None)
    if factory is None:
        known = [key for key in vars(_import(name, module_name)) if not key.startswith("_")]
        raise InvalidOptionError(f"agent {name!r}: {unknown_name('attribute', attribute, known)}")
    missing = [method for method in ("reset", "act") if not hasattr(factory, method)]
    if not callable(factory) or (inspect.isclass(factory) and missing):
        raise InvalidOptionError(
            f"agent {name!r} is {factory!r}: name a factory, or a class with reset(episode, seed) "
            "and act(observation)"
        )
    return factory


def make_agent(name: str) -> Agent:
    """Make a fresh agent.

    Raises:
        InvalidOptionError: as ``agent_factory``, or the factory made something else.
    """
    agent = agent_factory(name)()
    if not isinstance(agent, Agent):
        raise InvalidOptionError(
            f"agent {name!r} made {type(agent).__name__}: it must have reset(episode, seed) "
            "and act(observation)"
        )
    return agent


def check_env_id(env_id: str) -> None:
    """Make sure that ``gymnasium.make`` will know the environment.

    Raises:
        InvalidOptionError: it will not.
    """
    import gymnasium

    import icd_envs  # noqa: F401  registers our ids

    module, _, name = env_id.rpartition(":")
    try:
        if module:
            importlib.import_module(module)
        gymnasium.spec(name)
    except (gymnasium.error.Error, ImportError) as error:
        from icd_envs.registration import ENV_IDS

        raise InvalidOptionError(f"{unknown_name('env', env_id, ENV_IDS)} ({error})") from error


def _import(name: str, module_name: str) -> object:
    try:
        return importlib.import_module(module_name)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        if name in AGENTS:
            message = f"agent {name!r} is broken, importing {module_name} failed: {reason}"
        else:
            message = f"{unknown_name('agent', name, AGENTS)}; importing {module_name}: {reason}"
        raise InvalidOptionError(message) from error
