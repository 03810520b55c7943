"""Constraints that are redundant share what they carry."""

from __future__ import annotations

import numpy as np

from lumped.timeloop.holds import STUCK, Holds

__all__ = ["Sharing"]

_COMPLIANCE = 1e-9
"""Of redundant constraints, relative to the compliance of what they hold."""

_ASKED = 64
"""Holds, evenly chosen, that are asked for the compliance of what they hold."""


class Sharing:
    """Lets the redundant holds of a system yield a little.

    Parameters
    ----------
    holds : Holds
        Of the system, with one set of parameters.
    """

    def __init__(self, holds: Holds) -> None:
        self._holds = holds
        self._yielding: float | None = None
        self._known: dict[bytes, bool] = {}

    def share(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> None:
        """Let redundant constraints yield a little; the stronger one carries more."""
        holds = self._holds
        modes[holds.compliances] = 0.0
        stuck = holds.parts(modes)[STUCK]
        # what is independent remains so if some of it lets go
        if not stuck.any() or not self._redundant(t, x, modes, guess, np.ones_like(stuck)):
            return
        if not self._redundant(t, x, modes, guess, stuck):
            return
        if self._yielding is None:
            self._yielding = _COMPLIANCE * self._softest(t, x, modes, guess)
        modes[holds.compliances] = self._yielding
        look = holds.look(t, x, modes, guess)
        reach = np.minimum(np.abs(look.upper), np.abs(look.lower))
        finite = np.isfinite(reach) & (reach > 0)
        largest = reach[finite].max(initial=0.0)
        weight = np.where(finite & (largest > 0), largest / np.where(finite, reach, 1.0), 1.0)
        modes[holds.compliances] *= np.minimum(weight, 1e3)

    def _redundant(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray, stuck: np.ndarray
    ) -> bool:
        """Whether these cannot be given any accelerations that one likes if they stick."""
        key = stuck.tobytes()
        if key not in self._known:
            holds, trial = self._holds, modes.copy()
            holds.put(trial, stuck, STUCK)
            rest = holds.look(t, x, trial, guess)
            wanted = np.random.default_rng(4).uniform(0.5, 1.5, len(stuck))
            trial[holds.demands] = wanted
            look = holds.look(t, x, trial, guess)
            with np.errstate(invalid="ignore"):  # reactions are infinite where they are redundant
                error = np.abs(look.a - rest.a - wanted)[stuck].max(initial=0.0)
                finite = np.isfinite(look.reaction - rest.reaction)[stuck].all()
            self._known[key] = not (finite and error < 1e-6)
        return self._known[key]

    def _softest(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> float:
        """How much acceleration a unit of force gives at most where a constraint acts."""
        holds, found = self._holds, 0.0
        alone, count = modes.copy(), len(holds.demands)
        alone[holds.compliances] = 0.0
        holds.put(alone, np.arange(count), None)
        for i in np.unique(np.linspace(0, count - 1, min(count, _ASKED)).astype(int)).tolist():
            holds.put(alone, i, STUCK)
            rest = holds.look(t, x, alone, guess)
            alone[holds.demands[i]] = 1.0
            with np.errstate(invalid="ignore"):  # infinite where a motion is prescribed
                force = abs(holds.look(t, x, alone, guess).reaction[i] - rest.reaction[i])
            alone[holds.demands[i]] = 0.0
            holds.put(alone, i, None)
            if np.isfinite(force) and force > 0:
                found = max(found, 1.0 / force)
        return found or 1.0
