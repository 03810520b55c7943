"""Steady vibration of a drive that turns, order by order over the speed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.points.situation import situation
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import speed_unit
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.validity import ranges
from lumped.vibration.ordered.linearity import Linearity, linearity, refuse_vibration_outside
from lumped.vibration.ordered.mean_power import mean_power
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_excitations import (
    HIGHEST,
    Amplitude,
    Given,
    choose_orders,
    find_excitations,
    move_excitations,
)
from lumped.vibration.ordered.order_solution import (
    Excitations,
    OrderEquations,
    OrderSolution,
    find_amplitudes,
    input_amplitudes,
)
from lumped.vibration.responses.amplitudes import refuse_rates
from lumped.vibration.rotating.find_rotation import find_rotation
from lumped.vibration.rotating.harmonics import find_met_order
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import (
    SmallVibrations,
    amplitude_laws,
    small_vibrations,
)


@dataclass(frozen=True, eq=False)
class OrderResponse(OrderAmplitudes):
    """Steady vibration over the speed; ``response[name]`` has the shape (speeds, orders).

    Attributes
    ----------
    system, speeds, orders, of, values, means
        As in `OrderAmplitudes`.
    rotation : Rotation
        Steady rotation about which it vibrates.
    residual : float
        Largest backward error of the equations solved.
    damping_ratio : float
        What was added to the damping of every elastic mode.
    excitations : dict of str to dict of float to ndarray of complex, shape (k,)
        Amplitudes that were given, by inputs and orders.
    law_amplitudes : dict of str to ndarray, shape (k,)
        Amplitudes that were found at which laws hold, by their parameters.
    unsettled : float
        Largest difference between these and the vibration, over the amplitude.
    """

    rotation: Rotation
    residual: float
    damping_ratio: float
    excitations: Excitations
    law_amplitudes: dict[str, Real]
    unsettled: float
    _states: Complex
    _given: Given
    _named: tuple[float, ...] | None

    @property
    def small(self) -> SmallVibrations:
        """The equations of small vibrations that were solved; outputs, then those of laws."""
        more = amplitude_laws(self.system).quantities
        return small_vibrations(self.system, tuple(self.excitations), self.of + more)

    @property
    def _laws_at(self) -> Real:
        """Amplitudes at which laws hold, shape (k, m)."""
        return np.reshape(list(self.law_amplitudes.values()), (-1, len(self.speeds))).T

    @cached_property
    def linearity(self) -> Linearity | None:
        """Where the vibration leaves the range in which its linearisation holds, at some speeds.

        None if the equations are linear, or the orders have no common cycle.
        """
        return linearity(self.small, self.solution_at, self.speeds, self.orders, self.values)

    @property
    def notes(self) -> tuple[str, ...]:
        """Where the linearisation does not hold, and orders that nobody named."""
        return self.tell_notes(self.speeds)

    def tell_notes(self, speeds: Real) -> tuple[str, ...]:
        """The same with further speeds, between its own, at which that may be worse."""
        new = np.setdiff1d(speeds, self.speeds)
        known = [self.linearity, self.at_speeds(new).linearity if len(new) else None]
        found = sorted((each for each in known if each is not None), key=lambda own: -own.share)
        told = [k for k in found if k is found[0] or (k.released and not found[0].released)]
        return (*(each.note for each in told if each.note), *self._left_out)

    @cached_property
    def _left_out(self) -> tuple[str, ...]:
        """What higher orders meet, if none were named."""
        if self._named is not None or not self.rotation.turns_matter:
            return ()
        first = find_met_order(self.small, self.rotation, HIGHEST)
        if first is None:
            return ()
        order, hertz = first
        return (
            f"orders above {HIGHEST} were not computed, as none are named; from order {order:g} "
            f"on they meet natural frequencies ({hertz:.4g} Hz) at these speeds",
        )

    @cached_property
    def _inputs(self) -> Complex:
        """Amplitudes of inputs, shape (k, o, inputs)."""
        return input_amplitudes(self.excitations, self.speeds, self.orders)

    def solution_at(self, k: int) -> OrderSolution:
        """The equations and their solution at one speed."""
        steady, u = self.rotation.at(k), self._inputs[k : k + 1]
        equations = OrderEquations(self.small, steady, self.orders, u, self.damping_ratio)
        return equations.solve_vibration(self._laws_at[k : k + 1])

    def turning(
        self, speeds: Real, parameters: Changes | None = None, at: OperatingPoint | None = None
    ) -> Rotation:
        """Steady rotation found in the same way at other speeds, with other parameters or point.

        Raises
        ------
        OptionError
            If the operating points were given at each speed.
        """
        old = self.rotation
        if old.is_given and at is None:
            if len(old.points) > 1:
                raise OptionError(
                    f"{self.system.name}: operating points that were given at each speed, at=, "
                    "tell nothing of others; let a parameter balance the mean torques, "
                    "order_response(free=...)."
                )
            (at,) = old.points
        own = (parameters or old.points[0].parameters) if at is None else None
        return find_rotation(
            "order_response", self.system, old.shaft, speeds, old.turns, at, own, old.balancing
        )

    def again(self, parameters: Changes, at: OperatingPoint | None = None) -> OrderResponse:
        """The same with other parameters, or at an operating point that has them."""
        steady = self.turning(self.speeds, parameters, at)
        wanted = self.orders, self.excitations, self.damping_ratio, self._given, self._named
        return _respond(self.system, tuple(self.excitations), self.of, steady, *wanted)

    def at_speeds(self, speeds: Real) -> OrderResponse:
        """The same at other speeds, ascending, between its own.

        Operating points, and amplitudes that were given as numbers at each speed, lie on lines.
        """
        steady = self.rotation
        is_fixed = steady.is_given and len(steady.points) > 1
        steady = steady.on_lines(speeds) if is_fixed else self.turning(speeds)
        given = move_excitations(self._given, self.excitations, self.speeds, speeds)
        moved = find_excitations(self.system, given, speeds)
        wanted = self.orders, moved, self.damping_ratio, self._given, self._named
        return _respond(self.system, tuple(self.excitations), self.of, steady, *wanted)

    @checked
    def mean_power(self, quantity: Name) -> Real:
        """Mean of a quantity that is quadratic in the vibration, of each order, shape (k, o).

        Such as the power that a coupling or a damper dissipates: ``(1/2) d |w_rel|^2`` of each
        order; over the turns these add up. What the quantity is without vibration does not count.

        Parameters
        ----------
        quantity : name
            Any quantity or formula of the system, such as ``"coupling.power"``.
        """
        key = self.system.key(quantity)
        z = np.concatenate([self._states, self._inputs], axis=2)
        return mean_power(self.small, self.rotation, self.orders, key, z, self._laws_at)

    def number_of(self, speed: float, caller: str) -> int:
        """Which of the speeds one is.

        Raises
        ------
        OptionError
            If it was not computed.
        """
        k = int(np.abs(self.speeds - speed).argmin())
        if not np.isclose(self.speeds[k], speed, rtol=1e-9):
            raise OptionError(
                f"{caller}: {speed:g} rad/s is none of the speeds of the response; the nearest is "
                f"{self.speeds[k]:.9g}."
            )
        return k

    def __repr__(self) -> str:
        settled = f", amplitudes to {self.unsettled:.1e}" if self.law_amplitudes else ""
        speed = speed_unit()
        low, high = (speed.value(self.speeds[i]) for i in (0, -1))
        head = (
            f"{self.system.name}: {len(self.orders)} orders at {len(self.speeds)} speeds from "
            f"{low:g} to {high:g} {speed.unit}; residual {self.residual:.1e}"
            f"{settled}{situation(self.rotation.points[0])}"
        )
        return "\n".join([head, self.largest_orders(), *self.notes])


@checked
def order_response(
    system: System,
    *,
    speeds: ArrayLike,
    of: Iterable[Name],
    orders: Iterable[float] | None = None,
    shaft: Name | None = None,
    turns: int = 1,
    excitations: Mapping[Name, Mapping[float, Amplitude]] | None = None,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None = None,
    free: Name | None = None,
    damping_ratio: float = 0.0,
    parameters: Changes | None = None,
) -> OrderResponse:
    """Steady vibration over the speed of a shaft, order by order.

    The drive is linearised about steady rotation and excited by what does not turn steadily then:
    torques that follow from the angle of the shaft (gas and mass forces of cylinders, propeller
    blades, meshes), with all their orders, if its angle is named in `shaft`; and by `excitations`.
    The matrices are means over the turns, so that inertias and stiffnesses that vary with the angle
    count with their means and their excitation (first order in the variation; `lumped.periodic`
    takes them as they are).

    Laws whose stiffness or damping depends on the frequency of the vibration have at each order the
    frequency of that order. Laws that depend on the amplitude of a vibration, such as couplings of
    natural rubber, hold at half the range of its synthesis (of the sum of the amplitudes, if the
    orders have no common cycle). It is found at each speed to 1e-10; of several possible amplitudes
    it is the one that grows from rest.

    Parameters
    ----------
    system : System
        From `assemble`.
    speeds : array_like, shape (k,)
        Speeds of the shaft from which orders count, rad/s, ascending.
    of : iterable of names
        Quantities to observe.
    orders : iterable of float, optional
        Periods for each turn of the shaft; default is those of `excitations`, or up to 12 with
        `shaft`, of which some may excite nothing.
    shaft : name, optional
        The angle of that shaft, rad. Torques that depend on it excite.
    turns : int
        Turns of it after which everything repeats: 2 for a four-stroke engine, which has half
        orders.
    excitations : mapping of name to mapping of float to amplitude, optional
        Inputs (parameters, or inputs given as numbers), and for each order its complex amplitude:
        a number, one for each speed, or a function of the speeds. The input is
        ``Re(amplitude exp(j order angle))``.
    at : OperatingPoint or callable, optional
        Where to linearise, or a function of the speed that gives it. By default all parts turn
        together with `shaft`, and twists keep their start values.
    free : name, optional
        Parameter, such as the torque of the load, that lets mean torques balance at each speed; all
        states follow from the balance. Needed where stiffness or damping depends on the mean
        torque and `at` is not given.
    damping_ratio : float
        Of every elastic mode of the drive without its dampers, added to these.
    parameters : mapping of name to float, optional
        Parameters to change.

    Returns
    -------
    OrderResponse

    Raises
    ------
    OptionError
        If speeds are not ascending and positive, an order is not positive, one of `orders` excites
        nothing, or options contradict each other.
    UnknownNameError
        If a name does not exist.
    SolverError
        If there is no steady rotation, a vibration is unbounded, takes a component beyond where its
        equations hold, or finds no amplitude at which its laws agree with it.

    Notes
    -----
    Source of the method: Nestorides, A Handbook on Torsional Vibration (1958), forced vibrations by
    harmonic components.
    """
    grid = np.asarray(speeds, dtype=float).ravel()
    if not len(grid) or grid[0] <= 0 or (np.diff(grid) <= 0).any():
        raise OptionError(
            "order_response: speeds must be ascending and above zero, rad/s: at standstill no "
            "order has a frequency."
        )
    given = {system.key(name): own for name, own in (excitations or {}).items()}
    wanted = find_excitations(system, given, grid)
    if not wanted and shaft is None:
        raise OptionError(
            "order_response: nothing excites; name the angle of the shaft whose torques excite, "
            "shaft=, or give excitations={'load.tau': {2: 100.0}}."
        )
    if not 0 <= damping_ratio < 1:
        raise OptionError(
            f"order_response: damping_ratio = {damping_ratio:g} must be at least 0 and below 1."
        )
    inputs, outputs = tuple(wanted), tuple(system.key(name) for name in of)
    if not outputs:
        raise OptionError("order_response: name at least one quantity to observe, of=[...].")
    refuse_rates(system, inputs)
    found = find_rotation("order_response", system, shaft, grid, turns, at, parameters, free)
    chosen = choose_orders(orders, wanted, found)
    named = None if orders is None else tuple(chosen.tolist())
    response = _respond(
        found.system, inputs, outputs, found, chosen, wanted, damping_ratio, given, named
    )
    if orders is not None:
        _refuse_still(response)
    return response


def _respond(
    system: System,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    steady: Rotation,
    orders: Real,
    wanted: Excitations,
    damping_ratio: float,
    given: Given,
    named: tuple[float, ...] | None,
) -> OrderResponse:
    """The vibration about a steady rotation."""
    watched, laws = tuple(held.formula for held in ranges(system)), amplitude_laws(system)
    small = small_vibrations(system, inputs, outputs + laws.quantities + watched)
    u = input_amplitudes(wanted, steady.speeds, orders)
    equations = OrderEquations(small, steady, orders, u, damping_ratio)
    count = len(outputs)
    at, unsettled = find_amplitudes(equations, count)
    solved = equations.solve_vibration(at)
    first = count + len(laws.quantities)
    refuse_vibration_outside(
        small, steady, orders, solved.means[:, first:], solved.y[:, :, first:], at
    )
    return OrderResponse(
        system,
        steady.speeds,
        orders,
        outputs,
        solved.y[:, :, :count],
        solved.means[:, :count],
        steady,
        solved.residual,
        damping_ratio,
        wanted,
        dict(zip(laws.names, at.T, strict=True)),
        unsettled,
        solved.x,
        given,
        named,
    )


def _refuse_still(response: OrderResponse) -> None:
    """Refuse orders that move nothing at any speed."""
    moves = response._states.any(axis=(0, 2)) | response.values.any(axis=(0, 2))
    for order in response.orders[~moves].tolist():
        raise OptionError(
            f"{response.system.name}: order {order:g} excites nothing; leave it out, or give its "
            "excitation."
        )
