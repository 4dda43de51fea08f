"""What there is to run: agents, environments, suites, gates."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.examination import examine
from benchmarks.executors import Local
from benchmarks.gates import GATES
from benchmarks.plugins import find_plugins
from benchmarks.registry import AGENTS, FORMS
from benchmarks.suites import SUITES
from icd_envs.registration import ENV_IDS


class Entry(NamedTuple):
    """One line.

    Attributes:
        kind: agent, env, suite or gates.
        name: what the options of ``icd-bench`` take.
        what: a few words on it.
    """

    kind: str
    name: str
    what: str


def entries() -> Iterator[Entry]:
    """Everything; plug-ins are imported, in processes of their own, to see whether they work."""
    yield from (Entry("agent", name, spec) for name, spec in AGENTS.items())
    yield from _plugins()
    yield from (Entry("agent", form, f"yours: {what}") for form, what in FORMS.items())
    yield from (Entry("env", env_id, "") for env_id in ENV_IDS)
    for suite in SUITES.values():
        yield Entry("suite", suite.name, f"v{suite.version}: {suite.description}")
    for env_id, gates in GATES.items():
        yield Entry("gates", env_id, ", ".join(gate.name for gate in gates))


def _plugins() -> Iterator[Entry]:
    plugins = find_plugins(AGENTS)
    sound = [plugin.name for plugin in plugins if not plugin.problem]
    problems = {examined.name: examined.problem for examined in examine(sound, Local(2))}
    for plugin in plugins:
        problem = plugin.problem or problems[plugin.name]
        state = f"BROKEN: {problem}" if problem else "works"
        yield Entry("agent", plugin.name, f"plug-in of {plugin.origin}; {state}")
