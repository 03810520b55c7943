"""What does a call without options cost, against the fastest way to the same accuracy?

Two masses on a damped shaft under a torque that steps, 1 s, and the three masses of `time_loop`,
2 s. The errors are the largest of a state at 501 output times over its range, against SciPy's
DOP853 at a tight tolerance. The fastest way is the quickest method, over a ladder of tolerances,
whose error is at most 1e-6 or that of the default call if that is larger. SciPy's DOP853 on NumPy
with dense output is held to the same. Set-up is assembling and compiling.
Times are the best of several runs in one process, with everything compiled; read the ratios.

    python -m benchmarks.default_call
"""

import itertools
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.harness import build, publish, time_action
from benchmarks.time_loop import THREE
from lumped.components import Inertia, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.ops import where

TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8)
ROUNDS = 200


class Two(lp.Component):
    """Two masses on a damped shaft; the motor's torque steps."""

    a: Inertia = Inertia(J=2.0)
    s: SpringDamper = SpringDamper(c=1e4, d=5.0)
    b: Inertia = Inertia(J=1.0)
    motor: Torque = Torque(tau=where(lp.time < 0.1, 0, 50))

    def connections(self):
        """Join them in a row."""
        yield from lp.chain(self.motor, self.a, self.s, self.b)


def two(t: float, x: np.ndarray) -> np.ndarray:
    """Right-hand side of the two masses in NumPy: twist, speeds."""
    twisting = x[2] - x[1]
    torque = 1e4 * x[0] + 5.0 * twisting
    motor = 0.0 if t < 0.1 else 50.0
    return np.array([twisting, (motor + torque) / 2.0, -torque])


Problem = tuple[Callable[[], lp.Component], Callable[..., np.ndarray], tuple[float, ...], list[str]]
PROBLEMS: dict[str, Problem] = {
    "two masses, 1 s": (Two, two, (0, 0.1, 1.0), ["s.phi_rel", "a.w", "b.w"]),
    "three masses, 2 s": (THREE.model, THREE.rate, THREE.edges, THREE.names),
}


def by_scipy(rate, edges, states: int, times: np.ndarray, rtol: float) -> np.ndarray:
    """States at the times, by SciPy's DOP853 from edge to edge."""
    x, found = np.zeros(states), np.zeros((states, len(times)))
    for begin, end in itertools.pairwise(edges):
        here = (times >= begin) & (times <= end)
        inside, options = (begin, np.nextafter(end, begin)), {"rtol": rtol, "atol": rtol * 1e-3}
        run = solve_ivp(rate, inside, x, "DOP853", dense_output=True, **options)
        if here.any():
            found[:, here] = run.sol(times[here])
        x = run.y[:, -1]
    return found


def fastest(action, limit: float, error, rounds: int) -> tuple[float, float, float] | None:
    """Tolerance, error and time of the loosest run that is within the limit."""
    for rtol in TOLERANCES:
        found = error(action(rtol))
        if found <= limit:
            return rtol, found, time_action(lambda r=rtol: action(r), rounds)[0]
    return None


def rows_of(name: str) -> list[tuple[str, ...]]:
    """All ways on one problem."""
    model, rate, edges, wanted = PROBLEMS[name]
    (system, set_up), until = build(model()), edges[-1]
    times = np.linspace(0, until, 501)
    reference = by_scipy(rate, edges, len(wanted), times, 1e-12)
    ranges = np.ptp(reference, axis=1)

    def error(x: np.ndarray) -> float:
        return float((np.abs(x - reference).max(axis=1) / ranges).max())

    def states(run: lp.Trajectory) -> np.ndarray:
        place = np.searchsorted(run.t, times - 1e-9)
        return np.array([run[each][place] for each in wanted])

    run = lp.simulate(system, until=until)
    own = error(states(run))
    limit = max(1e-6, own)
    seconds = time_action(lambda: lp.simulate(system, until=until), ROUNDS)[0]
    ways = [(f"no options ({run.statistics.method})", set_up, 1e-6, own, seconds)]
    for method in ("explicit", "implicit", "exact"):

        def simulate(rtol: float, method=method) -> lp.Trajectory:
            return lp.simulate(system, until=until, rtol=rtol, method=method)

        try:
            found = fastest(simulate, limit, lambda r: error(states(r)), ROUNDS)
        except OptionError:  # there is no closed form
            continue
        if found:
            ways.append((method, set_up, *found))
    best = min(way[4] for way in ways[1:])
    found = fastest(lambda r: by_scipy(rate, edges, len(wanted), times, r), limit, error, 3)
    assert found
    ways.append(("SciPy DOP853, NumPy", 0.0, *found))
    return [
        (
            *(name, way, f"{made:.2f}", f"{rtol:g}", f"{e:.1e}", f"{s * 1e3:.3f}"),
            *(f"{s / best:.2f}", f"{s / found[2]:.4f}"),
        )
        for way, made, rtol, e, s in ways
    ]


def main() -> None:
    """Print the table and write it to the results."""
    head = ("problem", "way", "set-up, s", "rtol", "error", "ms", "over the fastest", "over SciPy")
    rows = [row for name in PROBLEMS for row in rows_of(name)]
    publish("default_call", head, rows)


if __name__ == "__main__":
    main()
