"""Packages whose public names load when they are first used.

The list of names is the stub beside the package, ``__init__.pyi``: one line for each name, such as
``from lumped.vibration.natural.find_modes import modes as modes``. Type checkers, editors and the
package read the same lines.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

_ALIKE = 0.6
"""Likeness of two names, at most 1, above which one may be the other misspelt."""
_LIBRARIES = ("components", "models")
"""Packages that build on the core; the core does not have them as names."""


def lazy_names(package: str) -> tuple[str, ...]:
    """Give a package the names of its stub; each loads its module when first used.

    Parameters
    ----------
    package : str
        Its ``__name__``.

    Returns
    -------
    tuple of str
        The names, for ``__all__``.
    """
    module = sys.modules[package]
    names = sources(package)
    vars(module)["_sources"] = names
    module.__class__ = _LazyPackage
    return tuple(sorted(names))


def sources(package: str) -> dict[str, str]:
    """Public names of a loaded package, and the module from which each comes.

    Parameters
    ----------
    package : str
        Name of the package.

    Returns
    -------
    dict
        A module that is public itself comes from its package.
    """
    stub = Path(str(sys.modules[package].__file__)).with_suffix(".pyi")
    lines = ast.parse(stub.read_text(encoding="utf-8")).body
    imports = [line for line in lines if isinstance(line, ast.ImportFrom)]
    return {alias.name: str(line.module) for line in imports for alias in line.names}


class _LazyPackage(ModuleType):
    """A package that loads its public names, lists no others, and knows where else a name is."""

    _sources: dict[str, str]

    def __getattr__(self, name: str) -> Any:
        if name not in self._sources:
            raise AttributeError(_missing(self.__name__, name), name=name)
        source = self._sources[name]
        if source == self.__name__:
            value: Any = import_module(f"{source}.{name}")
        else:
            value = getattr(import_module(source), name)
        vars(self)[name] = value
        return value

    def __dir__(self) -> list[str]:
        return sorted(self._sources)

    def __setattr__(self, name: str, value: object) -> None:
        # A package gets each of its modules as an attribute when it loads. The module `modes` must
        # not hide the function `modes`, whichever is loaded first.
        if not (name in self._sources and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __reduce__(self) -> tuple[Callable[[str], ModuleType], tuple[str]]:
        # Functions pickled with the objects they use refer to these by name, as to other packages.
        return import_module, (self.__name__,)


def _missing(package: str, name: str) -> str:
    """Text for a name that a package does not have: where it is, or which one may be meant."""
    text = f"{package} has no '{name}'."
    if name.startswith("_"):
        return text
    core = package.partition(".")[0]
    if package == core and name in _LIBRARIES:
        return f"{text} Write 'from {core}.{name} import ...'."
    themes = [theme for theme, source in sources(core).items() if _is_theme(core, theme, source)]
    places: dict[str, str] = {}
    for place in dict.fromkeys((package, core, *(f"{core}.{theme}" for theme in themes))):
        for known in sources(import_module(place).__name__):
            places.setdefault(known, f"{place}.{known}")
    if name in places:
        return f"{text} It is {places[name]}."
    if near := get_close_matches(name, places, 1, _ALIKE):
        return f"{text} Did you mean {places[near[0]]}?"
    return f"{text} dir({package}) lists its names; components stand in {core}.components."


def _is_theme(core: str, name: str, source: str) -> bool:
    return source == core and isinstance(import_module(f"{core}.{name}"), _LazyPackage)
