"""Settings of the denoiser and of how chains are generated. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

from icd_agent.options import is_count, is_finite, is_positive, require

LEVELS: Final = 4
"""Refinements of [now, goal]: chains of 3, 5, 9 and 17."""
LONGEST: Final = 2**LEVELS + 1


@dataclass(frozen=True)
class DiffusionConfig:
    """Sizes of the network.

    Attributes:
        latent: Z.
        scene_features: numbers per scene token, its place left out.
        points: N, of the object.
        scene_tokens: how many of a scene's tokens are read: the first ones.
        places: Q, numbers by which a cloud of these points is generated; 0 is not at all.
        memory: numbers by which a scene token and the goal enter the attention.
        width: of the Transformer.
        layers: of the Transformer.
        heads: of its attention.
        steps: of the diffusion, in training.
        scene_size: [m] places of scene tokens enter in this unit.
    """

    latent: int
    scene_features: int
    points: int
    scene_tokens: int
    places: int = 16
    memory: int = 64
    width: int = 192
    layers: int = 4
    heads: int = 4
    steps: int = 100
    scene_size: float = 0.2

    @property
    def numbers(self) -> int:
        """Of a subgoal: Z + Q."""
        return self.latent + self.places

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "int" and field.name != "places":
                require(is_count(value), field.name, value, "an integer >= 1")
        none = self.places == 0 and type(self.places) is int
        require(none or is_count(self.places), "places", self.places, "an integer >= 0")
        require(is_positive(self.scene_size), "scene_size", self.scene_size, "a number > 0")
        require(self.width % (2 * self.heads) == 0, "width", self.width, "a multiple of 2 x heads")


@dataclass(frozen=True)
class ChainConfig:
    """How chains are generated.

    Attributes:
        chains: how many are drawn; the one whose summed distance to the others is smallest is
            kept.
        denoising_steps: of DDIM, per level; see ``check_denoising``.
        reachable: [control steps] a chain is refined while any pair is predicted to be farther
            apart; None is to the end, to ``LONGEST`` subgoals.
        ask_field: descriptors of a subgoal are those that the field has at its generated places;
            otherwise they are decoded from its latent (the paper).
        inpaint_goal: the last subgoal is the goal as it was given (the paper). Otherwise it is
            generated for the present scene whenever the goal was specified in another.
        keep_shorter: asked again, keep what is left of the last chain unless the new one is
            predicted to take fewer steps; otherwise the new one always replaces it (the paper).
    """

    chains: int = 8
    denoising_steps: int = 12
    reachable: float | None = 15.0
    ask_field: bool = True
    inpaint_goal: bool = False
    keep_shorter: bool = True

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for name in ("chains", "denoising_steps"):
            require(is_count(getattr(self, name)), name, getattr(self, name), "an integer >= 1")
        within = self.reachable
        good = within is None or (is_finite(within) and within > 0)
        require(good, "reachable", within, "control steps > 0, or None")
