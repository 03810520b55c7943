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
from lumped.models.about import Measure, shared
from lumped.models.pilger_mill.about import ABOUT
from lumped.models.pilger_mill.balance import (
    Balance,
    balance,
)
from lumped.models.pilger_mill.drive import (
    Driven,
    running,
    start_up,
)
from lumped.models.pilger_mill.stand import (
    DESIGNS,
    IDLE,
    OFFSET,
    RADIUS,
    RATIO,
    ROD,
    SPEED,
    AsPrinted,
    Mill,
    crank_torque,
    mill,
    revolution,
    shaking_force,
    turned,
)
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
ADDED = {"m2": "counterweight added by the optimum", "U": "sector moment added by the optimum"}
DIFFERENCE = "table 2, after less before [P]"
FLAT = "set fitted to it [I], which leaves the optimum of a flat function loose: {best:.1f} {unit}"
RESTORED = "not published [R]"
CHOSEN = "not published, set [I]"
MOTOR = "not published, motor and gear [A]"
TWO_CYCLES = 1.8771169117  # s
FINE = 14400  # points of a revolution


def rows() -> list[Row]:
    """Published and computed numbers of both sets of parameters."""
    stroke = np.sqrt((ROD + RADIUS) ** 2 - OFFSET**2) - np.sqrt((ROD - RADIUS) ** 2 - OFFSET**2)
    dead = np.degrees(np.arcsin([OFFSET / (ROD + RADIUS), OFFSET / (ROD - RADIUS)]))
    outward = 180 - dead[1] + dead[0]
    found = [
        Row("stroke of the stand", "mm", None, 1e3 * stroke, RESTORED, "1183.644 from R, L and e"),
        Row(
            "crank angle of the stroke inward", "deg", None, outward, RESTORED, "178.7365 likewise"
        ),
    ]
    for name in ("F", "P"):
        found += _compared(name)
    run = running(until=TWO_CYCLES, grid=4000, rtol=1e-9)
    torque = run["motor.tau"]
    phi = float(run["mill.crank.phi"][-1] / (2 * np.pi))
    for label, unit, value, reference in (
        ("turns in 1.8771169117 s", "1", phi, "2 by DOP853"),
        ("motor speed then", "rad/s", run["motor.w"][-1], "104.28781 by DOP853"),
        ("motor torque then", "N.m", torque[-1], "2574.758 by DOP853"),
        ("motor torque, greatest", "N.m", torque.max(), "4776.7 by DOP853"),
        ("motor torque, least", "N.m", torque.min(), "-830.6 by DOP853"),
    ):
        found.append(Row(f"set P, {label}", unit, None, float(value), MOTOR, reference))
    return found


def powers(of: Balance, design: str, w: float) -> dict[str, float]:
    """Power at the crank over a revolution by three readings, W."""
    power = w * (np.array([1.0, *DESIGNS[design].values()]) @ of.torque)
    return {
        "peak": float(power.max()),
        "rms": float(np.sqrt(np.mean(power**2))),
        "mean": float(power.mean()),
    }


