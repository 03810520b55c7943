"""C sources compiled: by the compiler of this machine, or for another platform by Zig's."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from lumped.code import code_cache
from lumped.errors import ExportError
from lumped.support.optional_packages import extra

_TUNED, _PLAIN = "-O2", "-O1"
"""Of the time loop, which is kept; of all that is compiled for each model. That takes half as long
and makes no run slower by more than 2 %."""


class Linked(NamedTuple):
    """What is made: options of the compiler and of the linker, suffix of the file."""

    compile: tuple[str, ...]
    link: tuple[str, ...]
    suffix: str


def own_compiler() -> list[str] | None:
    """Command of the compiler of this machine: ``CC``, or ``cc``; None if there is none."""
    found = os.environ.get("CC") or shutil.which("cc")
    return found.split() if found else None


def zig_compiler(target: str, call: str) -> list[str]:
    """Command of Zig's C compiler for a target, such as ``wasm32-wasi``.

    Raises
    ------
    OptionError
        If the package ziglang is not installed; `call` is what needs it.
    """
    extra("ziglang", "cross", call)
    return [sys.executable, "-m", "ziglang", "cc", f"--target={target}"]


def compile_sources(
    files: Mapping[str, str], sources: Iterable[str], compiler: list[str], made: Linked
) -> bytes:
    """What a compiler makes of the sources; the time loop is compiled once and kept.

    Raises
    ------
    ExportError
        If the compiler cannot be run or refuses the sources.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        command = [*compiler, "-std=c99", "-ffp-contract=off", *made.compile]
        _compile_loop(
            [*command, _TUNED], _call([*compiler, "--version"], folder), files["loop.c"], folder
        )
        # as one source: compilers read the headers once
        others = "".join(f'#include "{name}"\n' for name in sources if name != "loop.c")
        (Path(folder) / "others.c").write_text(others, encoding="utf-8")
        _call([*command, _PLAIN, "-c", "others.c", "-o", "others.o"], folder)
        result = f"model{made.suffix}"
        _call([*command, "-o", result, "loop.o", "others.o", *made.link], folder)
        return (Path(folder) / result).read_bytes()


def _compile_loop(command: list[str], version: str, text: str, folder: str) -> None:
    """Object code of the time loop, which is the same in all units: compiled once and kept."""
    made = Path(folder) / "loop.o"
    key = hashlib.sha256("|".join([version, *command, text]).encode()).hexdigest()
    code = code_cache.load(code_cache.loop_name() + key)
    if code is None:
        _call([*command, "-c", "loop.c", "-o", "loop.o"], folder)
        code_cache.save(code_cache.loop_name() + key, made.read_bytes())
    else:
        made.write_bytes(code)


def _call(command: list[str], folder: str) -> str:
    """What a compiler says."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except OSError as error:
        raise ExportError(f"the C compiler cannot be run: {error}") from None
    if done.returncode:
        name = "Zig's compiler" if "ziglang" in command else command[0]
        raise ExportError(f"{name} refuses the sources:\n{done.stderr.strip()[:2000]}")
    return done.stdout
