"""ICD whose chains are followed by something else than whole descriptors: contact, or position?"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal

import torch
from torch import Tensor

from icd_agent.chain import CostSpace, PointSpace
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.generate import Generator
from icd_agent.field.encoder import SceneCode
from icd_agent.field.field import FieldOutput, SceneField
from icd_agent.field.space import FieldSpace
from icd_agent.networks import load_shipped
from icd_agent.presets import PRESETS, best_preset
from icd_agent.tracking import SubgoalTracker

REACH: Final = 0.1
"""[m] from a surface, over which the parts of the field fade, or at which they are cut."""


class PartOfField(SceneField):
    """A trained field, of which only what is near to surfaces is left, or only what is far.

    A part that fades still tells, by the length of its descriptors, how far the surface is.
    One that is cut says nothing at all beyond the cut.
    """

    def __init__(
        self, field: SceneField, part: Literal["near", "far"], *, cut: bool = False
    ) -> None:
        """Take the weights of another; it stays as it is."""
        with torch.random.fork_rng(devices=[]):  # layers draw weights that are replaced at once
            super().__init__(field.config)
        self.load_state_dict(field.state_dict())
        self._part = part
        self._cut = cut
        self.eval()

    def query(self, code: SceneCode, points: Tensor) -> FieldOutput:
        """Ask about points (B, Q, 3) [m]; descriptors fade, or end, with the predicted distance."""
        found = super().query(code, points)
        away = self.config.close_scale * found.log_distance.expm1()[..., None] / REACH
        far = (away >= 1.0).to(away) if self._cut else away.clamp(0.0, 1.0)
        weight = far if self._part == "far" else 1.0 - far
        return found._replace(descriptor=weight * found.descriptor)


def make_places(env_id: str) -> SubgoalTracker:
    """Build ICD whose subgoals are followed as places: points, no descriptors in the cost."""
    return _follow_in(env_id, lambda field: PointSpace())


def make_no_places(env_id: str) -> SubgoalTracker:
    """Build ICD whose subgoals are followed by descriptors alone, as in the paper."""
    return _follow_in(env_id, FieldSpace)


def make_near_field(env_id: str) -> SubgoalTracker:
    """Build ICD with the local part alone: descriptors fade over 10 cm from surfaces."""
    return _follow_in(env_id, lambda field: FieldSpace(PartOfField(field, "near")))


def make_far_field(env_id: str) -> SubgoalTracker:
    """Build ICD with the far part alone: descriptors fade over the last 10 cm to surfaces."""
    return _follow_in(env_id, lambda field: FieldSpace(PartOfField(field, "far")))


def make_near_field_cut(env_id: str) -> SubgoalTracker:
    """Build ICD with descriptors up to 10 cm from surfaces, and none beyond."""
    return _follow_in(env_id, lambda field: FieldSpace(PartOfField(field, "near", cut=True)))


def make_far_field_cut(env_id: str) -> SubgoalTracker:
    """Build ICD with descriptors from 10 cm from surfaces on, and none closer to them."""
    return _follow_in(env_id, lambda field: FieldSpace(PartOfField(field, "far", cut=True)))


def _follow_in(env_id: str, make_space: Callable[[SceneField], CostSpace]) -> SubgoalTracker:
    networks = load_shipped(env_id)
    settings = PRESETS[best_preset(env_id)]
    generator = Generator(networks.diffusion, networks.latent, settings.chain)
    encoded_in = FieldSpace(networks.encoded)
    source = DiffusedSource(networks.encoded, networks.latent, generator, encoded_in=encoded_in)
    space = make_space(networks.field)
    return SubgoalTracker(source, space, settings.mppi, settings.tracker)
