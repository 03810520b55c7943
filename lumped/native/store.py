"""Object code on disk, found again by what it was made from."""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from pathlib import Path

__all__ = ["load", "save"]

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
