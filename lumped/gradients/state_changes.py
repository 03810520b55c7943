"""What becomes of the states of a system at an instant, as expressions."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening import hold_modes
from lumped.timeloop.result import Trajectory

__all__ = ["Blow", "Changes", "exchange_fault"]


class Blow(NamedTuple):
    """Constraints that close at a speed.

    Attributes
    ----------
    hits : tuple of (int, bool)
        Holds that close, and whether each bounces.
    members : tuple of int
        Holds that take impulses.
    """

    hits: tuple[tuple[int, bool], ...]
    members: tuple[int, ...]


class Changes:
    """Changes of the states of one system, made once each."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._made: dict[object, ca.Function] = {}

    def states(self, jumps: tuple[int, ...], blow: Blow | None, modes: np.ndarray) -> ca.Function:
        """The states after: (x, p, t, m) -> states, derivatives by x and p, by time along the run.

        Parameters
        ----------
        jumps : tuple of int
            The `when` statements that act.
        blow : Blow or None
            What closes at a speed.
        modes : ndarray
            Modes after it; speeds of what sticks are exactly zero then.
        """
        s, count = self.system.switching, self.system.structure.mode_count
        place = {node: i for i, node in enumerate(self.system.structure.states)}
        stuck = np.flatnonzero(modes[s.first_modes] > 0.5).tolist()
        zero = tuple(place[s.speeds[h]] for h in stuck if s.speeds[h] in place)
        key = jumps, blow and (*blow, modes[:count].tobytes()), zero
        if key not in self._made:
            x, p, t, _ = self.system.inputs
            x_new = self._jumped(ca.SX(x), jumps, place)
            if blow is not None:
                rest, push = self._blown(x_new, blow, modes)
                x_new = x_new + self.system.rhs(x, p, t, push) - self.system.rhs(x, p, t, rest)
            for i in zero:
                x_new[i] = 0
            self._made[key] = self._along("change", x_new)
        return self._made[key]

    def impact(
        self, kind: str, hold: int, jumps: tuple[int, ...], blow: Blow, modes: np.ndarray
    ) -> ca.Function:
        """Loss or impulse of one hold: as `states`, with a number instead of the states."""
        count = self.system.structure.mode_count
        key = kind, hold, jumps, *blow, modes[:count].tobytes()
        if key not in self._made:
            x, p, t, _ = self.system.inputs
            place = {node: i for i, node in enumerate(self.system.structure.states)}
            start = self._jumped(ca.SX(x), jumps, place)
            rest, push = self._blown(start, blow, modes)
            s = self.system.switching
            both = self.system.structure.in_states(ca.horzcat(s.speed, s.acceleration, s.reaction))
            look = ca.Function("look", self.system.inputs, [both])
            before, free, driven = (
                look(start, p, t, m)[hold, :] for m in (self.system.inputs[3], rest, push)
            )
            impulse = driven[2] - free[2]
            speed = before[0] + driven[1] - free[1]
            found = -impulse if kind == "impulse" else 0.5 * impulse * (before[0] + speed)
            self._made[key] = self._along(kind, found)
        return self._made[key]

    def _along(self, name: str, found: ca.SX) -> ca.Function:
        x, p, t, _ = self.system.inputs
        along = ca.jtimes(found, ca.vertcat(x, t), ca.vertcat(self.system.rates, 1))
        outputs = [found, ca.jacobian(found, x), ca.jacobian(found, p), ca.densify(along)]
        return ca.Function(name, self.system.inputs, outputs)

    def _jumped(self, x: ca.SX, jumps: tuple[int, ...], place: dict[int, int]) -> ca.SX:
        """States after `when` statements."""
        values = self.system.structure.in_states(self.system.switching.values)
        for j in jumps:
            jump = self.system.switching.jumps[j]
            for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                if node in place:
                    x[place[node]] = sign * values[jump.first + i]
        return x

    def _blown(self, x: ca.SX, blow: Blow, modes: np.ndarray) -> tuple[ca.SX, ca.SX]:
        """Settings without and with what closes demanding its speeds (see `Impacts`)."""
        s, count = self.system.switching, self.system.structure.mode_count
        _, p, t, m = self.system.inputs
        rest = ca.vertcat(ca.SX(ca.DM(modes[:count])), m[count:])
        both = self.system.structure.in_states(ca.horzcat(s.speed, s.restitution))
        closing = ca.Function("closing", self.system.inputs, [both])(x, p, t, m)
        for h, first in enumerate(s.first_modes.tolist()):
            rest[first : first + hold_modes.COUNT] = ca.DM(
                [h in blow.members, *[0] * (hold_modes.COUNT - 1)]
            )
        push = ca.SX(rest)
        for h, bounces in blow.hits:
            again = 1 + closing[h, 1] if bounces else 1
            push[int(s.first_modes[h]) + hold_modes.DEMAND] = -again * closing[h, 0]
        return rest, push


def exchange_fault(run: Trajectory, t: float) -> str:
    """Why derivatives end where another motion leads, and what to do."""
    found = [e for e in run.events if e.before in run.system.state_names and e.time <= t]
    changes = [f"{e.after} leads instead of {e.before}" for e in found[-1:]]
    after = found[-1].after if found else "the motion that leads later"
    return (
        f"{run.system.name}: at t = {t:.9g} s states change places: "
        f"{''.join(changes) or 'see run.events'}. Derivatives are not followed across that. "
        f"Declare {after} with state='always', so that it leads from the start, or end the run "
        "before."
    )
