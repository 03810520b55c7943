"""Drives of published and computed torsional cases, and their tables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

import lumped as lp
from lumped.components import (
    Cylinder,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    LossSpring,
    Spring,
    Torque,
)

DATA = Path(__file__).parents[1] / "data" / "torsional"
LBF_IN = 0.11298
RPM = np.pi / 30
FIRST = (0, 4, 2, 5, 1, 3)
"""Positions of the cylinders in the firing order 1-5-3-6-2-4."""


def columns(case: str, name: str, texts: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """Columns of a table by their heads, numbers but for `texts`; what is not defined is nan."""
    with (DATA / case / name).open() as file:
        head, *rows = list(csv.reader(file))
    return {
        name: np.array(column if name in texts else [float(v) if v else np.nan for v in column])
        for name, column in zip(head, zip(*rows, strict=True), strict=True)
    }


def marine(*, damped: bool) -> lp.System:
    """Marine steam turbine with two gear stages and two branches (Gunter and Chen, 2001)."""
    f = LBF_IN
    grounded = 1.0 if damped else 0.0
    model = lp.compose(
        propeller=Inertia(J=2.454e6 * f),
        shaft=Spring(c=826e6 * f),
        bull=Inertia(J=0.826e6 * f),
        to_lp=IdealGear(ratio=1 / 9.4094),
        to_hp=IdealGear(ratio=1 / 9.4094),
        lp_intermediate=Spring(c=203.94e6 * f),
        hp_intermediate=Spring(c=24.17e6 * f),
        lp_wheel=Inertia(J=1.283e4 * f),
        hp_wheel=Inertia(J=2.723e4 * f),
        lp_gear=IdealGear(ratio=9.4094 / 40.0424),
        hp_gear=IdealGear(ratio=9.4094 / 78.2365),
        lp_shaft=Spring(c=30.51e6 * f),
        hp_shaft=Spring(c=14.26e6 * f),
        lp_turbine=Inertia(J=1.509e4 * f),
        hp_turbine=Inertia(J=2.612e2 * f),
        water=Damper(d=3.86e6 * f * grounded),
        hp_steam=Damper(d=42.738 * f * grounded),
        lp_steam=Damper(d=108.77 * f * grounded),
        ground=Fixed(),
        blades=Torque(tau=0.0),
        connections=lambda m: [
            *lp.chain(m.propeller, m.shaft, m.bull),
            *lp.chain(m.bull, m.to_lp, m.lp_intermediate, m.lp_wheel, m.lp_gear, m.lp_shaft),
            *lp.chain(m.lp_shaft, m.lp_turbine, m.lp_steam, m.ground),
            *lp.chain(m.bull, m.to_hp, m.hp_intermediate, m.hp_wheel, m.hp_gear, m.hp_shaft),
            *lp.chain(m.hp_shaft, m.hp_turbine, m.hp_steam, m.ground),
            *lp.chain(m.ground, m.water, m.propeller),
            lp.connect(m.blades.flange, m.propeller.flange_a),
        ],
    )
    return lp.assemble(model)


def blades(w: np.ndarray) -> np.ndarray:
    """Amplitude of the propeller's torque of order 5, N.m, over its speed, rad/s."""
    return 0.1 * 22.24e6 * LBF_IN * (w / RPM / 85) ** 2


INERTIAS = (0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750)
STIFFNESSES = (1.106e6, 1.631e6, 1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6, 1.976e6)
SHARE = 0.0685 / 0.207
SERIES = ((1, 1.0), (2, SHARE), (4, -(SHARE**3) / 4), (6, 9 / 128 * SHARE**5))


def six_cylinders(misfire: dict[int, str] | None = None, *, driven: bool = True) -> lp.System:
    """Six-cylinder diesel crankshaft (Mendes, Meirelles, Zampieri, 2008).

    Driven by its cylinders, at the pressure of 15.2 MPa, or by a torque at each of them.
    """
    table = columns("02_six_cylinder_crankshaft", "pressure_curve.csv")
    angles = np.radians(table["crank_angle_deg"])
    pressure = list(zip(angles, 1e6 * table["pressure_digitised_MPa"], strict=True))
    cylinders = [
        Cylinder(
            pressure=pressure,
            masses="series",
            series=SERIES,
            misfire=(misfire or {}).get(i, "none"),
            bore=0.105,
            r=0.0685,
            L=0.207,
            m=2.521,
            phase=position * 2 * np.pi / 3,
        )
        for i, position in enumerate(FIRST)
    ]
    model = lp.compose(
        mass=[Inertia(J=J) for J in INERTIAS],
        shaft=[LossSpring(c=c, eta=0.035, w_loss=1300.0) for c in STIFFNESSES],
        oil=[Damper(d=2.0) for _ in range(6)],
        cylinder=cylinders if driven else [Torque(tau=0.0) for _ in range(6)],
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(*(part for both in zip(m.mass, m.shaft, strict=False) for part in both)),
            *lp.chain(m.shaft[7], m.mass[8]),
            *(c for i in range(6) for c in lp.chain(m.ground, m.oil[i], m.mass[i + 2])),
            *(lp.connect(m.cylinder[i].flange, m.mass[i + 2].flange_a) for i in range(6)),
        ],
    )
    return lp.assemble(model)


def peak_share(rpm: float) -> float:
    """Peak pressure at a speed over 15.2 MPa."""
    table = columns("02_six_cylinder_crankshaft", "peak_pressure.csv")
    return float(np.interp(rpm, table["rpm"], table["peak_pressure_MPa"]) / 15.2)
