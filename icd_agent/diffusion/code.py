"""What a subgoal is made of while chains are generated: latents of descriptors, and places."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.latent.principal import Principal


class SubgoalCode(nn.Module):
    """Subgoals as vectors of about unit variance: Z latents of descriptors, then Q of places.

    Places are coefficients of principal components of object clouds in a frame of the scene. They
    are easier to learn than what the field has to say of them, so that both are generated, and the
    field can be asked.

    Attributes:
        mean: (Z + Q,) of the numbers of training states.
        deviation: (Z + Q,) their standard deviations.
    """

    mean: Tensor
    deviation: Tensor
    cloud: Tensor
    scale: Tensor
    components: Tensor

    def __init__(self, config: DiffusionConfig, places: Principal | None = None) -> None:
        """Build; ``places`` is None while weights are loaded.

        Args:
            config: sizes.
            places: components of object clouds (N, 3) in frames of their scenes; None also if
                there are no places.
        """
        super().__init__()
        self.latent = config.latent
        shape = config.points, 3
        if places is None:
            cloud, scale, components = torch.zeros(shape), 1.0, torch.zeros(config.places, *shape)
        else:
            cloud, scale = torch.from_numpy(places.mean), places.scale
            components = torch.from_numpy(places.components)
        self.register_buffer("cloud", cloud)
        self.register_buffer("scale", torch.tensor(scale))
        self.register_buffer("components", components)
        self.register_buffer("mean", torch.zeros(config.numbers))
        self.register_buffer("deviation", torch.ones(config.numbers))

    def fit(self, latents: Tensor, clouds: Tensor) -> None:
        """Set mean and deviation from training states (S, Z) and (S, N, 3)."""
        numbers = torch.cat([latents, self._place(clouds)], dim=-1)
        self.mean, self.deviation = numbers.mean(dim=0), numbers.std(dim=0).clamp(min=1e-6)

    def join(self, latents: Tensor, clouds: Tensor | None) -> Tensor:
        """Vectors (..., Z + Q).

        Args:
            latents: (..., Z).
            clouds: (..., N, 3) [m] in the scene's frame; None if unknown, then places are zero.
        """
        known, numbers = self.latent, latents
        if clouds is not None:
            numbers = torch.cat([latents, self._place(clouds)], dim=-1)
            known = len(self.mean)
        normal = (numbers - self.mean[:known]) / self.deviation[:known]
        return nn.functional.pad(normal, (0, len(self.mean) - known))

    def latents(self, vectors: Tensor) -> Tensor:
        """(..., Z) of vectors (..., Z + Q)."""
        return (vectors * self.deviation + self.mean)[..., : self.latent]

    def clouds(self, vectors: Tensor) -> Tensor | None:
        """(..., N, 3) [m] in the scene's frame, of vectors (..., Z + Q); None without places."""
        if not len(self.components):
            return None
        numbers = (vectors * self.deviation + self.mean)[..., self.latent :]
        flat = numbers @ self.components.flatten(1) * self.scale
        return flat.view(*flat.shape[:-1], *self.cloud.shape) + self.cloud

    @property
    def shares(self) -> Tensor:
        """(Z + Q,) of the variance, of latents and of places; each part sums to one."""
        spread = self.deviation.square()
        latents, places = spread[: self.latent], spread[self.latent :]
        return torch.cat([latents / latents.sum(), places / places.sum()])

    def _place(self, clouds: Tensor) -> Tensor:
        share = len(self.components) / len(self.cloud)
        off = (clouds - self.cloud) / self.scale
        return share * off.flatten(-2) @ self.components.flatten(1).T
