"""Natural frequencies that stay above or below orders of excitation over a range of speeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lumped.functionals.readings import Separation
from lumped.vibration.speeds.mean_campbell import speeds_that_show
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum

Real = NDArray[np.float64]
Spectra = Callable[[Real, Real], Sequence[MeanSpectrum]]
"""Spectra of a design, by its unknowns, at speeds, rad/s."""

_CROSSED = 1e-9
"""Share of an order's frequency by which a mode may be on the wrong side of it."""
WIDEST = 0.95
"""Largest separation."""


class Apart:
    """The modes of a design beside the orders of a `Separation`.

    A mode is above or below an order at all speeds of operation and a margin beyond; what counts is
    ``side (2 pi f(n) / (order n) - 1)`` at speeds ``n = a + share (b - a)`` between the ends
    ``a = low (1 - margin)`` and ``b = high (1 + margin)``. Only some are watched: those of the
    least values, to which `extend` adds.

    Parameters
    ----------
    key : Separation
        What is asked for.
    spectra : callable
        See `Spectra`.
    w : ndarray
        Unknowns at the start, where the sides are chosen.
    margin : float
        The margin there.
    """

    def __init__(self, key: Separation, spectra: Spectra, w: Real, margin: float) -> None:
        self.key, self.spectra = key, spectra
        self.orders = np.array(key.orders)
        speeds, hertz = self._all(w, margin)
        away = self._away(speeds, hertz)
        self.sides = np.where(away.min(axis=0) >= (-away).min(axis=0), 1.0, -1.0)
        least = self.sides * away
        wrong = least.min(axis=0) <= max(float(least.min()), 0.0)
        self.watched = [
            (o, mode, self._share(speeds[least[:, o, mode].argmin()], margin))
            for o, mode in np.argwhere(wrong).tolist()
        ]

    def rows(self, w: Real, margin: float) -> list[tuple[float, Real, float, str]]:
        """What must not be negative: value, derivatives by all parameters and by the margin."""
        begin, end = self._ends(margin)
        low, high = self.key.between
        shares = np.array([share for _, _, share in self.watched])
        speeds = begin + shares * (end - begin)
        found = []
        for (o, mode, share), speed, spectrum in zip(
            self.watched, speeds.tolist(), self.spectra(w, speeds), strict=True
        ):
            order, side = self.orders[o], self.sides[o, mode]
            factor = side * 2 * np.pi / (order * speed)
            hertz = float(spectrum.hertz[mode])
            moved = share * (high + low) - low
            by_margin = factor * (spectrum.hertz_by_speed(mode) - hertz / speed) * moved
            text = (
                f"{self.key}: mode {mode} at {speed * 30 / np.pi:.6g} 1/min = {hertz:.6g} Hz, at "
                f"{'least' if side > 0 else 'most'} {order * speed / (2 * np.pi):.6g}"
            )
            found.append((factor * hertz - side, factor * spectrum.hertz_by(mode), by_margin, text))
        return found

    def extend(self, w: Real, margin: float) -> bool:
        """Watch the speeds, too, at which a design is on the wrong side; whether there are any."""
        speeds, hertz = self._all(w, margin)
        least = self.sides * self._away(speeds, hertz)
        new = [
            (o, mode, self._share(speeds[least[:, o, mode].argmin()], margin))
            for o, mode in np.argwhere(least.min(axis=0) < -_CROSSED).tolist()
        ]
        new = [each for each in new if each not in self.watched]
        self.watched += new
        return bool(new)

    def _ends(self, margin: float) -> tuple[float, float]:
        low, high = self.key.between
        return low * (1 - margin), high * (1 + margin)

    def _share(self, speed: float, margin: float) -> float:
        begin, end = self._ends(margin)
        return (speed - begin) / (end - begin) if end > begin else 0.0

    def _all(self, w: Real, margin: float) -> tuple[Real, Real]:
        """Speeds that show on which side the modes are, and the frequencies there."""

        def rows(speeds: Real) -> Real:
            return np.array([each.hertz for each in self.spectra(w, speeds)])

        speeds = speeds_that_show(rows, *self._ends(margin), list(self.key.orders))
        return speeds, rows(speeds)

    def _away(self, speeds: Real, hertz: Real) -> Real:
        """Distance of frequencies from orders, shape (speeds, orders, modes)."""
        found: Real = 2 * np.pi * hertz[:, None] / (speeds[:, None] * self.orders)[..., None] - 1
        return found
