"""What a GPU computes is what a processor does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from icd_agent.field.train import load_field
from icd_agent.training.loop import LOG_NAME
from icd_agent.weights import shipped_chains
from icd_envs import ENV_IDS
from tests.envs.making import make
from tests.faults.training_run import RUNS
from tests.killing import KilledError, kill_at

pytestmark = [
    pytest.mark.gpu,
    pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device"),
]
GPU = "cuda"


@pytest.mark.parametrize("kind", RUNS)
def test_training_begins_as_on_a_processor(kind: str, tmp_path: Path) -> None:
    losses = {}
    for device in ("cpu", GPU):
        with pytest.raises(KilledError):
            RUNS[kind](tmp_path / device, kill_at(6), device)
        lines = (tmp_path / device / LOG_NAME).read_text().splitlines()
        losses[device] = [json.loads(line)["loss"] for line in lines]
    assert len(losses[GPU]) == 5
    np.testing.assert_allclose(losses[GPU], losses["cpu"], rtol=1e-3)


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_shipped_fields_describe_a_scene_as_on_a_processor(env_id: str) -> None:
    env = make(env_id)
    observation, _ = env.reset(seed=0)
    env.close()
    scene, cloud = (
        torch.from_numpy(observation[name])[None] for name in ("scene", "achieved_goal")
    )
    field = load_field(shipped_chains(env_id, "field"))
    with torch.no_grad():
        here = field(scene, cloud)
        there = field.to(GPU)(scene.to(GPU), cloud.to(GPU))
    for name, value in here._asdict().items():
        torch.testing.assert_close(getattr(there, name).cpu(), value, rtol=1e-3, atol=1e-4)
