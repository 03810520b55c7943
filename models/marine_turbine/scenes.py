"""Vibrations of the marine turbine: steady over the speed, and in a run up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import lumped as lp
from lumped.components import Torque
from lumped.models.marine_turbine.drive import (
    BLADES,
    D_WHOLE,
    J_WHOLE,
    RPM,
    ZETA,
    MarineTurbine,
)
from lumped.models.sources import Given

BEGIN = Given(25 * RPM, "rad/s", "A", "speed of the propeller at which the run up begins, 25 1/min")
RATE = Given(25 * RPM / 240, "rad/s2", "A", "rise of the speed of the propeller in the run up")
SHAFTS = (
    "shaft.tau",
    "low.intermediate.tau",
    "high.intermediate.tau",
    "low.shaft.tau",
    "high.shaft.tau",
)


class RunUp(MarineTurbine):
    """The drive whose steam raises the speed evenly."""

    w_begin: lp.Param = lp.param("rad/s", "speed of the propeller at the beginning", BEGIN)
    rate: lp.Param = lp.param("rad/s2", "its rise", RATE)

    steam: Torque = Torque(tau=J_WHOLE * rate + D_WHOLE * (w_begin + rate * lp.time))


def response(
    rpm: ArrayLike = tuple(range(1, 101)),
    model: MarineTurbine | None = None,
    damping_ratio: float = ZETA,
    parameters: Mapping[str, Any] | None = None,
) -> lp.vibration.OrderResponse:
    """Steady vibration of all shafts by the blades.

    Parameters
    ----------
    rpm : array_like
        Speeds of the propeller, 1/min.
    model : MarineTurbine, optional
        The drive.
    damping_ratio : float
        Of every elastic mode, beside the dampers.
    parameters : mapping, optional
        Parameters to change.
    """
    system = lp.assemble(model or MarineTurbine())
    return lp.vibration.order_response(
        system,
        speeds=np.asarray(rpm, dtype=float) * RPM,
        of=SHAFTS,
        shaft="propeller.phi",
        orders=[BLADES],
        damping_ratio=damping_ratio,
        parameters=parameters,
    )


def run_up(
    until: float = 240.0, model: MarineTurbine | None = None, **options: Any
) -> lp.Trajectory:
    """Run of the whole train from 25 1/min on, through the first critical speed.

    Parameters
    ----------
    until : float
        End of the run, s.
    model : MarineTurbine, optional
        The drive.
    **options
        Passed to `lumped.simulate`.
    """
    system = lp.assemble(model or RunUp(), keep=["propeller.phi", *SHAFTS])
    parameters = options.pop("parameters", None)
    return lp.simulate(system, until=until, start=slow_turning(system, parameters), **options)


def slow_turning(
    system: lp.System, parameters: Mapping[str, Any] | None = None
) -> lp.OperatingPoint:
    """All parts together at the speed at which the run up begins."""
    return lp.start_point(
        system, start={"propeller.w": BEGIN}, together=True, parameters=parameters
    )
