"""What must hold for every environment."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from icd_envs.tasks.env import ContactEnv
from tests.envs.making import (
    bare,
    digest,
    global_random_state,
    plant_of,
    play,
    random_actions,
    remake,
    seed_everything,
    state_bits,
)

ROOT = Path(__file__).parents[2]

DIGEST = """
import json, sys
from tests.envs.making import digest, make, play, random_actions
env = make(sys.argv[1], **json.loads(sys.argv[2]))
first = env.reset(seed=3)[0]
print(digest([first, *play(env, random_actions(2, 100))]))
"""


def test_rollout_equals_steps_bit_for_bit(env: ContactEnv[Any]) -> None:
    env.reset(seed=1)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    actions = random_actions(1, 50)
    simulators = [env.episode(simulator=True, threads=threads).simulator for threads in (1, 2)]
    at = np.array([0.0, 0.6, 1.0]) * len(oracle.actions)
    for done, rest in itertools.pairwise([0, *at.astype(int)]):
        play(env, oracle.actions[done:rest])
        state = env.snapshot()
        cloud, gripper = [], []
        for action in actions:
            observation, *_ = env.step(action)
            cloud.append(plant_of(env).points())  # what is observed, unless the view is partial
            gripper.append(observation["observation"][:3])
        for simulator in simulators:
            assert simulator is not None
            rollout = simulator.rollout(state, np.repeat(actions[None], 3, axis=0))
            for k in range(3):
                assert rollout.points[k].tobytes() == np.stack(cloud).tobytes()
                assert rollout.gripper[k].tobytes() == np.stack(gripper).tobytes()
            assert not rollout.diverged.any()
        env.restore(state)


def test_rollouts_do_not_depend_on_the_number_of_threads(env: ContactEnv[Any]) -> None:
    actions, state = random_actions(2, 8, 6), env.snapshot()
    found = []
    for threads in (1, 2, 3):
        simulator = env.episode(simulator=True, threads=threads).simulator
        assert simulator is not None
        rollout = simulator.rollout(state, actions)
        found.append((rollout.points.tobytes(), rollout.gripper.tobytes()))
    assert found[0] == found[1] == found[2]


def test_restored_state_continues_bit_for_bit(env: ContactEnv[Any]) -> None:
    env.reset(seed=2)
    play(env, random_actions(3, 10))
    state = env.snapshot()
    first = play(env, random_actions(4, 30))
    here = env.restore(state)
    assert state_bits(env) == state.physics.tobytes()
    assert (env.snapshot().steps, env.snapshot().held) == (state.steps, state.held)
    assert digest([here]) == digest([env.restore(env.snapshot())])
    assert digest(play(env, random_actions(4, 30))) == digest(first)


def test_snapshot_is_not_changed_by_what_follows(env: ContactEnv[Any]) -> None:
    state = env.snapshot()
    before = state.physics.copy()
    play(env, random_actions(5, 5))
    np.testing.assert_array_equal(state.physics, before)
    env.restore(state)


def test_same_seed_gives_the_same_hundred_steps_in_another_process(env: ContactEnv[Any]) -> None:
    first = env.reset(seed=3)[0]
    here = digest([first, *play(env, random_actions(2, 100))])
    assert env.spec is not None
    command = [sys.executable, "-c", DIGEST, env.task.env_id, json.dumps(env.spec.kwargs)]
    there = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert there.stdout.split()[-1] == here


def test_reset_forgets_history_and_ignores_rollouts_and_global_seeds(
    env: ContactEnv[Any],
) -> None:
    plain = bare(remake(env))
    first = digest([plain.reset(seed=4)[0], *play(plain, random_actions(6, 20))])
    plain.close()
    env.reset(seed=9)
    play(env, random_actions(7, 30))
    seed_everything(1)
    seen = [env.reset(seed=4)[0]]
    simulator = env.episode(simulator=True, oracle=True, threads=2).simulator
    assert simulator is not None
    for i, action in enumerate(random_actions(6, 20)):
        seed_everything(i)
        before = state_bits(env)
        simulator.rollout(env.snapshot(), random_actions(i, 4, 3))
        assert state_bits(env) == before
        seen.append(env.step(action)[0])
    assert digest(seen) == first


def test_global_random_state_is_left_alone(env: ContactEnv[Any]) -> None:
    seed_everything(5)
    before = global_random_state()
    env.reset(seed=5)
    play(env, random_actions(8, 5))
    simulator = env.episode(simulator=True).simulator
    assert simulator is not None
    simulator.rollout(env.snapshot(), random_actions(8, 2, 2))
    env.reset()
    assert global_random_state() == before


def test_unseeded_resets_follow_from_the_last_seed(env: ContactEnv[Any]) -> None:
    seeded, *unseeded = (digest([env.reset(seed=seed)[0]]) for seed in (6, None, None))
    assert len({seeded, *unseeded}) == 3
    env.reset(seed=6)
    assert digest([env.reset()[0]]) == unseeded[0]


def test_splits_and_seeds_draw_different_scenes(env: ContactEnv[Any]) -> None:
    train = bare(remake(env, split="train"))
    scenes = [e.reset(seed=s)[0]["scene"].tobytes() for e, s in ((env, 0), (env, 1), (train, 0))]
    assert len(set(scenes)) == 3
    train.close()
