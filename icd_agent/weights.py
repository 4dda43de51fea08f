"""Weights that come with the package."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from icd_envs.errors import CheckpointError, unknown_name

LOCAL: Final = "local"
"""Field, autoencoder and denoiser of ICD as in the paper, where all is told by the local field."""
GLOBAL: Final = "global"
"""The same on a field with one code for the whole scene, the baseline Global NDF."""
LOCAL_FIELD: Final = f"{LOCAL}/field"
GLOBAL_FIELD: Final = f"{GLOBAL}/field"
SUBGOAL_DIFFUSER: Final = "subgoal-diffuser"
"""Part with the autoencoder and the denoiser of the baseline of that name."""
DIFFUSION_POLICY: Final = "diffusion-policy"
DP3: Final = "dp3"
SAC_HER: Final = "sac-her"
FOLDER: Final = Path(__file__).parent / "shipped"

TRAINED_FOR: Final[Mapping[str, str]] = MappingProxyType(
    {
        "ICDCableRouting-v0": "cable-routing",
        "ICDCableRoutingAdaptation-v0": "cable-routing",
        "ICDNotebookFolding-v0": "notebook-folding",
        "ICDNotebookFoldingAdaptation-v0": "notebook-folding",
    }
)
"""Name of each environment's weights; an adaptation task shares those of its task."""


_CHAINS_IN: Final = MappingProxyType({"cable-routing": GLOBAL, "notebook-folding": LOCAL})


def weights_name(env_id: str) -> str | None:
    """Name of an environment's weights, or None; a ``module:`` prefix names the same task."""
    return TRAINED_FOR.get(env_id.rpartition(":")[2])


def chains_in(env_id: str) -> str:
    """Which of ``LOCAL`` and ``GLOBAL`` the chains of the package's ICD are generated in.

    Raises:
        CheckpointError: no weights are shipped for this environment.
    """
    return _CHAINS_IN[shipped_folder(env_id).name]


def shipped_folder(env_id: str, part: str = "") -> Path:
    """Where the weights for one environment are.

    Args:
        env_id: id of the environment.
        part: what they are of, e.g. ``field``; empty is the folder of all parts.

    Raises:
        CheckpointError: none are shipped for this environment, or none of this part.
    """
    name = weights_name(env_id)
    if name is None:
        known = unknown_name("environment with shipped weights:", env_id, TRAINED_FOR)
        raise CheckpointError(f"{known}; train weights for it: icd-bench train --help")
    folder = FOLDER / name / part
    if not folder.is_dir():
        raise CheckpointError(
            f"no weights of {part!r} are shipped for {env_id}: train them: icd-bench train --help"
        )
    return folder


def shipped_chains(env_id: str, part: str = "") -> Path:
    """Where the networks are that generate the chains of the package's ICD.

    Args:
        env_id: id of the environment.
        part: ``field``, ``latent`` or ``diffusion``; empty is the folder of all.

    Raises:
        CheckpointError: none are shipped for this environment.
    """
    return shipped_folder(env_id, f"{chains_in(env_id)}/{part}")
