"""A periodic motion as a result."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.orbits.orbit_sensitivity import OrbitSensitivity, orbit_sensitivity
from lumped.orbits.shooting import Orbit, OrbitProblem
from lumped.orbits.smooth_curves import Curve, Extreme, curves, extreme, find_harmonics, integral
from lumped.support.arguments import checked
from lumped.support.display_units import frequency_unit, time_unit
from lumped.support.text_table import amounts, table
from lumped.timeloop.results.operating_point import Named
from lumped.timeloop.results.trajectory import Trajectory

ON_CIRCLE = 1e-6
"""An orbit counts as unstable if a multiplier is larger than one by more than this."""


@dataclass(frozen=True, eq=False)
class PeriodicOrbit(Named):
    """A motion that repeats after a period; ``orbit[name]`` gives any quantity over `run.t`.

    Attributes
    ----------
    system : System
        What moves.
    run : Trajectory
        One period.
    period : float
        Its length, s.
    advance : dict of str to float
        States that go on turning, and by how much in a period, as given.
    drift : dict of str to float
        States without effect on the others, such as counters of energy, and what they gain in a
        period.
    multipliers : ndarray of complex, shape (k,)
        Floquet multipliers: factors by which small disturbances grow in a period, largest first.
        Of a motion of unknown period the one of a shift in time is left out.
    shift : complex or None
        That multiplier; it is 1 but for the error of the calculation.
    residual : float
        What the states miss after the period, largest, over their size.
    worst : str
        State of the largest residual.
    condition : float
        Condition number of the equations for the start states, and the period if it is unknown.
    seam : tuple of str
        States whose rates jump from the end of a period to the start of the next, because functions
        of time do not go on there as they begin.
    iterations, evaluations : int
        Newton steps; evaluations of the right-hand side, with its derivatives or without.
    free : dict of str to float
        Parameters that the motion determines, and what they came out as.
    """

    system: System
    run: Trajectory
    period: float
    advance: dict[str, float]
    drift: dict[str, float]
    multipliers: np.ndarray
    shift: complex | None
    residual: float
    worst: str
    condition: float
    seam: tuple[str, ...]
    iterations: int
    evaluations: int
    problem: OrbitProblem = field(repr=False)
    found: Orbit = field(repr=False)
    free: dict[str, float] = field(default_factory=dict)
    _courses: dict[str, list[Curve]] = field(default_factory=dict, init=False, repr=False)

    @checked
    def __getitem__(self, name: Name | list[Name]) -> np.ndarray:
        return self.run[name]

    @property
    def frequency(self) -> float:
        """Periods in a second, Hz."""
        return 1.0 / self.period

    @cached_property
    def largest(self) -> float:
        """Magnitude of the largest multiplier; zero if there is none."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """Whether small disturbances do not grow."""
        return self.largest <= 1 + ON_CIRCLE

    @checked
    def greatest(self, name: Name) -> Extreme:
        """The greatest value of a quantity and its time, also between the output times."""
        return extreme(self._course(name), 1)

    @checked
    def least(self, name: Name) -> Extreme:
        """The least value of a quantity and its time, also between the output times."""
        return extreme(self._course(name), -1)

    @checked
    def mean(self, name: Name) -> float:
        """Mean over the period."""
        return integral(self._course(name)).real / self.period

    @checked
    def fluctuation(self, name: Name) -> float:
        """Cyclic irregularity, (greatest - least) / mean.

        Raises
        ------
        OptionError
            If the mean is zero.
        """
        span, mean = self.greatest(name).value - self.least(name).value, self.mean(name)
        if abs(mean) <= 1e-9 * span:
            raise OptionError(
                f"fluctuation: the mean of {self.system.key(name)} is zero; its irregularity "
                "refers to a mean, as that of a shaft that turns."
            )
        return span / abs(mean)

    @checked
    def harmonics(self, name: Name, count: int) -> np.ndarray:
        """Complex Fourier coefficients ``c_0`` to ``c_count``, shape (count + 1,).

        The quantity is ``c_0 + Re(sum c_k exp(2 pi j k t / period))``: the magnitudes are
        amplitudes.
        """
        return find_harmonics(self._course(name), self.period, count)

    @checked
    def work(self, of: tuple[Name, Name]) -> float:
        """Work in a period, J, of a force and a speed, or a torque and an angular speed."""
        both = self.system.expressions([*of])
        return integral(curves(self.run, both[0] * both[1])).real

    @checked
    def sensitivity(self, *, of: Iterable[Name], by: Iterable[Name]) -> OrbitSensitivity:
        """Derivatives of the period and of quantities, their means and greatest values.

        Parameters
        ----------
        of : iterable of names
            Quantities along the orbit.
        by : iterable of names
            Parameters. A prescribed period stays as it is, unless it is one of them; a free
            parameter follows, so that the period stays.

        Returns
        -------
        OrbitSensitivity

        Raises
        ------
        OptionError
            If the motion determines one of the parameters.
        """
        names, keys = tuple(of), tuple(self.system.key(name) for name in by)
        for name in keys:
            if name in self.free:
                raise OptionError(
                    f"{self.system.name}: {name} is free, and this motion determines it; nothing "
                    "has a derivative by it. Leave it out of `by`."
                )
        tops = [self.greatest(name) for name in names]
        free = tuple(self.free)
        return orbit_sensitivity(self.problem, self.found, self.run, names, keys, tops, free)

    def _course(self, name: Name) -> list[Curve]:
        key = self.system.key(name)
        if key not in self._courses:
            self._courses[key] = curves(self.run, self.system.expressions([key]))
        return self._courses[key]

    def __repr__(self) -> str:
        time, frequency = time_unit(), frequency_unit()
        lines = [
            f"{self.system.name}: period {time.value(self.period):.9g} {time.unit} "
            f"({frequency.value(self.frequency):.6g} {frequency.unit}); "
            f"{self.iterations} iterations, {self.evaluations} evaluations, residual "
            f"{self.residual:.2g} ({self.worst}), condition {self.condition:.2g}",
            f"largest multiplier {self.largest:.6g}"
            if self.stable
            else f"unstable orbit: largest multiplier {self.largest:.6g}",
        ]
        if self.shift is not None:
            lines[1] += f"; that of a shift in time is 1 to {abs(self.shift - 1):.1g}"
        if self.free:
            held = ", ".join(f"{name} = {value:.9g}" for name, value in self.free.items())
            lines.append(f"for this period: {held}")
        for what, states in (("turning", self.advance), ("drifting", self.drift)):
            if states:
                by = ", ".join(f"{name} by {value:.6g}" for name, value in states.items())
                lines.append(f"{what} in a period: {by}")
        if self.seam:
            lines.append(
                "where a period follows the other, functions of time do not go on as they begin: "
                f"the rates of {', '.join(self.seam)} jump"
            )
        rows = []
        for name in self.system.state_names[:12]:
            if "(" not in name and name not in self.advance and name not in self.drift:
                low, high = self.least(name).value, self.greatest(name).value
                unit = self.system.quantity(name).unit
                rows.append((name, *amounts(name, unit, low, high, self.mean(name))))
        return "\n".join(lines) + "\n" + table(("state", "min", "max", "mean", "unit"), rows)
