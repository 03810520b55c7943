"""Torque frequencies of motors on inverters, and the speeds at which they meet frequencies.

Rules of the switching, no analysis: amplitudes follow from the inverter's control and are not
computed. The sidebands of the sine-triangle modulation are those of Holmes and Lipo, Pulse Width
Modulation for Power Converters; a switched inverter has them (tests). The rule of the
current-source inverter follows from its direct current, whose ripple has six times the frequency of
the line, and from its six pulses in a period of the motor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Real


@dataclass(frozen=True)
class TorqueLine:
    """Torque at the frequencies ``|m f_0 + n f|`` and ``|m f_0 - n f|``, f that of the inverter.

    Attributes
    ----------
    m, n : int
        Multiples of the fixed frequency and of that of the inverter.
    f_0 : float
        Fixed frequency, Hz.
    """

    m: int
    n: int
    f_0: float

    def frequencies(self, f: ArrayLike) -> Real:
        """Frequencies of the torque, Hz.

        Parameters
        ----------
        f : array_like, shape (k,)
            Frequencies of the inverter, Hz.

        Returns
        -------
        ndarray, shape (2, k)
            Sum and difference.
        """
        turning = self.n * np.atleast_1d(np.asarray(f, dtype=float))
        found: Real = np.abs(self.m * self.f_0 + np.array([1.0, -1.0])[:, None] * turning)
        return found


@dataclass(frozen=True)
class LineCrossing:
    """A speed at which a line of the torque meets a natural frequency.

    Attributes
    ----------
    speed : float
        Speed of the motor, rad/s.
    f : float
        Frequency of the inverter there, Hz.
    line : TorqueLine
        The line.
    sign : {"+", "-"}
        Whether its sum or its difference meets the natural frequency.
    mode : int
        Place of the natural frequency in those given, from 0.
    hertz : float
        Natural frequency, Hz.
    """

    speed: float
    f: float
    line: TorqueLine
    sign: str
    mode: int
    hertz: float

    @property
    def rpm(self) -> float:
        """The speed in turns for each minute."""
        return self.speed * 30 / np.pi


@checked
def sine_triangle_lines(f_s: float, *, m: int = 2, n: int = 18) -> tuple[TorqueLine, ...]:
    """Lines of a voltage-source inverter of three phases and two levels, sine-triangle modulation.

    Torque at ``|m f_s + n f|`` and ``|m f_s - n f|``: n = 0, 6, 12, ... with even m, n = 3, 9, 15,
    ... with odd m. Lines of m = 0 come from dead time or six-step operation.

    Parameters
    ----------
    f_s : float
        Switching frequency, fixed, Hz.
    m, n : int
        Greatest multiples of the switching frequency and of the inverter's.

    Returns
    -------
    tuple of TorqueLine
        Without the mean torque m = n = 0.

    Raises
    ------
    OptionError
        If the frequency is not positive or a multiple is negative.
    """
    _not_negative("sine_triangle_lines", f_s, "f_s", m=m, n=n)
    found = [
        TorqueLine(i, j, f_s) for i in range(m + 1) for j in range(3 * (i % 2), n + 1, 6) if i or j
    ]
    return tuple(found)


@checked
def six_pulse_lines(f_line: float, *, i: int = 2, j: int = 2) -> tuple[TorqueLine, ...]:
    """Lines of a current-source inverter, commutated by line and motor, six pulses on both sides.

    Torque at ``|6 i f_line + 6 j f|`` and ``|6 i f_line - 6 j f|``: interharmonics that the ripple
    of the line side leaves in the direct current. `TorqueLine.m` is i with ``f_0 = 6 f_line``, and
    `TorqueLine.n` is 6 j.

    Parameters
    ----------
    f_line : float
        Frequency of the line, Hz.
    i, j : int
        Greatest multiples of six times the line's and the inverter's frequency.

    Returns
    -------
    tuple of TorqueLine
        For i from 0, j from 1.

    Raises
    ------
    OptionError
        If the frequency is not positive or a multiple is negative.
    """
    _not_negative("six_pulse_lines", f_line, "f_line", i=i, j=j)
    return tuple(
        TorqueLine(row, 6 * column, 6 * f_line)
        for row in range(i + 1)
        for column in range(1, j + 1)
    )


@checked
def line_crossings(
    lines: Sequence[TorqueLine],
    hertz: ArrayLike,
    *,
    speeds: ArrayLike,
    pairs: int = 1,
) -> tuple[LineCrossing, ...]:
    """Speeds at which lines of the torque meet natural frequencies.

    The motor turns at ``w = 2 pi f / pairs``; the slip of an induction motor is left out. A line of
    constant frequency (n = 0) crosses none.

    Parameters
    ----------
    lines : sequence of TorqueLine
        From `sine_triangle_lines` or `six_pulse_lines`.
    hertz : array_like, shape (k,)
        Natural frequencies, Hz, such as ``modes.hertz``; those of zero are passed over.
    speeds : array_like, shape (2,)
        Least and greatest speed of the motor, rad/s.
    pairs : int
        Pole pairs.

    Returns
    -------
    tuple of LineCrossing
        By mode, then by speed.

    Raises
    ------
    OptionError
        If frequencies are negative, speeds do not ascend from zero up, or there is no pole pair.
    """
    natural = np.asarray(hertz, dtype=float).ravel()
    if (natural < 0).any():
        raise OptionError("line_crossings: natural frequencies, Hz, must be at least 0.")
    if pairs < 1:
        raise OptionError(f"line_crossings: pairs = {pairs} must be at least 1.")
    ends = np.asarray(speeds, dtype=float).ravel()
    if len(ends) != 2 or not 0 <= ends[0] < ends[1] < np.inf:
        raise OptionError(
            "line_crossings: speeds are the least and the greatest one, rad/s, not negative."
        )
    low, high = pairs * ends / (2 * np.pi)
    found = [
        LineCrossing(float(2 * np.pi * f / pairs), float(f), line, sign, mode, float(frequency))
        for mode, frequency in enumerate(natural)
        for line in lines
        for sign, f in _where(line, frequency)
        if low <= f <= high
    ]
    return tuple(sorted(found, key=lambda crossing: (crossing.mode, crossing.speed)))


def _where(line: TorqueLine, hertz: float) -> list[tuple[str, float]]:
    """Frequencies of the inverter at which a line has a frequency, with the sign that has it."""
    if line.n == 0 or hertz == 0:
        return []
    fixed = line.m * line.f_0
    met = [("+", (hertz - fixed) / line.n)]
    if line.m:
        met += [("-", (fixed - hertz) / line.n), ("-", (fixed + hertz) / line.n)]
    return [(sign, f) for sign, f in met if f > 0]


def _not_negative(call: str, frequency: float, name: str, **multiples: int) -> None:
    if not frequency > 0:
        raise OptionError(f"{call}: {name} = {frequency:g} Hz must be positive.")
    for key, value in multiples.items():
        if value < 0:
            raise OptionError(f"{call}: {key} = {value} must be at least 0.")
