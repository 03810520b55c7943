"""Amplitudes of quantities of a drive that turns, order by order over the speed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.by_name import ByName, find_place
from lumped.support.display_units import Units, choose_units, display, speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.pictures import order_response_picture


@dataclass(frozen=True, eq=False)
class OrderAmplitudes(ByName, RichHtml):
    """Complex amplitudes of quantities; ``found[name]`` has the shape (speeds, orders).

    A quantity vibrates as ``sum Re(amplitude exp(j order angle))``, with the angle of the shaft
    from which orders count.

    Attributes
    ----------
    system : System
        What vibrates.
    speeds : ndarray, shape (k,)
        Speeds of the shaft from which orders count, rad/s.
    orders : ndarray, shape (o,)
        Periods for each turn, ascending.
    of : tuple of str
        Names.
    values : ndarray of complex, shape (k, o, len(of))
        Amplitudes.
    means : ndarray, shape (k, len(of))
        Means over the turns.
    """

    system: System
    speeds: Real
    orders: Real
    of: tuple[str, ...]
    values: Complex
    means: Real

    @checked
    def __getitem__(self, of: Name) -> Complex:
        return self.values[:, :, self._place(of)]

    @property
    def notes(self) -> tuple[str, ...]:
        """What it knows of its own accuracy, which all that is made of it tells."""
        return ()

    @property
    def rpm(self) -> Real:
        """Speeds in turns for each minute, shape (k,)."""
        return self.speeds * 30 / np.pi

    @checked
    def mean(self, of: Name) -> Real:
        """Mean of a quantity over the turns, shape (k,)."""
        return self.means[:, self._place(of)]

    @checked
    def magnitude(self, of: Name, order: float) -> Real:
        """Amplitude of one order, shape (k,).

        Raises
        ------
        OptionError
            If the order was not computed.
        """
        return np.abs(self[of][:, self._order(order)])

    @checked
    def phase(self, of: Name, order: float) -> Real:
        """Phase of one order against the angle of the shaft, rad, shape (k,)."""
        return np.angle(self[of][:, self._order(order)])

    @checked
    def synthesis(self, of: Name, *, orders: Iterable[float] | None = None) -> Synthesis:
        """All orders together over a cycle.

        Parameters
        ----------
        of : name
            The quantity.
        orders : iterable of float, optional
            Orders that take part; default is all.

        Returns
        -------
        Synthesis
            Its maximum, half range and sum of amplitudes over the speed.
        """
        chosen = range(len(self.orders)) if orders is None else [self._order(o) for o in orders]
        places = sorted(set(chosen))
        key = self.of[self._place(of)]
        return Synthesis(
            key,
            self.system.quantity(key).unit,
            self.speeds,
            self.orders[places],
            self[of][:, places],
        )

    @checked
    def plot(
        self,
        of: Iterable[Name] | None = None,
        *,
        most: int = 6,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Largest orders and their synthesis over the speed, a panel for each quantity.

        Parameters
        ----------
        of : iterable of names, optional
            Outputs to draw; default is all.
        most : int
            Orders to draw in each panel, the largest.
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
        wanted = self.of if of is None else [self.system.key(name) for name in of]
        if not wanted:
            raise OptionError(f"{self.system.name}: name at least one quantity to draw.")
        choice = choose_units(units, ("speed", *self.system.names()))
        drawn = {}
        for of in wanted:
            to_show = display(of, self.system.quantity(of).unit, choice, is_change=True)
            size = to_show.value(np.abs(self[of]))
            order = np.argsort(-size.max(axis=0), kind="stable")[:most]
            curves = {f"order {self.orders[o]:g}": size[:, o] for o in sorted(order.tolist())}
            if len(self.orders) > 1:
                curves["half range"] = to_show.value(self.synthesis(of).half_range)
            drawn[of] = to_show.unit, curves
        left = len(self.orders) - most
        note = f"{left} smaller: choose with most=" if left > 0 else ""
        title = "; ".join([self.system.name, *self.notes])
        picture = order_response_picture(title, self.speeds, drawn, speed_unit(choice), note)
        return draw(picture, **canvas)

    def _names(self) -> tuple[str, ...]:
        return self.of

    def _place(self, of: Name) -> int:
        return find_place(self.system.key(of), self.of, "is not observed in this response")

    def _order(self, order: float) -> int:
        found = np.flatnonzero(np.isclose(self.orders, order, rtol=1e-12, atol=0))
        if not len(found):
            listed = ", ".join(f"{o:g}" for o in self.orders[:12])
            raise OptionError(
                f"{self.system.name}: order {order:g} was not computed; computed are {listed}"
                f"{', ...' if len(self.orders) > 12 else ''}."
            )
        return int(found[0])

    def largest_orders(self) -> str:
        """A table of the largest order and the synthesis of each quantity."""
        rows, speed = [], speed_unit()
        for of in self.of:
            size, both = np.abs(self[of]), self.synthesis(of)
            k, o = np.unravel_index(int(size.argmax()), size.shape)
            top = int(both.half_range.argmax())
            *sizes, unit = amounts(
                *(of, self.system.quantity(of).unit, size[k, o], both.half_range[top]),
                is_change=True,
            )
            at = [number(speed.value(self.speeds[i])) for i in (k, top)]
            rows.append((of, unit, f"{self.orders[o]:g}", at[0], sizes[0], at[1], sizes[1]))
        columns = (
            *("quantity", "unit", "largest order", f"at, {speed.unit}", "amplitude"),
            *(f"worst at, {speed.unit}", "half range"),
        )
        return table(columns, rows)
