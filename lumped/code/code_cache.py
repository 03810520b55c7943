"""Object code on disk, found again by the hash of its source."""

from __future__ import annotations

import hashlib
import os
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from lumped.support.whole_files import whole_file

__all__ = ["load", "loop_name", "own", "save"]

_MARK = b"lumped-1"


def folder() -> Path:
    """Where object code is kept: ``LUMPED_CACHE``, or a folder of the user's caches.

    Raises
    ------
    OSError
        If the user has no home.
    """
    given = os.environ.get("LUMPED_CACHE")
    if given:
        return Path(given)
    variable, place = {
        "win32": ("LOCALAPPDATA", "AppData/Local"),
        "darwin": ("", "Library/Caches"),
    }.get(sys.platform, ("XDG_CACHE_HOME", ".cache"))
    base = os.environ.get(variable)
    try:
        return (Path(base) if base else Path.home() / place) / "lumped"
    except RuntimeError as fault:
        raise OSError(str(fault)) from None


@cache
def own() -> str:
    """Hash of the files of this package on which all code depends."""
    here = Path(__file__).parent
    numerics = here.parent / "numerics"
    kernels = sorted((here.parent / "kernel").rglob("*.py"))
    files = [*sorted(here.glob("*.py")), *kernels]
    files += [numerics / "rodas5p.py", numerics / "dop853.py"]
    return hashlib.sha256(b"\n".join(file.read_bytes() for file in files)).hexdigest()


def loop_name() -> str:
    """Begin of the name of the time loop's code: a folder of its own."""
    return f"loop-{own()[:16]}/"


def load(key: str) -> bytes | None:
    """Code saved under a key; None if there is none, or only a damaged file."""
    try:
        held = (folder() / key).read_bytes()
    except OSError:
        return None
    head = len(_MARK) + 32
    code = held[head:]
    if not held.startswith(_MARK) or hashlib.sha256(code).digest() != held[len(_MARK) : head]:
        return None
    return code


def save(key: str, code: bytes) -> None:
    """Save code under a key; does nothing if the folder cannot be written."""
    with suppress(OSError):
        place = folder() / key
        place.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(place) as file:
            file.write(_MARK + hashlib.sha256(code).digest() + code)
