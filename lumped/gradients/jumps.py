"""Derivatives across one instant of a run: of one change, and of several in every order."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lumped.gradients.state_changes import Act, Entries

Side = tuple[np.ndarray, np.ndarray]
"""States and settings on one side of an instant."""


class EventDerivatives(NamedTuple):
    """Derivatives at an instant ``t(x, p)`` at which something changes; its own are `instant`.

    Sensitivities S become ``states S + parameters + drift t_p``. Leine and Nijmeijer, Dynamics and
    Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7.

    Attributes
    ----------
    states, parameters : Entries, shapes (n, n) and (n, p)
        Of the states after it by those before it and by the parameters.
    drift : ndarray, shape (n,)
        What a later instant adds to the states: ``g_x f_before + g_t - f_after``.
    instant : ndarray, shape (n + p,)
        Derivatives of the instant by states and parameters; zero if it is fixed.
    names : tuple of str
        Components that change.
    shared : bool
        Statically indeterminate constraints let go; the derivatives hold their shares fixed.
    before, after : tuple of ndarray
        States and settings on both sides.
    act : Act
        The `when` statements, and what closes at a speed.
    settles : bool
        A gap closes to rest after ever smaller bounces.
    used, modes : tuple of int
        Margins that are used up, and what changes with them.
    """

    states: Entries
    parameters: Entries
    drift: np.ndarray
    instant: np.ndarray
    names: tuple[str, ...]
    shared: bool
    before: Side
    after: Side
    act: Act
    settles: bool = False
    used: tuple[int, ...] = ()
    modes: tuple[int, ...] = ()

    def forward(self, S: np.ndarray, seed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sensitivities after it, shape (n, k), and of the instant, (k,).

        Parameters
        ----------
        S, seed : ndarray, shapes (n, k) and (p, k)
            Derivatives of states and parameters by what is varied.
        """
        t_p = self.instant @ np.vstack([S, seed])
        own = self.states.times(S) + self.parameters.times(seed)
        return own + np.outer(self.drift, t_p), t_p

    def backward(self, adjoint: np.ndarray, late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The transposed: adjoints before it and what it adds by parameters.

        Parameters
        ----------
        adjoint : ndarray, shape (n, k)
            Derivatives of k results by the states after it.
        late : ndarray, shape (k,)
            Derivatives of the results by the instant itself.
        """
        n = len(self.drift)
        weight = self.drift @ adjoint + late
        before, by_parameters = (v.multiply_transposed(adjoint) for v in self[:2])
        by_states, by_others = self.instant[:n, None], self.instant[n:, None]
        return before + by_states * weight, by_parameters + by_others * weight


Part = tuple[EventDerivatives, np.ndarray, np.ndarray]
"""A jump, the derivatives of its instant, and those by which integrals gain."""


class Passed(NamedTuple):
    """Sensitivities after an instant, and those of the instants of its parts, shape (k,) each.

    Attributes
    ----------
    S : ndarray, shape (n, k)
        Sensitivities.
    parts : list
        Jumps and derivatives of their instants.
    gains : list
        The same in every order, with those of the order that each column takes.
    """

    S: np.ndarray
    parts: list[Part]
    gains: list[Part]


class Crossing(NamedTuple):
    """What happens at one instant, in every order in which its parts can come.

    Attributes
    ----------
    t : float
        Instant, s.
    orders : tuple of tuple of EventDerivatives
        Jumps one after the other; several orders if different causes coincide; none if all that
        happens is part of the next crossing, at the same instant.
    """

    t: float
    orders: tuple[tuple[EventDerivatives, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Components that change."""
        return tuple(dict.fromkeys(n for order in self.orders[:1] for j in order for n in j.names))

    def forward(self, S: np.ndarray, seed: np.ndarray, side: int) -> Passed:
        """Sensitivities after it.

        Parameters
        ----------
        side : {1, -1}
            Whether what is varied grows or shrinks, which decides what comes first.
        """
        S_new, parts = self._follow(self.orders[0], S, seed)
        if len(self.orders) == 1:
            return Passed(S_new, parts, parts)
        chosen = np.zeros(S.shape[1], dtype=bool)
        every = []
        for order in self.orders:
            after, own = self._follow(order, S, seed)
            times = side * np.array([slopes for _, slopes, _ in own])
            rounding = 1e-9 * np.abs(times).max(axis=0)
            fits = (np.diff(times, axis=0) >= -rounding).all(axis=0) & ~chosen
            chosen |= fits
            S_new[:, fits] = after[:, fits]
            # integrals gain by this order for its own columns only
            every += [(jump, slopes, np.where(fits, slopes, 0.0)) for jump, slopes, _ in own]
            for i, (jump, slopes, gained) in enumerate(parts):
                same = next(s for j, s, _ in own if j.names == jump.names)
                parts[i] = jump, np.where(fits, same, slopes), gained
        return Passed(S_new, parts, every)

    @staticmethod
    def _follow(
        order: tuple[EventDerivatives, ...], S: np.ndarray, seed: np.ndarray
    ) -> tuple[np.ndarray, list[Part]]:
        parts = []
        for jump in order:
            S, t_p = jump.forward(S, seed)
            parts.append((jump, t_p, t_p))
        return S, parts
