from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from icd_envs.demonstrations import demonstrate, find_task, recording
from icd_envs.demonstrations.recording import record
from icd_envs.tasks.base import run_expert
from tests.envs.making import CABLE


@pytest.mark.parametrize("noisy", [False, True])
def test_recording_is_the_beginning_of_the_demonstration(noisy: bool) -> None:
    recorded = record(find_task(CABLE), seed=3, steps=25, split="train", noisy=noisy)
    shown = demonstrate(CABLE, seed=3, noisy=noisy)
    assert recorded.actions.tobytes() == shown.actions[:25].tobytes()
    assert recorded.gripper.tobytes() == shown.gripper[:26].tobytes()
    np.testing.assert_array_equal(recorded.nodes, shown.nodes[:26].astype(np.float32))
    np.testing.assert_array_equal(recorded.solved, shown.solved[:26])
    assert not recorded.success
    assert not recorded.diverged


def test_state_that_diverged_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def explode(*arguments: object) -> object:
        shown = run_expert(*arguments)  # type: ignore[arg-type]
        shown.nodes[-1] = np.nan
        return dataclasses.replace(shown, diverged=True)

    monkeypatch.setattr(recording, "run_expert", explode)
    recorded = record(find_task(CABLE), seed=0, steps=4, split="train", noisy=True)
    assert recorded.diverged
    assert recorded.actions.shape == (3, 3)
    assert len(recorded.nodes) == len(recorded.gripper) == len(recorded.solved) == 4
    assert np.all(np.isfinite(recorded.nodes))


def test_scene_parameters_are_kept() -> None:
    recorded = record(find_task(CABLE), seed=0, steps=1, split="train", noisy=True)
    assert set(recorded.parameters) == set(find_task(CABLE).parameter_names)
    assert len(recorded.scene_id) == 16
