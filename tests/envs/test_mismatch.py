"""Planners with a wrong model."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError
from icd_envs.physics.mismatch import changed
from icd_envs.wrappers import MismatchedPlanner
from tests.envs.making import make, plant_of, random_actions

PENDULUM = """
<mujoco><option gravity="0 0 -9.81"/><worldbody>
  <body name="hand"><joint name="slide_x" type="slide" axis="1 0 0"/><geom size=".1" mass="1"/>
    <body pos="0 0 -.5"><joint name="bend" axis="0 1 0" stiffness="2"/><geom size=".1" mass="3"/>
      <body name="rigid" pos="0 0 -.5"><geom size=".1" mass="4"/></body>
    </body>
  </body>
</worldbody></mujoco>
"""


def test_only_the_object_changes() -> None:
    model = mujoco.MjModel.from_xml_string(PENDULUM)
    other = changed(model, stiffness=2.0, mass=0.5, friction=0.25)
    assert other.jnt_stiffness.tolist() == [0.0, 4.0]
    assert other.body_mass.tolist() == [0.0, 1.0, 1.5, 2.0]
    assert other.body_subtreemass[0] == pytest.approx(4.5)
    np.testing.assert_allclose(other.body_inertia[1:, 0] / model.body_inertia[1:, 0], [1, 0.5, 0.5])
    np.testing.assert_allclose(other.geom_friction[:, 0] / model.geom_friction[:, 0], 0.25)
    assert model.jnt_stiffness.tolist() == [0.0, 2.0]
    assert model.body_mass.tolist() == [0.0, 1.0, 3.0, 4.0]


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_the_planner_is_wrong_and_the_environment_is_not(env_id: str) -> None:
    env = make(env_id)
    env.reset(seed=0)
    actions = random_actions(1, 8)
    truth = env.episode(simulator=True).simulator
    wrong = MismatchedPlanner(env, stiffness=2.0, mass=0.7, friction=0.5).episode(simulator=True)
    assert truth is not None
    assert wrong.simulator is not None
    state = env.snapshot()
    expected = truth.rollout(state, actions[None])
    believed = wrong.simulator.rollout(state, actions[None])
    assert not believed.diverged.any()
    error = np.linalg.norm(believed.points - expected.points, axis=-1).mean()
    assert 1e-4 < error < 0.1
    reached = [env.step(action)[0]["achieved_goal"] for action in actions]
    np.testing.assert_array_equal(reached, expected.points[0])


def test_factors_of_one_change_no_bit() -> None:
    env = make()
    env.reset(seed=0)
    actions = random_actions(1, 2, 4)
    exact = MismatchedPlanner(env).episode(simulator=True).simulator
    truth = env.episode(simulator=True).simulator
    assert exact is not None
    assert truth is not None
    state = env.snapshot()
    found, expected = exact.rollout(state, actions), truth.rollout(state, actions)
    np.testing.assert_array_equal(found.points, expected.points)


def test_agents_without_a_simulator_get_none() -> None:
    env = make()
    env.reset(seed=0)
    assert MismatchedPlanner(env, mass=2.0).episode().simulator is None
    assert plant_of(env).model.body_mass[-1] > 0


@pytest.mark.parametrize("factor", [0.0, -1.0, float("inf"), "heavy"])
def test_impossible_factors_are_refused(factor: float) -> None:
    with pytest.raises(InvalidOptionError, match="mass must be finite and > 0"):
        MismatchedPlanner(make(), mass=factor)
