"""Does a Taylor series pay, and is it as quick as that of heyoka?

Three masses under a torque step, 2 s, of `ensembles`: a whole call of `simulate`, the loop in it,
and a run among 20 000 in lanes that takes the final speeds; by DOP853, by Taylor's series, and by
heyoka.py, one run and four side by side, if it is installed. The tolerance of each is the loosest
of 1e-5, 1e-6, ... that leaves an error of 1e-8 at the end, relative to the largest speed, against
the matrix exponential. Set-up is what the first call takes more than the best, of heyoka what makes
the integrator. Times are the least of many, and of the processor alone in lanes; the ratio is to
heyoka of the same kind.

    python -m benchmarks.series
"""

import time
from collections.abc import Callable, Iterator

import numpy as np
from scipy.linalg import expm

import lumped as lp
from benchmarks._ensemble_tasks import DELAY, ThreeMasses
from benchmarks.harness import publish, run_timed, time_action
from lumped import functionals

END, ALLOWED, RUNS, ROUNDS = 2.0, 1e-8, 20_000, 2000
J, C, TORQUE = (0.5, 1.2, 3.0), (4e4, 2.5e4), 100.0
SPEEDS = tuple(f"mass[{i}].w" for i in range(3))
TOLERANCES = tuple(10.0**-k for k in range(5, 13))

Measured = dict[str, tuple[float, float, np.ndarray]]
"""Set-up and time in s, and the speeds at the end, of each way."""


def exact() -> np.ndarray:
    """Speeds at the end."""
    twist = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])
    rates = np.zeros((6, 6))
    rates[:2, 2:5] = twist
    rates[2:5, :2] = -(twist.T * np.array(C)) / np.array(J)[:, None]
    rates[2:5, 2:5] = DELAY * rates[2:5, :2] @ twist
    rates[2, 5] = TORQUE / J[0]
    found: np.ndarray = (expm(rates * END) @ np.eye(6)[5])[2:5]
    return found


def in_lumped(method: str, rtol: float) -> Measured:
    """A whole call, the loop in it, and a run among many."""
    system = lp.assemble(ThreeMasses())
    call, inner = run_timed(system, ROUNDS, until=END, rtol=rtol, method=method, grid=[END])
    speeds = np.array([call.result[name][-1] for name in SPEEDS])
    options = {"until": END, "rtol": rtol, "method": method, "workers": 1}
    over, of = {"motor.tau": np.full(RUNS, TORQUE)}, [functionals.final(name) for name in SPEEDS]
    lanes = time_action(
        lambda: lp.ensemble(system, over=over, of=of, **options), 5, time.process_time
    )
    return {
        "call": (call.first - call.seconds, call.seconds, speeds),
        "loop": (call.first - call.seconds, inner, speeds),
        "in lanes": (lanes.first - lanes.seconds, lanes.seconds / RUNS, lanes.result.values[0]),
    }


def in_heyoka(_: str, rtol: float) -> Measured:
    """One run, and four side by side."""
    import heyoka

    a, b, u, v, w = heyoka.make_vars("a", "b", "u", "v", "w")
    first, second = C[0] * (a + DELAY * (u - v)), C[1] * (b + DELAY * (v - w))
    rates = (u - v, v - w, (TORQUE - first) / J[0], (first - second) / J[1], second / J[2])
    equations, found = list(zip((a, b, u, v, w), rates, strict=True)), {}
    for what, make, zero, many in (
        ("call", heyoka.taylor_adaptive, np.zeros(5), 1),
        ("in lanes", heyoka.taylor_adaptive_batch, np.zeros((5, 4)), 4),
    ):
        begin = time.perf_counter()
        stepper = make(equations, zero, tol=rtol)
        made = time.perf_counter() - begin

        def run(stepper=stepper, many=many) -> np.ndarray:
            stepper.state[:] = 0.0
            stepper.set_time(0.0) if many > 1 else setattr(stepper, "time", 0.0)
            stepper.propagate_until(END)
            return stepper.state[2:].reshape(3, -1)[:, 0].copy()

        one = time_action(run, ROUNDS)
        found[what] = (made, one.seconds / many, one.result)
    return found


def rows_of(name: str, measure: Callable[[str, float], Measured], method: str) -> Iterator:
    """All ways at the loosest tolerance with which the least accurate is accurate enough."""
    right = exact()
    for rtol in TOLERANCES:
        found = measure(method, rtol)
        errors = [np.abs(x - right).max() / np.abs(right).max() for *_, x in found.values()]
        if max(errors) <= ALLOWED:
            for (what, (set_up, seconds, _)), error in zip(found.items(), errors, strict=True):
                yield f"{name}, {what}", rtol, error, set_up, seconds
            return


def main() -> None:
    """Print the table and write it to the results."""
    head = ("what", "rtol", "error", "set-up, s", "time, us", "over heyoka")
    found = []
    for way in (("DOP853", in_lumped, "explicit"), ("series", in_lumped, "taylor")):
        found += rows_of(*way)
    try:
        found += rows_of("heyoka", in_heyoka, "")
    except ImportError:
        print("heyoka is not installed")
    seconds = {name: time_of for name, *_, time_of in found}
    rows = []
    for name, rtol, error, set_up, own in found:
        peer = seconds.get("heyoka, in lanes" if "lanes" in name else "heyoka, call")
        ratio = f"{own / peer:.2f}" if peer else ""
        cells = (f"{rtol:.0e}", f"{error:.1e}", f"{set_up:.2f}", f"{own * 1e6:.1f}")
        rows.append((name, *cells, ratio))
    publish("series", head, rows)


if __name__ == "__main__":
    main()
