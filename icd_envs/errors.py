"""Every error a caller can cause, as a typed exception that names field, value and fix."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Final


class IcdError(Exception):
    """Base of every error this project raises on purpose."""


class InvalidActionError(IcdError, ValueError):
    """An action that no simulation step can be taken with; the simulation state is unchanged."""


class InvalidSeedError(IcdError, ValueError):
    """A reset seed that is not an integer in [0, 2**64)."""


class InvalidOptionError(IcdError, ValueError):
    """An option, id or name that does not exist, or a value it cannot take."""


class InvalidObservationError(IcdError, ValueError):
    """Clouds that cannot be wrapped or rewarded: wrong shape, NaN or infinite values."""


class EpisodeStateError(IcdError, RuntimeError):
    """A call out of order: step before reset, after the end of the episode, or after close."""


NOT_BEGUN: Final = "act() before reset(): call reset(episode, seed) first"
"""What an ``EpisodeStateError`` of an agent says."""


class NoSceneError(EpisodeStateError, AttributeError):
    """Model, state or goal asked for where there is none: before reset, or after close."""


class IncompatibleStateError(IcdError, ValueError):
    """A snapshot of another environment, version or scene, or no snapshot at all."""


class SceneGenerationError(IcdError, RuntimeError):
    """No solvable scene was found within the attempts allowed for one seed."""


class DemonstrationsError(IcdError, ValueError):
    """Recorded demonstrations that are missing, damaged, or of another version of a task."""


class TrainingError(IcdError, RuntimeError):
    """A training run that cannot go on: its loss is not finite, or its state is not its own."""


class CheckpointError(IcdError, ValueError):
    """Weights that are missing, damaged, or of something else."""


class SceneExportError(IcdError, ValueError):
    """A scene that cannot be written as a mesh file."""


class RenderingUnavailableError(IcdError, RuntimeError):
    """OpenGL could not be initialised; physics, point clouds and the benchmark work without it."""


def unknown_name(kind: str, name: object, known: Iterable[str]) -> str:
    """Message for a misspelt name, with the closest known names.

    Args:
        kind: what the name was supposed to be, e.g. ``"option"``.
        name: the value received.
        known: every valid name.
    """
    names = sorted(known)
    close = difflib.get_close_matches(str(name), names, n=3)
    hint = f"did you mean {' or '.join(map(repr, close))}? " if close else ""
    return f"unknown {kind} {name!r}: {hint}valid: {', '.join(map(repr, names)) or 'none'}"
