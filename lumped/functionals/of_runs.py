"""What sums up a run: extremes, integrals, values, events and damage, and what is made of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Literal

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.flattening.tree import key_of
from lumped.functionals.damage_law import Curve, MeanStress
from lumped.functionals.functional import Functional
from lumped.functionals.readings import (
    AtEvent,
    Between,
    Cycles,
    Extreme,
    Integral,
    Occurrence,
    Span,
    Value,
)
from lumped.ops import sqrt
from lumped.support.arguments import checked


@checked
def final(of: Name) -> Functional:
    """Value of a quantity at the end.

    Parameters
    ----------
    of : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.

    Returns
    -------
    Functional
    """
    return Functional.of(Value((key_of(of),)))


@checked
def peak(of: Name, *, between: Between | None = None) -> Functional:
    """Largest size of a quantity, ``max |y|``, in the whole run or between two instants.

    Parameters
    ----------
    of : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    return Functional.of(Extreme((key_of(of),), "peak", _window(between)))


@checked
def highest(of: Name, *, between: Between | None = None) -> Functional:
    """Largest value of a quantity, in the whole run or between two instants.

    Parameters
    ----------
    of : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    return Functional.of(Extreme((key_of(of),), "highest", _window(between)))


@checked
def lowest(of: Name, *, between: Between | None = None) -> Functional:
    """Least value of a quantity, in the whole run or between two instants.

    Parameters
    ----------
    of : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    return Functional.of(Extreme((key_of(of),), "lowest", _window(between)))


@checked
def swing(of: Name, *, between: Between | None = None) -> Functional:
    """From trough to crest of a quantity, in the whole run or between two instants.

    Parameters
    ----------
    of : name or expression
        The quantity, or an expression of quantities, such as ``rig.shaft.tau * rig.shaft.w``.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    high, low = highest(of, between=between), lowest(of, between=between)
    return (high - low).called(high.text.replace("highest", "swing", 1))


@checked
def integral(*of: Name, between: Between | None = None) -> Functional:
    """Integral over time of a quantity, or of a product: work is that of torque and speed.

    Parameters
    ----------
    *of : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    return Functional.of(Integral(_some(of, "integral"), _window(between)))


@checked
def span(*, between: Between | None = None) -> Functional:
    """How long a run, or a part of it, lasts, s: an integral over it is a mean times it.

    Parameters
    ----------
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    return Functional.of(Span(_window(between)))


@checked
def mean(*of: Name, between: Between | None = None) -> Functional:
    """Mean over time of a quantity, or of a product: power is that of torque and speed.

    Parameters
    ----------
    *of : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    whole = integral(*_some(of, "mean"), between=between)
    return (whole / span(between=between)).called(whole.text.replace("integral", "mean", 1))


@checked
def rms(*of: Name, between: Between | None = None) -> Functional:
    """Root of the mean over time of the square of a quantity, or of a product.

    Parameters
    ----------
    *of : names or expressions
        The quantity, or the factors of a product.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    whole = integral(*_some(of, "rms"), between=between)
    square = integral(*of, *of, between=between)
    return sqrt(square / span(between=between)).called(whole.text.replace("integral", "rms", 1))


@checked
def instant(component: str, after: str = "", *, number: int = 0) -> Functional:
    """Instant at which something happens in a component (see `Trajectory.events`).

    Parameters
    ----------
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).
    number : int
        Which of these, from 0; negative numbers count from the last.

    Returns
    -------
    Functional
    """
    return Functional.of(Occurrence("instant", component, after, number))


@checked
def count(component: str, after: str = "") -> Functional:
    """How often something happens in a component (see `Trajectory.events`).

    For `ensemble` only: a number that jumps has no derivative.

    Parameters
    ----------
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).

    Returns
    -------
    Functional
    """
    return Functional.of(Occurrence("count", component, after))


@checked
def at_time(time: float | Iterable[float], *of: Name) -> Functional:
    """Value of a quantity, or of a product, at an instant, or its sum over several instants.

    Where something jumps at that very instant, the value after it.

    Parameters
    ----------
    time : float or iterable of float
        Instants, s; 0 is the start.
    *of : names or expressions
        The factors.

    Returns
    -------
    Functional

    Raises
    ------
    OptionError
        If there is no instant, or one before the start.
    """
    times = tuple(float(t) for t in time) if isinstance(time, Iterable) else (float(time),)
    if not times or min(times) < 0:
        raise OptionError(f"at_time: {time!r}: instants within the run are needed, s.")
    return Functional.of(Value(_some(of, "at_time"), times))


@checked
def at_event(
    of: Name | tuple[Name, ...],
    component: str,
    after: str = "",
    *,
    number: int | None = 0,
    side: Literal["before", "after"] = "before",
) -> Functional:
    """Value of a quantity, or of a product, just before or after something happens.

    Parameters
    ----------
    of : name or expression, or tuple of these
        The quantity, or the factors.
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).
    number : int or None
        Which of these, from 0; negative numbers count from the last; None for the sum over all.
    side : {"before", "after"}
        Side of the event.

    Returns
    -------
    Functional

    Raises
    ------
    OptionError
        If the side is another.
    """
    if side not in ("before", "after"):
        raise OptionError(f"at_event: side = {side!r}: choose 'before' or 'after'.")
    names = of if isinstance(of, tuple) else (of,)
    return Functional.of(Value(_some(names, "at_event"), AtEvent(component, after, number, side)))


@checked
def loss(component: str, *, number: int | None = None) -> Functional:
    """Mechanical energy that a component loses in impacts, J: in all of them, or in one.

    Parameters
    ----------
    component : str
        As in `Event`.
    number : int, optional
        Which impact, from 0; negative numbers count from the last. Default is all.

    Returns
    -------
    Functional
    """
    return Functional.of(Occurrence("loss", component, number=number))


@checked
def impulse(component: str, *, number: int | None = 0) -> Functional:
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
    Functional
    """
    return Functional.of(Occurrence("impulse", component, number=number))


@checked
def damage(
    of: Name,
    curve: Curve,
    *,
    scale: float = 1.0,
    mean_stress: MeanStress | None = None,
) -> Functional:
    """Share of life that the cycles of a load take in a run, 1 being failure.

    Cycles are found by rainflow counting (ASTM E1049-85, what is left being half cycles) of all
    turning points, between the steps of the run too; shares add up (Palmgren and Miner). Where the
    load jumps, both sides count.

    Parameters
    ----------
    of : name or expression
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
    Functional

    Raises
    ------
    OptionError
        If the scale is not positive.
    """
    if not scale > 0:
        raise OptionError(f"damage: scale = {scale:g} must be positive.")
    return Functional.of(Cycles((key_of(of),), curve.law(mean_stress, scale)))


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
