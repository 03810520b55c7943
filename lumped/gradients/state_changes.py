"""What becomes of the states of a system at an instant, as expressions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening import hold_modes
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Recent, Shared, made_once

_KEPT = 64
"""Changes of settings of which is kept what may become of the states."""


class Blow(NamedTuple):
    """Constraints that close at a speed.

    Attributes
    ----------
    hits : tuple of (int, bool)
        Holds that close, and whether each bounces.
    members : tuple of int
        Holds that take impulses.
    rubs : tuple of int
        Modes of friction that slides while impulses press it.
    """

    hits: tuple[tuple[int, bool], ...]
    members: tuple[int, ...]
    rubs: tuple[int, ...]


Act = tuple[tuple[int, ...], Blow | None]
"""The `when` statements that act, and what closes at a speed."""


class Entries(NamedTuple):
    """A matrix as a sum of entries.

    Attributes
    ----------
    rows, columns, values : ndarray, shape (entries,)
        Where they stand, and how large they are.
    shape : tuple of int
        Of the matrix.
    """

    rows: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    shape: tuple[int, int]

    def times(self, other: np.ndarray) -> np.ndarray:
        """The product with a dense matrix."""
        return self._product(self.rows, self.columns, other, self.shape[0])

    def multiply_transposed(self, other: np.ndarray) -> np.ndarray:
        """The product of the transposed matrix with a dense one."""
        return self._product(self.columns, self.rows, other, self.shape[1])

    def _product(
        self, rows: np.ndarray, columns: np.ndarray, other: np.ndarray, count: int
    ) -> np.ndarray:
        width = other.shape[1]
        places = rows[:, None] * width + np.arange(width)
        parts = self.values[:, None] * other[columns]
        found = np.bincount(places.ravel(), parts.ravel(), count * width)
        return found.reshape(count, width)

    @property
    def only_row(self) -> np.ndarray:
        """A matrix of one row."""
        found = np.zeros(self.shape[1])
        np.add.at(found, self.columns, self.values)
        return found

    def with_outer(self, column: np.ndarray, row: np.ndarray) -> Entries:
        """The same with the product of a column and a row added."""
        i, k = np.flatnonzero(column), np.flatnonzero(row)
        more = np.repeat(i, len(k)), np.tile(k, len(i)), np.outer(column[i], row[k]).ravel()
        rows, columns, values = map(np.concatenate, zip(self[:3], more, strict=True))
        return Entries(rows, columns, values, self.shape)


class Change:
    """An expression of states, parameters and time at an instant, with its derivatives.

    Parameters
    ----------
    system : System
        From `assemble`.
    name : str
        Of the function.
    found : SX
        The expression, one column.
    """

    def __init__(self, system: System, name: str, found: ca.SX) -> None:
        x, p, t, _ = system.inputs
        along = ca.jtimes(found, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
        slopes = [ca.jacobian(found, x), ca.jacobian(found, p)]
        self._shapes: list[tuple[int, int]] = [s.shape for s in slopes]
        self._places = [np.array(s.sparsity().get_triplet(), dtype=int) for s in slopes]
        outputs = [ca.densify(found), *slopes, ca.densify(along)]
        self._call = ArrayFunction(ca.Function(name, system.inputs, outputs))

    def at(
        self, x: np.ndarray, theta: np.ndarray, t: float, settings: np.ndarray
    ) -> tuple[np.ndarray, Entries, Entries, np.ndarray]:
        """Its value, derivatives by states and parameters, and by time along the run."""
        value, *slopes, along = self._call(x, theta, t, settings)
        by_states, by_parameters = (
            Entries(rows, columns, own, shape)
            for (rows, columns), own, shape in zip(self._places, slopes, self._shapes, strict=True)
        )
        return value, by_states, by_parameters, along


class Changes(Shared):
    """Changes of the states of one system, made once each."""

    def __init__(self, system: System) -> None:
        super().__init__()
        self.system, s = system, system.switching
        held = s.first_modes[:, None] + np.arange(hold_modes.COUNT)
        self._not_held = np.setdiff1d(np.arange(system.structure.mode_count), held)
        self._impulsive = ~(s.has_upper & s.has_lower)
        self._place = {node: i for i, node in enumerate(system.structure.states)}
        self._recent_acts = Recent[list[Act]](_KEPT)

    def acts(self, used: tuple[int, ...], old: np.ndarray, new: np.ndarray) -> list[Act]:
        """What may become of the states: `when` statements, and bodies that hit each other.

        Parameters
        ----------
        used : tuple of int
            Margins that are used up.
        old, new : ndarray
            Settings on both sides.
        """
        key = used, old.tobytes(), new.tobytes()
        return self._recent_acts.of(key, lambda: list(self._list_acts(used, old, new)))

    def _list_acts(self, used: tuple[int, ...], old: np.ndarray, new: np.ndarray) -> Iterator[Act]:
        s = self.system.switching
        rows = [s.rows[i] for i in used]
        jumps: tuple[int, ...] = ()
        if s.jumps:
            risen = {int(s.relation_modes[k]) for kind, k in rows if kind == "relation"}
            risen |= set(np.flatnonzero(new > old).tolist())
            jumps = tuple(j for j, w in enumerate(s.jumps) if w.mode in risen and not old[w.mode])
        was, now = (side[s.first_modes] > 0.5 for side in (old, new))
        bodies = {h for kind, h in rows if kind == "slide" and s.has_gap[h]}
        hits = sorted(bodies | set(np.flatnonzero(now & ~was & self._impulsive).tolist()))
        stays = (was & self._impulsive, was & now & self._impulsive) if hits else ()
        for stay in stays:
            members = tuple(sorted({*hits, *np.flatnonzero(stay).tolist()}))
            # what sticks afterwards did not bounce
            for bounces in (tuple(not now[h] for h in hits), (True,) * len(hits)):
                each = tuple(zip(hits, map(bool, bounces), strict=True))
                yield jumps, Blow(each, members, ())
                if s.is_pressed.any():
                    sticks = np.flatnonzero(now & s.is_pressed).tolist()
                    all_hits = (*each, *((h, False) for h in sticks))
                    yield jumps, Blow(all_hits, tuple(sorted({*members, *sticks})), self._rubs(new))
        if not bodies:
            yield jumps, None

    def _rubs(self, modes: np.ndarray) -> tuple[int, ...]:
        """Modes of friction that slides while impulses press it."""
        s = self.system.switching
        first = s.first_modes[s.is_pressed]
        modes_of_slip = np.concatenate([first + hold_modes.FORWARD, first + hold_modes.BACKWARD])
        return tuple(modes_of_slip[modes[modes_of_slip] > 0.5].tolist())

    def states(self, jumps: tuple[int, ...], blow: Blow | None, modes: np.ndarray) -> Change:
        """The states after an act.

        Parameters
        ----------
        jumps : tuple of int
            The `when` statements that act.
        blow : Blow or None
            What closes at a speed.
        modes : ndarray
            Modes after it; speeds of what sticks are exactly zero then.
        """
        s, place = self.system.switching, self._place
        stuck = np.flatnonzero(modes[s.first_modes] > 0.5).tolist()
        zero = tuple(place[s.speeds[h]] for h in stuck if s.speeds[h] in place)
        others = b"" if blow is None else modes[self._not_held].tobytes()
        return self._change_states(jumps, blow, zero, others)

    def impact(
        self, kind: str, hold: int, jumps: tuple[int, ...], blow: Blow, modes: np.ndarray
    ) -> Change:
        """Loss or impulse of one hold; arguments as for `states`."""
        return self._impact(kind, hold, jumps, blow, modes[self._not_held].tobytes())

    @made_once
    def _change_states(
        self, jumps: tuple[int, ...], blow: Blow | None, zero: tuple[int, ...], others: bytes
    ) -> Change:
        """States after an act, those numbered in `zero` zero; `others` are modes but of holds."""
        x, p, t, _ = self.system.inputs
        x_new = self._jump(ca.SX(x), jumps)
        if blow is not None:
            rest, push = self._find_blow_settings(x_new, blow, others)
            x_new = x_new + self.system.rhs(x, p, t, push) - self.system.rhs(x, p, t, rest)
        for i in zero:
            x_new[i] = 0
        return Change(self.system, "change", x_new)

    @made_once
    def _impact(
        self, kind: str, hold: int, jumps: tuple[int, ...], blow: Blow, others: bytes
    ) -> Change:
        """Loss or impulse of one hold."""
        x, p, t, m = self.system.inputs
        start = self._jump(ca.SX(x), jumps)
        rest, push = self._find_blow_settings(start, blow, others)
        s = self.system.switching
        both = self.system.structure.in_states(ca.horzcat(s.speed, s.acceleration, s.reaction))
        look = ca.Function("look", self.system.inputs, [both])
        before, free, driven = (look(start, p, t, modes)[hold, :] for modes in (m, rest, push))
        impulse = driven[2] - free[2]
        speed = before[0] + driven[1] - free[1]
        found = -impulse if kind == "impulse" else 0.5 * impulse * (before[0] + speed)
        return Change(self.system, kind, found)

    def _jump(self, x: ca.SX, jumps: tuple[int, ...]) -> ca.SX:
        """States after `when` statements."""
        values = self.system.structure.in_states(self.system.switching.values)
        for j in jumps:
            jump = self.system.switching.jumps[j]
            for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                if node in self._place:
                    x[self._place[node]] = sign * values[jump.first + i]
        return x

    def _find_blow_settings(self, x: ca.SX, blow: Blow, others: bytes) -> tuple[ca.SX, ca.SX]:
        """Settings without and with what closes demanding its speeds (see `Impacts`)."""
        s, count = self.system.switching, self.system.structure.mode_count
        _, p, t, m = self.system.inputs
        modes = np.zeros(count)
        modes[self._not_held] = np.frombuffer(others)
        modes[s.first_modes[list(blow.members)]] = 1.0
        modes[list(blow.rubs)] = 1.0
        rest = ca.vertcat(ca.SX(ca.DM(modes)), m[count:])
        both = self.system.structure.in_states(ca.horzcat(s.speed, s.restitution))
        closing = ca.Function("closing", self.system.inputs, [both])(x, p, t, m)
        push = ca.SX(rest)
        for h, bounces in blow.hits:
            again = 1 + closing[h, 1] if bounces else 1
            push[int(s.first_modes[h]) + hold_modes.DEMAND] = -again * closing[h, 0]
        return rest, push
