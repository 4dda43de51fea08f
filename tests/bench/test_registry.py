"""Names of agents and environments."""

import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from baselines.sac_her import ActorAgent, load_actor
from benchmarks import registry
from benchmarks.registry import Offer
from icd_agent.weights import SAC_HER, shipped_folder
from icd_envs.errors import CheckpointError, InvalidOptionError
from icd_envs.registration import check_env_id
from tests.bench import toy

OFFER = Offer("E-v0", device="cuda:1")


def made(name: str) -> object:
    return registry.make_agent(name, OFFER)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where Python looks for modules as well."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr(sys, "modules", dict(sys.modules))
    return tmp_path


def test_module_attr_finds_class_and_factory() -> None:
    assert isinstance(made(toy.spec(toy.Straight)), toy.Straight)
    assert isinstance(made(toy.spec("make_straight")), toy.Straight)


def test_file_attr_finds_them_in_a_file_beside_its_own_helpers(folder: Path) -> None:
    (folder / "späce d").mkdir()
    (folder / "späce d" / "helper_of_agent.py").write_text("from tests.bench.toy import Drunk")
    file = folder / "späce d" / "my agent.py"
    file.write_text("from helper_of_agent import Drunk\nclass Nested:\n    Agent = Drunk")
    assert isinstance(made(f"{file}:Drunk"), toy.Drunk)
    assert isinstance(made(f"{file}:Nested.Agent"), toy.Drunk)
    with pytest.raises(InvalidOptionError, match="unknown agent"):
        made(f"{folder / 'nothing.py'}:Drunk")


def test_an_agent_of_ours_takes_the_weights_of_a_folder(tmp_path: Path) -> None:
    shipped = shipped_folder("ICDCableRouting-v0", SAC_HER)
    mine = tmp_path / "runs" / "sac@home"
    shutil.copytree(shipped, mine)
    name = f"sac-her@{mine}"
    agent = made(name)
    assert isinstance(agent, ActorAgent)
    kept = agent.actor.mean.weight.detach().numpy()
    np.testing.assert_array_equal(kept, load_actor(shipped).mean.weight.detach().numpy())
    before = registry.origin(name)
    assert before.startswith("sac@home sha256:")
    (mine / "training.jsonl").write_text("of no consequence")
    assert registry.origin(name) == before
    (mine / "config.json").write_text("{}")
    assert registry.origin(name) != before
    with pytest.raises(CheckpointError, match=r"config\.json"):
        made(name)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("sac-her@nowhere", "nowhere is no folder: name what icd-bench train has written"),
        ("pc-mppi@runs", "'pc-mppi' has no weights: leave out @runs"),
        ("nobody@runs", "unknown agent 'nobody@runs'"),
        ("sac-her@", "unknown agent 'sac-her@'"),
    ],
)
def test_weights_that_cannot_be_used_are_named(name: str, problem: str) -> None:
    with pytest.raises(InvalidOptionError, match=re.escape(problem)):
        made(name)


def test_function_becomes_an_agent(folder: Path) -> None:
    (folder / "toy_policy.py").write_text("def policy(observation): return observation * 2")
    for name in ("fn:toy_policy:policy", f"fn:{folder / 'toy_policy.py'}:policy"):
        agent = made(name)
        agent.reset(None, 0)
        assert agent.act(21) == 42


def test_factory_gets_what_it_declares_of_the_offer(folder: Path) -> None:
    (folder / "toy_factories.py").write_text("""
from tests.bench.toy import Straight
class Asks(Straight):
    def __init__(self, *more, device, env_id="none", other=3, **rest):
        self.got = (env_id, device, other, more, rest)
def both(device, env_id):
    return Asks(device=device, env_id=env_id, other=0)
""")
    assert made("toy_factories:Asks").got == ("E-v0", "cuda:1", 3, (), {})
    assert made("toy_factories:both").got == ("E-v0", "cuda:1", 0, (), {})


