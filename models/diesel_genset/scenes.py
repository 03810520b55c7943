"""Vibrations of the diesel engine: steady over the speed, with a misfire, and in a start."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import lumped as lp
from lumped.components import Engine
from lumped.models.diesel_genset.drive import ENGINE, RPM, SHAFTS, Crankshaft, Genset, load
from lumped.models.sources import Given

CASES = {
    "all cylinders fire": "none",
    "cylinder 1 compresses only": "compression",
    "cylinder 1 has no gas": "no gas",
}
"""What the cylinder 1 misses."""

SPEEDS = tuple(range(1000, 2551, 25))
"""Speeds at which the source looks, 1/min."""
SLOW = tuple(range(420, 1801, 30))
"""Speeds at which the genset is looked at, 1/min."""
BEGIN = Given(120 * RPM, "rad/s", "A", "speed that the starter gives, 120 1/min")
FUEL = Given(0.3, "1", "A", "factor of the pressure in the start")


def misfiring(model: Crankshaft, kind: str, cylinder: int = 1) -> Crankshaft:
    """The drive with a cylinder that may not fire.

    Parameters
    ----------
    model : Crankshaft
        The drive.
    kind : str
        "no gas", "compression" and expansion without firing, or "none" if it fires.
    cylinder : int
        Its number.
    """
    return model.with_({"engine.misfire": {cylinder: kind}})


def response(
    rpm: ArrayLike = SPEEDS,
    model: Crankshaft | None = None,
    of: Iterable[str] = SHAFTS,
    parameters: Mapping[str, Any] | None = None,
) -> lp.vibration.OrderResponse:
    """Steady vibration by the cylinders, orders 0.5 to 12.

    The pressure is that of the mean speed, as in the source. `Engine(over_speed=...)` would let it
    follow the speed within the vibration too.

    Parameters
    ----------
    rpm : array_like
        Speeds, 1/min.
    model : Crankshaft, optional
        The drive.
    of : iterable of str
        Quantities to observe.
    parameters : mapping, optional
        Parameters to change.
    """
    system = lp.assemble(model or Crankshaft())

    def at(w: float) -> lp.OperatingPoint:
        own = {"engine.load": load(w)} | dict(parameters or {})
        return lp.start_point(system, parameters=own, start=_turning(system, w), together=True)

    return lp.vibration.order_response(
        system,
        speeds=np.asarray(rpm, dtype=float) * RPM,
        of=of,
        shaft="flywheel.phi",
        turns=2,
        at=at,
    )


@cache
def solve_crankshaft(case: str = "all cylinders fire") -> lp.vibration.OrderResponse:
    """Steady vibration of the crankshaft at the speeds of the source, by a key of `CASES`."""
    return response(model=misfiring(Crankshaft(), CASES[case]))


@cache
def solve_coupling(case: str = "all cylinders fire") -> lp.vibration.OrderResponse:
    """Steady vibration of the coupling of the genset at the speeds `SLOW`."""
    return response(SLOW, misfiring(Genset(), CASES[case]), ["coupling.tau"])


def mean_modes(
    model: Crankshaft | None = None, parameters: Mapping[str, Any] | None = None
) -> lp.Modes:
    """Modes in the mean over the turns, at 1500 1/min."""
    system = lp.assemble(model or Crankshaft())
    return lp.vibration.mean_modes(
        system, shaft="flywheel.phi", speed=1500 * RPM, turns=2, parameters=parameters
    )


def vector_sums(
    orders: Iterable[float] = (0.5, 1, 1.5, 2, 2.5, 3, 4.5, 6),
) -> lp.vibration.VectorSums:
    """Sums of the amplitudes of the cylinders in each mode, with the phases of the orders."""
    phases: dict[str | lp.Expr, float] = {
        f"engine.throw[{i}].phi": phase for i, phase in enumerate(ENGINE.phases)
    }
    return lp.vibration.vector_sums(mean_modes(), phases, orders=orders)


class Start(Genset):
    """The genset without the damping of the throws, which would brake more than the engine."""

    engine: Engine = ENGINE.with_({"d": 0.0, "load": FUEL})


def run_up(until: float = 0.6, model: Genset | None = None, **options: Any) -> lp.Trajectory:
    """The engine fires from the speed of the starter on, without load.

    Parameters
    ----------
    until : float
        End of the run, s.
    model : Genset, optional
        The drive.
    **options
        Passed to `lumped.simulate`.
    """
    system = lp.assemble(model or Start(), keep=["flywheel.phi"])
    parameters = options.pop("parameters", None)
    point = starting(system, parameters, options.pop("start", {}))
    return lp.simulate(system, until=until, start=point, **options)


def starting(
    system: lp.System,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
) -> lp.OperatingPoint:
    """All parts together at the speed of the starter."""
    first = {**_turning(system, BEGIN), **(start or {})}
    return lp.start_point(system, start=first, together=True, parameters=parameters)


def _turning(system: lp.System, w: float) -> dict[str, float]:
    """Start values with which all parts turn at one speed, the ring of a damper too."""
    rings = [name for name in system.state_names if name == "damper.w"]
    return dict.fromkeys(["flywheel.w", *rings], w)
