"""The time loop, ready to be called: compiled by LLVM, as C, or unchanged in Python.

All three give the same bits. Runs use LLVM, exported units the C; Python is for a debugger and for
tests.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from lumped.code import code_cache
from lumped.code.machine_code import Code, built
from lumped.code.records import Record, address
from lumped.code.sources import hash_of_all
from lumped.code.to_c import as_c
from lumped.code.to_llvm import as_llvm
from lumped.support.process_lock import process_lock

__all__ = ["LANES", "call", "entry_addresses", "is_compiled", "lanes", "using"]

Engine = Literal["llvm", "c", "python"]
_T = TypeVar("_T")


ARGUMENTS = {
    "loop": 1,
    "begin": 1,
    "calm_positions": 1,
    "find_positions": 1,
    "value": 3,
    "values": 3,
    "closed": 1,
    "converged": 1,
    "watched": 1,
    "prepared": 1,
    "replayed": 2,
    "looked": 3,
    "listed": 2,
    "swept": 4,
    "variants": 1,
    "until_steps_of": 1,
    "attempt_of": 1,
    "crossing_of": 1,
    "look_of": 1,
    "end_of": 1,
    "count_all": 2,
    "sum_damage": 3,
}
"""Number of arguments of each entry (see `lumped.kernel.entries`)."""


def _once(function: Callable[..., _T]) -> Callable[..., _T]:
    """Keep what a function gives; of threads that ask first, all wait for one.

    Two of them would otherwise load code twice, and one copy would vanish while it is called.
    """
    kept = cache(function)

    @wraps(function)
    def found(*args: Engine) -> _T:
        with process_lock:
            return kept(*args)

    return found


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
    entry = (_ready.get(engine) or _entries(engine))[name]
    return entry(*[address(held) for held in given])


@_once
def time_loop() -> Code:
    """The time loop compiled by LLVM."""
    name = code_cache.loop_name()
    return built(hash_of_all(), list(ARGUMENTS), lambda: as_llvm(_kernels()), name)


LANES = 8
"""Runs side by side: as many numbers as one register of 512 bits holds, or two of 256."""


@_once
def lanes() -> Callable[[int], int]:
    """The loop for runs side by side, compiled by LLVM; takes the address of a `Lanes`."""
    from lumped.kernel.many_runs.lanes import COUNTERPARTS, ENTRIES

    name = code_cache.loop_name() + "lanes-"
    source = f"{LANES} {hash_of_all()}"
    code = built(source, list(ENTRIES), lambda: as_llvm(ENTRIES, LANES, COUNTERPARTS), name)
    made = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(code.addresses["lanes"])
    _kept.append(code)
    return made


def entry_addresses() -> Mapping[str, int]:
    """Addresses of the entries of the loop, by their names."""
    return time_loop().addresses


def is_compiled() -> bool:
    """Whether runs of this thread use machine code by LLVM, which lanes need."""
    return _engine.get() == "llvm"


_kept: list[Code] = []
_ready: dict[Engine, dict[str, Callable[..., int]]] = {}
"""Entries that were loaded, by engine."""


def _kernels() -> dict[str, Any]:
    # imported only when the loop is compiled
    from lumped.kernel.entries import ENTRIES

    return ENTRIES


@_once
def _entries(engine: Engine) -> dict[str, Callable[..., int]]:
    types = {name: [ctypes.c_void_p] * count for name, count in ARGUMENTS.items()}
    if engine == "llvm":
        addresses = time_loop().addresses
        _ready[engine] = {
            n: ctypes.CFUNCTYPE(ctypes.c_int64, *t)(addresses[n]) for n, t in types.items()
        }
        return _ready[engine]
    library = _c_library()
    found: dict[str, Callable[..., int]] = {}
    for name, arguments in types.items():
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_int64, arguments
        found[name] = function
    _ready[engine] = found
    return found


def _c_library() -> ctypes.CDLL:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise OSError("there is no C compiler")
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder) / "loop.c", Path(folder) / "loop.so"
        source.write_text(as_c(_kernels()))
        options = ["-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
        subprocess.run([compiler, *options, str(source), "-o", str(made), "-lm"], check=True)
        return ctypes.CDLL(str(made))