def test_built_in_names_are_looked_up_in_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.AGENTS, "ladder:toy", toy.spec(toy.Straight))
    assert isinstance(made("ladder:toy"), toy.Straight)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pc-mpi", "did you mean 'pc-mppi'"),
        ("ladder:oracle-point", "did you mean 'ladder:oracle-points'"),
        ("tests.bench.toy:Strait", "did you mean 'Straight'"),
        ("tests.bench.toy:Unready", "act"),
        ("tests.bench.toy:MAX_STEPS", "name a factory"),
        ("tests.bench.toy:MAX_STEPS.x", "unknown attribute 'x'"),
        ("__main__:Agent", "agent '__main__:Agent'"),
        ("builtins:max", "cannot be read"),
        ("fn:builtins:max", "function"),
        ("", "valid: 'diffusion-policy', 'dp3', 'expert'"),
        (":", "valid: 'diffusion-policy', 'dp3', 'expert'"),
    ],
)
def test_wrong_name_is_explained(name: str, message: str) -> None:
    with pytest.raises(InvalidOptionError, match=message):
        registry.agent_factory(name)


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("import no_such_module_anywhere", "no_such_module_anywhere"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("def Agent(what): pass", "its factory wants 'what'"),
        ("class Agent:\n reset = act = lambda self: 0", r"called as reset\(episode, seed\)"),
        ("class Agent:\n def reset(s, e, d): 0\n def act(s): 0", r"called as act\(observation\)"),
    ],
)
def test_broken_agent_is_explained(folder: Path, code: str, reason: str) -> None:
    (folder / "broken_toy_agent.py").write_text(code)
    with pytest.raises(InvalidOptionError, match=f"broken_toy_agent:Agent.*{reason}"):
        registry.agent_factory("broken_toy_agent:Agent")


@pytest.mark.parametrize("code", ["policy = 3", "def policy(): pass", "def policy(a, b): pass"])
def test_function_of_another_kind_is_explained(folder: Path, code: str) -> None:
    (folder / "broken_toy_policy.py").write_text(code)
    with pytest.raises(InvalidOptionError, match="function"):
        registry.agent_factory("fn:broken_toy_policy:policy")


def test_origin_changes_with_the_files(folder: Path) -> None:
    file = folder / "toy_origin.py"
    file.write_text("from tests.bench.toy import Straight")
    first = registry.origin("toy_origin:Straight")
    assert first.startswith("toy_origin.py sha256:")
    assert registry.origin(f"{file}:Straight") == first
    file.write_text("from tests.bench.toy import Straight  # changed")
    assert registry.origin("toy_origin:Straight") != first
    assert registry.origin(toy.spec(toy.Straight)).startswith("tests sha256:")


def test_origin_changes_with_what_lies_beside_the_file(folder: Path) -> None:
    helper = folder / "toy_gain.py"
    helper.write_text("GAIN = 1.0")
    (folder / "toy_with_gain.py").write_text(
        "import toy_gain\nfrom tests.bench.toy import Straight"
    )
    registry.agent_factory("toy_with_gain:Straight")
    first = registry.origin("toy_with_gain:Straight")
    (folder / "toy_unrelated.py").write_text("1 / 0")
    assert registry.origin("toy_with_gain:Straight") == first
    helper.write_text("GAIN = -1.0")
    assert registry.origin("toy_with_gain:Straight") != first


def test_pickles_are_refused_without_trust(tmp_path: Path) -> None:
    with pytest.raises(InvalidOptionError, match="--trust-pickle"):
        registry.agent_factory(f"sb3:{tmp_path / 'missing.zip'}")


def test_factory_that_makes_no_agent_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(toy, "make_straight", lambda: toy.Unready())
    with pytest.raises(InvalidOptionError, match="made Unready"):
        made(toy.spec("make_straight"))


def test_env_id_is_checked_before_the_first_episode() -> None:
    check_env_id(toy.ENV)
    with pytest.raises(InvalidOptionError, match="did you mean 'ICDCableRouting-v0'"):
        check_env_id("ICDCableRoutin-v0")


@pytest.mark.parametrize("code", ["raise RuntimeError('no')", "class", "raise SystemExit(3)"])
def test_env_whose_module_is_broken_is_explained(folder: Path, code: str) -> None:
    (folder / "broken_toy_env.py").write_text(code)
    with pytest.raises(InvalidOptionError, match=r"(Error|SystemExit): "):
        check_env_id("broken_toy_env:Foo-v0")
