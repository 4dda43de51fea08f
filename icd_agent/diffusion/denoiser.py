"""The denoiser: a Transformer over the subgoals of a chain that reads the scene at every one."""

from __future__ import annotations

import math
from typing import Final, NamedTuple, cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import LEVELS, DiffusionConfig

UNKNOWN: Final = 0
"""A subgoal about which nothing is known but the noisy latent."""
COARSE: Final = 1
"""One that the level before has proposed."""
GIVEN: Final = 2
"""One that is given: now, and the goal if it is in-painted."""


class Known(NamedTuple):
    """What is known of a chain before it is denoised.

    Attributes:
        subgoals: (B, L, V) coded; zero where nothing is known.
        kinds: (B, L) ``UNKNOWN``, ``COARSE`` or ``GIVEN``.
        goal: (B, V) the goal, coded.
        foreign: (B,) bool, the goal was specified in another scene.
        scene: (B, A, 3 + F) scene tokens seen from now.
        level: (B,) 1 to ``LEVELS``.
    """

    subgoals: Tensor
    kinds: Tensor
    goal: Tensor
    foreign: Tensor
    scene: Tensor
    level: Tensor


class KeyValue(NamedTuple):
    """What attention reads of its memory.

    Attributes:
        key: (B, heads, M, width / heads).
        value: of the same shape.
    """

    key: Tensor
    value: Tensor


class Denoiser(nn.Module):
    """Predicts the clean subgoals of a chain, as its code has them.

    Attributes:
        code: of subgoals, V = Z + Q numbers.
    """

    def __init__(self, config: DiffusionConfig, code: SubgoalCode | None = None) -> None:
        """Build the layers; ``code`` is None while weights are loaded."""
        super().__init__()
        self.config = config
        self.code = SubgoalCode(config) if code is None else code
        width, numbers = config.width, config.numbers
        self.noisy = nn.Linear(numbers, width)
        self.known = nn.Linear(numbers, width)
        self.kind = nn.Embedding(3, width)
        self.place = nn.Linear(width, width)
        self.scene = nn.Sequential(
            nn.Linear(config.scene_features + 3, width), nn.SiLU(), nn.Linear(width, config.memory)
        )
        self.goal = nn.Linear(numbers, config.memory)
        self.foreign = nn.Embedding(2, config.memory)
        self.time = nn.Sequential(nn.Linear(width, width), nn.SiLU(), nn.Linear(width, width))
        self.level = nn.Embedding(LEVELS + 1, width)
        self.blocks = nn.ModuleList(_Block(config) for _ in range(config.layers))
        self.out = nn.Linear(width, numbers)

    def look(self, goal: Tensor, foreign: Tensor, scene: Tensor) -> list[KeyValue]:
        """What every block reads of goal and scene: the same at all steps and levels of a chain.

        Args:
            goal: (B, V) as in ``Known``, as are the others.
            foreign: (B,).
            scene: (B, A, 3 + F).
        """
        told = self.goal(goal) + self.foreign(foreign.long())
        places = self.scene(scene[:, : self.config.scene_tokens])
        memory = torch.cat([places, told[:, None]], dim=1)
        return [cast(_Block, block).around.read(memory) for block in self.blocks]

    def forward(
        self, noisy: Tensor, time: Tensor, known: Known, seen: list[KeyValue] | None = None
    ) -> Tensor:
        """Clean subgoals (B, L, V).

        Args:
            noisy: (B, L, V).
            time: (B,) step of the diffusion, in [0, ``config.steps``).
            known: the rest.
            seen: what ``look`` has found of its goals and scenes; None is to look now.
        """
        if seen is None:
            seen = self.look(known.goal, known.foreign, known.scene)
        width = self.config.width
        where = torch.linspace(0.0, 1.0, noisy.shape[1], device=noisy.device)
        tokens = (
            self.noisy(noisy)
            + self.known(known.subgoals)
            + self.kind(known.kinds)
            + self.place(_waves(where, width))
        )
        condition = self.time(_waves(time / self.config.steps, width)) + self.level(known.level)
        for block, around in zip(self.blocks, seen, strict=True):
            tokens = block(tokens, around, condition)
        clean: Tensor = self.out(functional.layer_norm(tokens, (width,)))
        return clean


class _Block(nn.Module):
    """Attention among subgoals, then to the scene, then a perceptron, each steered (AdaLN)."""

    def __init__(self, config: DiffusionConfig) -> None:
        super().__init__()
        self.width = width = config.width
        self.steer = nn.Linear(width, 9 * width)
        self.among = _Attention(width, width, config.heads)
        self.around = _Attention(width, config.memory, config.heads)
        self.perceptron = nn.Sequential(
            nn.Linear(width, 4 * width), nn.SiLU(), nn.Linear(4 * width, width)
        )

    def forward(self, tokens: Tensor, around: KeyValue, condition: Tensor) -> Tensor:
        parts = self.steer(functional.silu(condition))[:, None].chunk(9, dim=-1)
        normal = self._normalise(tokens, parts[0], parts[1])
        tokens = tokens + parts[2] * self.among(normal, self.among.read(normal))
        normal = self._normalise(tokens, parts[3], parts[4])
        tokens = tokens + parts[5] * self.around(normal, around)
        normal = self._normalise(tokens, parts[6], parts[7])
        steered: Tensor = tokens + parts[8] * self.perceptron(normal)
        return steered

    def _normalise(self, tokens: Tensor, scale: Tensor, shift: Tensor) -> Tensor:
        return functional.layer_norm(tokens, (self.width,)) * (1.0 + scale) + shift


class _Attention(nn.Module):
    def __init__(self, width: int, memory: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(memory, 2 * width)
        self.out = nn.Linear(width, width)

    def read(self, memory: Tensor) -> KeyValue:
        return KeyValue(*map(self._split, self.key_value(memory).chunk(2, dim=-1)))

    def forward(self, tokens: Tensor, read: KeyValue) -> Tensor:
        query = self._split(self.query(tokens))
        found = functional.scaled_dot_product_attention(query, read.key, read.value)
        gathered: Tensor = self.out(found.transpose(1, 2).flatten(2))
        return gathered

    def _split(self, values: Tensor) -> Tensor:
        return values.view(*values.shape[:2], self.heads, -1).transpose(1, 2)


def _waves(values: Tensor, width: int) -> Tensor:
    """(...) in [0, 1] -> sines and cosines (..., width)."""
    frequencies = torch.logspace(0.0, 3.0, width // 2, device=values.device) * math.pi / 2
    angles = values[..., None] * frequencies
    return torch.cat([angles.sin(), angles.cos()], dim=-1)
