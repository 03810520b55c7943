"""How long each level of a load lasts, and at which speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.life.equivalent_load import ROLLER, check_exponent
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import spectrum_picture
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.display_units import Units, choose_units, display
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class LoadSpectrum(RichHtml):
    """Levels of a load, each with its speed and how long it lasts.

    Attributes
    ----------
    loads : ndarray, shape (k,)
        Sizes of the load.
    speeds : ndarray, shape (k,)
        Sizes of the speed at each, the mean over its time, rad/s.
    times : ndarray, shape (k,)
        How long each lasts, s.
    unit : str
        Unit of the load.
    """

    loads: Real
    speeds: Real
    times: Real
    unit: str = "N.m"

    @classmethod
    @checked
    def of_steps(
        cls, loads: ArrayLike, *, speeds: ArrayLike, times: ArrayLike, unit: str = "N.m"
    ) -> LoadSpectrum:
        """The spectrum of given steps.

        Parameters
        ----------
        loads, speeds : array_like, shape (k,)
            Of each step; speeds in rad/s.
        times : array_like, shape (k,)
            How long each lasts, s; shares of the time do as well.
        unit : str
            Unit of the loads.

        Returns
        -------
        LoadSpectrum

        Raises
        ------
        OptionError
            If they differ in number, or a time is negative, or all are zero.
        """
        found = [np.abs(np.atleast_1d(np.asarray(part, dtype=float))) for part in (loads, speeds)]
        lasting = np.atleast_1d(np.asarray(times, dtype=float))
        shapes = {part.shape for part in (*found, lasting)}
        if len(shapes) > 1 or lasting.ndim != 1:
            raise OptionError(
                "of_steps: loads, speeds and times must be as many, one of each for a step."
            )
        if lasting.min(initial=0.0) < 0 or not lasting.any():
            raise OptionError("of_steps: times must not be negative, nor all zero.")
        return cls(found[0], found[1], lasting, unit)

    @property
    def duration(self) -> float:
        """Of all levels together, s."""
        return float(self.times.sum())

    @property
    def shares(self) -> Real:
        """Of the whole time, of each level, shape (k,)."""
        found: Real = self.times / self.times.sum()
        return found

    @property
    def mean_speed(self) -> float:
        """Speed of the same number of revolutions, rad/s: ``sum n_k a_k``."""
        return float(self.shares @ self.speeds)

    @checked
    def equivalent(self, *, exponent: float = ROLLER) -> float:
        """Constant load of the same damage: ``(sum P_k^p (n_k / n_m) a_k)^(1/p)``.

        Parameters
        ----------
        exponent : float
            p: 10/3 for roller bearings, 3 for ball bearings; for teeth the slope of their S-N
            curve.

        Raises
        ------
        OptionError
            If the exponent is not positive, or nothing turns.
        """
        check_exponent(exponent, "equivalent")
        turns = self.shares * self.speeds
        if not turns.sum() > 0:
            raise OptionError("equivalent: nothing turns: there is no mean over revolutions.")
        largest = self.loads.max()
        if not largest:
            return 0.0
        mean = (self.loads / largest) ** exponent @ turns / turns.sum()
        return float(largest * mean ** (1 / exponent))

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Share of the time and mean speed of each level.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If plotly is not installed, or `ax` does not fit.
        UnitError
            If a unit does not fit.
        """
        told = choose_units(units)
        load, speed = display("load", self.unit, told), display("speed", "rad/s", told)
        rows = [
            (f"{number(load.value(y), 5)} {load.unit}", a, f"{number(speed.value(w), 4)}")
            for y, a, w in zip(self.loads, self.shares, self.speeds, strict=True)
        ]
        return draw(spectrum_picture(rows, speed.unit), **canvas)

    def __repr__(self) -> str:
        rows = []
        for y, w, t, a in zip(self.loads, self.speeds, self.times, self.shares, strict=True):
            load, unit = amounts("load", self.unit, y)
            speed, speed_unit = amounts("speed", "rad/s", w)
            rows.append((load, unit or "-", speed, speed_unit, number(t, 4), f"{a:.1%}"))
        head = ("load", "unit", "mean speed", "unit", "time, s", "share")
        return table(head, rows)


@checked
def load_spectrum(run: Trajectory, of: tuple[Name, Name], *, classes: int = 10) -> LoadSpectrum:
    """How long each level of a load lasts in a run, and at which mean speed.

    Sizes of the load are put into classes of equal width from the least to the largest; each class
    has the mean load and the mean speed of its time. Between two output times both are taken as
    straight, so that no part of the time is lost; classes that the load leaves out are left out.

    Parameters
    ----------
    run : Trajectory
        From `simulate`.
    of : (name, name)
        Load, such as a torque, and speed of the shaft.
    classes : int
        Their number.

    Returns
    -------
    LoadSpectrum

    Raises
    ------
    OptionError
        If there is no class, or the run has no steps.
    UnknownNameError
        If a quantity does not exist.
    """
    if classes < 1:
        raise OptionError(f"load_spectrum: classes = {classes} must be at least 1.")
    if len(run.t) < 2 or run.t[-1] == run.t[0]:
        raise OptionError("load_spectrum: the run has no steps over which a load could last.")
    load, speed = (np.abs(run[name]) for name in of)
    step = np.diff(run.t)
    begin, rise = load[:-1], np.diff(load)
    edges = np.linspace(load.min(), load.max(), classes + 1)
    edges[-1] = np.inf  # the largest load belongs to the last class
    # where in each step the load is below an edge, from 0 to 1 along the rise
    flat = rise == 0
    passed = (edges - begin[:, None]) / np.where(flat, 1.0, rise)[:, None]
    below = np.where(
        flat[:, None],
        edges > begin[:, None],
        np.where(rise[:, None] > 0, np.clip(passed, 0, 1), 1 - np.clip(passed, 0, 1)),
    )
    below[:, 0] = 0.0
    share = np.diff(below, axis=1)
    middle = 0.5 * (below[:, 1:] + below[:, :-1])
    middle = np.where(rise[:, None] < 0, 1 - middle, middle)
    middle = np.where(flat[:, None], 0.5, middle)  # the whole step is in one class
    lasting = share * step[:, None]
    times = lasting.sum(axis=0)
    kept = times > 0
    means = [
        (lasting * (y[:-1, None] + np.diff(y)[:, None] * middle)).sum(axis=0)[kept] / times[kept]
        for y in (load, speed)
    ]
    return LoadSpectrum(means[0], means[1], times[kept], run.system.quantity(of[0]).unit)
