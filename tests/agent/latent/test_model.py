"""What the autoencoder encodes: states of the object that it was trained on."""

from __future__ import annotations

import pytest
import torch

from icd_agent.latent.config import LatentConfig
from icd_agent.latent.model import LatentModel
from icd_agent.training.initial import initialise
from icd_envs.errors import InvalidOptionError

CONFIG = LatentConfig(5, 5, 20, latent=4, groups=4, neighbours=3, width=8)


@pytest.mark.parametrize(("points", "features"), [(20, 3), (19, 5), (20, 6)])
def test_other_points_or_features_are_refused_by_name(points: int, features: int) -> None:
    with pytest.raises(InvalidOptionError, match=rf"\(2, {points}, {features}\) .* \(B, 20, 5\)"):
        LatentModel(CONFIG).encode(torch.zeros(2, points, features), torch.rand(20, 3))


def test_another_object_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match=r"canonical=7 .* 20 points"):
        LatentModel(CONFIG).encode(torch.zeros(2, 20, 5), torch.rand(7, 3))


def test_what_is_kept_of_one_object_is_not_used_for_another() -> None:
    draw = torch.Generator().manual_seed(0)
    features = torch.randn(2, 20, 5, generator=draw)
    one, other = torch.rand(20, 3, generator=draw), torch.rand(20, 3, generator=draw)
    fresh = LatentModel(CONFIG).eval()
    initialise(fresh, draw)
    used = LatentModel(CONFIG).eval()
    used.load_state_dict(fresh.state_dict())
    with torch.no_grad():
        first = used.encode(features, one)
        assert torch.equal(used.encode(features, other), fresh.encode(features, other))
        assert torch.equal(used.encode(features, one), first)
        assert not torch.equal(used.encode(features, other), first)
        one += 1.0  # changed in place: no longer the object whose parts are kept
        assert torch.equal(used.encode(features, one), fresh.encode(features, one.clone()))
