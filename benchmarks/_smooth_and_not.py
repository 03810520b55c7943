"""Drives of many kinds, over which the methods are compared.

The five published machines; the models of the other benchmarks; small drives that each have one
kind of formula: sine, root, exponential, quotient, power, table, stiff part, events; and random
drives of the tests.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import lumped as lp
from benchmarks._ensemble_tasks import CrankDrive, Lorenz, ThreeClutches, ThreeMasses
from benchmarks.between_steps import EDGES, rotor
from benchmarks.hybrid import Coupled, rubbing
from benchmarks.simulate_mill import Mill
from benchmarks.time_loop import Chain, Drive
from lumped.components import (
    Backlash,
    BearingFriction,
    CrankSlider,
    Damper,
    ElastoBacklash,
    EllipticalGear,
    Fixed,
    Inertia,
    NonlinearSpring,
    QuadraticTorque,
    SpringDamper,
    Torque,
)
from lumped.models import MACHINES, machine
from lumped.ops import cos, exp, interpolate, sin, sqrt, tanh

__all__ = ["Task", "tasks"]

_RANDOM = (("random_drives", (3, 5, 8, 13, 19, 21)), ("hybrid_drives", (704, 707, 711, 715)))


class Task(NamedTuple):
    """A drive and a run of it.

    Attributes
    ----------
    name : str
    system : System
    until : float
        End, s.
    start : mapping or OperatingPoint, optional
    """

    name: str
    system: lp.System
    until: float
    start: Any = None


class _Law(lp.Component):
    """Torque on a shaft by a law of its angle, its speed and the time."""

    flange = lp.Flange()
    law: Any = None
    phi: lp.Var = lp.var("rad", "angle", start=0.3, state="always")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self) -> Any:
        """The law."""
        yield self.phi == self.flange.phi
        yield self.w == lp.der(self.phi)
        yield self.flange.tau == -self.law(self.phi, self.w)


def _ruled(law: Any) -> lp.Component:
    """A body under a law."""
    return lp.compose(
        body=Inertia(J=1.0), push=_Law(law=law), connections=lambda m: lp.chain(m.body, m.push)
    )


def _row(*parts: Any, **given: Any) -> lp.Component:
    """Parts in a row, a torque that swings at its begin."""

    def connections(m: Any) -> Any:
        yield from lp.chain(m.motor, *(getattr(m, name) for name in names))

    names = [f"part{k}" for k in range(len(parts))]
    motor = Torque(tau=given.get("tau", 20 * sin(7 * lp.time)))
    return lp.compose(motor=motor, **dict(zip(names, parts, strict=True)), connections=connections)


def _made() -> Iterator[tuple[str, lp.Component, float]]:
    """Drives that are made here or in other benchmarks."""
    t = lp.time
    yield "three masses, step", ThreeMasses(), 2.0
    yield "three masses, sine", Drive(), 2.0
    yield "undamped mill", Mill(), 2.0
    yield "chain of 300", Chain(), 0.5
    yield "crank drive", CrankDrive(), 2.0
    yield "Lorenz", Lorenz(), 10.0
    yield "three clutches that stick", ThreeClutches(), 5.0
    yield "three clutches that slip", Coupled(), 1.5
    yield "3 bodies that rub", rubbing(3), 10.0
    yield "30 bodies that rub", rubbing(30), 5.0
    yield "pendulum", _ruled(lambda phi, w: -9 * sin(phi)), 20.0
    yield "driven pendulum", _ruled(lambda phi, w: 5 * cos(2 * t) - 9 * sin(phi) - 0.1 * w), 20.0
    yield "Van der Pol", _ruled(lambda phi, w: 2 * (1 - phi * phi) * w - phi), 20.0
    yield "Van der Pol, stiff", _ruled(lambda phi, w: 300 * (1 - phi * phi) * w - phi), 300.0
    yield "hard spring", _ruled(lambda phi, w: 3 * cos(t) - phi**3 - 0.1 * w), 50.0
    yield "root", _ruled(lambda phi, w: 5 * sin(3 * t) - 8 * phi / sqrt(1 + phi * phi)), 20.0
    yield "exponential", _ruled(lambda phi, w: 1 - exp(3 * phi) - 0.2 * w), 20.0
    yield "smooth friction", _ruled(lambda phi, w: 4 * sin(t) - 4 * phi - tanh(5 * w)), 20.0
    yield "slip of a motor", _ruled(lambda phi, w: 9 * (4 - w) / (1 + (4 - w) ** 2) - w), 10.0
    yield "meshing teeth", _ruled(lambda phi, w: 2 - (9 + 3 * cos(30 * t)) * phi - 0.2 * w), 20.0
    yield (
        "seven waves",
        _ruled(lambda phi, w: sum(sin(k * t + k * phi) for k in range(1, 8)) - 4 * phi - w),
        10.0,
    )
    xs, ys = (-2.0, -1.0, -0.2, 0.2, 1.0, 2.0), (-50.0, -12.0, -1.0, 1.0, 12.0, 50.0)
    yield (
        "spring by a table",
        _ruled(lambda phi, w: 3 * cos(2 * t) - interpolate(phi, xs, ys)),
        20.0,
    )
    cubic = NonlinearSpring(characteristic=lambda x: 200 * x + 4e3 * x**3)
    yield "cubic shaft", _row(Inertia(J=1.0), cubic, Inertia(J=0.5)), 5.0
    yield (
        "crank and shaft",
        _row(
            Inertia(J=0.3),
            SpringDamper(c=500.0, d=0.5),
            Inertia(J=0.2),
            CrankSlider(r=0.1, L=0.4, m=3.0, phase=1.0),
        ),
        5.0,
    )
    yield (
        "elliptical gears",
        _row(
            Inertia(J=0.5),
            EllipticalGear(e=0.3),
            Inertia(J=0.5),
            SpringDamper(c=50.0, d=0.1),
            Inertia(J=0.2),
            tau=2.0,
        ),
        5.0,
    )
    yield (
        "play, elastic",
        _row(Inertia(J=1.0), ElastoBacklash(c=800.0, d=1.0, b=0.05), Inertia(J=0.5)),
        5.0,
    )
    yield "play, rigid", _row(Inertia(J=1.0), Backlash(b=0.1, restitution=0.5), Inertia(J=0.5)), 5.0
    fan = QuadraticTorque(tau_nominal=-20.0, w_nominal=15.0)
    yield "fan", _row(Inertia(J=1.0), SpringDamper(c=300.0, d=0.3), Inertia(J=2.0), fan), 10.0
    rub = BearingFriction(characteristic=((0.0, 3.0), (5.0, 4.0)))
    yield "bearing", _row(Inertia(J=1.0), SpringDamper(c=100.0, d=0.3), Inertia(J=2.0), rub), 10.0
    yield (
        "stiff shaft",
        _row(Inertia(J=1.0), SpringDamper(c=1e6, d=2e3), Inertia(J=1.0), Damper(d=1.0), Fixed()),
        10.0,
    )
    yield (
        "fast and slow",
        _row(
            Inertia(J=1.0),
            SpringDamper(c=1e5, d=5.0),
            Inertia(J=1e-2),
            SpringDamper(c=100.0, d=0.1),
            Inertia(J=2.0),
        ),
        2.0,
    )


def _random() -> Iterator[Task]:
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    for module, seeds in _RANDOM:
        made = __import__(module)
        for seed in seeds:
            drive = made.RandomDrive(seed)
            yield Task(
                f"{module.replace('_', ' ')[:-1]} {seed}", lp.assemble(drive.model()), made.END
            )


def tasks() -> Iterator[Task]:
    """All of them."""
    for name, text in MACHINES.items():
        scene = machine(name).scene(grid=1)
        yield Task(text, scene.system, float(scene.t[-1]), scene.point(0.0))
    yield Task("rotor on a stiff damper", rotor(), EDGES[-1])
    for name, model, until in _made():
        yield Task(name, lp.assemble(model), until)
    yield from _random()
