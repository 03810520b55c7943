"""Object code on disk, found again by the hash of its source."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import warnings
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

from lumped.code.sources import hash_of_all
from lumped.support.whole_files import whole_file

_MARK = b"lumped-1"
_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH


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


def loop_name() -> str:
    """Begin of the name of the time loop's code: a folder of its own."""
    return f"loop-{hash_of_all()[:16]}/"


def _is_own(status: os.stat_result) -> bool:
    """Whether nobody but this user, or root, can have written a file or folder."""
    if not hasattr(os, "geteuid"):
        return True
    return status.st_uid in (os.geteuid(), 0) and not status.st_mode & _BY_OTHERS


@cache
def _warn(place: Path) -> None:
    warnings.warn(
        f"{place} belongs to another user, or others may write there, so it is not used: compiled "
        "code is executed. Code is made anew in each process. Give LUMPED_CACHE a folder of your "
        f"own, or take the right to write away (chmod -R go-w {folder()}).",
        RuntimeWarning,
        stacklevel=2,
    )


def _may_use(places: Iterable[Path]) -> bool:
    """Whether folders may be trusted; warns once of the first that may not."""
    for place in places:
        if not _is_own(place.stat()):
            _warn(place)
            return False
    return True


def load(key: str) -> bytes | None:
    """Code saved under a key; None if there is none, a damaged file, or one that others wrote."""
    try:
        place = folder() / key
        with place.open("rb") as file:
            if not _may_use((folder(), place.parent)):
                return None
            if not _is_own(os.fstat(file.fileno())):
                _warn(place)
                return None
            held = file.read()
    except OSError:
        return None
    head = len(_MARK) + 32
    code = held[head:]
    if not held.startswith(_MARK) or hashlib.sha256(code).digest() != held[len(_MARK) : head]:
        return None
    return code


def save(key: str, code: bytes) -> None:
    """Save code under a key; does nothing if the folder cannot be written or trusted."""
    with suppress(OSError):
        place = folder() / key
        folder().parent.mkdir(parents=True, exist_ok=True)
        for own in (folder(), place.parent):
            own.mkdir(mode=0o755, exist_ok=True)
        if _may_use((folder(), place.parent)):
            with whole_file(place) as file:
                if hasattr(os, "fchmod"):
                    os.fchmod(file.fileno(), os.fstat(file.fileno()).st_mode & ~_BY_OTHERS)
                file.write(_MARK + hashlib.sha256(code).digest() + code)
