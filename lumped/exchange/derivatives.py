"""Derivatives of the functions that an importer sees, along a direction and back."""

from __future__ import annotations

import casadi as ca

from lumped.exchange.interface import Interface


def derivative_functions(interface: Interface, *, reverse: bool) -> dict[str, ca.Function]:
    """Derivatives of rates, outputs and event indicators, and of the states at the start.

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
        (rates + outputs + indicators,). "start_forward" takes a direction in which only states
        that can be set count, and gives derivatives of all states and of what they miss;
        "start_reverse" takes weights of both. All take their factors behind the parameters, as all
        functions have the same arguments.
    """
    system = interface.system
    x, p, t, m = system.inputs
    known = ca.vertcat(x, p, t)
    margins = ca.SX(0, 1)
    if interface.margins:
        margins = sum(system.margins(*system.inputs), start=ca.SX(0))
    found = ca.vertcat(system.rates, interface.output_expressions, margins)

    def function(name: str, count: int, *, transposed: bool) -> ca.Function:
        factors = ca.SX.sym(name, count)
        product = ca.cse(ca.jtimes(found, known, factors, transposed))
        return ca.Function(name, [x, ca.vertcat(p, factors), t, m], [ca.densify(product)])

    made = {
        "forward": function("forward", known.numel(), transposed=False),
        "start_forward": _start_forward(interface),
    }
    if reverse:
        made["reverse"] = function("reverse", found.numel(), transposed=True)
        made["start_reverse"] = _start_reverse(interface)
    return made


def _start_forward(interface: Interface) -> ca.Function:
    """Derivatives of all states but those that are solved for, and of what these must meet."""
    form, (x, p, t, m) = interface.form, interface.system.inputs
    every = interface.system.structure.values.states
    of_x, of_p = ca.SX.sym("of_x", x.numel()), ca.SX.sym("of_p", p.numel())
    of_t = ca.SX.sym("of_t")
    slopes = ca.jtimes(form.states, ca.vertcat(p, t), ca.vertcat(of_p, of_t))
    for i, place in _settable(interface):
        slopes[place] += of_x[i]
    missed = ca.SX(0, 1)
    if form.rows:
        along = ca.vertcat(slopes, of_p, of_t)
        missed = ca.jtimes(form.miss, ca.vertcat(every, p, t), along)[form.rows]
    inputs = [every, ca.vertcat(p, of_x, of_p, of_t), t, m]
    product = ca.cse(ca.densify(ca.vertcat(slopes, missed)))
    return ca.Function("start_forward", inputs, [product])


def _start_reverse(interface: Interface) -> ca.Function:
    """The transposed of `_start_forward`: derivatives by states that can be set, p and t."""
    form, (x, p, t, m) = interface.form, interface.system.inputs
    every = interface.system.structure.values.states
    weights, factors = ca.SX.sym("weights", every.numel()), ca.SX.sym("factors", len(form.rows))
    by_all, by_rest = ca.SX(weights), ca.SX.zeros(p.numel() + 1)
    if form.rows:
        spread = ca.SX.zeros(form.miss.numel())
        spread[form.rows] = factors
        back = ca.jtimes(form.miss, ca.vertcat(every, p, t), spread, True)
        by_all, by_rest = by_all + back[: every.numel()], back[every.numel() :]
    by_rest += ca.jtimes(form.states, ca.vertcat(p, t), by_all, True)
    by_x = ca.SX.zeros(x.numel())
    for i, place in _settable(interface):
        by_x[i] = by_all[place]
    inputs = [every, ca.vertcat(p, weights, factors), t, m]
    product = ca.cse(ca.densify(ca.vertcat(by_x, by_rest)))
    return ca.Function("start_reverse", inputs, [product])


def _settable(interface: Interface) -> list[tuple[int, int]]:
    """States that can be set before a run: number of each, and place among all states."""
    places = interface.system.structure.in_use
    return [(i, places[i]) for i, free in enumerate(interface.settable_states) if free]
