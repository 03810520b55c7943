"""Critical speeds at the mean state of each speed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from numpy.polynomial import chebyshev

from lumped.compiler.structure import Name
from lumped.errors import OptionError, SolverError
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import (
    OrderSensitivity,
    find_varied_places,
    refuse_ratio,
)
from lumped.vibration.speeds.campbell import (
    Campbell,
    CriticalSpeed,
    HertzOverSpeed,
    Orders,
    check_labels,
    diagram,
)
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum, mean_modes

_COARSE, _FINE = 8, 16
"""Degrees of two polynomials through frequencies over a stretch of speeds."""
_AGREE = 1e-4
"""Relative difference of these up to which the finer one is believed."""
_NARROW = 1 / 256
"""Width over that of the whole range from which on a stretch is not halved."""
_SAME = 1e-12
"""Relative difference of frequencies that is rounding."""
_MEETS = 1e-6
"""Relative distance of the frequency at the speed from that of the order."""
_TOUCHES = 1e-9


@checked
def mean_campbell(
    response: OrderResponse,
    *,
    orders: Orders | None = None,
    between: tuple[float, float] | None = None,
) -> Campbell:
    """Natural frequencies over the speed, each at the mean state of its speed.

    Where the stiffness follows the mean torque, and this the speed, a critical speed n solves
    ``order n = 2 pi f(n)``, f being the frequency (`mean_modes`) at the steady rotation at n. All
    of them in the range are found: frequencies are followed by polynomials over stretches of
    speeds, which are halved until degrees 8 and 16 agree to 1e-4, and what these show is located to
    rounding. Kinks that are narrower than a 256th of the range may be missed.

    Parameters
    ----------
    response : OrderResponse
        From `order_response`; what balances there balances at each speed. Operating points that
        were given at each of its speeds lie on lines between these.
    orders : iterable of float or mapping of str to float, optional
        Excitations for each turn of the shaft; default is those of the response.
    between : tuple of float, optional
        First and last speed, rad/s; default is those of the response.

    Returns
    -------
    Campbell

    Raises
    ------
    OptionError
        If the speeds are not two, ascending and positive, or an order is not positive.
    SolverError
        If there is no steady rotation at a speed.
    """
    begin, end = between or (float(response.speeds[0]), float(response.speeds[-1]))
    if not 0 < begin < end < np.inf:
        raise OptionError(
            f"mean_campbell: from {begin:g} to {end:g} rad/s: two ascending speeds above zero are "
            "needed, between=(50.0, 150.0)."
        )
    wanted = check_labels(response.orders.tolist() if orders is None else orders)
    hertz = HertzOverSpeed(modes_at(response), varies=True)
    grid = speeds_that_show(hertz.rows, begin, end, [order for _, order in wanted])
    return diagram(response.system, grid, wanted, hertz)


def modes_at(response: OrderResponse) -> Callable[[float], Modes]:
    """Modes at the steady rotation at a speed, by the means of its equations over the turns."""
    rotation, system = response.rotation, response.system
    first = rotation.points[0]

    def interpolate_point(speed: float) -> OperatingPoint:
        if len(rotation.points) == 1:
            return first
        k = int(np.clip(np.searchsorted(rotation.speeds, speed) - 1, 0, len(rotation.speeds) - 2))
        low, high = rotation.speeds[k : k + 2]
        share = (speed - low) / (high - low)
        own = rotation.points[k]
        x = (1 - share) * rotation.points[k].x + share * rotation.points[k + 1].x
        theta = (1 - share) * rotation.points[k].theta + share * rotation.points[k + 1].theta
        return replace(own, x=x, theta=theta, search=None, kept=None, residual=None, lost=())

    def find_modes(speed: float) -> Modes:
        if rotation.shaft is None:
            return modes(system, at=interpolate_point(speed))
        return mean_modes(
            system,
            shaft=rotation.shaft,
            speed=speed,
            turns=rotation.turns,
            at=interpolate_point(speed) if rotation.is_given else None,
            free=rotation.balancing,
            parameters=None if rotation.is_given else first.parameters,
        )

    return find_modes


def speeds_that_show(
    rows: Callable[[Real], Real], begin: float, end: float, orders: list[float]
) -> Real:
    """Ascending speeds between two of which each mode meets each order once at most.

    Parameters
    ----------
    rows : callable
        Frequencies at speeds, Hz, shape (k, modes).
    """
    ends = np.array([begin, 0.5 * (begin + end), end])
    three = rows(ends)
    if not np.isnan(three).any() and np.ptp(three, axis=0).max(initial=0.0) <= _SAME * three.max(
        initial=0.0
    ):
        return ends[[0, 2]]
    nodes = np.cos(np.pi * np.arange(_FINE, -1, -1) / _FINE)
    found, waiting = [], [(begin, end)]
    while waiting:
        low, high = waiting.pop()
        speeds = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        speeds[[0, -1]] = low, high
        values = rows(speeds)
        whole = np.flatnonzero(~np.isnan(values).any(axis=0))
        fine = chebyshev.chebfit(nodes, values[:, whole], _FINE)
        coarse = chebyshev.chebfit(nodes[::2], values[::2, whole], _COARSE)
        missed = np.abs(chebyshev.chebval(nodes, coarse).T - values[:, whole])
        agree = (missed <= _AGREE * values[:, whole].max(axis=0)).all()
        if (len(whole) < values.shape[1] or not agree) and high - low > _NARROW * (end - begin):
            waiting += [(low, 0.5 * (low + high)), (0.5 * (low + high), high)]
            continue
        found.append(speeds)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        for column in fine.T:
            for order in orders:
                away = column.copy()
                away[:2] -= order / (2 * np.pi) * np.array([middle, half])
                found.append(middle + half * _turns(away, nodes, _AGREE * np.abs(column[0])))
    return np.unique(np.concatenate(found))


def _turns(curve: Real, nodes: Real, small: float) -> Real:
    """Where a polynomial that may meet zero twice between two nodes is extreme."""
    roots = chebyshev.chebroots(chebyshev.chebder(curve))
    real = roots.real[(np.abs(roots.imag) <= 1e-6) & (np.abs(roots.real) < 1)]
    before = chebyshev.chebval(nodes[np.searchsorted(nodes, real) - 1], curve)
    there = chebyshev.chebval(real, curve)
    return real[there * np.sign(before) <= small]


@checked
def critical_sensitivity(
    response: OrderResponse, critical: CriticalSpeed, *, by: Iterable[Name] | None = None
) -> OrderSensitivity:
    """Exact derivatives of a critical speed by parameters.

    The speed n solves ``order n = 2 pi f(n, p)``, f at the mean state of that speed, so that
    ``dn/dp = 2 pi (df/dp) / (order - 2 pi df/dn)``: the mean state follows both n and p.

    Parameters
    ----------
    response : OrderResponse
        From `order_response`.
    critical : CriticalSpeed
        One of ``mean_campbell(response).critical``.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    OrderSensitivity
        Derivatives in rad/s for each unit of the parameter.

    Raises
    ------
    OptionError
        If it is no critical speed of this response, or operating points were given at each speed.
    SolverError
        If the mode only touches the order there, or coincides with another.
    UnknownNameError
        If a name does not exist.
    """
    refuse_ratio(response, "critical_sensitivity")
    speed, order = critical.speed, critical.order
    steady = response.turning(np.array([speed]))
    spectrum = MeanSpectrum(response.small, steady, response.orders)
    name = f"mode {critical.mode + 1}, {critical.label or f'order {order:g}'}"
    away = np.abs(2 * np.pi * spectrum.hertz / (order * speed) - 1)
    if away.min(initial=np.inf) > _MEETS:
        raise OptionError(
            f"{response.system.name}: {speed:.9g} rad/s is no critical speed of {name}; give one "
            "of lumped.vibration.mean_campbell(response).critical."
        )
    mode = int(away.argmin())
    steeper = order - 2 * np.pi * spectrum.hertz_by_speed(mode)
    if abs(steeper) <= _TOUCHES * order:
        raise SolverError(
            f"{response.system.name}: {name} only touches at {speed:.9g} rad/s, where the critical "
            "speed has no derivative. Change a parameter a little."
        )
    names, places = find_varied_places(response, by)
    slope = 2 * np.pi * spectrum.hertz_by(mode)[places] / steeper
    return OrderSensitivity(
        name,
        "critical speed",
        "rad/s",
        speed,
        speed,
        tuple(names),
        slope,
        slope * steady.theta[0, places] / speed,
    )
