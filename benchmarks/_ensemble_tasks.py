"""Four tasks for ensembles as models of lumped: three masses, clutches, a crank drive, Lorenz.

Random numbers are those of NumPy's PCG64, one row for each variant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Clutch, CrankSlider, Inertia, SpringDamper, Torque
from lumped.components.translation import Force

DELAY = 1e-4
"""Damping over stiffness of the shafts of three masses, s."""
CLUTCHES = (9.0, 7.0, 6.0)
STARTS = (30.0, 18.0, 12.0, 4.0)


class ThreeMasses(lp.Component):
    """Three masses at rest, on which a torque acts from the begin on."""

    c1: lp.Param = lp.param("N.m/rad", "stiffness of the first shaft", 4e4)
    c2: lp.Param = lp.param("N.m/rad", "stiffness of the second shaft", 2.5e4)
    mass = [Inertia(J=J) for J in (0.5, 1.2, 3.0)]  # noqa: RUF012
    shaft = [SpringDamper(c=c1, d=DELAY * c1), SpringDamper(c=c2, d=DELAY * c2)]  # noqa: RUF012
    motor: Torque = Torque(tau=100.0)

    def connections(self) -> Any:
        """Join them in a row."""
        b, s = self.mass, self.shaft
        yield from lp.chain(self.motor, b[0], s[0], b[1], s[1], b[2])


class ThreeClutches(lp.Component):
    """Four bodies in a row that three clutches bring to one speed."""

    drive: Torque = Torque(tau=2.0)
    body = [  # noqa: RUF012
        Inertia(J=J, w=w) for J, w in zip((1.0, 1.5, 0.8, 2.0), STARTS, strict=True)
    ]
    clutch = [  # noqa: RUF012
        Clutch(f_max=f, characteristic=((0.0, 1.0),), peak=1.0, u=1.0) for f in CLUTCHES
    ]

    def connections(self) -> Any:
        """Join them in a row."""
        yield lp.connect(self.drive.flange, self.body[0].flange_a)
        for i, clutch in enumerate(self.clutch):
            yield from lp.chain(self.body[i], clutch, self.body[i + 1])


class _Drag(lp.Component):
    """Torque against the speed of one flange."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "torque over speed", min=0)
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self) -> Any:
        """Viscous."""
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.d * self.w


class _Motor(lp.Component):
    """Torque that falls with the speed."""

    flange = lp.Flange()
    stall: lp.Param = lp.param("N.m", "torque at rest")
    idle: lp.Param = lp.param("rad/s", "speed without load", above=0)
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self) -> Any:
        """Linear in the speed."""
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == -self.stall * (1 - self.w / self.idle)


class CrankDrive(lp.Component):
    """Motor, elastic shaft, crank and a slider under a constant force."""

    motor: _Motor = _Motor(stall=60.0, idle=80.0)
    rotor: Inertia = Inertia(J=0.05, phi=0.3, w=0.0)
    shaft: SpringDamper = SpringDamper(c=600.0, d=1.5, phi_rel=0.0)
    wheel: Inertia = Inertia(J=0.5, w=0.0)
    drag: _Drag = _Drag(d=0.2)
    crank: CrankSlider = CrankSlider(r=0.12, L=0.45, m=8.0)
    push: Force = Force(f=150.0)

    def connections(self) -> Any:
        """Join them in a row."""
        yield from lp.chain(self.motor, self.rotor, self.shaft, self.wheel, self.crank)
        yield lp.connect(self.wheel.flange_b, self.drag.flange)
        yield lp.connect(self.crank.slider, self.push.flange)


class Lorenz(lp.Component):
    """The equations of Lorenz."""

    rho: lp.Param = lp.param("1", "relative temperature difference", 21.0)
    x: lp.Var = lp.var("1", "rate of the flow", 1.0, state="always")
    y: lp.Var = lp.var("1", "difference of temperature", 0.0, state="always")
    z: lp.Var = lp.var("1", "departure from a linear profile", 0.0, state="always")

    def equations(self) -> Any:
        """Three rates."""
        x, y, z = self.x, self.y, self.z
        yield lp.der(x) == 10.0 * (y - x)
        yield lp.der(y) == self.rho * x - y - x * z
        yield lp.der(z) == x * y - 2.666 * z


@dataclass(frozen=True)
class Task:
    """A model, what varies, and what is wanted.

    Attributes
    ----------
    model : Component
    names : tuple of str
        What varies, in the order of the columns.
    points : ndarray, shape (n, k)
        Its values.
    until : float
        End, s.
    of : dict of str to functional
    """

    model: lp.Component
    names: tuple[str, ...]
    points: np.ndarray
    until: float
    of: Mapping[str, Any]


def _factors(seed: int, count: int, nominal: tuple[float, ...], width: float) -> np.ndarray:
    u = np.random.default_rng(seed).random((count, len(nominal)))
    return np.array(nominal) * (1 - width + 2 * width * u)


def tasks() -> dict[str, Task]:
    """All four by their letters."""
    fun = lp.functionals
    masses = ("mass[0].J", "mass[1].J", "mass[2].J", "c1", "c2")
    torques = {"first": fun.peak("shaft[0].tau"), "second": fun.peak("shaft[1].tau")}
    grips = tuple(f"clutch[{k}].f_max" for k in range(3))
    locks: dict[str, Any] = {f"t{k}": fun.instant(f"clutch[{k}]", "stuck") for k in range(3)}
    for k in range(3):
        locks[f"heat{k}"] = fun.integral(f"clutch[{k}].tau", f"clutch[{k}].w_rel")
    crank = ("rotor.J", "shaft.c", "wheel.J", "crank.r", "crank.L", "crank.m")
    ends = {"phi": fun.final("wheel.phi"), "w": fun.final("wheel.w"), "rms": fun.rms("shaft.tau")}
    nominal_a, nominal_c = (0.5, 1.2, 3.0, 4e4, 2.5e4), (0.05, 600.0, 0.5, 0.12, 0.45, 8.0)
    return {
        "a": Task(ThreeMasses(), masses, _factors(20241, 100_000, nominal_a, 0.1), 2.0, torques),
        "b": Task(ThreeClutches(), grips, _factors(20242, 100_000, CLUTCHES, 0.2), 5.0, locks),
        "c": Task(CrankDrive(), crank, _factors(20243, 10_000, nominal_c, 0.05), 1.5, ends),
        "d": Task(
            Lorenz(),
            ("rho",),
            np.linspace(0.0, 21.0, 524_288)[:, None],
            1.0,
            {name: fun.final(name) for name in "xyz"},
        ),
    }