def _compared(name: str) -> Iterator[Row]:
    """Table 2 and the optimum with the parameters of a set and the source's torque."""
    head, w = f"set {name}, ", SPEED[name]
    paper, exact = balance(name, points=FINE), balance(name, kind=Mill, g=9.80665, points=FINE)
    force, torque, power, heavy = {}, {}, {}, {}
    for design, values in DESIGNS.items():
        u = np.array(list(values.values()))
        force[design] = float(paper.forces(u).max())
        torque[design] = paper.fluctuation(u) / RATIO[name]
        power[design] = powers(paper, design, w)
        heavy[design] = exact.fluctuation(u) / RATIO[name]
    for design in DESIGNS:
        remark = FITTED if name == "F" else SLOW
        row = Row(
            f"{head}foundation force {design}", "N", FORCE[design], force[design], TABLE, remark
        )
        yield row._replace(fitted=name == "F")
    less = 100 * (1 - force["after"] / force["before"])
    yield Row(
        f"{head}reduction of the foundation force", "%", 34.67, less, TABLE, FITTED, fitted=True
    )
    for design in DESIGNS:
        row = Row(
            f"{head}torque fluctuation {design}",
            "N.m",
            FLUCTUATION[design],
            torque[design],
            TABLE,
            PLAIN[name],
        )
        yield row._replace(fitted=True)
    change = torque["after"] - torque["before"]
    yield Row(f"{head}change of the torque fluctuation", "N.m", None, change, CHOSEN, SMALL)
    chosen = "mean" if name == "F" else "peak"
    for design in DESIGNS:
        label, reading = f"{head}motor power {design}", f"{chosen} power; {UNFIT}"
        row = Row(label, "kW", POWER[design], power[design][chosen] / 1e3, TABLE, reading)
        yield row._replace(fitted=True)
    for reading, value in power["after"].items():
        if reading != chosen:
            label, remark = f"{head}{reading} power after", "another reading of the motor power"
            yield Row(label, "kW", None, value / 1e3, CHOSEN, remark)
    paper = balance(name)
    best, published = paper.optimum(), np.array(list(DESIGNS["after"].values()))
    before = np.array(list(DESIGNS["before"].values()))
    for i, (key, unit) in enumerate((("m2", "kg"), ("U", "kg.m"))):
        label, more = head + ADDED[key], float(published[i] - before[i])
        remark = FLAT.format(best=best[i], unit=unit)
        row = Row(label, unit, round(more, 2), float(best[i] - before[i]), DIFFERENCE, remark)
        yield row._replace(fitted=True)
    sectors = float(paper.best_sectors(published[0]))
    remark = FLAT.format(best=sectors, unit="kg.m")
    more = round(float(published[1] - before[1]), 2)
    row = Row(
        f"{head}sector moment added, best for 7228 kg",
        "kg.m",
        more,
        sectors - before[1],
        DIFFERENCE,
        remark,
    )
    yield row._replace(fitted=True)
    goals, bound = paper.goals(), "2 is the bound"
    for label, unit, value, remark in (
        ("objective, published design", "1", paper.objective(published), bound),
        ("objective, best design", "1", paper.objective(best), bound),
        (
            "least foundation force of all designs",
            "N",
            goals[0],
            f"at m2 = {paper.single[0][0]:.1f} kg",
        ),
        (
            "least torque fluctuation of all designs",
            "N.m",
            goals[1] / RATIO[name],
            f"at m2 = {paper.single[1][0]:.1f} kg",
        ),
        ("inertia torque as printed", "kN.m", _swing(name, AsPrinted), "crest to trough"),
        ("inertia torque, exact", "kN.m", _swing(name, Mill), "crest to trough"),
    ):
        yield Row(head + label, unit, None, value, CHOSEN, remark)
    for design in DESIGNS:
        label = f"{head}torque fluctuation {design}, exact and with gravity"
        yield Row(label, "N.m", None, heavy[design], CHOSEN, "the source leaves gravity out")


def _swing(name: str, kind: type[Mill]) -> float:
    """Inertia torque of the published design from crest to trough, kN.m."""
    w = SPEED[name]
    system = turned(mill(name, kind=kind, T_f=0.0, M0=0.0), w * lp.time)
    torque = crank_torque(revolution(system, w, np.arange(0.0, 360.05, 0.1)))
    return float(np.ptp(torque)) / 1e3


def drawn() -> Driven:
    """The machine with a wanted speed."""
    return Driven(wanted=Driven.gear.ratio * Driven.w)


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Force and torque of a turn at constant speed with changed parameters."""
    w = SPEED["P"]
    system = turned(mill("P"), w * lp.time)
    turn = revolution(system, w, np.arange(0.0, 360.05, 0.25), shared(system, parameters))
    force = float(np.hypot(*shaking_force(turn).T).max())
    return [
        Measure("greatest force on the foundation", "N", force),
        Measure("fluctuation of the crank torque", "N.m", float(np.ptp(crank_torque(turn, IDLE)))),
    ]


MACHINE = Machine("pilger_mill", ABOUT, rows, drawn, start_up, effects, short=3.0)
