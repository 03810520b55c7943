"""The motion between stations that costs the drive least."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped import ops
from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.functionals import Functional
from lumped.language.expression import Expr
from lumped.numerics.collocation import DEGREE, POINTS, fractions, lagrange, phase
from lumped.numerics.nlp import Programme, Solution
from lumped.optimisation.design import Bounds, bounds_of, solution_lines
from lumped.optimisation.discretisation import Discretisation
from lumped.optimisation.terms import TermMaker, number_of
from lumped.support.arguments import checked
from lumped.support.text_table import amounts, table
from lumped.support.units import read_time
from lumped.timeloop.results.operating_point import Named, OperatingPoint

Limits = Mapping[str, Bounds]


@dataclass(frozen=True, eq=False)
class Motion(Named):
    """A motion that is best, at the nodes of its collocation; ``found["load.w"]`` gives a course.

    Attributes
    ----------
    system : System
        What moves.
    t : ndarray, shape (n,)
        Instants, s; at a station between two phases the same instant stands twice.
    x, theta, settings : ndarray, shapes (n, states), (n, parameters), (n, m)
        States, parameters with the drive among them, modes.
    stations : tuple of float
        Instants of the stations, s.
    minimise : Functional
        What was made small.
    objective : float
        Its least value.
    limits : tuple of str
        Limits that are reached somewhere.
    solution : Solution
        Status, iterations, evaluations, residual, violation, condition, seconds.
    """

    system: System
    t: np.ndarray
    x: np.ndarray
    theta: np.ndarray
    settings: np.ndarray
    stations: tuple[float, ...]
    minimise: Functional
    objective: float
    limits: tuple[str, ...]
    solution: Solution

    @checked
    def __getitem__(self, name: Name | list[Name]) -> np.ndarray:
        if isinstance(name, list):
            return np.column_stack([self[one] for one in name])
        if self.system.key(name) == "time":
            return self.t
        inputs = (self.x.T, self.theta.T, self.t[None, :], self.settings.T)
        return np.asarray(self.system.function([name])(*inputs)).ravel()

    @checked
    def profile(self, name: Name) -> Expr:
        """A continuous quantity, such as a position or speed, as an expression of `lumped.time`.

        Straight lines between the nodes, so that limits hold everywhere; the way of a speed given
        in this way errs with the square of the interval. Given to `inverse`, its acceleration is
        constant from node to node, so a rigid drive can follow it.
        """
        keep = np.append(np.diff(self.t) > 0, True)
        return ops.table(self.t[keep].tolist(), self[name][keep].tolist())

    def __repr__(self) -> str:
        cost, unit = str(self.minimise), self.minimise.unit(self.system)
        rows = [(cost, *amounts(cost, unit, self.objective, digits=9))]
        for i, t in enumerate(self.stations, start=1):
            rows.append((f"station {i}", *amounts("time", "s", t, digits=7)))
        lines = [
            *solution_lines(self.system, self.solution),
            table(("", "value", "unit"), rows),
            "limits reached: " + (", ".join(self.limits) or "none"),
        ]
        return "\n".join(lines)


@checked
def motion(
    points: OperatingPoint | Sequence[OperatingPoint],
    *,
    drive: Name,
    stations: Mapping[str, Sequence[float]],
    duration: float,
    minimise: Functional,
    limits: Limits | Sequence[Limits] | None = None,
    intervals: int = 50,
) -> Motion:
    """The motion from rest to rest over stations for which a functional is least.

    The drive is free at every instant; states follow the equations of the model by Radau
    collocation, so springs, gravity and mechanisms count. With several phases the times at which
    the stations between are passed are found too.

    Parameters
    ----------
    points : OperatingPoint, or sequence of them
        From `start_point`: parameters and modes (what sticks, slides, is engaged) of each phase,
        which hold throughout. All of one system, smooth but for these modes.
    drive : name
        Input, given to its instance as a number, that brings the motion about.
    stations : mapping of one name to sequence of float
        A position and its values at the start, at the change from each phase to the next, and at
        the end.
    duration : float
        From start to end, s.
    minimise : Functional
        Such as ``rms("motor.tau")`` or ``peak("motor.tau")``.
    limits : mapping of name to (low, high), or one for each phase, optional
        Limits of quantities at all instants: speeds, accelerations, the drive.
    intervals : int
        Intervals of each phase.

    Returns
    -------
    Motion

    Raises
    ------
    OptionError
        If stations, phases and limits do not fit together.
    UnknownNameError
        If a name does not exist, or the position was left out of the system.
    OptimisationError
        If no motion meets all limits, with the limit that is violated most.

    Notes
    -----
    At start and end the drive stands still and would do so for ever with some constant drive, so
    springs are not wound up and nothing swings on. A rigid inertia with free drive takes the
    parabola of speed, ``6 h t (T - t) / T^3``.
    """
    duration = read_time(duration, "duration")
    return _MotionSearch(
        points, drive, stations, duration, minimise, limits or {}, intervals
    ).solve_motion()


class _MotionSearch:
    def __init__(
        self,
        points: OperatingPoint | Sequence[OperatingPoint],
        drive: Name,
        stations: Mapping[str, Sequence[float]],
        duration: float,
        minimise: Functional,
        limits: Limits | Sequence[Limits],
        intervals: int,
    ) -> None:
        self.points = [points] if isinstance(points, OperatingPoint) else list(points)
        if not self.points:
            raise OptionError("motion: points = []: an operating point for each phase is needed.")
        if intervals < 1:
            raise OptionError(f"motion: intervals = {intervals}: at least one is needed.")
        self.system = system = self.points[0].system
        given = [limits] * len(self.points) if isinstance(limits, Mapping) else list(limits)
        if len(stations) != 1:
            raise OptionError(f"motion: stations = {stations!r}; give one position.")
        (self.position, values), *_ = stations.items()
        if not (
            len(values) == len(self.points) + 1
            and len(given) == len(self.points)
            and np.isfinite(values).all()
            and all(p.system is system for p in self.points)
        ):
            raise OptionError(
                f"motion: {len(values)} stations of {self.position}, {len(self.points)} phases and "
                f"{len(given)} sets of limits; each phase has an operating point of the same "
                "system, a station at its start and one at its end."
            )
        if not (np.isfinite(duration) and duration > 0):
            raise OptionError(f"motion: duration = {duration!r} s must be positive and finite.")
        key = system.key(drive)
        if key not in system.structure.tree.input_parameters:
            raise OptionError(
                f"motion: {key} is no input that is given to its instance as a number, as in "
                "Torque(tau=0)."
            )
        self.drive, (self.place,) = key, system.places([key])
        self.minimise, self.duration, self.intervals = minimise, duration, intervals
        self.values, self.limits = [float(v) for v in values], given
        self.programme = Programme(system.name)
        self._build()

    def _build(self) -> None:
        system, programme, count = self.system, self.programme, len(self.points)
        nodes = fractions(self.intervals)
        speed = (self.values[-1] - self.values[0]) / self.duration
        sizes = self._sizes(abs(speed))
        way = np.abs(np.diff(self.values))
        shares = way / way.sum() if way.sum() else np.full(count, 1 / count)
        spans = self.duration * np.maximum(shares, 0.02)
        if count > 1:
            durations = ca.vec(programme.unknown(spans, self.duration, 1e-6 * self.duration))
            programme.constrain("duration", ca.sum1(durations) / self.duration, 1.0, 1.0)
        else:
            durations = ca.SX(self.duration)
        bounds = [bounds_of(self.drive, p[self.drive]) for p in self.limits if self.drive in p]
        drives = max([abs(b) for b in np.ravel(bounds) if np.isfinite(b)] + [self._load()])
        now = programme.unknown(self._guess(self.points[0], self.values[0], speed) / sizes)
        now = now * ca.DM(sizes)
        begin, phases, settings = ca.SX(0), [], []
        for k, point in enumerate(self.points):
            line = np.interp(nodes[1:], [0, 1], self.values[k : k + 2])
            guess = np.array([self._guess(point, p, speed) for p in line]) / sizes
            inside = ca.reshape(programme.unknown(guess), len(sizes), -1)
            x = ca.horzcat(now, inside * ca.repmat(ca.DM(sizes), 1, len(line)))
            u = programme.unknown(np.full(len(line), point.theta[self.place]), drives)
            # for the value of the drive at the begin from those at the collocation points
            weights = ca.DM([lagrange(POINTS[1:], j)(0.0) for j in range(DEGREE)])
            theta = ca.repmat(ca.SX(ca.DM(point.theta)), 1, len(nodes))
            theta[self.place, :] = ca.horzcat(ca.dot(weights, u[:DEGREE]), u.T)
            own = np.repeat(point.settings[None, :], len(nodes), axis=0)
            span = (begin, durations[k])
            phases.append(phase(programme, system, x, theta, own, span, sizes))
            settings.append(own)
            now, begin = x[:, -1], begin + durations[k]
        self.course = Discretisation(
            system,
            ca.vertcat(*(p.t for p in phases)),
            ca.vertcat(*(p.weights for p in phases)),
            ca.horzcat(*(p.x for p in phases)),
            ca.horzcat(*(p.theta for p in phases)),
            np.concatenate(settings),
            self.duration,
        )
        self._at_stations(len(nodes))
        self._at_rest(sizes, drives)
        self._within(len(nodes))
        names = self.minimise.names
        sizes_of = np.full((1, len(names)), drives)
        given = names, self.course.quantities(names), sizes_of
        self.cost = TermMaker(programme, self.course, self.minimise, *given).term()
        weight = ca.SX.sym("weight")
        programme.ready(weight * self.cost.value, weight)

    def _guess(self, point: OperatingPoint, position: float, speed: float) -> np.ndarray:
        """States of a point with another position and speed."""
        system, x = self.system, point.x.copy()
        if "slopes" not in self.__dict__:
            states, y = system.inputs[0], system.expressions([self.position])
            rate = ca.jtimes(y, states, system.rates)
            parts = [ca.vertcat(y, rate), ca.jacobian(ca.vertcat(y, rate), states)]
            self.slopes = ca.Function("slopes", system.inputs, parts)
        now, by = (np.asarray(v) for v in self.slopes(x, point.theta, point.time, point.settings))
        wanted = np.array([position, speed]) - now.ravel()
        found: np.ndarray = x + np.linalg.lstsq(by, wanted, rcond=None)[0]
        return found

    def _sizes(self, speed: float) -> np.ndarray:
        """Sizes of the states in such a motion."""
        low, high = (
            np.abs(self._guess(self.points[0], value, speed))
            for value in (min(self.values), max(self.values))
        )
        sizes: np.ndarray = np.maximum(low, high)
        sizes[sizes == 0] = 1.0
        return sizes

    def _load(self) -> float:
        """Size of the drive: what accelerates to the middle speed in a quarter of the time."""
        system = self.system
        x, theta, _, _ = system.inputs
        rate = ca.jtimes(system.expressions([self.position]), x, system.rates)
        swift = ca.jtimes(rate, x, system.rates)
        parts = [swift, ca.jacobian(swift, theta[self.place])]
        function = ca.Function("load", system.inputs, parts)
        way, most = abs(self.values[-1] - self.values[0]), 0.0
        for point in self.points:
            now, by = (float(v) for v in function(*point.inputs))
            if by:
                most = max(most, (abs(now) + 4 * way / self.duration**2) / abs(by))
        return most or 1.0

    def _at_stations(self, nodes: int) -> None:
        """The position at the stations."""
        position = self.course.quantities([self.position])
        size = max(abs(v) for v in self.values) or 1.0
        unit = self.system.quantity(self.position).unit
        ends = [0, *(nodes * (k + 1) - 1 for k in range(len(self.points)))]
        for number_, (node, value) in enumerate(zip(ends, self.values, strict=True)):
            self.programme.constrain(
                f"{self.position} at station {number_ + 1}",
                position[node],
                value,
                value,
                scale=size,
                unit=unit,
            )

    def _at_rest(self, sizes: np.ndarray, load: float) -> None:
        """Start and end are equilibria of some constant drive; the drive may jump from it."""
        course, count = self.course, self.course.settings.shape[0]
        for end, node in (("start", 0), ("end", count - 1)):
            theta = ca.SX(course.theta[:, node])
            theta[self.place] = self.programme.unknown(0.0, load)
            rates = self.system.rhs(
                course.x[:, node], theta, course.t[node], ca.DM(course.settings[node])
            )
            scaled = rates * self.duration / ca.DM(sizes)
            self.programme.constrain(f"standstill at the {end}", scaled, 0.0, 0.0)

    def _within(self, nodes: int) -> None:
        """Limits at all nodes of their phases."""
        names = list(dict.fromkeys(name for limits in self.limits for name in limits))
        if not names:
            return
        y = self.course.quantities(names)
        for k, limits in enumerate(self.limits):
            for name, given in limits.items():
                low, high = bounds_of(name, given)
                size = max([abs(b) for b in (low, high) if np.isfinite(b)], default=1.0) or 1.0
                own = y[names.index(name), k * nodes : (k + 1) * nodes]
                self.programme.constrain(
                    name if len(self.limits) == 1 else f"{name} in phase {k + 1}",
                    own.T,
                    low,
                    high,
                    scale=size,
                    unit=self.system.quantity(name).unit,
                    given=True,
                )

    def solve_motion(self) -> Motion:
        """Solve, and read the motion."""
        solution = self.programme.solve([1.0 / self.cost.scale])
        c = self.course
        outputs = ca.Function("found", [self.programme.w], [c.t, c.weights, c.x, c.theta])
        t, dt, x, theta = (np.asarray(v) for v in outputs(solution.w))
        nodes = len(fractions(self.intervals))
        stations = t.ravel()[[0, *(nodes * (k + 1) - 1 for k in range(len(self.points)))]]
        result = Motion(
            self.system,
            t.ravel(),
            x.T,
            theta.T,
            c.settings,
            tuple(stations.tolist()),
            self.minimise,
            0.0,
            self.programme.list_active(solution),
            solution,
        )
        names = self.minimise.names
        value = number_of(self.minimise, names, result[list(names)], dt.ravel())
        object.__setattr__(result, "objective", value)
        return result
