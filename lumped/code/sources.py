"""What compiled code is made from: modules, found by their imports, and packages beside them."""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path

__all__ = ["hash_of_all", "imported"]

_BEGINS = ("lumped.kernel.engine", "lumped.code.functions")
"""Modules that compile kernels and functions of plants."""

_PACKAGE = Path(__file__).parent.parent
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]+))", re.M
)
_NAME = re.compile(r"(\w[\w.]*)(?:[ \t]+as[ \t]+\w+)?[ \t]*(?:,|$)", re.M)


def _names(text: str) -> Iterator[str]:
    """All that a module's imports name, anywhere in it; what is no module is no harm."""
    for source, names, modules in _IMPORT.findall(text):
        if source:
            yield source
            yield from (f"{source}.{name}" for name in _NAME.findall(names.strip("() ")))
        else:
            yield from _NAME.findall(modules)


def _file(module: str) -> Path | None:
    place = os.path.join(_PACKAGE, *module.split(".")[1:])
    found = (os.path.join(place, "__init__.py"), f"{place}.py")
    return next((Path(file) for file in found if os.path.isfile(file)), None)


def imported() -> tuple[dict[str, Path], list[str]]:
    """Modules of lumped that compiled code is made from, and other packages that these import."""
    waiting, files, others = list(_BEGINS), dict[str, Path](), set[str]()
    seen = {""}
    while waiting:
        if (module := waiting.pop()) in seen:
            continue
        seen.add(module)
        if (file := _file(module)) is None:
            continue
        files[module] = file
        waiting.append(module.rpartition(".")[0])
        for name in _names(file.read_text(encoding="utf-8")):
            first = name.partition(".")[0]
            if first == _PACKAGE.name:
                waiting.append(name)
            elif first not in sys.stdlib_module_names:
                others.add(first)
    return dict(sorted(files.items())), sorted(others)


@cache
def hash_of_all() -> str:
    """Hash of these modules, and of the versions of Python and of the packages."""
    files, others = imported()
    parts = [sys.version, *(f"{name} {version(name)}" for name in others)]
    texts = [part.encode() for part in parts]
    texts += [module.encode() + file.read_bytes() for module, file in files.items()]
    return hashlib.sha256(b"\n".join(texts)).hexdigest()
