"""Object code on disk, found again by what it was made from."""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from functools import cache
from pathlib import Path

__all__ = ["load", "loop_name", "own", "save", "stored"]

_MARK = b"lumped-1"


def folder() -> Path:
    """Where object code is kept: ``LUMPED_CACHE``, or a folder of the user's caches."""
    given = os.environ.get("LUMPED_CACHE")
    if given:
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library/Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "lumped"


@cache
def own() -> str:
    """Hash of what all code depends on in this package."""
    here = Path(__file__).parent
    files = [*sorted(here.glob("*.py")), here.parent / "rodas5p.py"]
    return hashlib.sha256(b"\n".join(file.read_bytes() for file in files)).hexdigest()


def loop_name() -> str:
    """Begin of the name of the time loop's code."""
    return f"loop-{own()[:16]}-"


def stored(prefix: str) -> bool:
    """Whether there is anything under a name that begins so."""
    try:
        return any(path.name.startswith(prefix) for path in folder().iterdir())
    except OSError:
        return False


def load(key: str) -> bytes | None:
    """What was saved under a key; None if there is nothing, or nothing whole."""
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
    """Keep something; without a word if the folder cannot be written."""
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=place)
        with os.fdopen(handle, "wb") as file:
            file.write(_MARK + hashlib.sha256(code).digest() + code)
        os.replace(name, place / key)
    except OSError:
        return
