"""Quantities and natural frequencies as formulas of named parameters."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.numerics.skew_scaling import two_colours
from lumped.points.start import start_point
from lumped.support.arguments import checked

_MOST = 3


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
    return _name_symbols(system, found)


@checked
def symbolic_frequencies(system: System) -> tuple[ca.SX, ...]:
    """Natural frequencies of a small undamped linear drive as formulas of its parameters.

    Torsions and speeds alternate: ``der(torsions) == B speeds``, ``der(speeds) == C torsions``, so
    the squares are eigenvalues of ``-B C`` (or ``-C B``, whichever is smaller), which up to three
    are the roots of a polynomial in closed form.

    Parameters
    ----------
    system : System
        From `assemble`.

    Returns
    -------
    tuple of SX
        Natural frequencies, rad/s, ascending.

    Raises
    ------
    OptionError
        If the drive is damped or not linear, or has more than three oscillating modes.
    """
    x, theta, time, settings = system.inputs
    A = ca.jacobian(system.rates, x)
    if ca.depends_on(A, ca.vertcat(x, time, settings)):
        raise OptionError(
            f"{system.name}: the drive is not linear; its frequencies depend on where it is. "
            "Use modes with an operating point."
        )
    used = np.flatnonzero(~np.isin(system.structure.states, list(system.structure.cyclic)))
    A = A[used.tolist(), used.tolist()]
    point = start_point(system)
    numbers = scipy.sparse.csr_array(ca.Function("A", [theta], [A])(point.theta).sparse())
    numbers.eliminate_zeros()
    colour = two_colours(numbers)
    if colour is None:
        raise OptionError(
            f"{system.name}: the drive is damped, so its natural frequencies have no short "
            "formula. Take Spring for SpringDamper, or set the damping to zero."
        )
    one, two = (np.flatnonzero(side).tolist() for side in (colour, ~colour))
    if len(two) < len(one):
        one, two = two, one
    if len(one) > _MOST:
        raise OptionError(
            f"{system.name}: {len(one)} oscillating modes; formulas are given for up to {_MOST}. "
            "Use modes."
        )
    squares = _roots(-A[one, two] @ A[two, one])
    return tuple(ca.vertsplit(_name_symbols(system, ca.sqrt(ca.vertcat(*squares)))))


def _roots(G: ca.SX) -> list[ca.SX]:
    """Eigenvalues of a matrix with real ones only, ascending."""
    n = G.shape[0]
    trace = ca.trace(G)
    if n < 2:
        return [trace] * n
    minors = sum(G[i, i] * G[k, k] - G[i, k] * G[k, i] for i in range(n) for k in range(i + 1, n))
    if n == 2:
        large = (trace + ca.sqrt(trace**2 - 4 * minors)) / 2
        return [minors / large, large]
    # three real roots: y**3 - 3 p y - 2 q = 0 around the mean, by the cosine of a third
    mean = trace / 3
    p = mean**2 - minors / 3
    q = mean**3 - mean * minors / 2 + ca.det(G) / 2
    angle = ca.acos(ca.fmin(ca.fmax(q / p**1.5, -1), 1)) / 3
    parts = (2 * np.pi / 3, -2 * np.pi / 3, 0.0)
    return [mean + 2 * ca.sqrt(p) * ca.cos(angle + part) for part in parts]


def _name_symbols(system: System, found: ca.SX) -> ca.SX:
    """With the symbols of the system replaced by named ones."""
    x, theta, time, _ = system.inputs
    names = [*system.state_names, *system.structure.parameters.free_names, "time"]
    symbols = ca.vertcat(*(ca.SX.sym(name) for name in names))
    return ca.substitute(found, ca.vertcat(x, theta, time), symbols)
