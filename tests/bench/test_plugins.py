"""Plug-ins as they are found, before anything is imported."""

import sys
from pathlib import Path

import pytest

from benchmarks import registry
from benchmarks.plugins import find_plugins
from benchmarks.registry import Offer
from icd_envs.errors import InvalidOptionError
from tests.bench import toy
from tests.bench.packages import install


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of packages."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    return tmp_path


def test_plugins_are_found_without_importing_them(site: Path) -> None:
    install(site, "toy_a", "raise RuntimeError", first="toy_a:First", second="toy_a:Second")
    found = {plugin.name: plugin for plugin in find_plugins(())}
    assert found["first"].origin == "toy_a 1.0: toy_a:First"
    assert (found["second"].problem, "toy_a" in sys.modules) == ("", False)


def test_plugin_is_an_agent_like_ours(site: Path) -> None:
    install(site, "toy_b", "from tests.bench.toy import Straight", b="toy_b:Straight")
    assert isinstance(registry.make_agent("b", Offer("E-v0")), toy.Straight)
    assert registry.origin("b").startswith("toy_b 1.0, toy_b.py sha256:")


def test_broken_plugin_disturbs_nobody_until_it_is_asked_for(site: Path) -> None:
    install(site, "toy_c", "import nothing_of_that_name", broken="toy_c:Agent")
    install(site, "toy_d", "from tests.bench.toy import Straight", d="toy_d:Straight")
    assert isinstance(registry.make_agent("d", Offer("E-v0")), toy.Straight)
    with pytest.raises(InvalidOptionError, match=r"'broken'.*nothing_of_that_name"):
        registry.agent_factory("broken")
    with pytest.raises(InvalidOptionError, match="did you mean 'broken'"):
        registry.agent_factory("brocken")


def test_name_that_is_taken_twice_names_both(site: Path) -> None:
    install(site, "toy_e", "from tests.bench.toy import Straight", same="toy_e:Straight")
    install(site, "toy_f", "from tests.bench.toy import Straight", same="toy_f:Straight")
    with pytest.raises(InvalidOptionError, match=r"toy_e 1.0: .* and toy_f 1.0: .*uninstall one"):
        registry.agent_factory("same")
    assert registry.agent_factory("toy_f:Straight") is toy.Straight


def test_our_names_stay_ours(site: Path) -> None:
    install(site, "toy_g", "from tests.bench.toy import Straight", random="toy_g:Straight")
    (plugin,) = (p for p in find_plugins(registry.AGENTS) if p.name == "random")
    assert "toy_g 1.0 must choose another name" in plugin.problem
    assert registry.agent_factory("random") is not toy.Straight
