"""Settings of the point cloud autoencoder. Imports no torch."""

from __future__ import annotations

from dataclasses import dataclass, fields

from icd_agent.options import is_count, is_positive, require


@dataclass(frozen=True)
class LatentConfig:
    """Sizes of the network.

    Attributes:
        features: D, numbers per object point.
        scene_features: numbers per scene token, its place left out.
        points: N, of the object.
        latent: Z.
        groups: G, parts of the object, spread over its canonical cloud.
        neighbours: points of a part.
        width: of the encoder's first layers; the others follow from it.
        decoder_width: of the decoder's outermost hidden layers; the innermost is four times it.
        bins: K of reachability; the last one is open.
        bin_steps: control steps per bin.
        softness: [control steps] of the soft minimum over the predicted distribution.
        object_size: [m] canonical coordinates enter in this unit.
        scene_size: [m] places of scene tokens enter in this unit.
    """

    features: int
    scene_features: int
    points: int
    latent: int = 64
    groups: int = 32
    neighbours: int = 16
    width: int = 64
    decoder_width: int = 64
    bins: int = 21
    bin_steps: int = 10
    softness: float = 10.0
    object_size: float = 0.2
    scene_size: float = 0.2

    def __post_init__(self) -> None:
        """Refuse values out of range.

        Raises:
            InvalidOptionError: naming the field, the value and what would be valid.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "int":
                require(is_count(value), field.name, value, "an integer >= 1")
            elif field.type == "float":
                require(is_positive(value), field.name, value, "a number > 0")
