"""Noise schedules, from diffusers; imported late, because that takes seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler


def make_schedule(steps: int) -> DDIMScheduler:
    """A DDIM scheduler of clean-sample prediction with the squared cosine schedule.

    Args:
        steps: of the diffusion, in training.
    """
    from diffusers.schedulers.scheduling_ddim import DDIMScheduler

    return DDIMScheduler(
        num_train_timesteps=steps,
        beta_schedule="squaredcos_cap_v2",
        prediction_type="sample",
        clip_sample=False,
        timestep_spacing="trailing",
    )
