from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from icd_agent.mppi.planner import MPPI, MPPIConfig
from icd_agent.mppi.presets import ADAPTIVE, IMPROVED, PAPER
from icd_envs.api import Float64Array
from icd_envs.errors import InvalidOptionError

SCALE = 0.03
EVERY_PLANNER = pytest.mark.parametrize(
    "config", [PAPER, ADAPTIVE, IMPROVED], ids=["paper", "adaptive", "improved"]
)


def textbook_mppi(
    nominal: Float64Array,
    actions: Float64Array,
    state_costs: Float64Array,
    temperature: float,
    variance: float,
) -> Float64Array:
    """Williams et al. 2017, algorithm 2, with loops and an explicit covariance matrix."""
    inverse = np.linalg.inv(variance * np.eye(nominal.shape[1]))
    total = []
    for sequence, cost in zip(actions, state_costs, strict=True):
        for t, action in enumerate(sequence):
            cost = cost + temperature * nominal[t] @ inverse @ (action - nominal[t])
        total.append(cost)
    weights = [math.exp(-(cost - min(total)) / temperature) for cost in total]
    plan = nominal.copy()
    for t in range(len(nominal)):
        for weight, sequence in zip(weights, actions, strict=True):
            plan[t] = plan[t] + weight / sum(weights) * (sequence[t] - nominal[t])
    return plan


def integrator_costs(
    state: Float64Array, actions: Float64Array, goal: Float64Array
) -> Float64Array:
    path = state + SCALE * np.cumsum(actions, axis=1)
    costs: Float64Array = np.sum((path - goal) ** 2, axis=(1, 2))
    return costs


def plain(**changes: object) -> MPPIConfig:
    """The paper's settings without the extra sample and the control cost."""
    base = dataclasses.replace(PAPER, keep_nominal=False, control_cost=False)
    return dataclasses.replace(base, **changes)  # type: ignore[arg-type]


@EVERY_PLANNER
def test_closed_loop_drives_an_integrator_to_the_goal(config: MPPIConfig) -> None:
    planner, rng = MPPI(config, SCALE), np.random.default_rng(0)
    state, goal = np.zeros(3), np.array([0.3, -0.2, 0.1])
    for _ in range(30):
        actions = planner.sample(rng)
        planner.update(actions, integrator_costs(state, actions, goal))
        state = state + SCALE * planner.shift()
    assert np.linalg.norm(state - goal) < 0.04


def test_update_equals_an_independent_textbook_implementation() -> None:
    planner, rng = MPPI(PAPER, SCALE), np.random.default_rng(1)
    state, goal = np.zeros(3), np.array([0.1, 0.05, 0.0])
    for _ in range(5):
        before = planner.nominal
        actions = planner.sample(rng)
        costs = integrator_costs(state, actions, goal)
        planner.update(actions, costs)
        expected = textbook_mppi(before, actions, costs, 0.005, 0.001 / SCALE**2)
        np.testing.assert_allclose(planner.nominal, expected, rtol=0, atol=1e-10)
        state = state + SCALE * planner.shift()


def test_variance_is_that_of_the_displacement_in_metres() -> None:
    scale = 1.0  # so large that nothing is clipped
    actions = MPPI(plain(samples=4000), scale).sample(np.random.default_rng(2))
    assert np.var(scale * actions) == pytest.approx(0.001, rel=0.02)


def test_temperature_towards_zero_picks_the_best_sample() -> None:
    planner, rng = MPPI(plain(temperature=1e-300), SCALE), np.random.default_rng(3)
    actions, costs = planner.sample(rng), rng.uniform(size=80)
    info = planner.update(actions, costs)
    np.testing.assert_array_equal(planner.nominal, actions[np.argmin(costs)])
    assert info.effective_samples == 1.0


def test_temperature_towards_infinity_takes_the_mean() -> None:
    planner, rng = MPPI(plain(temperature=1e12), SCALE), np.random.default_rng(4)
    actions, costs = planner.sample(rng), rng.uniform(size=80)
    info = planner.update(actions, costs)
    np.testing.assert_allclose(planner.nominal, actions.mean(axis=0), atol=1e-9)
    assert info.effective_samples == pytest.approx(80)


def test_adaptive_plan_ignores_the_unit_of_the_cost() -> None:
    plans = []
    for unit in (1e-6, 1.0, 1e6):
        planner, rng = MPPI(IMPROVED, SCALE), np.random.default_rng(5)
        actions, costs = planner.sample(rng), rng.uniform(size=80)
        planner.update(actions, unit * costs)
        plans.append(planner.nominal)
    np.testing.assert_allclose(plans[0], plans[1], atol=1e-9)
    np.testing.assert_allclose(plans[2], plans[1], atol=1e-9)


def test_an_adaptive_plan_is_made_of_about_a_dozen_of_evenly_spread_samples() -> None:
    planner = MPPI(IMPROVED, SCALE)
    actions = planner.sample(np.random.default_rng(5))
    info = planner.update(actions, np.linspace(0.0, 1.0, 80))
    assert 11 < info.effective_samples < 13


def test_adding_a_constant_to_every_cost_changes_nothing() -> None:
    plans = []
    for constant in (0.0, 100.0):
        planner, rng = MPPI(PAPER, SCALE), np.random.default_rng(6)
        actions, costs = planner.sample(rng), rng.uniform(size=80)
        planner.update(actions, costs + constant)
        plans.append(planner.nominal)
    np.testing.assert_allclose(plans[0], plans[1], atol=1e-8)


