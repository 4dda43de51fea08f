from __future__ import annotations

import numpy as np
import pytest

from icd_envs.demonstrations import demonstrate
from icd_envs.errors import InvalidOptionError
from icd_envs.experts.cable_routing import CableRoutingExpert, Stray, Style, draw_style
from icd_envs.geometry.routing import signed_crossings
from icd_envs.scenes.cable_routing import CONTACTS, CableRoutingScene, Contact
from icd_envs.tasks.base import HOLD_STEPS, IDLE_STEPS, Demonstration, run_expert
from icd_envs.tasks.cable_routing import CableRouting
from icd_envs.tasks.problem import draw_problem, scene_rng
from tests.envs.making import CABLE

TASK = CableRouting()
SEEDS = range(4)


def perform(scene: CableRoutingScene, style: Style, seed: int = 0) -> Demonstration:
    expert = CableRoutingExpert(scene, TASK.action_scale, style, np.random.default_rng(seed))
    return run_expert(TASK, scene, TASK.make_plant(scene), expert)


@pytest.fixture(scope="module")
def scenes() -> list[CableRoutingScene]:
    """Scenes that the clean expert solves."""
    return [draw_problem(TASK, scene_rng("test", seed), seed).scene for seed in SEEDS]


def test_clean_expert_solves_scenes_within_the_budget(scenes: list[CableRoutingScene]) -> None:
    for scene in scenes:
        demonstration = perform(scene, Style())
        assert demonstration.success
        assert demonstration.complete_rate == 1.0
        assert HOLD_STEPS < demonstration.steps <= TASK.max_steps
        held = signed_crossings(demonstration.points[-HOLD_STEPS:], scene.clip_poses)
        assert np.all(held != 0)


@pytest.mark.parametrize("clip", [0, 1])
@pytest.mark.parametrize("fault", ["free", "behind"])
def test_fault_at_one_clip_fails_there(
    scenes: list[CableRoutingScene], clip: int, fault: Contact
) -> None:
    contacts: list[Contact] = ["through", "through"]
    contacts[clip] = fault
    runs = [perform(scene, Style(tuple(contacts))) for scene in scenes]
    missed = [
        signed_crossings(run.points[-1], scene.clip_poses)[clip] == 0
        for run, scene in zip(runs, scenes, strict=True)
    ]
    # The sweep into one clip can carry the cable through the other by accident.
    assert sum(missed) >= len(scenes) - 1
    assert not any(run.success for run, miss in zip(runs, missed, strict=True) if miss)


def test_detour_goes_elsewhere_first(scenes: list[CableRoutingScene]) -> None:
    straight = perform(scenes[0], Style())
    detour = perform(scenes[0], Style(detour=(2.5, 0.4)))
    bearing = np.arctan2(detour.points[:, -1, 1], detour.points[:, -1, 0])
    assert np.abs(bearing - 2.5).min() < 0.15
    assert detour.steps > straight.steps


def test_expert_led_astray_slackens_the_cable_and_still_routes(
    scenes: list[CableRoutingScene],
) -> None:
    stray = Stray(30, 55, np.array([-0.02, 0.0, -0.01]))
    for scene in scenes:
        straight, led = perform(scene, Style()), perform(scene, Style(strays=(stray,)))
        assert led.success
        assert led.steps > straight.steps
        np.testing.assert_array_equal(led.actions[:30], straight.actions[:30])
        np.testing.assert_allclose(
            led.actions[30:55] * TASK.action_scale, np.tile(stray.velocity, (25, 1)), atol=1e-7
        )
        reach = np.linalg.norm(led.points[:, -1] - led.points[:, 0], axis=-1)
        assert reach[55] < 0.9 * reach[30]


def test_episode_ends_soon_after_the_expert_is_done(scenes: list[CableRoutingScene]) -> None:
    runs = [perform(scene, Style(("through", "free"))) for scene in scenes]
    assert not any(run.success for run in runs)
    for scene, run in zip(scenes, runs, strict=True):
        assert run.steps < TASK.max_steps
        routed = signed_crossings(run.points, scene.clip_poses)[:, 0] != 0
        assert routed[-IDLE_STEPS:].all()
        assert not run.actions[-IDLE_STEPS:].any()  # it has nothing left to do


@pytest.mark.parametrize("noisy", [False, True])
def test_same_seed_gives_the_same_demonstration(noisy: bool) -> None:
    first, second = (demonstrate(CABLE, seed=3, noisy=noisy) for _ in range(2))
    assert first.actions.tobytes() == second.actions.tobytes()
    assert first.points.tobytes() == second.points.tobytes()
    assert first.success == second.success


def test_seed_and_split_choose_the_scene() -> None:
    clouds = [
        demonstrate(CABLE, seed=seed, split=split).points[0].tobytes()
        for seed, split in ((0, "train"), (1, "train"), (0, "test"))
    ]
    assert len(set(clouds)) == 3


def test_demonstration_is_consistent() -> None:
    demonstration = demonstrate(CABLE, seed=5, noisy=True)
    steps = demonstration.steps
    assert demonstration.points.shape == (steps + 1, 200, 3)
    assert demonstration.actions.shape == (steps, 3)
    assert (demonstration.points.dtype, demonstration.actions.dtype) == (np.float32, np.float32)
    assert np.abs(demonstration.actions).max() <= 1.0
    assert np.all(np.isfinite(demonstration.points))
    assert not demonstration.diverged


def test_styles_are_mostly_good_and_always_valid() -> None:
    rng = np.random.default_rng(0)
    styles = [draw_style(rng, ("through",) * 3) for _ in range(2000)]
    faulty = [style for style in styles if style.detour or set(style.contacts or ()) != {"through"}]
    assert len(faulty) / len(styles) == pytest.approx(0.3, abs=0.04)
    assert {contact for style in styles for contact in style.contacts or ()} == set(CONTACTS)
    for style in styles:
        assert style.contacts is not None
        assert len(style.contacts) == 3
        assert 0 < style.speed <= TASK.action_scale
        assert style.noise >= 0
    strays = [stray for style in styles for stray in style.strays]
    led = [style for style in styles if style.strays]
    assert len(led) / len(styles) == pytest.approx(0.5, abs=0.04)
    assert len(strays) / len(led) == pytest.approx(1.5, abs=0.05)
    assert all(0 <= stray.begin < stray.end <= TASK.max_steps for stray in strays)
    assert max(np.linalg.norm(stray.velocity) for stray in strays) <= TASK.action_scale


def test_noise_changes_the_actions_but_stays_in_the_box(scenes: list[CableRoutingScene]) -> None:
    runs = [perform(scenes[0], Style(noise=0.01), seed) for seed in (0, 1)]
    assert not np.array_equal(runs[0].actions[:20], runs[1].actions[:20])
    assert all(np.abs(run.actions).max() <= 1.0 for run in runs)


def test_unknown_environment_is_named_with_the_nearest() -> None:
    with pytest.raises(InvalidOptionError, match="did you mean 'ICDCableRouting-v0'"):
        demonstrate("ICDCableRoutin-v0", seed=0)
