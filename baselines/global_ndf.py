"""Global NDF: ICD on a field that describes the whole scene with one code, as the first NDF does.

The paper's baseline (section V-B, after Simeonov et al., ICRA 2022): everything else is ICD's. The
package's weights are of the field alone so far; with them, the goal is the only subgoal.
"""

from __future__ import annotations

from pathlib import Path

from icd_agent.agent import ICDAgent, best_preset, load_networks
from icd_agent.chain import GoalSource
from icd_agent.field.space import FieldSpace
from icd_agent.mppi.presets import preset
from icd_agent.tracking import SubgoalTracker
from icd_agent.weights import GLOBAL_FIELD


def make_global_ndf(env_id: str, weights: Path | None = None) -> ICDAgent | SubgoalTracker:
    """Build it with the settings that ICD has, or with the package's weights as far as they go.

    Args:
        env_id: whose settings, and whose weights of the package.
        weights: folder of ``field``, ``latent`` and ``diffusion``, as ``icd-bench train
            global-ndf`` leaves it; None is the package's field, without chains.

    Raises:
        CheckpointError: missing or damaged weights.
    """
    if weights is not None:
        return ICDAgent(load_networks(weights), best_preset(env_id))
    space = FieldSpace.shipped(env_id, GLOBAL_FIELD)
    return SubgoalTracker(GoalSource(), space, preset("adaptive"))
