"""``icd-bench train`` for the learned baselines: from demonstrations to agents that act."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from baselines.diffusion_policy import make_diffusion_policy
from baselines.dp3 import make_dp3
from baselines.global_ndf import make_global_ndf
from baselines.subgoal_diffuser import compose
from icd_agent.checkpoints import read_about, trained_for
from icd_agent.field.train import KIND as FIELD
from icd_agent.field.train import load_field
from icd_agent.policy.agent import ChunkAgent
from icd_envs.errors import CheckpointError
from tests.bench.making import icd_bench
from tests.envs.making import CABLE

MOST_BYTES = 8_000_000


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("demonstrations") / "cable"
    collect = ("collect", "--env", CABLE, "--episodes", 2, "--steps", 5, "--out", out)
    assert icd_bench(*collect).exit_code == 0
    return out


def size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("model.safetensors"))


def acts(agent: Any, *, simulator: bool) -> None:  # noqa: ANN401  any agent
    env = gym.make(CABLE)
    observation, _ = env.reset(seed=0)
    unwrapped: Any = env.unwrapped
    agent.reset(unwrapped.episode(simulator=simulator), seed=0)
    assert np.abs(agent.act(observation)).max() <= 1
    env.close()


@pytest.mark.parametrize("name", ["diffusion-policy", "dp3"])
def test_a_policy_is_trained_and_goes_on(data: Path, tmp_path: Path, name: str) -> None:
    # Five steps solve nothing, so that by default nothing is left to imitate.
    train = ("train", name, "--env", CABLE, "--data", data, "--out", tmp_path, "--json")
    refused = icd_bench(*train, "--steps", 2)
    assert refused.exit_code == 2
    assert "solved its task" in refused.stderr
    assert "--all-episodes" in refused.stderr
    train = (*train, "--all-episodes")
    first = icd_bench(*train, "--steps", 2)
    assert first.exit_code == 0, first.stderr
    values = json.loads(first.stdout)
    assert values["episodes"] == 2
    assert values["loss"] > 0
    before = (tmp_path / "model.safetensors").read_bytes()
    assert icd_bench(*train, "--steps", 2).exit_code == 0
    assert (tmp_path / "model.safetensors").read_bytes() == before
    about = json.loads((tmp_path / "config.json").read_text())["about"]
    assert about["data"]["solved_only"] is False
    assert ("field" in about["data"]) == (name == "diffusion-policy")
    assert size(tmp_path) < MOST_BYTES
    saved = tmp_path / "saved"
    ChunkAgent.from_pretrained(tmp_path).save_pretrained(saved)
    assert trained_for(read_about(saved / "policy")) == CABLE
    make = {"diffusion-policy": make_diffusion_policy, "dp3": make_dp3}[name]
    for folder in (tmp_path, saved):
        acts(ChunkAgent.from_pretrained(folder), simulator=False)
        acts(make(CABLE, folder), simulator=False)
        with pytest.raises(CheckpointError, match="its own task"):
            make("ICDNotebookFolding-v0", folder)


def test_subgoal_diffuser_is_trained_and_goes_on(data: Path, tmp_path: Path) -> None:
    steps = ("--latent-steps", 2, "--steps", 2)
    train = ("train", "subgoal-diffuser", "--env", CABLE, "--data", data, "--out", tmp_path, *steps)
    first = icd_bench(*train, "--json")
    assert first.exit_code == 0, first.stderr
    values = json.loads(first.stdout)
    assert values["latent_recon"] > 0
    assert values["loss"] > 0
    assert values["places"] == 0
    parts = [tmp_path / part / "model.safetensors" for part in ("latent", "diffusion")]
    before = [part.read_bytes() for part in parts]
    assert icd_bench(*train).exit_code == 0
    assert [part.read_bytes() for part in parts] == before
    assert size(tmp_path) < MOST_BYTES
    acts(compose(CABLE, tmp_path, "improved"), simulator=True)


def test_global_ndf_is_trained_and_goes_on(data: Path, tmp_path: Path) -> None:
    steps = ("--field-steps", 2, "--latent-steps", 2, "--steps", 2)
    train = ("train", "global-ndf", "--env", CABLE, "--data", data, "--out", tmp_path, *steps)
    first = icd_bench(*train, "--json")
    assert first.exit_code == 0, first.stderr
    values = json.loads(first.stdout)
    assert min(values[name] for name in ("field_loss", "latent_recon", "loss")) > 0
    parts = [tmp_path / part / "model.safetensors" for part in ("field", "latent", "diffusion")]
    before = [part.read_bytes() for part in parts]
    assert icd_bench(*train).exit_code == 0
    assert [part.read_bytes() for part in parts] == before
    assert load_field(tmp_path / FIELD).config.scope == "global"
    acts(make_global_ndf(CABLE, tmp_path), simulator=True)


def test_training_refuses_other_data_in_one_line(data: Path, tmp_path: Path) -> None:
    for name in ("subgoal-diffuser", "global-ndf", "diffusion-policy", "dp3"):
        command = ("train", name, "--env", "ICDNotebookFolding-v0", "--data", data)
        refused = icd_bench(*command, "--out", tmp_path / name)
        assert refused.exit_code == 2
        assert "holds demonstrations of ICDCableRouting-v0" in refused.stderr
        assert not (tmp_path / name).exists()
