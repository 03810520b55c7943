"""Order responses of designs: found again for other parameters as they were found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lumped.errors import OptionError
from lumped.functionals.readings import OrderPeak, Separation
from lumped.support.arrays import Complex, Real
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.mode_designs import equilibrium_again
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import refuse_ratio, sizes_of
from lumped.vibration.speeds.campbell import CriticalSpeed
from lumped.vibration.speeds.mean_campbell import mean_campbell
from lumped.vibration.speeds.order_peaks import OrderPeaks, find_order_peaks

_FARTHER = (0.2, 0.9)
"""Shares of the speeds of operation up to which critical speeds are looked for beside these."""


class OrderDesigns:
    """Order responses of one system for other parameters.

    Parameters
    ----------
    first : OrderResponse
        That with which the designs are compared.
    analysis : str
        With which errors begin.

    Raises
    ------
    OptionError
        If operating points were given at each speed, or a damping ratio of all modes.
    """

    def __init__(self, first: OrderResponse, analysis: str) -> None:
        refuse_ratio(first, analysis)
        steady = first.rotation
        if steady.is_given and len(steady.points) > 1:
            raise OptionError(
                f"{analysis}: operating points that are given at each speed, at=, do not follow "
                "the parameters; let a parameter balance the mean torques, order_response(free=...)"
                "."
            )
        self.first, self.analysis = first, analysis

    def refuse_balancing(self, names: list[str], where: str) -> None:
        """Refuse to vary the parameter that balances the mean torques."""
        balancing = self.first.rotation.balancing
        if balancing in names:
            raise OptionError(
                f"{self.analysis}: {balancing} is free in the order response, so that it follows "
                f"from the others; leave it out of `{where}`."
            )

    def at(self, values: dict[str, float]) -> OperatingPoint | None:
        """The operating point of a design, if one was given."""
        old = self.first.rotation
        if not old.is_given:
            return None
        (point,) = old.points
        if point.kept is not None:
            return equilibrium_again(point, values)
        return replace(point, theta=self.first.system.theta(values))

    def response(self, values: dict[str, float]) -> OrderResponse:
        """Vibration of a design."""
        return self.first.again(values, self.at(values))

    def range_of(self, key: OrderPeak) -> tuple[float, float]:
        """First and last speed of the response that count for a peak."""
        speeds = self.first.speeds
        low, high = key.speeds or (speeds[0], speeds[-1])
        low, high = float(max(low, speeds[0])), float(min(high, speeds[-1]))
        if low > high:
            raise OptionError(f"{self.analysis}: {key}: no speed between these was computed.")
        return low, high

    def curve(self, key: OrderPeak, response: OrderResponse) -> OrderPeaks:
        """What a peak is the largest of, with all its maxima over the speed."""
        of = response.system.key(key.name)

        def sizes(speeds: Real, values: Complex) -> Real:
            shape = values[:, :, None], np.zeros((len(speeds), 1))
            part = OrderAmplitudes(response.system, speeds, response.orders, (of,), *shape)
            return sizes_of(part, of, key.measure)

        return find_order_peaks(response, lambda found: found[of], sizes, self.range_of(key))

    def top(self, key: OrderPeak, response: OrderResponse) -> tuple[float, OrderResponse]:
        """A peak, and the response at its speed alone."""
        curve = self.curve(key, response)
        most = int(curve.sizes.argmax())
        return float(curve.sizes[most]), response.at_speeds(curve.speeds[[most]])

    def nearest(
        self, key: Separation, response: OrderResponse
    ) -> tuple[float, CriticalSpeed | None]:
        """Separation, and the critical speed that is nearest; infinite where there is none.

        Looked for farther and farther from the speeds of operation.
        """
        low, high = key.between
        speeds = self.first.speeds
        for share in _FARTHER:
            between = (
                min(low * (1 - share), float(speeds[0])),
                max(high * (1 + share), float(speeds[-1])),
            )
            critical = mean_campbell(response, orders=key.orders, between=between).critical
            # distance from the speeds of operation, relative to the nearest of these
            away = [max(1 - c.speed / low, c.speed / high - 1, 0.0) for c in critical]
            if min(away, default=np.inf) <= share:
                break
        if not away:
            return np.inf, None
        least = int(np.argmin(away))
        return away[least], critical[least]
