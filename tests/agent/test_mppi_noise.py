from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from icd_agent.mppi import noise
from icd_envs.api import Float64Array

Draw = Callable[[np.random.Generator, int, int, int], Float64Array]


def coloured(rng: np.random.Generator, samples: int, horizon: int, dim: int) -> Float64Array:
    return noise.coloured(rng, samples, horizon, dim, beta=2.0)


KINDS = pytest.mark.parametrize("draw", [noise.white, coloured])


def lag_one(values: Float64Array) -> float:
    """Correlation of neighbouring steps."""
    return float(np.mean(values[:, 1:] * values[:, :-1]))


@KINDS
@pytest.mark.parametrize("horizon", [1, 2, 9, 10])
def test_every_step_has_mean_zero_and_variance_one(draw: Draw, horizon: int) -> None:
    values = draw(np.random.default_rng(0), 20_000, horizon, 2)
    assert values.shape == (20_000, horizon, 2)
    np.testing.assert_allclose(values.mean(axis=0), 0.0, atol=0.04)
    np.testing.assert_allclose(values.var(axis=0), 1.0, atol=0.06)


@KINDS
def test_same_generator_state_gives_the_same_noise(draw: Draw) -> None:
    first, second = (draw(np.random.default_rng(7), 5, 10, 3) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@KINDS
def test_axes_and_samples_are_independent(draw: Draw) -> None:
    values = draw(np.random.default_rng(1), 20_000, 10, 2)
    assert abs(np.mean(values[:, :, 0] * values[:, :, 1])) < 0.03
    assert abs(np.mean(values[::2] * values[1::2])) < 0.03


def test_white_is_uncorrelated_and_coloured_is() -> None:
    rng = np.random.default_rng(2)
    assert abs(lag_one(noise.white(rng, 5000, 10, 3))) < 0.02
    assert lag_one(coloured(rng, 5000, 10, 3)) > 0.6


def test_larger_beta_is_more_correlated_and_zero_is_white() -> None:
    rng = np.random.default_rng(3)
    lags = [lag_one(noise.coloured(rng, 5000, 10, 3, beta)) for beta in (0.0, 1.0, 2.0, 3.0)]
    assert abs(lags[0]) < 0.02
    assert lags == sorted(lags)


def test_coloured_end_is_not_tied_to_its_beginning() -> None:
    values = coloured(np.random.default_rng(4), 20_000, 10, 1)
    ends = np.mean(values[:, 0] * values[:, -1])
    assert ends < lag_one(values) - 0.3


def test_correlated_noise_reaches_at_least_twice_as_far() -> None:
    rng = np.random.default_rng(5)
    reach = [np.std(draw(rng, 5000, 10, 3).sum(axis=1)) for draw in (noise.white, coloured)]
    assert reach[0] == pytest.approx(np.sqrt(10), rel=0.05)
    assert reach[1] > 2 * reach[0]
