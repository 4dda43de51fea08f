"""Things of other people's modules and files, by ``module:attr`` or ``file.py:attr``."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import zlib
from pathlib import Path
from types import ModuleType

from icd_envs.errors import InvalidOptionError, unknown_name


def load(target: str) -> object:
    """Import a module or file and return what it has under that name.

    Args:
        target: ``module:attr`` or ``path/to/file.py:attr``; ``attr`` may have dots.

    Raises:
        InvalidOptionError: it cannot be imported, or has no such attribute.
    """
    source, _, attribute = target.rpartition(":")
    if not (source and attribute):
        raise InvalidOptionError(f"{target!r} is neither module:attr nor file.py:attr")
    found: object = load_module(source)
    for part in attribute.split("."):
        if not hasattr(found, part):
            known = [key for key in dir(found) if not key.startswith("_")]
            raise InvalidOptionError(f"{source}: {unknown_name('attribute', part, known)}")
        found = getattr(found, part)
    return found


def is_there(target: str) -> bool:
    """Whether there is a file or a module to look into; nothing of it is imported."""
    source = target.rpartition(":")[0]
    if source.endswith(".py"):
        return Path(source).is_file()
    top = source.partition(".")[0]
    try:
        return bool(top) and importlib.util.find_spec(top) is not None
    except ValueError:  # __main__, whose own file it is
        return False


def load_module(source: str) -> ModuleType:
    """Import a module by name, or a file by path.

    Raises:
        InvalidOptionError: it raises, leaves the program, or is not there.
    """
    try:
        if source.endswith(".py"):
            return _load_file(Path(source).resolve())
        return importlib.import_module(source)
    except (Exception, SystemExit) as error:
        raise InvalidOptionError(
            f"importing {source}: {type(error).__name__}: {' '.join(str(error).split())}"
        ) from error


def _load_file(path: Path) -> ModuleType:
    """As Python runs a script: files beside it can be imported, after everything else."""
    name = f"_file_{zlib.crc32(str(path).encode()):08x}_{path.stem}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        if str(path.parent) not in sys.path:
            sys.path.append(str(path.parent))
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
