"""What the files of units of FMI say that others made."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import prod
from pathlib import Path
from typing import Any, NamedTuple, Self

from lumped.errors import DeclarationError, nearest
from lumped.support.known_units import measure
from lumped.support.optional_packages import extra

_KINDS = {"co_simulation": "coSimulation", "model_exchange": "modelExchange"}


_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_USUAL = (
    *("1", "rad", "rad/s", "rad/s2", "N.m", "N", "m", "m/s", "m/s2", "s", "1/s", "kg", "kg.m2"),
    *("A", "V", "W", "K", "Pa", "Ohm", "H", "F", "T", "Wb", "N/m", "N.s/m", "N.m/rad"),
    *("N.m.s/rad", "N.m/A", "V.s/rad", "W/K", "m2", "m3"),
)
"""Units as components write them; the first of a dimension is taken."""


class _Quantity(NamedTuple):
    """An SI unit; one in the file is `factor` of it, and its zero is at `zero`."""

    unit: str
    factor: float
    zero: float


def of_unit(name: str | None, base: Any) -> _Quantity | None:
    """The SI unit of a unit in a file; None if nobody knows it.

    Parameters
    ----------
    name : str, optional
        Its name; without one, a number.
    base : BaseUnit of FMPy, optional
        Its powers of SI base units, factor and offset.
    """
    if not name:
        return _Quantity("1", 1.0, 0.0)
    known = measure(name)
    if base is None:
        if known is None:
            return None
        return _Quantity(_write_unit(known.powers), known.factor, known.zero)
    powers = {unit: int(getattr(base, unit)) for unit in _BASE if int(getattr(base, unit))}
    factor, zero = float(base.factor), float(base.offset)
    if known is not None and known.is_si and known.powers == powers and factor == 1 and not zero:
        return _Quantity(name, 1.0, 0.0)
    return _Quantity(_write_unit(powers), factor, zero)


def _write_unit(powers: dict[str, int]) -> str:
    """The SI unit with these powers of base units."""
    for usual in _USUAL:
        known = measure(usual)
        if known is not None and known.powers == powers:
            return usual
    return ".".join(f"{unit}{power}" if power != 1 else unit for unit, power in powers.items())


@dataclass(frozen=True)
class Signal:
    """An input, output or parameter of a unit.

    Attributes
    ----------
    name, text : str
        In the file.
    variable : (int, str, int)
        Value reference, type and number of values.
    unit : str
        SI unit.
    factor, zero : float
        One of what the unit computes in is so much in the SI unit, and zero is there.
    start : tuple of float
        Start values, SI; empty where the file has none.
    least, largest : float or None
        Its range, SI.
    """

    name: str
    text: str
    variable: tuple[int, str, int]
    unit: str
    factor: float
    zero: float
    start: tuple[float, ...]
    least: float | None
    largest: float | None

    @property
    def size(self) -> int:
        """Number of values."""
        return self.variable[2]

    @classmethod
    def of(cls, variable: Any, quantity: _Quantity) -> Self:
        """A variable that FMPy read."""
        unit, factor, zero = quantity
        zero = 0.0 if variable.relativeQuantity else zero

        def in_si(text: str | None) -> float | None:
            if text is None:
                return None
            word = str(text).lower()
            value = float(word == "true") if word in ("true", "false") else float(text)
            return value * factor + zero

        size = prod(int(_extent(each)) for each in variable.dimensions)
        texts = [] if variable.start is None else str(variable.start).split()
        start = tuple(value for value in map(in_si, texts) if value is not None)
        return cls(
            variable.name,
            variable.description or "",
            (variable.valueReference, variable.type, size),
            unit,
            factor,
            zero,
            start * size if len(start) == 1 else start,
            in_si(variable.min),
            in_si(variable.max),
        )


def _extent(dimension: Any) -> str:
    """Extent of an array; that which a structural parameter has at first."""
    found = dimension.start if dimension.variable is None else dimension.variable.start
    return str(found)


@dataclass(frozen=True, eq=False)
class Description:
    """What the file of a unit says.

    Attributes
    ----------
    path : Path
        The file.
    content : str
        Its hash.
    folder : TemporaryDirectory
        What is in it; removed at the end of the program.
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
    content: str
    folder: tempfile.TemporaryDirectory[str]
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
def _read(path: Path, stamp: int) -> Any:
    fmpy = extra("fmpy", "fmi", f"from_fmu({path.name!r})")
    try:
        return fmpy.read_model_description(str(path))
    except Exception as fault:
        raise DeclarationError(
            f"from_fmu: {path} cannot be read as a unit of FMI ({fault}). Give a file .fmu of FMI "
            "2.0 or 3.0."
        ) from None


def describe_unit(
    path: str | Path,
    kind: str | None,
    outputs: Sequence[str],
    units: Mapping[str, str],
    tolerance: float,
) -> Description:
    """What the file of a unit says.

    Parameters
    ----------
    path : str or Path
        The file.
    kind : {"co_simulation", "model_exchange"}, optional
        How to run it; default is the first that it has.
    outputs : sequence of str
        Variables that are outputs beside those that the file calls so.
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
    stamp = path.stat().st_mtime_ns
    read = _read(path, stamp)
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
        role = "output" if variable.name in outputs else variable.causality
        if role not in signals:
            continue
        if role == "parameter" and not _is_real(variable):
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
            signals[role].append(Signal.of(variable, quantity))
    used = {s.name for own in signals.values() for s in own}
    for option, names, known in (
        ("units", units, used),
        (
            "outputs",
            outputs,
            {v.name for v in read.modelVariables if v.name in used or _is_real(v)},
        ),
    ):
        for name in names:
            if name not in known:
                raise DeclarationError(
                    f"from_fmu: {option}= names {name!r}, which {path.name} does not have as a "
                    f"number. {nearest(name, known)}"
                )
    facts = {
        "version": version,
        "kind": kind,
        "identifier": interface.modelIdentifier,
        "token": read.guid,
        "tolerance": tolerance,
        "inputs": [s.variable for s in signals["input"]],
        "outputs": [s.variable for s in signals["output"]],
        "parameters": [s.variable for s in signals["parameter"]],
        "has_events": kind == "co_simulation" and bool(interface.hasEventMode),
        "states": read.numberOfContinuousStates,
        "indicators": read.numberOfEventIndicators,
        "tells_steps": kind == "model_exchange" and _tells_steps(interface, version),
        "is_alone": interface.canBeInstantiatedOnlyOncePerProcess,
    }
    return Description(
        path,
        *_unpack(path, stamp),
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


def _is_real(variable: Any) -> bool:
    return variable.type in ("Real", "Float64", "Float32")


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


@cache
def _unpack(path: Path, stamp: int) -> tuple[str, tempfile.TemporaryDirectory[str]]:
    """Hash of a file, and a folder with what is in it."""
    folder = tempfile.TemporaryDirectory(prefix="lumped-unit-", ignore_cleanup_errors=True)
    fmpy = extra("fmpy", "fmi", f"from_fmu({path.name!r})")
    try:
        fmpy.extract(str(path), folder.name)
    except Exception as fault:  # of a path that leaves the folder, FMPy raises no kind of its own
        folder.cleanup()
        raise DeclarationError(
            f"from_fmu: {path} cannot be unpacked ({fault}). Pack it anew, with paths below its "
            "own folder."
        ) from None
    return hashlib.sha256(path.read_bytes()).hexdigest(), folder
