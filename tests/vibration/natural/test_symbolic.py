"""Quantities as expressions of CasADi against formulas derived by hand."""

import casadi as ca
import pytest
from checks import refused
from rows import assemble_row

import lumped as lp
from lumped.components import Clutch, Inertia, SpringDamper
from lumped.errors import OptionError


def value(formula, numbers):
    symbols = ca.symvar(formula)
    return float(ca.Function("f", symbols, [formula])(*(numbers[s.name()] for s in symbols)))


def test_quantities_are_formulas_of_named_symbols():
    system = assemble_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    torque, rate = (lp.expression(system, "shaft.tau"), lp.expression(system, "der(a.w)"))
    numbers = {"shaft.c": 7.0, "shaft.d": 0.3, "shaft.phi_rel": 0.2, "shaft.phi_rel0": 0.05}
    numbers |= {"b.w": 3.0, "a.w": 1.0, "a.J": 2.0}
    expected = 7.0 * 0.15 + 0.3 * 2.0
    assert value(torque, numbers) == pytest.approx(expected, rel=1e-15)
    assert value(rate, numbers) == pytest.approx(expected / 2.0, rel=1e-15)


def test_what_has_no_formula_is_refused():
    system = assemble_row(
        a=Inertia(J=1.0),
        clutch=Clutch(characteristic=((0.0, 0.3),), c_geo=1.0, f_max=10.0, u=1.0),
        b=Inertia(J=1.0),
    )
    refused(OptionError, lambda: lp.expression(system, "der(a.w)"), "modes")
    refused(OptionError, lambda: lp.expression(system, "der(nothing)"), "is no state")
