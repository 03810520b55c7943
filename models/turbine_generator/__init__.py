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
from lumped.models.about import Measure, find_shared, number_values, read_about
from lumped.models.turbine_generator import scenes
from lumped.models.turbine_generator.drive import BEGIN, SHAFTS, Train, TurbineGenerator

BENCHMARK, DIGITS = "torsional frequencies [P]", "equal in the printed digits"
NOT = "not published [R]"
PUBLISHED = (15.71, 20.21, 25.55, 32.28, 47.46)  # Hz
TORQUES = {"air gap": "gen.tau"} | SHAFTS
WORST = {4: (0.1842, 1.293165), 3: (0.2849, 1.239080), 2: (0.3786, 0.572041), 1: (0.4726, 4.537599)}
"""Reactance of the series capacitor, pu, that excites a mode worst; its growth by NumPy, 1/s."""
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
        Row(f"torsional frequency, mode {i}", "Hz", published, value, BENCHMARK, DIGITS)
        for i, (published, value) in enumerate(zip(PUBLISHED, hertz, strict=True), 1)
    ]
    for mode, (X_c, by_hand) in WORST.items():
        name = f"series capacitor of {X_c} pu, growth of mode {mode}"
        growth = scenes.find_growth([X_c])[0, mode - 1]
        remark = f"{by_hand:.6f} by equations in d and q, in NumPy"
        found.append(Row(name, "1/s", None, growth, NOT, remark))
    grid = np.concatenate([[0.0], BEGIN + np.linspace(0.0, 0.5, 15_001)])
    for phases, text in (("abc", "three-phase fault"), ("bc", "line-to-line fault")):
        run = scenes.run_short_circuit(phases=phases, grid=grid, rtol=1e-9)
        for name, torque in TORQUES.items():
            course = scenes.per_unit(run, torque)
            remark = "in rated torques; no other value"
            if phases == "abc":
                remark = f"{BY_SCIPY[name]} by equations in d and q, in SciPy"
            elif name in ("air gap", "LPB-GEN"):
                remark = "in rated torques; the course agrees with fluxes in fixed axes, in SciPy"
            largest = course[np.abs(course).argmax()]
            found.append(Row(f"{text}, {name}, largest torque", "1", None, largest, NOT, remark))
    return found


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Torsional frequencies with changed parameters."""
    train = lp.assemble(Train())
    hertz = lp.modes(train, parameters=find_shared(train, parameters)).hertz
    return number_values("torsional frequency, mode", "Hz", hertz)


def begin(system: lp.System, parameters: Mapping[str, Any] | None) -> lp.OperatingPoint:
    """The steady state before the fault, from which bus, excitation and steam follow."""
    given = {name: value for name, value in (parameters or {}).items() if name not in scenes.FREE}
    return scenes.find_rated_point(system, given)


ABOUT = read_about(
    "turbine_generator",
    until=0.52,
    watched={
        "torque in the air gap": "gen.tau",
        "torque of the shaft LPB-GEN": "turbine.lpb_gen.tau",
        "torque of the shaft LPA-LPB": "turbine.lpa_lpb.tau",
        "speed of the generator": "gen.w",
    },
)
MACHINE = Machine(
    *("turbine_generator", ABOUT, rows, TurbineGenerator, scenes.run_short_circuit, effects),
    short=0.2,
    searched=begin,
    grid=8000,
)
