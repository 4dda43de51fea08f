"""What a policy is shown of clouds: fewer points, and of scenes what a field says of them."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from icd_agent.field.config import FieldConfig
from icd_agent.field.encoder import find_fixtures
from icd_agent.field.field import SceneField
from icd_agent.field.neighbours import gather, spread
from icd_agent.policy.config import PolicyConfig
from icd_agent.scene_tokens import scene_tokens
from icd_envs.api import Float32Array, FloatArray
from icd_envs.errors import CheckpointError


class Look:
    """Thins clouds as a policy wants them."""

    def __init__(self, config: PolicyConfig, field: SceneField | None) -> None:
        """Choose.

        Args:
            config: of the policy.
            field: describes scenes, in evaluation mode; None for policies that see points.

        Raises:
            CheckpointError: the policy needs a field, another one, or none.
        """
        found = 0 if field is None else field.config.descriptor
        if found != config.scene_features:
            raise CheckpointError(
                f"the policy takes {config.scene_features} scene features, but the field gives "
                f"{found}: use the field that it was trained with"
            )
        self._config = config
        self._field = field

    def scene(self, cloud: FloatArray) -> Float32Array:
        """(M, 3) [m] points that were seen -> (A, 3 + F)."""
        count = self._config.scene_points
        if self._field is not None:
            tokens = scene_tokens(self._field, cloud)
            return np.concatenate([tokens.places, tokens.features], axis=-1)[:count]
        points = torch.from_numpy(np.ascontiguousarray(cloud, np.float32))[None]
        _, fixture = find_fixtures(points, FieldConfig.floor_margin)
        kept: Float32Array = gather(points, spread(points, count, fixture))[0].numpy()
        return kept

    def object(self, clouds: FloatArray) -> Float32Array:
        """(..., N, 3) [m] -> (..., K, 3), evenly spaced in the material, both ends included."""
        kept = evenly(clouds.shape[-2], self._config.object_points)
        return np.asarray(clouds[..., kept, :], np.float32)


def evenly(there: int, wanted: int) -> NDArray[np.int64]:
    """Indices of so many of ``there`` points."""
    return np.linspace(0, there - 1, wanted).round().astype(np.int64)
