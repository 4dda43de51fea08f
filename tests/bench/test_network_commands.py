"""``icd-bench train``, ``diagnose`` and ``render``."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
import pytest
from PIL import Image

from benchmarks.registry import Offer, make_agent
from icd_agent.checkpoints import save_checkpoint
from icd_envs.errors import CheckpointError
from tests.agent.field.small import SMALL, small_field
from tests.bench.making import icd_bench
from tests.envs.making import CABLE

DIAGNOSED = {
    "occupancy_iou",
    "gradient_cosine",
    "yaw_invariance",
    "roll_sensitivity",
    "transfer_error",
    "kendall_tau",
    "bake_seconds",
    "interpolation_error",
    "step_distance",
    "progress_correlation",
    "scenes",
}


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("demonstrations") / "cable"
    collect = ("collect", "--env", CABLE, "--episodes", 2, "--steps", 5, "--out", out)
    assert icd_bench(*collect).exit_code == 0
    return out


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("field")
    save_checkpoint(folder, "field", small_field(), SMALL, {})
    return folder


@pytest.mark.parametrize("scope", ["local", "global"])
def test_field_is_trained_from_demonstrations_and_goes_on(
    data: Path, tmp_path: Path, scope: str
) -> None:
    train = ("train", "field", "--env", CABLE, "--data", data, "--steps", 3, "--scope", scope)
    trained = icd_bench(*train, "--out", tmp_path, "--json")
    assert trained.exit_code == 0, trained.stderr
    values = json.loads(trained.stdout)
    assert values["scenes"] == 2
    assert values["loss"] > 0
    assert "3/3 steps" in trained.stderr
    config = json.loads((tmp_path / "config.json").read_text())
    assert config["config"]["scope"] == scope
    assert config["about"]["data"]["env"] == CABLE
    before = (tmp_path / "model.safetensors").read_bytes()
    assert icd_bench(*train, "--out", tmp_path).exit_code == 0
    assert (tmp_path / "model.safetensors").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--env", "ICDNotebookFolding-v0"), "holds demonstrations of ICDCableRouting-v0"),
        (("--env", CABLE, "--device", "cuda:99"), "device='cuda:99' cannot be used"),
    ],
)
def test_training_refuses_in_one_line(
    data: Path, tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    out = tmp_path / "out"
    refused = icd_bench("train", "field", *arguments, "--data", data, "--out", out)
    assert refused.exit_code == 2
    assert message in refused.stderr
    assert not out.exists()


def test_diagnosis_has_every_value_of_its_promise(weights: Path) -> None:
    command = ("diagnose", "field", "--env", CABLE, "--scenes", 1, "--weights", weights)
    found = icd_bench(*command, "--json")
    assert found.exit_code == 0, found.stderr
    values = json.loads(found.stdout)
    assert values.keys() == DIAGNOSED
    # Laws of the network, which hold for any weights.
    assert values["yaw_invariance"] < 1e-3
    assert values["roll_sensitivity"] > 0.05
    assert 0 <= values["transfer_error"] < 0.3  # the goal is of the same scene
    assert 0 <= values["occupancy_iou"] <= 1
    assert -1 <= values["gradient_cosine"] <= 1


def test_picture_is_drawn(weights: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "field.png"
    drawn = icd_bench("render", "field", "--env", CABLE, "--weights", weights, "--out", out)
    assert drawn.exit_code == 0, drawn.stderr
    with Image.open(out) as picture:
        assert picture.width > 1000
        assert len(set(picture.convert("RGB").resize((64, 64)).getdata())) > 100


def test_episode_is_drawn_from_its_beginning_to_its_end(tmp_path: Path) -> None:
    out = tmp_path / "episode.png"
    command = ("render", "episode", "--agent", "expert", "--env", CABLE, "--seed", 3)
    drawn = icd_bench(*command, "--out", out)
    assert drawn.exit_code == 0, drawn.stderr
    with Image.open(out) as picture:
        left, right = (np.asarray(picture.crop(box).convert("L")) for box in _halves(picture))
    assert min(left.std(), right.std()) > 10  # pictures of the scene, not blanks
    assert np.abs(left.astype(int) - right).mean() > 1


def test_episode_is_filmed(tmp_path: Path) -> None:
    out = tmp_path / "new" / "episode.gif"
    command = ("render", "episode", "--agent", "random", "--env", "ICDNotebookFolding-v0")
    drawn = icd_bench(*command, "--option", "max_episode_steps=30", "--out", out)
    assert drawn.exit_code == 0, drawn.stderr
    with Image.open(out) as film:
        assert film.n_frames == 16  # type: ignore[attr-defined]  every other state of 31
        assert film.size == (320, 240)
        frames = []
        for index in (0, 15):
            film.seek(index)
            frames.append(np.asarray(film.convert("L")).astype(int))
    assert np.abs(frames[0] - frames[1]).mean() > 0.1


def test_episode_is_drawn_with_options_of_the_task(tmp_path: Path) -> None:
    command = (
        "render",
        "episode",
        "--agent",
        "random",
        "--env",
        CABLE,
        "--out",
        tmp_path / "e.png",
    )
    drawn = [icd_bench(*command, "--option", f"num_fixtures={count}") for count in (1, 9)]
    assert drawn[0].exit_code == 0, drawn[0].stderr
    assert drawn[1].exit_code == 2
    assert "num_fixtures" in drawn[1].stderr


def test_agent_of_the_user_that_raises_is_named_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "toy_that_raises.py").write_text(
        "class Agent:\n"
        "    def reset(self, episode, seed): raise ValueError('boom')\n"
        "    def act(self, observation): pass\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    command = ("render", "episode", "--env", CABLE, "--out", tmp_path / "e.png")
    drawn = icd_bench(*command, "--agent", "toy_that_raises:Agent")
    assert (drawn.exit_code, drawn.stdout) == (2, "")
    assert "'toy_that_raises:Agent': ValueError: boom (toy_that_raises.py:2)" in drawn.stderr
    assert len(drawn.stderr.strip().splitlines()) == 1
    assert "--trust-pickle" in icd_bench(*command, "--agent", "sb3:model.zip").stderr
    trusted = icd_bench(*command, "--agent", "sb3:model.zip", "--trust-pickle")
    assert "no model of Stable-Baselines3" in trusted.stderr


def _halves(picture: Image.Image) -> tuple[tuple[int, int, int, int], ...]:
    """Boxes of the first picture of the upper row and the last one of the lower."""
    width, height = picture.size
    return (0, 40, width // 4, height // 2), (width * 3 // 4, 40 + height // 2, width, height)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("diagnose", "field", "--env", "ICDCable"), "did you mean"),
        (("render", "chain", "--env", "ICDCable", "--out", "chain.png"), "did you mean"),
        (("render", "chain", "--env", CABLE, "--out", "chain.jpg"), "ends in .png"),
        (("render", "episode", "--agent", "icd", "--env", CABLE, "--out", "e.mp4"), "or .gif"),
        (("render", "episode", "--agent", "icdd", "--env", CABLE, "--out", "e.png"), "agent"),
        (("render", "field", "--env", CABLE, "--out", "field.jpg"), "ends in .png"),
        (("diagnose", "field", "--env", CABLE, "--weights", "nowhere"), "cannot read nowhere"),
    ],
)
def test_usage_errors_exit_2_in_one_line(arguments: tuple[str, ...], message: str) -> None:
    refused = icd_bench(*arguments)
    assert refused.exit_code == 2
    assert message in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1


class Trained(NamedTuple):
    latent: Path
    diffusion: Path
    printed: dict[str, dict[str, float]]


@pytest.fixture(scope="module")
def trained(data: Path, weights: Path, tmp_path_factory: pytest.TempPathFactory) -> Trained:
    """Two steps of each, on descriptors of the small field."""
    out = tmp_path_factory.mktemp("trained")
    common = ("--env", CABLE, "--data", data, "--field", weights, "--steps", 2, "--json")
    latent = icd_bench("train", "latent", *common, "--out", out / "latent")
    assert latent.exit_code == 0, latent.stderr
    given = ("--latent", out / "latent", "--out", out / "diffusion")
    diffusion = icd_bench("train", "diffusion", *common, *given)
    assert diffusion.exit_code == 0, diffusion.stderr
    printed = {"latent": json.loads(latent.stdout), "diffusion": json.loads(diffusion.stdout)}
    return Trained(out / "latent", out / "diffusion", printed)


@pytest.mark.parametrize(
    ("command", "network"),
    [
        (("train", "diffusion", "--data", "d", "--out", "o"), "--latent"),
        (("train", "bank", "--data", "d", "--out", "o"), "--latent"),
        (("diagnose", "latent"), "--weights"),
        (("diagnose", "diffusion"), "--latent"),
        (("diagnose", "diffusion"), "--weights"),
    ],
)
def test_networks_of_another_field_are_refused(
    trained: Trained, command: tuple[str, ...], network: str
) -> None:
    of_chains = command[1] == "diffusion" and network == "--weights"
    folder = trained.diffusion if of_chains else trained.latent
    refused = icd_bench(*command, "--env", CABLE, network, folder)  # the package's field
    assert refused.exit_code == 2
    assert "was trained with the field" in refused.stderr


def test_latents_and_chains_are_trained_on_one_another(data: Path, trained: Trained) -> None:
    assert trained.printed["latent"]["recon"] > 0
    assert trained.printed["diffusion"]["loss"] > 0
    about = json.loads((trained.diffusion / "config.json").read_text())["about"]["data"]
    latent = json.loads((trained.latent / "config.json").read_text())
    assert about["latent"] == latent["sha256"]
    assert about["field"] == latent["about"]["data"]["field"]
    # Descriptors are computed once, for both.
    kept = [path for path in data.parent.iterdir() if path.name.startswith(f"{data.name}-2-")]
    assert len(kept) == 1
    assert json.loads((kept[0] / "states.json").read_text())["done"] == 2


def test_data_may_be_the_working_directory_and_the_decoder_wider(
    data: Path, weights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(data)
    command = ("train", "latent", "--env", CABLE, "--data", ".", "--field", weights)
    trained = icd_bench(*command, "--steps", 2, "--decoder-width", 24, "--out", tmp_path)
    assert trained.exit_code == 0, trained.stderr
    assert json.loads((tmp_path / "config.json").read_text())["config"]["decoder_width"] == 24


def test_chains_of_contacts_alone_are_trained_and_followed_with_the_papers_settings(
    data: Path, weights: Path, trained: Trained, tmp_path: Path
) -> None:
    shutil.copytree(weights, tmp_path / "field")
    shutil.copytree(trained.latent, tmp_path / "latent")
    command = ("train", "diffusion", "--env", CABLE, "--data", data, "--field", weights)
    given = ("--latent", trained.latent, "--places", 0, "--steps", 2)
    done = icd_bench(*command, *given, "--out", tmp_path / "diffusion")
    assert done.exit_code == 0, done.stderr
    with pytest.raises(CheckpointError, match=r"places=0 and generates none: use preset 'paper'"):
        make_agent(f"icd@{tmp_path}", Offer(CABLE))
    agent = make_agent(f"icd-paper@{tmp_path}", Offer(CABLE))
    env: Any = gym.make(CABLE).unwrapped
    observation, _ = env.reset(seed=0)
    agent.reset(env.episode(simulator=True), 0)
    assert np.abs(agent.act(observation)).max() <= 1
    assert agent.plan_info.subgoals is None  # type: ignore[attr-defined]  there are no places
    env.close()


def test_latents_are_diagnosed_on_unseen_states(weights: Path, trained: Trained) -> None:
    command = ("diagnose", "latent", "--env", CABLE, "--scenes", 2, "--field", weights)
    found = icd_bench(*command, "--weights", trained.latent, "--json")
    assert found.exit_code == 0, found.stderr
    values = json.loads(found.stdout)
    assert values["scenes"] == 2
    assert values["states"] > 20
    assert values["reconstruction_error"] > 0.1  # two steps teach nothing
    assert values["bins_off"] > 0
    assert -1 <= values["rank_correlation"] <= 1
    assert "rank_correlation_solved" in values


def test_chains_are_diagnosed_in_unseen_scenes(weights: Path, trained: Trained) -> None:
    command = ("diagnose", "diffusion", "--env", CABLE, "--scenes", 2, "--field", weights)
    given = ("--latent", trained.latent, "--weights", trained.diffusion)
    found = icd_bench(*command, *given, "--json")
    assert found.exit_code == 0, found.stderr
    values = json.loads(found.stdout)
    assert values["chain_mse"] > 0
    assert values["line_mse"] > 0
    assert values["goal_distance"] > 0
    assert 0 < values["off_possible_real"] < values["off_possible"]  # two steps teach nothing
    assert values["off_possible_line"] > 0
    assert -1 <= values["order"] <= 1


def test_a_chain_is_drawn_beside_the_experts(
    weights: Path, trained: Trained, tmp_path: Path
) -> None:
    folder, out = tmp_path / "weights", tmp_path / "chain.png"
    parts = {"field": weights, "latent": trained.latent, "diffusion": trained.diffusion}
    for name, part in parts.items():
        shutil.copytree(part, folder / name)
    drawn = icd_bench("render", "chain", "--env", CABLE, "--weights", folder, "--out", out)
    assert drawn.exit_code == 0, drawn.stderr
    with Image.open(out) as picture:
        assert picture.width > 1000
        assert len(set(picture.convert("RGB").resize((64, 64)).getdata())) > 100


def test_a_bank_needs_episodes_that_solve_their_task(
    data: Path, weights: Path, trained: Trained, tmp_path: Path
) -> None:
    command = ("train", "bank", "--env", CABLE, "--data", data, "--field", weights)
    refused = icd_bench(*command, "--latent", trained.latent, "--out", tmp_path / "bank")
    assert refused.exit_code == 2
    assert "no episode that solved its task" in refused.stderr
    assert not (tmp_path / "bank").exists()
