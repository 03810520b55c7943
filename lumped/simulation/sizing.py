"""What a run asks of a motor: peaks, thermal load, and the points on its torque-speed plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Unpack

import numpy as np

from lumped import ops
from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.functionals import (
    Functional,
    highest,
    lowest,
    mean,
    peak,
    rms,
)
from lumped.language.expression import Expr
from lumped.language.formula import Formula
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import torque_speed
from lumped.plots.picture import label_axis
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, display
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.support.units import plain
from lumped.timeloop.results.trajectory import Trajectory

Limit = float | Sequence[tuple[float, float]]
"""A torque for all speeds, or rows of speed and torque."""
_Given = float | str | Sequence[tuple[float | str, float | str]]
"""The same, each a number or a value with a unit."""


@dataclass(frozen=True)
class Load:
    """How far a limit is used.

    Attributes
    ----------
    ratio : float
        Torque over the limit at its speed; infinite beyond the greatest speed of the limit.
    speed, torque, limit : float
        At the output point where that is greatest.
    """

    ratio: float
    speed: float
    torque: float
    limit: float

    @property
    def fits(self) -> bool:
        """The limit is kept."""
        return self.ratio <= 1


@dataclass(frozen=True)
class Sizing(RichHtml):
    """What a run asks of a motor; torques in N.m and speeds in rad/s, or forces and m/s.

    Attributes
    ----------
    peak_torque, peak_speed : float
        Greatest magnitudes.
    rms_torque : float
        ``sqrt(1/T integral tau^2 dt)``: the constant torque with the same copper losses.
    mean_speed : float
        ``1/T integral |w| dt``.
    peak_power, peak_regeneration, mean_power : float
        Greatest mechanical power given and taken back, and the mean, W.
    thermal : Load or None
        The thermal equivalent, `rms_torque` at `mean_speed`, against the rated torque.
    peak : Load or None
        The point that comes nearest to the greatest torque, or goes farthest beyond it.
    units : tuple of str
        Units of torque and speed.
    points : tuple of ndarray, each of shape (k,)
        Speed and torque over the run.
    rated, maximum : float, rows of (speed, torque) or None
        The limits that were given, in `units`.
    """

    peak_torque: float
    peak_speed: float
    rms_torque: float
    mean_speed: float
    peak_power: float
    peak_regeneration: float
    mean_power: float
    thermal: Load | None
    peak: Load | None
    units: tuple[str, str]
    points: tuple[np.ndarray, np.ndarray] = field(repr=False, compare=False)
    rated: Limit | None = None
    maximum: Limit | None = None

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Torque over speed with the limits, and the thermal equivalent.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        turning = self.units[0] == "N.m"
        names = ("torque", "angular velocity") if turning else ("force", "speed")
        choice = choose_units(units, names)
        y, x = (display(name, unit, choice) for name, unit in zip(names, self.units, strict=True))

        def convert_limit(limit: Limit | None) -> Limit | None:
            if limit is None or isinstance(limit, float | int):
                return None if limit is None else y.value(float(limit))
            return [(x.value(float(w)), y.value(float(bound))) for w, bound in limit]

        speed, torque = self.points
        picture = torque_speed(
            (x.value(speed), y.value(torque)),
            (x.value(self.mean_speed), y.value(self.rms_torque)),
            convert_limit(self.rated),
            convert_limit(self.maximum),
            (label_axis(names[1], x.unit), label_axis(names[0], y.unit)),
        )
        return draw(picture, **canvas)

    @property
    def fits(self) -> bool:
        """All limits that were given are kept."""
        return all(load.fits for load in (self.thermal, self.peak) if load is not None)

    def __repr__(self) -> str:
        torque, speed = self.units
        rows = [
            (name, *amounts(name, unit, value))
            for name, unit, value in (
                ("peak torque", torque, self.peak_torque),
                ("rms torque", torque, self.rms_torque),
                ("peak speed", speed, self.peak_speed),
                ("mean speed", speed, self.mean_speed),
                ("peak power", "W", self.peak_power),
                ("peak regeneration", "W", self.peak_regeneration),
                ("mean power", "W", self.mean_power),
            )
        ]
        for what, load in (("rated", self.thermal), ("maximum", self.peak)):
            if load is not None:
                rows.append((f"load of {what} torque", number(100 * load.ratio, 4), "%"))
        return table(("motor", "value", "unit"), rows)


@checked
def sizing(
    run: Trajectory,
    *,
    of: tuple[Name, Name],
    rated: _Given | None = None,
    maximum: _Given | None = None,
) -> Sizing:
    """What a run asks of a motor, and whether a given motor can do it.

    The run is taken as one cycle that repeats. A run from `simulate` is made again and read on the
    way, whatever its output times are; of others torque and speed are straight lines between the
    output points. A greatest torque that is zero at some speed is compared at these points alone.

    Parameters
    ----------
    run : Trajectory
        One cycle, from `simulate` or `inverse`.
    of : (name, name)
        Torque of the motor (N.m) and its angular velocity (rad/s), or force (N) and speed (m/s).
    rated, maximum : float, str or rows of (speed, torque), optional
        Torque that the motor bears for ever, and its greatest: one number or value with a unit,
        such as ``"0.3 kN.m"``, or rows of these over the magnitude of the speed, with straight
        lines between them, the first torque below them, and none above the last speed.

    Returns
    -------
    Sizing

    Raises
    ------
    OptionError
        If the units are not those of a torque and its speed, or a limit makes no sense.
    UnitError
        If a limit has a unit of another dimension.

    Notes
    -----
    The windings heat with the square of the torque, so a cycle short against the thermal time
    constant of the motor is as hot as its root mean square (Leonhard, Control of Electrical Drives,
    3rd ed., ch. 4).
    """
    torque, rate = of
    units = run.system.quantity(torque).unit, run.system.quantity(rate).unit
    if units not in (("N.m", "rad/s"), ("N", "m/s")):
        raise OptionError(
            f"sizing: of = ({run.system.key(torque)}, {run.system.key(rate)}), in {units[0]} and "
            f"{units[1]}; a torque (N.m) and its angular velocity "
            "(rad/s) are needed, or a force (N) and a speed (m/s)."
        )
    dt = np.diff(run.t)
    if not dt.sum() > 0:
        raise OptionError("sizing: the run has no duration; give `grid` at least two instants.")
    steady, most = _plain(rated, "rated", units), _plain(maximum, "maximum", units)
    tau, w = run[torque], run[rate]
    load = None if most is None else _load(most, "maximum", np.abs(w), np.abs(tau))
    if run.read is None:
        found = _of_points(dt, tau, w)
    else:
        keys = run.system.key(torque), run.system.key(rate)
        found = run.read(_wanted(*keys)).tolist()
        if load is not None and most is not None and np.min(_rows(most, "maximum")[1]) > 0:
            load = replace(load, ratio=_ratio(run, keys, most, found[1]))
    peak_torque, peak_speed, level, mean_speed, power, regeneration, mean_power = found
    thermal = None if steady is None else _load(steady, "rated", np.array([mean_speed]), [level])
    return Sizing(
        peak_torque,
        peak_speed,
        level,
        mean_speed,
        max(power, 0.0),
        max(-regeneration, 0.0),
        mean_power,
        thermal,
        load,
        units,
        (w, tau),
        steady,
        most,
    )


def _wanted(tau: str, w: str) -> list[Functional]:
    """What is read of a run, as `_of_points`."""
    power = Formula.made(lambda y, z: y * z, tau, w)
    sizes = peak(tau), peak(w), rms(tau), mean(Formula.made(abs, w))
    return [*sizes, highest(power), lowest(power), mean(tau, w)]


def _ratio(run: Trajectory, keys: tuple[str, str], limit: Limit, fastest: float) -> float:
    """Greatest torque over a limit that is nowhere zero."""
    speeds, torques = _rows(limit, "maximum")
    if not np.isscalar(limit) and fastest > speeds[-1]:
        return np.inf

    def share(tau: Expr, w: Expr) -> Expr:
        return abs(tau) / ops.interpolate(ops.maximum(abs(w), speeds[0]), speeds, torques)

    return run.value(highest(Formula.made(share, *keys)))


def _of_points(dt: np.ndarray, tau: np.ndarray, w: np.ndarray) -> list[float]:
    """Peaks of torque and speed, rms torque, mean speed, most, least and mean power."""
    power, rms_torque = tau * w, np.sqrt(_mean_product(dt, tau, tau))
    found = (np.abs(tau).max(), np.abs(w).max(), rms_torque, _mean_size(dt, w))
    return [*map(float, (*found, power.max(), power.min(), _mean_product(dt, tau, w)))]


def _mean_product(dt: np.ndarray, y: np.ndarray, z: np.ndarray) -> float:
    """Mean of the product of two quantities that are straight between points."""
    a, b, c, d = y[:-1], y[1:], z[:-1], z[1:]
    return float(dt @ (2 * a * c + a * d + b * c + 2 * b * d) / (6 * dt.sum()))


def _mean_size(dt: np.ndarray, y: np.ndarray) -> float:
    """Mean magnitude of a quantity that is straight between points."""
    a, b = y[:-1], y[1:]
    size = np.abs(a) + np.abs(b)
    crossing = a * b < 0
    inside = np.where(crossing, (a**2 + b**2) / np.where(size > 0, size, 1.0), size)
    return float(dt @ inside / (2 * dt.sum()))


def _load(limit: Limit, what: str, speed: np.ndarray, torque: Sequence[float] | np.ndarray) -> Load:
    sizes = np.asarray(torque)
    bound = _bound(limit, what, speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(sizes > 0, sizes / bound, 0.0)
    ratio[np.isnan(bound)] = np.inf
    i = int(np.argmax(ratio))
    return Load(float(ratio[i]), float(speed[i]), float(sizes[i]), float(np.nan_to_num(bound[i])))


def _bound(limit: Limit, what: str, speed: np.ndarray) -> np.ndarray:
    """Torque of a limit at magnitudes of the speed; nan beyond its last."""
    speeds, torques = _rows(limit, what)
    beyond = torques[0] if np.isscalar(limit) else np.nan
    bound: np.ndarray = np.interp(speed, speeds, torques, right=beyond)
    return bound


def _plain(limit: _Given | None, what: str, units: tuple[str, str]) -> Limit | None:
    """A limit as numbers in the units of torque and speed."""

    def convert(value: float | str, unit: str) -> float:
        return plain(value, unit, f"sizing: {what} =", OptionError)

    if not isinstance(limit, Sequence | np.ndarray) or isinstance(limit, str):
        return None if limit is None else convert(limit, units[0])
    return [(convert(w, units[1]), convert(bound, units[0])) for w, bound in limit]


def _rows(limit: Limit, what: str) -> np.ndarray:
    """Speeds and torques of a limit, shape (2, n)."""
    rows = np.array([(0.0, limit)] if np.isscalar(limit) else limit, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != 2 or not len(rows):
        raise OptionError(f"sizing: {what} = {limit!r}: a torque or rows of (speed, torque).")
    speeds, torques = rows.T
    if not ((np.diff(speeds) > 0).all() and speeds[0] >= 0 and (torques >= 0).all()):
        raise OptionError(
            f"sizing: {what} = {limit!r}: speeds must increase from zero or above, and no torque "
            "may be negative."
        )
    return rows.T
