"""PyTorch's global generator belongs to the user: neither training nor loading weights moves it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch

from benchmarks.registry import AGENTS, Offer, make_agent
from icd_agent.checkpoints import load_checkpoint, save_checkpoint
from icd_agent.field.config import FieldConfig
from icd_agent.field.field import SceneField
from icd_agent.policy.data import PolicyData
from icd_agent.policy.look import Look
from icd_agent.policy.train import train_policy
from icd_agent.training.config import TrainingConfig
from tests.agent.field.small import SMALL, small_field
from tests.agent.policy.toy import POINTS, toy_demonstrations
from tests.envs.making import CABLE

QUICK = ("diffusion-policy", "dp3", "sac-her", "ladder:near-field")
"""Agents with networks of every kind, and one that takes a network apart."""


def stays(call: Callable[[], object]) -> None:
    torch.manual_seed(5)
    before = torch.random.get_rng_state()
    call()
    assert torch.equal(torch.random.get_rng_state(), before)


def test_loading_weights_leaves_it(tmp_path: Path) -> None:
    save_checkpoint(tmp_path, "field", small_field(), SMALL, {})

    def build(fields: dict[str, Any]) -> SceneField:
        return SceneField(FieldConfig(**fields))

    stays(lambda: load_checkpoint(tmp_path, "field", build))


def test_weights_that_do_not_fit_leave_it_too(tmp_path: Path) -> None:
    save_checkpoint(tmp_path, "field", small_field(), SMALL, {})

    def fail(fields: dict[str, Any]) -> SceneField:
        torch.rand(3)
        raise ValueError("no such network")

    def refused() -> None:
        with pytest.raises(ValueError, match="no such network"):
            load_checkpoint(tmp_path, "field", fail)

    stays(refused)


def test_training_a_policy_leaves_it(tmp_path: Path) -> None:
    recorded = toy_demonstrations()
    data = PolicyData(recorded, Look(POINTS, None), POINTS, episodes=6, solved_only=False)
    stays(lambda: train_policy(data, POINTS, TrainingConfig(steps=1), tmp_path, about={}))


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in AGENTS],
)
def test_making_an_agent_leaves_it(name: str) -> None:
    stays(lambda: make_agent(name, Offer(CABLE)))
