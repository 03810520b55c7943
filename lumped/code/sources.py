"""What compiled code is made from: modules, found by their imports, and packages beside them."""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

_BEGINS = ("lumped.kernel.engine", "lumped.code.functions")
"""Modules that compile kernels and functions of plants."""

_PACKAGE = Path(__file__).parent.parent
# a line break is found much faster than the begin of a line
_IMPORT = re.compile(
    r"\n[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]+))"
)
_NAME = re.compile(r"(\w[\w.]*)(?:[ \t]+as[ \t]+\w+)?[ \t]*(?:,|$)", re.M)


class _Modules:
    """Modules of lumped, found with one look at each folder."""

    def __init__(self) -> None:
        self._folders: dict[str, frozenset[str]] = {}

    @staticmethod
    def _place(module: str) -> str:
        return os.path.join(_PACKAGE, *module.split(".")[1:])

    def _list_folder(self, package: str) -> frozenset[str]:
        """What the folder of a package holds; nothing if it is none."""
        if package not in self._folders:
            outer, _, name = package.rpartition(".")
            place = self._place(package)
            is_folder = not outer or (name in self._list_folder(outer) and os.path.isdir(place))
            self._folders[package] = frozenset(os.listdir(place) if is_folder else ())
        return self._folders[package]

    def is_package(self, module: str) -> bool:
        return "__init__.py" in self._list_folder(module)

    def find_names(self, text: str) -> Iterator[str]:
        """All that a module's imports name, anywhere in it; what is no module is no harm."""
        for source, names, modules in _IMPORT.findall(f"\n{text}"):
            if not source:
                yield from _NAME.findall(modules)
                continue
            yield source
            if source.partition(".")[0] == _PACKAGE.name and self.is_package(source):
                yield from (f"{source}.{name}" for name in _NAME.findall(names.strip("() ")))

    def file(self, module: str) -> str | None:
        if self.is_package(module):
            return os.path.join(self._place(module), "__init__.py")
        outer, _, name = module.rpartition(".")
        return f"{self._place(module)}.py" if f"{name}.py" in self._list_folder(outer) else None


def find_imports() -> tuple[dict[str, bytes], list[str]]:
    """Modules of lumped that compiled code is made from with their texts, and other packages."""
    waiting, texts, others = list(_BEGINS), dict[str, bytes](), set[str]()
    modules, seen = _Modules(), set[str]()
    while waiting:
        if (module := waiting.pop()) in seen:
            continue
        seen.add(module)
        first = module.partition(".")[0]
        if first != _PACKAGE.name:
            others |= {first} - {""} - sys.stdlib_module_names
        elif file := modules.file(module):
            with open(file, "rb") as held:
                texts[module] = held.read()
            waiting.append(module.rpartition(".")[0])
            waiting += modules.find_names(texts[module].decode())
    return dict(sorted(texts.items())), sorted(others)


def version(package: str) -> str:
    """Version of a package, which compiled code needs loaded in any case."""
    return str(import_module(package).__version__)


@cache
def hash_of_all() -> str:
    """Hash of these modules, and of the versions of Python and of the packages."""
    modules, others = find_imports()
    parts = [sys.version, *(f"{name} {version(name)}" for name in others)]
    texts = [part.encode() for part in parts]
    texts += [module.encode() + text for module, text in modules.items()]
    return hashlib.sha256(b"\n".join(texts)).hexdigest()
