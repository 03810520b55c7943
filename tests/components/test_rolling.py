"""Load of a rolling pass against the balance of the strip, coasting and energy."""

import numpy as np
import pytest
from rows import assemble_rows, in_a_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import (
    Fixed,
    Inertia,
    Position,
    RollingTorque,
    Speed,
    Spring,
    StripPass,
    Torque,
)
from lumped.errors import ParameterError

J, F, A, R = 50.0, 2e6, 0.012, 0.4
FORMING = 2 * F * A


def rolls(until, w=0.0, tau=0.0, grid=400, **given):
    """Rolls with their drive; what is given goes to the pass."""
    values = {"F": F, "a": A, "R": R, "T_back": 0.0, "T_front": 0.0} | given
    model = in_a_row(drive=Torque(tau=tau), body=Inertia(J=J, w=w), gap=RollingTorque(**values))
    system = lp.assemble(model, keep=["body.phi"])
    return lp.simulate(system, until=until, rtol=1e-10, grid=grid)


@pytest.mark.parametrize(("T_back", "T_front"), [(0.0, 0.0), (3e5, 0.0), (1e5, 4e5)])
def test_the_torque_is_that_of_the_shear_that_balances_the_strip(T_back, T_front):
    """Shear of the roll on the strip, integrated over the arc of contact."""
    bite, b, top = 0.08, 1.2, 9e8  # rad, m, Pa; the pressure falls to both ends

    def pressure(x):
        return top * x * (bite - x) / bite**2

    # per roll; angles small: force b R int p dx, its lever arm from the line of the axes
    force = b * R * quad(pressure, 0, bite)[0]
    arm = b * R**2 * quad(lambda x: pressure(x) * x, 0, bite)[0] / force
    # pressure pushes the strip back, shear forward: 2 shear - 2 int p x = T_back - T_front
    back = b * R * quad(lambda x: pressure(x) * x, 0, bite)[0]
    shear = back + (T_back - T_front) / 2
    model = in_a_row(
        turn=Speed(w=1.0), gap=RollingTorque(F=force, a=arm, R=R, T_back=T_back, T_front=T_front)
    )
    received = lp.start_point(lp.assemble(model))["gap.tau"]
    assert received == pytest.approx(2 * R * shear, rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_rolls_that_coast_stop_in_the_strip_and_stay(side):
    T_back, T_front = (1e5, 4e4) if side > 0 else (4e4, 1e5)
    run = rolls(2.0, w=8.0 * side, T_back=T_back, T_front=T_front)
    rate = (FORMING + 6e4 * R) / J
    stop = 8.0 / rate
    expected = side * np.where(run.t < stop, 8.0 - rate * run.t, 0.0)
    assert run["body.w"] == pytest.approx(expected, abs=1e-8)
    assert run["gap.position"][-1] == 0
    # at rest the strip holds the tensions
    assert run["gap.tau"][-1] == pytest.approx(0.0, abs=1e-6)
    assert run["gap.tau_f"][-1] == pytest.approx(-side * 6e4 * R, rel=1e-9)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_front_tension_pulls_resting_rolls_along_only_beyond_the_torque_of_forming(share):
    run = rolls(1.0, T_front=share * FORMING / R)
    expected = max(share - 1, 0.0) * FORMING / J
    assert run["body.w"][-1] == pytest.approx(expected, abs=1e-9)


def test_open_rolls_run_freely():
    run = rolls(1.0, w=3.0, F=0.0)
    assert run["body.w"] == pytest.approx(3.0, rel=1e-12)
    assert run["gap.position"][-1] == 2


DH, LENGTH = 0.02, 6.0
ARC = np.sqrt(R * DH)
NO_TENSION = {"T_back": 0.0, "T_front": 0.0}


def test_the_torque_rises_while_the_arc_of_contact_fills_and_falls_while_it_empties():
    gap = StripPass(F=F, a=A, R=R, dh=DH, l=LENGTH, phi_in=2.0, **NO_TENSION)
    at = np.linspace(0.0, 5.0, 1001)
    model = in_a_row(turn=Position(phi=5.0 * lp.time), gap=gap)
    run = lp.simulate(lp.assemble(model), until=5.0, grid=at)
    s = R * (5.0 * at - 2.0)
    share = np.interp(s, [0.0, ARC, LENGTH, LENGTH + ARC], [0.0, 1.0, 1.0, 0.0])
    assert run["gap.tau"] == pytest.approx(FORMING * share, abs=1e-7 * FORMING)


@pytest.mark.parametrize("ratio", [0.1, 0.7, 1.0, 1.6, 2.5])
def test_the_shaft_answers_an_entry_by_the_torque_amplification_factor(ratio):
    """A ramp of the time t_r: ``1 + abs(sin(x)) / x``, ``x = pi t_r / T``.

    The stand turns back instead of the rolls, which vibrate so little that the gap fills evenly.
    """
    c, w = 1e8, 8.0
    T = ARC / (R * w) / ratio
    system = assemble_rows(
        *("wall shaft body gap.flange", "gap.support stand.flange"),
        wall=Fixed(),
        shaft=Spring(c=c),
        body=Inertia(J=c * (T / (2 * np.pi)) ** 2, w=0.0),
        gap=StripPass(F=300.0, a=A, R=R, dh=DH, l=LENGTH, phi_in=0.05, **NO_TENSION),
        stand=Position(phi=-w * lp.time),
    )
    until = (0.05 + ARC / R) / w + 1.2 * T
    start = {"shaft.phi_rel": 0.0}
    run = lp.simulate(system, until=until, rtol=1e-12, atol=1e-16, grid=20000, start=start)
    x = np.pi * ratio
    expected = 1 + abs(np.sin(x)) / x
    received = np.abs(run["shaft.tau"]).max() / (600 * A)
    assert received == pytest.approx(expected, rel=1e-6)


def test_work_of_a_pass_is_that_of_the_force_along_the_strip():
    """Entry and exit together are as long as the strip: ``2 F a l / R``."""
    body = Inertia(J=J, w=60.0)
    gap = StripPass(F=F, a=A, R=R, dh=DH, l=0.5, phi_in=1.0, **NO_TENSION)
    run = lp.simulate(lp.assemble(in_a_row(body=body, gap=gap)), until=1.0, rtol=1e-11)
    lost = J * (60.0**2 - run["body.w"][-1] ** 2) / 2
    assert run["gap.position"][-1] == 2
    assert lost == pytest.approx(FORMING * 0.5 / R, rel=1e-8)


@pytest.mark.parametrize("parameter", ["dh", "F", "l", "phi_in"])
def test_a_pass_has_derivatives_through_its_entry_and_its_exit(parameter):
    """With the work ``2 F a l / R`` and the way, ``w`` after the pass does not know dh."""
    gap = StripPass(F=F, a=A, R=R, dh=DH, l=0.5, phi_in=1.0, **NO_TENSION)
    system = lp.assemble(in_a_row(body=Inertia(J=J, w=60.0), gap=gap))
    w = lp.functionals.final("body.w")
    found = lp.gradient(system, of=[w], by=[f"gap.{parameter}"], until=1.0, rtol=1e-10)
    left = np.sqrt(60.0**2 - 2 * FORMING * 0.5 / R / J)
    slope = -FORMING * 0.5 / R / J / left  # by F and l in proportion
    expected = {"F": slope / F, "l": slope / 0.5}.get(parameter, 0.0)
    assert found.derivatives[0, 0] == pytest.approx(expected, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("given", [{"dh": -0.01}, {"l": 0.0}])
def test_a_strip_of_no_sense_is_refused(given):
    (name,) = given
    values = {"F": F, "a": A, "R": R, "dh": DH, "l": LENGTH} | NO_TENSION | given
    with pytest.raises(ParameterError, match=f"gap.{name} = "):
        lp.assemble(in_a_row(body=Inertia(J=J), gap=StripPass(**values)))
