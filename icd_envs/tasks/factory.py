"""What ``gymnasium.make`` calls: the one place where option names are checked."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, Final, Generic, TypeVar

from icd_envs.errors import InvalidOptionError, unknown_name

EnvT = TypeVar("EnvT")

OF_MAKE: Final = ("disable_env_checker", "max_episode_steps")
"""Options that ``gymnasium.make`` takes for itself; a misspelt one arrives here."""


class EnvFactory(Generic[EnvT]):
    """Makes environments of one class from options by name.

    Gymnasium hands over whatever keywords it was given, and Python's own answer to a misspelt
    one is a TypeError that proposes nothing before Python 3.13.

    Attributes:
        metadata: of the class; Gymnasium looks here for its render modes.
    """

    def __init__(self, env_class: Callable[..., EnvT]) -> None:
        """Look the options up.

        Args:
            env_class: a class whose arguments all are keyword-only options.
        """
        self._env_class = env_class
        self._known = tuple(inspect.signature(env_class).parameters)
        self.metadata: dict[str, Any] = env_class.metadata  # type: ignore[attr-defined]

    def __call__(self, **options: object) -> EnvT:
        """Make an environment.

        Args:
            options: as the class takes them.

        Raises:
            InvalidOptionError: on a name that is no option, or a value that it cannot take.
        """
        for name in options:
            if name not in self._known:
                raise InvalidOptionError(unknown_name("option", name, self._known + OF_MAKE))
        return self._env_class(**options)
