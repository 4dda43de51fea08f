"""Global NDF: ICD on a field that describes the whole scene with one code, as the first NDF does.

The paper's baseline (section V-B, after Simeonov et al., ICRA 2022): everything else is ICD's.
Where our ICD generates its chains in this field too, the weights are the same, but it encodes exact
descriptors and this agent those of a baked grid, so that chains differ slightly; here they are
followed in this field, ICD's in the local one.
"""

from __future__ import annotations

from pathlib import Path

from icd_agent.agent import ICDAgent
from icd_agent.networks import Networks, load_networks, one_field
from icd_agent.presets import best_preset
from icd_agent.weights import GLOBAL, shipped_folder


def make_global_ndf(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it with the settings that ICD has.

    Args:
        env_id: whose settings, and whose weights of the package.
        weights: folder of ``field``, ``latent`` and ``diffusion``, as ``icd-bench train
            global-ndf`` leaves it; None is the package's.

    Raises:
        CheckpointError: missing or damaged weights, or those of other fields.
    """
    networks = _networks(env_id, weights)
    return ICDAgent(networks, best_preset(networks.env_id or env_id))


def make_global_ndf_paper(env_id: str, weights: Path | None = None) -> ICDAgent:
    """Build it with the paper's settings, as ``icd-paper``; see ``make_global_ndf``."""
    return ICDAgent(_networks(env_id, weights), "paper")


def _networks(env_id: str, weights: Path | None) -> Networks:
    return one_field(load_networks(weights or shipped_folder(env_id, GLOBAL), env_id), "global")
