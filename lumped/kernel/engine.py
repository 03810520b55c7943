"""The time loop, ready to be called: compiled by LLVM, as C, or unchanged in Python.

All three give the same bits. Runs use LLVM, exported units the C; Python is for a debugger and for
tests.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from lumped.code import code_cache, shipped
from lumped.code.machine_code import Code, load_or_compile
from lumped.code.records import Record, address
from lumped.code.sources import hash_of_all
from lumped.support.process_lock import process_lock

Engine = Literal["llvm", "c", "python"]
_T = TypeVar("_T")


def _once(function: Callable[[], _T]) -> Callable[[], _T]:
    """Keep what a function gives; of threads that ask first, all wait for one.

    Two of them would otherwise load code twice, and one copy would vanish while it is called.
    """
    kept = cache(function)

    @wraps(function)
    def call_once() -> _T:
        with process_lock:
            return kept()

    return call_once


_engine: ContextVar[Engine] = ContextVar("engine", default="llvm")


@contextmanager
def using(engine: Engine) -> Iterator[None]:
    """Use another engine for the runs of this thread in a ``with`` block."""
    before = _engine.set(engine)
    try:
        yield
    finally:
        _engine.reset(before)


def call(name: str, *given: Record | np.ndarray) -> int:
    """Call an entry with records and arrays."""
    engine = _engine.get()
    if engine == "python":
        with np.errstate(all="ignore"):
            return int(_kernels()[name](*given))
    entry = _ready[engine].get(name) or _entry(engine, name, len(given))
    return entry(*[address(held) for held in given])


@_once
def time_loop() -> Code:
    """The time loop compiled by LLVM."""
    return shipped.load_code("loop") or load_or_compile(
        hash_of_all(), lambda: (_loop_assembly(),), code_cache.loop_name()
    )


def _loop_assembly() -> str:
    from lumped.code.to_llvm import as_llvm

    return as_llvm(_kernels())


LANES = 8
"""Runs side by side: as many numbers as one register of 512 bits holds, or two of 256."""


@_once
def lanes() -> Callable[[int], int]:
    """The loop for runs side by side, compiled by LLVM; takes the address of a `Lanes`."""
    name = code_cache.loop_name() + "lanes-"
    source = f"{LANES} {hash_of_all()}"
    code = shipped.load_code("lanes") or load_or_compile(source, lambda: (_lanes_assembly(),), name)
    made = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(code.address("lanes"))
    _kept.append(code)
    return made


def _lanes_assembly() -> str:
    from lumped.code.to_llvm import as_llvm
    from lumped.kernel.many_runs.lanes import COUNTERPARTS, ENTRIES

    return as_llvm(ENTRIES, LANES, COUNTERPARTS)


ASSEMBLY = {"loop": _loop_assembly, "lanes": _lanes_assembly}
"""What a wheel brings along as machine code."""


def entry_address(name: str) -> int:
    """Address of an entry of the loop (see `lumped.kernel.entries`)."""
    return time_loop().address(name)


def is_compiled() -> bool:
    """Whether runs of this thread use machine code by LLVM, which lanes need."""
    return _engine.get() == "llvm"


_kept: list[Code] = []
_ready: dict[Engine, dict[str, Callable[..., int]]] = {"llvm": {}, "c": {}}
"""Entries that were called, by engine."""


def _kernels() -> dict[str, Any]:
    # imported only when the loop is compiled
    from lumped.kernel.entries import ENTRIES

    return ENTRIES


def _entry(engine: Engine, name: str, arguments: int) -> Callable[..., int]:
    kind = ctypes.CFUNCTYPE(ctypes.c_int64, *[ctypes.c_void_p] * arguments)
    found = kind(entry_address(name)) if engine == "llvm" else kind((name, _c_library()))
    _ready[engine][name] = found
    return found


@_once
def _c_library() -> ctypes.CDLL:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise OSError("there is no C compiler")
    from lumped.code.to_c import as_c

    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder) / "loop.c", Path(folder) / "loop.so"
        source.write_text(as_c(_kernels()))
        options = ["-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
        subprocess.run([compiler, *options, str(source), "-o", str(made), "-lm"], check=True)
        return ctypes.CDLL(str(made))
