"""What a report on torsional vibrations is made from, checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.system import System
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.support.arrays import Real
from lumped.support.display_units import (
    Shown,
    Units,
    choose_units,
    display,
    frequency_unit,
    speed_unit,
)
from lumped.support.units import plain
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.inertias.mass_elastic import MassElastic, mass_elastic
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.rules.limits import Limit
from lumped.vibration.rules.measures import show_peaks
from lumped.vibration.rules.separation import separation
from lumped.vibration.rules.verdict import Verdict, verdict
from lumped.vibration.speeds.campbell import Campbell, CriticalSpeed
from lumped.vibration.speeds.mean_campbell import mean_campbell, modes_at

Limits = Iterable[Limit] | Mapping[str, Iterable[Limit]]

MOST_ORDERS = 6
"""Orders of a quantity that are drawn, the largest."""
_SAME = 1e-9
"""Relative difference of speeds that is rounding."""
_ALIKE = 0.9
"""Modal assurance criterion, with the inertias, above which a shape is the same."""


@dataclass(frozen=True, eq=False)
class Study:
    """Results of a torsional vibration calculation.

    Attributes
    ----------
    responses, runs : dict
        Order responses and runs, by their captions.
    limits : dict of str to tuple of Limit
        Limits, by these captions.
    operation : tuple of float or None
        First and last speed of operation, rad/s.
    margin : float or None
        Least distance of critical speeds from it.
    modes : Modes
        At the mean state of `place`.
    campbell : Campbell
        Over the speeds of the first response.
    is_at_means : bool
        Whether that is at the mean state of each speed.
    place : int
        Number of the speed in the middle of the operation, or of the last.
    heat : dict of str to dict of str to ndarray
        Mean dissipated power over the speeds of a response, W, by its caption and the part.
    units : mapping of str to str
        Units to show.
    """

    responses: dict[str, OrderResponse]
    runs: dict[str, Trajectory]
    limits: dict[str, tuple[Limit, ...]]
    operation: tuple[float, float] | None
    margin: float | None
    modes: Modes
    campbell: Campbell
    is_at_means: bool
    place: int
    heat: dict[str, dict[str, Real]]
    units: Units

    @property
    def first(self) -> OrderResponse:
        """The response of the drive as it should be."""
        return next(iter(self.responses.values()))

    @property
    def system(self) -> System:
        """Its system."""
        return self.first.system

    @property
    def outputs(self) -> list[str]:
        """Quantities of all responses."""
        return list(dict.fromkeys(name for r in self.responses.values() for name in r.of))

    def having(self, output: str) -> dict[str, OrderResponse]:
        """Responses that have a quantity."""
        return {key: r for key, r in self.responses.items() if output in r.of}

    def unit(self, output: str) -> str:
        """SI unit of a quantity."""
        return next(iter(self.having(output).values())).system.quantity(output).unit

    def choose_unit(self, output: str) -> Shown:
        """How amplitudes of a quantity are shown."""
        return display(output, self.unit(output), self.units, is_change=True)

    @cached_property
    def speed(self) -> Shown:
        """How speeds are shown."""
        return speed_unit(self.units)

    @cached_property
    def frequency(self) -> Shown:
        """How frequencies are shown."""
        return frequency_unit(self.units)

    @cached_property
    def power(self) -> Shown:
        """How dissipated powers are shown."""
        return display("power", "W", self.units)

    def measure_orders(self, output: str) -> dict[str, dict[float, tuple[float, float]]]:
        """Largest amplitude of each order and its speed, rad/s, in each response that has it."""
        found = {}
        for caption, response in self.having(output).items():
            size = np.abs(response[output])
            at = response.speeds[size.argmax(axis=0)].tolist()
            peaks = zip(size.max(axis=0).tolist(), at, strict=True)
            found[caption] = dict(zip(response.orders.tolist(), peaks, strict=True))
        return found

    def limits_of(self, caption: str, output: str) -> list[Limit]:
        """Limits of a quantity in a response."""
        system = self.responses[caption].system
        return [x for x in self.limits.get(caption, ()) if system.key(x.quantity) == output]

    @property
    def orders_left_out(self) -> list[float]:
        """Orders of the responses that the Campbell diagram does not have."""
        every = {order for r in self.responses.values() for order in r.orders.tolist()}
        return sorted(every - set(self.campbell.orders))

    def find_watched(self, caption: str) -> list[str]:
        """Quantities of the responses and of its limits that a run has.

        Raises
        ------
        OptionError
            If there is none.
        """
        run = self.runs[caption]
        limited = [run.system.key(limit.quantity) for limit in self.limits.get(caption, ())]
        known = set(run)
        found = [x for x in dict.fromkeys((*self.outputs, *limited)) if x in known]
        if not found:
            raise OptionError(
                f"torsional_report: the run '{caption}' has none of the quantities of the "
                f"responses: {', '.join(self.outputs)}."
            )
        return found

    @cached_property
    def verdicts(self) -> dict[str, Verdict]:
        """Verdicts by captions, that on separation last."""
        every: dict[str, OrderResponse | Trajectory] = {**self.responses, **self.runs}
        found = {key: verdict(every[key], own) for key, own in self.limits.items() if own}
        if self.margin is not None and self.operation is not None:
            found["critical speeds"] = separation(
                self.campbell, between=self.operation, margin=self.margin
            )
        return found

    @property
    def reach(self) -> tuple[float, float]:
        """Least and greatest frequency of the orders of the Campbell diagram, Hz."""
        speeds = self.first.speeds / (2 * np.pi)
        orders = self.campbell.orders
        return float(speeds[0] * min(orders)), float(speeds[-1] * max(orders))

    @cached_property
    def drive(self) -> MassElastic | str:
        """Inertias and stiffnesses at the point of the modes, or why there are none."""
        shaft = self.first.rotation.shaft
        if shaft is None:
            turning = (x for x in self.modes.angles if self.system.quantity(x).unit == "rad")
            shaft = next(turning, None)
        if shaft is None:
            return f"{self.system.name}: no shaft turns."
        try:
            return mass_elastic(self.modes, shaft=shaft)
        except (OptionError, UnknownNameError) as error:
            return str(error)

    @cached_property
    def counterparts(self) -> list[int | None]:
        """The mode to which each mode without damping belongs, by its shape."""
        drive = self.drive
        if not isinstance(drive, MassElastic) or not len(self.modes.hertz):
            return [] if isinstance(drive, str) else [None] * len(drive.hertz)
        J = np.array([part.J for part in drive.inertias])
        names = [part.name for part in drive.inertias]
        damped = np.array([self.modes.shape(angle) for angle in _angles_of(self.system, names)])
        sizes = (J[:, None] * np.abs(damped) ** 2).sum(axis=0)
        found: list[int | None] = []
        for mode in range(len(drive.hertz)):
            holzer = drive.holzer(mode)
            shape = np.array([holzer.angle(name) for name in names])
            alike = np.abs((J * shape) @ damped) ** 2 / ((J * shape**2).sum() * sizes)
            best = int(alike.argmax())
            found.append(best if alike[best] > _ALIKE and best not in found else None)
        return found

    def distance(self, critical: CriticalSpeed) -> float:
        """Distance of a critical speed from the operation, over the nearest end; 0 inside."""
        assert self.operation is not None
        low, high = self.operation
        if critical.speed < low:
            return 1 - critical.speed / low
        return max(critical.speed / high - 1, 0.0)


def study(
    responses: OrderResponse | Mapping[str, OrderResponse],
    *,
    limits: Limits = (),
    operation: tuple[float | str, float | str] | None = None,
    margin: float | None = None,
    orders: Iterable[float] | None = None,
    found_modes: Modes | None = None,
    found_campbell: Campbell | None = None,
    heat: Mapping[str, Mapping[str, ArrayLike]],
    runs: Mapping[str, Trajectory],
    units: Units = None,
) -> Study:
    """Results put together and checked; what was not given is computed.

    Raises
    ------
    OptionError
        If there is no response, the operation makes no sense, an order was not computed, or a run
        has none of the quantities.
    UnknownNameError
        If a caption is that of no response and no run.
    UnitError
        If a unit does not fit.
    """
    given = {"": responses} if isinstance(responses, OrderResponse) else dict(responses)
    if not given:
        raise OptionError("torsional_report: give at least one order response.")
    for caption in given.keys() & runs.keys():
        raise OptionError(f"torsional_report: '{caption}' is the caption of a response and a run.")
    first = next(iter(given.values()))
    between = None if operation is None else _operation(operation, first)
    if margin is not None and between is None:
        raise OptionError("torsional_report: a margin needs the speeds of operation, operation=.")
    drawn = _orders(orders, given)
    middle = first.speeds[-1] if between is None else 0.5 * (between[0] + between[1])
    filled = {caption: show_peaks(response) for caption, response in given.items()}
    first = next(iter(filled.values()))
    place = int(np.abs(first.speeds - middle).argmin())
    own_modes = modes_at(first)(float(first.speeds[place])) if found_modes is None else found_modes
    return Study(
        filled,
        dict(runs),
        _limits(limits, given, runs),
        between,
        margin,
        own_modes,
        found_campbell or _campbell(first, drawn, between, margin or 0.0),
        found_campbell is None,
        place,
        _heat(heat, given, filled),
        choose_units(units, _names(first.system, runs), usual="engineering"),
    )


def _names(system: System, runs: Mapping[str, Trajectory]) -> Iterator[str]:
    """All that a unit may be chosen for."""
    yield from ("speed", "frequency", "power", "time", "energy")
    for each in (system, *(run.system for run in runs.values())):
        yield from each.names()
    yield from system.structure.parameters.names


def _operation(given: tuple[float | str, float | str], first: OrderResponse) -> tuple[float, float]:
    low, high = (plain(w, "rad/s", "torsional_report: operation =", OptionError) for w in given)
    if not 0 < low <= high:
        raise OptionError(
            f"torsional_report: operation = {given}: the first and last speed of operation are "
            "needed, rad/s or such as ('1450 rpm', '1550 rpm'), above zero."
        )
    begin, end = first.speeds[0], first.speeds[-1]
    if low < begin * (1 - _SAME) or high > end * (1 + _SAME):
        scale = 30 / np.pi
        raise OptionError(
            f"torsional_report: operation from {low * scale:g} to {high * scale:g} 1/min, but the "
            f"response was computed from {begin * scale:g} to {end * scale:g} 1/min only."
        )
    return low, high


def _orders(
    given: Iterable[float] | None, responses: Mapping[str, OrderResponse]
) -> tuple[float, ...]:
    """Orders of the Campbell diagram: as given, or all that were computed."""
    first = next(iter(responses.values()))
    if given is not None:
        wanted = tuple(sorted({float(order) for order in given}))
        for order in wanted:
            first.magnitude(first.of[0], order)
        return wanted
    return tuple(sorted({order for r in responses.values() for order in r.orders.tolist()}))


def strongest_orders(responses: Iterable[OrderResponse], most: int) -> tuple[float, ...]:
    """The largest orders of any quantity, over the largest of that quantity."""
    shares: dict[float, float] = {}
    for response in responses:
        size = np.abs(response.values).max(axis=0)
        largest = (size / np.maximum(size.max(axis=0), 1e-300)).max(axis=1)
        for order, share in zip(response.orders.tolist(), largest.tolist(), strict=True):
            shares[order] = max(share, shares.get(order, 0.0))
    return tuple(sorted(sorted(shares, key=lambda order: -shares[order])[:most]))


def _campbell(
    response: OrderResponse,
    orders: tuple[float, ...],
    operation: tuple[float, float] | None,
    margin: float,
) -> Campbell:
    """Natural frequencies over the speeds, or the lower half of a single one, and the margin."""
    begin, end = float(response.speeds[0]), float(response.speeds[-1])
    begin = begin if len(response.speeds) > 1 else 0.5 * begin
    if operation is not None:
        begin, end = (
            min(begin, operation[0] * (1 - margin)),
            max(end, operation[1] * (1 + margin)),
        )
    return mean_campbell(response, orders=orders, between=(begin, end))


def _angles_of(system: System, parts: list[str]) -> list[str]:
    """Angles of inertias: of their first flange, or of the flange after which they are named."""
    tree = system.structure.tree
    first: dict[str, str] = {}
    for node in tree.instances:
        quantities = node.layout.quantities
        for k in range(0, 2 * len(node.layout.ports), 2):
            if (quantities[k].unit, quantities[k + 1].unit) == ("rad", "N.m"):
                first.setdefault(node.path, tree.unknown_name(node.first_unknown + k))
    return [first.get(part, f"{part}.phi") for part in parts]


def _limits(
    given: Limits, responses: Mapping[str, OrderResponse], runs: Mapping[str, Trajectory]
) -> dict[str, tuple[Limit, ...]]:
    if not isinstance(given, Mapping):
        every = tuple(given)
        return dict.fromkeys(responses, every) if every else {}
    for caption in given:
        _refuse_unknown(caption, [*responses, *runs], "limits", "response and no run")
    return {caption: tuple(own) for caption, own in given.items()}


def _heat(
    given: Mapping[str, Mapping[str, ArrayLike]],
    responses: Mapping[str, OrderResponse],
    filled: Mapping[str, OrderResponse],
) -> dict[str, dict[str, Real]]:
    found: dict[str, dict[str, Real]] = {}
    for caption, parts in given.items():
        _refuse_unknown(caption, list(responses), "heat", "response")
        found[caption] = {}
        for part, power in parts.items():
            shape = responses[caption].speeds.shape
            try:
                values = np.asarray(power, dtype=float)
            except (TypeError, ValueError):
                values = np.zeros(0)
            if values.shape != shape or not np.isfinite(values).all():
                raise OptionError(
                    f"torsional_report: heat of {part} in '{caption}': a power, W, at each of the "
                    f"{shape[0]} speeds is needed."
                )
            speeds = responses[caption].speeds
            found[caption][part] = np.interp(filled[caption].speeds, speeds, values)
    return found


def _refuse_unknown(caption: str, known: Sequence[str], option: str, what: str) -> None:
    if caption not in known:
        raise UnknownNameError(
            f"torsional_report: {option}: '{caption}' is the caption of no {what}. "
            f"{nearest(caption, known)}"
        )
