"""What does a call without options cost, against the fastest way to the same accuracy?

Two masses on a damped shaft under a torque that steps, 1 s, and the three masses of `time_loop`,
2 s. The errors are the largest of a state at 501 output times over its range, against SciPy's
DOP853 at a tight tolerance. The fastest way is the quickest method, over a ladder of tolerances,
whose error is at most 1e-6 or that of the default call if that is larger. SciPy's DOP853 on NumPy
with dense output is held to the same. Set-up is assembling and compiling.
Times are the best of several runs in one process, with everything compiled; read the ratios.

Then ten drives of which one inertia changes from call to call, as in a sweep by hand: the call
without options against the quickest method, over the same ladder, whose error is at most 1e-6 or
that of the call. The errors are those against steps at 1e-11; times are those of the processor, of
ten calls in a row, the ways in turn.

    python -m benchmarks.default_call
"""

import itertools
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.harness import build, in_turn, publish, time_action
from benchmarks.hybrid import Coupled
from benchmarks.time_loop import THREE
from lumped.components import IdealGear, InductionMotor, Inertia, Spring, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.ops import where

TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8)
ROUNDS, TURNS, CALLS = 200, 40, 10
STEPPED = where(lp.time < 0.1, 0, 50)


class Two(lp.Component):
    """Two masses on a damped shaft; the motor's torque steps."""

    a: Inertia = Inertia(J=2.0)
    s: SpringDamper = SpringDamper(c=1e4, d=5.0)
    b: Inertia = Inertia(J=1.0)
    motor: Torque = Torque(tau=STEPPED)

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


def in_a_row(*parts: lp.Component) -> lp.Component:
    """Parts one after the other."""
    return lp.compose(part=list(parts), connections=lambda m: lp.chain(*m.part))


def masses(count: int, c: float, d: float = 0.0) -> lp.Component:
    """Equal masses on equal shafts under a torque that steps."""
    shafts = [SpringDamper(c=c, d=d) if d else Spring(c=c) for _ in range(count - 1)]
    pairs = zip([Inertia(J=1.0) for _ in range(count)], [*shafts, None], strict=True)
    return in_a_row(Torque(tau=STEPPED), *(part for pair in pairs for part in pair if part))


class Drive(NamedTuple):
    """A drive, the end of its run, and the inertia that changes."""

    model: lp.Component
    until: float
    name: str


def drives() -> dict[str, Drive]:
    """Ten drives."""
    shaft, heavy, light = SpringDamper(c=1e4, d=5.0), Inertia(J=2.0), Inertia(J=0.5)
    motor = InductionMotor(J=0.5, w_s=157.0, tau_k=100.0, s_k=0.1)
    return {
        "two masses, damped": Drive(Two(), 1.0, "b.J"),
        "two masses, undamped": Drive(masses(2, 1e4), 1.0, "part[1].J"),
        "three masses, sine and steps": Drive(THREE.model(), 2.0, "body[1].J"),
        "ten masses, damped": Drive(masses(10, 1e4, 2.0), 1.0, "part[3].J"),
        "ten masses, undamped": Drive(masses(10, 1e4), 1.0, "part[3].J"),
        "fifty masses": Drive(masses(50, 1e4, 1.0), 1.0, "part[3].J"),
        "three masses, stiff": Drive(masses(3, 1e6, 300.0), 1.0, "part[3].J"),
        "motor's law": Drive(in_a_row(motor, shaft, heavy), 1.0, "part[2].J"),
        "gear": Drive(
            in_a_row(Torque(tau=STEPPED), light, IdealGear(ratio=3.0), shaft, heavy),
            1.0,
            "part[4].J",
        ),
        "three clutches": Drive(Coupled(), 1.5, "body[1].J"),
    }


def changing_rows(name: str, drive: Drive) -> Iterator[tuple[str, ...]]:
    """The call without options and the quickest method on a drive of which an inertia changes."""
    system, _ = build(drive.model)
    inertia, count = system.parameters[drive.name], itertools.count()
    options = {"until": drive.until, "parameters": {drive.name: inertia}}
    reference = lp.simulate(system, **options, rtol=1e-11, method="steps")
    wanted = [each for each in system.state_names if np.ptp(reference[each]) > 0]

    def error(run: lp.Trajectory) -> float:
        return max(np.abs(run[n] - reference[n]).max() / np.ptp(reference[n]) for n in wanted)

    def way(**own):
        def sweep() -> None:
            for _ in range(CALLS):
                value = inertia * (1 + 1e-6 * next(count))
                lp.simulate(system, until=drive.until, parameters={drive.name: value}, **own)

        return sweep

    plain = lp.simulate(system, **options)
    ways = {plain.statistics.method: (1e-6, error(plain), way())}
    for method in ("explicit", "implicit", "exact"):
        for rtol in TOLERANCES:
            own = {"method": method, "rtol": rtol}
            try:
                found = error(lp.simulate(system, **options, **own))
            except OptionError:  # there is no closed form
                break
            if found <= max(1e-6, error(plain)):
                ways[f"method={method!r}"] = rtol, found, way(**own)
                break
    times = in_turn(*(sweep for *_, sweep in ways.values()), rounds=TURNS, clock=time.process_time)
    rows = [
        (way, f"{rtol:g}", f"{found:.1e}", timed.seconds / CALLS)
        for (way, (rtol, found, _)), timed in zip(ways.items(), times, strict=True)
    ]
    (taken, _, own, seconds), quickest = rows[0], min(rows[1:], key=lambda row: row[3])
    cells = quickest[0], *quickest[1:3], f"{quickest[3] * 1e3:.3f}"
    yield name, taken, own, f"{seconds * 1e3:.3f}", *cells, f"{seconds / quickest[3]:.2f}"


def main() -> None:
    """Print the tables and write them to the results."""
    head = ("problem", "way", "set-up, s", "rtol", "error", "ms", "over the fastest", "over SciPy")
    rows = [row for name in PROBLEMS for row in rows_of(name)]
    publish("default_call", head, rows)
    head = ("drive, one inertia changing", "no options", "error", "ms")
    head = (*head, "quickest", "rtol", "error", "ms", "ratio")
    rows = [row for name, drive in drives().items() for row in changing_rows(name, drive)]
    publish("default_call_changing", head, rows)


if __name__ == "__main__":
    main()
