"""How the states at a start follow from parameters and from start values that vary."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from lumped.compiler.constraints import constraints_of
from lumped.compiler.system import Changes, System
from lumped.errors import StartError
from lumped.points.direct_start import direct_slopes, direct_start
from lumped.points.start import by_name, find_start, start_by_states
from lumped.points.start_search import StartSearch
from lumped.points.start_values import read_start_values
from lumped.timeloop.leading_states import tied_values
from lumped.timeloop.results.operating_point import OperatingPoint


def start_slopes(
    system: System,
    theta: np.ndarray,
    start: Changes | OperatingPoint | None,
    time: float,
    seed: np.ndarray,
    varied: Mapping[int, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """States at the start, before any impact there, and their derivatives.

    Parameters
    ----------
    start : mapping of name to float, or OperatingPoint, optional
        Start values; or a point, whose states stay where parameters vary.
    time : float
        Instant of the start, s.
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters.
    varied : mapping of int to ndarray, shape (k,)
        Derivatives of start values of unknowns; each is given or a state.

    Returns
    -------
    ndarray, shapes (n,) and (n, k)
    """
    used = system.structure.in_use
    if isinstance(start, OperatingPoint):
        slopes = np.zeros((len(system.structure.states), seed.shape[1]))
        reduced, place = system.structure.reduced, dict[int | None, int]()
        place |= {node: i for i, node in enumerate(system.structure.states)}
        for unknown, unit in varied.items():
            slopes[place[reduced.node(unknown)]] = reduced.aliases.signs[unknown] * unit
        return start.x, slopes
    changed = read_start_values(system, by_name(start))
    form, values = direct_start(system, tuple(changed)), list(changed.values())
    direct = direct_slopes(system, tuple(changed), tuple(varied))
    found = None if form is None else form.states(theta, time, values)
    if found is not None and direct is not None and not _may_be_led(system):
        directions = np.vstack([seed, *varied.values()]) if varied else seed
        return found[0], direct.along(theta, time, values, directions)
    begin = _search(system, theta, by_name(start), time)
    x = begin.x
    return x[used], begin.slopes(x, seed, varied)[used]


def _search(system: System, theta: np.ndarray, start: Changes, time: float) -> StartSearch:
    """The search for the start, after it was made; from the point that was found in all ties.

    Raises
    ------
    StartError
        If other quantities than the states of the system lead there, or what moved to meet the
        start values is not determined by them.
    """
    search, used = StartSearch(system, theta, start, [], time), system.structure.in_use
    made = system, dict(zip(system.parameters, theta.tolist(), strict=True)), start, (), time
    point = find_start(*made) if _may_be_led(system) else None
    if point is not None:
        point = point.before or point
        led = point.system is not system
        if not led and (own := _own(*made)) is not None:
            point = None if np.array_equal(point.x, (own.before or own).x) else point
    if point is None:
        search.solve()
        return search
    begin, missing = search.x.copy(), set[int]()
    if not led:
        values = tied_values(system, system, point.inputs)
        for unknown, raw in (search.starts | search.given).items():
            node, value = search.reduced.node(unknown), search.signed(unknown, raw)
            if node in values and abs(values[node] - value) <= 1e-9 * max(1.0, abs(value)):
                search.followed[node] = unknown, value
        search.x[used] = point.x
        search.guesses = point.settings[len(point.settings) - len(search.guesses) :]
        found = search.solve()
        fixed = {search.position[node] for node in search.fixed}
        found_by = set(search.search.regular(found)[1]) if search.search else set[int]()
        missing = set(np.flatnonzero(np.abs(found - begin) > 1e-9).tolist()) - fixed - found_by
        led = not np.allclose(found[used], point.x, rtol=1e-7, atol=1e-9)
    if led or missing:
        raise StartError(
            f"{system.name}: how this start follows from parameters is not known, as start values "
            f"of other quantities than the states {', '.join(system.state_names[:6])} lead to it. "
            "Give start values of these, or keep the start as it is: start=lp.start_point(system)."
        )
    return search


def _may_be_led(system: System) -> bool:
    return bool(constraints_of(system)) and not system.structure.flat.initial


def _own(*made: Any) -> OperatingPoint | None:
    """The start as the states lead to it, if they do."""
    try:
        return start_by_states(*made)
    except StartError:
        return None


@dataclass(frozen=True, eq=False)
class StartForm:
    """States at the time zero as expressions of the parameters, before any impact there.

    Attributes
    ----------
    states : SX, shape (all states, 1)
        Those that are given or take their defaults; numbers for those that must be searched for.
    miss : SX
        What must vanish: targets less what is wanted, relative to that if it is above one;
        expressions of all states, parameters, time and settings.
    rows, columns : list of int
        Targets and states of a regular system of as many equations as states.
    guesses : ndarray
        Where the search for implicit quantities begins.
    """

    states: ca.SX
    miss: ca.SX
    rows: list[int]
    columns: list[int]
    guesses: np.ndarray


def fix_start(point: OperatingPoint) -> StartForm:
    """The states of a point, whatever the parameters are."""
    structure = point.system.structure
    states = ca.SX.zeros(len(structure.reduced.states))
    states[structure.in_use] = ca.SX(ca.DM(point.x))
    guesses = point.settings[len(point.settings) - len(structure.implicit) :]
    return StartForm(states, ca.SX(0, 1), [], [], guesses)


def start_form(system: System, start: Changes) -> StartForm:
    """How the states at the time zero follow from the parameters; some start values are set."""
    begin = _search(system, system.theta(None), start, 0.0)
    x, flat, reduced = begin.x, system.structure.flat, begin.reduced

    def read_signed(unknown: int) -> ca.SX:
        given = begin.given if unknown in begin.changed else {**flat.starts, **flat.given}
        return float(reduced.aliases.signs[unknown]) * ca.SX(given[unknown])

    states = ca.SX.zeros(len(x))
    for unknown in (*flat.starts, *(u for u, _ in begin.fixed.values())):
        node = reduced.node(unknown)
        if node in begin.position:
            states[begin.position[node]] = read_signed(unknown)
    guesses = begin.settings[len(begin.settings) - len(begin.guesses) :]
    if begin.search is None:
        return StartForm(states, ca.SX(0, 1), [], [], guesses)
    rows, columns = begin.search.regular(x)
    states[columns] = ca.DM(x[columns])
    wanted = ca.SX.zeros(begin.search.value.numel())
    for i, (unknown, _) in enumerate(begin.targets.values()):
        wanted[i] = read_signed(unknown)
    miss = (begin.search.value - wanted) / ca.fmax(1, ca.fabs(wanted))
    return StartForm(states, miss, rows, columns, guesses)
