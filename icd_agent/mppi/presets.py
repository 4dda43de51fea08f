"""Named planner settings; every table says which one was used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from icd_agent.mppi.planner import MPPIConfig
from icd_envs.errors import InvalidOptionError, unknown_name

PAPER: Final = MPPIConfig(
    samples=80, horizon=10, variance=0.001, temperature=0.005, noise="white", control_cost=True
)
"""The paper's section V-B: K = 80, H = 10, noise 0.001, temperature 0.005."""

ADAPTIVE: Final = replace(PAPER, temperature="adaptive", control_cost=False)
"""The same for costs of any scale, such as distances between descriptors: the paper gives one
temperature for spaces whose scales it does not give."""

IMPROVED: Final = MPPIConfig(
    samples=80,
    horizon=10,
    variance=0.001,
    temperature="adaptive",
    noise="coloured",
    beta=2.0,
    control_cost=False,
)
"""Same number of rollouts; noise correlated in time reaches two to three times as far."""

PRESETS: Final[Mapping[str, MPPIConfig]] = MappingProxyType(
    {"paper": PAPER, "adaptive": ADAPTIVE, "improved": IMPROVED}
)


def preset(name: str) -> MPPIConfig:
    """Look a preset up by name.

    Args:
        name: "paper", "adaptive" or "improved".

    Raises:
        InvalidOptionError: for any other name, with the closest known ones.
    """
    if name not in PRESETS:
        raise InvalidOptionError(unknown_name("MPPI preset", name, PRESETS))
    return PRESETS[name]
