"""Starts that the chosen states do not reach: found in all that is tied, led by other states."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from lumped.compiler.constraints import constraints_of
from lumped.compiler.leads import exchange_states, free_coordinates
from lumped.compiler.system import Changes, System
from lumped.errors import StartError
from lumped.points.consistent_start import ConsistentStart
from lumped.points.start_search import StartSearch
from lumped.timeloop.clocks import modes_at
from lumped.timeloop.fit_states import FitStates, SingularPositionError, singular_text
from lumped.timeloop.leading_states import tied_values
from lumped.timeloop.levers import may_be_unfit
from lumped.timeloop.plants.executable import evaluate_at, executable
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.settings import close_settings, just_after

_HELD = 1e-9
_CLOSE = 1e-4
"""Independence of constraints below which rounding decides on what states lead to."""
_ROUNDED = 3e-6
"""Independence below which rounding hides whether links turn sharply."""
_AWAY, _BENT, _STEPS = 1e-4, 0.01, 10
"""Independence, squared, away from a singular position, how speeds may differ there, relative to
the fastest, and steps of Newton's method to the constraints."""
_MOVED = 1e-6
"""Distance of two assemblies, beside rounding."""


def consistent_point(
    system: System, theta: np.ndarray, start: Changes, time: float, found: OperatingPoint | None
) -> OperatingPoint | None:
    """The point at which constraints, given and declared values hold, before any impact.

    Parameters
    ----------
    found : OperatingPoint or None
        What the states in use lead to, before any impact; None if they lead to nothing.

    Returns
    -------
    OperatingPoint or None
        None if that is right, or if more is demanded than values of tied quantities.

    Raises
    ------
    StartError
        If nothing was found before, and there is no such point.
    """
    structure = system.structure
    reduced = structure.reduced
    parts = constraints_of(system)
    if not parts:
        return None
    search = StartSearch(system, theta, start, [], time)
    search.sort()
    stores = search.fixed, search.targets, search.guessed
    held = {node: value for store in stores for node, (_, value) in store.items()}
    starts = [(reduced.node(u), search.signed(u, v)) for u, v in search.starts.items()]
    declared = {node: value for node, value in starts if node is not None}
    if not held.keys() <= reduced.tied | set(reduced.states):
        return None
    modes = modes_at(system, theta, just_after(time))
    if found is not None:
        modes = found.settings[: len(modes)]
    guess = declared | held
    fit = FitStates(system, theta, time, modes)
    lost: tuple[str, ...] = ()
    is_near = False
    if found is not None:
        values = dict.fromkeys((n for part in parts for n in part.nodes), 0.0) | guess
        values |= tied_values(system, system, found.inputs)
        lost = _list_lost(system, guess, values)
        turned = any(
            abs(values[n] - guess.get(n, 0.0)) > np.pi
            for n in structure.implicit
            if n in values and structure.is_angle(n)
        )
        is_fit, is_near = not fit.is_unfit(values), _is_near_singular(found)
        if is_fit and not (lost or turned or is_near):
            return None
    guessed = [n for n, (u, _) in search.guessed.items() if u not in search.changed]

    def search_all(yielding: Collection[int]) -> dict[int, float]:
        values: dict[int, float] = {}
        for part in parts:
            tied = ConsistentStart(system, part, theta, time, modes, guess, set(held))
            values |= _find_free(tied, yielding)
        return values

    try:
        every = search_all(guessed)
    except StartError:
        if found is None or not is_fit:
            raise
        try:  # what chooses an assembly may be rough
            every = search_all(search.guessed)
        except StartError:
            return replace(found, lost=lost)
    moved = found is not None and any(
        abs(values[n] - every[n]) > _MOVED for n in structure.implicit if n in every
    )
    is_close = False
    try:
        if found is None or is_near:
            least = fit.check(every)
            is_close = least < _CLOSE
        pairs = fit.find(every) if fit.is_unfit(every) else []
    except SingularPositionError as error:
        if found is None or is_near:
            raise StartError(singular_text(system, error, "the start")) from None
        return replace(found, lost=lost)
    if found is not None and not (lost or turned or moved or pairs or is_close):
        return None
    led = exchange_states(system, pairs) if pairs else system
    if is_close:
        led = free_coordinates(system, -1)
        if not led.structure.invariants.numel():
            raise StartError(
                f"{system.name}: at the start a constraint has a slope without bound, as a root at "
                "zero, so that it is not determined how it moves on. Start beside it, or give it a "
                "smooth function."
            )
    now = {**guess, **every}
    x = np.array([now.get(node, 0.0) for node in led.structure.states])
    if is_close:
        _check_branch(led, x, theta, time, modes, least)
    guesses = np.array([now.get(node, 0.0) for node in led.structure.implicit])
    settings = close_settings(led, x, theta, time, modes, guesses)
    point = OperatingPoint(led, time, x, theta, settings)
    # beside a singular position, closing may lead to another branch than the search
    return replace(
        point, lost=_list_lost(system, guess, every | tied_values(system, led, point.inputs))
    )


def _check_branch(
    system: System,
    x: np.ndarray,
    theta: np.ndarray,
    time: float,
    modes: np.ndarray,
    independence: float,
) -> None:
    """Refuse speeds in redundant coordinates with which no branch leaves a singular position.

    Where links nearly come into line, speeds turn sharply on one branch.

    Raises
    ------
    StartError
        If speeds change where the motion has come away from it.
    """
    code = executable(system)
    rates = code.evaluate("rates", x, theta, time, modes)
    is_position = code.plant.is_moved.astype(bool)
    speed = float(np.abs(rates[is_position]).max(initial=0.0))
    for reach in 2.0 ** np.arange(-40, 0) / max(speed, 1e-300):
        there = x + reach * np.where(is_position, rates, 0.0)
        change = code.evaluate("projection", there, theta, time + reach, modes)
        if change[-1] >= _AWAY:
            break
    aside = np.zeros(len(x))
    for way in (reach, -reach):
        there = x + way * np.where(is_position, rates, 0.0)
        for _ in range(_STEPS):
            there += code.evaluate("projection", there, theta, time + way, modes)[:-1]
        aside += 0.5 * there
    turn = float(np.abs(rates[~is_position]).max(initial=0.0))
    is_sharp = independence > _ROUNDED and turn * independence > _BENT * speed**2
    bent = float(np.abs(aside - x)[~is_position].max(initial=0.0))
    if not (is_sharp or bent <= _BENT * speed):
        raise StartError(
            f"{system.name}: at the start links are nearly in line, and with these speeds they do "
            "not move on: they fit none of the branches. Give the speeds of one, or start farther "
            "from that position."
        )


def _find_free(tied: ConsistentStart, guessed: Collection[int]) -> dict[int, float]:
    """The point at which given values hold; if there is none, guesses of assemblies yield."""
    try:
        return tied.find()
    except StartError:
        if not guessed or not tied.release(guessed):
            raise
        return tied.find()


def _is_near_singular(point: OperatingPoint) -> bool:
    """Whether a linkage is near a position in which states do not lead it."""
    system = point.system
    if not may_be_unfit(system):
        return False
    ratios = evaluate_at(system, "leverage", point.x, point.theta, point.time, point.settings)
    return not (np.abs(ratios) <= 1.0).all()


def _list_lost(
    system: System, wanted: Mapping[int, float], values: Mapping[int, float]
) -> tuple[str, ...]:
    """Start values that do not hold, in words."""
    return tuple(
        f"{system.structure.node_name(n)} = {v:.6g}"
        for n, v in wanted.items()
        if n in values and not abs(values[n] - v) <= _HELD * max(1.0, abs(v))
    )
