"""What happens to the five machines at their edges?

One parameter of the run of each report goes to extremes: stiffness, inertia, geometry near a dead
centre, tolerance. The error is the largest of a state over its range, against a reference by steps
at a hundredth of the tolerance whose own error stands beside it. Within is below a hundred
tolerances; outside are torques of shafts so stiff that the absolute tolerance of their twist does
not fit, and runs with other events; what is refused says why.

    python -m benchmarks.machine_extremes
"""

from benchmarks.harness import publish
from lumped.errors import LumpedError
from lumped.models import machine

RTOL = 1e-6
CASES = {
    "carrousel_coiler": {
        "free": (100.0, 10.0, 1.0, 0.1),
        "drive.rotor.J": (1e-3, 1.0, 1e6),
        "drive.h": (1e-5, 1e-3, 5e-3),
    },
    "pilger_mill": {
        "mill.e": (0.0, 0.33, 2.0, 3.6),
        "mill.L1": (0.6, 0.591, 0.59001),
        "shaft.J": (1e-6, 3e3, 1e9),
        "motor.T": (1e-6, 0.02, 10.0),
    },
    "eccentric_shear": {
        "eps": (0.0, 0.5, 0.9, 0.99),
        "motor.J": (5.4e2, 5.4e4, 5.4e8),
        "loaded.shear.upper.length": (3.4, 0.26, 0.2501),
        "motor.L": (1e-9, 3e-4, 1.0),
    },
    "reversing_mill": {
        "upper.shaft.c": (2.6e2, 2.6e5, 2.6e9, 2.6e13),
        "upper.rolls.J": (1e-6, 1.57, 1e6),
        "M_s": (1073.9, 1431.8, 1e9),
    },
    "rotary_arm": {
        "motor.J": (1e-3, 12.8, 1e5),
        "arm.m_x": (1.0, 3.17e4, 3.17e7),
        "motor.T": (1e-6, 5e-3, 1.0),
    },
}
"""Parameters by the machine, and their values, one of which is the machine's own."""


def measure(name: str, changes: dict[str, float], rtol: float) -> tuple[str, ...]:
    """Error, error of the reference, run time, steps and outcome."""
    try:
        found = machine(name).accuracy(changes or None, methods=["auto"], tolerances=[rtol])
    except LumpedError as fault:
        return "", "", "", "", f"refused: {str(fault).splitlines()[0]}"
    (row,) = found.rows
    numbers = f"{row.error:.1e}", f"{found.reference_error:.1e}", f"{1e3 * row.seconds:.3g}"
    outcome = "within"
    if row.outcome != "ok":
        outcome = f"OUTSIDE: {row.outcome}"
    elif row.error > 100 * rtol + found.reference_error:
        outcome = "OUTSIDE"
    return *numbers, str(row.steps), outcome


def main() -> None:
    """Print the table and write it to the results."""
    head = ("machine", "parameter", "value", "rtol", "error", "of reference", "ms", "steps")
    rows = []
    for name, parameters in CASES.items():
        cases = [({key: value}, RTOL) for key, values in parameters.items() for value in values]
        cases += [({}, rtol) for rtol in (1e-2, 1e-4, 1e-8, 1e-11)]
        for changes, rtol in cases:
            ((key, value),) = changes.items() or (("", ""),)
            rows.append((name, key, f"{value}", f"{rtol:.0e}", *measure(name, changes, rtol)))
    publish("machine_extremes", (*head, "outcome"), rows)


if __name__ == "__main__":
    main()
