"""Cold pilger mill LG90: published numbers of its balancing beside computed ones.

The drive and its source are described in `lumped.models.pilger_mill.stand`, its balance in
`lumped.models.pilger_mill.balance`, its motor in `lumped.models.pilger_mill.drive`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, Motor, find_shared, read_about
from lumped.models.pilger_mill import drive, stand
from lumped.models.pilger_mill.balance import Balance, balance
from lumped.models.pilger_mill.design import find_weighted_optimum
from lumped.models.pilger_mill.torque import rod_motion, split_torque
from lumped.models.sources import Given

TABLE = "table 2 [P]"
FORCE = {
    "before": Given(491228.9, "N", "P", "greatest force on the foundation before, F1"),
    "after": Given(320910.4, "N", "P", "greatest force on the foundation after, F1"),
}
FLUCTUATION = {
    "before": Given(84439.48, "N.m", "P", "fluctuation of the motor torque before, F2"),
    "after": Given(84516.00, "N.m", "P", "fluctuation of the motor torque after, F2"),
}
POWER = {
    "before": Given(510.0, "kW", "P", "motor power before, N"),
    "after": Given(501.0, "kW", "P", "motor power after, N"),
}
FITTED = "set fitted to it [I]"
SLOW = "set P [I] has a plausible speed; this force needs 127.2 1/min or more"
UNFIT = "set fitted to it [I]; no set explains the printed drop of 9 kW"
SMALL = "table 2 has 76.52, a difference of 0.1 % between two torques"
PLAIN = {
    "P": "set fitted to it [I]; at the crank's shaft",
    "F": "set fitted to it [I]; at the motor's shaft, as the text has it",
}
DIFFERENCE = "table 2, after less before [P]"
FLAT = "set fitted to it [I], which leaves the optimum of a flat function loose: {best:.1f} {unit}"
RESTORED = "not published [R]"
CHOSEN = "not published, set [I]"
NECKS = "not published, rolling force and neck [A]"
MOTOR = "not published, motor and gear [A]"
TWO_CYCLES = 1.8771169117  # s
FINE = 14400  # points of a revolution
VECTORS = {name: np.array(list(design.values())) for name, design in stand.DESIGNS.items()}


def rows() -> list[Row]:
    """Published and computed numbers of both sets of parameters."""
    reach = stand.ROD + stand.RADIUS * np.array([1, -1])
    far, near = 1e3 * np.sqrt(reach**2 - stand.OFFSET**2)
    dead, inward = np.degrees(np.arcsin(stand.OFFSET / reach)), "crank angle of the stroke inward"
    outward = 180 - dead[1] + dead[0]
    found = [
        Row("stroke of the stand", "mm", None, far - near, RESTORED, "1183.644 from R, L and e"),
        Row(inward, "deg", None, outward, RESTORED, "178.7365 likewise"),
    ]
    for name in ("F", "P"):
        found += _compare(name)
    found += [row._replace(quantity=f"set P, {row.quantity}") for row in _turn()]
    run = drive.running(until=TWO_CYCLES, grid=4000, rtol=1e-9)
    torque = run["motor.tau"]
    phi = run["mill.crank.phi"][-1] / (2 * np.pi)
    for label, unit, value, reference in (
        ("turns in 1.8771169117 s", "1", phi, "2 by DOP853"),
        ("motor speed then", "rad/s", run["motor.w"][-1], "104.28781 by DOP853"),
        ("motor torque then", "N.m", torque[-1], "2574.758 by DOP853"),
        ("motor torque, greatest", "N.m", torque.max(), "4776.7 by DOP853"),
        ("motor torque, least", "N.m", torque.min(), "-830.6 by DOP853"),
    ):
        found.append(Row(f"set P, {label}", unit, None, value, MOTOR, reference))
    return found


def powers(of: Balance, design: str, w: float) -> dict[str, float]:
    """Power at the crank over a revolution by three readings, W."""
    power = w * (np.array([1.0, *stand.DESIGNS[design].values()]) @ of.torque)
    return {
        "peak": float(power.max()),
        "rms": float(np.sqrt(np.mean(power**2))),
        "mean": float(power.mean()),
    }


def _compare(name: str) -> Iterator[Row]:
    """Table 2 and the optimum with the parameters of a set and the source's torque."""
    for row in (*_table(name), *_optimum(name)):
        yield row._replace(quantity=f"set {name}, {row.quantity}")


