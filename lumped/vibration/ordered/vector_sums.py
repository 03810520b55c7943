"""Vector sums of the orders of an engine in its modes: the phase diagrams of the firing order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.natural.modes import Modes
from lumped.vibration.pictures import phase_diagrams_picture

_MOST_SHOWN = 24


@dataclass(frozen=True, eq=False)
class VectorSums(RichHtml):
    """Sums of the relative amplitudes of cylinders with the phases of an order, for each mode.

    Attributes
    ----------
    modes : Modes
        Whose shapes count.
    names : tuple of str
        Angles at which the cylinders act.
    phases : ndarray, shape (c,)
        Angles of the shaft at which their cycles begin, rad.
    orders : ndarray, shape (o,)
        Periods for each turn.
    vectors : ndarray of complex, shape (k, o, c)
        Relative amplitude of each cylinder in each mode, turned by ``-order phase``.
    """

    modes: Modes
    names: tuple[str, ...]
    phases: Real
    orders: Real
    vectors: Complex

    @property
    def values(self) -> Complex:
        """Vector sums, shape (k, o)."""
        found: Complex = self.vectors.sum(axis=2)
        return found

    @property
    def critical_rpm(self) -> Real:
        """Speeds at which an order excites a mode, 1/min, shape (k, o)."""
        return 60 * self.modes.hertz[:, None] / self.orders

    @checked
    def plot(self, mode: int = 0, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Phase diagram of each order in a mode: its vectors and their sum.

        Parameters
        ----------
        mode : int
            Its number, from 0.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If there is no such mode.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        self.modes.check_mode(mode, "vector_sums")
        frequency = frequency_unit(choose_units(units, ("frequency", *self.modes.system.names())))
        told = f"{frequency.value(self.modes.hertz[mode]):.4g} {frequency.unit}"
        title = f"{self.modes.system.name}: {told}"
        labels = [str(i + 1) for i in range(len(self.names))]
        captions = [f"order {order:g}" for order in self.orders]
        picture = phase_diagrams_picture(title, labels, self.vectors[mode], captions)
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        size = np.abs(self.values)
        head = (
            f"{self.modes.system.name}: vector sums of {len(self.names)} cylinders, the largest "
            f"amplitude of each mode being 1"
        )
        rows = [
            (f"{order:g}", *(number(v, 4) for v in size[:6, o]))
            for o, order in enumerate(self.orders[:_MOST_SHOWN])
        ]
        frequency = frequency_unit()
        told = frequency.value(self.modes.hertz[:6])
        columns = ("order", *(f"{value:.4g} {frequency.unit}" for value in told))
        return f"{head}\n" + table(columns, rows)


@checked
def vector_sums(
    modes: Modes, phases: Mapping[Name, float], *, orders: Iterable[float]
) -> VectorSums:
    """Vector sums of orders: ``sum_i shape_i exp(-j order phase_i)`` for each mode.

    Cylinders with equal torques that act at the angles of a mode do work in proportion to this sum,
    so an order whose sum is large is a major one of that mode.

    Parameters
    ----------
    modes : Modes
        From `modes` or `mean_modes`.
    phases : mapping of name to float
        Angle at which each cylinder acts (``"engine.throw[0].phi"``), and that of the shaft at
        which its cycle begins, rad (`Engine.phases`). Two cylinders on a throw act at different
        names of the same angle (``"engine.cylinder[3].flange.phi"``).
    orders : iterable of float
        Periods for each turn.

    Returns
    -------
    VectorSums

    Raises
    ------
    OptionError
        If an order is not positive, a phase is not finite, or there is no cylinder or mode.
    UnknownNameError
        If a name does not exist.

    Notes
    -----
    Source: Nestorides, A Handbook on Torsional Vibration (1958), phase vector sums.
    """
    chosen = np.array([float(order) for order in orders])
    if not len(chosen) or not (chosen > 0).all():
        raise OptionError("vector_sums: orders must be positive periods for each turn.")
    if not phases:
        raise OptionError(
            "vector_sums: name the angles at which cylinders act, and their phases, such as "
            '{"engine.throw[0].phi": 0.0}.'
        )
    if not len(modes.hertz):
        raise OptionError(f"{modes.system.name}: no oscillating mode.")
    names = tuple(modes.system.key(name) for name in phases)
    angles = np.array(list(phases.values()), dtype=float)
    if not np.isfinite(angles).all():
        raise OptionError("vector_sums: the phases must be finite, in rad.")
    shapes = np.array([modes.shape(name) for name in names]).T
    turned = np.exp(-1j * chosen[:, None] * angles)
    return VectorSums(modes, names, angles, chosen, shapes[:, None, :] * turned)
