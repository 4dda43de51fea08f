"""Generate chains: level by level, refined while any pair of subgoals is too far apart."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from icd_agent.diffusion.config import LEVELS, ChainConfig
from icd_agent.diffusion.denoiser import COARSE, GIVEN, UNKNOWN, Denoiser, KeyValue, Known
from icd_agent.diffusion.schedule import check_denoising, make_schedule
from icd_agent.latent.model import LatentModel
from icd_agent.latent.reachability import shortest_steps
from icd_agent.options import require


class Task(NamedTuple):
    """What a chain is wanted for.

    Attributes:
        now: (V,) the present state, coded.
        goal: (V,) the goal, coded in the scene it was specified in; without places if foreign and
            not in-painted.
        foreign: that scene is another.
        scene: (A, 3 + F) scene tokens seen from now.
    """

    now: Tensor
    goal: Tensor
    foreign: bool
    scene: Tensor


class Generated(NamedTuple):
    """A chain, from now to the goal.

    Attributes:
        latents: (L, Z), L = 2 to ``LONGEST``; the first is now.
        clouds: (L, N, 3) [m] in the scene's frame; None if only latents are known.
        steps: (L - 1,) predicted control steps between consecutive ones.
    """

    latents: Tensor
    clouds: Tensor | None
    steps: Tensor


class _Told(NamedTuple):
    """What is the same for C chains at all levels; see ``Known``.

    Attributes:
        goal: (C, V).
        foreign: (C,) bool.
        scene: (C, A, 3 + F).
    """

    goal: Tensor
    foreign: Tensor
    scene: Tensor


class Generator:
    """Draws chains with trained networks.

    Attributes:
        code: of subgoals.
        config: how.
    """

    def __init__(self, denoiser: Denoiser, latent: LatentModel, config: ChainConfig) -> None:
        """Put together.

        Args:
            denoiser: in evaluation mode.
            latent: in evaluation mode, the one whose latents the denoiser was trained on.
            config: how.

        Raises:
            InvalidOptionError: ``config.denoising_steps`` do not fit the denoiser's diffusion, or
                ``reachable`` is less than any pair is ever predicted to be apart.
        """
        check_denoising(config.denoising_steps, denoiser.config.steps)
        within, bins = config.reachable, latent.config.bin_steps
        require(
            within is None or within > bins / 2,
            "reachable",
            within,
            f"more than {bins / 2:g} control steps, the middle of the first of these latents' bins "
            f"of {bins}, or None to refine every chain to the end",
        )
        self._denoiser = denoiser
        self.code = denoiser.code
        self._latent = latent
        self.config = config
        self._schedule = make_schedule(denoiser.config.steps)
        self._schedule.set_timesteps(config.denoising_steps)

    @torch.no_grad()
    def generate(self, task: Task, rng: np.random.Generator) -> Generated:
        """Draw chains and keep the one that is most like the others.

        Args:
            task: where from and where to.
            rng: source of every draw.
        """
        count, within = self.config.chains, self.config.reachable
        foreign = task.foreign and not self.config.inpaint_goal
        chains = torch.stack([task.now, task.goal]).expand(count, -1, -1)
        told = _Told(
            task.goal.expand(count, -1),
            torch.full((count,), foreign),  # in training, foreign goals are not in-painted
            task.scene.expand(count, -1, -1),
        )
        seen = self._denoiser.look(*told)
        for level in range(1, LEVELS + 1):
            chains = self._refine(chains, told, seen, level, foreign, rng)
            chain = self._most_alike(chains, self.code.shares)
            latents = self.code.latents(chain)
            steps = self.steps(latents[None], task.scene)[0]
            if within is not None and float(steps.max()) <= within:
                break
        return Generated(latents, self.code.clouds(chain), steps)

    @torch.no_grad()
    def steps(self, chains: Tensor, scene: Tensor) -> Tensor:
        """Predicted control steps (C, L - 1) between consecutive latents (C, L, Z)."""
        first, second = chains[:, :-1].flatten(0, 1), chains[:, 1:].flatten(0, 1)
        logits = self._latent.reachability(first, second, scene.expand(len(first), -1, -1))
        return shortest_steps(logits, self._latent.config).view(len(chains), -1)

    @staticmethod
    def _most_alike(chains: Tensor, shares: Tensor) -> Tensor:
        """The one (L, V) of chains (C, L, V) whose distances to the others have the least sum.

        Args:
            chains: coded.
            shares: (V,) by which numbers count.
        """
        apart = ((chains[:, None] - chains[None]).square() @ shares).sum(dim=2).sqrt()
        return chains[int(apart.sum(dim=1).argmin())]

    def _refine(
        self,
        chains: Tensor,
        told: _Told,
        seen: list[KeyValue],
        level: int,
        generated: bool,
        rng: np.random.Generator,
    ) -> Tensor:
        """Chains (C, 2^(level-1) + 1, V) -> (C, 2^level + 1, V); perhaps with a generated end."""
        count, length = len(chains), 2**level + 1
        shown = chains.new_zeros(count, length, chains.shape[-1])
        shown[:, ::2] = chains
        kinds = torch.full((length,), UNKNOWN)
        kinds[::2] = COARSE
        kinds[0] = GIVEN
        kinds[-1] = GIVEN if not generated else COARSE if level > 1 else UNKNOWN
        shown = shown * (kinds != UNKNOWN)[:, None]
        known = Known(shown, kinds.expand(count, -1), *told, torch.full((count,), level))
        given = (kinds == GIVEN)[:, None]
        noise = rng.normal(size=shown.shape).astype(np.float32)
        values = torch.where(given, shown, torch.from_numpy(noise))
        for time in self._schedule.timesteps:
            clean = self._denoiser(values, time.expand(count), known, seen)
            clean = torch.where(given, shown, clean)
            values = self._schedule.step(clean, time, values, return_dict=False)[0]
            values = torch.where(given, shown, values)
        return values
