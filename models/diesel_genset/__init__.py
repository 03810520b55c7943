"""Six-cylinder diesel engine and its generator: published numbers beside computed ones.

The drive and its source are described in `lumped.models.diesel_genset.drive`, its vibrations in
`lumped.models.diesel_genset.scenes`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row, list_rows
from lumped.models.about import Measure, number_values, read_about
from lumped.models.diesel_genset import scenes
from lumped.models.diesel_genset.drive import SHAFTS, Genset

PICTURE = "picture of the example [P]"
NOT = "not published [R]"
ASSUMED = "not published, assumed parts [A]"
MATRICES = "by complex matrices in SciPy"
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
    return [*_compare_published(), *_natural(), *_largest(), *_coupling()]


def _compare_published() -> Iterator[Row]:
    steady = scenes.solve_crankshaft()
    for number, (torque, rpm) in PUBLISHED.items():
        size, text = (
            steady.synthesis(OUTER[number]).sum,
            f"shaft {number}, largest sum of amplitudes",
        )
        yield Row(text, "N.m", torque, size.max(), PICTURE, READ)
        at = steady.rpm[size.argmax()]
        yield Row(f"shaft {number}, speed there", "1/min", rpm, at, PICTURE, READ)


def _natural() -> list[Row]:
    hertz = lp.vibration.mass_elastic(scenes.mean_modes(), shaft="flywheel.phi").hertz
    remarks = {
        f"natural frequency, mode {i}": f"{known} from K and M by SciPy"
        for i, known in enumerate(NATURAL, 1)
    }
    return list_rows("Hz", NOT, remarks, hertz[: len(NATURAL)])


def _largest() -> Iterator[Row]:
    for case in scenes.CASES:
        for (number, name), known in zip(OUTER.items(), BY_SCIPY[case], strict=True):
            size = scenes.solve_crankshaft(case).synthesis(name).maximum.max()
            text, remark = f"shaft {number}, largest torque, {case}", f"{known} {MATRICES}"
            yield Row(text, "N.m", None, size, NOT, remark)


def _coupling() -> Iterator[Row]:
    rated = scenes.SLOW.index(1500)
    for case in scenes.CASES:
        size = scenes.solve_coupling(case).synthesis("coupling.tau").maximum[rated]
        text = f"coupling at 1500 1/min, {case}"
        yield Row(text, "N.m", None, size, ASSUMED, "vibratory torque")


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


ABOUT = read_about(
    "diesel_genset",
    until=0.6,
    watched={
        "torque of the coupling": "coupling.tau",
        "torque of shaft 8": "shaft_8.tau",
        "heat of the damper": "damper.power",
        "speed of the flywheel": "flywheel.w",
    },
)
MACHINE = Machine(
    *("diesel_genset", ABOUT, rows, Genset, scenes.run_up, effects),
    short=0.2,
    searched=scenes.starting,
    grid=8000,
)
