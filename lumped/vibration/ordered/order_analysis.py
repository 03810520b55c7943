"""Orders of excitation that a machine has by itself, taken from a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean, Real
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.natural.modes import Modes

_REPEATS = 0.02
"""Difference from one turn to the next, over the range, below which a quantity repeats."""


@dataclass(frozen=True)
class Order:
    """One harmonic of a quantity over the turn of a shaft.

    Attributes
    ----------
    order : float
        Periods for each turn; 0.5 is one in two turns.
    amplitude : float
        In the unit of the quantity.
    phase : float
        ``amplitude cos(order angle + phase)``, rad.
    """

    order: float
    amplitude: float
    phase: float


@checked
def orders(
    run: Trajectory,
    of: Name,
    *,
    shaft: Name,
    least: float = 0.01,
    most: int = 40,
    turns: int = 1,
) -> tuple[Order, ...]:
    """Harmonics of a quantity over the last full turn of a shaft, or the last turns.

    Run the machine at constant speed, as with `lumped.inverse` or a speed source, and give the
    orders of its load torque to `critical_speeds` or `campbell`.

    Parameters
    ----------
    run : Trajectory
        With a grid fine enough for the highest order: some 40 points for each of its periods.
    of : name
        The quantity, such as the torque at the crank.
    shaft : name
        The angle of the shaft, rad; it must rise or fall throughout.
    least : float
        Smallest amplitude that is kept, as a share of the largest.
    most : int
        Highest order.
    turns : int
        Turns after which the quantity repeats: 2 for the torque of a four-stroke engine, which has
        the orders 0.5, 1, 1.5, ...

    Returns
    -------
    tuple of Order
        The mean (order 0) apart, by order.

    Raises
    ------
    OptionError
        If the run has less than these turns, the angle does not rise or fall throughout, the grid
        is too coarse, or the quantity does not repeat after these turns.
    """
    if turns < 1:
        raise OptionError(f"orders: turns = {turns}: a whole number of turns is needed.")
    system = run.system
    angle, value, rising = rising_angle(run, of, shaft, "orders")
    whole = "a full turn is" if turns == 1 else f"{turns} full turns are"
    window = 2 * np.pi * turns
    begin = angle[-1] - window
    if begin < angle[0] - 1e-9:
        raise OptionError(f"orders: {shaft} covers {angle[-1] - angle[0]:.4g} rad; {whole} needed.")
    inside = rising & (angle > begin)
    if inside.sum() < 8 * most * turns:
        raise OptionError(
            f"orders: {inside.sum() / turns:g} points a turn of {shaft} are too few for the order "
            f"{most} of {system.key(of)}; run with a grid of at least {8 * most} points a turn."
        )
    known = angle[rising], value[rising]
    first = np.interp(begin, *known)
    # exact integrals of the straight pieces between the points, times the harmonics
    a, y = np.append(0.0, angle[inside] - begin), np.append(first, value[inside])
    # one turn later it must be the same, as far back as the run goes; at least where it begins
    earlier = np.union1d(known[0][(known[0] > begin - window) & (known[0] < begin)], begin)
    missed = np.abs(np.interp(earlier + window, *known) - np.interp(earlier, *known)).max()
    if missed > _REPEATS * np.ptp(y):
        raise OptionError(
            f"orders: {system.key(of)} does not repeat after {turns} turn{'s' * (turns > 1)} of "
            f"{shaft}: it differs by {missed:.3g} {system.quantity(of).unit}, "
            f"{missed / np.ptp(y):.0%} of its range. Where it repeats after more turns, as that of "
            f"a four-stroke engine after 2, give turns={turns + 1}; else let the run settle first."
        )
    slope = np.diff(y) / np.diff(a)
    k = np.arange(1, most * turns + 1)[:, None] / turns
    turning = np.exp(-1j * k * a)
    pieces = (y[1:] * turning[:, 1:] - y[:-1] * turning[:, :-1]) * 1j / k + slope * np.diff(
        turning, axis=1
    ) / k**2
    harmonics = pieces.sum(axis=1) * 2 / window * np.exp(-1j * k[:, 0] * begin)
    size = np.abs(harmonics)
    kept = np.flatnonzero(size > least * size.max(initial=0.0)).tolist()
    return tuple(
        Order(
            (i + 1) // turns if (i + 1) % turns == 0 else (i + 1) / turns,
            float(size[i]),
            float(np.angle(harmonics[i])),
        )
        for i in kept
    )


def rising_angle(run: Trajectory, of: Name, shaft: Name, what: str) -> tuple[Real, Real, Boolean]:
    """An angle that rises, a quantity, and the points at which the angle rises on.

    Raises
    ------
    OptionError
        If the angle turns back.
    """
    angle, value = run[shaft] * np.sign(run[shaft][-1] - run[shaft][0]), run[of]
    step = np.diff(angle)
    if (step < 0).any():
        raise OptionError(f"{what}: {shaft} turns back; orders count over a steady turn.")
    return angle, value, np.append(step > 0, True)


@checked
def turns(modes: Modes, of: Name, *, shaft: Name) -> float:
    """Turns of a shaft for each turn of another, by the gears between them.

    Its unbalance or eccentricity excites with this order, twice for an oval roll, and a mesh of its
    wheel with this times the number of teeth. Taken from the rigid-body mode in which both turn.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; the drive must be free to turn.
    of, shaft : name
        Angles of the shaft, and of that from which orders count, rad.

    Returns
    -------
    float
        Negative where they turn in opposite directions.

    Raises
    ------
    OptionError
        If no rigid-body mode turns both, or several turn them in different ratios.
    """
    own, led = modes.rigid_shape(shaft), modes.rigid_shape(of)
    turning = np.abs(own) > 1e-9
    ratios = led[turning] / own[turning]
    size = np.abs(ratios).max(initial=0.0)
    if not size > 1e-9 or np.ptp(ratios) > 1e-9 * size:
        raise OptionError(
            f"turns: {of} does not turn with {shaft} in a fixed ratio, as they are not joined, are "
            "held, or meet in a differential. Give the order as a number."
        )
    return float(abs(ratios[0]))


@checked
def mesh_orders(
    modes: Modes, teeth: Mapping[Name, int], *, shaft: Name, harmonics: int = 1
) -> dict[str, float]:
    """Orders with which gear meshes excite: teeth times the turns of their shafts.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; the drive must be free to turn.
    teeth : mapping of name to int
        Angle of the shaft of one wheel of each mesh, rad, and the teeth of this wheel.
    shaft : name
        Angle of the shaft from which orders count, rad.
    harmonics : int
        Multiples of the mesh frequency, from 1.

    Returns
    -------
    dict of str to float
        Orders by labels, for `campbell` and `critical_speeds`: together with the natural
        frequencies the interference diagram of a gearbox.

    Raises
    ------
    OptionError
        If teeth are no positive whole number, or a shaft does not turn in a fixed ratio.
    """
    if harmonics < 1:
        raise OptionError(f"mesh_orders: harmonics = {harmonics} must be at least 1.")
    found = {}
    for name, z in teeth.items():
        key = modes.system.key(name)
        if isinstance(z, bool) or not isinstance(z, int) or z < 1:
            raise OptionError(f"mesh_orders: {key} has {z!r} teeth; a whole number is needed.")
        order = z * turns(modes, name, shaft=shaft)
        for k in range(1, harmonics + 1):
            found[f"{k} x {key}, {z} teeth" if k > 1 else f"{key}, {z} teeth"] = k * order
    return found
