"""Films that a browser plays wherever it shows pictures; needs Pillow."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

GIF_WIDTH: Final = 320
"""[px]"""
GIF_EVERY: Final = 2
"""Control steps per picture."""
GIF_PERIOD: Final = 100
"""[ms] per picture: as fast as real."""
GIF_REST: Final = 1500
"""[ms] that the last picture stays."""
COLOURS: Final = 192
VIVID: Final = 60
"""Difference from the largest to the least of red, green and blue in a colour that is no grey."""

Frame = NDArray[np.uint8]


def write_gif(path: Path, frames: list[Frame]) -> None:
    """Write an endless GIF with one palette; unchanged pixels cost nothing.

    Args:
        path: of the file; folders are made.
        frames: (H, W, 3) each, of every control step.
    """
    kept = [*frames[:-1:GIF_EVERY], frames[-1]]
    small = [Image.fromarray(shrunk(frame, GIF_WIDTH)) for frame in kept]
    palette = Image.fromarray(_shares_of_colours(frames)).quantize(COLOURS, kmeans=1)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in small]
    periods = [GIF_PERIOD] * (len(flat) - 1) + [GIF_REST]
    path.parent.mkdir(parents=True, exist_ok=True)
    flat[0].save(
        path, save_all=True, append_images=flat[1:], duration=periods, loop=0, optimize=True
    )


def contact_sheet(frames: list[Frame]) -> Frame:
    """(540, 960, 3) twelve of the frames, first and last included, row by row."""
    shown = np.linspace(0, len(frames) - 1, 12).round().astype(int).reshape(3, 4)
    return np.concatenate(
        [np.concatenate([shrunk(frames[i], 240) for i in row], axis=1) for row in shown]
    )


def shrunk(frame: Frame, width: int) -> Frame:
    """The same picture, ``width`` pixels wide."""
    size = (width, width * frame.shape[0] // frame.shape[1])
    return np.asarray(Image.fromarray(frame).resize(size, Image.Resampling.LANCZOS))


def _shares_of_colours(frames: list[Frame]) -> Frame:
    """(1, P, 3) pixels from which to choose a palette, a quarter of them vivid at least.

    Chosen from all alike, a palette has hardly a colour for what is thin: a red goal turns grey.
    """
    pixels = contact_sheet(frames).reshape(-1, 3)
    vivid = pixels[np.ptp(pixels, axis=1) > VIVID]
    return np.concatenate([pixels, np.resize(vivid, (len(pixels) // 3, 3))])[None]
