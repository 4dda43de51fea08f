"""Intervals and tests against scipy, textbooks and published tables."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest, bootstrap, permutation_test

from benchmarks.statistics import bootstrap_mean, fisher_p, holm, paired_p, wilson


@pytest.mark.parametrize(
    ("successes", "n"), [(0, 1), (1, 1), (0, 20), (20, 20), (7, 20), (1, 3), (13, 200), (999, 1000)]
)
@pytest.mark.parametrize("confidence", [0.8, 0.95, 0.99])
def test_wilson_agrees_with_scipy(successes: int, n: int, confidence: float) -> None:
    expected = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    interval = wilson(successes, n, confidence)
    assert interval == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert 0.0 <= interval.low <= successes / n <= interval.high <= 1.0


def test_wilson_agrees_with_a_textbook() -> None:
    # Agresti, Categorical Data Analysis: 0 of 25 students are vegetarians.
    assert wilson(0, 25) == pytest.approx((0.0, 0.133), abs=5e-4)


def test_wilson_takes_fractional_sums_between_their_neighbours() -> None:
    below, between, above = wilson(7, 20), wilson(7.5, 20), wilson(8, 20)
    assert below.low < between.low < above.low
    assert below.high < between.high < above.high


def test_wilson_of_nothing_is_none() -> None:
    assert wilson(0, 0) is None


@pytest.mark.parametrize("successes", [-1, 21, float("nan")])
def test_wilson_refuses_impossible_sums(successes: float) -> None:
    with pytest.raises(ValueError, match="successes must be in"):
        wilson(successes, 20)


def outcomes(both: int, first: int, second: int, neither: int) -> tuple[list[bool], list[bool]]:
    """Pairs of which so many were won by both, by one only, by none."""
    a = [True] * (both + first) + [False] * (second + neither)
    b = [True] * both + [False] * first + [True] * second + [False] * neither
    return a, b


@pytest.mark.parametrize(
    ("table", "p"),
    [
        # Fagerland, Lydersen, Laake 2013 (doi:10.1186/1471-2288-13-91), table 1: airway
        # hyper-responsiveness before and after stem cell transplantation.
        ((1, 1, 7, 12), 0.0703),
        # Armitage and Berry 1994, page 127: two media for culturing tuberculosis.
        ((20, 12, 2, 16), 0.0129),
    ],
)
def test_mcnemar_agrees_with_published_tables(table: tuple[int, int, int, int], p: float) -> None:
    a, b = outcomes(*table)
    assert paired_p(a, b, range(len(a))) == pytest.approx(p, abs=5e-5)
    assert paired_p(b, a, range(len(a))) == pytest.approx(p, abs=5e-5)


@pytest.mark.parametrize("table", [(0, 0, 0, 0), (5, 0, 0, 0), (0, 0, 0, 5), (3, 0, 0, 2)])
def test_agents_that_never_differ_are_not_told_apart(table: tuple[int, int, int, int]) -> None:
    a, b = outcomes(*table)
    assert paired_p(a, b, range(len(a))) == 1.0


@settings(deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=12))
def test_repeats_count_by_case_and_single_ones_as_mcnemar(pairs: list[tuple[bool, bool]]) -> None:
    a, b = ([pair[i] for pair in pairs] for i in range(2))
    single = paired_p(a, b, range(len(pairs)))
    # Whoever repeats every episode to the bit learns nothing.
    assert paired_p(a * 2, b * 2, [*range(len(pairs))] * 2) == pytest.approx(single)


def test_repeats_agree_with_scipys_permutation_test() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.random(16) < 0.8, rng.random(16) < 0.3
    cases = np.repeat(np.arange(8), 2)
    by_case = [np.bincount(cases, weights=successes) for successes in (a, b)]
    expected = permutation_test(
        by_case, lambda x, y: np.mean(x - y), permutation_type="samples", n_resamples=np.inf
    )
    assert paired_p(list(a), list(b), list(cases)) == pytest.approx(expected.pvalue)


def test_fisher_agrees_with_the_lady_tasting_tea() -> None:
    assert fisher_p((3, 4), (1, 4)) == pytest.approx(34 / 70)
    assert fisher_p((18, 20), (13, 20)) == pytest.approx(0.127, abs=5e-4)
    assert fisher_p((20, 20), (20, 20)) == 1.0


def test_holm_agrees_with_a_worked_example() -> None:
    # Holm 1979's procedure on four p-values, by hand: 4 x .005, 3 x .01, 2 x .03, then the same.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.7, 0.6]) == [1.0, 1.0]
    assert holm([]) == []


@pytest.mark.parametrize("n", [10, 100])
def test_bootstrap_agrees_with_scipy(n: int) -> None:
    rng = np.random.default_rng(1)
    values = rng.integers(0, 3, n) / 2.0
    expected = bootstrap((values,), np.mean, method="percentile", rng=rng).confidence_interval
    interval = bootstrap_mean(list(values), range(n))
    assert interval == pytest.approx((expected.low, expected.high), abs=0.02)
    assert bootstrap_mean(list(values), range(n)) == interval


def test_bootstrap_draws_whole_cases() -> None:
    values = [0.0, 1.0, 1.0, 0.0, 1.0, 1.0]
    once = bootstrap_mean(values, range(6))
    twice = bootstrap_mean(values * 2, [*range(6)] * 2)
    assert twice == pytest.approx(once, abs=0.03)
    assert bootstrap_mean(values * 2, range(12)).low > once.low


@pytest.mark.parametrize(("values", "cases"), [([], []), ([1.0], [0]), ([1.0, 0.0], [0, 0])])
def test_bootstrap_needs_two_cases(values: list[float], cases: list[int]) -> None:
    assert bootstrap_mean(values, cases) is None


def test_bootstrap_of_equal_values_is_that_value() -> None:
    assert bootstrap_mean([0.5] * 5, range(5)) == (0.5, 0.5)


def test_bootstrap_of_very_many_values_is_that_of_the_normal_distribution() -> None:
    interval = bootstrap_mean([0.0, 1.0] * 20_000, range(40_000))
    assert interval == pytest.approx((0.5 - 1.96 * 0.0025, 0.5 + 1.96 * 0.0025), abs=2e-4)
