"""Where natural frequencies meet orders of excitation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.plots.draw import Canvas, draw
from lumped.points.situation import situation
from lumped.points.start import point_at
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.display_units import Shown, Units, choose_units, frequency_unit, speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.modes import Modes
from lumped.vibration.speeds.campbell_picture import campbell_picture

Orders = Iterable[float] | Mapping[str, float]
"""Excitations for each turn of a shaft, or such by their labels."""
Labelled = tuple[tuple[str, float], ...]
"""Labels, which may be empty, and orders."""


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed at which an order of excitation meets a natural frequency.

    Attributes
    ----------
    speed : float
        Speed of the shaft from which the orders count, rad/s.
    order : float
        Excitations for each turn of that shaft.
    mode : int
        Number of the mode by natural frequency, from 0.
    hertz : float
        Natural frequency there, Hz.
    label : str
        What excites; empty if the order was given without a label.
    searched : tuple of float
        First and last speed between which it was looked for, rad/s.
    """

    speed: float
    order: float
    mode: int
    hertz: float
    label: str = ""
    searched: tuple[float, float] = (0.0, np.inf)

    @property
    def rpm(self) -> float:
        """The speed in turns for each minute."""
        return self.speed * 30 / np.pi


@dataclass(frozen=True)
class BarredRange:
    """Speeds that must be passed quickly.

    Attributes
    ----------
    begin, end : float
        First and last of them, rad/s.
    """

    begin: float
    end: float

    def __str__(self) -> str:
        return self.format_range(speed_unit())

    def format_range(self, speed: Shown) -> str:
        """The range as speeds are shown."""
        return f"{speed.value(self.begin):.5g} to {speed.value(self.end):.5g} {speed.unit}"


