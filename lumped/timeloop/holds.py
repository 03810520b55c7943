"""Holds of a system: their modes read and written, and what decides modes at a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lumped.compiler.switching import Switching
from lumped.compiler.system import System
from lumped.kernel.instants.holds import STANDSTILL
from lumped.support.made_once import made_once
from lumped.timeloop.plants.executable import evaluate_at


class HoldValues(NamedTuple):
    """What decides modes at one point.

    Attributes
    ----------
    greater, less : ndarray, shape (r,)
        Sides of the conditions.
    v, a, reaction, upper, lower, gap, restitution : ndarray, shape (h,)
        Quantities of the holds; limits that are not given are infinite.
    values : ndarray
        New values of all jumps.
    rates : ndarray, shape (n,)
        Derivatives of the states.
    """

    greater: np.ndarray
    less: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    reaction: np.ndarray
    upper: np.ndarray
    lower: np.ndarray
    gap: np.ndarray
    restitution: np.ndarray
    values: np.ndarray
    rates: np.ndarray


@made_once
def _places(system: System) -> np.ndarray:
    """State that each speed is, or -1."""
    place = {node: i for i, node in enumerate(system.structure.states)}
    return np.array([place.get(node, -1) for node in system.switching.speeds], dtype=int)


class Holds:
    """The holds of a system with one set of parameters."""

    def __init__(self, system: System, theta: np.ndarray) -> None:
        s = self.switching = system.switching
        self.system, self._theta = system, theta
        self._places = _places(system)
        self._are_states = self._places >= 0
        self._parts = s.first_modes + np.arange(3)[:, None]
        self._speed_uses = system.speed_uses

    def look(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> HoldValues:
        """Evaluate everything that decides modes."""
        settings = np.concatenate([modes, guess])
        row = evaluate_at(self.system, "look", x, self._theta, t, settings)
        places = self.switching.places_needed
        needed = {name: row[place] for name, place in places.items()}
        needed["upper"][~self.switching.has_upper] = np.inf
        needed["lower"][~self.switching.has_lower] = -np.inf
        return HoldValues(**needed, rates=row[places["values"].stop :])

    def parts(self, modes: np.ndarray) -> np.ndarray:
        """Which are stuck, forward, backward; shape (3, h)."""
        return modes[self._parts] > 0.5

    def rounding(self, x: np.ndarray) -> np.ndarray:
        """Speeds that may be rounding of the states that they depend on."""
        size = np.zeros(len(self.switching.speeds))
        holds, states = self._speed_uses
        np.maximum.at(size, holds, np.abs(x[states]))
        return STANDSTILL * (1.0 + size)

    def stop(self, x: np.ndarray, which: np.ndarray) -> None:
        """Make speeds exactly zero where they are states."""
        x[self._places[which & self._are_states]] = 0.0

    def word(self, modes: np.ndarray, hold: int) -> str:
        """Mode of a hold in words."""
        stuck, forward, backward = modes[self._parts[:, hold]] > 0.5
        words = hold_words(self.switching, hold)
        return words[0 if stuck else 1 if forward else 2 if backward else 3]


def turn_condition(
    system: System, x: np.ndarray, theta: np.ndarray, t: float, settings: np.ndarray, number: int
) -> np.ndarray:
    """Settings with one condition changed: to its contrary, or to the next piece at hand."""
    s, found, run = system.switching, settings.copy(), 0.0
    if s.is_table[number]:
        row = evaluate_at(system, "look", x, theta, t, settings)
        greater, less = (row[s.places_needed[side]][number] for side in ("greater", "less"))
        run = float(greater - less)
    s.turn(found, number, run)
    return found


def hold_words(switching: Switching, hold: int) -> tuple[str, str, str, str]:
    """Words for a hold that is stuck, slides forward or backward, or is free."""
    own = ("closed", "open") if switching.has_gap[hold] else ("stuck", "forward")
    sticks, slides, free = switching.words[hold] or (*own, "free")
    return sticks, slides, "backward", free
