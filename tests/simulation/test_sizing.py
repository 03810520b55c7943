"""Sizing of a motor against closed forms."""

import re

import numpy as np
import pytest
from checks import refused
from rows import in_a_row

import lumped as lp
from lumped import profiles
from lumped.components import Damper, Fixed, Inertia, Torque, translation
from lumped.errors import OptionError, UnitError
from lumped.ops import cos, sin

J, PEAK, T_UP, T_CRUISE, T_REST = 0.4, 20.0, 0.25, 0.5, 0.6


@pytest.fixture
def cycle():
    """An inertia that speeds up, turns steadily, brakes and rests."""
    rig = in_a_row(motor=Torque(tau=0.0), load=Inertia(J=J))
    a = PEAK / T_UP
    move = profiles.trapezoidal(PEAK * (T_UP + T_CRUISE), PEAK, a)
    whole = 2 * T_UP + T_CRUISE + T_REST
    return lp.inverse(
        lp.assemble(rig),
        motion={"load.phi": profiles.path(move)},
        drive="motor.tau",
        until=whole,
        grid=47,
    )


def size(cycle, **limits):
    return lp.simulation.sizing(cycle, **{"of": ("motor.tau", "load.w"), **limits})


def test_a_trapezoidal_cycle_has_the_figures_of_the_catalogues(cycle):
    tau, whole = J * PEAK / T_UP, 2 * T_UP + T_CRUISE + T_REST
    found = size(cycle)
    expected = {
        "peak_torque": tau,
        "peak_speed": PEAK,
        "rms_torque": tau * np.sqrt(2 * T_UP / whole),
        "mean_speed": PEAK * (T_UP + T_CRUISE) / whole,
        "peak_power": tau * PEAK,
        "peak_regeneration": tau * PEAK,
    }
    for name, value in expected.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12), name
    assert found.mean_power == pytest.approx(0.0, abs=1e-12 * tau * PEAK)
    assert found.thermal is None
    assert found.fits


def test_the_thermal_equivalent_is_compared_with_the_rated_torque_at_its_speed(cycle):
    whole = 2 * T_UP + T_CRUISE + T_REST
    rms = J * PEAK / T_UP * np.sqrt(2 * T_UP / whole)
    mean = PEAK * (T_UP + T_CRUISE) / whole
    rows = [(0.0, 30.0), (40.0, 10.0)]
    found = size(cycle, rated=rows)
    assert found.thermal.limit == pytest.approx(30 - mean / 2, rel=1e-12)
    assert found.thermal.ratio == pytest.approx(rms / (30 - mean / 2), rel=1e-12)
    assert found.fits
    found = size(cycle, rated=0.99 * rms)
    assert found.thermal.ratio == pytest.approx(1 / 0.99, rel=1e-12)
    assert not found.fits


def test_the_worst_point_is_where_the_envelope_falls_below_the_torque(cycle):
    tau = J * PEAK / T_UP
    rows = [(10.0, 40.0), (20.0, 30.0), (25.0, 0.0)]
    found = size(cycle, maximum=rows)
    # the torque is constant up to full speed, so the end of speeding up is the worst
    assert (found.peak.speed, found.peak.limit) == pytest.approx((PEAK, 30.0), rel=1e-12)
    assert found.peak.ratio == pytest.approx(tau / 30.0, rel=1e-12)
    assert not found.fits
    slow = size(cycle, maximum=[(0, 50.0), (19.0, 50.0)])
    assert slow.peak.ratio == np.inf
    wide = size(cycle, maximum=50.0)
    assert wide.peak.ratio == pytest.approx(tau / 50.0, rel=1e-12)
    assert wide.fits


def test_the_report_prints_its_figures(cycle):
    text = repr(size(cycle, rated=40.0, maximum=64.0))
    rows = [re.split(r"\s{2,}", line) for line in text.splitlines()[2:]]
    received = {name: float(value) for name, value, _ in rows}
    assert received["peak torque"] == J * PEAK / T_UP
    assert received["load of maximum torque"] == 100 * J * PEAK / T_UP / 64.0


