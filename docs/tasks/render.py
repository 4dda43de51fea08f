"""Draw the pictures that every task page has: python -m docs.tasks.render [--env ID].

One clean expert episode of a test scene: a GIF, twelve moments of it, the start with the goal in
red, and the end from every camera. Needs the extra [video]; about 20 s per environment.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

import numpy as np
from PIL import Image

from benchmarks.suites import episode_seed
from docs.tasks.filming import (
    FOLDER,
    Frame,
    all_views,
    contact_sheet,
    film_expert,
    save,
    shrunk,
)
from docs.tasks.make_pages import slug
from icd_envs import ENV_IDS

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


def draw(env_id: str, index: int) -> None:
    """All pictures of one environment.

    Args:
        env_id: which.
        index: of the test scene, as the benchmark counts them.

    Raises:
        RuntimeError: if the expert does not reach the goal.
    """
    seed = episode_seed(0, env_id, index)
    film = film_expert(env_id, seed)
    if not film.info["is_success"]:
        raise RuntimeError(f"{env_id}, index {index}: the expert failed, take another one")
    name = slug(env_id)
    write_gif(FOLDER / f"{name}-expert.gif", film.frames)
    save(f"{name}-expert", contact_sheet(film.frames))
    save(f"{name}-start-and-goal", film.frames[0])
    save(f"{name}-success", all_views(env_id, seed, film.end))


def write_gif(path: Path, frames: list[Frame]) -> None:
    """Write an endless GIF with one palette; unchanged pixels cost nothing.

    Args:
        path: of the file.
        frames: of every control step.
    """
    kept = [*frames[:-1:GIF_EVERY], frames[-1]]
    small = [Image.fromarray(shrunk(frame, GIF_WIDTH)) for frame in kept]
    palette = Image.fromarray(_shares_of_colours(frames)).quantize(COLOURS, kmeans=1)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in small]
    periods = [GIF_PERIOD] * (len(flat) - 1) + [GIF_REST]
    flat[0].save(
        path, save_all=True, append_images=flat[1:], duration=periods, loop=0, optimize=True
    )


def _shares_of_colours(frames: list[Frame]) -> Frame:
    """(1, P, 3) pixels from which to choose a palette, a quarter of them vivid at least.

    Chosen from all alike, a palette has hardly a colour for what is thin: a red goal turns grey.
    """
    pixels = contact_sheet(frames).reshape(-1, 3)
    vivid = pixels[np.ptp(pixels, axis=1) > VIVID]
    return np.concatenate([pixels, np.resize(vivid, (len(pixels) // 3, 3))])[None]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env", choices=ENV_IDS, help="only this one")
    parser.add_argument("--index", type=int, default=3, help="of the test scene")
    options = parser.parse_args()
    for env_id in [options.env] if options.env else ENV_IDS:
        draw(env_id, options.index)
        print(env_id)
