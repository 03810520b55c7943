"""Changes of modes at an instant: what sticks and what slides from then on, what collides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.timeloop.fitting import Fitting
from lumped.timeloop.holds import STUCK, Holds, Look, Situation
from lumped.timeloop.impact import Impacts
from lumped.timeloop.sharing import Sharing

__all__ = ["Change", "Settler"]

_INSIDE = 1e-9
"""How deep bodies may start inside each other, m or rad: rounding of start values."""


@dataclass(frozen=True)
class Change:
    """A component that changed its mode: words for before and after, energy lost in J."""

    component: str
    before: str
    after: str
    loss: float = 0.0


class Settler:
    """Finds modes for one system and set of parameters.

    Parameters
    ----------
    system : System
        From `assemble`.
    theta : ndarray
        Parameters.
    span : float
        Size of the times of the run, s. What happens within 1e-12 of it happens at once; a bounce
        that would last less than 1e-10 of it is left out.
    """

    def __init__(self, system: System, theta: np.ndarray, span: float) -> None:
        self._s, self._name, self._soon = system.switching, system.name, 1e-12 * span
        self._holds = Holds(system, theta)
        self._sharing = Sharing(self._holds)
        self._impacts = Impacts(self._holds, self._sharing, 1e-10 * span)

    def begin(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, tuple[Change, ...]]:
        """States and modes at the start, and what collides there at once.

        Only modes of functions of time are given.

        Raises
        ------
        StartError
            If bodies start inside each other.
        SolverError
            If no modes fit.
        """
        s = self._s
        modes, look = self._conditions(t, x, modes, guess)
        for h in np.flatnonzero(s.has_gap & (look.gap < -_INSIDE)):
            raise StartError(
                f"{self._name}: {s.names[h]} starts {-look.gap[h]:.6g} "
                f"{s.gap_units[h]} inside the body that it must not enter. Give start values "
                "that leave a gap, or none."
            )
        at = self._situation(t, x, modes, guess, modes)
        self._fitting(at, modes).run()
        slow = self._holds.rounding(x)
        hits = [h for h in sorted(at.losses) if abs(look.v[h]) > slow[h]]
        word = self._holds.word
        collisions = [Change(s.names[h], "", word(at.modes, h), at.losses[h]) for h in hits]
        return at.x, at.modes, tuple(collisions)

    def positions(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> np.ndarray:
        """Modes at a start before anything collides there, with the arguments of `begin`.

        Raises
        ------
        SolverError
            If no modes fit.
        """
        modes, _ = self._conditions(t, x, modes, guess)
        at = self._situation(t, x, modes, guess, modes)
        Fitting(self._holds, self._sharing, None, at, modes, self._soon).run()
        return at.modes

    def _conditions(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, Look]:
        """Modes with those of conditions as their sides say, and what was looked at."""
        modes = modes.copy()
        for _ in range(3):
            look = self._holds.look(t, x, modes, guess)
            # not an instant after the start already, so that a clock ticks at zero
            self._s.begin(modes, look.greater, look.less)
        return modes, look

    def settle(
        self,
        t: float,
        x: np.ndarray,
        modes: np.ndarray,
        guess: np.ndarray,
        before: np.ndarray,
        fired: Sequence[tuple[str, int]] = (),
    ) -> tuple[np.ndarray, np.ndarray, list[Change]]:
        """States and modes just after an instant.

        Parameters
        ----------
        modes, before : ndarray
            Modes with those of functions of time as they are from now on; all as they were.
        fired : sequence of (str, int)
            Margins that are used up (see `Switching.margins`).

        Raises
        ------
        SolverError
            If no modes fit, or changes follow each other without end.
        """
        at = self._situation(t, x, modes, guess, before)
        fitting = self._fitting(at, before)
        fitting.flip(fired)
        fitting.run()
        return at.x, at.modes, self._changes(at, before, fitting.jumped)

    def _situation(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray, before: np.ndarray
    ) -> Situation:
        was_stuck = self._holds.parts(before)[STUCK]
        x = x.copy()
        self._holds.stop(x, was_stuck)  # implicit steps leave rounding there
        return Situation(t, x, modes.copy(), guess, was_stuck, np.zeros_like(was_stuck))

    def _fitting(self, at: Situation, before: np.ndarray) -> Fitting:
        return Fitting(self._holds, self._sharing, self._impacts, at, before, self._soon)

    def _changes(self, at: Situation, before: np.ndarray, jumped: set[int]) -> list[Change]:
        """What is different from before."""
        s, word, found = self._s, self._holds.word, []
        old, new = (modes[s.relation_modes] for modes in (before, at.modes))
        made_jump = np.isin(s.relation_modes, list(jumped)) if jumped else False
        for k in np.flatnonzero((old != new) | made_jump).tolist():
            was, now = float(old[k]), float(new[k])
            if s.relation_modes[k] in jumped:
                was, now = 0.0, 1.0
            name, text = s.relation_text(k, was)
            found.append(Change(name, text, s.relation_text(k, now)[1]))
        changed = (self._holds.parts(before) != self._holds.parts(at.modes)).any(axis=0)
        changed[list(at.losses)] = True
        for h in np.flatnonzero(changed).tolist():
            words = word(before, h), word(at.modes, h)
            found.append(Change(s.names[h], *words, at.losses.get(h, 0.0)))
        return found
