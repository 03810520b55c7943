"""Cold pilger mill LG90: published numbers of its balancing beside computed ones.

The drive and its source are described in `lumped.models.pilger_mill_stand`, its balance in
`lumped.models.pilger_mill_balance`, its motor in `lumped.models.pilger_mill_drive`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from lumped.models import Row
from lumped.models.pilger_mill_balance import Balance, balance
from lumped.models.pilger_mill_drive import GEAR, Driven, running
from lumped.models.pilger_mill_stand import DESIGNS, OFFSET, RADIUS, RATIO, ROD, SPEED, Mill

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE = "table 2"
FORCE = {"before": 491228.9, "after": 320910.4}  # N  F1 [P]
FLUCTUATION = {"before": 84439.48, "after": 84516.00}  # N.m  F2 [P]
POWER = {"before": 510.0, "after": 501.0}  # kW  N [P]
SLOW = "set P has a plausible speed; this force needs 127.2 1/min or more"
UNFIT = "no set explains a drop of 9 kW"
FREE = "fitted; the text defines it at the motor's shaft"
PLAIN = {"P": "fitted; at the crank's shaft", "F": FREE}
NOT = "not published"
FINE = 14400  # points of a revolution


def rows() -> list[Row]:
    """Published and computed numbers of both sets of parameters."""
    stroke = np.sqrt((ROD + RADIUS) ** 2 - OFFSET**2) - np.sqrt((ROD - RADIUS) ** 2 - OFFSET**2)
    found = [Row("stroke of the stand", "mm", None, 1e3 * stroke, NOT, "from R, L and e")]
    for name in ("F", "P"):
        found += _compared(name)
    run = running(grid=2000)
    steady = run.t > 0.95
    torque = run["motor.tau"][steady]
    remark = "motor and gear are assumed"
    found.append(Row("set P, motor torque, greatest", "N.m", None, torque.max(), NOT, remark))
    found.append(Row("set P, motor torque, least", "N.m", None, torque.min(), NOT, remark))
    return found


def model() -> Driven:
    """The machine to draw and to report on."""
    return Driven(wanted=GEAR * SPEED["P"])


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.pilger_mill_figures import figures

    return figures()


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
        power[design] = powers(paper, design, w)["mean" if name == "F" else "peak"] / 1e3
        heavy[design] = exact.fluctuation(u) / RATIO[name]
    for design in DESIGNS:
        remark = "fitted" if name == "F" else SLOW
        yield Row(f"{head}F1 {design}", "N", FORCE[design], force[design], TABLE, remark)
    less = 100 * (1 - force["after"] / force["before"])
    yield Row(f"{head}reduction of F1", "%", 34.672, less, TABLE, "fitted")
    for design in DESIGNS:
        label = f"{head}F2 {design}"
        yield Row(label, "N.m", FLUCTUATION[design], torque[design], TABLE, PLAIN[name])
    for design in DESIGNS:
        reading = "mean power; " if name == "F" else "greatest power; "
        label = f"{head}motor power {design}"
        yield Row(label, "kW", POWER[design], power[design], TABLE, reading + UNFIT)
    paper = balance(name)
    best = paper.optimum()
    flat = "the optimum is a kink of a flat function"
    for i, (key, unit) in enumerate((("m2", "kg"), ("U", "kg.m"))):
        label = f"{head}best {'ms Rs' if i else 'm2'}"
        yield Row(label, unit, DESIGNS["after"][key], float(best[i]), TABLE, flat)
    published = np.array(list(DESIGNS["after"].values()))
    for label, u in (("published design", published), ("best design", best)):
        yield Row(f"{head}objective, {label}", "1", None, paper.objective(u), NOT, "2 is the bound")
    for design in DESIGNS:
        label = f"{head}F2 {design}, exact and with gravity"
        yield Row(label, "N.m", None, heavy[design], NOT, "the source leaves gravity out")
