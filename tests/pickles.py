"""What a file must never get away with."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path


class MakesFolder:
    """Whoever unpickles it makes a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, (str(self._folder),)
