"""What pictures of networks have in common: the file, and colours of descriptors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from icd_envs.api import FloatArray
from icd_envs.errors import InvalidOptionError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(out: Path, size: tuple[float, float]) -> Figure:
    """An empty figure that will be saved as ``out``.

    Args:
        out: PNG file.
        size: [inch].

    Raises:
        InvalidOptionError: a file that is no PNG, or no Matplotlib.
    """
    if out.suffix != ".png":
        raise InvalidOptionError(f"out={str(out)!r} cannot be used: give a name that ends in .png")
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InvalidOptionError(
            "pictures need Matplotlib: pip install 'implicit-contact-diffuser[figures]'"
        ) from error
    return Figure(figsize=size, dpi=110, layout="constrained")


def save_figure(figure: Figure, out: Path) -> None:
    """Write it; folders are made."""
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out)


class Colours:
    """Colours of descriptors: their first three principal components as red, green and blue."""

    def __init__(self, descriptors: FloatArray) -> None:
        """Choose the components.

        Args:
            descriptors: (Q, D), all that will be shown side by side.
        """
        self._mean = descriptors.mean(axis=0)
        _, _, axes = np.linalg.svd(descriptors - self._mean, full_matrices=False)
        self._axes = axes[:3].T
        shown = (descriptors - self._mean) @ self._axes
        self._low, self._high = np.quantile(shown, [0.02, 0.98], axis=0)

    def __call__(self, descriptors: FloatArray) -> FloatArray:
        """(..., D) -> (..., 3) in [0, 1]."""
        shown = (descriptors - self._mean) @ self._axes
        return np.asarray(np.clip((shown - self._low) / (self._high - self._low), 0.0, 1.0))
