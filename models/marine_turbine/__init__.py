"""Geared steam turbines of a ship: published numbers beside computed ones.

The drive and its source are described in `lumped.models.marine_turbine.drive`, its vibrations in
`lumped.models.marine_turbine.scenes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, find_shared, number_values
from lumped.models.marine_turbine.about import ABOUT
from lumped.models.marine_turbine.drive import BLADES, MarineTurbine
from lumped.models.marine_turbine.scenes import response, run_up, slow_turning

EXAMPLE = "example 8.1 [P]"
FIGURE = "figure 8.10-5, digitised [P]"
NOT = "not published [R]"
DIGITS = "equal in the printed digits"
PUBLISHED = (177.7, 220.2, 1282.6)  # 1/min
HIGHER = ("2496.867 from K and M by SciPy", "2883.382 from K and M by SciPy")


def rows() -> list[Row]:
    """Published and computed numbers."""
    modes = lp.modes(lp.assemble(MarineTurbine()))
    found = lp.vibration.mass_elastic(modes, shaft="propeller.phi").hertz * 60
    steady = response(np.arange(20.0, 60.05, 0.1))
    size = {name: steady.magnitude(name, BLADES) for name in steady.of}
    top = int(size["shaft.tau"].argmax())
    text = "natural frequency, mode"
    return [
        *(
            Row(f"{text} {i}", "1/min", published, float(found[i - 1]), EXAMPLE, DIGITS)
            for i, published in enumerate(PUBLISHED, 1)
        ),
        *(
            Row(f"{text} {i}", "1/min", None, float(found[i - 1]), NOT, remark)
            for i, remark in enumerate(HIGHER, 4)
        ),
        Row(
            "propeller shaft, greatest vibratory torque",
            "kN.m",
            468.75,
            float(size["shaft.tau"][top] / 1e3),
            FIGURE,
            "highest of the digitised points",
        ),
        Row(
            "propeller shaft, speed there",
            "1/min",
            35.46,
            float(steady.rpm[top]),
            FIGURE,
            "highest of the digitised points",
        ),
        Row(
            "LP intermediate shaft, greatest vibratory torque",
            "kN.m",
            None,
            float(size["low.intermediate.tau"].max() / 1e3),
            NOT,
            "42.849 by dense linear algebra",
        ),
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


MACHINE = Machine(
    *("marine_turbine", ABOUT, rows, MarineTurbine, run_up, effects),
    short=20.0,
    searched=slow_turning,
    grid=8000,
)
