"""How finely a shaft is cut."""

from __future__ import annotations

from lumped.errors import OptionError
from lumped.ops import pi
from lumped.support.arguments import checked

__all__ = ["elements_needed"]


@checked
def elements_needed(transit: float, f_max: float, accuracy: float) -> int:
    """Number of equal elements, half their inertia at each end, that a uniform bar is cut into.

    In a row of n such elements a wave of the frequency ``f`` of the bar has the frequency
    ``f sin(x) / x`` with ``x = pi f T / n``, `T` the time a wave takes from end to end. With free
    and clamped ends this holds for all natural frequencies, so they are too low by
    ``1 - sin(x) / x < x^2 / 6``. A body at an end sees a torque too small by ``cos(x)``, which
    makes the condition at the end, ``cot(q L) = b q``, one of ``b q tan(x) / x``. That lowers the
    wave number `q` by at most another ``x^2 / 6``, as ``q L >= sin(q L) cos(q L)``. So the error up
    to `f_max` stays below `accuracy`, whatever bodies are at the ends, if
    ``n >= pi f_max T / sqrt(3 accuracy)``; without bodies it is half of that.

    Parameters
    ----------
    transit : float
        Time a wave takes from end to end, s: length times ``sqrt(rho / G)``.
    f_max : float
        Highest frequency of interest, Hz.
    accuracy : float
        Relative error allowed of natural frequencies up to there.

    Returns
    -------
    int
        At least one.

    Raises
    ------
    OptionError
        If a time or frequency is negative, or the accuracy not between 0 and 1.
    """
    if transit < 0 or f_max < 0:
        name, value, unit = ("f_max", f_max, "Hz") if f_max < 0 else ("transit", transit, "s")
        raise OptionError(f"elements_needed: {name} = {value:g} {unit} must not be negative.")
    if not 0 < accuracy < 1:
        raise OptionError(
            f"elements_needed: accuracy = {accuracy:g}: a relative error between 0 and 1, such as "
            "0.01."
        )
    return max(1, -int(-pi * f_max * transit / (3 * accuracy) ** 0.5 // 1))
