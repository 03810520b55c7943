"""Shared libraries of a unit: for this machine, or for others by Zig's compiler."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from lumped.errors import OptionError
from lumped.exchange.c_compiler import Linked, compile_sources, own_compiler, zig_compiler

_SYSTEMS = {
    "linux": ("linux-gnu.2.17", ".so", ("-fPIC",)),
    "windows": ("windows-gnu", ".dll", ()),
    "darwin": ("macos", ".dylib", ("-fPIC",)),
}
"""Zig's target, suffix of shared libraries, options of the compiler."""
_MACHINES = ("x86_64", "aarch64")
_SHORT = {"x86_64-linux": "linux64", "x86_64-windows": "win64", "x86_64-darwin": "darwin64"}
"""Names in version 2.0 of the interface, which knows no others."""


class Library(NamedTuple):
    """A shared library: folder of its platform, suffix of its file, its bytes."""

    folder: str
    suffix: str
    content: bytes


def platforms_of(version: str, asked: Iterable[str]) -> tuple[str, ...]:
    """Names of platforms, each once, as machine and system.

    Parameters
    ----------
    version : {"2.0", "3.0"}
        Of the interface.
    asked : iterable of str
        Their names in this version.

    Raises
    ------
    OptionError
        If this version has no such platform.
    """
    known = [f"{machine}-{system}" for machine in _MACHINES for system in _SYSTEMS]
    named = {_folder(version, name): name for name in known if version == "3.0" or name in _SHORT}
    wanted = tuple(dict.fromkeys(asked))
    for name in wanted:
        if name not in named:
            raise OptionError(
                f"export_fmu: platforms = {wanted!r}: FMI {version} has no platform {name!r}; "
                f"choose from {', '.join(named)}."
            )
    return tuple(named[name] for name in wanted)


def libraries(
    files: Mapping[str, str],
    sources: Sequence[str],
    version: str,
    platforms: Sequence[str],
) -> list[Library]:
    """Libraries for platforms; without any, for this machine, if it has a compiler.

    Raises
    ------
    OptionError
        If Zig's compiler is needed and not installed.
    ExportError
        If a compiler refuses the sources.
    """
    own = None if platforms else own_compiler()
    found = []
    for name in platforms or ([_own_platform()] if own else []):
        machine, _, system = name.partition("-")
        target, suffix, options = _SYSTEMS[system]
        compiler = own or zig_compiler(f"{machine}-{target}", "export_fmu(platforms=)")
        strip = () if own and system == "darwin" else ("-s",)  # Apple's linker knows no -s
        link = "-shared", "-lm", *strip
        made = Linked((*options, "-fvisibility=hidden"), link, suffix)
        content = compile_sources(files, sources, compiler, made)
        found.append(Library(_folder(version, name), suffix, content))
    return found


def _folder(version: str, name: str) -> str:
    return _SHORT.get(name, name) if version == "2.0" else name


def _own_platform() -> str:
    """That of this machine."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{machine}-{system}"
