"""Order response and Campbell diagram of a drive that itself says at which speeds it turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lumped.drawing.torsional_study import strongest_orders
from lumped.errors import LumpedError
from lumped.explorer.study import Analysis, Moment, Study, Values
from lumped.points.start import start_point
from lumped.support.arrays import Real
from lumped.support.made_once import Recent
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.ordered.order_response import OrderResponse, order_response
from lumped.vibration.rotating.find_rotation import find_rotation
from lumped.vibration.rotating.harmonics import harmonics
from lumped.vibration.rotating.rotation import speed_of
from lumped.vibration.rotating.small_vibrations import small_vibrations
from lumped.vibration.speeds.campbell import Campbell, campbell
from lumped.vibration.speeds.mean_campbell import mean_campbell

_ANGLES = 12
"""Angles that are tried as that of the shaft from which orders count."""
_SPEEDS = 40
_RANGE = 0.1, 1.1
"""Least and greatest speed over the greatest that the drive has."""
_HIGHEST = 12
"""Highest order that is looked for."""
_ORDERS = 6
"""Orders in a Campbell diagram, those that excite most."""
_VARIES = 1e-3
"""Relative change of a natural frequency over the speeds from which on it is shown."""


def find_analyses(study: Study) -> dict[str, Analysis]:
    """Pictures over the speed, by their titles, where the equations say that there is something.

    Torques that follow from the angle of a shaft excite orders. Its speeds are those up to a tenth
    above the greatest of the run, or of the start without one. Without such torques, a Campbell
    diagram is made if natural frequencies depend on the speed. All parts turn together, or as they
    do at the start.
    """
    moment = Moment(study, study.base)
    if not study.of:
        return {}
    try:
        names = [name for name in moment.modes.angles if study.system.quantity(name).unit == "rad"]
    except Exception:  # functions of the user may raise anything; the pictures tell it
        return {}
    shafts = [
        _Shaft(study, name, speeds, together)
        for name in names[:_ANGLES]
        if len(speeds := _speeds(moment, name))
        for together in (True, False)
    ]
    for shaft in shafts:
        for turns in (1, 2):
            if len(orders := shaft.exciting(moment, turns)):
                return _by_orders(shaft, turns, orders)
    for shaft in shafts:
        if shaft.varies(moment):
            return {f"Campbell diagram over {shaft.angle}": shaft.campbell}
    return {}


def _speeds(moment: Moment, angle: str) -> Real:
    """Speeds of a shaft to look at, rad/s; none if it stands, or has no speed."""
    try:
        name = speed_of(moment.study.system, angle)
        seen = moment.point[name] if moment.study.until is None else moment.run[name]
    except LumpedError:
        return np.zeros(0)
    top = float(np.abs(seen).max())
    return np.linspace(*_RANGE, _SPEEDS) * top if np.isfinite(top) and top else np.zeros(0)


@dataclass(frozen=True)
class _Shaft:
    """A shaft from which orders count, and how the drive turns with it.

    Attributes
    ----------
    study : Study
        What is shown.
    angle : str
        Its angle.
    speeds : ndarray, shape (k,)
        Its speeds, rad/s.
    together : bool
        All parts turn with it; else all speeds are in proportion to those at the start.
    """

    study: Study
    angle: str
    speeds: Real
    together: bool

    def at(self, values: Values) -> Callable[[float], OperatingPoint]:
        """Operating points at its speeds."""
        system, name = self.study.system, speed_of(self.study.system, self.angle)
        if self.together:
            return lambda w: start_point(system, parameters=values, start={name: w}, together=True)
        point = Moment(self.study, values).point
        first = dict(zip(system.state_names, point.x.tolist(), strict=True))
        moving = [each for each in first if system.quantity(each).unit in ("rad/s", "m/s")]
        own = float(point[name])

        def scale_point(w: float) -> OperatingPoint:
            start = first | {each: first[each] * w / own for each in moving}
            return start_point(system, parameters=values, start=start)

        return scale_point

    def exciting(self, moment: Moment, turns: int) -> Real:
        """Orders in which torques follow from its angle."""
        system, orders = moment.study.system, np.arange(1, _HIGHEST * turns + 1) / turns
        try:
            at = self.at(moment.parameters)
            turned = find_rotation(
                "explore", system, self.angle, self.speeds[[0, -1]], turns, at, None, None
            )
            rates = harmonics(small_vibrations(system, (), ()), turned, orders)[0]
        except (LumpedError, ZeroDivisionError):  # it stands at the start
            return np.zeros(0)
        return orders[rates.any(axis=(0, 2))]

    def varies(self, moment: Moment) -> bool:
        """Whether natural frequencies depend on its speed."""
        try:
            ends = replace(self, speeds=self.speeds[[0, -1]]).campbell(moment.parameters).hertz
        except (LumpedError, ZeroDivisionError):  # it stands at the start
            return False
        return bool((np.ptp(ends, axis=0) > _VARIES * np.abs(ends).max(axis=0)).any())

    def campbell(self, values: Values) -> Campbell:
        """Natural frequencies over its speed."""
        at = self.at(values)
        return campbell(self.study.system, speeds=self.speeds, orders=[1.0], at=at)


def _by_orders(shaft: _Shaft, turns: int, orders: Real) -> dict[str, Analysis]:
    study, angle = shaft.study, shaft.angle
    units = [study.system.quantity(name).unit for name in study.of]
    unit = "N.m" if "N.m" in units else units[0]
    of = [name for name, own in zip(study.of, units, strict=True) if own == unit]
    known = Recent[OrderResponse](1)

    def response(values: Values) -> OrderResponse:
        how: dict[str, Any] = {"parameters": values}
        if not shaft.together:
            how = {"at": shaft.at(values)}
        return known.of(
            tuple(values.items()),
            lambda: order_response(
                study.system,
                speeds=shaft.speeds,
                of=of,
                orders=orders,
                shaft=angle,
                turns=turns,
                **how,
            ),
        )

    def diagram(values: Values) -> Campbell:
        found = response(values)
        return mean_campbell(found, orders=strongest_orders([found], _ORDERS))

    return {f"Order response over {angle}": response, f"Campbell diagram over {angle}": diagram}
