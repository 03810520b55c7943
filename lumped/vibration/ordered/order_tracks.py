"""Orders of a quantity over the speed, from a run with rising or falling speed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Unpack

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import Units, choose_units, display, speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.ordered.order_analysis import rising_angle
from lumped.vibration.pictures import order_tracks_picture

_SAMPLES = 16
"""Samples for each period of the highest order."""
_POINTS = 10
"""Points of a run for each such period, between which a cubic spline errs by less than 1e-3."""


_NEAR = 0.2
"""Share of a step of the map within which a maximum counts as lying on it; in the passage through
a resonance the phase turns, which moves the maximum."""

_LEAST = 0.01
"""Share of the largest amplitude below which a maximum is none."""


@dataclass(frozen=True, eq=False)
class OrderTracks(RichHtml):
    """Amplitudes of the orders of a quantity in windows along a run.

    Attributes
    ----------
    name, of, shaft, unit : str
        The model, the quantity, the angle over which orders count, and the unit of the quantity.
    times, angles, speeds : ndarray, shape (k,)
        Middle of each window: time, s, angle, rad, and mean speed there, rad/s.
    turns : int
        Length of a window.
    overlap : float
        Share of a window that the next one has too.
    most : float
        Highest order.
    samples : ndarray, shape (k, s)
        The quantity at equal steps of the angle, without its mean and trend in each window.
    """

    name: str
    of: str
    shaft: str
    unit: str
    times: Real
    angles: Real
    speeds: Real
    turns: int
    overlap: float
    most: float
    samples: Real

    @property
    def rpm(self) -> Real:
        """Speeds in turns for each minute, shape (k,)."""
        return self.speeds * 30 / np.pi

    @property
    def orders(self) -> Real:
        """Orders of the map, a step of one period for each window apart, shape (o,)."""
        return np.arange(1, round(self.most * self.turns) + 1) / self.turns

    @cached_property
    def values(self) -> Complex:
        """Amplitudes at `orders`, shape (k, o); see `track` for their phase."""
        return self._at(self.orders)

    @checked
    def track(self, order: float) -> Complex:
        """Amplitude of any order, shape (k,).

        The quantity is ``Re(amplitude exp(j order angle))`` in each window, with the angle of the
        shaft from where it is zero, counted in the sense of rotation.

        Raises
        ------
        OptionError
            If the order lies below two periods for each window, or above the highest order.
        """
        if not 2 / self.turns <= order <= self.most:
            raise OptionError(
                f"{self.name}: order {order:g} must lie between {2 / self.turns:g}, two periods "
                f"in a window of {self.turns} turns, and {self.most:g}; change turns= or most=."
            )
        return self._at(np.array([order]))[:, 0]

    def _at(self, orders: Real) -> Complex:
        count = self.samples.shape[1]
        place = (np.arange(count) + 0.5) / count - 0.5
        weight = (1 + np.cos(2 * np.pi * place)) / count
        turned = np.exp(-2j * np.pi * self.turns * orders[None, :] * place[:, None])
        found: Complex = 2 * (self.samples * weight) @ turned
        found *= np.exp(-1j * orders[None, :] * self.angles[:, None])
        return found

    @checked
    def largest(self, count: int = 6) -> tuple[float, ...]:
        """Orders whose greatest amplitude exceeds that of both neighbours, and 1 % of the largest.

        Returns
        -------
        tuple of float
            The `count` greatest of them, ascending.
        """
        size = np.abs(self.values).max(axis=0)
        inner = np.append(np.append(0.0, size), 0.0)
        tops = (size > inner[:-2]) & (size >= inner[2:]) & (self.orders >= 2 / self.turns)
        tops &= size > _LEAST * size.max(initial=0.0)
        places = np.flatnonzero(tops)
        kept = places[np.argsort(-size[places], kind="stable")[:count]]
        return tuple(sorted(self._top(order) for order in self.orders[kept].tolist()))

    def _top(self, order: float) -> float:
        """Place of a maximum between the orders of the map, or its order if that is nearest."""
        step = 1 / self.turns
        found = scipy.optimize.minimize_scalar(
            lambda o: -np.abs(self._at(np.array([o]))).max(),
            bounds=(max(order - step, 2 * step), min(order + step, self.most)),
            method="bounded",
            options={"xatol": 1e-4 * step},
        ).x
        return order if abs(found - order) < _NEAR * step else float(found)

    @checked
    def plot(
        self,
        orders: Iterable[float] | None = None,
        *,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Amplitudes over speed and order as a colour map, and those of some orders as curves.

        Parameters
        ----------
        orders : iterable of float, optional
            Orders to draw as curves; default is the six largest.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows, and 1/min
            for speeds.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        wanted = self.largest() if orders is None else tuple(orders)
        choice = choose_units(units, ("speed", self.of))
        to_show = display(self.of, self.unit, choice, is_change=True)
        tracks = {f"order {o:.5g}": to_show.value(np.abs(self.track(o))) for o in wanted}
        size, speed = to_show.value(np.abs(self.values)), speed_unit(choice)
        title = f"{self.name}: {self.of}"
        picture = order_tracks_picture(
            title, self.speeds, self.orders, size, tracks, to_show.unit, speed
        )
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        speed = speed_unit()
        low, high = speed.value(self.speeds.min()), speed.value(self.speeds.max())
        head = (
            f"{self.name}: {self.of} in {len(self.times)} windows of {self.turns} turns of "
            f"{self.shaft} (Hann), overlap {self.overlap:.0%}, {low:.5g} to {high:.5g} {speed.unit}"
        )
        rows = []
        for order in self.largest():
            size = np.abs(self.track(order))
            k = int(size.argmax())
            told = amounts(self.of, self.unit, size[k], is_change=True)
            rows.append((f"{order:.5g}", *told, number(speed.value(self.speeds[k]))))
        columns = ("order", "largest amplitude", "unit", f"at, {speed.unit}")
        return f"{head}\n" + table(columns, rows)


@checked
def order_tracks(
    run: Trajectory,
    of: Name,
    *,
    shaft: Name,
    most: float = 12.0,
    turns: int = 8,
    overlap: float = 0.75,
) -> OrderTracks:
    """Orders of a quantity over the speed, from a run up or down.

    The quantity is taken at equal steps of the angle, by a cubic spline, in windows that move along
    the run. In each of them its mean and trend are taken away, and Hann's window weights the rest.
    Orders that are `2 / turns` or more apart do not disturb each other. Where the vibration changes
    within a window, as in the passage through a resonance, the amplitude is a weighted mean.

    Parameters
    ----------
    run : Trajectory
        With ten points or more for each period of the highest order.
    of : name
        The quantity.
    shaft : name
        The angle of the shaft from which orders count, rad; it must rise or fall throughout.
    most : float
        Highest order. What vibrates with more than fifteen times this order is taken for a lower
        one.
    turns : int
        Length of a window: the more turns, the finer the orders and the coarser the speeds.
    overlap : float
        Share of a window that the next one has too.

    Returns
    -------
    OrderTracks

    Raises
    ------
    OptionError
        If the run has fewer turns than a window, the angle turns back, or the grid is too coarse.

    Notes
    -----
    Source: Fyfe and Munck, Analysis of Computed Order Tracking, Mechanical Systems and Signal
    Processing 11 (1997), for the resampling.
    """
    if turns < 3:
        raise OptionError(f"order_tracks: turns = {turns}: at least 3 turns are needed.")
    if not 0 <= overlap < 1:
        raise OptionError(f"order_tracks: overlap = {overlap:g} must be at least 0 and below 1.")
    if not most * turns >= 2:
        raise OptionError(f"order_tracks: most = {most:g}: give the highest order, such as 12.")
    angle, value, rising = rising_angle(run, of, shaft, "order_tracks")
    angle, value, t = angle[rising], value[rising], run.t[rising]
    length = 2 * np.pi * turns
    if len(angle) < 4 or angle[-1] - angle[0] < length:
        raise OptionError(
            f"order_tracks: {shaft} makes {(angle[-1] - angle[0]) / (2 * np.pi):.4g} turns; a "
            f"window has {turns}. Run longer, or give fewer turns=."
        )
    coarse = float(np.diff(angle).max())
    if coarse * most * _POINTS > 2 * np.pi * (1 + 1e-6):
        raise OptionError(
            f"order_tracks: {2 * np.pi / coarse:.4g} points a turn of {shaft} are too few for the "
            f"order {most:g}; run with a grid of at least {_POINTS * most:g} points a turn at the "
            "highest speed, or lower most=."
        )
    step = length * (1 - overlap)
    begins = angle[0] + step * np.arange(1 + int((angle[-1] - angle[0] - length) / step + 1e-9))
    count = int(np.ceil(_SAMPLES * most * turns))
    place = (np.arange(count) + 0.5) / count
    places = begins[:, None] + length * place
    samples = scipy.interpolate.CubicSpline(angle, value)(places)
    weight = (1 - np.cos(2 * np.pi * place)) / count
    samples -= (samples @ weight)[:, None]
    ramp = place - 0.5
    samples -= (samples @ (weight * ramp))[:, None] * ramp / (weight @ ramp**2)
    clock = scipy.interpolate.CubicSpline(angle, t)
    middle = begins + length / 2
    system = run.system
    return OrderTracks(
        system.name,
        system.key(of),
        system.key(shaft),
        system.quantity(of).unit,
        clock(middle),
        middle,
        1 / (clock(places, 1) @ weight),
        turns,
        overlap,
        float(most),
        samples,
    )
