"""The description of a model as the Functional Mock-up Interface wants it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree as Xml

import casadi as ca

from lumped.exchange.interface import Interface, Shown
from lumped.language.declared import text_of
from lumped.support.display_units import display
from lumped.support.known_units import measure

__all__ = ["build_description", "model_description"]

_STRUCTURED = re.compile(r"(der\()?[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*(,\d+)?\)?$")
_KINDS = {"model_exchange": "ModelExchange", "co_simulation": "CoSimulation"}
_DISPLAYED = {"rad": "deg", "rad/s": "rpm"}
"""Units that people read."""


def model_description(
    interface: Interface,
    *,
    version: str,
    kinds: Iterable[str],
    identifier: str,
    token: str,
    rtol: float,
    sources: Sequence[str],
) -> str:
    """Text of ``modelDescription.xml``."""
    new, variables, system = version == "3.0", interface.variables, interface.system
    structured = all(_STRUCTURED.match(v.name) for v in variables)
    root = Xml.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": system.name,
            "instantiationToken" if new else "guid": token,
            "description": (text_of(type(system.model)) or system.name).split("\n")[0],
            "generationTool": "lumped",
            "variableNamingConvention": "structured" if structured else "flat",
        },
    )
    if not new:
        root.set("numberOfEventIndicators", str(interface.margins))
    for kind in kinds:
        _kind(root, kind, identifier, sources, new=new)
    _units(root, variables)
    Xml.SubElement(root, "DefaultExperiment", startTime="0", tolerance=repr(rtol))
    listed = Xml.SubElement(root, "ModelVariables")
    for reference, shown in enumerate(variables):
        if new:
            _variable3(listed, reference, shown)
        elif shown.role != "indicator":
            _variable2(listed, reference, shown)
    _structure(root, interface, new=new)
    return _written(root)


def build_description(identifier: str, sources: Sequence[str]) -> str:
    """Text of ``sources/buildDescription.xml`` of version 3.0."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    build = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = Xml.SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        Xml.SubElement(files, "SourceFile", name=name)
    return _written(root)


def _written(root: Xml.Element) -> str:
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"


def _kind(
    root: Xml.Element, kind: str, identifier: str, sources: Sequence[str], *, new: bool
) -> None:
    state = "FMUState" if new else "FMUstate"
    options = {
        "modelIdentifier": identifier,
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if kind == "co_simulation":
        options["canHandleVariableCommunicationStepSize"] = "true"
    elif new:
        options["needsCompletedIntegratorStep"] = "true"
    element = Xml.SubElement(root, _KINDS[kind], options)
    if not new:
        files = Xml.SubElement(element, "SourceFiles")
        for name in sources:
            Xml.SubElement(files, "File", name=name)


def _units(root: Xml.Element, variables: Sequence[Shown]) -> None:
    definitions = Xml.SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in variables} - {"1"}):
        element = Xml.SubElement(definitions, "Unit", name=unit)
        known = measure(unit)
        if known is not None and known.is_si:
            Xml.SubElement(element, "BaseUnit", {k: str(n) for k, n in known.powers.items()})
        if unit in _DISPLAYED:
            name, factor, _ = display("", unit, _DISPLAYED)
            Xml.SubElement(element, "DisplayUnit", name=name, factor=repr(factor))


def _facts(shown: Shown) -> tuple[dict[str, str], dict[str, str]]:
    """Causality and the like of a variable, and what concerns its values."""
    facts = {"name": shown.name, "description": shown.text}
    causality = {"parameter": "parameter", "input": "input", "time": "independent"}
    facts["causality"] = causality.get(shown.role, "output" if shown.is_output else "local")
    facts["variability"] = "continuous"
    if shown.role == "parameter":
        facts["variability"] = "tunable" if shown.tunable else "fixed"
    values = {} if shown.unit == "1" else {"unit": shown.unit}
    if shown.unit in _DISPLAYED:
        values["displayUnit"] = _DISPLAYED[shown.unit]
    if shown.role == "state" and shown.nominal != 1.0:
        values["nominal"] = repr(shown.nominal)
    values |= {key: repr(shown.limits[key]) for key in ("min", "max") if key in shown.limits}
    if shown.start is not None:
        values["start"] = repr(shown.start)
    if shown.role not in ("time", "input"):
        facts["initial"] = "calculated" if shown.start is None else "exact"
    return facts, values


def _variable2(listed: Xml.Element, reference: int, shown: Shown) -> None:
    facts, values = _facts(shown)
    element = Xml.SubElement(listed, "ScalarVariable", facts, valueReference=str(reference))
    if shown.state:
        values["derivative"] = str(shown.state + 1)
    Xml.SubElement(element, "Real", values)


def _variable3(listed: Xml.Element, reference: int, shown: Shown) -> None:
    facts, values = _facts(shown)
    if shown.state:
        values["derivative"] = str(shown.state)
    Xml.SubElement(listed, "Float64", facts | values, valueReference=str(reference))


def _structure(root: Xml.Element, interface: Interface, *, new: bool) -> None:
    """Outputs, derivatives and what is computed at the start, with what they depend on."""
    structure = Xml.SubElement(root, "ModelStructure")
    variables = interface.variables
    known = _dependencies(interface)
    outputs = [r for r, v in enumerate(variables) if v.is_output]
    rates = [r for r, v in enumerate(variables) if v.role == "rate"]
    initial = [r for r in outputs if variables[r].start is None] + rates
    initial += [
        r
        for r, v in enumerate(variables)
        if v.role == "state" and v.start is None and not v.is_output
    ]
    indicators = [r for r, v in enumerate(variables) if v.role == "indicator"]
    groups = [("Output", outputs), ("ContinuousStateDerivative", rates)]
    groups += [("InitialUnknown", sorted(initial)), ("EventIndicator", indicators)]
    if not new:
        groups = [("Outputs", outputs), ("Derivatives", rates)]
        groups += [("InitialUnknowns", sorted(initial))]
    for name, references in groups:
        if not references:
            continue
        parent = structure if new else Xml.SubElement(structure, name)
        for r in references:
            facts = {"valueReference": str(r)} if new else {"index": str(r + 1)}
            if r in known and not name.startswith("Initial"):
                facts["dependencies"] = " ".join(str(d + (not new)) for d in known[r])
            Xml.SubElement(parent, name if new else "Unknown", facts)


def _dependencies(interface: Interface) -> dict[int, list[int]]:
    """Value references of states and inputs on which outputs and derivatives depend."""
    system, variables = interface.system, interface.variables
    x, p, _, _ = system.inputs
    symbols = ca.vertcat(x, p)
    states = [r for r, v in enumerate(variables) if v.role == "state"]
    parameters = [r for r, v in enumerate(variables) if v.role in ("parameter", "input")]
    columns = [*states, *parameters]
    rows = [r for r, v in enumerate(variables) if v.role == "rate"]
    rows += [r for r, v in enumerate(variables) if v.role == "output"]
    everything = ca.vertcat(system.rates, interface.output_expressions)
    known: dict[int, list[int]] = {r: [] for r in rows}
    entries = ca.jacobian_sparsity(everything, symbols).get_triplet()
    for i, j in zip(*entries, strict=True):
        if variables[columns[j]].role != "parameter":
            known[rows[i]].append(columns[j])
    for r, v in enumerate(variables):
        if v.role == "state" and v.is_output:
            known[r] = [r]
    return {r: sorted(found) for r, found in known.items()}
