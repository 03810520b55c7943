"""Units of FMI that others made, as runs ask them."""

from __future__ import annotations

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
from lumped.exchange.unit_description import Description, Signal
from lumped.language.program import Program, Session


class UnitProgram(Program):
    """A unit with the values of what is fixed in it.

    Parameters
    ----------
    unit : Description
        From `describe_unit`.
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
        """The hash of the file, how it is run, and what its values mean."""
        unit = self._unit
        signals = unit.inputs, unit.outputs, unit.parameters
        return f"{unit.content} {unit.facts} {self._fixed} {signals}"

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
        self._inputs, self._outputs = _Scales(unit.inputs), _Scales(unit.outputs)
        self._parameters = _Scales(unit.parameters)

    def answer(self, values: np.ndarray) -> np.ndarray:
        """Outputs at a sample; one that does not follow the last begins anew."""
        number, middle = round(float(values[0])), 2 + self._parameters.count
        inputs, parameters = self._inputs.to_unit(values[middle:]), None
        if self._process is None or not self._process.is_alive or number != self._next:
            self._take()
            parameters = self._parameters.to_unit(values[2:middle])
        assert self._process is not None
        outputs = self._outputs.from_unit(self._process.ask(float(values[1]), parameters, inputs))
        self._next = number + 1
        if not np.isfinite(outputs).all():
            self._process.stop()
            first = int(np.argmin(np.isfinite(outputs)))
            raise SolverError(f"its output {self._outputs.names[first]} is {outputs[first]}.")
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
            [sys.executable, "-P", unit_process.__file__],
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
            raise SolverError(f"its binary crashed ({_explain_end(self._popen.wait())}).")
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
            raise SolverError(f"its process ended ({_explain_end(self._popen.wait())}).") from None

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


def _explain_end(code: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


class _Scales:
    """How values of signals become SI units, and back."""

    def __init__(self, signals: Sequence[Signal]) -> None:
        sizes = [each.size for each in signals]
        self.count = sum(sizes)
        self._factors = np.repeat([each.factor for each in signals], sizes)
        self._zeros = np.repeat([each.zero for each in signals], sizes)
        self.names = [
            each.name if each.size == 1 else f"{each.name}[{i + 1}]"
            for each in signals
            for i in range(each.size)
        ]

    def to_unit(self, values: np.ndarray) -> list[float]:
        """Numbers in SI as the unit takes them."""
        found: list[float] = ((values - self._zeros) / self._factors).tolist()
        return found

    def from_unit(self, values: Sequence[float]) -> np.ndarray:
        """Numbers of the unit in SI."""
        found: np.ndarray = np.array(values) * self._factors + self._zeros
        return found
