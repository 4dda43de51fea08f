"""What can be acted on passes untouched, what cannot is named; every learned agent asks."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from baselines.dp3 import make_dp3
from baselines.sac_her import make_sac_her
from icd_agent.agent import ICDAgent
from icd_agent.observed import checked
from icd_envs.api import Agent
from icd_envs.errors import InvalidObservationError
from tests.agent.test_icd_agent import networks
from tests.envs.making import CABLE, make


def observed(obs_mode: str = "full") -> dict[str, Any]:
    env = make(CABLE, obs_mode=obs_mode)
    observation: Any = env.reset(seed=3)[0]
    env.close()
    return dict(observation)


@pytest.mark.parametrize("obs_mode", ["full", "partial"])
def test_what_environments_observe_passes_as_the_same_arrays(obs_mode: str) -> None:
    observation = observed(obs_mode)
    found: Any = checked(observation, 200)
    assert found.keys() == observation.keys()
    assert all(found[name] is value for name, value in observation.items())


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"scene": np.full((1000, 3), np.nan)}, "scene has NaN"),
        ({"achieved_goal": np.full((200, 3), np.inf)}, "achieved_goal has NaN or inf"),
        ({"desired_goal": np.zeros((50, 3))}, r"desired_goal has shape \(50, 3\).*\(200, 3\)"),
        ({"goal_scene": np.zeros((0, 3))}, r"goal_scene has shape \(0, 3\).*\(N, 3\)"),
        ({"observation": np.zeros(3)}, r"observation has shape \(3,\).*\(6,\)"),
        ({"scene": [["a", "b", "c"]]}, "scene is no array of numbers"),
        ({"scene_mask": np.ones(7)}, r"scene_mask has shape \(7,\).*\(1000,\)"),
    ],
)
def test_what_cannot_be_acted_on_is_named(changes: dict[str, Any], reason: str) -> None:
    with pytest.raises(InvalidObservationError, match=reason):
        checked({**observed(), **changes}, 200)


def test_what_is_missing_is_named() -> None:
    observation = observed()
    del observation["scene"]
    with pytest.raises(InvalidObservationError, match="no 'scene', only 'observation'"):
        checked(observation)
    with pytest.raises(InvalidObservationError, match=r"is ndarray.*FlattenPointCloud"):
        checked(np.zeros(12))


@pytest.mark.parametrize("name", ["icd", "dp3", "sac-her"])
def test_agents_take_double_precision_and_refuse_what_is_not_finite(name: str) -> None:
    env: gym.Env[Any, Any] = make(CABLE)
    observation, _ = env.reset(seed=3)
    episode: Any = env.unwrapped.episode(simulator=True)  # type: ignore[attr-defined]
    agent: Agent = {
        "icd": lambda: ICDAgent(networks()),
        "dp3": lambda: make_dp3(CABLE),
        "sac-her": lambda: make_sac_her(CABLE),
    }[name]()

    def act(given: Any) -> Any:  # noqa: ANN401
        agent.reset(episode, seed=1)
        return agent.act(given)

    double = {part: value.astype(np.float64) for part, value in observation.items()}
    np.testing.assert_array_equal(act(double), act(observation))
    observation["achieved_goal"][3] = np.nan
    with pytest.raises(InvalidObservationError, match="achieved_goal has NaN"):
        act(observation)
    env.close()
