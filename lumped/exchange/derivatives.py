"""Derivatives of the functions that an importer sees, along a direction and back."""

from __future__ import annotations

import casadi as ca

from lumped.exchange.interface import Interface

__all__ = ["derivative_functions"]


def derivative_functions(interface: Interface, *, reverse: bool) -> dict[str, ca.Function]:
    """Derivatives of the rates and outputs by states, parameters and the time.

    Positions of conditions and holds stay; implicit quantities follow the states, as the last step
    of Newton's method holds their derivatives.

    Parameters
    ----------
    interface : Interface
    reverse : bool
        Whether products with the transposed Jacobian are wanted too.

    Returns
    -------
    dict of str to Function
        "forward" takes a direction of shape (states + parameters + 1,), "reverse" weights of shape
        (rates + outputs,); both take them behind the parameters, as all functions have the same
        arguments.
    """
    x, p, t, m = interface.system.inputs
    known = ca.vertcat(x, p, t)
    found = ca.vertcat(interface.system.rates, interface.output_expressions)

    def function(name: str, count: int, *, transposed: bool) -> ca.Function:
        factors = ca.SX.sym(name, count)
        product = ca.cse(ca.jtimes(found, known, factors, transposed))
        return ca.Function(name, [x, ca.vertcat(p, factors), t, m], [ca.densify(product)])

    made = {"forward": function("forward", known.numel(), transposed=False)}
    if reverse:
        made["reverse"] = function("reverse", found.numel(), transposed=True)
    return made
