"""Model predictive path integral control: sample, update, shift. Knows no dynamics and no cost.

Source: Williams et al. 2017, "Information Theoretic MPC for Model-Based Reinforcement Learning",
algorithm 2, with the sign and clipping conventions of the pytorch_mppi package; section
"MPPI with Neural Contact Subgoals" of the paper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from icd_agent.mppi import noise
from icd_agent.options import is_count, is_finite, is_positive, require
from icd_envs.api import Float64Array, FloatArray

NoiseName = Literal["white", "coloured"]
Status = Literal["ok", "all rollouts diverged"]

# Adaptive temperature: half of the spread between the best sample and the best 15 %, so that
# about a dozen of 80 samples share the weight whatever the unit of the cost.
ADAPTIVE_QUANTILE = 0.15
ADAPTIVE_SCALE = 0.5


@dataclass(frozen=True)
class MPPIConfig:
    """Settings of the planner; the defaults are the paper's.

    Attributes:
        samples: K, action sequences per control step.
        horizon: H, control steps per sequence.
        variance: [m^2] of the gripper displacement, per step and axis. The paper's "noise 0.001"
            is read as a variance (standard deviation 3.2 cm): a standard deviation of 1 mm cannot
            produce the published motion.
        temperature: in units of the cost, or "adaptive" to follow the spread of the sample costs.
        noise: correlation of the noise in time.
        beta: exponent of "coloured" noise.
        keep_nominal: sample 0 is the shifted previous plan without noise, so that a step never
            loses what the step before found (with a single sample, the plan never changes).
        control_cost: add ``temperature * u^T Sigma^-1 eps``; needs white noise and a fixed
            temperature, for which this Sigma is the true covariance.
    """

    samples: int = 80
    horizon: int = 10
    variance: float = 0.001
    temperature: float | Literal["adaptive"] = 0.005
    noise: NoiseName = "white"
    beta: float = 2.0
    keep_nominal: bool = True
    control_cost: bool = True

    def __post_init__(self) -> None:
        """Refuse values no plan can be made with.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in ("samples", "horizon"):
            value = getattr(self, field)
            require(is_count(value), field, value, "an integer >= 1")
        require(is_positive(self.variance), "variance", self.variance, "a finite number > 0 [m^2]")
        adaptive = self.temperature == "adaptive"
        require(
            adaptive or is_positive(self.temperature),
            "temperature",
            self.temperature,
            'a finite number > 0, or "adaptive"',
        )
        names = get_args(NoiseName)
        require(self.noise in names, "noise", self.noise, f"one of {', '.join(names)}")
        require(
            is_finite(self.beta) and self.beta >= 0,
            "beta",
            self.beta,
            "a finite number >= 0",
        )
        require(
            not self.control_cost or (self.noise == "white" and not adaptive),
            "control_cost",
            self.control_cost,
            "False, or white noise and a fixed temperature",
        )


@dataclass(frozen=True)
class UpdateInfo:
    """What one update did.

    Attributes:
        status: "ok", or why the plan was replaced by holding still.
        best_cost: lowest cost of a valid sample, without the control cost; inf if there is none.
        mean_cost: mean of the same costs.
        effective_samples: 1 / sum of squared weights, between 1 and K; 0 if none is valid.
        invalid_samples: samples with a NaN or infinite cost, which got no weight.
        temperature: the temperature used.
    """

    status: Status
    best_cost: float
    mean_cost: float
    effective_samples: float
    invalid_samples: int
    temperature: float


