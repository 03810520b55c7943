"""What compiled code is made from: modules, and packages beside them."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

_PACKAGE = Path(__file__).parent.parent
_PARTS = ("code", "kernel", "numerics", "support", "flattening/hold_modes.py")
"""Folders and a file with all modules of lumped that kernels and their translators import."""
PACKAGES = ("casadi", "llvmlite", "numpy")


def find_files() -> Iterator[Path]:
    """Files of all these modules, in order."""
    for part in _PARTS:
        place = _PACKAGE / part
        yield from sorted(place.rglob("*.py")) if place.is_dir() else [place]


def version(package: str) -> str:
    """Version of a package, which compiled code needs loaded in any case."""
    return str(import_module(package).__version__)


@cache
def hash_of_modules() -> str:
    """Hash of these modules."""
    texts = []
    for file in find_files():
        texts += [file.relative_to(_PACKAGE).as_posix().encode(), file.read_bytes()]
    return hashlib.sha256(b"\n".join(texts)).hexdigest()


@cache
def hash_of_all() -> str:
    """Hash of these modules, and of the versions of Python and of the packages."""
    parts = [sys.version, *(f"{name} {version(name)}" for name in PACKAGES), hash_of_modules()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
