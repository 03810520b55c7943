"""Equilibria that Newton's method alone does not find."""

import numpy as np
import pytest
from rows import assemble_row, in_rows
from scipy.optimize import brentq

import lumped as lp
from lumped.components import Inertia, QuadraticTorque, SpringDamper, Torque
from lumped.errors import SolverError
from lumped.points import equilibrium_search as module


class Motor(lp.Component):
    """Motor with a steep characteristic: tau_shaft = T tanh((w_0 - w) / s)."""

    flange = lp.Flange()
    T: lp.Param = lp.param("N.m", "largest torque", 80.0)
    w_0: lp.Param = lp.param("rad/s", "speed without load", 150.0)
    s: lp.Param = lp.param("rad/s", "slip", 0.5)

    def equations(self):
        w = lp.der(self.flange.phi)
        yield self.flange.tau == -self.T * lp.ops.tanh((self.w_0 - w) / self.s)


def fan_drive(k, T_0=5.0):
    """A steep motor against the torque T_0 + k w |w|."""
    return in_rows(
        "motor a shaft b load",
        "b fan",
        motor=Motor(),
        a=Inertia(J=0.5),
        shaft=SpringDamper(c=4e4, d=2.0),
        b=Inertia(J=3.0),
        load=Torque(tau=-T_0),
        fan=QuadraticTorque(tau_nominal=-k, w_nominal=1.0),
    )


@pytest.mark.parametrize("k", [0.0, 1e-3, 0.1])
def test_a_steep_motor_runs_up_to_its_steady_speed(k, monkeypatch):
    system = lp.assemble(fan_drive(k), keep=["a.phi"])
    point = lp.equilibrium(system)
    balance = lambda w: 80.0 * np.tanh((150.0 - w) / 0.5) - 5.0 - k * w * abs(w)  # noqa: E731
    expected = brentq(balance, 0.0, 200.0, xtol=1e-13)
    assert point["b.w"] == pytest.approx(expected, rel=1e-9)
    torque = 5.0 + k * expected**2
    assert point["shaft.phi_rel"] == pytest.approx(-torque / 4e4, rel=1e-8)
    if k == 0.0:  # Newton's method alone fails: nothing there reacts to the speed
        monkeypatch.setattr(module, "settle_states", lambda *_: None)
        with pytest.raises(SolverError, match="no equilibrium"):
            lp.equilibrium(system)


class Play(lp.Component):
    """Spring to ground without stiffness in the middle: tau = c (phi - b tanh(phi / b))."""

    flange = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", 300.0)
    b: lp.Param = lp.param("rad", "play", 0.02)

    def equations(self):
        phi = self.flange.phi
        yield self.flange.tau == self.c * (phi - self.b * lp.ops.tanh(phi / self.b))


def test_a_spring_without_stiffness_where_the_search_begins_finds_its_rest(monkeypatch):
    system = assemble_row(drive=Torque(tau=4.0), body=Inertia(J=2.0), spring=Play())
    expected = brentq(lambda p: 300.0 * (p - 0.02 * np.tanh(p / 0.02)) - 4.0, 0, 1, xtol=1e-15)
    for rest in (False, True):
        assert lp.equilibrium(system, rest=rest)["body.phi"] == pytest.approx(expected, rel=1e-9)
    monkeypatch.setattr(module, "settle_states", lambda *_: None)
    with pytest.raises(SolverError, match="no equilibrium"):
        lp.equilibrium(system)


def test_a_load_beyond_the_motor_is_refused():
    # reversed, the fan would drive; a constant load of 90 N.m beats 80 at every speed
    system = lp.assemble(fan_drive(0.0, 90.0))
    with pytest.raises(SolverError, match=r"no equilibrium near the start values: der\("):
        lp.equilibrium(system)
