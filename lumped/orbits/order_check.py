"""Order responses against the periodic motions that they approximate."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.orbits.guesses import after_response
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.periodic import GRID, find_orbit, turning_problem
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import speed_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.vibration.ordered.order_response import OrderResponse


@dataclass(frozen=True, eq=False)
class OrderCheck(RichHtml):
    """How amplitudes of an order response differ from those of periodic motions.

    Attributes
    ----------
    response : OrderResponse
        What was checked.
    speeds : ndarray, shape (k,)
        Where, rad/s.
    values : ndarray of complex, shape (k, o, len(response.of))
        Amplitudes of the periodic motions; nan where none was found.
    differences : ndarray, shape (k, o, len(response.of))
        Size of the difference of the amplitudes, over the largest amplitude of the quantity at that
        speed.
    orbits : tuple of PeriodicOrbit or None
        The motions.
    faults : dict of float to str
        Why there is none, by speed.
    tolerance : float
        Difference up to which the response is right.
    """

    response: OrderResponse
    speeds: Real
    values: Complex
    differences: Real
    orbits: tuple[PeriodicOrbit | None, ...]
    faults: dict[float, str]
    tolerance: float

    @property
    def exceeding(self) -> tuple[tuple[float, str, float, float], ...]:
        """Speed, quantity, order and difference where that exceeds the tolerance; largest first."""
        rows = [
            (float(self.speeds[k]), self.response.of[i], float(self.response.orders[o]), d)
            for k, o, i in np.argwhere(self.differences > self.tolerance).tolist()
            for d in [float(self.differences[k, o, i])]
        ]
        return tuple(sorted(rows, key=lambda row: -row[3]))

    @property
    def holds(self) -> bool:
        """Whether a motion was found at all speeds and no amplitude differs by more."""
        return not self.faults and not self.exceeding

    def __repr__(self) -> str:
        found = [k for k, orbit in enumerate(self.orbits) if orbit is not None]
        count = len(self.exceeding)
        head = (
            f"{self.response.system.name}: order response against {len(found)} periodic motions: "
            f"{count or 'no'} amplitude{'s' * (count != 1)} differ{'s' * (count == 1)} by more "
            f"than {self.tolerance:.3g} of the largest"
        )
        rows, speed = [], speed_unit()
        for k in found:
            place = self.response.number_of(float(self.speeds[k]), "check_orders")
            for i, output in enumerate(self.response.of):
                own, unit = self.differences[k, :, i], self.response.system.quantity(output).unit
                o = int(own.argmax())
                both = self.response.values[place, o, i], self.values[k, o, i]
                at, order = number(speed.value(self.speeds[k])), f"{self.response.orders[o]:g}"
                sizes = amounts(output, unit, *np.abs(both), is_change=True)
                holds = "NO" if own[o] > self.tolerance else "yes"
                rows.append((at, output, order, *sizes, f"{own[o]:.2%}", holds))
        columns = (
            *(f"at, {speed.unit}", "quantity", "order", "response", "motion", "unit"),
            *("difference", "holds"),
        )
        lines = [head, table(columns, rows)] if rows else [head]
        lines += [
            f"at {speed.value(w):.6g} {speed.unit}: {text}" for w, text in self.faults.items()
        ]
        return "\n".join(lines)


@checked
def check_orders(
    response: OrderResponse,
    *,
    speeds: Iterable[float] | None = None,
    tolerance: float = 0.05,
    rtol: float = 1e-10,
    iterations: int = 20,
) -> OrderCheck:
    """Compare an order response with the periodic motions that it approximates.

    These have friction, play, progressive couplings and inertias that vary with the angle as they
    are. Laws of the frequency or the amplitude of a vibration hold in a motion at those that
    parameters state.

    Parameters
    ----------
    response : OrderResponse
        From `order_response` with `shaft` and `free`.
    speeds : iterable of float, optional
        Some of its speeds, rad/s; default is where its quantities vibrate most.
    tolerance : float
        Difference, over the largest amplitude of a quantity at a speed, up to which an amplitude is
        right.
    rtol : float
        As for `periodic`. Tighter than elsewhere: what is missing after a period adds up.
    iterations : int
        Newton steps for each motion after which to give up.

    Returns
    -------
    OrderCheck

    Raises
    ------
    OptionError
        If a speed was not computed, or the response does not determine a motion.
    """
    if not 0 < tolerance < np.inf:
        raise OptionError(f"check_orders: tolerance = {tolerance:g} must be positive.")
    if speeds is None:
        places = sorted(set(np.abs(response.values).sum(axis=1).argmax(axis=0).tolist()))
    else:
        places = [response.number_of(float(w), "check_orders") for w in speeds]
    if not places:
        raise OptionError("check_orders: give at least one speed.")
    problem, free = turning_problem(response.system, response, rtol, iterations)
    turns = response.rotation.turns
    shape = len(places), len(response.orders), len(response.of)
    values, faults = np.full(shape, np.nan, dtype=complex), {}
    orbits: list[PeriodicOrbit | None] = []
    for row, k in enumerate(places):
        try:
            orbit = find_orbit(problem, after_response(problem, response, k), GRID, free)
        except SolverError as fault:
            faults[float(response.speeds[k])] = str(fault)
            orbits.append(None)
            continue
        values[row], _ = order_harmonics(
            orbit, response.of, response.orders, turns, angle_of(response, k)
        )
        orbits.append(orbit)
    size = np.abs(values).max(axis=1, keepdims=True)
    missed = np.abs(values - response.values[places])
    differences = missed / np.where(size > 0, size, np.inf)
    return OrderCheck(
        response, response.speeds[places], values, differences, tuple(orbits), faults, tolerance
    )


def order_harmonics(
    orbit: PeriodicOrbit,
    outputs: tuple[str, ...],
    orders: Real,
    turns: int,
    shaft: tuple[str, float] | None = None,
) -> tuple[Complex, Real]:
    """Amplitudes of orders, shape (o, outputs), and means, shape (outputs,).

    Parameters
    ----------
    turns : int
        Turns in a period.
    shaft : (name, float), optional
        Angle of the shaft, and its value where orders have no phase. They count over what it is on
        average, which grows steadily; without it over the time from the start of the period.
    """
    numbers = np.rint(orders * turns).astype(int)
    offset = 0.0
    if shaft is not None:
        name, zero = shaft
        offset = orbit.mean(name) - np.pi * turns - zero
    turned = np.exp(-1j * orders * offset)
    every = np.array([orbit.harmonics(output, int(numbers.max())) for output in outputs])
    return (every[:, numbers] * turned).T, every[:, 0].real


def angle_of(response: OrderResponse, k: int) -> tuple[str, float]:
    """Angle of the shaft of a response, and its value where orders have no phase at a speed."""
    own, system = response.rotation.at(k), response.system
    assert own.shaft is not None
    function = ca.Function("angle", system.inputs, [system.expressions([own.shaft])])
    value = function(own.x[0], own.theta[0], own.points[0].time, own.settings[0])
    return own.shaft, float(value)
