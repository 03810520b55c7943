"""Drives of published and computed torsional cases, and their tables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

import lumped as lp
from lumped.components import Engine, Torque
from lumped.models.diesel_genset.drive import ENGINE, Crankshaft
from lumped.models.marine_turbine.drive import MarineTurbine

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


def rows(case: str, name: str) -> list[dict[str, str]]:
    """Rows of a table as texts by the heads of their columns."""
    with (DATA / case / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def marine(*, damped: bool) -> lp.System:
    """Marine steam turbine (Gunter and Chen, 2001) with a torque in place of its blades."""
    model = MarineTurbine().with_({"blades": Torque(tau=0.0)})
    if not damped:
        model = model.with_({"load.d": 0.0, "low.steam.d": 0.0, "high.steam.d": 0.0})
    return lp.assemble(model)


def blades(w: np.ndarray) -> np.ndarray:
    """Amplitude of the propeller's torque of order 5, N.m, over its speed, rad/s."""
    return 0.1 * 22.24e6 * LBF_IN * (w / RPM / 85) ** 2


INERTIAS = (0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750)
STIFFNESSES = (1.106e6, 1.631e6, 1.253e6, 1.253e6, 1.678e6, 1.253e6, 1.253e6, 1.976e6)
SHARE = 0.0685 / 0.207
SERIES = ((1, 1.0), (2, SHARE), (4, -(SHARE**3) / 4), (6, 9 / 128 * SHARE**5))
BODIES = ("pulley", "gears", *(f"engine.throw[{i}]" for i in range(6)), "flywheel")


class Excited(Crankshaft):
    """Six-cylinder diesel crankshaft with a torque in place of each cylinder."""

    engine: Engine = ENGINE.with_({"cylinder": tuple(Torque(tau=0.0) for _ in range(6))})


def peak_share(rpm: float) -> float:
    """Peak pressure at a speed over 15.2 MPa."""
    table = columns("02_six_cylinder_crankshaft", "peak_pressure.csv")
    return float(np.interp(rpm, table["rpm"], table["peak_pressure_MPa"]) / 15.2)
