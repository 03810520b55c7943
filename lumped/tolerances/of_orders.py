"""Vibrations of order responses at many values of parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lumped.functionals import Functional
from lumped.functionals.readings import Damping, OrderPeak, Reading, Separation
from lumped.tolerances.evaluated import Array, OfReadings
from lumped.tolerances.of_modes import slope_of_modes, value_of_modes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import slope_of
from lumped.vibration.speeds.critical_sensitivity import critical_sensitivity
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from lumped.vibration.speeds.order_designs import OrderDesigns


class OfOrders(OfReadings):
    """Functionals of order responses (see `Evaluated`).

    Parameters
    ----------
    begin : OrderResponse
        That of the nominal drive.
    names : tuple of str
        What varies.
    of : mapping of str to functional
    analysis : str
        With which errors begin.
    """

    def __init__(
        self,
        begin: OrderResponse,
        names: tuple[str, ...],
        of: Mapping[str, Functional],
        analysis: str,
    ) -> None:
        super().__init__(begin.system, names, of)
        self._base = begin.rotation.points[0].parameters
        self._designs = OrderDesigns(begin, analysis)
        self._designs.refuse_balancing(list(names), "over")
        self._own = begin.system.places(names)
        for reading in self._readings:
            if isinstance(reading, OrderPeak):
                self._designs.inside(reading)

    def _read_alone(self, row: Array, with_slopes: bool) -> tuple[Array, Array]:
        values = dict(zip(self._names, row.tolist(), strict=True))
        found = self._designs.response(self._base | values)
        pairs = [self._value(reading, found, with_slopes) for reading in self._readings]
        slopes = np.array([slope for _, slope in pairs])
        return np.array([value for value, _ in pairs]), slopes[:, : None if with_slopes else 0]

    def _value(
        self, wanted: Reading, found: OrderResponse, with_slope: bool
    ) -> tuple[float, Array]:
        none = np.zeros(len(self._names))
        if isinstance(wanted, OrderPeak):
            sizes = self._designs.sizes(wanted, found)
            most = int(sizes.argmax())
            if not with_slope:
                return float(sizes[most]), none
            place = int(self._designs.inside(wanted)[most])
            by = slope_of(found, self._system.key(wanted.name), place, wanted.measure)
            return float(sizes[most]), by[self._own]
        if isinstance(wanted, Separation):
            away, critical = self._designs.nearest(wanted, found)
            if not with_slope or critical is None or not away:
                return away, none
            low, high = wanted.between
            side = -1 / low if critical.speed < low else 1 / high
            by = critical_sensitivity(found, critical, by=self._names).derivatives
            return away, side * by
        spectrum = MeanSpectrum(found.small, found.rotation.at(0), found.orders)
        value = value_of_modes(wanted, spectrum.hertz, spectrum.damping)
        if not with_slope:
            return value, none
        chosen, side = slope_of_modes(wanted, spectrum.hertz)
        slope = spectrum.damping_by if isinstance(wanted, Damping) else spectrum.hertz_by
        return value, side * slope(chosen)[self._own]
