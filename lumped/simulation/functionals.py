"""Numbers that sum up a run or its modes: what is minimised, bounded or differentiated."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal, Protocol

from lumped.compiler.system import Name
from lumped.errors import OptionError
from lumped.flattening.tree import key_of
from lumped.simulation.functional_kinds import (
    At,
    AtEvent,
    Between,
    Clearance,
    Count,
    Damage,
    Damping,
    Designed,
    Final,
    Frequency,
    Functional,
    Impact,
    Instant,
    Integral,
    Modal,
    OrderPeak,
    Peak,
    Separation,
    Swing,
    Vibrating,
)
from lumped.support.arguments import checked
from lumped.timeloop.cycle_count import DamageLaw, MeanStress

__all__ = [
    "At",
    "AtEvent",
    "Clearance",
    "Count",
    "Curve",
    "Damage",
    "Damping",
    "Designed",
    "Final",
    "Frequency",
    "Functional",
    "Impact",
    "Instant",
    "Integral",
    "Modal",
    "OrderPeak",
    "Peak",
    "Separation",
    "Swing",
    "Vibrating",
    "at",
    "at_event",
    "clearance",
    "count",
    "damage",
    "damping",
    "final",
    "frequency",
    "highest",
    "impulse",
    "instant",
    "integral",
    "loss",
    "lowest",
    "mean",
    "order_peak",
    "peak",
    "rms",
    "separation",
    "swing",
]


@checked
def final(name: Name) -> Final:
    """Value of a quantity at the end.

    Parameters
    ----------
    name : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.

    Returns
    -------
    Final
        To be given to an analysis.
    """
    return Final(key_of(name))


@checked
def peak(name: Name, *, between: Between | None = None) -> Peak:
    """Largest size of a quantity, ``max |y|``, in the whole run or between two instants.

    Parameters
    ----------
    name : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Peak
        To be given to an analysis.
    """
    return Peak(key_of(name), "peak", _window(between))


@checked
def highest(name: Name, *, between: Between | None = None) -> Peak:
    """Largest value of a quantity, in the whole run or between two instants.

    Parameters
    ----------
    name : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Peak
        To be given to an analysis.
    """
    return Peak(key_of(name), "highest", _window(between))


@checked
def lowest(name: Name, *, between: Between | None = None) -> Peak:
    """Least value of a quantity, in the whole run or between two instants.

    Parameters
    ----------
    name : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Peak
        To be given to an analysis.
    """
    return Peak(key_of(name), "lowest", _window(between))


@checked
def swing(name: Name) -> Swing:
    """From trough to crest of a quantity.

    Parameters
    ----------
    name : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.

    Returns
    -------
    Swing
        To be given to an analysis.
    """
    return Swing(key_of(name))


@checked
def integral(*names: Name, between: Between | None = None) -> Integral:
    """Integral over time of a quantity, or of a product: work is that of torque and speed.

    Parameters
    ----------
    *names : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Integral
        To be given to an analysis.
    """
    return Integral(_some(names, "integral"), "integral", _window(between))


@checked
def mean(*names: Name, between: Between | None = None) -> Integral:
    """Mean over time of a quantity, or of a product: power is that of torque and speed.

    Parameters
    ----------
    *names : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Integral
        To be given to an analysis.
    """
    return Integral(_some(names, "mean"), "mean", _window(between))


@checked
def rms(*names: Name, between: Between | None = None) -> Integral:
    """Root of the mean over time of the square of a quantity, or of a product.

    Parameters
    ----------
    *names : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Integral
        To be given to an analysis.
    """
    return Integral(_some(names, "rms"), "rms", _window(between))


@checked
def instant(component: str, after: str = "", *, number: int = 0) -> Instant:
    """Instant at which something happens in a component (see `Trajectory.events`).

    Parameters
    ----------
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).
    number : int
        Which of these, from 0; negative numbers count from the last.

    Returns
    -------
    Instant
        To be given to an analysis.
    """
    return Instant(component, after, number)


@checked
def count(component: str, after: str = "") -> Count:
    """How often something happens in a component (see `Trajectory.events`).

    For `ensemble` only: a number that jumps has no derivative.

    Parameters
    ----------
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).

    Returns
    -------
    Count
        To be given to an analysis.
    """
    return Count(component, after)


@checked
def at(time: float | Iterable[float], *names: Name) -> At:
    """Value of a quantity, or of a product, at an instant, or its sum over several instants.

    Where something jumps at that very instant, the value after it.

    Parameters
    ----------
    time : float or iterable of float
        Instants, s; 0 is the start.
    names : names or expressions
        The factors.

    Returns
    -------
    At
        To be given to an analysis.

    Raises
    ------
    OptionError
        If there is no instant, or one before the start.
    """
    times = tuple(float(t) for t in time) if isinstance(time, Iterable) else (float(time),)
    if not times or min(times) < 0:
        raise OptionError(f"at: {time!r}: instants within the run are needed, s.")
    return At(times, _some(names, "at"))


def at_event(
    name: Name | tuple[Name, ...],
    component: str,
    after: str = "",
    *,
    number: int | None = 0,
    side: Literal["before", "after"] = "before",
) -> AtEvent:
    """Value of a quantity, or of a product, just before or after something happens.

    Parameters
    ----------
    name : name or expression, or tuple of these
        The quantity, or the factors.
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).
    number : int or None
        Which of these, from 0; negative numbers count from the last; None for the sum over all.
    side : {"before", "after"}
        Side of the event.

    Returns
    -------
    AtEvent
        To be given to an analysis.

    Raises
    ------
    OptionError
        If the side is another.
    """
    if side not in ("before", "after"):
        raise OptionError(f"at_event: side = {side!r}: choose 'before' or 'after'.")
    names = name if isinstance(name, tuple) else (name,)
    return AtEvent(_some(names, "at_event"), component, after, number, side)


def loss(component: str, *, number: int | None = None) -> Impact:
    """Mechanical energy that a component loses in impacts, J: in all of them, or in one.

    Parameters
    ----------
    component : str
        As in `Event`.
    number : int, optional
        Which impact, from 0; negative numbers count from the last. Default is all.

    Returns
    -------
    Impact
        To be given to an analysis.
    """
    return Impact(component, number, "loss")


def impulse(component: str, *, number: int | None = 0) -> Impact:
    """Impulse of an impact, N.s or N.m.s, positive where it drives bodies apart.

    Of one impact of the component, or of all (``number=None``).

    Parameters
    ----------
    component : str
        As in `Event`.
    number : int or None
        Which impact, from 0; negative numbers count from the last; None for the sum over all.

    Returns
    -------
    Impact
        To be given to an analysis.
    """
    return Impact(component, number, "impulse")


class Curve(Protocol):
    """How much damage a cycle does, as an S-N curve says it."""

    def law(self, mean_stress: MeanStress | None, scale: float) -> DamageLaw:
        """The numbers of the curve."""
        ...


@checked
def damage(
    name: Name,
    curve: Curve,
    *,
    scale: float = 1.0,
    mean_stress: MeanStress | None = None,
) -> Damage:
    """Share of life that the cycles of a load take in a run, 1 being failure.

    Cycles are found by rainflow counting (ASTM E1049-85, what is left being half cycles) of all
    turning points, between the steps of the run too; shares add up (Palmgren and Miner). Where the
    load jumps, both sides count.

    Parameters
    ----------
    name : name or expression
        The load, or an expression of quantities, such as ``16 * rig.shaft.tau / (pi * d**3)``.
    curve : SNCurve
        From `lumped.life`.
    scale : float
        Stress for each unit of the load, such as ``16 / (pi d^3)`` for the torque of a shaft.
    mean_stress : optional
        How the mean of a cycle counts, such as ``lumped.life.goodman("700 MPa")``; default is not
        at all.

    Returns
    -------
    Damage
        To be given to an analysis.

    Raises
    ------
    OptionError
        If the scale is not positive.
    """
    if not scale > 0:
        raise OptionError(f"damage: scale = {scale:g} must be positive.")
    return Damage(key_of(name), curve.law(mean_stress, scale))


@checked
def frequency(mode: int) -> Frequency:
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first.

    Parameters
    ----------
    mode : int
        Its number, from 0.

    Returns
    -------
    Frequency
        To be given to an analysis.
    """
    return Frequency(mode)


