"""Agents that other installed packages offer under the entry-point group ``icd.agents``."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points
from typing import Final

GROUP: Final = "icd.agents"


@dataclass(frozen=True)
class Plugin:
    """One agent of another package.

    Attributes:
        name: what users call it.
        entry_point: where it is.
        problem: why it cannot be used, as far as can be told without importing it; or empty.
    """

    name: str
    entry_point: EntryPoint
    problem: str = ""

    @property
    def origin(self) -> str:
        """Name and version of the package, and where in it the agent is."""
        return f"{self.package}: {self.entry_point.value}"

    @property
    def package(self) -> str:
        """Name and version of the package."""
        dist = self.entry_point.dist
        return "unknown package" if dist is None else f"{dist.name} {dist.version}"


def find_plugins(taken: Collection[str]) -> list[Plugin]:
    """Every plug-in that is installed; nothing is imported.

    Args:
        taken: names that are not to be had.
    """
    found = [Plugin(entry.name, entry) for entry in entry_points(group=GROUP)]
    found.sort(key=lambda plugin: (plugin.name, plugin.origin))
    return [replace(plugin, problem=_problem(plugin, found, taken)) for plugin in found]


def _problem(plugin: Plugin, found: list[Plugin], taken: Collection[str]) -> str:
    if plugin.name in taken:
        return (
            f"{plugin.name!r} is an agent of icd-bench: {plugin.package} must choose another name"
        )
    same = " and ".join(other.origin for other in found if other.name == plugin.name)
    return f"the name is taken twice, by {same}: uninstall one" if same != plugin.origin else ""
