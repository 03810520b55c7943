"""What does a controller cost that is a unit of another tool?

A motor drives a roll over a shaft; a PI controller sets its torque a thousand times a second. The
controller is a component between samples and holds, then a unit in a process of its own. Times are
the best of several runs of one second in one process; read the ratios.

    python -m benchmarks.units_in
"""

import csv
import tempfile
import time
from pathlib import Path

import numpy as np

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    PIController,
    SampleHold,
    SpeedSensor,
    SpringDamper,
    Torque,
    from_fmu,
)
from lumped.support.text_table import table

T_S, UNTIL, ROUNDS = 1e-3, 1.0, 7


def drive(controller: lp.Component, *, held: bool) -> lp.System:
    """The drive; a controller of equations stands between samples and holds."""
    parts = {
        "motor": Torque(),
        "rotor": Inertia(J=2.0),
        "shaft": SpringDamper(c=4e4, d=5.0),
        "roll": Inertia(J=3.0),
        "friction": Damper(d=0.3),
        "ground": Fixed(),
        "sensor": SpeedSensor(),
        "law": controller,
    }
    if held:
        parts |= {"sample": SampleHold(T_s=T_S), "hold": SampleHold(T_s=T_S)}

    def connections(m):
        yield from lp.chain(m.motor, m.rotor, m.shaft, m.roll, m.friction, m.ground)
        yield lp.connect(m.rotor.flange_b, m.sensor.flange)
        if held:
            yield lp.connect(m.sensor.w, m.sample.u)
            yield lp.connect(m.sample.y, m.law.measured)
            yield lp.connect(m.law.y, m.hold.u)
            yield lp.connect(m.hold.y, m.motor.tau)
        else:
            yield lp.connect(m.sensor.w, m.law.measured)
            yield lp.connect(m.law.y, m.motor.tau)

    return lp.assemble(lp.compose(**parts, connections=connections))


def main() -> None:
    """Print and write the table."""
    law = {"k": 5.0, "T_i": 0.5, "wanted": 10.0}
    reference = drive(PIController(**law), held=True)
    samples = UNTIL / T_S
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for version in ("2.0", "3.0"):
            path = Path(name) / f"law_{version}.fmu"
            exported = lp.assemble(PIController(**law | {"measured": 0.0}))
            lp.export_fmu(exported, path, version=version, inputs=["measured"], outputs=["y"])
            for kind in ("co_simulation", "model_exchange"):
                system = drive(from_fmu(path, kind=kind, T_s=T_S), held=False)
                own = others = np.inf
                for _ in range(ROUNDS):
                    seconds, expected = _timed(reference)
                    own = min(own, seconds)
                    seconds, found = _timed(system)
                    others = min(others, seconds)
                worst = abs(found["rotor.w"][-1] / expected["rotor.w"][-1] - 1)
                each = 1e6 * (others - own) / samples
                numbers = (f"{1e3 * own:.3g}", f"{1e3 * others:.3g}", f"{others / own:.2g}")
                words = kind.replace("_", " ")
                rows.append((version, words, *numbers, f"{each:.0f}", f"{worst:.0e}"))
    header = ("FMI", "kind", "equations, ms", "unit, ms", "ratio", "a sample, us", "deviation")
    print(table(header, rows))
    path = Path(__file__).parent / "results" / "units_in.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])


def _timed(system: lp.System) -> tuple[float, lp.Trajectory]:
    begin = time.perf_counter()
    run = lp.simulate(system, until=UNTIL, grid=100)
    return time.perf_counter() - begin, run


if __name__ == "__main__":
    main()
