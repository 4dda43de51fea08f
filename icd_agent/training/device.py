"""Devices that PyTorch can use."""

from __future__ import annotations

import torch

from icd_envs.errors import InvalidOptionError


def check_device(name: str) -> None:
    """Refuse a device that is not there, or that has no numbers, as "meta".

    Raises:
        InvalidOptionError: naming what could be used.
    """
    try:
        torch.zeros(1, device=name).item()
    except (RuntimeError, AssertionError) as error:  # torch raises both
        there = "cpu, cuda" if torch.cuda.is_available() else "cpu"
        raise InvalidOptionError(f"device={name!r} cannot be used: give one of {there}") from error
