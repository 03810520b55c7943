"""Steady state, steady rotation and rest."""

import numpy as np
import pytest
from rows import assemble_row, in_a_row
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import SolverError


def loaded(**load):
    """Motor torque, elastic shaft, gear and loaded body."""
    return in_a_row(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5, w=100.0),
        shaft=SpringDamper(c=400.0, d=0.2),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0, phi=0.4),
        **load,
    )


# -- steady rotation ---------------------------------------------------------------------------


@pytest.mark.parametrize("keep", [[], ["b.phi"], ["a.phi", "b.phi"]])
def test_a_loaded_drive_turns_at_its_given_speed_with_twisted_shaft(keep):
    system = lp.assemble(loaded(load=Torque(tau=-120.0)), keep=keep)
    point = lp.equilibrium(system)
    assert point["a.w"] == pytest.approx(100.0, rel=1e-12)
    assert point["b.w"] == pytest.approx(25.0, rel=1e-12)
    # the twist that carries the motor torque; negative as flange a drives
    assert point["shaft.phi_rel"] == pytest.approx(-30.0 / 400.0, rel=1e-10)
    run = lp.simulate(system, until=2.0, start=point, grid=4, rtol=1e-9)
    assert run["a.w"] == pytest.approx(np.full(5, 100.0), rel=1e-9)
    if keep:
        assert run["b.phi"] == pytest.approx(0.4 + 25.0 * run.t, rel=1e-9)


