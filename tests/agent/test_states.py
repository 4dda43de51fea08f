"""Features of recorded states: the right ones, computed once, whatever happens in between."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest

from icd_agent import states as module
from icd_agent.chain import Features
from icd_agent.scene_tokens import SceneTokens
from icd_agent.states import EVERY, States, describe_states
from icd_envs.api import Float32Array
from icd_envs.demonstrations import Demonstrations
from icd_envs.errors import DemonstrationsError
from tests.demonstrations.making import make_folder
from tests.killing import KilledError

EPISODES = 3


class Describe:
    """Features are places about the middle of the scene; ends the call after so many scenes."""

    def __init__(self, scenes: int = 1000) -> None:
        self.left = scenes

    def __call__(self, scene: Float32Array) -> tuple[Features, SceneTokens]:
        if self.left == 0:
            raise KilledError
        self.left -= 1
        middle = scene.mean(axis=0)
        return (lambda points: points - middle), SceneTokens(scene[:4], scene[:4] - middle)


@pytest.fixture(scope="module")
def demonstrations(tmp_path_factory: pytest.TempPathFactory) -> Demonstrations:
    return Demonstrations(make_folder(tmp_path_factory.mktemp("data"), episodes=EPISODES))


def compute(demonstrations: Demonstrations, folder: Path, describe: Describe) -> States:
    return describe_states(demonstrations, describe, folder, space="toy", episodes=EPISODES)


def test_every_fifth_state_and_the_last_with_their_features(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    states = compute(demonstrations, tmp_path, Describe())
    for i in range(EPISODES):
        rows = slice(states.first[i], states.first[i + 1])
        episode = demonstrations.episode(i)
        steps = states.step[rows]
        assert steps[0] == 0
        assert steps[-1] == episode.steps
        assert (steps[:-1] % EVERY == 0).all()
        assert (states.episode[rows] == i).all()
        middle = demonstrations.scene(i).cloud.mean(axis=0)
        wanted = episode.points[steps] - middle
        np.testing.assert_allclose(states.features[rows], wanted, atol=1e-3)
        np.testing.assert_allclose(states.clouds[rows], episode.points[steps], atol=1e-6)
        np.testing.assert_allclose(states.middle[rows], episode.points[steps].mean(1), atol=1e-5)
        assert (states.solved[rows] == episode.solved[steps]).all()
    assert len(states.step) == states.first[-1] == len(states.features)


def test_a_killed_call_goes_on_and_a_finished_one_computes_nothing(
    demonstrations: Demonstrations, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "SAVE_EVERY", 1)
    whole = compute(demonstrations, tmp_path / "whole", Describe())
    for _ in range(EPISODES - 1):
        with pytest.raises(KilledError):
            compute(demonstrations, tmp_path / "parts", Describe(1))
    compute(demonstrations, tmp_path / "parts", Describe(1))
    parts = compute(demonstrations, tmp_path / "parts", Describe(0))
    np.testing.assert_array_equal(parts.features, whole.features)
    np.testing.assert_array_equal(parts.clouds, whole.clouds)
    np.testing.assert_array_equal(parts.middle, whole.middle)
    np.testing.assert_array_equal(parts.tokens.places, whole.tokens.places)
    np.testing.assert_array_equal(parts.tokens.features, whole.tokens.features)


def test_features_of_something_else_are_refused(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    compute(demonstrations, tmp_path, Describe())
    with pytest.raises(DemonstrationsError, match="other states or of another space"):
        describe_states(demonstrations, Describe(), tmp_path, space="else", episodes=EPISODES)


def test_features_of_the_same_seeds_played_by_another_expert_are_refused(
    demonstrations: Demonstrations, tmp_path: Path
) -> None:
    compute(demonstrations, tmp_path, Describe())
    anew = copy.copy(demonstrations)
    anew.nodes = demonstrations.nodes + np.float32(1e-3)
    with pytest.raises(DemonstrationsError, match="other states or of another space"):
        compute(anew, tmp_path, Describe())
