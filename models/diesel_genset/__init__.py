"""Six-cylinder diesel engine and its generator: published numbers beside computed ones.

The drive and its source are described in `lumped.models.diesel_genset.drive`, its vibrations in
`lumped.models.diesel_genset.scenes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, number_values
from lumped.models.diesel_genset import scenes
from lumped.models.diesel_genset.about import ABOUT
from lumped.models.diesel_genset.drive import SHAFTS, Genset

PICTURE = "picture of the example [P]"
NOT = "not published [R]"
ASSUMED = "not published, assumed parts [A]"
READ = "read off the picture, within about 0.5 %"
PUBLISHED = {8: (9530.0, 2170.0), 1: (867.0, 2170.0)}  # shaft: N.m, 1/min
NATURAL = ("216.5836", "592.7405", "984.9230", "1171.0174", "1415.9950")  # Hz, matrices in SciPy
BY_SCIPY = {  # largest torque of the shafts 8 and 1 over a cycle, N.m, matrices in SciPy
    "all cylinders fire": ("8832.63", "792.97"),
    "cylinder 1 compresses only": ("7742.57", "705.17"),
    "cylinder 1 has no gas": ("7246.30", "587.06"),
}
OUTER = {8: "shaft_8.tau_c", 1: "shaft_1.tau_c"}


def rows() -> list[Row]:
    """Published and computed numbers."""
    found = [*_compare_published(), *_natural()]
    for case in scenes.CASES:
        for (number, name), known in zip(OUTER.items(), BY_SCIPY[case], strict=True):
            size = float(scenes.solve_crankshaft(case).synthesis(name).maximum.max())
            remark = f"{known} by complex matrices in SciPy"
            text = f"shaft {number}, largest torque, {case}"
            found.append(Row(text, "N.m", None, size, NOT, remark))
    rated = scenes.SLOW.index(1500)
    for case in scenes.CASES:
        size = float(scenes.solve_coupling(case).synthesis("coupling.tau").maximum[rated])
        text = f"coupling at 1500 1/min, {case}"
        found.append(Row(text, "N.m", None, size, ASSUMED, "vibratory torque"))
    return found


def _compare_published() -> list[Row]:
    steady, found = scenes.solve_crankshaft(), []
    for number, (torque, rpm) in PUBLISHED.items():
        size = steady.synthesis(OUTER[number]).sum
        text = f"shaft {number}, largest sum of amplitudes"
        found.append(Row(text, "N.m", torque, float(size.max()), PICTURE, READ))
        at = float(steady.rpm[size.argmax()])
        found.append(Row(f"shaft {number}, speed there", "1/min", rpm, at, PICTURE, READ))
    return found


def _natural() -> list[Row]:
    hertz = lp.vibration.mass_elastic(scenes.mean_modes(), shaft="flywheel.phi").hertz
    return [
        Row(
            f"natural frequency, mode {i}",
            "Hz",
            None,
            float(value),
            NOT,
            f"{known} from K and M by SciPy",
        )
        for i, (value, known) in enumerate(zip(hertz[: len(NATURAL)], NATURAL, strict=True), 1)
    ]


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Natural frequencies and steady vibration with changed parameters."""
    modes = scenes.mean_modes(Genset(), parameters)
    hertz = lp.vibration.mass_elastic(modes, shaft="flywheel.phi").hertz
    found = number_values("natural frequency, mode", "Hz", hertz)
    of = [*SHAFTS, "coupling.tau"]
    steady = scenes.response(np.arange(1000.0, 1801.0, 50.0), Genset(), of, parameters)
    for name in of:
        size = steady.synthesis(name).maximum.max()
        found.append(Measure(f"largest vibration of {name}", "N.m", float(size)))
    return found


MACHINE = Machine(
    *("diesel_genset", ABOUT, rows, Genset, scenes.run_up, effects),
    short=0.2,
    searched=scenes.starting,
    grid=8000,
)
