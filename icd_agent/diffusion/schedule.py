"""Noise schedules, from diffusers; imported late, because that takes seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler


def make_schedule(
    steps: int, prediction: Literal["sample", "epsilon"] = "sample", *, clip: bool = False
) -> DDIMScheduler:
    """A DDIM scheduler with the squared cosine schedule.

    Args:
        steps: of the diffusion, in training.
        prediction: what the network is asked for: the clean sample, or the noise.
        clip: keep predicted clean samples in [-1, 1].
    """
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler

    return DDIMScheduler(
        num_train_timesteps=steps,
        beta_schedule="squaredcos_cap_v2",
        prediction_type=prediction,
        clip_sample=clip,
        timestep_spacing="trailing",
    )
