"""A system as machine code: its functions compiled, its tables laid out for the time loop."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec

import numpy as np

from lumped.compiler.system import System
from lumped.kernel import layout as at
from lumped.kernel.blocks import MOST_DENSE, Sizes, laid_out
from lumped.kernel.code_cache import loop_name, stored
from lumped.kernel.emit_llvm import UnsupportedError
from lumped.timeloop.guards import levers

__all__ = ["Machine", "begun", "machine", "patience"]

_AT_LEAST, _EACH, _RUN, _COMPILING = 0.04, 1e-4, 0.05, 2.5
"""Time to make machine code, at least and for each operation, what a run before counts, and time
to compile the time loop, s."""

_READY: list[bool] = []
"""Not empty as soon as the time loop is known to be compiled."""

_HALF = 500_000_000
"""Operations in half a second."""

_CALL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)


@dataclass
class Machine:
    """A system compiled.

    Attributes
    ----------
    system : System
        Which.
    integers : ndarray of int64
        The block of integers as every run begins with it.
    count : int
        Numbers in the other block.
    signs, table : ndarray
        Of the states that jumps change; settings of the pieces of tables.
    attempts : int
        Steps between two visits to Python, about half a second.
    """

    system: System
    integers: np.ndarray
    count: int
    signs: np.ndarray
    table: np.ndarray
    attempts: int
    _codes: list[object]

    def blocks(
        self, theta: np.ndarray, x: np.ndarray, settings: np.ndarray, span: float, more: int = 0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Blocks for one run, with room for some numbers more at the end of the second.

        Parameters
        ----------
        span : float
            Size of the times of the run, s.
        """
        z, r = self.integers.copy(), np.zeros(self.count + more)
        for place, values in (
            (at.P, theta),
            (at.X, x),
            (at.M, settings),
            (at.SIGNS, self.signs),
            (at.TABLE, self.table),
        ):
            r[z[place] : z[place] + len(values)] = values
        r[at.UNTIL], r[at.SOON], r[at.SHORTEST] = span, 1e-12 * span, 1e-10 * span
        return z, r

    def ask(self, z: np.ndarray, r: np.ndarray) -> None:
        """Note whether constraints may be redundant, which a run then watches."""
        count, first = int(z[at.NH]), int(z[at.WISH])
        if count:
            r[first : first + count] = _any_accelerations(count)
            self("doubt", z, r)

    def __call__(self, name: str, z: np.ndarray, r: np.ndarray) -> int:
        """Call a function of the time loop with the blocks of a run."""
        return _loop()[name](z.ctypes.data, r.ctypes.data)

    def with_jacobian(self, integers: np.ndarray) -> bool:
        """Let a run use the implicit method; whether that is possible."""
        if len(self.system.states) > MOST_DENSE:
            return False
        if not self.integers[at.JACOBIAN]:
            from lumped.kernel.functions import compiled_functions

            functions = {"jacobian": self.system.jacobian}
            code = compiled_functions(self.system._inputs, functions, dense=False)
            self._codes.append(code)
            self.integers[at.JACOBIAN] = code.addresses["jacobian"]
            self.integers[at.MAY_IMPLICIT] = 1
        for place in (at.JACOBIAN, at.MAY_IMPLICIT):
            integers[place] = self.integers[place]
        return True


def patience(system: System) -> float:
    """Time of stepping in a run after which machine code pays, s.

    It is infinite without LLVM and with ``LUMPED_NATIVE=0``, and zero with ``LUMPED_NATIVE=1``.
    """
    choice = os.environ.get("LUMPED_NATIVE")
    if choice == "0" or not _has_llvm() or machine_failed(system):
        return math.inf
    if choice == "1" or "machine" in system.made:
        return 0.0
    cost = _AT_LEAST + _EACH * system.rhs.n_instructions()
    return cost + _loop_cost() - _RUN * float(system.made.get("runs", 0.0))


def _loop_cost() -> float:
    """Time to compile the time loop, s; nothing if that was done before."""
    if not _READY and stored(loop_name()):
        _READY.append(True)
    return 0.0 if _READY else _COMPILING


@cache
def _has_llvm() -> bool:
    # on Windows, LLVM's linker does not find the C library's functions by itself
    return sys.platform != "win32" and find_spec("llvmlite") is not None


def machine_failed(system: System) -> bool:
    """Whether there is no machine code of a system."""
    return not system.states or system.made.get("machine", system) is None


def machine(system: System) -> Machine | None:
    """The system as machine code; None if it cannot be had."""
    if "machine" not in system.made:
        try:
            system.made["machine"] = _built(system) if system.states else None
        except UnsupportedError:
            system.made["machine"] = None
    found: Machine | None = system.made["machine"]
    return found


def begun(
    system: System, theta: np.ndarray, time: float, x: np.ndarray, settings: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """States and settings at the start, if machine code is at hand and finds them."""
    code = system.made.get("machine")
    if code is None or patience(system) > 0 or system._values.implicit:
        return None
    z, r = code.blocks(theta, x, settings, 1.0)
    r[at.T] = time
    code.ask(z, r)
    if not code("begin", z, r):
        return None
    first, second = int(z[at.XS]), int(z[at.MS])
    return r[first : first + len(x)].copy(), r[second : second + len(settings)].copy()


@cache
def _any_accelerations(count: int) -> np.ndarray:
    return np.random.default_rng(4).uniform(0.5, 1.5, count)


@cache
def _loop() -> dict[str, Callable[[int, int], int]]:
    from lumped.kernel.functions import time_loop

    _READY.append(True)
    return {name: _CALL(address) for name, address in time_loop().addresses.items()}


def _built(system: System) -> Machine:
    from lumped.kernel.functions import compiled_functions

    s, implicit = system.switching, len(system._values.implicit)
    functions = {"rhs": system.rhs}
    count = 0
    if s:
        functions["look"] = system.look
        count = int(system.margins.size1_out(0))
        if count:
            functions |= {"margins": system.margins, "slopes": system.margin_rates}
    if implicit:
        functions["closure"] = system.closure
    pairs, ratios = levers(system)
    if pairs:
        functions["levers"] = ratios
    code = compiled_functions(system._inputs, functions)
    sparsity = system.jacobian.sparsity_out(0) if len(system.states) <= MOST_DENSE else None
    sizes = Sizes(
        len(system.states),
        system._inputs[3].numel(),
        implicit,
        system._inputs[1].numel(),
        count,
        len(pairs),
        sparsity.nnz() if sparsity is not None else 0,
    )
    blocks = laid_out(sizes, s, system.states, system.speed_uses)
    rows, columns = sparsity.get_triplet() if sparsity is not None else ([], [])
    blocks.table(at.JAC_ROW, rows)
    blocks.table(at.JAC_COLUMN, columns)
    blocks.flags(at.TIMED_MODE, sizes.settings - implicit)
    places = {"rhs": at.RHS, "look": at.LOOK, "margins": at.MARGINS, "slopes": at.SLOPES}
    places |= {"closure": at.CLOSURE, "levers": at.LEVERS}
    for name, address in code.addresses.items():
        blocks.put(places[name], address)
    signs = np.array([sign for jump in s.jumps for sign in jump.signs], dtype=float)
    table = np.concatenate([np.zeros(0), *(pieces.table.ravel() for _, pieces in s.tables)])
    work = 50 * (system.rhs.n_instructions() + sizes.states) + sizes.states**3
    return Machine(system, blocks.integers, blocks.count, signs, table, _HALF // work + 1, [code])