@dataclass(frozen=True, eq=False)
class Campbell(RichHtml):
    """Natural frequencies over the speed, and orders of excitation.

    Attributes
    ----------
    system : System
        What was analysed.
    speeds : ndarray, shape (k,)
        Speeds of the shaft from which the orders count, rad/s.
    hertz : ndarray, shape (k, m)
        Natural frequencies at each speed, ascending, Hz; nan where a mode no longer oscillates.
    orders : tuple of float
        Excitations for each turn.
    critical : tuple of CriticalSpeed
        Intersections, by speed.
    evaluations : int
        How often modes were computed.
    residual : float
        Largest ``abs(hertz - order speed / 2 pi)`` at an intersection, relative to `hertz`.
    situations : tuple of str
        What is open, closed, stuck, sliding or released at the operating points, in words.
    labels : tuple of str
        What excites with each order; empty where an order was given without a label.
    """

    system: System
    speeds: Real
    hertz: Real
    orders: tuple[float, ...]
    critical: tuple[CriticalSpeed, ...]
    evaluations: int
    residual: float
    situations: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()

    @checked
    def plot(
        self,
        *,
        between: tuple[float, float] | None = None,
        barred: Iterable[BarredRange] = (),
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Natural frequencies over the speed, rays of the orders, and points where they meet.

        Parameters
        ----------
        between : tuple of float, optional
            First and last speed of operation, rad/s, to shade.
        barred : iterable of BarredRange, optional
            Ranges to hatch, such as those of a verdict, `Verdict.barred`.
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
        choice = choose_units(units, ("speed", "frequency", *self.system.names()))
        picture = campbell_picture(
            self.system.name,
            self.speeds,
            self.hertz,
            list(zip(self.labels, self.orders, strict=True)),
            [(c.speed, c.hertz) for c in self.critical],
            between,
            [(each.begin, each.end) for each in barred],
            (speed_unit(choice), frequency_unit(choice)),
        )
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        head = (
            f"{self.system.name}: {len(self.critical)} critical speeds; modes at "
            f"{self.evaluations} speeds, intersections met to {self.residual:.1e}"
            f"{', or'.join(self.situations)}"
        )
        return f"{head}\n" + _table(self.critical)


def _table(critical: Iterable[CriticalSpeed]) -> str:
    speeds, frequency = dict.fromkeys((Shown("rad/s"), speed_unit())), frequency_unit()
    rows = [
        (
            *(number(speed.value(c.speed)) for speed in speeds),
            f"{number(c.order)} ({c.label})" if c.label else number(c.order),
            str(c.mode + 1),
            number(frequency.value(c.hertz)),
        )
        for c in critical
    ]
    first, *others = (speed.unit for speed in speeds)
    told = f"natural frequency, {frequency.unit}"
    return table((f"speed, {first}", *others, "order", "mode", told), rows)


@checked
def critical_speeds(modes: Modes, orders: Orders) -> tuple[CriticalSpeed, ...]:
    """Speeds at which orders of excitation meet natural frequencies: ``2 pi hertz / order``.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; they must not depend on the speed (else `campbell`).
    orders : iterable of float or mapping of str to float
        Excitations for each turn of the shaft, with labels in a mapping (`mesh_orders`): 1 for
        unbalance, the number of teeth for a mesh, the ratio times the order for a shaft behind a
        gear.

    Returns
    -------
    tuple of CriticalSpeed
        By speed.

    Raises
    ------
    OptionError
        If an order is not positive.
    """
    found = [
        CriticalSpeed(float(2 * np.pi * hertz / order), order, mode, float(hertz), label)
        for label, order in check_labels(orders)
        for mode, hertz in enumerate(modes.hertz)
    ]
    return tuple(sorted(found, key=lambda c: c.speed))


@checked
def campbell(
    system: System,
    *,
    speeds: ArrayLike,
    orders: Orders,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None = None,
) -> Campbell:
    """Natural frequencies over the speed of a shaft, and where orders of excitation meet them.

    Parameters
    ----------
    system : System
        From `assemble`.
    speeds : array_like, shape (k,)
        Ascending, rad/s.
    orders : iterable of float or mapping of str to float
        Excitations for each turn of the shaft, with labels in a mapping (`mesh_orders`).
    at : OperatingPoint or callable, optional
        Where to linearise; default is the start point. If frequencies depend on the speed, a
        function of it, such as ``lambda w: equilibrium(system, start={"motor.w": w})`` or
        ``lambda w: start_point(system, parameters={"bearing.c": stiffness(w)})``.

    Returns
    -------
    Campbell

    Raises
    ------
    OptionError
        If speeds are not ascending or an order is not positive.

    Notes
    -----
    Modes count by frequency. An intersection is located between two of the speeds to rounding;
    two of the same mode and order between the same two speeds are not seen.
    """
    grid = np.asarray(speeds, dtype=float).ravel()
    if len(grid) < 2 or grid[0] < 0 or (np.diff(grid) <= 0).any():
        raise OptionError("campbell: give at least two speeds, rad/s, ascending and not negative.")
    wanted = check_labels(orders)

    def modes_at(speed: float) -> Modes:
        point = point_at("campbell", system, at, speed) if callable(at) else at
        return modes(system, at=point)

    return diagram(system, grid, wanted, HertzOverSpeed(modes_at, varies=callable(at)))


class HertzOverSpeed:
    """Natural frequencies over the speed, computed once at each.

    Parameters
    ----------
    modes_at : callable
        Modes at a speed, rad/s.
    varies : bool
        Whether they depend on it.

    Attributes
    ----------
    situations : dict of str to None
        What was open, closed, stuck, sliding or released, in words.
    """

    def __init__(self, modes_at: Callable[[float], Modes], *, varies: bool) -> None:
        self._modes_at, self._varies = modes_at, varies
        self._known: dict[float, Real] = {}
        self.situations: dict[str, None] = {}

    def __call__(self, speed: float) -> Real:
        """Frequencies at a speed, ascending, Hz, shape (m,)."""
        place = float(speed) if self._varies else 0.0
        if place not in self._known:
            found = self._modes_at(place)
            self._known[place] = found.hertz
            self.situations[situation(found.point)] = None
        return self._known[place]

    def rows(self, speeds: Real) -> Real:
        """Frequencies at speeds, shape (k, m); nan where a mode does not oscillate."""
        rows = [self(speed) for speed in speeds.tolist()]
        found = np.full((len(rows), max(len(row) for row in rows)), np.nan)
        for line, row in zip(found, rows, strict=True):
            line[: len(row)] = row
        return found

    @property
    def evaluations(self) -> int:
        """How often modes were computed."""
        return len(self._known)


def diagram(system: System, grid: Real, wanted: Labelled, hertz_at: HertzOverSpeed) -> Campbell:
    """The diagram of frequencies; between two speeds a mode meets an order once at most."""
    hertz = hertz_at.rows(grid)

    def gap(speed: float, order: float, mode: int) -> float:
        return float(hertz_at(speed)[mode] - order * speed / (2 * np.pi))

    found, searched = [], (float(grid[0]), float(grid[-1]))
    for label, order in wanted:
        side = np.sign(hertz - order * grid[:, None] / (2 * np.pi))
        places = [(float(grid[k]), mode) for k, mode in np.argwhere(side == 0).tolist()]
        for k, mode in np.argwhere(side[:-1] * side[1:] < 0).tolist():
            ends, near = grid[k : k + 2], 1e-13 * grid[k + 1]
            root = scipy.optimize.brentq(gap, *ends, args=(order, mode), xtol=near)
            places.append((float(root), mode))
        for speed, mode in places:
            met = float(hertz_at(speed)[mode])
            found.append(CriticalSpeed(speed, order, mode, met, label, searched))
    found.sort(key=lambda c: c.speed)
    missed = [abs(c.order * c.speed / (2 * np.pi) / c.hertz - 1) for c in found]
    worst = float(max(missed, default=0.0))
    labels, values = zip(*wanted, strict=True)
    return Campbell(
        system,
        grid,
        hertz,
        values,
        tuple(found),
        hertz_at.evaluations,
        worst,
        tuple(hertz_at.situations),
        labels,
    )


def check_labels(orders: Orders) -> Labelled:
    """Labels and orders that make sense."""
    labels = orders if isinstance(orders, Mapping) else None
    try:
        values = [float(order) for order in (labels.values() if labels is not None else orders)]
    except (TypeError, ValueError):
        raise OptionError(
            f"orders = {orders!r}: excitations for each turn as a sequence of numbers are needed, "
            "such as [1, 2], or by their labels, such as {'propeller': 5}."
        ) from None
    for order in values:
        if not (np.isfinite(order) and order > 0):
            raise OptionError(f"order {order:g}: excitations for each turn must be positive.")
    if not values:
        raise OptionError("name at least one order of excitation.")
    return tuple(zip(labels or [""] * len(values), values, strict=True))
