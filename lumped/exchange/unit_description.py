"""What the files of units of FMI say that others made."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lumped.errors import DeclarationError, nearest
from lumped.exchange.unit_quantities import Signal, of_unit
from lumped.support.optional_packages import extra

_KINDS = {"co_simulation": "coSimulation", "model_exchange": "modelExchange"}


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
    extra("fmpy", "fmi", f"from_fmu({path.name!r})").extract(str(path), folder.name)
    return hashlib.sha256(path.read_bytes()).hexdigest(), folder
