"""Sine and cosine from additions and products alone, for one number or several side by side.

Wherever an operation of a plant is carried out, the same bits come out. The angle is reduced by
multiples of a quarter turn in three parts (Cody and Waite, Software Manual for the Elementary
Functions, 1980); the polynomials are those of fdlibm (Sun Microsystems, 1993). The error is below
two units in the last place.
"""

from __future__ import annotations

from lumped.code.words import any_lane, cos, kernel, sin

FARTHEST = 1e6
"""Angle from which on the C library is asked, rad: here its multiple is no longer exact."""
_PER_RADIAN = 0.6366197723675814
_QUARTER = 1.5707963267341256
_QUARTER_REST = 6.077100506303966e-11
_QUARTER_END = 2.0222662487959506e-21
"""A quarter turn in three parts; the first two have 33 bits each."""
_ROUND = 6755399441055744.0
"""Added and subtracted, it rounds to a whole number."""


@kernel
def _quarters(x: float) -> float:
    """The nearest whole number of quarter turns."""
    return (x * _PER_RADIAN + _ROUND) - _ROUND


@kernel
def _halve(whole: float) -> float:
    """Half of a whole number, rounded down."""
    return ((0.5 * whole - 0.25) + _ROUND) - _ROUND


@kernel
def _is_odd(whole: float) -> float:
    """One if a whole number is odd, else zero."""
    return whole - 2.0 * _halve(whole)


@kernel
def _rest(x: float, quarters: float) -> float:
    """The angle without so many quarter turns."""
    return ((x - quarters * _QUARTER) - quarters * _QUARTER_REST) - quarters * _QUARTER_END


@kernel
def _small_sine(r: float) -> float:
    z = r * r
    high = z * (1.58969099521155010221e-10 * z - 2.50507602534068634195e-08)
    high = z * (2.75573137070700676789e-06 + high) - 1.98412698298579493134e-04
    return r + r * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * high))


@kernel
def _small_cosine(r: float) -> float:
    z = r * r
    high = z * (2.08757232129817482790e-09 - 1.13596475577881948265e-11 * z)
    high = z * (high - 2.75573143513906633035e-07) + 2.48015872894767294178e-05
    high = z * (z * high - 1.38888888888741095749e-03) + 4.16666666666666019037e-02
    half = 0.5 * z
    w = 1.0 - half
    return w + (((1.0 - w) - half) + z * z * high)


@kernel
def near_sine(x: float) -> float:
    """Sine of an angle that is not far.

    Products with zero and one choose between the polynomials, without a branch.
    """
    quarters = _quarters(x)
    r, odd = _rest(x, quarters), _is_odd(quarters)
    size = odd * _small_cosine(r) + (1.0 - odd) * _small_sine(r)
    return (1.0 - 2.0 * _is_odd(_halve(quarters))) * size


@kernel
def near_cosine(x: float) -> float:
    """Cosine of an angle that is not far."""
    quarters = _quarters(x)
    r, odd = _rest(x, quarters), _is_odd(quarters)
    size = (1.0 - odd) * _small_cosine(r) - odd * _small_sine(r)
    return (1.0 - 2.0 * _is_odd(_halve(quarters))) * size


@kernel
def sine(x: float) -> float:
    """Sine of an angle in rad."""
    near, is_far = near_sine(x), abs(x) > FARTHEST
    if any_lane(is_far):
        return sin(x) if is_far else near
    return near


@kernel
def cosine(x: float) -> float:
    """Cosine of an angle in rad."""
    near, is_far = near_cosine(x), abs(x) > FARTHEST
    if any_lane(is_far):
        return cos(x) if is_far else near
    return near
