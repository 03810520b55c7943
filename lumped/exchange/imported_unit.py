"""Units of FMI that others made: what their files say, and how runs ask them."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from lumped.errors import DeclarationError, SolverError
from lumped.exchange import unit_process
from lumped.exchange.unit_quantities import Signal, of_unit
from lumped.language.program import Program, Session
from lumped.support.optional_packages import extra

__all__ = ["Description", "UnitProgram", "described"]

_KINDS = {"co_simulation": "coSimulation", "model_exchange": "modelExchange"}


@dataclass(frozen=True, eq=False)
class Description:
    """What the file of a unit says.

    Attributes
    ----------
    path : Path
        The file.
    kind : {"co_simulation", "model_exchange"}
        How the unit is run.
    name, text : str
        Of the model.
    inputs, outputs, parameters : list of Signal
        Those that are numbers.
    fixed : dict of str to (int, str, object)
        Reference, type and value of parameters that are whole numbers, truth values or texts.
    step : float or None
        Step that the unit asks for, s.
    facts : dict
        What its process needs.
    """

    path: Path
    kind: str
    name: str
    text: str
    inputs: list[Signal]
    outputs: list[Signal]
    parameters: list[Signal]
    fixed: dict[str, tuple[int, str, Any]]
    step: float | None
    facts: dict[str, Any]


@cache
def _read(path: Path, stamp: tuple[int, int]) -> Any:
    fmpy = extra("fmpy", "fmi", f"from_fmu({path.name!r})")
    try:
        return fmpy.read_model_description(str(path))
    except Exception as fault:
        raise DeclarationError(
            f"from_fmu: {path} cannot be read as a unit of FMI ({fault}). Give a file .fmu of FMI "
            "2.0 or 3.0."
        ) from None


def described(
    path: str | Path, kind: str | None, units: Mapping[str, str], tolerance: float
) -> Description:
    """What the file of a unit says.

    Parameters
    ----------
    path : str or Path
        The file.
    kind : {"co_simulation", "model_exchange"}, optional
        How to run it; default is the first that it has.
    units : mapping of str to str
        Units of variables whose units the file does not define.
    tolerance : float
        Relative tolerance with which it solves its own equations.

    Raises
    ------
    DeclarationError
        If it cannot be read, or asks for what is not done here.
    """
    path = Path(path)
    if not path.is_file():
        raise DeclarationError(f"from_fmu: there is no file {path}.")
    path = path.resolve()
    status = path.stat()
    read = _read(path, (status.st_mtime_ns, status.st_size))
    version = read.fmiMajorVersion
    if version not in (2, 3):
        raise DeclarationError(
            f"from_fmu: {path.name} is of FMI {read.fmiVersion}; 2.0 or 3.0 is needed."
        )
    kind = _kind(path, read, kind)
    interface = getattr(read, _KINDS[kind])
    _refuse_other_platform(path, interface)
    if interface.needsExecutionTool:
        raise DeclarationError(
            f"from_fmu: {path.name} needs the tool that made it ({read.generationTool}) while it "
            "runs. Export it there with its solver."
        )
    _refuse_clocks(path, read)
    defined = {unit.name: unit.baseUnit for unit in read.unitDefinitions}
    signals: dict[str, list[Signal]] = {"input": [], "output": [], "parameter": []}
    fixed: dict[str, tuple[int, str, Any]] = {}
    for variable in read.modelVariables:
        if variable.causality not in signals:
            continue
        is_number = variable.type in ("Real", "Float64", "Float32")
        if variable.causality == "parameter" and not is_number:
            if variable.type != "Binary" and not variable.dimensions:
                fixed[variable.name] = (variable.valueReference, variable.type, _start(variable))
        elif variable.type not in ("String", "Binary"):
            unit = units.get(variable.name) or variable.unit
            if unit is None and variable.declaredType is not None:
                unit = variable.declaredType.unit
            is_given = variable.name in units
            quantity = of_unit(unit, None if is_given else defined.get(unit))
            if quantity is None:
                raise DeclarationError(
                    f"from_fmu: {variable.name} of {path.name} is in {unit!r}, which the file does "
                    f"not define and nobody here knows. Say what it is: "
                    f"units={{{variable.name!r}: 'N.m'}}."
                )
            signals[variable.causality].append(Signal.of(variable, quantity))
    unknown = [n for n in units if all(n != s.name for own in signals.values() for s in own)]
    if unknown:
        names = [s.name for own in signals.values() for s in own]
        raise DeclarationError(
            f"from_fmu: units= names {unknown[0]!r}, which {path.name} does not have. Known: "
            f"{', '.join(names[:20])}."
        )
    facts = {
        "version": version,
        "kind": kind,
        "identifier": interface.modelIdentifier,
        "token": read.guid,
        "name": read.modelName,
        "tolerance": tolerance,
        "inputs": [signal.variable for signal in signals["input"]],
        "outputs": [signal.variable for signal in signals["output"]],
        "parameters": [signal.variable for signal in signals["parameter"]],
        "has_events": kind == "co_simulation" and bool(interface.hasEventMode),
        "states": read.numberOfContinuousStates,
        "indicators": read.numberOfEventIndicators,
        "tells_steps": kind == "model_exchange" and _tells_steps(interface, version),
        "is_alone": interface.canBeInstantiatedOnlyOncePerProcess,
    }
    return Description(
        path,
        kind,
        read.modelName or path.stem,
        read.description or "",
        signals["input"],
        signals["output"],
        signals["parameter"],
        fixed,
        _step(read, interface),
        facts,
    )


def _kind(path: Path, read: Any, kind: str | None) -> str:
    """How a unit is run."""
    found = [name for name, attribute in _KINDS.items() if getattr(read, attribute) is not None]
    if kind is None and found:
        return found[0]
    if kind not in found:
        wanted = f"kind = {kind!r}: " if kind is not None else ""
        raise DeclarationError(
            f"from_fmu: {wanted}{path.name} can be run by {' and '.join(found) or 'nothing known'}."
        )
    return kind


def _refuse_other_platform(path: Path, interface: Any) -> None:
    fmpy = extra("fmpy", "fmi", f"from_fmu({path.name!r})")
    found = fmpy.supported_platforms(str(path))
    if fmpy.platform not in found:
        binaries = ", ".join(sorted(set(found) - {"c-code"})) or "no platform"
        sources = " It has sources: compile them by fmpy compile." if "c-code" in found else ""
        raise DeclarationError(
            f"from_fmu: {path.name} has binaries for {binaries}, not for {fmpy.platform}; ask for "
            f"one with those of this machine.{sources}"
        )


def _refuse_clocks(path: Path, read: Any) -> None:
    clocks = [v.name for v in read.modelVariables if v.type == "Clock" or v.clocks]
    if clocks:
        raise DeclarationError(
            f"from_fmu: {path.name} has clocks ({', '.join(clocks[:6])}), which are not ticked "
            "here. Export it without, as a unit that samples by itself."
        )


def _start(variable: Any) -> Any:
    """Start value of a variable that is no real number."""
    if variable.type == "Boolean":
        return str(variable.start).lower() in ("true", "1")
    return (variable.start or "") if variable.type == "String" else int(variable.start or 0)


def _step(read: Any, interface: Any) -> float | None:
    inner = getattr(interface, "fixedInternalStepSize", None)
    if inner is None and read.defaultExperiment is not None:
        inner = read.defaultExperiment.stepSize
    return None if inner is None else float(inner)


def _tells_steps(interface: Any, version: int) -> bool:
    """Whether a unit wants to know of completed steps."""
    if version == 3:
        return bool(interface.needsCompletedIntegratorStep)
    return not interface.completedIntegratorStepNotNeeded


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

    @property
    def content(self) -> str:
        """The hash of the file, and how it is run."""
        facts = self._unit.facts
        told = self._unit.kind, facts["tolerance"], self._fixed
        return f"{_hash(self._unit.path, self._unit.path.stat().st_mtime_ns)} {told}"

    def begin(self) -> Session:
        """A process that no run uses now."""
        return _UnitSession(self._unit, self._idle, self._fixed)


@cache
def _hash(path: Path, stamp: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


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
        middle = 2 + sum(signal.size for signal in unit.parameters)
        inputs, parameters = _to_unit(unit.inputs, values[middle:]), None
        if self._process is None or not self._process.is_alive or number != self._next:
            self._take()
            parameters = _to_unit(unit.parameters, values[2:middle])
        assert self._process is not None
        found = self._process.ask(float(values[1]), parameters, inputs)
        self._next = number + 1
        return _from_unit(unit.outputs, found)

    def _take(self) -> None:
        """Take a process that is idle, or begin one."""
        alone, process = self._unit.facts["is_alone"], self._process
        if process is not None and process.is_alive and not alone:
            return
        if process is not None:
            process.stop()
        self._process = self._idle.pop() if self._idle and not alone else None
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
        self._stop = weakref.finalize(self, _stop, self._popen)
        folder = _extracted(unit.path, unit.path.stat().st_mtime_ns).name
        self.is_alive = True
        self._send({**unit.facts, "folder": folder, "fixed": fixed})

    def ask(
        self, t: float, parameters: Sequence[float] | None, inputs: Sequence[float]
    ) -> list[float]:
        """Begin at a time, if there are parameters, or go on to it; gives the outputs.

        Raises
        ------
        SolverError
            If the unit fails or its process has ended.
        """
        self._send((t, parameters, inputs))
        assert self._popen.stdout is not None
        answer = unit_process.read(self._popen.stdout)
        if answer is None:
            self.is_alive = False
            raise SolverError(f"its binary crashed ({_ended(self._popen.wait())}).")
        found, said = answer
        if isinstance(found, str):
            self.stop()
            told = f" It said: {' '.join(said)[-500:]}" if said else ""
            raise SolverError(f"{found.rstrip('.')}.{told}")
        bad = [value for value in found if not np.isfinite(value)]
        if bad:
            self.stop()
            raise SolverError(f"an output is {bad[0]}.")
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


def _stop(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            stream.close()


def _ended(code: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    import signal

    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


@cache
def _extracted(path: Path, stamp: int) -> tempfile.TemporaryDirectory[str]:
    """A folder with what is in the file; removed at the end of the program."""
    folder = tempfile.TemporaryDirectory(prefix="lumped-unit-", ignore_cleanup_errors=True)
    extra("fmpy", "fmi", f"from_fmu({path.name!r})").extract(str(path), folder.name)
    return folder


def _to_unit(signals: Sequence[Signal], values: np.ndarray) -> list[float]:
    """Numbers in SI as a unit takes them."""
    found, place = [], 0
    for signal in signals:
        own = values[place : place + signal.size]
        found += ((own - signal.zero) / signal.factor).tolist()
        place += signal.size
    return found


def _from_unit(signals: Sequence[Signal], values: Sequence[float]) -> np.ndarray:
    """Numbers of a unit in SI."""
    factors = np.repeat([s.factor for s in signals], [s.size for s in signals])
    zeros = np.repeat([s.zero for s in signals], [s.size for s in signals])
    found: np.ndarray = np.asarray(values, dtype=float) * factors + zeros
    return found
