"""Export of a model as flat Modelica text."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import casadi as ca
import numpy as np

from lumped.compiler.switching import Condition
from lumped.compiler.system import Changes, Name, System
from lumped.errors import ExportError
from lumped.exchange.interface import Interface, Shown, refuse_doubles
from lumped.exchange.modelica_terms import ModelicaWriter, TextTerm, real
from lumped.language.declared import text_of
from lumped.support.arguments import checked
from lumped.support.whole_files import write_text

__all__ = ["export_modelica"]


@checked
def export_modelica(
    system: System,
    path: str | Path,
    *,
    inputs: Iterable[Name] = (),
    outputs: Iterable[Name] = (),
    start: Changes | None = None,
) -> Path:
    """Write the reduced equations of a model as one flat Modelica model.

    States have a ``der``, their start values follow from parameters where they do in the model;
    names are those of lumped in quotes. Functions of time and conditions become ``if``, changes of
    states ``when`` and ``reinit``.

    Parameters
    ----------
    system : System
        From `assemble`.
    path : path
        File to write, ``*.mo``.
    inputs, outputs : iterable of names
        Parameters, or inputs given as numbers, that become inputs; quantities to give out.
    start : mapping of name to float, optional
        Start values to set or change, as for `simulate`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ExportError
        If the model has constraints that hold or slide (friction, clutches, stops), closed linkages
        that are solved by iteration, or an operation that Modelica lacks; write an FMU then.
    OptionError, StartError, UnknownNameError
        As for `export_fmu`.
    """
    interface = Interface(system, inputs, outputs, start or {})
    refuse_doubles(interface)
    _refuse(system)
    path = Path(path)
    write_text(path, _Text(interface).model())
    return path


def _refuse(system: System) -> None:
    other = "Modelica text has no equations for that; write an FMU by export_fmu."
    if system.switching.names:
        names = ", ".join(dict.fromkeys(system.switching.names))
        raise ExportError(f"{system.name}: {names} can hold and slide. {other}")
    if system.structure.implicit:
        names = ", ".join(system.structure.node_name(n) for n in system.structure.implicit[:6])
        raise ExportError(
            f"{system.name}: {names} follow from a closed linkage by iteration. {other}"
        )


class _Text:
    def __init__(self, interface: Interface) -> None:
        self.interface, self.system = interface, interface.system
        self.shown: dict[str, list[Shown]] = {}
        for variable in interface.variables:
            self.shown.setdefault(variable.role, []).append(variable)
        self.given = [v for v in interface.variables if v.role in ("parameter", "input")]
        self.states = self.shown.get("state", [])
        self.outputs = self.shown.get("output", [])
        self.writer = ModelicaWriter()

    def model(self) -> str:
        system = self.system
        name = re.sub(r"\W", "_", system.name)
        body = self._equations()
        about = (text_of(type(system.model)) or system.name).split("\n")[0]
        lines = [f"model {name} {_string(about)}", *self._declarations(), "equation", *body]
        return "\n".join([*lines, f"end {name};", ""])

    def _equations(self) -> list[str]:
        """All equations; afterwards the writer knows the variables that they need."""
        system, switching = self.system, self.system.switching
        x, p, t, m = system.inputs
        theta = [TextTerm(_quoted(v.name)) for v in self.given]
        results = [
            system.rates,
            self.interface.output_expressions,
            system.structure.in_states(
                ca.vertcat(ca.SX(0, 1), *(c.greater for c in switching.conditions))
            ),
            system.structure.in_states(
                ca.vertcat(ca.SX(0, 1), *(c.less for c in switching.conditions))
            ),
            system.structure.in_states(switching.values),
        ]
        ends = np.cumsum([0, *(r.numel() for r in results)]).tolist()
        shared = ca.vertsplit(ca.cse(ca.densify(ca.vertcat(*results))), ends)
        function = ca.Function("all", [x, p, t, m], shared)
        self.modes = self._modes(theta)
        given = [
            [TextTerm(_quoted(v.name)) for v in self.states],
            theta,
            [TextTerm("time")],
            self.modes,
        ]
        rates, outputs, greater, less, values = self.writer.written(function, given)
        relations = []
        for k, condition in enumerate(switching.conditions):
            if condition.pieces is not None:
                relations += self._piece(condition, greater[k])
                continue
            sign = ">" if switching.strict[k] else ">="
            sides = f"{_side(greater[k])} {sign} {_side(less[k])}"
            relations.append(f"  {self.modes[condition.mode].text} = {sides};")
        lines = [f"  {name} = {term.text};" for name, term in self.writer.variables]
        lines += self.clocked + relations
        for shown, rate in zip(self.states, rates, strict=True):
            lines.append(f"  der({_quoted(shown.name)}) = {real(rate).text};")
        for shown, value in zip(self.outputs, outputs, strict=True):
            lines.append(f"  {_quoted(shown.name)} = {real(value).text};")
        return lines + self._jumps(values)

    def _modes(self, theta: list[TextTerm]) -> list[TextTerm]:
        """What each mode is: a comparison of the time, a condition or a setting of its own."""
        system, s = self.system, self.system.switching
        terms = [TextTerm("0")] * system.structure.mode_count
        for k, condition in enumerate(s.conditions):
            terms[condition.mode] = TextTerm(f"c{k + 1}", logical=True)
        for condition in (*s.timed, *s.conditions):
            for i, mode in enumerate(condition.modes if condition.pieces is not None else ()):
                terms[mode] = TextTerm(f"s{condition.mode}_{i}")
        self.clocked: list[str] = []
        v = system.structure.values
        for condition in s.timed:
            sides = [ca.densify(condition.greater), ca.densify(condition.less)]
            function = ca.Function("sides", [v.modes, system.inputs[1], v.time], sides)
            given = [terms, theta, [TextTerm("time")]]
            (left,), (right,) = self.writer.written(function, given, inline=True)
            if condition.pieces is not None:
                self.clocked += self._piece(condition, left)
                continue
            sign = ">" if condition.relation.strict else ">="
            terms[condition.mode] = TextTerm(
                f"{_side(left)} {sign} {_side(right)}", 0, logical=True
            )
        return terms

    def _piece(self, condition: Condition, argument: TextTerm) -> list[str]:
        """Equations of the settings of the piece that an argument is in."""
        pieces, name = condition.pieces, f"s{condition.mode}"
        assert pieces is not None
        place, lines = f"{name}_place", [f"  {name}_back = 0;"]
        if pieces.period is not None:
            turns = f"floor(({argument.text} - ({pieces.begins[0]!r})) / {pieces.period!r})"
            lines = [f"  {name}_back = {pieces.period!r} * {turns};"]
        lines.append(f"  {place} = {_side(argument)} - {name}_back;")
        rows = pieces.table.tolist()
        for i in range(pieces.width):
            choices = [
                f"if {place} < {begin!r} then {row[i]!r}"
                for begin, row in zip(pieces.begins[1:], rows, strict=False)
            ]
            chosen = " else ".join([*choices, repr(rows[-1][i])])
            shift = f" + {name}_back" if i == 1 else ""
            lines.append(f"  {name}_{i} = ({chosen}){shift};")
        return lines

    def _jumps(self, values: list[TextTerm]) -> list[str]:
        lines = []
        for jump in self.system.switching.jumps:
            lines.append(f"  when {self.modes[jump.mode].text} then")
            for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                if node not in self.system.structure.states:
                    continue
                name = _quoted(self.system.state_names[self.system.structure.states.index(node)])
                value = real(values[jump.first + i]).text
                lines.append(f"    reinit({name}, {'-' if sign < 0 else ''}({value}));")
            lines.append("  end when;")
        return lines

    def _declarations(self) -> list[str]:
        lines = []
        for v in self.given:
            if v.role == "input":
                lines.append(f"  input Real {_head(v, start=f'{v.start!r}')} {_string(v.text)};")
            else:
                value = f"{v.start!r}"
                lines.append(f"  parameter Real {_head(v)} = {value} {_string(v.text)};")
        for v, start in zip(self.states, self._starts(), strict=True):
            lines.append(f"  Real {_head(v, start=start, fixed='true')} {_string(v.text)};")
        for v in self.outputs:
            lines.append(f"  output Real {_head(v)} {_string(v.text)};")
        s = self.system.switching
        for k, condition in enumerate(s.conditions):
            if condition.pieces is None:
                owner, text = s.relation_text(k, 1.0)
                lines.append(f"  Boolean c{k + 1} {_string(f'{owner}: {text}')};")
        for condition in (*s.timed, *s.conditions):
            if condition.pieces is not None:
                listed = [*range(condition.pieces.width), "back", "place"]
                names = ", ".join(f"s{condition.mode}_{i}" for i in listed)
                lines.append(f"  Real {names} {_string(f'{condition.name}: piece of a table')};")
        for name, term in self.writer.variables:
            lines.append(f"  {'Boolean' if term.logical else 'Real'} {name};")
        return lines

    def _starts(self) -> list[str]:
        """Start value of each state as text."""
        form, system = self.interface.form, self.system
        picked = form.states[system.structure.in_use] if system.structure.in_use else ca.SX(0, 1)
        function = ca.Function("starts", [system.inputs[1]], [ca.densify(picked)])
        theta = [TextTerm(_quoted(v.name)) for v in self.given]
        (found,) = self.writer.written(function, [theta], inline=True)
        return [real(term).text for term in found]


def _side(term: TextTerm) -> str:
    return f"({term.text})" if term.binds == 0 else term.text


def _head(shown: Shown, **more: str) -> str:
    """Name and modifiers of a variable."""
    facts = {"unit": f'"{shown.unit}"', **more}
    facts |= {key: repr(shown.limits[key]) for key in ("min", "max") if key in shown.limits}
    return f"{_quoted(shown.name)}({', '.join(f'{k}={v}' for k, v in facts.items())})"


def _quoted(name: str) -> str:
    return "'" + name.replace("\\", "\\\\").replace("'", "\\'") + "'"


def _string(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
