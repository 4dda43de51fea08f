"""Settings of the action-chunk policies. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

from icd_agent.diffusion.schedule import check_denoising
from icd_agent.options import is_count, is_finite, require

Sees = Literal["key points", "points"]
Prediction = Literal["epsilon", "sample"]

GROUPS = 8
"""Of the group normalisation in the U-Net."""


@dataclass(frozen=True)
class PolicyConfig:
    """Sizes of a policy, and how it acts.

    Attributes:
        sees: "key points": object and goal as key points in order, scenes as tokens of a trained
            field (Diffusion Policy); "points": all as point clouds (3D Diffusion Policy).
        scene_features: F, numbers per scene token beside its place; 0 for points.
        object_points: K of the object and K of the goal that are seen.
        scene_points: A of the present scene and A of the goal's.
        horizon: actions that are generated at once, the first for the oldest observation.
        observed: observations that are looked at, the present one included.
        executed: actions that are executed before others are generated.
        widths: of the U-Net's levels.
        kernel: of its convolutions.
        encoded: numbers that a set of points becomes.
        time_width: numbers that the step of the diffusion becomes.
        steps: of the diffusion, in training.
        denoising_steps: of DDIM, when acting; see ``check_denoising``.
        eta: share of fresh noise in each of these steps: 0 is DDIM, 1 as much as DDPM has.
        prediction: what the network is asked for.
        temperature: standard deviation of the noise that a chunk begins as; below 1 the policy
            keeps to likely actions, and leaves out the noise of those it was trained on.
    """

    sees: Sees
    scene_features: int
    object_points: int
    scene_points: int
    horizon: int = 16
    observed: int = 2
    executed: int = 8
    widths: tuple[int, ...] = (64, 128, 256)
    kernel: int = 3
    encoded: int = 64
    time_width: int = 64
    steps: int = 100
    denoising_steps: int = 16
    eta: float = 1.0
    prediction: Prediction = "epsilon"
    temperature: float = 1.0

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "int" and field.name != "scene_features":
                require(is_count(value), field.name, value, "an integer >= 1")
        for name, known in (("sees", get_args(Sees)), ("prediction", get_args(Prediction))):
            value = getattr(self, name)
            require(value in known, name, value, f"one of {', '.join(known)}")
        none = self.scene_features == 0 and self.sees == "points"
        require(
            none or (is_count(self.scene_features) and self.sees == "key points"),
            "scene_features",
            self.scene_features,
            "those of the field for key points, 0 for points",
        )
        good = len(self.widths) >= 1 and all(is_count(w) and w % GROUPS == 0 for w in self.widths)
        require(good, "widths", self.widths, f"multiples of {GROUPS}")
        require(is_finite(self.eta) and 0 <= self.eta <= 1, "eta", self.eta, "a number in [0, 1]")
        good = is_finite(self.temperature) and 0 <= self.temperature <= 1
        require(good, "temperature", self.temperature, "a number in [0, 1]")
        require(self.kernel % 2 == 1, "kernel", self.kernel, "an odd integer")
        require(self.time_width % 2 == 0, "time_width", self.time_width, "an even integer")
        halved = 2 ** (len(self.widths) - 1)
        require(self.horizon % halved == 0, "horizon", self.horizon, f"a multiple of {halved}")
        most = self.horizon - self.observed + 1
        require(self.executed <= most, "executed", self.executed, f"at most {most}")
        check_denoising(self.denoising_steps, self.steps)

    @classmethod
    def of(cls, given: dict[str, Any]) -> PolicyConfig:
        """From a checkpoint's record, in which tuples are lists."""
        return cls(**{**given, "widths": tuple(given["widths"])})