def test_a_force_is_sized_over_a_speed_through_zero():
    rig = in_a_row(motor=translation.Force(f=0.0), slide=translation.Mass(m=3.0))
    motion = {"slide.v": 1.0 - 2 * lp.time}
    run = lp.inverse(lp.assemble(rig), motion=motion, drive="motor.f", until=2.0, grid=7)
    found = lp.simulation.sizing(run, of=("motor.f", "slide.v"))
    # v falls from 1 to -3 m/s: areas of two triangles
    assert found.mean_speed == pytest.approx((0.5 * 1 * 0.5 + 0.5 * 3 * 1.5) / 2, rel=1e-12)
    assert found.rms_torque == pytest.approx(6.0, rel=1e-12)
    # the kinetic energy grows by 3/2 (9 - 1) J in 2 s
    assert found.mean_power == pytest.approx(6.0, rel=1e-12)
    assert (found.peak_power, found.peak_regeneration) == pytest.approx((18.0, 6.0), rel=1e-12)


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({"of": ("load.w", "load.w")}, "of = (load.w, load.w), in rad/s and rad/s"),
        ({"rated": [(0.0, -1.0)]}, "no torque may be negative"),
        ({"maximum": [(3.0, 1.0), (2.0, 1.0)]}, "speeds must increase"),
        ({"maximum": [1.0, 2.0]}, "rows of 2 numbers"),
    ],
)
def test_what_cannot_be_sized_is_named(cycle, options, part):
    refused(OptionError, lambda: size(cycle, **options), part)
    refused(UnitError, lambda: size(cycle, rated="3 N.m.s"), "rated = '3 N.m.s'", "kind N.m")


@pytest.mark.parametrize("grid", [1, 7, None])
def test_output_times_change_nothing_of_a_run_that_was_simulated(grid):
    # torque 6 sin(5 t) on 2 kg.m2 from -0.6 rad/s, two periods: w = -0.6 cos(5 t)
    model = in_a_row(motor=Torque(tau=6.0 * sin(5.0 * lp.time)), body=Inertia(J=2.0, w=-0.6))
    run = lp.simulate(lp.assemble(model), until=4 * np.pi / 5, grid=grid, rtol=1e-9)
    found = lp.simulation.sizing(run, of=("body.flange_a.tau", "body.w"), maximum=3.0)
    received = (found.peak_torque, found.rms_torque, found.peak_speed, found.mean_speed)
    assert received == pytest.approx((6.0, 6 / np.sqrt(2), 0.6, 1.2 / np.pi), rel=1e-7)
    assert (found.peak_power, found.peak_regeneration) == pytest.approx((1.8, 1.8), rel=1e-7)
    assert found.peak.ratio == pytest.approx(2.0, rel=1e-7)


@pytest.mark.parametrize("grid", [1, 7])
def test_a_limit_over_the_speed_is_compared_between_output_times(grid):
    # 6 |sin| over 8 - 6 |cos| is greatest where |cos| = 3/4
    model = in_a_row(motor=Torque(tau=6.0 * sin(5.0 * lp.time)), body=Inertia(J=2.0, w=-0.6))
    run = lp.simulate(lp.assemble(model), until=4 * np.pi / 5, grid=grid, rtol=1e-9)
    limits = ((0.0, 8.0), (0.6 * (1 + 1e-9), 2.0)), ((0.0, 8.0), (0.5, 3.0))
    found = [
        lp.simulation.sizing(run, of=("body.flange_a.tau", "body.w"), maximum=limit).peak.ratio
        for limit in limits
    ]
    assert found == pytest.approx([6 / np.sqrt(28), np.inf], rel=1e-6)


@pytest.mark.parametrize("begun", ["point", "start point", "periodic"])
def test_a_run_from_a_point_is_sized_by_its_kinks_too(begun):
    # w = -0.6 cos(5 t) with a damper of 2 N.m.s: torque 6 sin(5 t) - 1.2 cos(5 t)
    tau = 6.0 * sin(5.0 * lp.time) - 1.2 * cos(5.0 * lp.time)
    parts = {"body": Inertia(J=2.0, w=-0.6), "loss": Damper(d=2.0), "wall": Fixed()}
    system = lp.assemble(in_a_row(motor=Torque(tau=tau), **parts))
    period, rtol = 2 * np.pi / 5, 1e-9
    if begun == "periodic":
        run = lp.periodic(system, period=period, start={"body.w": -0.6}, rtol=rtol).run
    else:
        first = lp.simulate(system, until=1.0, rtol=rtol)
        point = first.point(1.0) if begun == "point" else lp.start_point(system)
        run = lp.simulate(system, until=point.time + period, start=point, rtol=rtol)
    limits = {"rated": "0.006 kN.m", "maximum": [("0 rpm", "8 N.m"), (0.7, 1.0)]}
    found = lp.simulation.sizing(run, of=("motor.tau", "body.w"), **limits)
    rms = np.hypot(6.0, 1.2) / np.sqrt(2)
    received = (found.rms_torque, found.mean_speed, found.thermal.ratio)
    assert received == pytest.approx((rms, 1.2 / np.pi, rms / 6), rel=1e-6)
    swing = np.hypot(1.8, 0.36)
    received = found.peak_power, found.peak_regeneration, found.mean_power
    assert received == pytest.approx((swing + 0.36, swing - 0.36, 0.36), rel=1e-6)
    angle = np.linspace(0, 2 * np.pi, 1_000_001)
    share = np.abs(6 * np.sin(angle) - 1.2 * np.cos(angle)) / (8 - 6 * np.abs(np.cos(angle)))
    assert found.peak.ratio == pytest.approx(share.max(), rel=1e-6)
