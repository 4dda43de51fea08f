"""Named settings of ICD."""

from __future__ import annotations

from typing import Final, NamedTuple

from icd_agent.diffusion.config import ChainConfig
from icd_agent.mppi.planner import MPPIConfig
from icd_agent.mppi.presets import ADAPTIVE, IMPROVED
from icd_agent.tracking import TrackerConfig
from icd_agent.weights import weights_name


class Preset(NamedTuple):
    """A named way to run ICD.

    Attributes:
        mppi: the planner's settings.
        chain: how chains are generated.
        tracker: how they are followed.
        places: weight of a metre between object states, beside descriptors; 0 is none.
    """

    mppi: MPPIConfig
    chain: ChainConfig
    tracker: TrackerConfig
    places: float = 0.0


_CLOSELY: Final = TrackerConfig(
    threshold=0.5, spacing="own", passed=0.7, window=1, patience=10, replan_every=20
)

PRESETS: Final = {
    "paper": Preset(
        ADAPTIVE,
        ChainConfig(chains=1, ask_field=False, inpaint_goal=True, keep_shorter=False),
        TrackerConfig(replan_every=20),
    ),
    "improved": Preset(IMPROVED, ChainConfig(), _CLOSELY, places=0.2),
    "careful": Preset(ADAPTIVE, ChainConfig(), _CLOSELY, places=0.2),
}
"""``paper``: one chain, minimum over all remaining subgoals, the goal in-painted. ``improved``: the
one of several chains that is most like the others, one subgoal at a time, passed once most of the
way to it is done, the last one generated if the goal is foreign, noise correlated in time.
``careful``: the same with the paper's white noise, for objects that must not be hurried."""

_BEST: Final = {"notebook-folding": "careful"}


def best_preset(env_id: str | None) -> str:
    """Name of the settings that did best in training scenes.

    Args:
        env_id: id of the environment that the weights were trained for; None if it is not known.
    """
    return _BEST.get(weights_name(env_id or "") or "", "improved")
