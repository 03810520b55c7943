"""What happens at the edges? Each run is within its tolerance, or ends in an error with a name.

Drives whose course is known in closed form (or by a quadrature over the angle) are taken to
extremes. Errors are relative to the range of the signal. Where errors add up over a run, the limit
is the tolerance times the number of steps, at least a hundred; for the closed form it is the
tolerance itself.

* A stiff shaft that vibrates holds every method by steps to its period: 200 000 steps are not
  enough from a ratio of 1e8 or 1e10 on, and the run says so. If it only stands in the way, the
  implicit method passes over it with 70 steps. The closed form needs none of this; its rounding,
  2e-16 times the highest frequency times the time, is the error that is left.
* Errors by steps add up: after 1e5 periods an error of 1e-6 in each step is some percent. The
  limit grows with the steps for this reason; the closed form stays at rounding.
* A linkage has no closed form; `exact` names what is not linear.
* 1e-9 rad beside a dead centre is as small as the absolute tolerance, and the fall multiplies the
  error of the start by 1e9. At the default tolerances this is OUTSIDE, and the only row that is
  wrong without an error; `certify=True` shows it (estimate 5e-4, true 6e-4), a smaller `atol`
  cures it.
* Explicit steps at the limit of stability are less accurate than their tolerance, 40 times for the
  slow mode beside a shaft of ratio 100; the limit is a hundred times.

    python -m benchmarks.extreme
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad

import lumped as lp
from benchmarks.harness import publish, time_action
from lumped.components import CrankSlider, EllipticalGear, Inertia, Spring
from lumped.components.translation import Force
from lumped.errors import LumpedError

TURN = 2 * np.pi
METHODS = ("explicit", "implicit", "exact", "auto")
HEAD = ("case", "value", "method", "rtol", "error", "limit", "ms", "steps", "energy", "outcome")


@dataclass(frozen=True)
class Case:
    """A run whose course is known."""

    name: str
    value: float
    system: lp.System
    until: float
    start: dict
    error: Callable[[lp.Trajectory], float]
    energy: Callable[[lp.Trajectory], np.ndarray]
    rtol: float = 1e-6
    atol: float | None = None
    most: int = 200_000


def join_row(keep=(), **parts) -> lp.System:
    """Parts in a row."""
    return lp.assemble(lp.compose(**parts, connections=lp.chain(*parts.values())), keep=keep)


def apart(received: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the range."""
    return float(np.abs(received - expected).max() / np.ptp(expected))


def stiffness(ratio: float) -> Iterator[Case]:
    """Three bodies with a soft and a stiff shaft; the slow mode alone, and both."""
    J = np.array([1.0, 2.0, 3.0])
    system = join_row(
        a=Inertia(J=J[0]),
        soft=Spring(c=1.0),
        b=Inertia(J=J[1]),
        stiff=Spring(c=ratio),
        c=Inertia(J=J[2]),
    )
    one, two = 1 / J[0] + 1 / J[1], ratio * (1 / J[1] + 1 / J[2])
    high = (one + two + np.sqrt((one - two) ** 2 + 4 * ratio / J[1] ** 2)) / 2
    squares = np.array([ratio * J.sum() / J.prod() / high, high])
    b = 1 / J[0] - squares
    shapes = np.column_stack([np.full(2, 1 / J[0]), b, -(1 + J[1] * b) / J[2]])
    w = np.sqrt(squares)
    until = 3 * TURN / w[0]

    def energy(run):
        kinetic = sum(j * run[f"{n}.w"] ** 2 for j, n in zip(J, "abc", strict=True))
        return kinetic + run["soft.phi_rel"] ** 2 + ratio * run["stiff.phi_rel"] ** 2

    for name, parts in (("stiff shaft, slow mode", [1.0, 0.0]), ("stiff shaft, both modes", None)):
        if parts is None:
            parts = 1 / np.abs(shapes).max(axis=1)
        start = dict(zip(("a.w", "b.w", "c.w"), np.array(parts) @ shapes, strict=True))

        def error(run, parts=parts):
            waves = np.cos(np.outer(run.t, w)) * parts
            return max(apart(run[f"{n}.w"], waves @ shapes[:, i]) for i, n in enumerate("abc"))

        yield Case(name, ratio, system, until, start, error, energy)


def two_masses(J_a: float, c: float, J_b: float, periods: float, name: str, value: float, **more):
    """Two bodies on a shaft, the first with speed 1."""
    w = np.sqrt(c / J_a + c / J_b)

    def error(run):
        return apart(run["shaft.phi_rel"], -np.sin(w * run.t) / w)

    def energy(run):
        speeds = J_a * run["a.w"] ** 2 + J_b * run["b.w"] ** 2
        return speeds + c * run["shaft.phi_rel"] ** 2

    system = join_row(a=Inertia(J=J_a), shaft=Spring(c=c), b=Inertia(J=J_b))
    return Case(name, value, system, periods * TURN / w, {"a.w": 1.0}, error, energy, **more)


def turning(name: str, value: float, system, inertia, speeds, begin: float) -> Case:
    """Ten turns of a body whose inertia depends on its angle, by its energy."""
    whole = inertia(begin) / 2
    points = {"limit": 2000, "epsabs": 0, "epsrel": 1e-11}
    half = quad(lambda phi: np.sqrt(inertia(phi) / 2 / whole), 0, np.pi, **points)[0]
    start = {"a.phi": begin, "a.w": 1.0}

    def error(run):
        return abs(run["a.phi"][-1] - begin - 10 * TURN) / (10 * TURN)

    return Case(name, value, system, 20 * half, start, error, speeds)


