"""Amplitudes that excite an order response, and its orders."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.support.arrays import Complex, Real
from lumped.vibration.ordered.order_solution import Excitations
from lumped.vibration.rotating.rotation import Rotation

Amplitude: TypeAlias = complex | ArrayLike | Callable[[Real], ArrayLike]
"""Amplitude at all speeds, at each of them, or a function of the speeds, rad/s."""
Given: TypeAlias = Mapping[str, Mapping[float, Amplitude]]
"""Amplitudes by inputs and orders."""

HIGHEST = 12
"""Order up to which torques are taken where no orders are named."""


def find_excitations(system: System, given: Given, speeds: Real) -> Excitations:
    """Amplitudes of inputs, by their names and orders, each at all speeds."""
    found: Excitations = {}
    for name, harmonics in given.items():
        key = system.key(name)
        if not isinstance(harmonics, Mapping) or not harmonics:
            raise OptionError(
                f"order_response: excitation {key}: amplitudes by orders are needed, such as "
                "{2: 100.0}."
            )
        found[key] = {}
        for order, amplitude in harmonics.items():
            if not (np.isfinite(order) and order > 0):
                raise OptionError(
                    f"order_response: excitation {key}: order {order!r} must be positive."
                )
            value = amplitude(speeds) if callable(amplitude) else amplitude
            try:
                own = np.broadcast_to(np.asarray(value, dtype=complex), speeds.shape)
            except (TypeError, ValueError):
                raise OptionError(
                    f"order_response: excitation {key}, order {order:g}: one amplitude, or one for "
                    f"each of the {len(speeds)} speeds is needed."
                ) from None
            if not np.isfinite(own).all():
                raise OptionError(
                    f"order_response: excitation {key}, order {order:g}: an amplitude is not "
                    "finite."
                )
            found[key][float(order)] = own
    return found


def move_excitations(given: Given, known: Excitations, old: Real, speeds: Real) -> Given:
    """The same at other speeds: functions as they are, numbers on lines between those known."""

    def move(values: Complex) -> Complex:
        found: Complex = np.interp(speeds, old, values.real) + 1j * np.interp(
            speeds, old, values.imag
        )
        return found

    return {
        name: {
            order: own if callable(own) else move(known[name][float(order)])
            for order, own in harmonics.items()
        }
        for name, harmonics in given.items()
    }


def choose_orders(orders: Iterable[float] | None, wanted: Excitations, steady: Rotation) -> Real:
    """Orders to compute, ascending."""
    given = {order for harmonics in wanted.values() for order in harmonics}
    if orders is None:
        if steady.turns_matter:
            given |= {i / steady.turns for i in range(1, HIGHEST * steady.turns + 1)}
        if not given:
            raise OptionError(
                f"{steady.system.name}: nothing excites: no torque depends on {steady.shaft}. Add "
                "parts whose torque does, such as cylinders or blades, or give excitations=."
            )
        return np.array(sorted(given))
    chosen = np.array(sorted({float(order) for order in orders}))
    if not len(chosen) or chosen[0] <= 0:
        raise OptionError("order_response: orders must be positive periods for each turn.")
    if steady.turns_matter:
        cycles = chosen * steady.turns
        for order in chosen[np.abs(cycles - np.rint(cycles)) > 1e-9].tolist():
            if order not in given:
                raise OptionError(
                    f"order_response: order {order:g} is no whole number of periods in "
                    f"{steady.turns} turn{'s' * (steady.turns > 1)} of {steady.shaft}; give turns=."
                )
    return chosen
