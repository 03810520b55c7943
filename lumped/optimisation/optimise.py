"""Parameters that make a run or modes best, under bounds, with exact derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast, get_args

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import Changes, Name, System
from lumped.errors import OptionError
from lumped.numerics.nlp import Programme, Rows, Solution
from lumped.optimisation.collocated_course import (
    Repeating,
    collocated,
    measured_well,
    of_orbit,
    repeating,
    simulated,
)
from lumped.optimisation.design import Bounds, Key, Optimum, bounds_of, varied
from lumped.optimisation.discretisation import (
    Discretisation,
    FunctionalTerm,
    along,
    dt_of,
    followed_by,
    held_instants,
    measured,
    number_of,
    smooth,
    term,
)
from lumped.optimisation.optimise_modes import best_modes
from lumped.optimisation.optimise_orders import best_orders
from lumped.optimisation.optimise_runs import best_runs
from lumped.orbits.orbit import PeriodicOrbit
from lumped.simulation.functional_kinds import unit_of, watching
from lumped.simulation.functionals import Designed, Functional, Modal, Vibrating
from lumped.support.arguments import checked
from lumped.support.units import in_seconds
from lumped.timeloop.result import Trajectory
from lumped.vibration.modes import Modes
from lumped.vibration.order_response import OrderResponse

__all__ = ["DesignProblem", "Objective", "optimise"]

_LEAST = 1e-3
"""Size of a functional, over that at the start, below which its error is relative to the start."""

Objective = Key | str | Mapping[Key | str, float]
"""What is made small: a functional, or functionals and parameters with weights."""


@checked
def optimise(
    run: Trajectory | PeriodicOrbit | Modes | OrderResponse | System,
    *,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: Objective,
    subject_to: Mapping[Key | str, Bounds] | None = None,
    intervals: int = 50,
    periodic: bool = False,
    until: float | str | None = None,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-8,
    starts: int = 1,
) -> Optimum:
    """Parameters for which a run is best, or natural frequencies are where they are wanted.

    Without states (prescribed motion, inverse dynamics) quantities are evaluated at the instants
    of the run, so give `simulate` or `inverse` a grid that is fine enough. With states the run
    becomes equations for the states at collocation points, and the optimum is simulated anew as a
    check. Solved by IPOPT with
    exact first and second derivatives; greatest values enter by a bound of their own (epigraph),
    so their kinks do no harm.

    Natural frequencies and damping ratios have exact gradients (`eigen_sensitivity`) and are placed
    by sequential quadratic programming; if the modes are those of a point from `equilibrium`, it is
    found anew for each design, with the same start values and free parameters; a point of a run is
    held.

    Vibrations of an order response, with its natural frequencies at its first speed, have exact
    gradients too (`order_sensitivity`). A limit of an `order_peak` holds at all its speeds: those
    at which a design is worst are added to the search until none exceeds it. A `separation` keeps
    critical speeds away from those of operation, each at the mean state of its speed.

    Long or stiff runs and those with events are simulated whole for each design (single shooting):
    give the system and `until` in place of a run. Gradients are those of `gradient`, and the
    search is the same as for modes. Kinks of a peak, where one crest overtakes another, may stop
    it.

    Parameters
    ----------
    run : Trajectory, PeriodicOrbit, Modes, OrderResponse or System
        From `simulate`, `inverse`, `periodic`, `modes` or `order_response`, with the parameters at
        which the search begins; or a system, to be simulated for each design. A motion from
        `periodic` stays periodic, of its period, or of one that is found where it is unknown; what
        its `free` parameter shall be is found too if it is in `vary`.
    vary : mapping of name to (low, high)
        Parameters and their bounds.
    minimise : functional, or mapping of functional or parameter name to weight
        Such as ``peak("motor.tau")``, or ``{rms("motor.tau"): 1.0, "flywheel.J": 0.2}``; of modes
        `frequency`, `damping` and `clearance`; of an order response `order_peak` and
        `separation` too. A negative weight makes large.
    subject_to : mapping of functional or name to (low, high), optional
        Bounds of functionals, or of a quantity at all instants.
    intervals : int
        For a system with states: number of intervals of its collocation, for each part of the run
        between jumps of functions of time.
    periodic : bool
        The states at the end are those at the start, which are free, except for whole turns that
        angles make in the run; states on which nothing depends stay as they start. Else the states
        start as in the run.
    until, parameters, start, rtol
        For a system, as for `gradient`; the search begins with `parameters`. `rtol` is tighter
        than elsewhere: near the optimum a search compares runs that hardly differ.
    starts : int
        For a system: number of searches. The first begins with `parameters`, the others at the
        best of 128 designs each between the bounds, run by `ensemble` and far from each other.
        The best result counts; ``others`` has the rest, so local minima show.

    Returns
    -------
    Optimum

    Raises
    ------
    OptionError
        If bounds contradict each other or the start, a parameter has no effect, or the run has
        changes of modes.
    UnknownNameError
        If a name does not exist.
    OptimisationError
        If no optimum is found, with the constraint that is violated most.
    SolverError
        If a run or an equilibrium fails on the way.

    Notes
    -----
    Waechter and Biegler, Mathematical Programming 106, 2006 (IPOPT); Kraft, DFVLR-FB 88-28, 1988
    (SLSQP).
    """
    weights = _weights(minimise)
    known_kinds: dict[type, Any] = {
        Trajectory: Designed,
        PeriodicOrbit: Designed,
        Modes: Modal,
        OrderResponse: Vibrating,
        System: Functional,
    }
    if type(run) not in known_kinds:
        raise OptionError(
            f"optimise: {type(run).__name__} is nothing that can be optimised; give a run, a "
            "motion from periodic, modes or a system."
        )
    of_kind = known_kinds[type(run)]
    kinds = (str, of_kind)
    for key in [*weights, *(subject_to or {})]:
        if not isinstance(key, kinds):
            known = ", ".join(kind.__name__.lower() for kind in get_args(kinds[1]))
            raise OptionError(
                f"optimise: {key!r} is nothing that {type(run).__name__.lower()} has; known are "
                f"{known} and names."
            )
    if not isinstance(run, System) and (until, parameters, start) != (None, None, None):
        raise OptionError(
            "optimise: until, parameters and start belong to a system; others have theirs."
        )
    if starts < 1 or (starts > 1 and not isinstance(run, System)):
        raise OptionError(
            f"optimise: starts = {starts}: at least one search is needed, and several for a system "
            "only."
        )
    if isinstance(run, Modes):
        return best_modes(run, vary, cast(Any, weights), cast(Any, subject_to or {}))
    if isinstance(run, OrderResponse):
        return best_orders(run, vary, cast(Any, weights), cast(Any, subject_to or {}))
    if isinstance(run, System):
        if until is None:
            raise OptionError("optimise: a system is simulated for each design; give until=, s.")
        until = in_seconds(until, "until")
        scene: Any = {"until": until, "parameters": parameters, "start": start, "rtol": rtol}
        scene["starts"] = starts
        return best_runs(run, vary, cast(Any, weights), cast(Any, subject_to or {}), **scene)
    bounds = cast(Mapping[Designed | str, Bounds], subject_to or {})
    wanted = cast(dict[Designed | str, float], weights)
    repeats = None
    if isinstance(run, PeriodicOrbit):
        _check_free(run, vary)
        repeats, run = of_orbit(run), run.run
    elif periodic and run.system.structure.states:
        repeats = repeating(run)
    problem = DesignProblem(run, vary, wanted, bounds, intervals, repeats)
    return problem.optimum(problem.solve(list(weights.values())), wanted)


def _check_free(orbit: PeriodicOrbit, vary: Mapping[str, Bounds] | Mapping[Name, Bounds]) -> None:
    """Refuse to hold what a periodic motion determines."""
    given = {orbit.system.key(name) for name in vary}
    for name in orbit.free:
        if name not in given:
            raise OptionError(
                f"optimise: {name} is free at this motion, which determines it; name it in `vary`, "
                "with the bounds in which it may be found."
            )


def _weights(minimise: Objective) -> dict[Key | str, float]:
    """Weights of an objective, checked."""
    weights: dict[Key | str, float] = {}
    weights.update(minimise if isinstance(minimise, Mapping) else {minimise: 1.0})
    for key, weight in weights.items():
        if not (isinstance(weight, int | float | np.number) and np.isfinite(weight)):
            raise OptionError(f"optimise: {key} has the weight {weight}; give a finite number.")
    if not any(weights.values()):
        raise OptionError("optimise: nothing to minimise; give one functional or weight.")
    return weights


class DesignProblem:
    """The programme of one design problem, solved for any weights.

    Parameters
    ----------
    run, vary, subject_to
        As for `optimise`.
    weights : mapping of Designed or parameter name to float
        What may be minimised; a negative weight asks for a functional that can be made large.
    """

    def __init__(
        self,
        run: Trajectory,
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[Designed | str, float],
        subject_to: Mapping[Designed | str, Bounds],
        intervals: int = 50,
        repeats: Repeating | None = None,
    ) -> None:
        self.run, self.system = run, run.system
        smooth(run, "optimise")
        self.programme = Programme(self.system.name)
        if intervals < 1:
            raise OptionError(f"intervals = {intervals}: at least one is needed.")
        self.intervals, self.repeats = intervals, repeats
        self.names, box, scale = varied(self.system, vary, run.theta)
        parts = [self.programme.unknown(r[0], k, *r[1:]) for r, k in zip(box, scale, strict=True)]
        self.u = ca.vertcat(*parts)
        self.places = self.system.places(self.names)
        theta = ca.SX(ca.DM(run.theta))
        theta[self.places] = self.u
        self.theta = theta
        held_instants(self.system, self.places)
        self.course = self._course()
        self.terms: dict[Designed | str, FunctionalTerm] = {}
        self.value_rows: dict[Designed | str, Rows] = {}
        self.functionals = self._functionals([*weights, *subject_to])
        self._quantities(subject_to)
        for key in weights:
            if isinstance(key, str):
                place = self.system.places([key])[0]
                size = abs(float(run.theta[place])) or 1.0
                self.terms[key] = FunctionalTerm(self.theta[place], size, False)
        for key, term_ in self.terms.items():
            low, high = bounds_of(str(key), subject_to.get(key, (None, None)))
            if term_.bounded and (np.isfinite(low) or weights.get(key, 0.0) < 0):
                raise OptionError(
                    f"optimise: {key} can be made small or bounded above, not made large or "
                    "bounded below: that has no smooth form."
                )
            unit = self._unit(key)
            self.value_rows[key] = self.programme.constrain(
                str(key), term_.value, low, high, scale=term_.scale, unit=unit, given=True
            )
        self.keys = list(weights)
        w = ca.SX.sym("weights", len(self.keys))
        value = ca.dot(w, ca.vertcat(*(self.terms[k].value for k in self.keys)))
        self._check_effect()
        self.programme.ready(value, w)

    def _unit(self, key: Designed | str) -> str:
        return (
            self.system.parameter_unit(key) if isinstance(key, str) else unit_of(self.system, key)
        )

    def _course(self) -> Discretisation:
        if not self.system.structure.states:
            return along(self.run, self.theta)
        return collocated(
            self.programme, self.run, self.theta, self.places, self.intervals, self.repeats
        )

    def _functionals(self, keys: list[Designed | str]) -> list[Designed]:
        """Terms of all functionals, their quantities evaluated together."""
        found = list(dict.fromkeys(k for k in keys if isinstance(k, Designed)))
        for functional in found:
            if watching(self.system, [functional]) is not self.system:
                raise OptionError(
                    f"optimise: {functional} has kinks, which the equations of a run do not "
                    "follow. Give the system and until=, which simulates each design, or write "
                    "lumped.ops.smooth around what has them."
                )
        if found:
            y = self.course.quantities([f.name for f in found])
            for i, functional in enumerate(found):
                start = self.run[functional.name]
                self.terms[functional] = term(
                    self.programme, self.course, functional, y[i, :], start
                )
        return found

    def _quantities(self, subject_to: Mapping[Designed | str, Bounds]) -> None:
        """Bounds of quantities at all instants."""
        names = [key for key in subject_to if not isinstance(key, Designed)]
        for name in names:
            if self.system.key(name) in self.system.parameters:
                raise OptionError(f"optimise: {name} is a parameter; its bounds belong to `vary`.")
        y = self.course.quantities(names) if names else None
        for i, name in enumerate(names):
            assert y is not None
            low, high = bounds_of(name, subject_to[name])
            sizes = [abs(b) for b in (low, high) if np.isfinite(b)]
            size = max([*sizes, float(np.abs(self.run[name]).max())]) or 1.0
            times = self.course.t if isinstance(self.course.t, np.ndarray) else None
            unit = self.system.quantity(name).unit
            self.programme.constrain(
                name, y[i, :].T, low, high, scale=size, unit=unit, times=times, given=True
            )

    def _check_effect(self) -> None:
        """Refuse parameters on which neither objective nor constraints depend."""
        g = ca.vertcat(*self.programme.constraints)
        symbols = ca.vertcat(*(ca.symvar(self.u[i])[0] for i in range(self.u.numel())))
        columns = set(ca.jacobian_sparsity(g, symbols).get_triplet()[1])
        idle = [name for i, name in enumerate(self.names) if i not in columns]
        if idle:
            meant = ", ".join(dict.fromkeys(row.label for row in self.programme.rows if row.given))
            raise OptionError(
                f"optimise: {', '.join(idle)} has no effect on {meant}. Leave it out of `vary`, "
                "or name a quantity that depends on it."
            )
        self._check_objective()

    def _check_objective(self) -> None:
        """Refuse an objective that no parameter reaches through the equations."""
        w = ca.vertcat(*self.programme.unknowns)
        own = [row for row in self.programme.rows if not row.given]
        kept = [i for row in own for i in range(row.first, row.first + row.count)]
        g = ca.vertcat(*self.programme.constraints)[kept] if kept else ca.SX(0, 1)
        links = scipy.sparse.csr_array(ca.DM(ca.jacobian_sparsity(g, w), 1).sparse())
        label = scipy.sparse.csgraph.connected_components(links.T @ links)[1]
        reached = set(label[: self.u.numel()].tolist())
        for key in self.keys:
            used = ca.jacobian_sparsity(self.terms[key].value, w).get_triplet()[1]
            if not reached & {int(label[i]) for i in used}:
                raise OptionError(
                    f"optimise: {key} does not depend on {', '.join(self.names)}. Vary something "
                    "else, or minimise something else."
                )

    def solve(
        self,
        weights: list[float],
        *,
        limits: Mapping[Designed, float] | None = None,
        begin: np.ndarray | None = None,
    ) -> Solution:
        """Least weighted sum, with upper bounds of functionals besides."""
        box = self.programme.limits.copy()
        for key, high in (limits or {}).items():
            row = self.value_rows[key]
            box[row.first, 1] = min(box[row.first, 1], high / row.scale)
        size = sum(abs(w) * self.terms[k].scale for k, w in zip(self.keys, weights, strict=True))
        return self.programme.solve([w / size for w in weights], begin=begin, limits=box)

    def optimum(self, solution: Solution, weights: Mapping[Designed | str, float]) -> Optimum:
        """What a solution means, with the run made anew."""
        outputs = [self.u, self.course.t, self.course.x]
        found = ca.Function("found", [self.programme.w], [ca.SX(v) for v in outputs])(solution.w)
        u, t = (np.asarray(v).ravel() for v in found[:2])
        theta = self.run.theta.copy()
        theta[self.places] = u
        self.system.check_parameters(theta)
        parameters = dict(zip(self.names, u.tolist(), strict=True))
        settings = self.course.settings
        if self.system.structure.states:
            run = simulated(self.run, theta, t, np.asarray(found[2]), settings)
            true = measured_well(run, self.functionals)
            told = true
        else:
            run = followed_by(self.run, theta)
            true = [measured(f, run) for f in self.functionals]
            told = [number_of(f, run[f.name], dt_of(run)) for f in self.functionals]
        values: dict[Key, float] = dict(zip(self.functionals, told, strict=True))
        error = 0.0
        promised = self.promised(solution)
        for f, number in zip(self.functionals, true, strict=True):
            # an epigraph variable that nothing presses down says nothing
            if not self.terms[f].bounded or weights.get(f):
                size = max(abs(number), _LEAST * self.terms[f].scale)
                error = max(error, abs(promised[f] - number) / size)
        whole = 0.0
        for key, weight in weights.items():
            value = theta[self.system.places([key])[0]] if isinstance(key, str) else values[key]
            whole += weight * float(value)
        starts = self.run.theta[self.places].tolist()
        return Optimum(
            run,
            parameters,
            dict(zip(self.names, starts, strict=True)),
            whole,
            values,
            self._active(solution),
            float(error),
            solution,
        )

    def promised(self, solution: Solution) -> dict[Designed, float]:
        """Functionals as the programme has them."""
        terms = ca.vertcat(ca.SX(0, 1), *(self.terms[f].value for f in self.functionals))
        said = np.asarray(ca.Function("said", [self.programme.w], [terms])(solution.w)).ravel()
        return dict(zip(self.functionals, said.tolist(), strict=True))

    def _active(self, solution: Solution) -> tuple[str, ...]:
        """Names of bounds and constraints that press."""
        found = []
        box = self.programme.box
        for first, name in enumerate(self.names):
            low, high = np.abs(solution.w[first] - box[first, 1:]) <= 1e-6
            if (low or high) and abs(solution.bounds[first]) > 1e-8:
                found.append(f"{name} at its {'lower' if low else 'upper'} bound")
        found += self.programme.reached(solution)
        return tuple(dict.fromkeys(found))