def test_shift_returns_the_first_action_and_moves_the_plan_on() -> None:
    planner, rng = MPPI(plain(horizon=3), SCALE), np.random.default_rng(7)
    actions = planner.sample(rng)
    planner.update(actions, rng.uniform(size=80))
    plan = planner.nominal
    np.testing.assert_array_equal(planner.shift(), plan[0])
    np.testing.assert_array_equal(planner.nominal, [plan[1], plan[2], np.zeros(3)])


def test_first_sample_is_the_shifted_plan_without_noise() -> None:
    planner, rng = MPPI(PAPER, SCALE), np.random.default_rng(8)
    planner.update(planner.sample(rng), rng.uniform(size=80))
    planner.shift()
    np.testing.assert_array_equal(planner.sample(rng)[0], planner.nominal)


def test_actions_stay_in_the_box() -> None:
    planner, rng = MPPI(dataclasses.replace(PAPER, variance=1.0), SCALE), np.random.default_rng(9)
    actions = planner.sample(rng)
    planner.update(actions, -actions.sum(axis=(1, 2)))
    assert np.abs(actions).max() == 1.0
    assert np.abs(planner.nominal).max() <= 1.0


@EVERY_PLANNER
def test_samples_depend_on_the_generator_only(config: MPPIConfig) -> None:
    first = MPPI(config, SCALE).sample(np.random.default_rng(10))
    np.random.seed(123)  # noqa: NPY002 - the global state is what must not matter
    before = np.random.get_state(legacy=False)  # noqa: NPY002
    second = MPPI(config, SCALE).sample(np.random.default_rng(10))
    after = np.random.get_state(legacy=False)  # noqa: NPY002
    np.testing.assert_array_equal(first, second)
    np.testing.assert_equal(after, before)


@EVERY_PLANNER
@pytest.mark.parametrize(("samples", "horizon"), [(1, 10), (80, 1), (1, 1), (2, 2)])
def test_one_sample_or_one_step_is_safe(config: MPPIConfig, samples: int, horizon: int) -> None:
    planner = MPPI(dataclasses.replace(config, samples=samples, horizon=horizon), SCALE)
    actions = planner.sample(np.random.default_rng(0))
    assert actions.shape == (samples, horizon, 3)
    info = planner.update(actions, np.ones(samples))
    assert info.status == "ok"
    assert np.isfinite(planner.shift()).all()


@EVERY_PLANNER
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_no_usable_sample_holds_still_and_says_so(config: MPPIConfig, bad: float) -> None:
    planner, rng = MPPI(config, SCALE), np.random.default_rng(0)
    planner.update(planner.sample(rng), rng.uniform(size=80))
    info = planner.update(planner.sample(rng), np.full(80, bad))
    assert info.status == "all rollouts diverged"
    assert info.invalid_samples == 80
    np.testing.assert_array_equal(planner.shift(), np.zeros(3))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_unusable_samples_get_no_weight(bad: float) -> None:
    rng = np.random.default_rng(0)
    planner = MPPI(plain(temperature=1e12), SCALE)
    actions, costs = planner.sample(rng), rng.uniform(size=80)
    costs[:40] = bad
    info = planner.update(actions, costs)
    assert info.invalid_samples == 40
    assert math.isfinite(info.mean_cost)
    np.testing.assert_allclose(planner.nominal, actions[40:].mean(axis=0), atol=1e-9)


@EVERY_PLANNER
@pytest.mark.parametrize("extreme", [1e308, -1e308, 1e-320, 0.0])
def test_extreme_costs_never_make_a_nan_action(config: MPPIConfig, extreme: float) -> None:
    planner, rng = MPPI(config, SCALE), np.random.default_rng(0)
    number = np.arange(80)
    for negative in (number < 0, number < 1, number % 2 == 0):
        pattern = np.where(negative, -extreme, extreme)
        planner.update(planner.sample(rng), pattern)
        assert np.isfinite(planner.shift()).all()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("samples", 0),
        ("samples", 2.0),
        ("samples", True),
        ("horizon", 0),
        ("variance", 0.0),
        ("variance", math.nan),
        ("temperature", -1.0),
        ("temperature", math.inf),
        ("temperature", "hot"),
        ("noise", "pink"),
        ("beta", -1.0),
    ],
)
def test_bad_option_is_named_with_its_value(field: str, value: object) -> None:
    with pytest.raises(InvalidOptionError, match=f"{field}={value!r}"):
        MPPIConfig(**{field: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("change", [{"noise": "coloured"}, {"temperature": "adaptive"}])
def test_control_cost_needs_its_own_covariance(change: dict[str, str]) -> None:
    with pytest.raises(InvalidOptionError, match="control_cost=True"):
        MPPIConfig(control_cost=True, **change)  # type: ignore[arg-type]


def test_wrong_shapes_and_scales_are_refused() -> None:
    planner = MPPI(PAPER, SCALE)
    actions = planner.sample(np.random.default_rng(0))
    with pytest.raises(InvalidOptionError, match=r"costs\.shape"):
        planner.update(actions, np.zeros(79))
    with pytest.raises(InvalidOptionError, match=r"actions\.shape"):
        planner.update(actions[:, :5], np.zeros(80))
    with pytest.raises(InvalidOptionError, match="action_scale=0"):
        MPPI(PAPER, 0)


def test_the_papers_settings_are_the_default() -> None:
    assert MPPIConfig() == PAPER
