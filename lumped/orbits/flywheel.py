"""Flywheels: the inertia that keeps the cyclic irregularity of a speed at a wanted value."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError, SolverError
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.periodic import find_orbit
from lumped.orbits.shooting import Guess
from lumped.orbits.smooth_curves import values_along
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.operating_point import OperatingPoint

_MOST = 12
"""Times that the inertia is doubled."""


@dataclass(frozen=True, eq=False)
class Flywheel(RichHtml):
    """A flywheel and the motion with it.

    Attributes
    ----------
    inertia : str
        Parameter that was changed.
    before, after : float
        Its values, kg.m2.
    classical : float
        Inertia to add after Wittenbauer, for torques that depend on the angle alone, kg.m2.
    irregularity : float
        The one reached.
    orbit : PeriodicOrbit
        The motion with the flywheel.
    orbits : int
        Periodic motions calculated.
    evaluations : int
        Evaluations of the right-hand side in them.
    """

    inertia: str
    before: float
    after: float
    classical: float
    irregularity: float
    orbit: PeriodicOrbit
    orbits: int
    evaluations: int

    @property
    def added(self) -> float:
        """Inertia to add, kg.m2."""
        return self.after - self.before

    def __repr__(self) -> str:
        rows = [
            ("inertia to add", *amounts(self.inertia, "kg.m2", self.added)),
            ("the same by Wittenbauer", *amounts(self.inertia, "kg.m2", self.classical)),
            ("irregularity", number(self.irregularity), "1"),
        ]
        head = f"{self.inertia}: {self.orbits} orbits, {self.evaluations} evaluations"
        if not self.orbit.stable:
            head += f"; unstable orbit: largest multiplier {self.orbit.largest:.6g}"
        return head + "\n" + table(("flywheel", "value", "unit"), rows)


@checked
def flywheel(orbit: PeriodicOrbit, *, inertia: Name, of: Name, irregularity: float) -> Flywheel:
    """Find the inertia at a shaft with which its speed has a wanted cyclic irregularity.

    The exact inertia is found by Brent's method on periodic motions, on the reciprocal of the
    irregularity, which is nearly linear in the inertia. The classical one takes the excess work
    over the turn from the present motion and assumes that it stays: with the reduced inertia J and
    the kinetic energy ``E = J w^2 / 2`` at each angle, ``w = sqrt(2 (E + E_0) / (J + J_added))``
    (Wittenbauer, Graphische Dynamik, 1923; for constant J, ``J_added + J = W / (irregularity
    w^2)``). It holds where the shaft is rigidly joined to all that turns.

    Parameters
    ----------
    orbit : PeriodicOrbit
        The motion without the flywheel.
    inertia : name
        Parameter, kg.m2, such as the inertia of the motor.
    of : name
        Speed of the same shaft, to be kept steady.
    irregularity : float
        Wanted (greatest - least) / mean of it.

    Returns
    -------
    Flywheel

    Raises
    ------
    OptionError
        If the irregularity is not positive, or that of the orbit is not larger, or the parameter
        has no effect on the acceleration of the shaft.
    SolverError
        If no inertia is found.
    """
    if not 0 < irregularity < np.inf:
        raise OptionError(f"flywheel: irregularity = {irregularity!r}: a positive number.")
    system, theta = orbit.system, orbit.run.theta
    (place,) = system.places([inertia])
    key, now = system.key(inertia), orbit.fluctuation(of)
    if now <= irregularity:
        raise OptionError(
            f"flywheel: the irregularity of {system.key(of)} is {now:.4g} already, not above "
            f"{irregularity:.4g}; no inertia needs to be added."
        )
    classical = _wittenbauer(orbit, place, of, irregularity)
    before, search = float(theta[place]), _IrregularitySearch(orbit, place, of, irregularity)
    low, high = before, before + classical
    for _ in range(_MOST):
        if search(high) >= 0:
            break
        low, high = high, before + 2 * (high - before)
    else:
        raise SolverError(
            f"flywheel: with {key} = {low:.6g} kg.m2 the irregularity of {system.key(of)} is "
            f"still {search.orbits[low].fluctuation(of):.6g}; no inertia brings it to "
            f"{irregularity:.6g}. Something else than inertia governs the speed of this shaft.",
            search.orbits[low].run,
        )
    value = float(scipy.optimize.brentq(search, low, high, xtol=1e-12 * high, rtol=1e-10))
    search(value)
    found, count = search.orbits[value], len(search.orbits) - 1
    evaluations = sum(made.evaluations for made in search.orbits.values()) - orbit.evaluations
    reached = found.fluctuation(of)
    return Flywheel(key, before, value, classical, reached, found, count, evaluations)


class _IrregularitySearch:
    """Reciprocal of the irregularity over that wanted, less one, for values of the parameter.

    Attributes
    ----------
    orbits : dict of float to PeriodicOrbit
        For each value so far; a new one is searched for from the last.
    """

    def __init__(self, orbit: PeriodicOrbit, place: int, of: Name, wanted: float) -> None:
        self.place, self.of, self.wanted = place, of, wanted
        self.orbits, self._last = {float(orbit.run.theta[place]): orbit}, orbit

    def __call__(self, value: float) -> float:
        if value not in self.orbits:
            old = self._last.found.guess
            theta = old.point.theta.copy()
            theta[self.place] = value
            point = OperatingPoint(self._last.system, 0.0, old.point.x, theta, old.point.settings)
            grid = max(sum(len(piece.t) for piece in self._last.run.pieces), 100)
            guess = Guess(point, old.period, old.phase)
            self._last = find_orbit(self._last.problem, guess, grid)
            self.orbits[value] = self._last
        return self.wanted / self.orbits[value].fluctuation(self.of) - 1


def _wittenbauer(orbit: PeriodicOrbit, place: int, of: Name, irregularity: float) -> float:
    """Inertia to add if torques depend on the angle alone."""
    system, run = orbit.system, orbit.run
    x, p, t, _ = system.inputs
    w = system.expressions([of])
    a = ca.jtimes(w, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    both = ca.densify(ca.vertcat(w, a, ca.jacobian(a, p[place])))
    function = ca.Function("inertia", system.inputs, [both])
    w, a, by = np.hstack(values_along(function, run))
    clear = np.abs(a) > 1e-3 * np.abs(a).max()
    if not np.abs(by[clear]).max(initial=0.0) or not (-a[clear] / by[clear] > 0).all():
        raise OptionError(
            f"flywheel: the acceleration of {system.key(of)} does not depend on that parameter "
            "as on an inertia of its shaft. Name an inertia that is rigidly joined to it."
        )
    # the acceleration is torque / J
    J = np.interp(run.t, run.t[clear], -a[clear] / by[clear])
    E, w = 0.5 * J * w**2, np.abs(w)
    way = np.gradient(np.concatenate([[0], np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(run.t))]))
    mean = way.sum() / (way / w).sum()

    def speeds(added: float) -> np.ndarray:
        def off(extra: float) -> float:
            found = np.sqrt(2 * (E + extra) / (J + added))
            return float(way.sum() / (way / found).sum() - mean)

        low = -E.min() * (1 - 1e-9)
        high = E.max() + (J.max() + added) * mean**2
        found: np.ndarray = np.sqrt(
            2 * (E + scipy.optimize.brentq(off, low, high, rtol=1e-14)) / (J + added)
        )
        return found

    def measure_excess(added: float) -> float:
        found = speeds(added)
        return float(np.ptp(found) / mean / irregularity - 1)

    most = J.max()
    while measure_excess(most) > 0:
        most *= 4
    return float(scipy.optimize.brentq(measure_excess, 0.0, most, rtol=1e-12))
