"""Geared steam turbines of a ship: published numbers beside computed ones.

The drive and its source are described in `lumped.models.marine_turbine.drive`, its vibrations in
`lumped.models.marine_turbine.scenes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row, list_rows
from lumped.models.about import Measure, find_shared, number_values, read_about
from lumped.models.marine_turbine.drive import BLADES, MarineTurbine
from lumped.models.marine_turbine.scenes import response, run_up, slow_turning

EXAMPLE = "example 8.1 [P]"
FIGURE = "figure 8.10-5, digitised [P]"
NOT = "not published [R]"
DIGITS, HIGHEST = "equal in the printed digits", "highest of the digitised points"
PUBLISHED = (177.7, 220.2, 1282.6)  # 1/min
HIGHER = ("2496.867 from K and M by SciPy", "2883.382 from K and M by SciPy")


def rows() -> list[Row]:
    """Published and computed numbers."""
    modes = lp.modes(lp.assemble(MarineTurbine()))
    found = lp.vibration.mass_elastic(modes, shaft="propeller.phi").hertz * 60
    steady = response(np.arange(20.0, 60.05, 0.1))
    shaft, inner = (
        steady.magnitude(x, BLADES) / 1e3 for x in ("shaft.tau", "low.intermediate.tau")
    )
    speed, text = steady.rpm[shaft.argmax()], "greatest vibratory torque"
    low, hand = f"LP intermediate shaft, {text}", "42.849 by dense linear algebra"
    higher = {f"natural frequency, mode {i}": remark for i, remark in enumerate(HIGHER, 4)}
    return [
        *(
            Row(f"natural frequency, mode {i}", "1/min", published, hertz, EXAMPLE, DIGITS)
            for i, (published, hertz) in enumerate(zip(PUBLISHED, found, strict=False), 1)
        ),
        *list_rows("1/min", NOT, higher, found[3:5]),
        Row(f"propeller shaft, {text}", "kN.m", 468.75, shaft.max(), FIGURE, HIGHEST),
        Row("propeller shaft, speed there", "1/min", 35.46, speed, FIGURE, HIGHEST),
        Row(low, "kN.m", None, inner.max(), NOT, hand),
    ]


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Natural frequencies and steady vibration with changed parameters."""
    system = lp.assemble(MarineTurbine())
    own = find_shared(system, parameters)
    found = number_values("natural frequency, mode", "Hz", lp.modes(system, parameters=own).hertz)
    steady = response(np.arange(20.0, 100.1, 0.2), parameters=own)
    for name in steady.of:
        size = steady.magnitude(name, BLADES).max()
        found.append(Measure(f"greatest vibration of {name}", "N.m", float(size)))
    return found


ABOUT = read_about(
    "marine_turbine",
    until=240.0,
    watched={
        "torque of the propeller shaft": "shaft.tau",
        "torque of the LP turbine shaft": "low.shaft.tau",
        "torque of the HP turbine shaft": "high.shaft.tau",
        "speed of the propeller": "propeller.w",
    },
)
MACHINE = Machine(
    *("marine_turbine", ABOUT, rows, MarineTurbine, run_up, effects),
    short=20.0,
    searched=slow_turning,
    grid=8000,
)
