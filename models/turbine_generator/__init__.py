"""Turbine generator of a benchmark: published frequencies beside computed ones, and faults.

The machine and its source are described in `lumped.models.turbine_generator.drive`, faults at its
terminals in `lumped.models.turbine_generator.scenes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, find_shared, number_values
from lumped.models.turbine_generator.about import ABOUT
from lumped.models.turbine_generator.drive import BEGIN, SHAFTS, Train, TurbineGenerator
from lumped.models.turbine_generator.scenes import (
    FREE,
    find_rated_point,
    per_unit,
    run_short_circuit,
)

BENCHMARK = "torsional frequencies [P]"
NOT = "not published [R]"
PUBLISHED = (15.71, 20.21, 25.55, 32.28, 47.46)  # Hz
TORQUES = {"air gap": "gen.tau"} | SHAFTS
BY_SCIPY = {  # largest torques of the three-phase fault, pu, from dq equations in SciPy
    "air gap": "8.002358",
    "HP-IP": "0.823051",
    "IP-LPA": "1.364340",
    "LPA-LPB": "2.279888",
    "LPB-GEN": "3.159265",
    "GEN-EXC": "0.207335",
}


def rows() -> list[Row]:
    """Published and computed numbers."""
    hertz = lp.modes(lp.assemble(Train())).hertz
    found = [
        Row(
            f"torsional frequency, mode {i}",
            "Hz",
            published,
            float(value),
            BENCHMARK,
            "equal in the printed digits",
        )
        for i, (published, value) in enumerate(zip(PUBLISHED, hertz, strict=True), 1)
    ]
    grid = np.concatenate([[0.0], BEGIN + np.linspace(0.0, 0.5, 15_001)])
    for phases, text in (("abc", "three-phase fault"), ("bc", "line-to-line fault")):
        run = run_short_circuit(phases=phases, grid=grid, rtol=1e-9)
        for name, torque in TORQUES.items():
            course = per_unit(run, torque)
            remark = "in rated torques; no other value"
            if phases == "abc":
                remark = f"{BY_SCIPY[name]} by equations in d and q, in SciPy"
            elif name in ("air gap", "LPB-GEN"):
                remark = "in rated torques; the course agrees with fluxes in fixed axes, in SciPy"
            largest = float(course[np.abs(course).argmax()])
            found.append(Row(f"{text}, {name}, largest torque", "1", None, largest, NOT, remark))
    return found


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Torsional frequencies with changed parameters."""
    train = lp.assemble(Train())
    hertz = lp.modes(train, parameters=find_shared(train, parameters)).hertz
    return number_values("torsional frequency, mode", "Hz", hertz)


def begin(system: lp.System, parameters: Mapping[str, Any] | None) -> lp.OperatingPoint:
    """The steady state before the fault, from which bus, excitation and steam follow."""
    given = {name: value for name, value in (parameters or {}).items() if name not in FREE}
    return find_rated_point(system, given)


MACHINE = Machine(
    *("turbine_generator", ABOUT, rows, TurbineGenerator, run_short_circuit, effects),
    short=0.2,
    searched=begin,
    grid=8000,
)
