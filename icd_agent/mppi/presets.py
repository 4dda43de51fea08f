"""Named planner settings; every table says which one was used."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from icd_agent.mppi.planner import MPPIConfig

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
