"""How a critical speed moves with parameters."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError, SolverError
from lumped.support.arguments import checked
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import (
    OrderSensitivity,
    find_varied_places,
    refuse_ratio,
)
from lumped.vibration.speeds.campbell import CriticalSpeed
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum

_MEETS = 1e-6
"""Relative distance of the frequency at the speed from that of the order."""
_TOUCHES = 1e-9


@checked
def critical_sensitivity(
    response: OrderResponse, critical: CriticalSpeed, *, by: Iterable[Name] | None = None
) -> OrderSensitivity:
    """Exact derivatives of a critical speed by parameters.

    The speed n solves ``order n = 2 pi f(n, p)``, f at the mean state of that speed, so that
    ``dn/dp = 2 pi (df/dp) / (order - 2 pi df/dn)``: the mean state follows both n and p.

    Parameters
    ----------
    response : OrderResponse
        From `order_response`.
    critical : CriticalSpeed
        One of ``mean_campbell(response).critical``.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    OrderSensitivity
        Derivatives in rad/s for each unit of the parameter.

    Raises
    ------
    OptionError
        If it is no critical speed of this response, or operating points were given at each speed.
    SolverError
        If the mode only touches the order there, or coincides with another.
    UnknownNameError
        If a name does not exist.
    """
    refuse_ratio(response, "critical_sensitivity")
    speed, order = critical.speed, critical.order
    steady = response.turning(np.array([speed]))
    spectrum = MeanSpectrum(response.small, steady, response.orders)
    name = f"mode {critical.mode + 1}, {critical.label or f'order {order:g}'}"
    away = np.abs(2 * np.pi * spectrum.hertz / (order * speed) - 1)
    if away.min(initial=np.inf) > _MEETS:
        raise OptionError(
            f"{response.system.name}: {speed:.9g} rad/s is no critical speed of {name}; give one "
            "of lumped.vibration.mean_campbell(response).critical."
        )
    mode = int(away.argmin())
    steeper = order - 2 * np.pi * spectrum.hertz_by_speed(mode)
    if abs(steeper) <= _TOUCHES * order:
        raise SolverError(
            f"{response.system.name}: {name} only touches at {speed:.9g} rad/s, where the critical "
            "speed has no derivative. Change a parameter a little."
        )
    names, places = find_varied_places(response, by)
    slope = 2 * np.pi * spectrum.hertz_by(mode)[places] / steeper
    return OrderSensitivity(
        name,
        "critical speed",
        "rad/s",
        speed,
        speed,
        tuple(names),
        slope,
        slope * steady.theta[0, places] / speed,
    )
