"""An explicit step of one system as one function: all stages, the new states and their error."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

from lumped.code.functions import compile_written, load_written
from lumped.code.machine_code import Code
from lumped.code.operations import STATE, TIME, Operations
from lumped.code.writing_out import Place, Value, Writer
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods import dop853
from lumped.kernel.plant import Function
from lumped.kernel.run import ANGLE, END, LENGTH, TOLERANCE
from lumped.support.process_lock import process_lock

_MOST_OPERATIONS = 6000
"""Of a step that is written out: longer ones take too long to compile."""
_WORTH = 250_000
"""Attempts that take about as long as compiling one."""


class WrittenStep:
    """The attempt of a step (`dop853.attempt`) as straight-line code, compiled when that pays.

    Parameters
    ----------
    rates : Operations or None
        Rates of the states; None where a step needs more than these.
    states : int
        How many there are.
    lanes : int
        Runs side by side.
    integrand : Operations, optional
        What is integrated over the step.

    Attributes
    ----------
    function : Function
        For records of runs; without an address as long as it is not compiled.
    """

    def __init__(
        self, rates: Operations | None, states: int, lanes: int, integrand: Operations | None
    ) -> None:
        self.function = Function()
        self._code: Code | None = None
        self._attempts = 0
        self._write: Callable[[], Operations] | None = None
        self._lanes = lanes
        if rates is None or not 0 < _count(rates, states, integrand) <= _MOST_OPERATIONS:
            return
        self._write = partial(write_step, rates, states, integrand)
        self._key = f"{states} {rates.key.hex()} {integrand and integrand.key.hex()}"
        self._take(load_written(self._key, lanes))

    def _take(self, code: Code | None) -> None:
        if code is not None:
            self._code = code
            self.function.wide_address = code.address("step")
            self.function.address = self.function.wide_address  # last: runs ask for it meanwhile

    def compile(self) -> None:
        """Make machine code of it now, unless it is too long."""
        with process_lock:  # of several threads one: code of another is not freed while it runs
            if self._write is not None and self._code is None:
                self._take(compile_written(self._key, self._write, self._lanes))

    def account(self, attempts: int) -> None:
        """Note attempts, those of all lanes one by one; compile what that is worth."""
        self._attempts += attempts
        if self._attempts > _WORTH * self._lanes:
            self.compile()


def _count(rates: Operations, states: int, integrand: Operations | None) -> int:
    """About so many operations; none without states."""
    if not states:
        return 0
    looks = 0 if integrand is None else len(dop853.LOOKED) * len(integrand.table)
    return len(dop853.STAGES) * len(rates.table) + looks + 150 * states


def write_step(rates: Operations, states: int, integrand: Operations | None) -> Operations:
    """The attempt of a step as a function.

    It takes the states, and behind them all that the attempt reads, as a run has it. Its results
    are what the attempt writes, from the stages of the run on.
    """
    n, integrands = states, 0 if integrand is None else integrand.results
    writer = Writer()

    def write(function: Operations, _: Any, x: Place, t: Value, __: Any, out: Place) -> None:
        writer.evaluate(function, x, t, out)

    writer.replace(evaluate, write)
    found = Place(writer.inputs(STATE, n, 18 * n + 3), 0)
    run: Any = SimpleNamespace(
        plant=SimpleNamespace(states=n, invariants=0, rates=rates),
        x=Place(writer.inputs(STATE, 0, n), 0),
        t=writer.input(TIME, 0),
        m=None,
        stages=found,
        new=found[16 * n :],
        atol=found[17 * n :],
        attempt=found[18 * n :],
        at_stages=found[18 * n + 6 :],
        argument=Place({}, 0),
        dense=Place({}, 0),
        is_implicit=0,
        shares=0,
        evaluations=0,
        watches=integrands > 0,
        watch=SimpleNamespace(integrands=integrands, integrand=integrand),
    )
    given = dict(found.held)
    run.t_new, run.rtol = run.attempt[END], run.attempt[TOLERANCE]
    writer.written(dop853.attempt)(run, run.attempt[LENGTH])
    run.attempt[ANGLE] = writer.farthest
    results = {k: value for k, value in found.held.items() if value is not given.get(k)}
    return writer.operations(results)
