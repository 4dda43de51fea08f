"""What the autoencoder encodes: states of the object that it was trained on."""

from __future__ import annotations

import pytest
import torch

from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_envs.errors import InvalidOptionError

CONFIG = LatentConfig(5, 5, 20, latent=4, groups=4, neighbours=3, width=8)


@pytest.mark.parametrize(("points", "features"), [(20, 3), (19, 5), (20, 6)])
def test_other_points_or_features_are_refused_by_name(points: int, features: int) -> None:
    with pytest.raises(InvalidOptionError, match=rf"\(2, {points}, {features}\) .* \(B, 20, 5\)"):
        LatentModel(CONFIG).encode(torch.zeros(2, points, features), torch.rand(20, 3))


def test_another_object_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match=r"canonical=7 .* 20 points"):
        LatentModel(CONFIG).encode(torch.zeros(2, 20, 5), torch.rand(7, 3))