class Coupling(lp.Component):
    """Elastic coupling that hardens, without a twist of its own: tau = c (b - a) + k (b - a)^3."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", 200.0)
    k: lp.Param = lp.param("N.m/rad3", "hardening", 5e4)

    def equations(self):
        twist = self.flange_b.phi - self.flange_a.phi
        yield self.flange_b.tau == self.c * twist + self.k * twist**3
        yield self.flange_a.tau == -self.flange_b.tau


def coupled(**coupling):
    return in_a_row(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5, w=100.0),
        coupling=Coupling(**coupling),
        b=Inertia(J=2.0),
        load=Torque(tau=-30.0),
    )


def test_a_drive_of_absolute_angles_turns_steadily_too():
    system = lp.assemble(coupled())
    assert {"a.phi", "b.phi"} <= set(system.state_names)
    point = lp.equilibrium(system)
    twist = brentq(lambda x: 200.0 * x + 5e4 * x**3 + 30.0, -1, 0, xtol=1e-15)
    assert point["b.phi"] - point["a.phi"] == pytest.approx(twist, rel=1e-9)
    assert [point["a.w"], point["b.w"]] == pytest.approx([100.0, 100.0], rel=1e-12)
    rest = lp.equilibrium(system, rest=True)
    assert rest["b.phi"] - rest["a.phi"] == pytest.approx(twist, rel=1e-9)
    assert [rest["a.w"], rest["b.w"]] == [0.0, 0.0]


@pytest.mark.parametrize("keep", [[], ["fluid.phi_rel"], ["a.phi", "fluid.phi_rel"]])
def test_a_fluid_coupling_slips_steadily(keep):
    model = in_a_row(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5),
        fluid=Damper(d=2.0),
        b=Inertia(J=2.0),
        fan=Damper(d=0.5),
        wall=Fixed(),
    )
    point = lp.equilibrium(lp.assemble(model, keep=keep))
    assert point["b.w"] == pytest.approx(30.0 / 0.5, rel=1e-10)
    assert point["a.w"] == pytest.approx(30.0 / 0.5 + 30.0 / 2.0, rel=1e-10)


class Rotor(lp.Component):
    """Rotor without an angle: J der(w) = tau."""

    w: lp.Var = lp.var("rad/s", "speed", 3.0)

    def equations(self):
        yield 2.0 * lp.der(self.w) == 4.0


def test_a_speed_that_nothing_depends_on_must_not_grow():
    model = lp.compose(rotor=Rotor(), body=Inertia(J=1.0))
    with pytest.raises(SolverError, match=r"der\(rotor\.w\) stays at 2"):
        lp.equilibrium(lp.assemble(model))


class Tether(lp.Component):
    """Very soft spring to ground: tau = c phi."""

    flange = lp.Flange()

    def equations(self):
        yield self.flange.tau == 1e-2 * self.flange.phi


def test_a_soft_tether_beside_a_stiff_coupling_keeps_a_drive_from_turning_for_ever():
    model = in_a_row(
        motor=Torque(tau=0.5),
        a=Inertia(J=0.5, w=100.0),
        coupling=Coupling(c=1e6),
        b=Inertia(J=2.0),
        tether=Tether(),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["b.phi"] == pytest.approx(0.5 / 1e-2, rel=1e-6)
    assert [point["a.w"], point["b.w"]] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_motor_torque_follows_from_the_speed_that_it_shall_hold():
    system = lp.assemble(loaded(brake=Damper(d=3.0), wall=Fixed()))
    point = lp.equilibrium(system, free=["motor.tau"])
    assert point["a.w"] == pytest.approx(100.0, rel=1e-12)
    # 4 tau = d w / 4
    assert point.parameters["motor.tau"] == pytest.approx(3.0 * 100.0 / 16.0, rel=1e-10)


def test_a_speed_that_is_no_state_is_kept_too():
    system = assemble_row(
        motor=Torque(tau=1.0),
        a=Inertia(J=0.5),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0),
        brake=Damper(d=3.0),
        wall=Fixed(),
    )
    for name, value in {"a.w": 80.0, "b.w": 20.0}.items():
        point = lp.equilibrium(system, start={name: value}, free=["motor.tau"])
        assert [point["a.w"], point["b.w"]] == pytest.approx([80.0, 20.0], rel=1e-12)
        assert point.parameters["motor.tau"] == pytest.approx(3.0 * 20.0 / 4.0, rel=1e-10)


def test_an_initial_equation_goes_on_to_hold_at_an_equilibrium():
    model = in_a_row(
        a=Inertia(J=0.5),
        shaft=SpringDamper(c=400.0, d=0.2),
        b=Inertia(J=2.0),
        initial_equations=lambda m: [m.a.w + m.b.w == 50.0],
    )
    point = lp.equilibrium(lp.assemble(model))
    assert [point["a.w"], point["b.w"]] == pytest.approx([25.0, 25.0], rel=1e-10)


# -- rest --------------------------------------------------------------------------------------


def hoist():
    """A load on a rope over a drum that an elastic brake holds; it was given speeds."""
    return in_a_row(
        wall=Fixed(),
        brake=Spring(c=900.0),
        drum=Inertia(J=0.3, w=20.0),
        rope=SpringDamper(c=50.0, d=0.1),
        load=Inertia(J=1.0, w=20.0),
        weight=Torque(tau=-45.0),
    )


def test_at_rest_springs_carry_the_load_whatever_speeds_were_given():
    system = lp.assemble(hoist())
    point = lp.equilibrium(system, rest=True)
    received = [point[n] for n in ("drum.w", "load.w", "drum.a", "load.a")]
    assert received == pytest.approx([0.0] * 4, abs=1e-9)
    assert point["brake.phi_rel"] == pytest.approx(-45.0 / 900.0, rel=1e-10)
    assert point["rope.phi_rel"] == pytest.approx(-45.0 / 50.0, rel=1e-10)


@pytest.mark.parametrize("keep", [[], ["a.phi"]])
def test_a_balanced_drive_rests_where_it_was_put(keep):
    system = lp.assemble(loaded(load=Torque(tau=-120.0)), keep=keep)
    point = lp.equilibrium(system, rest=True)
    assert [point["a.w"], point["b.w"]] == [0.0, 0.0]
    assert point["shaft.phi_rel"] == pytest.approx(-30.0 / 400.0, rel=1e-10)