def gears(e: float) -> Case:
    """Elliptical gears between two bodies."""

    def ratio(phi):
        return (1 - e**2) / ((1 - e) ** 2 + 4 * e * np.sin(phi / 2) ** 2)

    system = join_row(a=Inertia(J=2.0), gear=EllipticalGear(e=e), b=Inertia(J=1.0), keep=["a.phi"])
    return turning(
        *("elliptical gears, e", e, system, lambda phi: 2 + ratio(phi) ** 2),
        lambda run: 2 * run["a.w"] ** 2 + run["b.w"] ** 2,
        np.pi,
    )


def slope(phi: float, rod: float) -> float:
    """Travel of the piston for each radian of a crank of radius 1."""
    return -np.sin(phi) * (1 + np.cos(phi) / np.sqrt(rod**2 - np.sin(phi) ** 2))


def crank(ratio: float) -> Case:
    """A crank almost as long as its rod turns a heavy piston."""
    system = join_row(
        a=Inertia(J=1.0), slider=CrankSlider(r=1.0, L=1 / ratio, m=3.0), keep=["a.phi"]
    )
    return turning(
        *("crank over rod", ratio, system, lambda phi: 1 + 3 * slope(phi, 1 / ratio) ** 2),
        lambda run: run["a.w"] ** 2 + 3 * run["slider.v"] ** 2,
        0.0,
    )


def dead_centre(begin: float, atol: float | None = None) -> Case:
    """A piston pressed beside its dead centre falls until the crank stands at 2 rad."""
    rod, f = 3.0, 10.0
    system = lp.assemble(
        lp.compose(
            a=Inertia(J=1.0),
            slider=CrankSlider(r=1.0, L=rod, m=3.0),
            force=Force(f=-f),
            connections=lambda m: [
                lp.connect(m.a.flange_b, m.slider.flange),
                lp.connect(m.slider.slider, m.force.flange),
            ],
        ),
        keep=["a.phi"],
    )

    def fall(phi):
        """Way of the piston from the begin, without cancellation."""
        high, low = np.sqrt(rod**2 - np.sin(begin) ** 2), np.sqrt(rod**2 - np.sin(phi) ** 2)
        drop = 2 * np.sin((phi + begin) / 2) * np.sin((phi - begin) / 2)
        squares = np.sin(phi + begin) * np.sin(phi - begin)
        return drop + squares / (high + low)

    def pace(u):
        phi = begin * np.cosh(u)
        inertia = 1 + 3 * slope(phi, rod) ** 2
        return np.sqrt(inertia / (2 * f * fall(phi))) * begin * np.sinh(u) if u > 0 else rest

    tiny = 1e-6
    rest = 0.0
    rest = pace(tiny)
    until = quad(pace, 0, np.arccosh(2.0 / begin), limit=2000, epsabs=0, epsrel=1e-11)[0]

    def error(run):
        return abs(run["a.phi"][-1] - 2.0) / 2.0

    def energy(run):
        kinetic = (run["a.w"] ** 2 + 3 * run["slider.v"] ** 2) / 2
        return 4 * f + kinetic + f * run["slider.s"]

    name = "beside the dead centre, rad" + ("" if atol is None else f", atol {atol:g}")
    return Case(name, begin, system, until, {"a.phi": begin}, error, energy, atol=atol)


def cases() -> Iterator[Case]:
    """All of them."""
    for exponent in range(0, 15, 2):
        yield from stiffness(10.0**exponent)
    for exponent in range(-8, 9, 4):
        ratio = 10.0**exponent
        yield two_masses(1.0, 1.0, ratio, 20, "inertia ratio", ratio)
    for rtol in (1e-6, 1e-9):
        yield two_masses(
            2.0, 300.0, 1.0, 1e5, "periods without damping", 1e5, rtol=rtol, most=1_000_000
        )
    for digits in range(3, 13):
        rtol = 10.0**-digits
        yield two_masses(2.0, 300.0, 1.0, 10, "tolerance", rtol, rtol=rtol)
    for e in (0.5, 0.9, 0.99):
        yield gears(e)
    for ratio in (0.5, 0.9, 0.99):
        yield crank(ratio)
    for begin in (1e-1, 1e-3, 1e-6, 1e-9):
        yield dead_centre(begin)
    yield dead_centre(1e-9, 1e-17)


def measure_case(case: Case, method: str) -> tuple:
    """Row of the table."""

    def action():
        return lp.simulate(
            case.system,
            until=case.until,
            start=case.start,
            grid=997,  # no whole number of periods
            rtol=case.rtol,
            atol=case.atol,
            method=method,
            max_steps=case.most,
        )

    first = (case.name, f"{case.value:g}", method, f"{case.rtol:g}")
    try:
        spent, _, run = time_action(action, 2)
        error, energy = case.error(run), case.energy(run)
    except LumpedError as fault:
        text = f"{type(fault).__name__}: {str(fault).splitlines()[0]}"
        return (*first, "", "", "", "", "", text)
    limit = case.rtol * (1 if run.statistics.method == "exact" else max(run.steps, 100))
    drift = np.abs(energy / energy[0] - 1).max()
    outcome = "within" if error <= limit else "OUTSIDE"
    if not np.isfinite(error + drift):
        outcome = "NOT FINITE"
    if method == "auto":
        outcome += f" ({run.statistics.method})"
    figures = (f"{error:.1e}", f"{limit:.0e}", f"{1e3 * spent:.3g}", run.steps, f"{drift:.1e}")
    return (*first, *figures, outcome)


def main() -> None:
    """Print the table and write it to the results."""
    publish("extreme", HEAD, [measure_case(case, method) for case in cases() for method in METHODS])


if __name__ == "__main__":
    main()
