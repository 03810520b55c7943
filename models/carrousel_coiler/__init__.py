"""Winding drive of a carrousel coiler: published numbers beside computed ones.

The drive and its source are described in `lumped.models.carrousel_coiler.drive`, its sizing in
`sizing` beside it, the elastic strip in `scenes`, the turret in `turret` and `changeover`, gears,
coupling and bearings in `gearing`. Marks: [P] printed, [R] restored by derivation, [I] inferred,
[A] assumed as the source does not give it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, Motor, find_shared, read_about
from lumped.models.carrousel_coiler import drive, scenes, sizing
from lumped.models.carrousel_coiler.parts_rows import list_parts
from lumped.models.carrousel_coiler.turret import half_turn

EXAMPLE_1, EXAMPLE_2, DRAWING = "[P] example 3.1", "[P] example 3.2", "[P] example 3.1, drawing"
RESTORED, INFERRED = "not published, [R]", "not published, [I]"
ASSUMED = "not published, inertias and strip [A]"
RPM = 30 / np.pi
MOTOR = sizing.choose_motor()
LIMITS = sizing.limit_rows(MOTOR)


def rows() -> list[Row]:
    """Published and computed numbers."""
    own = [*_motors(), *_gears(), *_run(), *_deviations(), *_elastic(), *_extremes()]
    return [*own, *list_parts()]


def _motors() -> Iterator[Row]:
    motor, second = MOTOR, sizing.choose_motor(sizing.SPEED_2)
    note = "print cut off, not rounded; (3.4) [R] times 1.25 [I], which is read off this number"
    row = Row("motor power, 20 m/s", "kW", 2347.0, motor.power / 1e3, EXAMPLE_1, note)
    yield row._replace(fitted=True)
    note = "read as 1.25 times tension, 20 m/s and K, without the efficiency [I]; 1.150 times (3.4)"
    row = Row("motor power, drawing", "kW", 2160.0, sizing.drawn_power() / 1e3, DRAWING, note)
    yield row._replace(fitted=True)
    note = "1878.26, without the factor 1.25"
    yield Row("power of (3.4)", "kW", None, sizing.tension_power() / 1e3, RESTORED, note)
    for name, i, printed, slower in (
        ("high gear only", drive.I_HIGH, 10.65, 9.836),
        ("both gears", drive.I_LOW, 7.21, 6.659),
    ):
        found = sizing.speed_range(i)
        note = "print cut off, not rounded; 1300 m/min, not the 20 m/s of example 3.1"
        yield Row(f"range of motor speeds, {name}", "1", printed, found, EXAMPLE_2, note)
        found = sizing.speed_range(i, v_max=20.0)
        note = f"{slower} with the speed of example 3.1"
        yield Row(f"range of motor speeds, {name}, 20 m/s", "1", None, found, RESTORED, note)
    for speed, chosen, base, most in (
        ("20 m/s", motor, "323.24 from a = 1.25; (3.12) would ask for 258.6", "847.85 from (3.13)"),
        ("1300 m/min", second, "350.2, perhaps 350 was meant", "918.5 from (3.13)"),
    ):
        name = f"base speed of the motor, {speed}"
        yield Row(name, "rpm", None, chosen.base * RPM, INFERRED, base)
        name = f"greatest speed of the motor, {speed}"
        yield Row(name, "rpm", None, chosen.speed * RPM, RESTORED, most)
    note = "69.3597, which holds the full coil in high gear"
    yield Row("rated torque, 20 m/s", "kN.m", None, motor.torque / 1e3, INFERRED, note)


def _gears() -> Iterator[Row]:
    motor, drawn = MOTOR, sizing.drawn_motor()
    slow = np.array([5.0])
    for name, found, i, note in (
        ("high gear", motor, drive.I_HIGH, "80 as a = 1.25 says"),
        ("low gear", motor, drive.I_LOW, "118.17 from (3.4) and the envelope"),
        ("2160 kW, high gear", drawn, drive.I_HIGH, "73.6 from (3.4) and the envelope"),
        ("2160 kW, low gear", drawn, drive.I_LOW, "108.71 from (3.4) and the envelope"),
    ):
        held = sizing.greatest_tension(found, slow, i)[0] / 1e3
        yield Row(f"tension at full coil, {name}", "kN", None, held, INFERRED, note)
    reach = float(sizing.torque_at_mandrel(drawn.torque)) / drive.TENSION
    yield Row("radius up to which 2160 kW hold 80 kN", "m", None, reach, INFERRED, "0.92")
    for name, i, value in (("high", drive.I_HIGH, "1200"), ("low", drive.I_LOW, "812.4")):
        fastest = 60 * motor.speed * drive.MANDREL / i
        yield Row(f"fastest line, {name} gear", "m/min", None, fastest, INFERRED, value)


def _run() -> Iterator[Row]:
    run = drive.winding(grid=20_000, rtol=1e-9)
    asked = sizing.demand(run, MOTOR)
    note = "1892.0 closed form, at the end of the acceleration; (3.4) gives 1878.3"
    yield Row("greatest motor power, whole run", "kW", None, asked.peak_power / 1e3, ASSUMED, note)
    note = "61.9386 closed form, at the end of steady winding"
    peak = asked.peak_torque / 1e3
    yield Row("greatest motor torque, whole run", "kN.m", None, peak, ASSUMED, note)
    rms = asked.rms_torque / MOTOR.torque
    yield Row("RMS motor torque over rated torque", "1", None, rms, ASSUMED, "0.648 closed form")
    use = asked.peak.ratio if asked.peak else np.nan
    yield Row("greatest use of the motor's limit", "1", None, use, ASSUMED, "0.893 closed form")
    turns, mass = run["drive.coil.theta"][-1] / (2 * np.pi), run["drive.coil.m"][-1]
    length = run["drive.coil.L"][-1]
    yield Row("length of strip in the full coil", "m", None, length, ASSUMED, "2849.35")
    yield Row("turns of the full coil", "1", None, turns, ASSUMED, "695, (R - r) / h")
    yield Row("mass of the full coil", "t", None, mass / 1e3, ASSUMED, "27.96")
    J = run["drive.coil.J"][[0, -1]] + scenes.J_EMPTY
    yield Row("inertia, full over empty", "1", None, J[1] / J[0], ASSUMED, "10.55")
    twice = drive.strip_momentum(drive.RADIUS)
    note = "3925: w dJ/dt of (3.5) [R] counts the momentum of the strip twice, 4.9 % of T R"
    yield Row("torque that the text adds, full coil", "N.m", None, twice, ASSUMED, note)


def _deviations() -> Iterator[Row]:
    ends = np.array([drive.MANDREL, drive.RADIUS])
    steady = scenes.tension_deviation(ends) / 1e3
    starting = scenes.tension_deviation(np.array([*ends, 0.555]), v=0.0, a=1.0) / 1e3
    text = steady - drive.strip_momentum(1.0) / 1e3
    thin, thick = (scenes.tension_deviation(ends[:1], h=h)[0] / 1e3 for h in (0.3e-3, 5e-3))
    for name, found, note in (
        ("steady, empty", steady[0], "11.771 from A / R^4 + B"),
        ("steady, full", steady[1], "1.0746 from A / R^4 + B"),
        ("steady, empty, as the text", text[0], "7.85 from A / R^4 - 3 B"),
        ("steady, full, as the text", text[1], "-2.85 from A / R^4 - 3 B"),
        ("1 m/s2, empty", starting[0], "-17.200 from -a J / R^2"),
        ("1 m/s2, full", starting[1], "-16.9 from -a J / R^2"),
        ("1 m/s2, least, at 0.555 m", starting[2], "-9.51 from -a J / R^2"),
        ("steady, empty, 0.3 mm", thin, "3.5 from A / R^4 + B"),
        ("steady, empty, 5 mm", thick, "58.9 from A / R^4 + B: needs the controller"),
    ):
        yield Row(f"deviation of tension, {name}", "kN", None, found, ASSUMED, note)


def _elastic() -> Iterator[Row]:
    lossless = {"drive.eta": 1.0, "drive.mu": 0.0}
    at = np.array([0.0, 10.0, 59.9, 150.1])
    run = scenes.elastic_winding(0.0, until=151.0, grid=at, rtol=1e-9, parameters=lossless)
    by_hand = (67_070.5, 81_534.7, 101_181)
    for t, found, value in zip(at[1:], run["strip.T"][1:], by_hand, strict=True):
        name = f"elastic strip at {t:g} s, not compensated"
        yield Row(name, "N", None, found, ASSUMED, f"{value} by DOP853, no loss")
    run = scenes.elastic_winding(1.0, until=160.4, grid=400, rtol=1e-11, parameters=lossless)
    worst = run["strip.T"][np.abs(run["strip.T"] - drive.TENSION).argmax()]
    note = "80000.0 within 8e-5 by DOP853, no loss"
    yield Row("elastic strip, compensated, farthest off", "N", None, worst, ASSUMED, note)


def _extremes() -> Iterator[Row]:
    for name, radius, percent in (("empty", drive.MANDREL, "0.59"), ("full", drive.RADIUS, "0.35")):
        part = 100 * sizing.share_of_losses(radius)
        note = f"{percent} from sigma_s b h^2 / 4 and mu Q d / 2, 1 mm [A]; it fits thicker strip"
        label = f"bending and friction in the total power, {name} coil"
        yield Row(label, "%", None, part, "[P] text to (3.3)", note, bounds=(5.0, 10.0))
    for h, value in ((drive.THICKNESS, 93.75), (5e-3, 2344)):
        model = drive.UnderTension().with_({"drive.h": h, "drive.motor.phi": lp.time})
        found = lp.start_point(lp.assemble(model))["drive.coil.M_b"]
        name = f"torque that bends the strip, {1e3 * h:g} mm"
        yield Row(name, "N.m", None, found, ASSUMED, f"{value} from sigma_s b h^2 / 4")
    lost = sum(event.loss for event in scenes.gear_change().events) / 1e3
    note = "15.649 from momentum"
    yield Row("energy lost by a gear change at 20 rad/s", "kJ", None, lost, ASSUMED, note)
    turret = -half_turn(grid=600)["turn.flange.tau"] / 1e3
    for name, found, value in (("least", turret.min(), 29), ("greatest", turret.max(), 174)):
        note = f"{value} from plane geometry"
        yield Row(f"turret drive, {name} torque of half a turn", "kN.m", None, found, ASSUMED, note)


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Demand of a coil that the line winds, with changed parameters."""
    system = lp.assemble(drive.UnderTension())
    wound = drive.winding(grid=4000, rtol=1e-9, parameters=find_shared(system, parameters))
    asked = sizing.demand(wound, MOTOR)
    return [
        Measure("prescribed motion, greatest motor power", "W", asked.peak_power),
        Measure("prescribed motion, greatest motor torque", "N.m", asked.peak_torque),
        Measure("prescribed motion, RMS motor torque", "N.m", asked.rms_torque),
        Measure("strip in the coil", "m", float(wound["drive.coil.L"][-1])),
        Measure("mass of the coil", "kg", float(wound["drive.coil.m"][-1])),
    ]


ABOUT = read_about(
    "carrousel_coiler",
    until=np.inf,
    watched={
        "tension of the strip": "strip.T",
        "motor torque": "drive.motor.tau",
        "speed of the motor": "drive.rotor.w",
        "radius of the coil": "drive.coil.R",
    },
    motors=(Motor("motor of 2348 kW", "drive.motor.tau", "drive.rotor.w", MOTOR.torque, LIMITS),),
)
MACHINE = Machine(
    *("carrousel_coiler", ABOUT, rows, drive.UnderTension, scenes.elastic_winding, effects),
    short=30.0,
)
