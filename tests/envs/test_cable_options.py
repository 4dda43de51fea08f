"""Cable routing with other numbers of clips and other cables."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from icd_envs.demonstrations import demonstrate_task
from icd_envs.errors import InvalidOptionError
from icd_envs.scenes.cable import CABLES, CableKind
from icd_envs.scenes.cable_routing import cable_for, draw_scene
from icd_envs.tasks.cable_routing import CableRouting
from tests.envs.making import make, random_actions


def test_defaults_are_the_papers_task() -> None:
    assert CableRouting() == CableRouting(num_fixtures=2, cable="default")
    assert (CableRouting().max_steps, CableRouting().action_scale) == (300, 0.03)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_mouths_alternate_and_clips_keep_their_distance(count: int) -> None:
    for seed in range(50):
        scene = draw_scene(np.random.default_rng(seed), count)
        assert len(scene.clips) == count
        stations = [scene.anchor[:2], *(clip.origin[:2] for clip in scene.clips)]
        legs = np.diff(stations, axis=0)
        assert np.all(np.linalg.norm(legs, axis=1) > 0.23)
        sides = [
            np.sign(leg[0] * clip.mouth[1] - leg[1] * clip.mouth[0])
            for leg, clip in zip(legs, scene.clips, strict=True)
        ]
        assert sides == [1, -1, 1, -1][:count]
        every_pair = np.linalg.norm(scene.clip_poses[:, None, :2] - scene.clip_poses[:, :2], axis=2)
        assert np.all(every_pair[np.triu_indices(count, 1)] > 0.2)


@pytest.mark.parametrize("kind", CABLES)
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_cable_reaches_beyond_the_last_clip_with_links_of_5_cm(kind: CableKind, count: int) -> None:
    spec = cable_for(kind, count)
    assert spec.length / spec.links == pytest.approx(0.05)
    assert count > 2 or spec == CABLES[kind]
    for seed in range(50):
        scene = draw_scene(np.random.default_rng(seed), count, spec)
        route = np.array([scene.anchor[:2], *scene.clip_poses[:, :2]])
        assert np.linalg.norm(np.diff(route, axis=0), axis=1).sum() < spec.length - 0.2


def test_no_cable_is_thinner_than_the_hand_is_fast() -> None:
    step = CableRouting.action_scale / 10
    assert all(spec.radius > step for spec in CABLES.values())


@pytest.mark.parametrize("kind", CABLES)
def test_expert_solves_one_and_two_clips_with_every_cable(kind: CableKind) -> None:
    runs = [
        demonstrate_task(CableRouting(count, kind), seed=seed, split="test")
        for count in (1, 2)
        for seed in range(2)
    ]
    assert sum(run.success for run in runs) >= len(runs) - 1
    assert not any(run.diverged for run in runs)


@pytest.mark.parametrize(("count", "kind"), [(3, "ethernet"), (4, "rope")])
def test_expert_solves_longer_routes_within_their_budget(count: int, kind: CableKind) -> None:
    task = CableRouting(count, kind)
    run = demonstrate_task(task, seed=0, split="test")
    assert run.success
    assert 300 < run.steps + 100 < task.max_steps


@pytest.mark.parametrize("kind", CABLES)
def test_noisy_expert_and_random_actions_do_not_diverge(kind: CableKind) -> None:
    task = CableRouting(3, kind)
    assert not demonstrate_task(task, seed=1, noisy=True).diverged
    plant = task.make_plant(task.draw_scenes(np.random.default_rng(0)).scene)
    for action in random_actions(0, 100):
        plant.step(action)
    assert not plant.diverged()


@pytest.mark.parametrize("options", [{"num_fixtures": 4, "cable": "ethernet"}, {"cable": "rope"}])
def test_environment_passes_options_on(options: dict[str, Any]) -> None:
    env = make(**options)
    count = options.get("num_fixtures", 2)
    assert env.task == CableRouting(count, options["cable"])
    observation, info = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    assert info["clips"].shape == (count, 3)
    assert env.episode().max_steps == {2: 300, 4: 700}[count]
    assert env.episode().canonical_cloud[-1, 0] == pytest.approx({2: 1.0, 4: 1.7}[count])
    env.close()


@pytest.mark.parametrize("count", [0, 5, -1, 2.0, True, "2", None])
def test_impossible_number_of_fixtures_is_refused(count: object) -> None:
    with pytest.raises(InvalidOptionError, match=r"num_fixtures must be an integer in \[1, 4\]"):
        make(num_fixtures=count)


def test_misspelt_cable_is_answered_with_the_right_one() -> None:
    with pytest.raises(InvalidOptionError, match="did you mean 'ethernet'"):
        make(cable="ethrenet")
