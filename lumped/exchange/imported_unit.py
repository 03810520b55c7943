"""Units of FMI that others made, as runs ask them."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import weakref
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lumped.errors import SolverError
from lumped.exchange import unit_process
from lumped.exchange.unit_description import Description
from lumped.exchange.unit_quantities import Signal
from lumped.language.program import Program, Session

__all__ = ["UnitProgram"]


class UnitProgram(Program):
    """A unit with the values of what is fixed in it.

    Parameters
    ----------
    unit : Description
        From `described`.
    fixed : mapping of str to object
        Values of parameters that are no real numbers, by their names in the file.
    """

    def __init__(self, unit: Description, fixed: Mapping[str, Any]) -> None:
        self._unit, self.text = unit, f"unit '{unit.path.name}'"
        self._fixed = [
            (reference, kind, fixed.get(name, value))
            for name, (reference, kind, value) in unit.fixed.items()
            if fixed.get(name, value) != value
        ]
        self._idle: list[_Process] = []
        self._owner = os.getpid()

    @property
    def content(self) -> str:
        """The hash of the file, and how it is run."""
        facts = self._unit.facts
        told = self._unit.kind, facts["tolerance"], self._fixed
        return f"{self._unit.content} {told}"

    def begin(self) -> Session:
        """A process that no run uses now; one of another program stays with that."""
        if self._owner != os.getpid():
            self._idle, self._owner = [], os.getpid()
        return _UnitSession(self._unit, self._idle, self._fixed)


class _UnitSession(Session):
    """A unit that a run asks.

    It is told the number of the sample, its instant, parameters, and inputs, all in SI units.
    """

    def __init__(
        self, unit: Description, idle: list[_Process], fixed: list[tuple[int, str, Any]]
    ) -> None:
        self._unit, self._idle, self._fixed = unit, idle, fixed
        self._process: _Process | None = None
        self._next = 0

    def answer(self, values: np.ndarray) -> np.ndarray:
        """Outputs at a sample; one that does not follow the last begins anew."""
        unit, number = self._unit, round(float(values[0]))
        middle = 2 + sum(s.size for s in unit.parameters)
        inputs, parameters = _to_unit(unit.inputs, values[middle:]), None
        if self._process is None or not self._process.is_alive or number != self._next:
            self._take()
            parameters = _to_unit(unit.parameters, values[2:middle])
        assert self._process is not None
        found = self._process.ask(float(values[1]), parameters, inputs)
        self._next = number + 1
        outputs = _from_unit(unit.outputs, found)
        for name, value in zip(_names(unit.outputs), outputs.tolist(), strict=True):
            if not math.isfinite(value):
                self._process.stop()
                raise SolverError(f"its output {name} is {value}.")
        return outputs

    def _take(self) -> None:
        """Take a process that is idle, or begin one."""
        alone, process = self._unit.facts["is_alone"], self._process
        if process is not None and process.is_alive and not alone:
            return
        if process is not None:
            process.stop()
        try:
            self._process = None if alone else self._idle.pop()
        except IndexError:
            self._process = None
        if self._process is None:
            self._process = _Process(self._unit, self._fixed)

    def end(self) -> None:
        """Let other runs have the process."""
        if self._process is not None and self._process.is_alive:
            self._idle.append(self._process)
        self._process = None


class _Process:
    """A process that runs a unit."""

    def __init__(self, unit: Description, fixed: list[tuple[int, str, Any]]) -> None:
        self._popen = subprocess.Popen(
            [sys.executable, unit_process.__file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=-1,
        )
        self._stop = weakref.finalize(self, _stop, self._popen, os.getpid())
        self.is_alive = True
        self._send({**unit.facts, "folder": unit.folder.name, "fixed": fixed})

    def ask(
        self, t: float, parameters: Sequence[float] | None, inputs: Sequence[float]
    ) -> list[float]:
        """Begin at a time, if there are parameters, or go on to it; gives the outputs.

        Raises
        ------
        SolverError
            If the unit fails or its process has ended.
        """
        try:
            self._send((t, parameters, inputs))
            assert self._popen.stdout is not None
            answer = unit_process.read(self._popen.stdout)
        except BaseException:  # an interrupt leaves an answer that nobody waits for
            self.stop()
            raise
        if answer is None:
            self.is_alive = False
            raise SolverError(f"its binary crashed ({_ended(self._popen.wait())}).")
        found, said = answer
        if isinstance(found, str):
            self.stop()
            told = f" It said: {' '.join(said)[-500:]}" if said else ""
            raise SolverError(f"{found.rstrip('.')}.{told}")
        return list(found)

    def _send(self, message: object) -> None:
        assert self._popen.stdin is not None
        try:
            unit_process.write(self._popen.stdin, message)
        except OSError:
            self.is_alive = False
            raise SolverError(f"its process ended ({_ended(self._popen.wait())}).") from None

    def stop(self) -> None:
        """End the process."""
        self.is_alive = False
        self._stop()


def _stop(process: subprocess.Popen[bytes], owner: int) -> None:
    if owner != os.getpid():
        return
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            stream.close()


def _ended(code: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


def _names(signals: Sequence[Signal]) -> list[str]:
    """Names of the values of signals."""
    return [s.name if s.size == 1 else f"{s.name}[{i + 1}]" for s in signals for i in range(s.size)]


def _to_unit(signals: Sequence[Signal], values: np.ndarray) -> list[float]:
    """Numbers in SI as a unit takes them."""
    found, place = [], 0
    for each in signals:
        own = values[place : place + each.size]
        found += ((own - each.zero) / each.factor).tolist()
        place += each.size
    return found


def _from_unit(signals: Sequence[Signal], values: Sequence[float]) -> np.ndarray:
    """Numbers of a unit in SI."""
    factors = np.repeat([s.factor for s in signals], [s.size for s in signals])
    zeros = np.repeat([s.zero for s in signals], [s.size for s in signals])
    found: np.ndarray = np.asarray(values, dtype=float) * factors + zeros
    return found
