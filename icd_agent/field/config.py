"""Settings of the scene descriptor field. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from icd_agent.options import is_count, is_finite, is_positive, require


@dataclass(frozen=True)
class FieldConfig:
    """Sizes of the network.

    Attributes:
        scope: ``local``: a query gathers the anchors around it (the paper's field) and looks out at
            others (ours). ``global``: one code for the whole scene (the baseline Global NDF).
        anchors: points of the scene that carry features, spread over its surface.
        anchor_neighbours: scene points that an anchor's features come from.
        graph_neighbours: anchors that an anchor exchanges features with.
        graph_layers: how many times.
        query_neighbours: k, nearest anchors that a query gathers.
        outlook: anchors spread over the whole scene that a query looks out to; how far it looks
            grows with its distance to the nearest of them, so that contacts are described by what
            is touched and places in the open by more of what stands around.
        outlook_scale: [m] how far a query at a surface looks out.
        outlook_growth: how much farther it looks per metre of that distance.
        channels: vector channels of an anchor.
        code_channels: of the one code of the global scope, which must hold what many anchors hold
            otherwise.
        code_blocks: residual layers that ask that code.
        edge_width: scalar channels of what an anchor tells a query.
        width: scalar channels of a query.
        descriptor: D, size of a descriptor.
        close_scale: [m] distances enter as log(1 + r / close_scale); the nearest anchors' say
            fades over this distance from a surface.
        length_scale: [m] distances between descriptors are taught as log(1 + r / length_scale);
            also their unit: at a surface, points 1 mm apart have descriptors about 0.001 apart.
        floor_margin: [m] scene points this close above the lowest one are floor, not fixture.
    """

    scope: Literal["local", "global"] = "local"
    anchors: int = 256
    anchor_neighbours: int = 24
    graph_neighbours: int = 16
    graph_layers: int = 2
    query_neighbours: int = 12
    outlook: int = 16
    outlook_scale: float = 0.04
    outlook_growth: float = 0.5
    channels: int = 24
    code_channels: int = 128
    code_blocks: int = 4
    edge_width: int = 48
    width: int = 128
    descriptor: int = 32
    close_scale: float = 0.03
    length_scale: float = 0.03
    floor_margin: float = 0.003

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        require(self.scope in ("local", "global"), "scope", self.scope, "'local' or 'global'")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "int":
                require(is_count(value), field.name, value, "an integer >= 1")
        for name in ("outlook_scale", "outlook_growth", "close_scale", "length_scale"):
            require(is_positive(getattr(self, name)), name, getattr(self, name), "a number > 0")
        margin = self.floor_margin
        require(is_finite(margin) and margin >= 0, "floor_margin", margin, "metres >= 0")
