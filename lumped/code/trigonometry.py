"""Sine and cosine from additions and products alone, for one number or several side by side.

Wherever an operation of a plant is carried out, the same bits come out. The angle is reduced by
multiples of a quarter turn in three parts (Cody and Waite, Software Manual for the Elementary
Functions, 1980); the polynomials are those of fdlibm (Sun Microsystems, 1993). The error is below
two units in the last place.
"""

from __future__ import annotations

from lumped.code.words import any_lane, cos, kernel, sin

_FARTHEST = 1e6
"""Angle from which on the C library is asked, rad: here its multiple is no longer exact."""
_PER_RADIAN = 0.6366197723675814
_QUARTER = 1.5707963267341256
_QUARTER_REST = 6.077100506303966e-11
_QUARTER_END = 2.0222662487959506e-21
"""A quarter turn in three parts; the first two have 33 bits each."""
_ROUND = 6755399441055744.0
"""Added and subtracted, it rounds to a whole number."""


@kernel
def _near_sine(r: float) -> float:
    z = r * r
    high = z * (1.58969099521155010221e-10 * z - 2.50507602534068634195e-08)
    high = z * (2.75573137070700676789e-06 + high) - 1.98412698298579493134e-04
    return r + r * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * high))


@kernel
def _near_cosine(r: float) -> float:
    z = r * r
    high = z * (2.08757232129817482790e-09 - 1.13596475577881948265e-11 * z)
    high = z * (high - 2.75573143513906633035e-07) + 2.48015872894767294178e-05
    high = z * (z * high - 1.38888888888741095749e-03) + 4.16666666666666019037e-02
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + z * z * high)


@kernel
def _wave(x: float, ahead: float) -> float:
    """Sine of an angle and a number of quarter turns, 0 or 1."""
    k = (x * _PER_RADIAN + _ROUND) - _ROUND
    r = ((x - k * _QUARTER) - k * _QUARTER_REST) - k * _QUARTER_END
    k += ahead
    quarter = k - 4.0 * ((0.25 * k - 0.375 + _ROUND) - _ROUND)
    is_odd = quarter == 1.0 or quarter == 3.0
    size = _near_cosine(r) if is_odd else _near_sine(r)
    return -size if quarter > 1.5 else size


@kernel
def sine(x: float) -> float:
    """Sine of an angle in rad."""
    near, is_far = _wave(x, 0.0), abs(x) > _FARTHEST
    if any_lane(is_far):
        return sin(x) if is_far else near
    return near


@kernel
def cosine(x: float) -> float:
    """Cosine of an angle in rad."""
    near, is_far = _wave(x, 1.0), abs(x) > _FARTHEST
    if any_lane(is_far):
        return cos(x) if is_far else near
    return near