class MPPI:
    """A plan of H actions that is improved from weighted samples.

    One control step is ``actions = sample(rng)``, costs from outside, ``update(actions, costs)``,
    ``action = shift()``. The plan begins, and is continued, with zero actions: hold still.
    """

    def __init__(self, config: MPPIConfig, action_scale: float, action_dim: int = 3) -> None:
        """Begin with the plan of holding still.

        Args:
            config: settings.
            action_scale: [m] displacement per control step for an action of 1.
            action_dim: A.

        Raises:
            InvalidOptionError: if the scale is not positive and finite.
        """
        require(is_positive(action_scale), "action_scale", action_scale, "a finite number > 0 [m]")
        self.config = config
        self.action_std = math.sqrt(config.variance) / action_scale
        self._nominal = np.zeros((config.horizon, action_dim))

    @property
    def nominal(self) -> Float64Array:
        """The plan, (H, A) in [-1, 1]; a copy."""
        return self._nominal.copy()

    def sample(self, rng: np.random.Generator) -> Float64Array:
        """Draw action sequences round the plan.

        Args:
            rng: source of all randomness.

        Returns:
            (K, H, A), clipped to [-1, 1].
        """
        samples, (horizon, dim) = self.config.samples, self._nominal.shape
        match self.config.noise:
            case "white":
                unit = noise.white(rng, samples, horizon, dim)
            case "coloured":
                unit = noise.coloured(rng, samples, horizon, dim, self.config.beta)
        if self.config.keep_nominal:
            unit[0] = 0.0
        return np.clip(self._nominal + self.action_std * unit, -1.0, 1.0)

    def update(self, actions: FloatArray, costs: FloatArray) -> UpdateInfo:
        """Replace the plan by the exponentially weighted mean of the samples.

        Samples with a NaN or infinite cost get no weight; if that is all of them, the plan becomes
        holding still.

        Args:
            actions: (K, H, A) from ``sample``.
            costs: (K,) cost of each sequence.

        Returns:
            What was done.

        Raises:
            InvalidOptionError: if the shapes do not belong together.
        """
        fits = actions.ndim == 3 and actions.shape[1:] == self._nominal.shape
        require(fits, "actions.shape", actions.shape, f"(K, *{self._nominal.shape})")
        require(costs.shape == (len(actions),), "costs.shape", costs.shape, f"({len(actions)},)")
        valid = np.isfinite(costs) & np.isfinite(actions).all(axis=(1, 2))
        invalid = int(np.count_nonzero(~valid))
        if invalid == len(costs):
            self._nominal = np.zeros_like(self._nominal)
            return UpdateInfo("all rollouts diverged", math.inf, math.inf, 0.0, invalid, math.nan)

        candidates = np.asarray(actions[valid], np.float64)
        prices = np.asarray(costs[valid], np.float64)
        best = float(prices.min())
        # The best sample's exponent is finite whatever the others overflow to.
        with np.errstate(over="ignore", under="ignore"):
            excess = np.minimum(prices - best, np.finfo(np.float64).max)
            mean_cost = best + float(excess.mean())
            temperature = self._temperature(excess)
            exponents = excess / temperature
            if self.config.control_cost:
                # The noise that was left after clipping: what was cut off was never executed.
                kept = candidates - self._nominal
                exponents += np.einsum("ha,kha->k", self._nominal, kept) / self.action_std**2
            weights = np.exp(exponents.min() - exponents)
        weights /= weights.sum()
        self._nominal = np.clip(np.einsum("k,kha->ha", weights, candidates), -1.0, 1.0)
        return UpdateInfo(
            status="ok",
            best_cost=best,
            mean_cost=mean_cost,
            effective_samples=float(1.0 / np.sum(weights**2)),
            invalid_samples=invalid,
            temperature=temperature,
        )

    def shift(self) -> Float64Array:
        """Take the first action of the plan and move the plan one step on.

        Returns:
            (A,) the action to execute now, in [-1, 1].
        """
        action: Float64Array = self._nominal[0].copy()
        self._nominal = np.concatenate([self._nominal[1:], np.zeros((1, len(action)))])
        return action

    def _temperature(self, excess: Float64Array) -> float:
        """The fixed temperature, or one that follows the costs above the best (K,)."""
        if self.config.temperature != "adaptive":
            return self.config.temperature
        spread = float(np.quantile(excess, ADAPTIVE_QUANTILE))
        return max(ADAPTIVE_SCALE * spread, float(np.finfo(np.float64).tiny))
