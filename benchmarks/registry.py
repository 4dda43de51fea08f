"""Agents and environments by name; nothing is imported before it is asked for."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

from benchmarks.adapters import FunctionAgent
from benchmarks.imports import is_there, load, load_module
from benchmarks.plugins import Plugin, find_plugins
from benchmarks.provenance import (
    WEIGHT_FILES,
    package_versions,
    source_of_file,
    source_of_folder,
    source_of_module,
)
from icd_envs.api import Agent
from icd_envs.errors import InvalidOptionError, unknown_name

AgentFactory = Callable[..., Agent]

AGENTS: dict[str, str] = {
    "random": "baselines.random_agent:RandomAgent",
    "expert": "baselines.expert:ExpertAgent",
    "pc-mppi": "baselines.pc_mppi:make_pc_mppi",
    "pc-mppi-improved": "baselines.pc_mppi:make_pc_mppi_improved",
    "icd": "baselines.icd:make_icd",
    "icd-local": "baselines.icd:make_icd_local",
    "icd-paper": "baselines.icd:make_icd_paper",
    "ndf-mppi": "baselines.ndf_mppi:make_ndf_mppi",
    "ndf-mppi-improved": "baselines.ndf_mppi:make_ndf_mppi_improved",
    "global-ndf": "baselines.global_ndf:make_global_ndf",
    "global-ndf-paper": "baselines.global_ndf:make_global_ndf_paper",
    "subgoal-diffuser": "baselines.subgoal_diffuser:make_subgoal_diffuser",
    "subgoal-diffuser-paper": "baselines.subgoal_diffuser:make_subgoal_diffuser_paper",
    "diffusion-policy": "baselines.diffusion_policy:make_diffusion_policy",
    "dp3": "baselines.dp3:make_dp3",
    "sac-her": "baselines.sac_her:make_sac_her",
    "ladder:oracle-points": "baselines.ladder:make_oracle_points",
    "ladder:oracle-descriptors": "baselines.ladder:make_oracle_descriptors",
    "ladder:vae": "baselines.ladder:make_vae",
    "ladder:retrieved-chain": "baselines.ladder:make_retrieved_chain",
    "ladder:replaced-goal": "baselines.replaced_goal:make_replaced_goal",
    "ladder:places": "baselines.field_parts:make_places",
    "ladder:no-places": "baselines.field_parts:make_no_places",
    "ladder:near-field": "baselines.field_parts:make_near_field",
    "ladder:far-field": "baselines.field_parts:make_far_field",
    "ladder:near-field-cut": "baselines.field_parts:make_near_field_cut",
    "ladder:far-field-cut": "baselines.field_parts:make_far_field_cut",
    "ladder:transferred-points": "baselines.ladder:make_transferred_points",
    "ladder:transferred-descriptors": "baselines.ladder:make_transferred_descriptors",
    "ladder:transferred-global": "baselines.ladder:make_transferred_global",
}
FORMS: Final[dict[str, str]] = {
    "name@folder": "an agent of the above with the weights in a folder, as training leaves them",
    "module:attr": "a class or factory",
    "file.py:attr": "the same in a file",
    "fn:module:attr": "a function observation -> action, of a module or file",
    "sb3:path.zip": "a model saved by Stable-Baselines3, with --trust-pickle",
}
"""How an agent from elsewhere is named."""


_NAMED: Final = (
    inspect.Parameter.POSITIONAL_ONLY,
    inspect.Parameter.POSITIONAL_OR_KEYWORD,
    inspect.Parameter.KEYWORD_ONLY,
)


@dataclass(frozen=True)
class Offer:
    """What a factory gets if it declares it.

    Attributes:
        env_id: environment the agent will act in.
        device: of PyTorch, for those who use it.
        trust_pickle: whether files may be unpickled; never handed out.
    """

    env_id: str
    device: str = "cpu"
    trust_pickle: bool = False


def make_agent(name: str, offer: Offer) -> Agent:
    """Make a fresh agent.

    Args:
        name: one of ``AGENTS``, of a plug-in, or of the ``FORMS``.
        offer: what its factory may ask for.

    Raises:
        InvalidOptionError: as ``agent_factory``, or the factory made something else.
    """
    factory = agent_factory(name, trust_pickle=offer.trust_pickle)
    known = {"env_id": offer.env_id, "device": offer.device}
    agent = factory(**{key: value for key, value in known.items() if key in asked(factory)})
    if not isinstance(agent, Agent):
        raise InvalidOptionError(
            f"agent {name!r} made {type(agent).__name__}: it must have reset(episode, seed) "
            "and act(observation)"
        )
    return agent


def agent_factory(name: str, *, trust_pickle: bool = False) -> AgentFactory:
    """Import what makes the agent of that name.

    Args:
        name: one of ``AGENTS``, of a plug-in, or of the ``FORMS``.
        trust_pickle: whether files may be unpickled.

    Raises:
        InvalidOptionError: unknown name, broken import, or nothing that could make an agent.
    """
    form, _, rest = name.partition(":")
    try:
        if name in AGENTS:
            return _checked(load(AGENTS[name]))
        if plugin := _plugin(name):
            return _checked(load(plugin.entry_point.value))
        if folder := _own_weights(name):
            return _with_weights(name.partition("@")[0], folder)
        if form == "fn":
            return _function_agent(load(rest))
        if form == "sb3":
            return _sb3_agent(Path(rest), trust_pickle=trust_pickle)
        if not (form and rest) or not is_there(name):
            raise InvalidOptionError(_unknown(name))
        return _checked(load(name))
    except InvalidOptionError as error:
        raise InvalidOptionError(f"agent {name!r}: {error}") from error


def origin(name: str) -> str:
    """Where an agent from elsewhere comes from: package, version, and a hash of its files.

    Args:
        name: as for ``agent_factory``, which must have accepted it.
    """
    form, _, rest = name.partition(":")
    if folder := _own_weights(name):
        return source_of_folder(folder, WEIGHT_FILES)
    if form == "sb3":
        versions = package_versions(("stable-baselines3", "torch"))
        return ", ".join([source_of_file(Path(rest)), *map(" ".join, versions.items())])
    plugin = _plugin(name)
    if plugin:
        return _source(plugin.entry_point.value, plugin.package)
    return _source(rest if form == "fn" else name)


def _own_weights(name: str) -> Path | None:
    """The folder in ``name@folder``, if the name is one of ours."""
    ours, _, folder = name.partition("@")
    return Path(folder) if ours in AGENTS and folder else None


def _with_weights(ours: str, folder: Path) -> AgentFactory:
    factory = _checked(load(AGENTS[ours]))
    if "weights" not in inspect.signature(factory).parameters:
        raise InvalidOptionError(f"{ours!r} has no weights: leave out @{folder}")
    if not folder.is_dir():
        raise InvalidOptionError(f"{folder} is no folder: name what icd-bench train has written")
    return partial(factory, weights=folder)


def _source(target: str, distribution: str = "") -> str:
    return source_of_module(load_module(target.rpartition(":")[0]), distribution)


def _unknown(name: str) -> str:
    known = [*AGENTS, *(plugin.name for plugin in find_plugins(AGENTS))]
    hint = f"no module or file of that name is there either ({', '.join(FORMS)})"
    return f"{unknown_name('agent', name, known)}; {hint}"


def _plugin(name: str) -> Plugin | None:
    for plugin in find_plugins(AGENTS):
        if plugin.name == name:
            if plugin.problem:
                raise InvalidOptionError(plugin.problem)
            return plugin
    return None


def _checked(factory: object) -> AgentFactory:
    missing = [method for method in ("reset", "act") if not hasattr(factory, method)]
    if not callable(factory) or (inspect.isclass(factory) and missing):
        raise InvalidOptionError(
            f"{factory!r} is no agent: name a factory, or a class with reset(episode, seed) and "
            "act(observation)"
        )
    if inspect.isclass(factory):
        _check_call(factory.reset, "reset(episode, seed)", 3)
        _check_call(factory.act, "act(observation)", 2)
    asked(factory)
    return factory


def _check_call(function: Callable[..., object], call: str, arguments: int) -> None:
    try:
        inspect.signature(function).bind(*range(arguments))
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(f"it cannot be called as {call}: {error}") from error


def asked(factory: AgentFactory) -> list[str]:
    """Which of ``env_id`` and ``device`` a factory takes.

    Raises:
        InvalidOptionError: it wants something else as well.
    """
    found = []
    try:
        parameters = inspect.signature(factory).parameters
    except (TypeError, ValueError) as error:
        raise InvalidOptionError(
            f"what its factory takes cannot be read ({error}): name a function or class"
        ) from error
    for name, parameter in parameters.items():
        if name in ("env_id", "device"):
            found.append(name)
        elif parameter.default is parameter.empty and parameter.kind in _NAMED:
            raise InvalidOptionError(
                f"its factory wants {name!r}, but gets only env_id and device: give it a default"
            )
    return found


def _function_agent(function: object) -> AgentFactory:
    if not callable(function):
        raise InvalidOptionError(f"{function!r} is no function observation -> action")
    _check_call(function, "function(observation)", 1)
    return partial(FunctionAgent, function)


def _sb3_agent(path: Path, *, trust_pickle: bool) -> AgentFactory:
    if not trust_pickle:
        raise InvalidOptionError(
            f"loading {path} unpickles it, which runs whatever code is in the file: if you trust "
            "whoever made it, say so with --trust-pickle"
        )
    if importlib.util.find_spec("stable_baselines3") is None:
        raise InvalidOptionError("it needs pip install 'implicit-contact-diffuser[rl]'")
    from benchmarks.sb3_agent import SB3Agent

    return partial(SB3Agent, path)
