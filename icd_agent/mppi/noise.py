"""Gaussian noise over a horizon: unit variance at every step, different correlation in time.

Every function is pure: it draws from the generator handed in and returns (K, H, A).
"""

from __future__ import annotations

import numpy as np

from icd_envs.api import Float64Array


def white(rng: np.random.Generator, samples: int, horizon: int, dim: int) -> Float64Array:
    """Draw noise that is independent from step to step.

    Args:
        rng: source of all randomness.
        samples: K.
        horizon: H.
        dim: A, number of action axes.

    Returns:
        (K, H, A), variance 1.
    """
    return rng.standard_normal((samples, horizon, dim))


def coloured(
    rng: np.random.Generator, samples: int, horizon: int, dim: int, beta: float
) -> Float64Array:
    """Draw power-law noise, spectral density 1 / f^beta (iCEM, Pinneri et al. 2020).

    White noise is filtered in the frequency domain. A period of twice the horizon is made and
    half of it kept, because filtered noise is periodic and a plan must not end where it began.

    Args:
        rng: source of all randomness.
        samples: K.
        horizon: H.
        dim: A, number of action axes.
        beta: exponent; 0 is white, 2 is close to a random walk.

    Returns:
        (K, H, A), variance 1.
    """
    period = 2 * horizon
    frequency = np.abs(np.fft.fftfreq(period))
    gain = np.maximum(frequency, 1.0 / period) ** (-beta / 2.0)
    gain /= np.sqrt(np.mean(gain**2))
    spectrum = np.fft.rfft(rng.standard_normal((samples, period, dim)), axis=1)
    spectrum *= gain[: horizon + 1, None]
    return np.fft.irfft(spectrum, n=period, axis=1)[:, :horizon]
