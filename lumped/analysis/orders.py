"""Orders of excitation that a machine has by itself, taken from a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.analysis.modes import Modes
from lumped.analysis.result import Trajectory
from lumped.arguments import checked
from lumped.errors import OptionError
from lumped.system import Name

__all__ = ["Order", "orders", "turns"]


@dataclass(frozen=True)
class Order:
    """One harmonic of a quantity over the turn of a shaft.

    Attributes
    ----------
    order : int
        Periods for each turn.
    amplitude : float
        In the unit of the quantity.
    phase : float
        ``amplitude cos(order angle + phase)``, rad.
    """

    order: int
    amplitude: float
    phase: float


@checked
def orders(
    run: Trajectory, of: Name, over: Name, *, least: float = 0.01, most: int = 40
) -> tuple[Order, ...]:
    """Harmonics of a quantity over the last full turn of a shaft.

    Run the machine at constant speed, as with `lumped.inverse` or a speed source, and give the
    orders of its load torque to `critical_speeds` or `campbell`.

    Parameters
    ----------
    run : Trajectory
        With a grid fine enough for the highest order: some 40 points for each of its periods.
    of : name
        The quantity, such as the torque at the crank.
    over : name
        The angle of the shaft, rad; it must rise or fall throughout.
    least : float
        Smallest amplitude that is kept, as a share of the largest.
    most : int
        Highest order.

    Returns
    -------
    tuple of Order
        The mean (order 0) apart, by order.

    Raises
    ------
    OptionError
        If the run has less than a turn, the angle does not rise or fall throughout, or the grid is
        too coarse.
    """
    system = run.system
    angle, value = run[over] * np.sign(run[over][-1] - run[over][0]), run[of]
    rising = np.diff(angle) > 0
    if (np.diff(angle) < 0).any():
        raise OptionError(f"orders: {over} turns back; orders count over a steady turn.")
    begin = angle[-1] - 2 * np.pi
    if begin < angle[0] - 1e-9:
        raise OptionError(
            f"orders: {over} covers {angle[-1] - angle[0]:.4g} rad; a full turn is needed."
        )
    inside = np.append(rising, True) & (angle > begin)
    if inside.sum() < 8 * most:
        raise OptionError(
            f"orders: {inside.sum()} points in the last turn of {over} are too few for the order "
            f"{most} of {system.key(of)}; run with a grid of at least {8 * most} points a turn."
        )
    first = np.interp(begin, angle[np.append(rising, True)], value[np.append(rising, True)])
    # exact integrals of the straight pieces between the points, times the harmonics
    a, y = np.append(0.0, angle[inside] - begin), np.append(first, value[inside])
    slope = np.diff(y) / np.diff(a)
    k = np.arange(1, most + 1)[:, None]
    turning = np.exp(-1j * k * a)
    pieces = (y[1:] * turning[:, 1:] - y[:-1] * turning[:, :-1]) * 1j / k + slope * np.diff(
        turning, axis=1
    ) / k**2
    harmonics = pieces.sum(axis=1) / np.pi * np.exp(-1j * k[:, 0] * begin)
    size = np.abs(harmonics)
    kept = np.flatnonzero(size > least * size.max(initial=0.0)).tolist()
    return tuple(Order(i + 1, float(size[i]), float(np.angle(harmonics[i]))) for i in kept)


@checked
def turns(modes: Modes, of: Name, over: Name) -> float:
    """Turns of a shaft for each turn of another, by the gears between them.

    Its unbalance or eccentricity excites with this order, twice for an oval roll, and a mesh of its
    wheel with this times the number of teeth. Taken from the rigid-body mode in which both turn.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; the drive must be free to turn.
    of, over : name
        Angles of the shaft, and of that from which orders count, rad.

    Raises
    ------
    OptionError
        If no rigid-body mode turns both, or several turn them in different ratios.
    """
    own, led = modes.rigid_shape(over), modes.rigid_shape(of)
    turning = np.abs(own) > 1e-9
    ratios = led[turning] / own[turning]
    size = np.abs(ratios).max(initial=0.0)
    if not size > 1e-9 or np.ptp(ratios) > 1e-9 * size:
        raise OptionError(
            f"turns: {of} does not turn with {over} in a fixed ratio, as they are not joined, are "
            "held, or meet in a differential. Give the order as a number."
        )
    return float(abs(ratios[0]))
