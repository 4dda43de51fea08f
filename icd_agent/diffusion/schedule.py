"""Noise schedules, from diffusers; imported late, because that takes seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from icd_envs.errors import InvalidOptionError

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


def check_denoising(denoising_steps: int, steps: int) -> None:
    """Refuse counts of denoising steps that do not end without noise.

    DDIM takes every (steps / denoising_steps)th step of the diffusion, rounded, and from each goes
    as far down as that ratio, rounded off: with an unlucky count the last one stops short of the
    clean sample, or there is one too many.

    Args:
        denoising_steps: of DDIM.
        steps: of the diffusion, in training.

    Raises:
        InvalidOptionError: naming counts nearby that can be used.
    """
    if _ends_clean(denoising_steps, steps):
        return
    good = [count for count in range(1, steps + 1) if _ends_clean(count, steps)]
    near = sorted(sorted(good, key=lambda count: abs(count - denoising_steps))[:4])
    raise InvalidOptionError(
        f"denoising_steps={denoising_steps} cannot be used with steps={steps}: the last of them "
        f"would not end without noise: give one like {', '.join(map(str, near))}"
    )


def _ends_clean(count: int, steps: int) -> bool:
    times = np.round(np.arange(steps, 0, -steps / count)).astype(np.int64) - 1
    return len(times) == count and 0 <= times[-1] < steps // count
