"""What a reference case says, and what its model is built of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import lumped as lp


@dataclass(frozen=True)
class Case:
    """One reference case.

    Attributes
    ----------
    system : System
        The model.
    until : float
        End of the run, s.
    of : dict
        Functionals by their names in the file. A pair is a function of numbers, and the
        functionals and parameters that these are.
    to : dict
        Names here of parameters of the file, where they differ.
    runs : dict
        Ends of the run for functionals that look at another part, s.
    until_by : dict
        Derivatives of the end of the run by parameters.
    """

    system: lp.System
    until: float
    of: Mapping[str, object]
    to: Mapping[str, str] = field(default_factory=dict)
    runs: Mapping[str, float] = field(default_factory=dict)
    until_by: Mapping[str, float] = field(default_factory=dict)


def given(p):
    """Parameters with the values of a file."""
    return {key: lp.param("1", key, value) for key, value in p.items()}


def one(equations, data, keep=(), initial=None, **variables):
    """A system of one component, called Body."""
    body = {"equations": equations, "__doc__": "See equations.", **data, **variables}
    if initial is not None:
        body["initial_equations"] = initial
    return lp.assemble(type("Body", (lp.Component,), body)(), keep=list(keep))


def held(start=0.0):
    """A state."""
    return lp.var("1", "state", start=start, state="always")


def free():
    """A quantity."""
    return lp.var("1", "quantity")


def rub(reaction, speed, kinetic, static=None, **more):
    """Dry friction; it holds what it bears while it slides unless its limit at rest is given."""
    static = kinetic if static is None else static
    limits = {"forward": kinetic, "backward": -kinetic, "upper": static, "lower": -static}
    return lp.hold(reaction, speed, **limits, **more)


class Cases(dict[str, Callable[[Mapping[str, float]], Case]]):
    """Cases of one subject; called as a decorator, it notes one by the name of its function."""

    def __call__(self, function):
        """Note a case."""
        self[function.__name__] = function
        return function
