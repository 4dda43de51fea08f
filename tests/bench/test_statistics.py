"""Wilson's interval against scipy."""

import pytest
from scipy.stats import binomtest

from benchmarks.statistics import wilson


@pytest.mark.parametrize(
    ("successes", "n"), [(0, 1), (1, 1), (0, 20), (20, 20), (7, 20), (1, 3), (13, 200), (999, 1000)]
)
@pytest.mark.parametrize("confidence", [0.8, 0.95, 0.99])
def test_wilson_agrees_with_scipy(successes: int, n: int, confidence: float) -> None:
    expected = binomtest(successes, n).proportion_ci(confidence, method="wilson")
    interval = wilson(successes, n, confidence)
    assert interval == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert 0.0 <= interval.low <= successes / n <= interval.high <= 1.0


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
