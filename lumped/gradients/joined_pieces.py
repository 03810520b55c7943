"""Smooth parts of a run that go on over points of tables of time.

Such a point comes at a fixed instant and leaves the states as they are, so that derivatives do not
jump there: ``S_after = S_before + drift t_p`` with ``t_p == 0`` (see `EventDerivatives`).
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.functionals.readings import AtEvent, Cycles, Extreme, Occurrence, Reading, Value
from lumped.gradients.readings.product_curve import look_along
from lumped.support.made_once import made_once
from lumped.timeloop.clocks import clocks
from lumped.timeloop.results.trajectory import Piece, Trajectory

_ROUNDING = 1e-9
"""Of the largest value: differences below are no jump."""


def join_pieces(run: Trajectory, pieces: list[Piece], readings: Iterable[Reading]) -> list[Piece]:
    """Smooth parts, those in one between which nothing changes that derivatives notice.

    Parameters
    ----------
    readings : iterable of Reading
        What is read from the run: those of events need all of them, extremes and cycles need both
        sides of the jumps of what they look at.
    """
    system = pieces[0].system
    noticed = ~_passed(system, any(map(_looks_for_events, readings)))
    pairs = list(pairwise(pieces))
    goes_on = np.array(
        [
            before.t[-1] == after.t[0]
            and (before.x[-1] == after.x[0]).all()
            and (before.settings[-1] == after.settings[0])[: len(noticed)][noticed].all()
            for before, after in pairs
        ],
        dtype=bool,
    )
    own = np.flatnonzero(goes_on).tolist()
    for factors in {f.factors for f in readings if isinstance(f, Extreme | Cycles)} if own else ():
        look = look_along(system, tuple(map(system.key, factors)))
        x, t = (np.array([getattr(pairs[k][1], v)[0] for k in own]) for v in ("x", "t"))
        old, new = (
            look(x, run.theta, t, np.array([pairs[k][side].settings[side - 1] for k in own]))[:, 0]
            for side in (0, 1)
        )
        goes_on[own] &= np.abs(new - old) <= _ROUNDING * np.abs([old, new]).max()
    begins = np.flatnonzero(np.append(True, ~goes_on)).tolist()
    return [_join(pieces[a:b]) for a, b in pairwise([*begins, len(pieces)])]


def _looks_for_events(reading: Reading) -> bool:
    at_event = isinstance(reading, Value) and isinstance(reading.at, AtEvent)
    return at_event or isinstance(reading, Occurrence)


@made_once
def _passed(system: System, only_smooth: bool) -> np.ndarray:
    """Modes of tables of time, or those in `smooth`, whose points do not move."""
    found, fixed = np.zeros(system.structure.mode_count, dtype=bool), set[int]()
    for k, clock in enumerate(clocks(system)):
        condition = clock.condition
        moves = ca.depends_on(condition.argument, clock.inputs[2])
        if moves or condition.pieces is None or not fixed.issuperset(clock.needs):
            continue
        fixed.add(k)
        found[list(condition.modes)] = not (only_smooth and condition.relation.told)
    return found


def _join(pieces: list[Piece]) -> Piece:
    """Several pieces in one; each ends where the next one begins."""
    if len(pieces) == 1:
        return pieces[0]
    *firsts, last = pieces
    t, x, settings = (
        np.concatenate([*(getattr(p, v)[:-1] for p in firsts), getattr(last, v)])
        for v in ("t", "x", "settings")
    )
    ends = None
    if last.ends is not None:
        ends = np.concatenate([*(p.ends[:-1] for p in firsts if p.ends is not None), last.ends])
    return Piece(last.system, t, x, settings, ends)