def _table(name: str) -> Iterator[Row]:
    """Force, torque and power of both designs, to which the set is fitted but for set P's force."""
    paper, ratio = balance(name, points=FINE), stand.RATIO[name]
    force = {design: float(paper.forces(u).max()) for design, u in VECTORS.items()}
    torque = {design: paper.fluctuation(u) / ratio for design, u in VECTORS.items()}
    power = {design: powers(paper, design, stand.SPEED[name]) for design in VECTORS}
    plain = PLAIN[name]
    remark, chosen = (SLOW, "peak") if name == "P" else (FITTED, "mean")
    for design, found in force.items():
        row = Row(f"foundation force {design}", "N", FORCE[design], found, TABLE, remark)
        yield row._replace(fitted=name == "F")
    less = 100 * (1 - force["after"] / force["before"])
    row = Row("reduction of the foundation force", "%", 34.67, less, "section 3.2 [P]", FITTED)
    yield row._replace(fitted=True)
    for design, found in torque.items():
        row = Row(f"torque fluctuation {design}", "N.m", FLUCTUATION[design], found, TABLE, plain)
        yield row._replace(fitted=True)
    change = torque["after"] - torque["before"]
    yield Row("change of the torque fluctuation", "N.m", None, change, CHOSEN, SMALL)
    for design, readings in power.items():
        found, remark = readings[chosen] / 1e3, f"{chosen} power; {UNFIT}"
        row = Row(f"motor power {design}", "kW", POWER[design], found, TABLE, remark)
        yield row._replace(fitted=True)
    for reading, found in power["after"].items():
        if reading != chosen:
            remark = "another reading of the motor power"
            yield Row(f"{reading} power after", "kW", None, found / 1e3, CHOSEN, remark)


def _optimum(name: str) -> Iterator[Row]:
    """What the optimum adds, the objective, and what the source leaves out."""
    paper, ratio = balance(name), stand.RATIO[name]
    exact = balance(name, kind=stand.Mill, g=9.80665, points=FINE)
    before, published = VECTORS.values()
    best, added = paper.optimum(), published - before
    sectors = float(paper.best_sectors(published[0]))
    for label, unit, i, value in (
        ("counterweight added by the optimum", "kg", 0, best[0]),
        ("sector moment added by the optimum", "kg.m", 1, best[1]),
        ("sector moment added, best for 7228 kg", "kg.m", 1, sectors),
    ):
        more, remark = round(float(added[i]), 2), FLAT.format(best=value, unit=unit)
        row = Row(label, unit, more, float(value - before[i]), DIFFERENCE, remark)
        yield row._replace(fitted=True)
    (force, torque), (light, even) = paper.goals(), (design[0] for design in paper.single)
    least, bound, crest = torque / ratio, "2 is the bound", "crest to trough"
    for label, unit, value, remark in (
        ("objective, published design", "1", paper.objective(published), bound),
        ("objective, best design", "1", paper.objective(best), bound),
        ("least foundation force of all designs", "N", force, f"at m2 = {light:.1f} kg"),
        ("least torque fluctuation of all designs", "N.m", least, f"at m2 = {even:.1f} kg"),
        *_by_ipopt(name),
        ("inertia torque as printed", "kN.m", _swing(name, stand.AsPrinted), crest),
        ("inertia torque, exact", "kN.m", _swing(name, stand.Mill), crest),
    ):
        yield Row(label, unit, None, value, CHOSEN, remark)
    for design, u in VECTORS.items():
        label, value = f"torque fluctuation {design}, exact and with gravity", exact.fluctuation(u)
        yield Row(label, "N.m", None, value / ratio, CHOSEN, "the source leaves gravity out")


