"""Formulas against hand-derived ones, numbers of `modes`, and derivatives of eigenvalues."""

import casadi as ca
import numpy as np
import pytest
from checks import refused
from drive_chains import in_turn
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Clutch, CrankSlider, Fixed, IdealGear, Inertia, Spring, SpringDamper
from lumped.errors import OptionError
from lumped.models.reversing_mill import stand
from lumped.models.reversing_mill.stand import OpenGap


def value(formula, numbers):
    symbols = ca.symvar(formula)
    return float(ca.Function("f", symbols, [formula])(*(numbers[s.name()] for s in symbols)))


def drive(bodies, grounded=False, ratio=1.0):
    rng = np.random.default_rng(bodies)
    parts = [Inertia(J=float(J)) for J in rng.uniform(0.2, 4.0, bodies)]
    shafts = [Spring(c=float(c)) for c in rng.uniform(1e2, 1e4, bodies)]

    end = {"ground": Fixed()} if grounded else {"gear": IdealGear(ratio=ratio), "far": Inertia(J=3)}
    return lp.assemble(in_turn(end, body=parts, shaft=shafts))


def test_two_inertias_have_the_formula_of_every_textbook(two_mass):
    system = lp.assemble(two_mass)
    (formula,) = lp.vibration.symbolic_frequencies(system)
    names = sorted(s.name() for s in ca.symvar(formula))
    assert names == ["a.J", "b.J", "shaft.c"]
    for J_a, J_b, c in ((1.0, 2.0, 300.0), (0.1, 77.0, 5e6)):
        numbers = {"a.J": J_a, "b.J": J_b, "shaft.c": c}
        assert value(formula, numbers) == pytest.approx(
            np.sqrt(c * (J_a + J_b) / (J_a * J_b)), rel=1e-14
        )


@pytest.mark.parametrize("bodies", [1, 2, 3])
@pytest.mark.parametrize("grounded", [True, False])
def test_formulas_agree_with_the_eigenvalues_and_their_derivatives(bodies, grounded):
    system = drive(bodies, grounded, ratio=2.5)
    modes = lp.modes(system)
    formulas = lp.vibration.symbolic_frequencies(system)
    found = [value(f, system.parameters) for f in formulas]
    assert found == pytest.approx(2 * np.pi * modes.hertz, rel=1e-11)
    sensitivity = lp.vibration.eigen_sensitivity(modes)
    for k, formula in enumerate(formulas):
        for symbol in ca.symvar(formula):
            derivative = value(ca.gradient(formula, symbol), system.parameters) / (2 * np.pi)
            expected = sensitivity.hertz[k, sensitivity.by.index(symbol.name())]
            assert derivative == pytest.approx(expected, rel=1e-9, abs=1e-13)


def test_quantities_are_formulas_of_named_symbols():
    system = assemble_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    torque, rate = (lp.expression(system, "shaft.tau"), lp.expression(system, "der(a.w)"))
    numbers = {"shaft.c": 7.0, "shaft.d": 0.3, "shaft.phi_rel": 0.2, "shaft.phi_rel0": 0.05}
    numbers |= {"b.w": 3.0, "a.w": 1.0, "a.J": 2.0}
    expected = 7.0 * 0.15 + 0.3 * 2.0
    assert value(torque, numbers) == pytest.approx(expected, rel=1e-15)
    assert value(rate, numbers) == pytest.approx(expected / 2.0, rel=1e-15)


def test_what_has_no_formula_is_refused():
    refused(OptionError, lambda: lp.vibration.symbolic_frequencies(drive(4)), "4 oscillating modes")
    damped = in_a_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    with pytest.raises(OptionError, match="is damped"):
        lp.vibration.symbolic_frequencies(lp.assemble(damped))
    slider = CrankSlider(r=0.1, L=0.4, m=2.0)
    crank = in_a_row(wheel=Inertia(J=1.0), shaft=Spring(c=10.0), crank=slider)
    with pytest.raises(OptionError, match="not linear"):
        lp.vibration.symbolic_frequencies(lp.assemble(crank))
    system = assemble_row(
        a=Inertia(J=1.0),
        clutch=Clutch(characteristic=((0.0, 0.3),), c_geo=1.0, f_max=10.0, u=1.0),
        b=Inertia(J=1.0),
    )
    refused(OptionError, lambda: lp.expression(system, "der(a.w)"), "modes")
    refused(OptionError, lambda: lp.expression(system, "der(nothing)"), "is no state")


def test_separate_branches_without_a_damper_have_formulas():
    system = lp.assemble(OpenGap())
    found = lp.vibration.symbolic_frequencies(system)
    upper, lower = (
        np.sqrt(np.linalg.eigvalsh(np.diag(J**-0.5) @ K @ np.diag(J**-0.5)))[1:]
        for J, K in branches()
    )
    expected = np.sort([*upper, *lower])
    assert [value(f, system.parameters) for f in found] == pytest.approx(expected, rel=1e-12)


def branches():
    """Inertias and stiffnesses of both halves of the open stand."""
    C1, C2 = float(stand.C_SHAFT), float(stand.C_SPINDLE)
    J1, J3, J = float(stand.J_MOTOR), float(stand.J_GEARBOX), float(stand.J_BACKUP + stand.J_WORK)
    yield np.array([J1, J3, J]), np.array([[C1, -C1, 0], [-C1, C1 + C2, -C2], [0, -C2, C2]])
    yield np.array([J1 + J3, J]), np.array([[C2, -C2], [-C2, C2]])
