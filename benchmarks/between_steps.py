"""How accurate is a run between its steps?

A rotor of 0.3 kg.m2 on a stiff torque-speed curve with a fan, 6 s, under a torque that rises
slowly, so that steps are long. The error is that of its speed over its range and the tolerance, at
the ends of the steps and at 5 000 times, against SciPy's Radau at a tight tolerance. SciPy's DOP853
with its dense output stands beside it.

    python -m benchmarks.between_steps
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.harness import publish
from lumped.components import Damper, Fixed, Inertia, QuadraticTorque, Torque
from lumped.ops import table as tabulated

EDGES, START = (0.0, 0.5, 5.5, 6.0), 149.0
TIMES = np.linspace(0, EDGES[-1], 5001)


def rotor() -> lp.System:
    """The drive."""

    def joints(m):
        yield from lp.chain(m.motor, m.rotor, m.slip, m.ground)
        yield lp.connect(m.rotor.flange_b, m.fan.flange)

    return lp.assemble(
        lp.compose(
            motor=Torque(tau=1209 + 60 * tabulated([0.5, 5.5], [0.0, 1.0])),
            rotor=Inertia(J=0.3, w=START),
            slip=Damper(d=8.1),
            ground=Fixed(),
            fan=QuadraticTorque(tau_nominal=-1.0, w_nominal=150.0),
            connections=joints,
        )
    )


def rate(t: float, w: np.ndarray) -> np.ndarray:
    """Its right-hand side by hand."""
    return (1209 + 60 * np.interp(t, [0.5, 5.5], [0, 1]) - 8.1 * w - w * abs(w) / 150**2) / 0.3


def by_scipy(method: str, rtol: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, list]:
    """Speed at the times, and the steps with the speeds at their ends."""
    found, w = np.empty(len(times)), np.array([START])
    steps, ends = [], []
    for begin, end in itertools.pairwise(EDGES):
        options = {"rtol": rtol, "atol": rtol * 1e-3, "dense_output": True}
        run = solve_ivp(rate, (begin, end), w, method, **options)
        here = (times >= begin) & (times <= end)
        found[here] = run.sol(times[here])[0]
        steps += run.t.tolist()
        ends += run.y[0].tolist()
        w = run.y[:, -1]
    return found, np.array(steps), ends


def exact(times: np.ndarray) -> np.ndarray:
    """Speed at the times."""
    return by_scipy("Radau", 1e-12, times)[0]


def main() -> None:
    """Print the table and write it to the results."""
    system, reference, rows = rotor(), exact(TIMES), []
    size = float(np.ptp(reference))

    def note_error(label: str, rtol: float, steps, at_steps, between) -> None:
        errors = [np.abs(at_steps - exact(steps)).max(), np.abs(between - reference).max()]
        shares = [f"{e / size / rtol:.2f}" for e in errors]
        rows.append((f"{rtol:g}", label, str(len(steps) - 1), *shares))

    for rtol in (1e-4, 1e-6, 1e-8):
        between, steps, ends = by_scipy("DOP853", rtol, TIMES)
        note_error("SciPy DOP853", rtol, steps, np.array(ends), between)
        for method in ("explicit", "implicit", "auto"):
            given = {"until": EDGES[-1], "rtol": rtol, "method": method}
            run = lp.simulate(system, **given, grid=None)
            fine = lp.simulate(system, **given, grid=TIMES)
            used = run.statistics.method
            label = f"lumped {'default (' + used + ')' if method == 'auto' else method}"
            note_error(label, rtol, run.t, run["rotor.w"], fine["rotor.w"])
    head = ("rtol", "way", "steps", "error at steps over rtol x range")
    head = (*head, "error between steps over rtol x range")
    publish("between_steps", head, rows)


if __name__ == "__main__":
    main()
