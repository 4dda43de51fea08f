"""Settings of the scene descriptor field. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from icd_agent.options import is_count, is_finite, is_positive, require


@dataclass(frozen=True)
class FieldConfig:
    """Sizes of the network.

    Attributes:
        scope: ``local``: a query gathers the anchors around it (the paper's field). ``global``:
            one code for the whole scene (the paper's baseline Global NDF).
        anchors: points of the scene that carry features, spread over its surface.
        anchor_neighbours: scene points that an anchor's features come from.
        graph_neighbours: anchors that an anchor exchanges features with.
        graph_layers: how many times.
        query_neighbours: k, anchors that a query gathers.
        channels: vector channels of an anchor.
        edge_width: scalar channels of what an anchor tells a query.
        width: scalar channels of a query.
        descriptor: D, size of a descriptor.
        length_scale: [m] distances are compressed as log(1 + r / length_scale).
        floor_margin: [m] scene points this close above the lowest one are floor, not fixture.
    """

    scope: Literal["local", "global"] = "local"
    anchors: int = 128
    anchor_neighbours: int = 24
    graph_neighbours: int = 16
    graph_layers: int = 2
    query_neighbours: int = 16
    channels: int = 24
    edge_width: int = 64
    width: int = 160
    descriptor: int = 48
    length_scale: float = 0.04
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
        require(is_positive(self.length_scale), "length_scale", self.length_scale, "metres > 0")
        margin = self.floor_margin
        require(is_finite(margin) and margin >= 0, "floor_margin", margin, "metres >= 0")
