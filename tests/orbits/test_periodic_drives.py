"""Periodic motion with friction, of machines and of drives that turn, and flywheels."""

import numpy as np
import pytest
from periodic_motions import ROTOR, TURN, Slider, orbit_of, swing_of

import lumped as lp
from lumped.errors import OptionError
from lumped.models.pilger_mill.drive import GEAR, Driven, ElasticallyDriven
from lumped.models.pilger_mill.stand import SPEED

LIGHT = {"J": 0.3, "tau": 3.0}


@pytest.mark.parametrize("u", [0.2, 0.4, 1.0])
def test_a_slider_on_a_belt_sticks_and_slips_for_as_long_as_calculated_by_hand(u):
    c, m, kinetic, static = 9.0, 2.0, 3.0, 5.0
    w, step = np.sqrt(c / m), (static - kinetic) / c
    phi = np.arctan2(step, u / w)
    T = (2 * np.pi - 2 * phi) / w + 2 * step / u
    orbit = lp.periodic(lp.assemble(Slider(u=u)), near=1.1 * T)
    assert orbit.period == pytest.approx(T, rel=1e-9)
    assert orbit.greatest("s").value == pytest.approx(kinetic / c + np.hypot(step, u / w), rel=1e-9)
    # while it sticks only the phase is free
    assert np.abs(orbit.multipliers).max() < 1e-9
    by = orbit.sensitivity(of=["s"], by=["static", "u", "c"])
    slope = -2 / (c * w) * (u / w) / (step**2 + (u / w) ** 2) + 2 / (c * u)
    assert by.period["static"] == pytest.approx(slope, rel=1e-7)
    slope = 2 / w * step / w / (step**2 + (u / w) ** 2) - 2 * step / u**2
    assert by.period["u"] == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("turn", [TURN, {"back": -4 * np.pi}])
def test_a_turning_rotor_finds_its_own_mean_speed(turn):
    exact = orbit_of(**LIGHT)
    orbit = lp.periodic(ROTOR, turn=turn, warm_up=5.0, parameters=LIGHT)
    assert orbit.period == pytest.approx(exact.y[1, -1], rel=1e-10)
    assert orbit.advance["phi"] == pytest.approx(2 * np.pi)
    assert orbit.mean("w") == pytest.approx(2 * np.pi / orbit.period, rel=1e-9)
    fluctuation = swing_of(exact) * orbit.period / (2 * np.pi)
    assert orbit.fluctuation("w") == pytest.approx(fluctuation, rel=1e-7)
    # multipliers: one of a shift in time, the other exp(integral of the trace)
    assert abs(orbit.shift - 1) < 1e-8
    assert orbit.multipliers == pytest.approx([np.exp(-0.5 / 0.3 * orbit.period)], rel=1e-7)
    by = orbit.sensitivity(of=["w"], by=["tau", "J"])
    beside = [
        lp.periodic(ROTOR, turn=turn, warm_up=5.0, parameters=LIGHT | {"tau": tau})
        for tau in (3.001, 2.999)
    ]
    slope = (beside[0].period - beside[1].period) / 0.002
    assert by.period["tau"] == pytest.approx(slope, rel=1e-5)
    assert by.mean[0, 0] == pytest.approx(-2 * np.pi * slope / orbit.period**2, rel=1e-5)
    slope = (beside[0].greatest("w").value - beside[1].greatest("w").value) / 0.002
    assert by.greatest[0, 0] == pytest.approx(slope, rel=1e-5)
    assert "greatest" in repr(by)


@pytest.mark.parametrize("drive", [Driven(), ElasticallyDriven(c=2e6, d=2e3)])
def test_the_pilger_mill_turns_at_the_mean_speed_that_its_controller_integrates(drive):
    w = GEAR * SPEED["P"]
    system = lp.assemble(drive.with_({"wanted": w}), keep=["mill.crank.phi"])
    start = {"motor.w": w}
    if isinstance(drive, ElasticallyDriven):
        start["shaft.w"] = SPEED["P"]
    turn = {"mill.crank.phi": 2 * np.pi}
    orbit = lp.periodic(system, turn=turn, warm_up=5.0, start=start)
    assert orbit.advance == pytest.approx({"motor.phi": 2 * np.pi * GEAR})
    assert orbit.period == pytest.approx(2 * np.pi / SPEED["P"], rel=1e-12)
    assert orbit.mean("motor.w") == pytest.approx(w, rel=1e-10)
    # a run that settled passes the same extremes
    T = orbit.period
    times = np.linspace(59, 60, 4001) * T
    run = lp.simulate(system, until=60 * T, start=start, grid=times, rtol=1e-9)
    assert run["motor.tau"].max() == pytest.approx(orbit.greatest("motor.tau").value, rel=1e-5)
    assert np.ptp(run["motor.w"]) / w == pytest.approx(orbit.fluctuation("motor.w"), rel=1e-5)
    assert orbit.stable
    assert abs(orbit.shift - 1) < 1e-9


@pytest.mark.parametrize("wanted", [0.1, 0.02])
def test_a_flywheel_gives_the_irregularity_asked_for(wanted):
    orbit = lp.periodic(ROTOR, turn=TURN, warm_up=5.0, parameters=LIGHT)
    found = lp.orbits.flywheel(orbit, inertia="J", of="w", irregularity=wanted)
    exact = orbit_of(**LIGHT | {"J": found.after})
    assert swing_of(exact) * exact.y[1, -1] / (2 * np.pi) == pytest.approx(wanted, rel=1e-6)
    assert found.irregularity == pytest.approx(wanted, rel=1e-8)
    # excess work of sin(phi) is 2 G; torques do not depend on the angle alone, so it is no more
    assert found.after == pytest.approx(4 / (wanted * orbit.mean("w") ** 2), rel=0.1)
    assert found.before + found.classical == pytest.approx(found.after, rel=0.15)
    with pytest.raises(OptionError, match="already"):
        lp.orbits.flywheel(orbit, inertia="J", of="w", irregularity=2.0)
    with pytest.raises(OptionError, match="rigidly joined"):
        lp.orbits.flywheel(orbit, inertia="ratio", of="w", irregularity=wanted)


def test_the_classical_flywheel_is_exact_where_torques_depend_on_the_angle_alone():
    """With a weak motor the torque is constant over a turn, and the excess work 2 G."""
    weak = {"d": 1e-3, "tau": 8e-3, "J": 3.0}
    orbit = lp.periodic(ROTOR, turn=TURN, warm_up=5.0, parameters=weak, start={"w": 8.0})
    found = lp.orbits.flywheel(orbit, inertia="J", of="w", irregularity=0.005)
    assert found.classical == pytest.approx(found.added, rel=2e-3)
    # w^2 is a mean plus W / J, the mean speed that of idling
    assert found.after == pytest.approx(4 / (0.005 * 8.0**2), rel=2e-3)