def _by_ipopt(name: str) -> Iterator[tuple[str, str, float, str]]:
    """The optimum by another method than that of `Balance`."""
    best, method = find_weighted_optimum(name), "F1/F10 + F2/F20 by IPOPT, not linear programmes"
    yield "counterweight of the optimum, nonlinear programme", "kg", best.parameters["m2"], method
    yield "sector moment of the optimum, likewise", "kg.m", best.parameters["U"], method


def _turn() -> Iterator[Row]:
    """Rods by (9) to (12) and parts of the torque by (29) and (30) over a turn of set P."""
    w = stand.SPEED["P"]
    system = stand.turn_mill(stand.mill("P", kind=stand.AsPrinted), w * lp.time)
    run = stand.revolution(system, w, np.arange(0.0, 360.25, 0.5))
    rods, parts = rod_motion(run), split_torque(run, w)
    for key, label, degrees, reference in (
        ("wL", "speed of the stand's rods at 0 deg (9)", 0, "0.93296 from R, L and e"),
        ("wL1", "speed of the counterweight's rods at 90 deg (10)", 90, "-1.16268, R w / L1"),
        ("xiL", "acceleration of the stand's rods at 90 deg (11)", 90, "-6.38348 likewise"),
        ("xiL1", "acceleration of the counterweight's rods at 0 deg (12)", 0, "-7.91016 likewise"),
    ):
        unit, value = "rad/s2" if key.startswith("xi") else "rad/s", rods[key][2 * degrees]
        yield Row(label, unit, None, float(value), CHOSEN, reference)
    rolls, necks, idle = (parts[key] / 1e3 for key in ("rolling", "necks", "idle"))
    wrong, drives = "(29) has P f d, twice as much", "(30) takes mu M, which drives where M < 0"
    for label, value, place, remark in (
        ("rolling torque at the crank, greatest", rolls.max(), NECKS, "2 (wG / w) MZ"),
        ("friction of the necks at the crank, greatest", necks.max(), NECKS, "from P f d / 2"),
        ("friction of the necks as printed, greatest", 2 * necks.max(), NECKS, wrong),
        ("idle friction at the crank, greatest", idle.max(), CHOSEN, "mu M"),
        ("idle friction at the crank, least", idle.min(), CHOSEN, drives),
    ):
        yield Row(label, "kN.m", None, float(value), place, remark)


def _swing(name: str, kind: type[stand.Mill]) -> float:
    """Inertia torque of the published design from crest to trough, kN.m."""
    w = stand.SPEED[name]
    system = stand.turn_mill(stand.mill(name, kind=kind, T_f=0.0, M0=0.0), w * lp.time)
    torque = stand.crank_torque(stand.revolution(system, w, np.arange(0.0, 360.05, 0.1)))
    return float(np.ptp(torque)) / 1e3


def build_drawn() -> drive.Driven:
    """The machine with a wanted speed."""
    return drive.Driven(wanted=drive.Driven.gear.ratio * drive.Driven.w)


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Force and torque of a turn at constant speed with changed parameters."""
    w = stand.SPEED["P"]
    system = stand.turn_mill(stand.mill("P"), w * lp.time)
    degrees, shared = np.arange(0.0, 360.05, 0.25), find_shared(system, parameters)
    turn = stand.revolution(system, w, degrees, shared)
    force = np.hypot(*stand.shaking_force(turn).T).max()
    swing = np.ptp(stand.crank_torque(turn, stand.IDLE))
    return [
        Measure("greatest force on the foundation", "N", float(force)),
        Measure("fluctuation of the crank torque", "N.m", float(swing)),
    ]


ABOUT = read_about(
    "pilger_mill",
    until=9.0,
    watched={
        "motor torque": "motor.tau",
        "speed of the crank": "shaft.w",
        "speed of the motor": "motor.w",
        "position of the stand": "mill.stand.s",
    },
    motors=(Motor("motor", "motor.tau", "motor.w", maximum=drive.BREAKDOWN),),
)
MACHINE = Machine("pilger_mill", ABOUT, rows, build_drawn, drive.start_up, effects, short=3.0)
