"""Whether two results come from the same model, functions and options: one hash for all of that."""

from __future__ import annotations

import dis
import functools
import hashlib
import sys
import sysconfig
import types
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

import casadi as ca
import numpy as np

from lumped.compiler.energies import ENERGIES, told
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.flattening.template import template_key
from lumped.flattening.template_cache import content_of
from lumped.language.component import Component
from lumped.language.declared import place_of, values_of


def fingerprint(what: object) -> str:
    """Hash of all on which results depend.

    Of a system these are its equations with their tables, conditions, holds and jumps, the
    instants of functions of time, connections, start values, the choice of states, what its
    components say of their energy, and the version of lumped; values of parameters do not count.
    Of a function it is its code, with the functions and values that it uses, and theirs; what
    belongs to an installed package counts by its name and version.

    Parameters
    ----------
    what : object
        A system; or a function, an option, or a collection of such.

    Raises
    ------
    OptionError
        If something in it has no content that can be read, such as an open file.
    """
    return _Hashing().of(what).hex()[:16]


_PLAIN = (bool, int, float, complex, str, bytes, range, PurePath, np.generic)
"""What says all of itself when it is printed."""
_MADE_OF: dict[type, tuple[str, ...]] = {
    staticmethod: ("__func__",),
    classmethod: ("__func__",),
    property: ("fget", "fset", "fdel"),
    functools.partial: ("func", "args", "keywords"),
    types.MethodType: ("__func__", "__self__"),
}
"""What consists of these attributes."""


class _Hashing:
    """Hashes of values, each made once.

    What contains itself, such as a function that calls itself, is named by how far above it is.
    """

    def __init__(self) -> None:
        self._known: dict[int, bytes] = {}
        self._above: list[int] = []
        self._held: list[object] = []

    def of(self, value: object) -> bytes:
        """Hash of a value."""
        key = id(value)
        if key in self._known:
            return self._known[key]
        if key in self._above:
            return f"above {len(self._above) - self._above.index(key)}".encode()
        self._above.append(key)
        try:
            parts = [type(value).__name__.encode(), *self._parts(value)]
        finally:
            self._above.pop()
        found = hashlib.sha256(b"".join(len(p).to_bytes(8, "big") + p for p in parts)).digest()
        self._known[key] = found
        self._held.append(value)  # else its place may be taken by another
        return found

    def _parts(self, value: Any) -> Iterator[bytes]:
        """What a value consists of."""
        if value is None or isinstance(value, _PLAIN):
            yield repr(value).encode()
        elif isinstance(value, np.ndarray) and value.dtype != object:
            yield from (repr((value.dtype.str, value.shape)).encode(), value.tobytes())
        elif isinstance(value, System):
            yield from _of_system(value)
            if len(self._above) > 1:  # used by a function, which may read them
                yield value.structure.parameters.defaults.tobytes()
        elif isinstance(value, Component):
            yield from map(self.of, (type(value), values_of(value), place_of(value)))
        elif isinstance(value, tuple(_MADE_OF)):
            names = next(names for kind, names in _MADE_OF.items() if isinstance(value, kind))
            yield from (self.of(getattr(value, name)) for name in names)
        elif isinstance(value, types.ModuleType):
            yield _name_version(value.__name__)
        elif isinstance(value, type):
            yield from self._class(value)
        elif isinstance(value, types.CodeType):
            yield from self._code(value)
        elif isinstance(value, types.FunctionType):
            yield from self._function(value)
        elif isinstance(value, types.BuiltinFunctionType | np.ufunc):
            yield value.__name__.encode()
            yield self.of(getattr(value, "__self__", None))
        elif isinstance(value, types.CellType):
            yield self.of(_content(value))
        elif isinstance(value, list | tuple):
            yield from map(self.of, value)
        elif isinstance(value, Mapping | set | frozenset):
            pairs = value.items() if isinstance(value, Mapping) else ((v, None) for v in value)
            yield from sorted(self.of(k) + self.of(v) for k, v in pairs)
        else:
            yield from self._object(value)

    def _function(self, value: types.FunctionType) -> Iterator[bytes]:
        if _is_installed(value.__module__ or ""):
            yield _name_version(value.__module__)
            yield value.__qualname__.encode()
            return
        yield self.of(value.__code__)
        yield from map(self.of, (value.__defaults__, value.__kwdefaults__, value.__closure__))
        for name in sorted(_globals(value.__code__)):
            yield name.encode()
            if name in value.__globals__:
                yield self.of(value.__globals__[name])

    def _code(self, value: types.CodeType) -> Iterator[bytes]:
        """Instructions and what they hold; not where they were written."""
        yield value.co_code
        yield repr((value.co_names, value.co_varnames, value.co_freevars)).encode()
        yield from map(self.of, value.co_consts)

    def _class(self, value: type) -> Iterator[bytes]:
        yield value.__qualname__.encode()
        if _is_installed(value.__module__ or ""):
            yield _name_version(value.__module__)
            return
        yield from map(self.of, value.__bases__)
        dropped = ("__dict__", "__weakref__", "__doc__", "__module__")
        own = {n: v for n, v in vars(value).items() if n not in dropped}
        own = {n: v for n, v in own.items() if not isinstance(v, types.MemberDescriptorType)}
        for name in sorted(own):
            yield name.encode()
            yield self.of(own[name])

    def _object(self, value: Any) -> Iterator[bytes]:
        """Anything else by what it would be made from again."""
        try:
            made = value.__reduce_ex__(4)
        except Exception as fault:
            raise OptionError(
                f"{value!r} of type {type(value).__name__} has no content that can be compared "
                f"({fault}), so results that depend on it cannot be found again in a file."
            ) from None
        for part in [made] if isinstance(made, str) else made:
            yield self.of(list(part) if isinstance(part, Iterator) else part)


