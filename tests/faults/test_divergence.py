"""Physics that blows up, states that do not fit, and buffers that are full."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.api import SimState
from icd_envs.errors import EpisodeStateError, IncompatibleStateError
from icd_envs.physics.plant import FULL_BUFFERS, Plant, TrackedCloud
from icd_envs.tasks.env import ContactEnv
from tests.envs.making import digest, make, plant_of, play, random_actions, state_bits


def crowded_plant() -> Plant:
    """A hundred balls on a floor, and memory for a fraction of their contacts."""
    balls = "".join(
        f'<body pos="{x} {y} 0.049"><freejoint/><geom size="0.05"/></body>'
        for x in range(10)
        for y in range(10)
    )
    slides = "".join(
        f'<joint name="slide_{axis}" type="slide" axis="{vector}"/>'
        for axis, vector in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"))
    )
    servos = "".join(f'<velocity joint="slide_{axis}"/>' for axis in "xyz")
    xml = f"""<mujoco><size memory="100K"/><option timestep="0.005"/><worldbody>
        <geom type="plane" size="20 20 1"/>{balls}
        <body pos="0 0 1">{slides}<geom size="0.01"/><site name="node_0"/></body></worldbody>
        <sensor><framepos objtype="site" objname="node_0"/></sensor>
        <actuator>{servos}</actuator></mujoco>"""
    return Plant(xml, TrackedCloud(np.array([0]), np.zeros((1, 1))), 0.03)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e7, 1e12, 1e300])
@pytest.mark.parametrize("where", ["qpos", "qvel"])
def test_divergence_ends_the_episode_with_a_finite_observation(
    env: ContactEnv[Any],
    start: SimState,
    where: str,
    value: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    before = env.restore(start)
    getattr(plant_of(env).data, where)[7] = value
    observation, reward, terminated, truncated, info = env.step(np.zeros(3))
    assert (terminated, truncated) == (True, False)
    assert info["diverged"] is True
    assert (info["is_success"], info["complete_rate"], reward) == (False, 0.0, -1.0)
    assert env.observation_space.contains(observation)
    assert env.observation_space.contains(before)
    with pytest.raises(EpisodeStateError, match="diverged"):
        env.step(np.zeros(3))
    observation = env.restore(start)
    assert digest([observation]) == digest([before])
    _, _, terminated, _, info = env.step(np.zeros(3))
    assert (terminated, info["diverged"]) == (False, False)
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("env_id", ENV_IDS)
@pytest.mark.parametrize("reward_type", ["sparse", "dense"])
def test_divergence_is_not_paid_as_success(env_id: str, reward_type: str) -> None:
    env = make(env_id, reward_type=reward_type)
    env.reset(seed=0)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    for action in oracle.actions:
        observation, reward, *_, info = env.step(action)
    assert info["is_success"]
    plant_of(env).data.qpos[7] = np.nan
    after, diverged, *_, info = env.step(np.zeros(3))
    assert digest([after]) == digest([observation])
    assert (info["is_success"], info["complete_rate"], info["diverged"]) == (False, 0.0, True)
    assert diverged == pytest.approx(reward - 1.0)
    env.close()


@pytest.mark.parametrize("velocity", [1.0, 10.0, 1e3, 1e5, 1e8])
def test_rollouts_diverge_where_steps_do(
    env: ContactEnv[Any], start: SimState, velocity: float
) -> None:
    env.restore(start)
    simulator = env.episode(simulator=True).simulator
    assert simulator is not None
    plant_of(env).data.qvel[7] = velocity
    predicted = bool(simulator.rollout(env.snapshot(), np.zeros((1, 5, 3))).diverged[0])
    happened = False
    for _ in range(5):
        happened = happened or env.step(np.zeros(3))[4]["diverged"]
        if happened:
            break
    env.restore(start)
    assert predicted == happened
    # In between it depends on the scene.
    assert happened or velocity <= 1e3
    assert not happened or velocity >= 1e3


def test_reset_after_a_divergence_is_as_good_as_new(env: ContactEnv[Any], start: SimState) -> None:
    expected = digest([env.restore(start), *play(env, random_actions(2, 10))])
    plant_of(env).data.qpos[:] = np.nan
    assert env.step(np.zeros(3))[4]["diverged"]
    assert digest([env.reset(seed=0)[0], *play(env, random_actions(2, 10))]) == expected


def test_snapshot_of_a_divergence_is_refused_and_nothing_changes(
    env: ContactEnv[Any], start: SimState
) -> None:
    env.restore(start)
    plant_of(env).data.qpos[7] = np.nan
    bad = env.snapshot()
    env.restore(start)
    simulator = env.episode(simulator=True).simulator
    assert simulator is not None
    with pytest.raises(IncompatibleStateError, match="NaN"):
        env.restore(bad)
    with pytest.raises(IncompatibleStateError, match="NaN"):
        simulator.rollout(bad, np.zeros((2, 3, 3)))
    assert state_bits(env) == start.physics.tobytes()


@pytest.fixture(scope="module")
def foreign() -> list[SimState]:
    """Where episodes of another seed and of the other split begin, for every id."""
    states = []
    for env_id in ENV_IDS:
        for split, seed in (("test", 1), ("train", 0)):
            other = make(env_id, split=split)
            other.reset(seed=seed)
            states.append(other.snapshot())
            other.close()
    return states


def test_foreign_snapshots_are_refused_and_nothing_changes(
    env: ContactEnv[Any], start: SimState, foreign: list[SimState]
) -> None:
    env.restore(start)
    next_version = dataclasses.replace(start, env_id=env.task.env_id.replace("v0", "v1"))
    another_size = dataclasses.replace(start, physics=start.physics[:-1])
    for state in (*foreign, next_version, another_size):
        with pytest.raises(IncompatibleStateError, match="seed, split and options"):
            env.restore(state)
    assert state_bits(env) == start.physics.tobytes()


def test_full_buffers_are_counted() -> None:
    plant = crowded_plant()
    start = plant.get_state()
    plant.set_state(start)
    assert plant.buffer_overflows() == 0
    plant.step(np.zeros(3))
    assert plant.buffer_overflows() > 0
    plant.set_state(start)
    assert plant.buffer_overflows() == 0


def test_full_buffers_are_reported(env: ContactEnv[Any], start: SimState) -> None:
    env.restore(start)
    plant_of(env).data.warning[int(FULL_BUFFERS[0])].number = 3
    assert env.step(np.zeros(3))[4]["buffer_overflows"] == 3
    env.restore(start)
    assert env.step(np.zeros(3))[4]["buffer_overflows"] == 0
