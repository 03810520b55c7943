"""Incoming strip of varying thickness, which the source names beside the eccentric rolls.

A wave of thickness of length `wave` on the incoming strip meets the rolls with the frequency
f = v (1 - r) / wave, for strip that leaves with v and a reduction r enters with v (1 - r). The
rolling torque goes with the draft, so that at a fixed gap dM / M = (dh / h) / r. The source prints
no numbers for this: waves, reduction and amplitude are [A].

The waves taken here are those that eccentric backup rolls left in the pass before, one in each
circumference. So they come with the frequency (47) times 1 - r: what is excited at 9.97 m/s by the
eccentricity is excited at 14.24 m/s by the strip; the speeds in print are 10 and 15 m/s.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Sine, Torque
from lumped.models.reversing_mill import stand as mill
from lumped.models.sources import Given

REDUCTION = Given(0.3, "1", "A", "reduction of a pass, r")
WAVE = Given(
    np.pi * mill.BACKUP_DIAMETER,
    "m",
    "A",
    "length of the waves on the incoming strip: circumference of a backup roll of the pass before",
)
THICKNESS = Given(0.01, "1", "A", "amplitude of the thickness of the incoming strip over its mean")


class WavyStrip(mill.CreepingGap):
    """Creeping rolls under a rolling torque that follows the thickness of the incoming strip."""

    v: lp.Param = lp.param("m/s", "speed of the strip behind the rolls", 15.0, min=0)
    r: lp.Param = lp.param("1", "reduction", REDUCTION, above=0, below=1)
    wave: lp.Param = lp.param("m", "length of the waves on the incoming strip", WAVE, above=0)
    h: lp.Param = lp.param("1", "amplitude of the thickness over its mean", THICKNESS, min=0)
    M_pr: lp.Param = lp.param("N.m", "mean rolling torque on each pair of rolls", mill.RATED)
    rolling: Sine = Sine(amplitude=-M_pr * h / r, frequency=v * (1 - r) / wave, offset=-M_pr)
    upper_load: Torque = Torque()
    lower_load: Torque = Torque()

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.rolling.y, self.upper_load.tau, self.lower_load.tau)


def thickness_hertz(speed: float, reduction: float = REDUCTION, wave: float = WAVE) -> float:
    """Frequency of the waves of the incoming strip at the speed of the leaving one in m/s."""
    return speed * (1 - reduction) / wave


def thickness_gains(gap: mill.OpenGap, speeds: np.ndarray, torque: float) -> np.ndarray:
    """Shaft torques in the steady state under waves of the incoming strip.

    Parameters
    ----------
    gap : OpenGap, ClosedGap or CreepingGap
        Stand.
    speeds : array_like, shape (k,)
        Speeds of the leaving strip, m/s.
    torque : float
        Amplitude on each pair of rolls.

    Returns
    -------
    ndarray of complex, shape (k, 3)
        Amplitudes of the torques `SHAFTS`.
    """
    return mill.rolling_gains(gap, thickness_hertz(1) * np.asarray(speeds), torque)


def rolling_waves(
    speed: float = 15.0,
    until: float = 3.0,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Waves of thickness that reach the rolls in steady rolling with rated torque.

    Parameters
    ----------
    speed : float
        Speed of the leaving strip, m/s.
    until : float
        End, s.
    parameters, start : mapping of name to value, optional
        Parameters to change, and start values besides rated torque in all shafts.
    **options
        Passed to `lumped.simulate`.
    """
    driving = {"v": speed, "upper.drive.tau": mill.RATED, "lower.drive.tau": mill.RATED}
    return lp.simulate(
        lp.assemble(WavyStrip()),
        until=until,
        parameters=driving | dict(parameters or {}),
        start=dict.fromkeys(mill.SHAFTS, mill.RATED) | dict(start or {}),
        **options,
    )