def _content(cell: types.CellType) -> object:
    try:
        return cell.cell_contents
    except ValueError:  # not given yet
        return None


def _globals(code: types.CodeType) -> set[str]:
    """Names that code looks up outside of functions, also from functions inside."""
    looks = ("LOAD_GLOBAL", "LOAD_NAME")
    found = {i.argval for i in dis.get_instructions(code) if i.opname in looks}
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found |= _globals(constant)
    return found


@functools.cache
def _is_installed(module: str) -> bool:
    """Whether a module belongs to an installed package, the interpreter or lumped."""
    top = module.partition(".")[0]
    if top == "lumped" or top in sys.stdlib_module_names:
        return True
    file = getattr(sys.modules.get(module), "__file__", None)
    if file is None:
        return False
    folders = {sysconfig.get_path(name) for name in ("purelib", "platlib")}
    return any(Path(file).is_relative_to(folder) for folder in folders)


@functools.cache
def _name_version(module: str) -> bytes:
    """A module with the version of its package."""
    return f"{module} {_version(module.partition('.')[0])}".encode()


def _version(package: str) -> str:
    version = getattr(sys.modules.get(package), "__version__", None)
    if version is None:
        import importlib.metadata  # takes long to load, and is needed rarely

        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            version = sys.version
    return str(version)


def _of_system(system: System) -> Iterator[bytes]:
    flat, tree = system.structure.flat, system.structure.tree
    _, outputs, kept = system.origin
    yield _name_version("lumped")
    yield repr((outputs, kept, sorted(system.structure.ranks.items()), sorted(tree.freed))).encode()
    for node in tree.instances:
        yield node.path.encode()
    for layout in dict.fromkeys(node.layout for node in tree.instances):
        rows = [(n, q.kind, q.nominal, q.wish) for n, q in _rows(layout)]
        yield repr((rows, list(layout.parameters))).encode()
    for group in (*flat.groups, *flat.initial):
        yield repr((group.template.content, group.unknowns.shape, group.parameters.shape)).encode()
        yield from (group.unknowns.tobytes(), group.parameters.tobytes())
    joints, p = flat.joints, flat.parameters
    sums = [(unknowns, signs) for unknowns, signs, _ in joints.sums]
    equal = [(a, b) for a, b, _ in joints.equal]
    yield repr((equal, sums, [u for u, _ in joints.grounded])).encode()
    values = [p.values, *flat.given.values(), *flat.starts.values()]
    limits = [(number, name) for number, _, name, _ in p.ordered]
    yield repr((list(flat.given), list(flat.starts), p.names, p.free, limits)).encode()
    values += [least for _, least, *_ in p.ordered]
    yield ca.Function("values", [p.theta], [ca.vertcat(*values)]).serialize().encode()
    yield from _energies(system)


def _rows(layout: Any) -> Iterator[tuple[str, Any]]:
    return zip(layout.names, layout.quantities, strict=True)


def _energies(system: System) -> Iterator[bytes]:
    """What components say that they store and lose."""
    tree = system.structure.tree
    for node in {template_key(node.component): node for node in tree.instances}.values():
        for name in ENERGIES:
            expression = told(node, name)
            if expression is not None:
                result = content_of(expression, lambda c, n=node: tree.below(c, n))  # type: ignore[misc]
                yield repr((node.path, name, result)).encode()
