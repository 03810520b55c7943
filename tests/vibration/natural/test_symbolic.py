"""Formulas against hand-derived ones, numbers of `modes`, and derivatives of eigenvalues."""

import casadi as ca
import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Clutch, CrankSlider, Fixed, IdealGear, Inertia, Spring, SpringDamper
from lumped.errors import OptionError


def value(formula, system):
    symbols = ca.symvar(formula)
    numbers = [system.parameters[s.name()] for s in symbols]
    return float(ca.Function("f", symbols, [formula])(*numbers))


def drive(bodies, grounded=False, ratio=1.0):
    rng = np.random.default_rng(bodies)
    parts = [Inertia(J=float(J)) for J in rng.uniform(0.2, 4.0, bodies)]
    shafts = [Spring(c=float(c)) for c in rng.uniform(1e2, 1e4, bodies)]

    def joints(m):
        for i in range(bodies - 1):
            yield from lp.chain(m.body[i], m.shaft[i], m.body[i + 1])
        end = [m.ground] if grounded else [m.gear, m.far]
        yield from lp.chain(m.body[bodies - 1], m.shaft[bodies - 1], *end)

    end = {"ground": Fixed()} if grounded else {"gear": IdealGear(ratio=ratio), "far": Inertia(J=3)}
    return lp.assemble(lp.compose(body=parts, shaft=shafts, **end, connections=joints))


def test_two_inertias_have_the_formula_of_every_textbook(two_mass):
    system = lp.assemble(two_mass)
    (formula,) = lp.vibration.symbolic_frequencies(system)
    names = sorted(s.name() for s in ca.symvar(formula))
    assert names == ["a.J", "b.J", "shaft.c"]
    for J_a, J_b, c in ((1.0, 2.0, 300.0), (0.1, 77.0, 5e6)):
        numbers = {"a.J": J_a, "b.J": J_b, "shaft.c": c}
        symbols = ca.symvar(formula)
        found = ca.Function("f", symbols, [formula])(*(numbers[s.name()] for s in symbols))
        assert float(found) == pytest.approx(np.sqrt(c * (J_a + J_b) / (J_a * J_b)), rel=1e-14)


@pytest.mark.parametrize("bodies", [1, 2, 3])
@pytest.mark.parametrize("grounded", [True, False])
def test_formulas_agree_with_the_eigenvalues_and_their_derivatives(bodies, grounded):
    system = drive(bodies, grounded, ratio=2.5)
    modes = lp.modes(system)
    formulas = lp.vibration.symbolic_frequencies(system)
    found = [value(f, system) for f in formulas]
    assert found == pytest.approx(2 * np.pi * modes.hertz, rel=1e-11)
    sensitivity = lp.vibration.eigen_sensitivity(modes)
    for k, formula in enumerate(formulas):
        for symbol in ca.symvar(formula):
            derivative = value(ca.gradient(formula, symbol), system) / (2 * np.pi)
            expected = sensitivity.hertz[k, sensitivity.by.index(symbol.name())]
            assert derivative == pytest.approx(expected, rel=1e-9, abs=1e-13)


def test_quantities_are_formulas_of_named_symbols():
    model = in_a_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    system = lp.assemble(model)
    torque, rate = (lp.expression(system, "shaft.tau"), lp.expression(system, "der(a.w)"))
    symbols = {s.name(): s for s in ca.symvar(torque)}
    numbers = {"shaft.c": 7.0, "shaft.d": 0.3, "shaft.phi_rel": 0.2, "shaft.phi_rel0": 0.05}
    numbers |= {"b.w": 3.0, "a.w": 1.0, "a.J": 2.0}
    at = [numbers[name] for name in symbols]
    expected = 7.0 * 0.15 + 0.3 * 2.0
    found = ca.Function("f", list(symbols.values()), [torque])(*at)
    assert float(found) == pytest.approx(expected, rel=1e-15)
    symbols = ca.symvar(rate)
    found = ca.Function("f", symbols, [rate])(*(numbers[s.name()] for s in symbols))
    assert float(found) == pytest.approx(expected / 2.0, rel=1e-15)


def test_what_has_no_formula_is_refused():
    with pytest.raises(OptionError, match="4 oscillating modes"):
        lp.vibration.symbolic_frequencies(drive(4))
    damped = in_a_row(a=Inertia(J=2.0), shaft=SpringDamper(c=3.0, d=0.5), b=Inertia(J=4.0))
    with pytest.raises(OptionError, match="is damped"):
        lp.vibration.symbolic_frequencies(lp.assemble(damped))
    crank = lp.compose(
        wheel=Inertia(J=1.0),
        shaft=Spring(c=10.0),
        crank=CrankSlider(r=0.1, L=0.4, m=2.0),
        connections=lambda m: [
            lp.connect(m.wheel.flange_b, m.shaft.flange_a),
            lp.connect(m.shaft.flange_b, m.crank.flange),
        ],
    )
    with pytest.raises(OptionError, match="not linear"):
        lp.vibration.symbolic_frequencies(lp.assemble(crank))
    clutch = in_a_row(
        a=Inertia(J=1.0),
        clutch=Clutch(characteristic=((0.0, 0.3),), c_geo=1.0, f_max=10.0, u=1.0),
        b=Inertia(J=1.0),
    )
    system = lp.assemble(clutch)
    with pytest.raises(OptionError, match="modes"):
        lp.expression(system, "der(a.w)")
    with pytest.raises(OptionError, match="is no state"):
        lp.expression(system, "der(nothing)")
