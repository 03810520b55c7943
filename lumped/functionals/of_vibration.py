"""What sums up natural vibrations and order responses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.flattening.tree import key_of
from lumped.functionals.functional import Functional
from lumped.functionals.readings import Clearance, Damping, Frequency, OrderPeak, Separation
from lumped.support.arguments import checked


@checked
def frequency(mode: int) -> Functional:
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first.

    Parameters
    ----------
    mode : int
        Its number, from 0.

    Returns
    -------
    Functional
    """
    return Functional.of(Frequency(mode))


@checked
def damping(mode: int) -> Functional:
    """Damping ratio of a mode; modes count from 0, the lowest first.

    Parameters
    ----------
    mode : int
        Its number, from 0.

    Returns
    -------
    Functional
    """
    return Functional.of(Damping(mode))


@checked
def clearance(excitations: Iterable[float]) -> Functional:
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations.

    Each frequency stays on the side of each excitation on which a search begins.

    Parameters
    ----------
    excitations : iterable of float
        Frequencies to avoid, Hz.

    Returns
    -------
    Functional
    """
    return Functional.of(Clearance(tuple(float(f) for f in excitations)))


@checked
def order_peak(
    of: Name,
    *,
    measure: Literal["maximum", "half range", "sum"] | float = "half range",
    speeds: tuple[float, float] | None = None,
) -> Functional:
    """Largest vibration of a quantity over the speeds of an order response.

    Parameters
    ----------
    of : name
        One of the outputs of the response.
    measure : {"maximum", "half range", "sum"} or float
        Of its synthesis over a cycle, or the order whose amplitude is meant.
    speeds : (float, float), optional
        First and last speed that count, rad/s; default is all of the response.

    Returns
    -------
    Functional

    Raises
    ------
    OptionError
        If the order is not positive, or the speeds are not in order.
    """
    if not isinstance(measure, str) and not 0 < measure < math.inf:
        raise OptionError(f"order_peak: order {measure!r} must be positive.")
    if speeds is None:
        return Functional.of(OrderPeak(key_of(of), measure))
    low, high = map(float, speeds)
    if not 0 < low <= high < math.inf:
        raise OptionError(f"order_peak: speeds = {speeds!r}: the first and the last, rad/s.")
    return Functional.of(OrderPeak(key_of(of), measure, (low, high)))


@checked
def separation(orders: Iterable[float], *, between: tuple[float, float]) -> Functional:
    """Least distance of critical speeds from the speeds of operation, as a share of the nearest.

    Natural frequencies are those at the mean state of each speed, as in
    `lumped.vibration.mean_campbell`. Between the speeds of operation, and that share beyond
    them, each mode stays above or below each order, whichever asks for the smaller change of its
    frequency where a search begins.

    Parameters
    ----------
    orders : iterable of float
        Excitations for each turn of the shaft of an order response.
    between : (float, float)
        First and last speed of operation, rad/s.

    Returns
    -------
    Functional

    Raises
    ------
    OptionError
        If an order is not positive, or the speeds are not in order.
    """
    wanted = tuple(dict.fromkeys(float(order) for order in orders))
    if not wanted or not all(0 < order < math.inf for order in wanted):
        raise OptionError(f"separation: orders = {wanted}: positive excitations for each turn.")
    low, high = map(float, between)
    if not 0 < low <= high < math.inf:
        raise OptionError(f"separation: between = {between!r}: the first and the last, rad/s.")
    return Functional.of(Separation(wanted, (low, high)))
