"""Training chains: states of one episode at equal distances, and what is told of them."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import LEVELS
from icd_agent.diffusion.denoiser import COARSE, GIVEN, UNKNOWN, Known
from icd_agent.episodes import Goals
from icd_agent.scene_tokens import Frame
from icd_agent.states import States

FROM_START: Final = 0.4
"""Share of chains that begin where the episode does."""
TO_END: Final = 0.6
"""Share that end where it does."""
BLUR: Final = 0.1
"""Largest standard deviation of the noise on what the level before has proposed: at test time
it was generated."""


class Chains(NamedTuple):
    """A batch of one level.

    Attributes:
        clean: (B, L, V) coded subgoals.
        known: what is told of them.
    """

    clean: Tensor
    known: Known


class ChainData:
    """Recorded states as subgoals, and random chains of them."""

    def __init__(
        self, states: States, latents: Tensor, code: SubgoalCode, scene_size: float
    ) -> None:
        """Keep them.

        Args:
            states: of recorded episodes.
            latents: (S, Z) of these states.
            code: of subgoals.
            scene_size: [m] unit of the scene tokens' places.
        """
        self._states = states
        self._latents = latents
        self._code = code
        self._scene_size = scene_size
        self._last = states.first[1:] - 1
        self._whose = Goals(states.solved[self._last])

    def draw(self, count: int, rng: np.random.Generator, device: str = "cpu") -> Chains:
        """A batch of chains, all of one level.

        Args:
            count: B.
            rng: source of every draw.
            device: where the tensors go.
        """
        level = int(rng.integers(1, LEVELS + 1))
        rows = self._rows(level, count, rng)
        clean = self._code.join(self._latents[torch.from_numpy(rows)], self._clouds(rows))
        goal, foreign = self._goals(rows[:, -1], rng)
        told = self._code.join(self._latents[torch.from_numpy(goal)], None)
        own = torch.from_numpy(~foreign)
        told[own] = clean[own, -1]
        kinds = np.where(np.arange(2**level + 1) % 2 == 0, COARSE, UNKNOWN)
        kinds = np.tile(kinds, (count, 1))
        kinds[:, 0] = GIVEN
        kinds[:, -1] = np.where(foreign, COARSE if level > 1 else UNKNOWN, GIVEN)
        blur = rng.uniform(0.0, BLUR, (count, 1, 1)) * rng.normal(size=clean.shape)
        shown = clean + torch.from_numpy((blur * (kinds == COARSE)[..., None]).astype(np.float32))
        shown = shown * torch.from_numpy(kinds != UNKNOWN)[..., None]
        known = Known(
            shown,
            torch.from_numpy(kinds),
            told,
            torch.from_numpy(foreign),
            torch.from_numpy(self._states.seen_from(rows[:, 0], self._scene_size)),
            torch.full((count,), level),
        )
        return Chains(clean.to(device), Known(*(each.to(device) for each in known)))

    def _clouds(self, rows: NDArray[np.int64]) -> Tensor:
        """(B, L, N, 3) [m] of states (B, L), in the frames of the first ones."""
        frame = self._states.frame(rows[:, 0])
        frames = Frame(frame.origin[:, None], frame.along[:, None])
        return torch.from_numpy(frames.place(self._states.clouds[rows]).astype(np.float32))

    def _rows(self, level: int, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
        """(B, 2^level + 1) rows of states at equal distances, at least one apart."""
        states, parts = self._states, 2**level
        episode = rng.integers(len(states.first) - 1, size=count)
        low, high = states.first[episode], states.first[episode + 1] - 1
        shortest = np.minimum(parts, high - low)
        start = low + rng.integers(0, high - low - shortest + 1)
        start = np.where(rng.random(count) < FROM_START, low, start)
        end = start + shortest + rng.integers(0, high - start - shortest + 1)
        end = np.where(rng.random(count) < TO_END, high, end)
        share = np.linspace(0.0, 1.0, parts + 1)
        return np.rint(start[:, None] + share * (end - start)[:, None]).astype(np.int64)

    def _goals(
        self, rows: NDArray[np.int64], rng: np.random.Generator
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """The goal of each chain: its own last state, or one like it in another scene."""
        episode = self._states.episode[rows]
        whose, foreign = self._whose.draw(episode, rng, at_end=rows == self._last[episode])
        return np.where(foreign, self._last[whose], rows), foreign
