"""Measures of vibrations that limits hold, at speeds and between them."""

from __future__ import annotations

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.support.arrays import Complex, Real
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.rules.limits import Limit, Measure
from lumped.vibration.speeds.order_peaks import OrderPeaks, fill_in, find_order_peaks


def measure_quantity(found: OrderAmplitudes, key: str, measure: Measure) -> Real:
    """A measure of a quantity at each speed, see `Limit`."""
    if measure == "mean power":
        if not isinstance(found, OrderResponse):
            raise OptionError(f"limit of {key}: mean powers follow from order responses only.")
        power: Real = found.mean_power(key).sum(axis=1)
        return power
    both = found.synthesis(key)
    if measure == "with mean":
        (_, high), (_, low) = both.extremes
        mean = found.mean(key)
        return np.maximum(np.abs(mean + high), np.abs(mean + low))
    return both.measure(measure)


def find_peaks_of_use(
    found: OrderResponse, key: str, limit: Limit, between: tuple[float, float]
) -> OrderPeaks:
    """How far a limit is used over speeds."""
    is_power, unit = limit.measure == "mean power", found.system.quantity(key).unit

    def signals(response: OrderResponse) -> Complex:
        if is_power:
            return measure_quantity(response, key, limit.measure)[:, None].astype(complex)
        return np.column_stack([response[key], response.mean(key)])

    def sizes(speeds: Real, values: Complex) -> Real:
        own = values[:, 0].real
        if not is_power:
            whole = values[:, :-1, None], values[:, -1:].real
            part = OrderAmplitudes(found.system, speeds, found.orders, (key,), *whole)
            own = measure_quantity(part, key, limit.measure)
        used: Real = own / limit.at(speeds, unit)
        return used

    return find_order_peaks(found, signals, sizes, between)


def show_peaks(response: OrderResponse) -> OrderResponse:
    """A response with more speeds, so that pages show what verdicts judge.

    They lie beside resonances, and where amplitudes, maxima and half ranges are largest; where the
    vibration cannot be computed between the given speeds, there are none.
    """
    ends = float(response.speeds[0]), float(response.speeds[-1])
    if ends[0] == ends[1]:
        return response
    kinds: tuple[Measure, ...] = "maximum", "half range"
    try:
        found = fill_in(response)
        peaks = [
            find_peaks_of_use(found, of, Limit(of, 1.0, measure=kind), ends)
            for of in response.of
            for kind in kinds
        ]
    except SolverError:
        return response
    tops = [each.speeds[each.sizes.argmax()] for each in peaks]
    return found.at_speeds(np.union1d(found.speeds, tops))
