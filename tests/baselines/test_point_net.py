from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium import spaces
from torch import Tensor

from baselines.point_net import PointNetExtractor
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError

B = 5


def space(**shapes: tuple[int, ...]) -> spaces.Dict:
    return spaces.Dict(
        {name: spaces.Box(-1.0, 1.0, shape, np.float32) for name, shape in shapes.items()}
    )


PARTIAL = space(
    observation=(6,), goal=(20, 3), cloud=(20, 3), cloud_mask=(20,), scene=(30, 3), scene_mask=(30,)
)


def extractor(of: spaces.Dict = PARTIAL, points: int = 128) -> PointNetExtractor:
    with torch.random.fork_rng():
        torch.manual_seed(0)
        return PointNetExtractor(of, points=points, widths=(8, 16, 32))


def drawn(of: spaces.Dict = PARTIAL, seed: int = 0) -> dict[str, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    parts = {name: torch.rand(B, *box.shape, generator=generator) for name, box in of.items()}
    return {n: (v < 0.7).float() if n.endswith("_mask") else v for n, v in parts.items()}


def test_features_are_clouds_then_vectors() -> None:
    net, seen = extractor(), drawn()
    features = net(seen)
    assert set(net.clouds) == {"goal", "cloud", "scene"}
    assert net.vectors == ["observation"]
    assert features.shape == (B, net.features_dim) == (B, 3 * 32 + 6)
    torch.testing.assert_close(features[:, -6:], seen["observation"])
    assert torch.isfinite(features).all()


def test_order_of_points_does_not_matter() -> None:
    net, seen = extractor(), drawn()
    generator = torch.Generator().manual_seed(1)
    mixed = dict(seen)
    for name in net.clouds:
        order = torch.randperm(seen[name].shape[1], generator=generator)
        for part in (name, f"{name}_mask"):
            if part in seen:
                mixed[part] = seen[part][:, order]
    torch.testing.assert_close(net(mixed), net(seen))
    # But the points themselves do.
    moved = {**seen, "cloud": seen["cloud"] + 0.1}
    assert not torch.allclose(net(moved), net(seen))


def test_hidden_points_do_not_matter() -> None:
    net, seen = extractor(), drawn()
    hidden = (seen["cloud_mask"] == 0)[..., None]
    assert hidden.any()
    elsewhere = {**seen, "cloud": torch.where(hidden, torch.tensor(50.0), seen["cloud"])}
    torch.testing.assert_close(net(elsewhere), net(seen))
    shown = {**elsewhere, "cloud_mask": torch.ones_like(seen["cloud_mask"])}
    assert not torch.allclose(net(shown), net(seen))


def test_visible_points_alone_give_the_same_as_with_hidden_ones() -> None:
    net, seen = extractor(), drawn()
    visible = seen["cloud_mask"][0] == 1
    row = {name: value[:1] for name, value in seen.items()}
    alone = {**row, "cloud": row["cloud"][:, visible], "cloud_mask": row["cloud_mask"][:, visible]}
    of = space(
        **{name: tuple(value.shape[1:]) for name, value in alone.items()}  # fewer points
    )
    other = extractor(of)
    assert other.clouds == net.clouds
    torch.testing.assert_close(other(alone), net(row))


def test_cloud_without_a_visible_point_gives_zeros_and_finite_gradients() -> None:
    net, seen = extractor(), drawn()
    seen["cloud_mask"][1] = 0.0
    seen["cloud"].requires_grad_()
    features = net(seen)
    at = 32 * net.clouds.index("cloud")
    assert (features[1, at : at + 32] == 0).all()
    assert (features[0, at : at + 32] != 0).any()
    features.sum().backward()
    assert torch.isfinite(seen["cloud"].grad).all()
    assert (seen["cloud"].grad[1] == 0).all()


def test_gradients_reach_every_layer_and_visible_points_only() -> None:
    net, seen = extractor(), drawn()
    seen["cloud"].requires_grad_()
    net(seen).square().sum().backward()
    for name, weight in net.named_parameters():
        assert weight.grad is not None, name
        assert weight.grad.abs().sum() > 0, name
        assert torch.isfinite(weight.grad).all(), name
    per_point = seen["cloud"].grad.abs().sum(dim=-1)
    assert (per_point[seen["cloud_mask"] == 0] == 0).all()
    assert (per_point[seen["cloud_mask"] == 1] > 0).any()


def test_gradient_agrees_with_differences() -> None:
    of = space(cloud=(6, 3), observation=(2,))
    net = extractor(of).double()
    seen = {name: value.double().requires_grad_() for name, value in drawn(of).items()}
    assert torch.autograd.gradcheck(
        lambda cloud, vector: net({"cloud": cloud, "observation": vector}),
        (seen["cloud"], seen["observation"]),
    )


@pytest.mark.parametrize(("points", "used"), [(3, [0, 10, 19]), (20, range(20)), (99, range(20))])
def test_larger_clouds_are_thinned_evenly(points: int, used: list[int]) -> None:
    of = space(cloud=(20, 3), cloud_mask=(20,))
    net, seen = extractor(of, points), drawn(of)
    seen["cloud_mask"][:] = 1.0
    seen["cloud"].requires_grad_()
    thinned = {name: value[:, list(used)] for name, value in seen.items()}
    few = extractor(space(cloud=(len(used), 3), cloud_mask=(len(used),)))
    features = net(seen)
    torch.testing.assert_close(features, few(thinned))
    features.sum().backward()
    touched = seen["cloud"].grad.abs().sum(dim=(0, 2)).nonzero().flatten().tolist()
    assert set(touched) <= set(used)


@pytest.mark.parametrize("env_id", ENV_IDS)
@pytest.mark.parametrize("obs_mode", ["full", "partial"])
def test_every_environment_is_understood(env_id: str, obs_mode: str) -> None:
    env = gym.make(env_id, obs_mode=obs_mode)
    assert isinstance(env.observation_space, spaces.Dict)
    net = extractor(env.observation_space)
    assert sorted(net.clouds) == ["achieved_goal", "desired_goal", "goal_scene", "scene"]
    assert net.vectors == ["observation"]
    parts = env.observation_space.sample()
    features = net({name: torch.as_tensor(part)[None] for name, part in parts.items()})
    assert features.shape == (1, 4 * 32 + 6)
    env.close()


@pytest.mark.parametrize(
    ("of", "settings", "message"),
    [
        (space(vector=(7,)), {}, "needs clouds"),
        (space(cloud=(7, 3), picture=(8, 8, 3)), {}, "'picture': (8, 8, 3)"),
        (space(cloud=(7, 3)), {"points": 0}, "points=0"),
        (space(cloud=(7, 3)), {"widths": ()}, "at least 1"),
        (space(cloud=(7, 3)), {"widths": (8, 0)}, "at least 1"),
    ],
)
def test_what_it_cannot_use_is_refused(
    of: spaces.Dict, settings: dict[str, object], message: str
) -> None:
    with pytest.raises(InvalidOptionError) as refused:
        PointNetExtractor(of, **settings)  # type: ignore[arg-type]
    assert message in str(refused.value)
