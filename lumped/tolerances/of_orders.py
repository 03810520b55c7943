"""Vibrations of order responses at many values of parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.functionals.readings import Damping, OrderPeak, Reading, Separation
from lumped.tolerances.evaluated import Array, Evaluated, Failures, one_by_one
from lumped.tolerances.of_modes import slope_of_modes, value_of_modes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import slope_of
from lumped.vibration.speeds.mean_campbell import critical_sensitivity
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from lumped.vibration.speeds.order_designs import OrderDesigns


class OfOrders(Evaluated):
    """Readings of order responses (see `Evaluated`).

    Parameters
    ----------
    begin : OrderResponse
        That of the nominal drive.
    names : tuple of str
        What varies.
    of : sequence of Reading
    analysis : str
        With which errors begin.
    """

    def __init__(
        self,
        begin: OrderResponse,
        names: tuple[str, ...],
        of: Sequence[Reading],
        analysis: str,
    ) -> None:
        self._begin, self._names, self._of = begin, names, tuple(of)
        self._system, self._base = begin.system, begin.rotation.points[0].parameters
        self._designs = OrderDesigns(begin, analysis)
        self._designs.refuse_balancing(list(names), "over")
        self._places = begin.system.places(names)
        for functional in of:
            if isinstance(functional, OrderPeak):
                self._designs.inside(functional)

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals of all designs."""

        def one(row: Array) -> list[Array]:
            found = self._response(row)
            return [np.array([self._value(f, found)[0] for f in self._of])]

        (values,), failures = one_by_one(x, [(len(self._of),)], one)
        return values, failures

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals and derivatives of all designs."""
        k, d = len(self._of), len(self._names)

        def one(row: Array) -> list[Array]:
            found = self._response(row)
            pairs = [self._value(f, found, with_slope=True) for f in self._of]
            return [np.array([pair[i] for pair in pairs]) for i in (0, 1)]

        (values, slopes), failures = one_by_one(x, [(k,), (k, d)], one)
        return values, slopes, failures

    def _response(self, row: Array) -> OrderResponse:
        return self._designs.response(
            self._base | dict(zip(self._names, row.tolist(), strict=True))
        )

    def _value(
        self, wanted: Reading, found: OrderResponse, with_slope: bool = False
    ) -> tuple[float, Array]:
        none = np.zeros(len(self._names))
        if isinstance(wanted, OrderPeak):
            sizes = self._designs.sizes(wanted, found)
            most = int(sizes.argmax())
            if not with_slope:
                return float(sizes[most]), none
            place = int(self._designs.inside(wanted)[most])
            by = slope_of(found, self._system.key(wanted.name), place, wanted.measure)
            return float(sizes[most]), by[self._places]
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
        return value, side * slope(chosen)[self._places]
