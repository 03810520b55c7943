"""Laws of motion from rest to rest, and paths made of them.

A law (`trapezoidal`, `s_curve`, `polynomial5`, ...) gives a `Move`: its duration, its peaks and its
way over the time. `path` puts moves and dwells one after the other and gives the position as an
expression of `lumped.time`, to be prescribed by `lumped.inverse` or by an input of the model; its
speed is ``lumped.der`` of it. Distances have the unit of the position, rad or m; below it is called
1, so speeds are in 1/s.

How smooth a law must be depends on the drive. Bodies alone need a continuous speed; a spring
between drive and load asks for a continuous third derivative as well, which only `polynomial7` has
at its ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cbrt, isfinite, pi, sqrt

from lumped.errors import OptionError
from lumped.language.expression import Expr, Where, as_expr, time
from lumped.ops import sin
from lumped.support.arguments import checked

__all__ = [
    "Move",
    "cycloidal",
    "dwell",
    "modified_sine",
    "path",
    "polynomial5",
    "polynomial7",
    "s_curve",
    "trapezoidal",
]


@dataclass(frozen=True)
class Move:
    """A motion from rest to rest.

    Attributes
    ----------
    distance : float
        Its way, of either sign.
    duration : float
        Its time, s.
    speed, acceleration, jerk : float
        Greatest magnitudes, in 1/s, 1/s2 and 1/s3; the jerk may be infinite.
    pieces : tuple of (float, callable)
        Begin of each piece, s, and the way from the begin of the move as an expression of the time
        since then.
    """

    distance: float
    duration: float
    speed: float
    acceleration: float
    jerk: float
    pieces: tuple[tuple[float, Callable[[Expr], Expr]], ...]


def path(*moves: Move, begin: float = 0.0, start: float = 0.0) -> Expr:
    """Position over the time: moves and dwells one after the other.

    Parameters
    ----------
    *moves : Move
        In their order.
    begin : float
        Instant at which the first begins, s; before it everything rests.
    start : float
        Position before the first.

    Returns
    -------
    Expr
        Over `lumped.time`.

    Raises
    ------
    OptionError
        If there is no move, or a value is not finite.
    """
    if not moves:
        raise OptionError("path: no moves are given.")
    for move in moves:
        if not isinstance(move, Move):
            raise OptionError(
                f"path: {move!r} is no move; give moves one after the other, such as "
                "path(polynomial5(1.0, 2.0), dwell(0.5)), a list as path(*moves)."
            )
    if not isfinite(begin) or not isfinite(start):
        raise OptionError(f"path: begin = {begin} s and start = {start} must be finite.")
    pieces: list[tuple[float, Expr]] = []
    now, position = begin, start
    for move in moves:
        since = time - now
        pieces += [(now + t, position + way(since)) for t, way in move.pieces]
        now, position = now + move.duration, position + move.distance
    pieces.append((now, as_expr(position)))

    def choose(low: int, high: int) -> Expr:
        """Balanced choice among pieces[low:high], the rest before the first being -1."""
        if high - low == 1:
            return as_expr(start) if low < 0 else pieces[low][1]
        middle = (low + high) // 2
        return Where(time >= pieces[middle][0], choose(middle, high), choose(low, middle))

    return choose(-1, len(pieces))


@checked
def dwell(duration: float) -> Move:
    """Rest for a while.

    Parameters
    ----------
    duration : float
        How long, s.

    Returns
    -------
    Move
        To be given to `path`.
    """
    _positive(duration=duration)
    return Move(0.0, duration, 0.0, 0.0, 0.0, ((0.0, lambda t: as_expr(0.0)),))


@checked
def trapezoidal(distance: float, v_max: float, a_max: float) -> Move:
    """Quickest move within a speed and an acceleration: constant acceleration, speed, deceleration.

    Peak speed ``v = min(v_max, sqrt(h a_max))`` over the way ``h``, duration ``h / v + v / a_max``.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    v_max, a_max : float
        Greatest speed and acceleration.

    Returns
    -------
    Move
        To be given to `path`.
    """
    _positive(v_max=v_max, a_max=a_max)
    way = _way(distance)
    v = min(v_max, sqrt(way * a_max))
    up, cruise = v / a_max, max(way / v - v / a_max, 0.0)
    phases = ((up, a_max, 0.0), (cruise, 0.0, 0.0), (up, -a_max, 0.0))
    return _phased(distance, phases, (v, a_max, float("inf")))


@checked
def s_curve(distance: float, v_max: float, a_max: float, j_max: float) -> Move:
    """Quickest move within a speed, an acceleration and a jerk, in up to seven pieces.

    With the peak speed ``v`` and acceleration ``a = min(a_max, sqrt(v j_max))``, speeding up takes
    ``v / a + a / j_max``, and the move ``h / v`` longer. ``v`` is `v_max` where the way ``h`` lets
    it be reached; else ``h = v (v / a + a / j_max)``.

    Source: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008,
    ch. 3.4.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    v_max, a_max, j_max : float
        Greatest speed, acceleration and jerk.

    Returns
    -------
    Move
        To be given to `path`.
    """
    _positive(v_max=v_max, a_max=a_max, j_max=j_max)
    way = _way(distance)
    ramp = a_max / j_max
    v = 0.5 * a_max * (sqrt(ramp**2 + 4 * way / a_max) - ramp)
    if v * j_max < a_max**2:
        v = j_max * cbrt(way / (2 * j_max)) ** 2
    v = min(v, v_max)
    a = min(a_max, sqrt(v * j_max))
    jerk, flat = a / j_max, max(v / a - a / j_max, 0.0)
    cruise = max(way / v - v / a - a / j_max, 0.0)
    phases = (
        (jerk, 0.0, j_max),
        (flat, a, 0.0),
        (jerk, a, -j_max),
        (cruise, 0.0, 0.0),
        (jerk, 0.0, -j_max),
        (flat, -a, 0.0),
        (jerk, -a, j_max),
    )
    return _phased(distance, phases, (v, a, j_max))


@checked
def polynomial5(distance: float, duration: float) -> Move:
    """The 3-4-5 polynomial, ``s = h (10 x^3 - 15 x^4 + 6 x^5)``, ``x = t / T``.

    Speed and acceleration are zero at the ends. Peaks: speed ``15/8 h/T``, acceleration
    ``10/sqrt(3) h/T^2``, jerk ``60 h/T^3``.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    duration : float
        Of the whole move, s.

    Returns
    -------
    Move
        To be given to `path`.
    """

    def law(x: Expr) -> Expr:
        return x * x * x * (10 + x * (6 * x - 15))

    return _scaled(distance, duration, (15 / 8, 10 / sqrt(3), 60.0), ((0.0, law),))


@checked
def polynomial7(distance: float, duration: float) -> Move:
    """The 4-5-6-7 polynomial, ``s = h (35 x^4 - 84 x^5 + 70 x^6 - 20 x^7)``, ``x = t / T``.

    Speed, acceleration and jerk are zero at the ends, as a drive with one spring needs. Peaks:
    speed ``35/16 h/T``, acceleration ``84 sqrt(5)/25 h/T^2``, jerk ``105/2 h/T^3``.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    duration : float
        Of the whole move, s.

    Returns
    -------
    Move
        To be given to `path`.
    """

    def law(x: Expr) -> Expr:
        return x * x * x * x * (35 + x * (x * (70 - 20 * x) - 84))

    return _scaled(distance, duration, (35 / 16, 84 * sqrt(5) / 25, 52.5), ((0.0, law),))


@checked
def cycloidal(distance: float, duration: float) -> Move:
    """Sinusoidal acceleration, ``s = h (x - sin(2 pi x) / (2 pi))``, ``x = t / T``.

    Speed and acceleration are zero at the ends. Peaks: speed ``2 h/T``, acceleration
    ``2 pi h/T^2``, jerk ``4 pi^2 h/T^3``.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    duration : float
        Of the whole move, s.

    Returns
    -------
    Move
        To be given to `path`.
    """

    def law(x: Expr) -> Expr:
        return x - sin(2 * pi * x) / (2 * pi)

    return _scaled(distance, duration, (2.0, 2 * pi, 4 * pi**2), ((0.0, law),))


@checked
def modified_sine(distance: float, duration: float) -> Move:
    """Modified sine: a quick sine of acceleration at the ends, a slow one in between.

    With ``x = t / T`` and ``k = h / (4 + pi)``, ``s = k (pi x - sin(4 pi x) / 4)`` up to
    ``x = 1/8``, ``k (2 + pi x - 9/4 sin((4 pi x + pi) / 3))`` up to 7/8, and then
    ``k (4 + pi x - sin(4 pi x) / 4)``. Peaks: speed ``4 pi/(4 + pi) h/T``, acceleration
    ``4 pi^2/(4 + pi) h/T^2``, jerk ``16 pi^3/(4 + pi) h/T^3``.

    Source: Norton, Cam Design and Manufacturing Handbook, 2nd ed.

    Parameters
    ----------
    distance : float
        Way of the move, m or rad, with its sign.
    duration : float
        Of the whole move, s.

    Returns
    -------
    Move
        To be given to `path`.
    """
    k = 1 / (4 + pi)

    def first(x: Expr) -> Expr:
        return k * (pi * x - sin(4 * pi * x) / 4)

    def middle(x: Expr) -> Expr:
        return k * (2 + pi * x - 9 / 4 * sin((4 * pi * x + pi) / 3))

    def last(x: Expr) -> Expr:
        return k * (4 + pi * x - sin(4 * pi * x) / 4)

    peaks = (4 * pi * k, 4 * pi**2 * k, 16 * pi**3 * k)
    pieces = ((0.0, first), (1 / 8, middle), (7 / 8, last))
    return _scaled(distance, duration, peaks, pieces)


def _scaled(
    distance: float,
    duration: float,
    peaks: tuple[float, float, float],
    pieces: tuple[tuple[float, Callable[[Expr], Expr]], ...],
) -> Move:
    """A law from 0 to 1 within the unit of time, stretched."""
    _positive(duration=duration)
    way = _way(distance)

    def stretched(law: Callable[[Expr], Expr]) -> Callable[[Expr], Expr]:
        return lambda t: distance * law(t / duration)

    v, a, j = (peak * way / duration**n for n, peak in enumerate(peaks, 1))
    return Move(
        distance, duration, v, a, j, tuple((x * duration, stretched(law)) for x, law in pieces)
    )


def _phased(
    distance: float,
    phases: tuple[tuple[float, float, float], ...],
    peaks: tuple[float, float, float],
) -> Move:
    """Phases of constant jerk: the time, the acceleration at the begin, and the jerk of each."""
    sign = 1.0 if distance > 0 else -1.0
    begin = s = v = 0.0
    pieces = []
    for duration, a, j in phases:
        pieces.append((begin, _cubic(begin, sign * s, sign * v, sign * a, sign * j)))
        t = duration
        s, v = s + t * (v + t * (a / 2 + t * j / 6)), v + t * (a + t * j / 2)
        begin += t
    # what rounding leaves of a phase that is not there is dropped
    there = [phase[0] > 1e-12 * begin for phase in phases]
    kept = tuple(piece for piece, is_there in zip(pieces, there, strict=True) if is_there)
    return Move(distance, begin, *peaks, kept)


def _cubic(begin: float, s: float, v: float, a: float, j: float) -> Callable[[Expr], Expr]:
    def law(t: Expr) -> Expr:
        u = t - begin
        return s + u * (v + u * (a / 2 + u * j / 6))

    return law


def _way(distance: float) -> float:
    if not isfinite(distance) or distance == 0:
        raise OptionError(
            f"distance = {distance}: the way of a move must be finite and not zero; for a rest "
            "take dwell(duration)."
        )
    return abs(distance)


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (isfinite(value) and value > 0):
            raise OptionError(f"{name} = {value}: a positive, finite number is needed.")
