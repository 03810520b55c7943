"""What does a stiff drive cost, and how does that grow with its size?

A chain of inertias of 0.01 kg.m2 on shafts of 1e5 N.m/rad and 50 N.m.s/rad, at whose end a torque
of 100 N.m steps in after 0.01 s; until 0.5 s. The first table has the time over the error at the
end of CVODE's BDF method (scikit-sundae, the extra `bench`) with a banded Jacobian and a right-hand
side in NumPy, its states in the order that makes the band narrow, and of its fastest run that is at
least as accurate as lumped. The second has how lumped's time grows. Errors are those of the speeds
at the end over the largest of them, against the matrix exponential.
Times are the best of several runs in one process; read the ratios.

    python -m benchmarks.stiff_chain
"""

import os
import tempfile
import time

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import expm_multiply

import lumped as lp
from benchmarks.harness import publish, run_timed, time_action
from lumped.components import Inertia, SpringDamper, Torque
from lumped.ops import where
from lumped.timeloop.plants.executable import executable

J, C, D, TORQUE, STEP, END, RTOL = 0.01, 1e5, 50.0, 100.0, 0.01, 0.5, 1e-6
COMPARED, GROWING = (300, 1000), (300, 1000, 3000, 10000)
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9, 3e-10, 1e-10)


def chain(n: int) -> lp.Component:
    """Equal inertias on equal shafts."""

    def joints(m):
        yield from lp.chain(m.motor, m.body[0])
        for i, shaft in enumerate(m.shaft):
            yield from lp.chain(m.body[i], shaft, m.body[i + 1])

    return lp.compose(
        motor=Torque(tau=where(lp.time < STEP, 0.0, TORQUE)),
        body=[Inertia(J=J) for _ in range(n)],
        shaft=[SpringDamper(c=C, d=D) for _ in range(n - 1)],
        connections=joints,
    )


def exact(n: int) -> np.ndarray:
    """Speeds at the end: a linear system under a constant torque."""
    eye = scipy.sparse.identity(n, format="csr")
    twist = (eye[1:] - eye[:-1]).tocsr()
    torque = scipy.sparse.csr_matrix(([TORQUE / J], ([0], [0])), (n, 1))
    a = scipy.sparse.bmat(
        [
            [None, twist, None],
            [-C / J * twist.T, -D / J * twist.T @ twist, torque],
            [None, None, scipy.sparse.csr_matrix((1, 1))],
        ],
        format="csr",
    )
    x = np.zeros(2 * n)
    x[-1] = 1.0
    return expm_multiply(a * (END - STEP), x)[n - 1 : -1]


def by_cvode(n: int, rtol: float):
    """A run by CVODE as a function without arguments; speeds and twists take turns."""
    from sksundae.cvode import CVODE

    torque, load = np.empty(n + 1), 0.0

    def rate(_: float, y: np.ndarray, yp: np.ndarray) -> None:
        twisting = yp[1::2]
        np.subtract(y[2::2], y[:-2:2], out=twisting)
        torque[0], torque[-1] = -load, 0.0
        torque[1:-1] = C * y[1::2] + D * twisting
        np.subtract(torque[1:], torque[:-1], out=yp[::2])
        yp[::2] /= J

    options = {"linsolver": "band", "lband": 2, "uband": 2, "max_num_steps": 1_000_000}
    solver = CVODE(rate, method="BDF", rtol=rtol, atol=rtol * 1e-3, **options)

    def run() -> np.ndarray:
        nonlocal load
        y = np.zeros(2 * n - 1)
        for begin, end, load in ((0.0, STEP, 0.0), (STEP, END, TORQUE)):  # noqa: B007
            found = solver.solve(np.array([begin, end]), y)
            if not found.success:
                raise RuntimeError(found.message)
            y = found.y[-1]
        return y[::2]

    return run


def own(system: lp.System, method: str) -> tuple[float, lp.Trajectory]:
    """Best time of a run, and the run."""
    options = {"until": END, "rtol": RTOL, "grid": [END], "method": method}
    found, _ = run_timed(system, 10, **options)
    return found.seconds, found.result


def speeds(run: lp.Trajectory, n: int) -> np.ndarray:
    """Speeds at the end."""
    return np.array([run[f"body[{i}].w"][-1] for i in range(n)])


def compare(n: int, system: lp.System) -> list[tuple[str, ...]]:
    """Times and errors of both."""
    reference, ways = exact(n), []
    largest = np.abs(reference).max()

    def error(w: np.ndarray) -> float:
        return float(np.abs(w - reference).max() / largest)

    for method in ("auto", "implicit"):
        seconds, run = own(system, method)
        used = run.statistics.method
        label = f"lumped, {'default' if method == 'auto' else method} ({used}), rtol {RTOL:g}"
        ways.append((label, error(speeds(run, n)), seconds))
    for rtol in TOLERANCES:
        found = time_action(by_cvode(n, rtol), 3)
        way = (f"CVODE BDF, banded, NumPy, rtol {rtol:g}", error(found.result), found.seconds)
        if way[1] <= ways[0][1]:
            break
    ways.append(way)
    return [
        (str(n), label, f"{e:.1e}", f"{seconds * 1e3:.1f}", f"{seconds / way[2]:.2f}")
        for label, e, seconds in ways
    ]


def measure_chains() -> tuple[list[tuple[str, ...]], list[tuple[str, ...]]]:
    """Rows of both tables; nothing of the chains is compiled yet."""
    rows, growth, base = [], [], np.inf
    for n in GROWING:
        begin = time.perf_counter()
        system = lp.assemble(chain(n))
        assembled = time.perf_counter() - begin
        begin = time.perf_counter()
        lp.simulate(system, until=END, rtol=RTOL, grid=[END])
        first = time.perf_counter() - begin
        begin = time.perf_counter()
        executable(system).compile()
        compiled = time.perf_counter() - begin
        if n in COMPARED:
            rows += compare(n, system)
        seconds, run = own(system, "auto")
        attempts = run.steps + run.statistics.rejected
        each = seconds / attempts / n
        base = min(base, each)
        numbers = (f"{assembled:.2f}", f"{first:.2f}", f"{compiled:.2f}", f"{seconds:.3f}")
        growth.append((str(n), *numbers, str(attempts), f"{each * 1e9:.0f}", f"{each / base:.2f}"))
    return rows, growth


def main() -> None:
    """Print the tables and write them to the results."""
    lp.simulate(lp.assemble(chain(2)), until=END)  # the time loop itself is compiled
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LUMPED_CACHE"] = folder
        rows, growth = measure_chains()
    head = ("inertias", "way", "error", "ms", "ratio to CVODE")
    publish("stiff_chain_peers", head, rows)
    head = ("inertias", "assemble, s", "first run, s", "compile, s", "run, s", "attempted steps")
    head = (*head, "ns per attempt and inertia", "over the least before")
    publish("stiff_chain_growth", head, growth)


if __name__ == "__main__":
    main()
