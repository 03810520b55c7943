"""Numbers of coupling, gears, bearings, turret and mandrel, (3.14) to (3.54) of the source."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lumped.life import mean_speed
from lumped.models import Row, list_rows
from lumped.models.carrousel_coiler import drive, expansion, gearing, sizing
from lumped.models.carrousel_coiler.changeover import changeover, plan

ASSUMED = "not published, loads and sizes [A]"


def list_parts() -> list[Row]:
    """Rows of the parts."""
    return [*_rules(), *_teeth(), *_strength(), *_turret(), *_mandrel()]


def _rules() -> Iterator[Row]:
    run = gearing.coil_run()
    power = sizing.demand(run, sizing.choose_motor()).peak_power / sizing.tension_power()
    note = "1.0073: 1892.0 over 1878.3 kW; 1 m/s2 [A] and no jump of the tension"
    row = Row("dynamic factor of the motor power", "1", None, power, "[P] section 3.1.1", note)
    yield row._replace(bounds=(float(sizing.DYNAMIC[0]), float(sizing.DYNAMIC[1])))
    power, speed = run["drive.rotor.flange_a.tau"] * run["drive.rotor.w"], run["drive.coil.w"]
    last = int(power.argmax())
    tension, bending = run["drive.coil.T"] * run["drive.coil.R"], run["drive.coil.M_b"]
    static = (tension + bending + np.abs(run["drive.bearing.tau"])) * speed / drive.ETA
    found = power[last] / static[last]
    note = "1.083: K = 1.08 of (3.4) is too large for strip of 1 mm"
    yield Row("greatest motor power over that of (3.3) there", "1", None, found, ASSUMED, note)
    found = sizing.speed_range()
    note = "10.6557: above 10 it asks for two gears, chosen for a strip at standstill"
    row = Row("range of mandrel speeds", "1", None, found, "[P] section 3.1.4", note)
    yield row._replace(bounds=(float(sizing.TWO_GEARS), None))
    found = sizing.torque_check(sizing.choose_motor())
    note = "1.08, which is K; the formula of this check is restored"
    name = "rated torque over that of the full coil"
    yield Row(name, "1", None, found, "[P] section 3.1.4", note, bounds=(1.0, None))


def _teeth() -> Iterator[Row]:
    place = "[P] section 3.1.6"
    for gear, ratio in (("high", drive.I_HIGH), ("low", drive.I_LOW)):
        pair = gearing.stage(gear)
        name = f"ratio of whole teeth over that of the {gear} gear, difference"
        note = f"{pair.teeth[1]}/{pair.teeth[0]} teeth without a common factor"
        error = 100 * float(gearing.RATIO_ERROR)
        found = 100 * (pair.ratio / ratio - 1)
        yield Row(name, "%", None, found, place, note, bounds=(-error, error))
    found = gearing.equal_seat_teeth()
    note = "39.9 for R + r between the mandrels: equal wheels of module 16 need more teeth"
    bounds = float(gearing.SEAT_TEETH[0]), float(gearing.SEAT_TEETH[1])
    name = "teeth of equal wheels in the gear seat, at least"
    yield Row(name, "1", None, found, place, note, bounds=bounds)
    seat, stage = gearing.seat_pair(), gearing.stage("high")
    notes = {
        "ratio of the reducer, high gear": "1.354 as the seat is 1 : 1, (3.17) to (3.20)",
        "helix angle of the reducer": "11.675 from (3.31), (3.32)",
        "helix angle of the gear seat": "13.394 from (3.32)",
        "transverse contact ratio, high gear": "1.6377 from (3.37)",
        "overlap ratio, high gear": "1.3813 from (3.38)",
    }
    computed = (
        gearing.split_ratio(drive.I_HIGH).reducer,
        np.degrees(stage.helix),
        np.degrees(seat.helix),
        stage.contact_ratio,
        stage.overlap_ratio,
    )
    for row, unit in zip(
        list_rows("1", ASSUMED, notes, computed), ("1", "deg", "deg", "1", "1"), strict=True
    ):
        yield row._replace(unit=unit)


def _strength() -> Iterator[Row]:
    run = gearing.coil_run()
    loads, rated = gearing.loads(run), gearing.rate_stage(run)
    for name, note in (("peak", "end of steady winding"), ("equivalent", "(3.45)")):
        label = f"torque into the gears, {name}"
        yield Row(label, "kN.m", None, loads[name] / 1e3, ASSUMED, note)
    speed = run.value(mean_speed(gearing.LOAD[1])) * 30 / np.pi
    yield Row("mean speed of the motor", "rpm", None, speed, ASSUMED, "(3.46)")
    least = 1e3 * gearing.module_of_root(loads["peak"])
    note = "16 is printed; of table 3-4 it is the next of the first series"
    yield Row("least module by the root, (3.25)", "mm", None, least, ASSUMED, note)
    for part, least in zip(("contact", "root"), gearing.SAFETIES, strict=True):
        found = getattr(rated["peak"], part)
        note = f"{getattr(rated['equivalent'], part):.2f} under the equivalent torque; strength [A]"
        name = f"{part} safety of the high gear under the peak torque"
        yield Row(name, "1", None, found, "[P] table 3-1", note, bounds=(float(least), None))
    hours = run.value(gearing.bearing_hours())
    note = "(3.45) to (3.53), 90 per cent; tables 3-5 and 3-6 give f_t = 1 and f_p = 1.5"
    yield Row("life of the worse pinion bearing", "h", None, hours, ASSUMED, note)
    chosen = gearing.coupling()
    note = "104.04: 1.5 times the rated torque, (3.14)"
    yield Row("torque of the coupling", "kN.m", None, chosen.needed / 1e3, ASSUMED, note)
    note = "the least that carries it, K_n = 1 as its chart is in a handbook, (3.15), (3.16)"
    name = "nominal torque of the coupling"
    yield Row(name, "kN.m", None, chosen.permitted / 1e3, ASSUMED, note)


def _turret() -> Iterator[Row]:
    stages, _ = plan()
    run = changeover(grid=np.linspace(stages.turns, stages.turned, 601), rtol=1e-9)
    torque = -run["turn.flange.tau"][(run.t > stages.turns) & (run.t < stages.turned)] / 1e3
    for name, found in (("least", torque.min()), ("greatest", torque.max())):
        label = f"turret drive with its mass, {name} torque of half a turn"
        note = "by plane geometry with weight and inertia"
        yield Row(label, "kN.m", None, found, ASSUMED, note)


def _mandrel() -> Iterator[Row]:
    force = expansion.segment_force()
    for name, found, note in (
        ("expands", expansion.pull(force), "127.3 against one wrap at 80 kN"),
        ("holds", expansion.hold(force), "33.9; below it the segments slide back"),
    ):
        label = f"pull of the cylinder that {name} the mandrel"
        yield Row(label, "kN", None, found / 1e3, ASSUMED, note)