@checked
def damping(mode: int) -> Damping:
    """Damping ratio of a mode; modes count from 0, the lowest first.

    Parameters
    ----------
    mode : int
        Its number, from 0.

    Returns
    -------
    Damping
        To be given to an analysis.
    """
    return Damping(mode)


@checked
def clearance(excitations: Iterable[float]) -> Clearance:
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations.

    Each frequency stays on the side of each excitation on which a search begins.

    Parameters
    ----------
    excitations : iterable of float
        Frequencies to avoid, Hz.

    Returns
    -------
    Clearance
        To be given to an analysis.
    """
    return Clearance(tuple(float(f) for f in excitations))


@checked
def order_peak(
    name: Name,
    *,
    measure: Literal["maximum", "half range", "sum"] | float = "half range",
    speeds: tuple[float, float] | None = None,
) -> OrderPeak:
    """Largest vibration of a quantity over the speeds of an order response.

    Parameters
    ----------
    name : name
        One of the outputs of the response.
    measure : {"maximum", "half range", "sum"} or float
        Of its synthesis over a cycle, or the order whose amplitude is meant.
    speeds : (float, float), optional
        First and last speed that count, rad/s; default is all of the response.

    Returns
    -------
    OrderPeak
        To be given to `lumped.optimise`.

    Raises
    ------
    OptionError
        If the order is not positive, or the speeds are not in order.
    """
    if not isinstance(measure, str) and not 0 < measure < math.inf:
        raise OptionError(f"order_peak: order {measure!r} must be positive.")
    if speeds is None:
        return OrderPeak(key_of(name), measure)
    low, high = map(float, speeds)
    if not 0 < low <= high < math.inf:
        raise OptionError(f"order_peak: speeds = {speeds!r}: the first and the last, rad/s.")
    return OrderPeak(key_of(name), measure, (low, high))


@checked
def separation(orders: Iterable[float], *, between: tuple[float, float]) -> Separation:
    """Least distance of critical speeds from the speeds of operation, as a share of the nearest.

    Natural frequencies are those at the mean state of each speed, as in
    `lumped.vibration.mean_campbell`. Between the speeds of operation, and that share beyond them,
    each mode stays above or below each order, whichever asks for the smaller change of its
    frequency where a search begins.

    Parameters
    ----------
    orders : iterable of float
        Excitations for each turn of the shaft of an order response.
    between : (float, float)
        First and last speed of operation, rad/s.

    Returns
    -------
    Separation
        To be given to `lumped.optimise`.

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
    return Separation(wanted, (low, high))


def _window(between: Between | None) -> Between | None:
    """Two instants in order."""
    if between is None:
        return None
    begin, end = map(float, between)
    if not 0 <= begin < end < math.inf:
        raise OptionError(f"between = {between!r}: two instants of the run in order, s.")
    return begin, end


def _some(names: tuple[Name, ...], what: str) -> tuple[str, ...]:
    if not names:
        raise OptionError(f"{what}: name at least one quantity.")
    return tuple(map(key_of, names))
