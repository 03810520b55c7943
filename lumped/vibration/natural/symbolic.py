"""Quantities as expressions of named symbols."""

from __future__ import annotations

import casadi as ca

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.support.arguments import checked


@checked
def expression(system: System, of: Name) -> ca.SX:
    """A quantity as a CasADi expression of symbols that carry the names of the model.

    The symbols are states, parameters and ``time``; ``casadi.symvar`` lists them,
    ``casadi.gradient`` differentiates by them.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : str or reference
        A quantity, or the derivative of a state as ``der(name)``.

    Returns
    -------
    casadi.SX

    Raises
    ------
    UnknownNameError
        If there is no such quantity, or it needs a state that was left out.
    OptionError
        If it depends on modes (what sticks, which branch holds) or is found by iteration; then it
        has no formula of its own.
    """
    return _name_symbols(system, find_expression(system, of))


def find_expression(system: System, of: Name) -> ca.SX:
    """As `expression`, of the symbols of the system."""
    inner = of[4:-1] if isinstance(of, str) and of.startswith("der(") else None
    if inner is None:
        found = system.expressions([of])
    else:
        states = system.state_names
        if inner not in states:
            raise OptionError(f"{system.name}: {inner} is no state. States: {', '.join(states)}.")
        found = system.rates[states.index(inner)]
    settings = system.inputs[3]
    if ca.depends_on(found, settings):
        raise OptionError(
            f"{system.name}: {of} depends on modes or on implicit quantities and has no formula "
            "of its own. Use system.function, which takes them as arguments."
        )
    return found


def _name_symbols(system: System, found: ca.SX) -> ca.SX:
    """With the symbols of the system replaced by named ones."""
    x, theta, time, _ = system.inputs
    names = [*system.state_names, *system.structure.parameters.free_names, "time"]
    symbols = ca.vertcat(*(ca.SX.sym(name) for name in names))
    return ca.substitute(found, ca.vertcat(x, theta, time), symbols)
