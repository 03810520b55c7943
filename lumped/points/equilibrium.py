"""States at which nothing changes: steady state, steady rotation and rest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError, StartError
from lumped.points.equilibrium_demands import Demands, computable_rows, order_of
from lumped.points.equilibrium_search import EquilibriumSearch
from lumped.points.position_search import search_positions
from lumped.points.start import by_key, free_places, start_point
from lumped.points.steady_directions import unsteady_part
from lumped.support.arguments import checked
from lumped.support.units import amount
from lumped.timeloop.holds import Holds
from lumped.timeloop.programs import refuse_programs
from lumped.timeloop.results.operating_point import Kept, OperatingPoint
from lumped.timeloop.results.validity import refuse_point_outside
from lumped.timeloop.settings import just_after, settings_at, settle_positions

_MOST = 10
"""Times that what sticks, slides or switches is chosen anew, and four for each that may."""


@checked
def equilibrium(
    system: System,
    *,
    parameters: Changes | None = None,
    start: Changes | None = None,
    free: Iterable[Name] = (),
    rest: bool = False,
    time: float = 0.0,
    tolerance: float = 1e-10,
) -> OperatingPoint:
    """Find states whose derivatives all vanish, nearest to the start values.

    Given start values are kept and initial equations go on to hold if an equilibrium allows it, so
    a free drive turns at the speed that was given. What no equilibrium near the start keeps is
    named in ``point.lost`` and where the point is printed; values in `start` come before those
    given to instances. Absolute angles or positions may go on at a constant rate if nothing
    depends on how far they turned together (steady rotation).

    The search starts from `start_point`. It is a Newton iteration with minimum-norm steps
    (Deuflhard, Newton Methods for Nonlinear Problems, ch. 4). Where that fails, the way on which
    the system settles is followed in pseudo-time, through play that closes and whatever else
    changes its position. What sticks, slides and is switched agrees with the point found.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters, start : mapping of name to float, optional
        Parameters to change, start values to set.
    free : iterable of names
        Parameters that the equilibrium determines, for example the torque of a motor that turns
        its load at the given speed. Given start values must then hold.
    rest : bool
        Nothing moves: all speeds are zero, whatever start values instances give them.
    time : float
        Instant at which functions of time are taken, s.
    tolerance : float
        Largest remaining derivative, relative to the derivatives' own scale.

    Returns
    -------
    OperatingPoint

    Raises
    ------
    OptionError
        If the tolerance makes no sense, a free parameter is named twice, or the system asks
        programs.
    SolverError
        If there is no equilibrium near the start; the text names the worst equation.
    StartError
        If free parameters are not determined, or speeds are given to a system at rest.
    """
    if not 0 < tolerance < 1:
        raise OptionError(f"equilibrium: tolerance = {tolerance:g} must lie between 0 and 1.")
    refuse_programs(system, "an equilibrium")
    free = tuple(free)
    places = free_places(system, free)
    begin = start_point(system, parameters=parameters, start=start, time=time)
    if rest:
        _refuse_speeds(system, start)
    demands = Demands(begin, start or {}, rest)
    fault: SolverError | None = None
    again = None
    if system.structure.lost_states:
        given = by_key(system, parameters, start, free)
        again = partial(equilibrium, **given, rest=rest, time=time, tolerance=tolerance)
    for keep in (True, False)[: 1 if places else 2]:
        try:
            found = _Equilibrium(demands, places, rest, tolerance).find(keep=keep)
        except SolverError as error:
            fault = fault or error
            continue
        system.check_parameters(found.theta)
        refuse_point_outside(found, "at the equilibrium")
        return replace(found, again=again)
    assert fault is not None
    raise fault


class _Equilibrium:
    """The search for an equilibrium and the positions that hold there."""

    def __init__(self, demands: Demands, places: list[int], rest: bool, tolerance: float) -> None:
        self._demands, self._first, self._system = demands, demands.begin, demands.begin.system
        self._places, self._rest, self._tolerance = places, rest, tolerance
        self._on_the_way = False

    def find(self, *, keep: bool) -> OperatingPoint:
        """An equilibrium; with all that was given, or as much of it as possible.

        Raises
        ------
        SolverError
            If there is none near the start.
        """
        demands, s = self._demands, self._system.switching
        nodes = demands.asked + demands.declared
        equations = list(range(demands.equations.numel()))
        point = search_positions(
            self._first,
            partial(self._solve, nodes, equations) if keep else self._nearest,
            self._reposition,
            _between,
            _key,
            _MOST + 4 * (len(s.relation_modes) + len(s.first_modes)),
        )
        if point is None:
            raise SolverError(
                f"{self._system.name}: no equilibrium near the start values: what sticks or slides "
                "changes again and again. Give start values nearer to it."
            )
        if not keep or (_modes(point) != _modes(self._first)).any():
            point = self._nearer(point, *((nodes, equations) if keep else demands.find_kept(point)))
        lost = demands.list_lost(point)
        kept = Kept(rest=self._rest)
        if not lost:
            kept = Kept(tuple(self._places), tuple(sorted({*nodes})), True, self._rest)
        return replace(point, lost=lost, kept=replace(kept, start=demands.start))

    def _nearer(
        self, point: OperatingPoint, nodes: list[int], equations: list[int]
    ) -> OperatingPoint:
        """The equilibrium nearest to the start in the positions of one, keeping some of it."""
        system = self._system
        wanted = dict(zip(nodes, self._demands.values(nodes, self._first), strict=True))
        speeds = np.array([order_of(system, n) > 0 for n in system.structure.states], dtype=bool)
        closed = np.where(speeds, self._first.x, point.x)
        for begin in (self._first.x, closed, point.x):
            x = begin.copy()
            for i, node in enumerate(system.structure.states):
                if node in wanted:
                    x[i] = wanted[node]
            start = replace(self._first, x=x, settings=point.settings)
            try:
                near = self._solve(nodes, equations, start, newton=True)
                if self._reposition(near) is near:
                    return near
            except (SolverError, StartError):
                continue
        return point

    def _nearest(self, begin: OperatingPoint) -> OperatingPoint:
        """The equilibrium in the positions of a point that keeps as much as possible."""
        demands, values = self._demands, self._system.structure.values
        asked, declared = (
            (values.of(nodes), demands.values(nodes, self._first))
            for nodes in (demands.asked, demands.declared)
        )
        zeros = np.zeros(demands.equations.numel())
        second = ca.vertcat(declared[0], demands.equations), np.append(declared[1], zeros)
        return self._solve([], [], begin, wishes=(asked, second))

    def _solve(
        self,
        nodes: list[int],
        equations: list[int],
        begin: OperatingPoint,
        *,
        wishes: Sequence[tuple[ca.SX, np.ndarray]] = (),
        newton: bool = False,
    ) -> OperatingPoint:
        """An equilibrium that keeps what is named, in the positions of a point.

        Or a point on the way to it where these positions change.
        """
        system, rest = self._system, self._rest
        s = system.switching
        are_stuck = begin.settings[s.first_modes] > 0.5
        stuck = {n for n, on in zip(s.speeds, are_stuck, strict=True) if on and n >= 0}
        still = np.array([node in stuck for node in system.structure.states], dtype=bool)
        fixed = np.array([node in nodes for node in system.structure.states], dtype=bool)
        if rest:
            still |= np.array(
                [order_of(system, n) > 0 for n in system.structure.states], dtype=bool
            )
        every = scipy.sparse.eye_array(len(still), format="csc")
        change = every if rest else unsteady_part(begin)
        kept = [n for n in nodes if n not in system.structure.states and n not in stuck]
        zero = sorted(stuck - {*system.structure.states})
        zero = [n for n in zero if computable_rows(system, system.structure.values.of([n]))[0]]
        gaps = np.flatnonzero(s.has_gap & are_stuck).tolist()  # closed, and stay so
        closed = s.gap[gaps] if gaps else ca.SX(0, 1)
        nothing = np.zeros(len(zero) + closed.numel() + len(equations))
        wanted = [self._demands.values(kept, self._first), nothing]
        expressions = ca.vertcat(
            system.structure.values.of(kept),
            system.structure.values.of(zero),
            closed,
            self._demands.equations[equations] if equations else ca.SX(0, 1),
        )
        wishes = [] if rest else [(system.structure.in_states(e), v) for e, v in wishes if len(v)]
        search = EquilibriumSearch(
            begin,
            self._places,
            self._tolerance,
            change,
            system.structure.in_states(expressions),
            np.concatenate(wanted),
            wishes,
        )
        x = np.where(still, 0.0, begin.x)
        implicit = begin.settings[len(begin.settings) - len(system.structure.implicit) :]
        later = just_after(self._first.time)
        settings = settings_at(system, x, begin.theta, later, implicit, begin.settings)
        movable = ~(fixed | still)
        if newton:
            found = search.newton(x, settings, movable)
        else:
            found = search.near(x, settings, movable, still)
        self._on_the_way = search.on_the_way
        if found is None:
            raise SolverError(search.fault("rest" if rest else "equilibrium"))
        if rest and not self._on_the_way:
            search.check_rest(found)
        return found

    def _reposition(self, found: OperatingPoint) -> OperatingPoint:
        """The point with the positions that hold there; itself if it is an equilibrium in them."""
        point = _settle_positions(found)
        if point is found and self._on_the_way:
            raise SolverError(
                f"{self._system.name}: no equilibrium near the start values: on the way there, "
                "positions of conditions or holds cannot be told. Give start values nearer to it."
            )
        return point


def _modes(point: OperatingPoint) -> np.ndarray:
    return point.settings[: len(point.settings) - len(point.system.structure.implicit)]


def _between(begin: OperatingPoint, end: OperatingPoint, share: float) -> OperatingPoint:
    return replace(begin, x=begin.x + share * (end.x - begin.x))


def _key(point: OperatingPoint) -> np.ndarray:
    """What tells points of the search apart: modes and states, without rounding."""
    positions = point.system.switching.positions(_modes(point))
    return np.append(positions, point.x).astype(np.float32)


def _settle_positions(point: OperatingPoint) -> OperatingPoint:
    """The point, with what sticks, slides and is switched there; itself if nothing changes.

    What would have to slide backwards on the way there is tried at standstill first.
    """
    system, switching = point.system, point.system.switching
    if not switching:
        return point
    modes, guesses = np.split(
        point.settings, [len(point.settings) - len(system.structure.implicit)]
    )
    holds, time, x = Holds(system, point.theta), just_after(point.time), point.x.copy()
    speed = holds.look(time, x, modes, guesses).speed
    _, forward, backward = holds.parts(modes)
    turned = (forward & (speed < 0) | backward & (speed > 0)) & ~switching.has_gap
    holds.stop(x, turned)
    found = settle_positions(system, point.theta, time, x, point.settings)
    return point if found is None else OperatingPoint(system, point.time, x, point.theta, found)


def _refuse_speeds(system: System, start: Changes | None) -> None:
    for name, value in (start or {}).items():
        node = system.structure.reduced.node(system.structure.tree.unknown(name))
        if node is not None and order_of(system, node) > 0 and value:
            raise StartError(
                f"{system.key(name)} = {amount(value, system.quantity(name).unit)}: nothing "
                "moves at rest. Leave out this start value, or rest=True."
            )
