"""What a model shows to other tools: parameters, inputs, states and outputs with their units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.language.quantity import Bound
from lumped.points.start import start_point
from lumped.points.start_slopes import StartForm, fix_start, start_form
from lumped.timeloop.clocks import Clock, clocks
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.programs import refuse_programs
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.responses.amplitudes import needing_rates


@dataclass(frozen=True)
class Shown:
    """A variable that other tools see.

    Attributes
    ----------
    name, unit, text : str
        Dotted name, SI unit ("1" without), meaning.
    role : {"time", "parameter", "input", "state", "rate", "output", "indicator"}
        What it is.
    start : float or None
        Value before the run, if it can be set.
    tunable : bool
        Whether a parameter may change during a run.
    state : int
        Value reference of the state of which it is the derivative, 0 for others.
    is_output : bool
        Whether it was asked for as an output.
    bounds : sequence of Bound
        Range of a parameter.
    nominal : float
        Typical size.
    """

    name: str
    unit: str
    text: str
    role: str
    start: float | None = None
    tunable: bool = False
    state: int = 0
    is_output: bool = False
    bounds: Sequence[Bound] = ()
    nominal: float = 1.0


class Interface:
    """Variables of a system and their order; a variable's place is its value reference.

    Parameters
    ----------
    system : System
        From `assemble`.
    inputs, outputs : iterable of names
        Parameters that become inputs, quantities that are outputs.
    start : mapping of name to float, or OperatingPoint
        Start values to set, or all states.

    Raises
    ------
    OptionError
        If the rate of an input would matter, or the system asks programs.
    UnknownNameError
        If a name is unknown.
    """

    def __init__(
        self,
        system: System,
        inputs: Iterable[Name],
        outputs: Iterable[Name],
        start: Changes | OperatingPoint,
    ) -> None:
        refuse_programs(system, "an exported model")
        self.system = system
        self.inputs = self._inputs([system.key(name) for name in inputs])
        asked = [system.key(name) for name in outputs]
        if len(set(asked)) < len(asked) or len(set(self.inputs)) < len(self.inputs):
            raise OptionError(f"{system.name}: name each input and output once.")
        self.point: OperatingPoint
        self.form: StartForm
        if isinstance(start, OperatingPoint):
            self.point, self.form = start, fix_start(start)
        else:
            self.point, self.form = start_point(system, start=start), start_form(system, start)
        self.output_states = [n for n in asked if n in system.state_names]
        self.outputs = [n for n in asked if n not in self.output_states]
        self.output_expressions = system.expressions(self.outputs)

    def _inputs(self, names: list[str]) -> list[str]:
        system = self.system
        free = list(system.parameters)
        for name in names:
            if name not in free:
                raise UnknownNameError(
                    f"{system.name}: '{name}' cannot be an input: it is no parameter with a value "
                    "of its own, and no input given as a number. Give the component a number "
                    f"there. {nearest(name, free)}"
                )
        for name, place in zip(names, system.places(names), strict=True):
            if place in needing_rates(system):
                raise OptionError(
                    f"{system.name}: as an input, {name} would need its rate of change, but the "
                    "model holds it constant. Let a torque or force vary instead, or prescribe the "
                    "motion by a component with its acceleration as input and der(w) == a."
                )
        return names

    @cached_property
    def settable_states(self) -> list[bool]:
        """States whose start value follows from no parameter and no other start value."""
        states, theta = self.form.states, self.system.inputs[1]
        bound = set(ca.jacobian_sparsity(states, theta).get_triplet()[0]) | set(self.form.columns)
        return [i not in bound for i in self.system.structure.in_use]

    @cached_property
    def variables(self) -> list[Shown]:
        """All variables in the order of their value references."""
        system, p = self.system, self.system.structure.parameters
        fixed = needing_rates(system)
        found = [Shown("time", "s", "time", "time")]
        for place, (number, start) in enumerate(zip(p.free, p.defaults.tolist(), strict=True)):
            declared, name = p.declared[number], p.names[number]
            role = "input" if name in self.inputs else "parameter"
            found.append(
                Shown(
                    name,
                    declared.unit,
                    declared.text,
                    role,
                    start,
                    tunable=place not in fixed,
                    bounds=declared.bounds,
                )
            )
        first = len(found)
        starts, sizes = self._start_states(), nominals(system).tolist()
        rates = []
        for i, name in enumerate(system.state_names):
            unit, text = self._describe(name)
            start = starts[i] if self.settable_states[i] else None
            output = name in self.output_states
            found.append(
                Shown(name, unit, text, "state", start, is_output=output, nominal=sizes[i])
            )
            own = _derivative(name), rate_unit(unit), f"derivative of: {text}"
            rates.append(Shown(*own, "rate", state=first + i))
        found += rates
        for name in self.outputs:
            quantity = system.quantity(name)
            found.append(Shown(name, quantity.unit, quantity.text, "output", is_output=True))
        for i in range(self.margins):
            text = "negative as soon as a mode must change"
            found.append(Shown(f"margins[{i + 1}]", "1", text, "indicator"))
        return found

    def _start_states(self) -> list[float]:
        function = ca.Function("x", [self.system.inputs[1]], [self.form.states])
        values = np.asarray(function(self.point.theta)).ravel()
        return [float(values[i]) for i in self.system.structure.in_use]

    def _describe(self, name: str) -> tuple[str, str]:
        """Unit and text of a state, which may be a derivative."""
        inner = name.replace("der(", "").rstrip(")")
        quantity = self.system.quantity(inner)
        unit = quantity.unit
        for _ in range(name.count("der(")):
            unit = rate_unit(unit)
        return unit, ("derivative of: " if inner != name else "") + quantity.text

    @property
    def margins(self) -> int:
        """Number of event indicators."""
        return int(self.system.margins.size1_out(0)) if self.system.switching else 0


def refuse_doubles(interface: Interface) -> None:
    """Refuse outputs whose names another variable has, for files in which names are unique.

    Raises
    ------
    OptionError
        If an output is a parameter or an input, or two formulas have the same text.
    """
    system = interface.system
    taken = set(system.parameters)
    for name in map(str, (*interface.output_states, *interface.outputs)):
        if name in system.parameters:
            kind = "an input" if name in interface.inputs else "a parameter"
            raise OptionError(
                f"{system.name}: '{name}' cannot be an output: it is {kind}, whose value is known. "
                "Leave it out of the outputs."
            )
        if name in taken:
            raise OptionError(
                f"{system.name}: two outputs have the text '{name}'. Declare a variable for one."
            )
        taken.add(name)


def _derivative(name: str) -> str:
    """Name of the derivative of a state as structured names have it."""
    inner = name.replace("der(", "").rstrip(")")
    order = name.count("der(") + 1
    return f"der({inner})" if order == 1 else f"der({inner},{order})"


def rate_unit(unit: str) -> str:
    """Unit of a time derivative."""
    powers = re.search(r"/s(\d*)$", unit)
    if powers:
        return f"{unit[: powers.start()]}/s{int(powers.group(1) or 1) + 1}"
    if "/" not in unit:
        return f"{unit}/s"
    above, below = unit.split("/", 1)
    return f"{above}/({below.strip('()')}.s)"


def uneven_clocks(system: System) -> list[Clock]:
    """Functions of time whose instants the C code cannot tell beforehand.

    Systems with some are exported `without_foresight`.
    """
    return [timed for timed in clocks(system) if timed.moves and not timed.even]
