"""The description of a model as the Functional Mock-up Interface wants it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

from lumped.exchange.dependencies import Dependencies
from lumped.exchange.interface import Interface, Shown
from lumped.language.declared import text_of
from lumped.support.display_units import display
from lumped.support.known_units import measure

_IDENTIFIER = r"[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}|der\({_IDENTIFIER}(,\d+)?\)", re.ASCII)
_QUOTABLE = re.compile(r"[\w!#$%&()*+,./:;<>=?@\[\]^{}|~ \-'\"\\]+", re.ASCII)
"""Grammars of the standard: a structured name, and text that is one between apostrophes."""
_KINDS = {"model_exchange": "ModelExchange", "co_simulation": "CoSimulation"}
_DISPLAYED = {"rad": "deg", "rad/s": "rpm"}
"""Units that people read."""
_STARTED = ("state", "rate")
"""Roles of what is unknown at the start without being an output."""


def model_description(
    interface: Interface,
    *,
    version: str,
    kinds: Sequence[str],
    identifier: str,
    token: str,
    rtol: float,
    sources: Sequence[str],
) -> str:
    """Text of ``modelDescription.xml``."""
    new, variables, system = version == "3.0", interface.variables, interface.system
    names, convention = _names(variables)
    root = Xml.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": system.name,
            "instantiationToken" if new else "guid": token,
            "description": (text_of(type(system.model)) or system.name).split("\n")[0],
            "generationTool": "lumped",
            "variableNamingConvention": convention,
        },
    )
    if not new:
        root.set("numberOfEventIndicators", str(interface.margins))
    for kind in kinds:
        _kind(root, kind, identifier, sources, new=new)
    _units(root, variables)
    Xml.SubElement(root, "DefaultExperiment", startTime="0", tolerance=repr(rtol))
    listed = Xml.SubElement(root, "ModelVariables")
    switching = system.switching
    may_jump = bool(len(switching.first_modes) or switching.jumps)
    jumps = "model_exchange" in kinds and may_jump  # events change states
    for reference, shown in enumerate(variables):
        if new or shown.role != "indicator":
            facts, values = _facts(shown, names[reference], jumps=jumps)
            if shown.state:
                values["derivative"] = str(shown.state + (not new))
            own = "Float64" if new else "ScalarVariable"
            merged = facts | values if new else facts
            variable = Xml.SubElement(listed, own, merged, valueReference=str(reference))
            if not new:
                Xml.SubElement(variable, "Real", values)
    _structure(root, interface, new=new)
    return _write_xml(root)


def build_description(identifier: str, sources: Sequence[str]) -> str:
    """Text of ``sources/buildDescription.xml`` of version 3.0."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    build = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = Xml.SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        Xml.SubElement(files, "SourceFile", name=name)
    return _write_xml(root)


def _write_xml(root: Xml.Element) -> str:
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
        f"providesDirectionalDerivative{'s' if new else ''}": "true",
    }
    if new:
        options["providesAdjointDerivatives"] = "true"
    if kind == "co_simulation":
        options["canHandleVariableCommunicationStepSize"] = "true"
        if new:
            options |= {"mightReturnEarlyFromDoStep": "true", "hasEventMode": "true"}
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


def _facts(shown: Shown, name: str, *, jumps: bool) -> tuple[dict[str, str], dict[str, str]]:
    """Causality and the like of a variable, and what concerns its values."""
    facts = {"name": name, "description": shown.text}
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
    if shown.role == "state" and jumps:
        values["reinit"] = "true"
    ends = {"at least": "min", "at most": "max"}
    values |= {ends[b.words]: repr(b.limit) for b in shown.bounds if b.words in ends}
    if shown.start is not None:
        values["start"] = repr(shown.start)
    if shown.role not in ("time", "input"):
        facts["initial"] = "calculated" if shown.start is None else "exact"
    return facts, values


def _names(variables: Sequence[Shown]) -> tuple[list[str], str]:
    """Names as the standard wants them, and the convention that they follow."""
    names = [v.name for v in variables]
    odd = [name for name in names if not _STRUCTURED.fullmatch(name)]
    if not all(_QUOTABLE.fullmatch(name) for name in odd):
        return names, "flat"
    quoted = {name: "'" + re.sub(r"(['\"\\])", r"\\\1", name) + "'" for name in odd}
    return [quoted.get(name, name) for name in names], "structured"


def _structure(root: Xml.Element, interface: Interface, *, new: bool) -> None:
    """Outputs, derivatives and what is computed at the start, with what they depend on."""
    structure = Xml.SubElement(root, "ModelStructure")
    variables, dependencies = interface.variables, Dependencies(interface)
    running, initial = dependencies.running(), dependencies.initial()
    outputs = [r for r, v in enumerate(variables) if v.is_output]
    rates = [r for r, v in enumerate(variables) if v.role == "rate"]
    unknown = [r for r in initial if variables[r].is_output or variables[r].role in _STARTED]
    indicators = [r for r, v in enumerate(variables) if v.role == "indicator"]
    groups = [("Output", outputs), ("ContinuousStateDerivative", rates)]
    groups += [("InitialUnknown", unknown), ("EventIndicator", indicators)]
    if not new:
        groups = [("Outputs", outputs), ("Derivatives", rates), ("InitialUnknowns", unknown)]
    for name, references in groups:
        if not references:
            continue
        parent = structure if new else Xml.SubElement(structure, name)
        for r in references:
            facts = {"valueReference": str(r)} if new else {"index": str(r + 1)}
            begins = name.startswith("Initial")
            known = initial[r] if begins else [other for other, _ in running[r]]
            facts["dependencies"] = " ".join(str(other + (not new)) for other in known)
            if not begins:
                facts["dependenciesKind"] = " ".join(kind for _, kind in running[r])
            Xml.SubElement(parent, name if new else "Unknown", facts)
