"""Winding drive of a carrousel coiler: motor, two-speed gear, mandrel, growing coil, strip.

Source: Zhang Fei, Structural and kinetic characteristic analysis of carrousel coiler (in Chinese),
graduation thesis, supervisor Wang Yongqin, College of Mechanical Engineering, Chongqing University,
June 2011, 54 pages; equations (3.1) to (3.13) here and in `sizing`, (3.14) to (3.54) in `gearing`.
The formulas are lost in the copy used, so that places are given by the numbers of equations and
examples. Marks: [P] printed, [R] restored by derivation and in agreement with the
print, [I] inferred, [A] assumed because the source does not give it. All moments of inertia and the
data of the strip are [A].

    motor - two-speed gear - mesh loss - mandrel and bearings - coil - strip

The source adds a torque of the growing coil, ``w dJ/dt`` (3.5) [R], although the entering strip
already has exactly this momentum; `lumped.components.Coil` keeps the balance of the open system.
At 1 mm and 20 m/s the difference is 3.9 kN.m on the full coil, 4.9 % of the torque of the tension.

Angles count positive in the sense of winding, which is clockwise as the coiler is drawn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import (
    Brake,
    Coil,
    EfficientGear,
    Inertia,
    Position,
    SelectableGear,
    translation,
)
from lumped.errors import OptionError
from lumped.models.sources import Given
from lumped.ops import pi, sqrt, where

TENSION = Given(80e3, "N", "P", "tension of the strip, T")
RADIUS = Given(1.0, "m", "P", "full coil, R")
MANDREL = Given(0.305, "m", "P", "mandrel, r")
SPEED = Given(20.0, "m/s", "P", "greatest line speed of example 3.1")
I_HIGH = Given(1.354, "1", "P", "high gear, the smaller ratio")
I_LOW = Given(2.0, "1", "P", "low gear")
ETA = Given(0.92, "1", "P", "total efficiency, friction included; here that of the gears")

WIDTH = Given(1.25, "m", "A", "width of the strip")
THICKNESS = Given(1e-3, "m", "A", "thickness of the strip, h")
DENSITY = Given(7850.0, "kg/m3", "A", "density of the strip")
YIELD = Given(300e6, "Pa", "A", "yield stress of the strip")
J_MOTOR = Given(600.0, "kg.m2", "A", "motor, at its shaft")
J_MANDREL = Given(500.0, "kg.m2", "A", "gears and mandrel, at the mandrel")
M_MANDREL = Given(2500.0, "kg", "A", "mass on the bearings without a coil")
MU = Given(0.003, "1", "A", "friction coefficient of the mandrel's bearings")
BEARING = Given(0.40, "m", "A", "diameter of the mandrel's bearings")
ACCELERATION = Given(1.0, "m/s2", "A", "acceleration of the line")
DECELERATION = Given(1.25, "m/s2", "A", "deceleration of the line")

HIGH, LOW = 1.0, 2.0
"""Commands of the gear."""


class WindingDrive(lp.Component):
    """Motor, gear, mandrel and coil; the enclosing model joins the strip to `coil.strip`."""

    strip = lp.LinearFlange()
    r: lp.Param = lp.param("m", "radius of the mandrel", MANDREL, above=0)
    R: lp.Param = lp.param("m", "radius of the full coil", RADIUS, above=r)
    h: lp.Param = lp.param("m", "thickness of the strip", THICKNESS, min=0)
    eta: lp.Param = lp.param("1", "efficiency of the gears", ETA, above=0, max=1)
    mu: lp.Param = lp.param("1", "friction of the bearings", MU, min=0)
    sigma_s: lp.Param = lp.param("Pa", "yield stress of the strip", YIELD, min=0)
    motor: lp.Component = Position(phi=0.0)
    rotor: Inertia = Inertia(J=J_MOTOR)
    gear: SelectableGear = SelectableGear(ratio_1=I_HIGH, ratio_2=I_LOW, u=HIGH)
    mesh: EfficientGear = EfficientGear(ratio=1.0, eta=eta)
    mandrel: Inertia = Inertia(J=J_MANDREL)
    bearing: Brake = Brake(characteristic=((0.0, 1.0),), c_geo=mu * BEARING / 2, f_max=1.0)
    coil: Coil = Coil(
        r=r,
        R_max=R + h,  # over-full: one layer more than full
        h=h,
        b=WIDTH,
        rho=DENSITY,
        sigma_s=sigma_s,
        m_0=M_MANDREL,
    )

    def connections(self) -> Iterator[lp.Connection]:
        yield from self.line()
        yield lp.connect(self.mandrel.flange_b, self.bearing.flange_a, self.coil.flange)
        yield lp.connect(self.coil.load, self.bearing.u)
        yield lp.connect(self.coil.strip, self.strip)

    def line(self) -> Iterator[lp.Connection]:
        """From the motor to the mandrel."""
        yield from lp.chain(self.motor, self.rotor, self.gear, self.mesh, self.mandrel)


class UnderTension(lp.Component):
    """Winding drive against a strip of given tension."""

    T: lp.Param = lp.param("N", "tension", TENSION)
    drive: WindingDrive = WindingDrive()
    line: translation.Force = translation.Force(f=-T)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.drive.strip, self.line.flange)


def capacity(radius: float = RADIUS, h: float = THICKNESS, r: float = MANDREL) -> float:
    """Length of strip in a coil of this radius, m: pi (R^2 - r^2) / h, (3.8) [I]."""
    return float(np.pi * (radius**2 - r**2) / h) if h else np.inf


def strip_momentum(radius: float, v: float = SPEED, h: float = THICKNESS) -> float:
    """Angular momentum that the strip brings to a coil each second, N.m: rho b h v^2 R.

    The term ``w dJ/dt`` of (3.5) adds it to the motor torque by mistake.
    """
    return DENSITY * WIDTH * h * v**2 * radius


def line_speed(
    length: float, v: float = SPEED, a: float = ACCELERATION, b: float = DECELERATION
) -> tuple[lp.Expr, lp.Expr, lp.Expr, float]:
    """Wound length, speed and acceleration over the time while a strip is wound from rest to rest.

    Parameters
    ----------
    length : float
        Length of the strip, m.
    v, a, b : float
        Line speed m/s, acceleration and deceleration m/s2.

    Returns
    -------
    tuple of Expr, Expr, Expr and float
        Length m, speed m/s, acceleration m/s2, and the whole time s.

    Raises
    ------
    OptionError
        If the strip is too short to reach the speed.
    """
    ramps = v**2 / 2 * (1 / a + 1 / b)
    if not length > ramps:
        raise OptionError(
            f"line_speed: a strip of {length:g} m does not reach {v:g} m/s; acceleration and "
            f"deceleration take {ramps:g} m. Give a lower speed or a longer strip."
        )
    t, reached = lp.time, v / a
    slows = reached + (length - ramps) / v
    late = t - slows
    at_slows = v * (slows - reached / 2)
    steady = (v * (t - reached / 2), v + 0 * t, 0 * t)
    falling = (at_slows + v * late - b * late**2 / 2, v - b * late, -b + 0 * t)
    rising = (a * t**2 / 2, a * t, a + 0 * t)
    travel, speed, acceleration = (
        where(t >= slows, late_, where(t >= reached, middle, early))
        for early, middle, late_ in zip(rising, steady, falling, strict=True)
    )
    return travel, speed, acceleration, slows + v / b


def turn_mandrel(length: lp.Expr) -> lp.Expr:
    """Angle of the mandrel of a `WindingDrive` from the wound length in m.

    From the drive's own radius and thickness, without a difference of large numbers.
    """
    r = WindingDrive.r
    return 2 * length / (r + sqrt(r**2 + WindingDrive.h * length / pi))


def check_length(length: float | None, found: Mapping[str, float]) -> float:
    """Length of a strip that fits on the coil: as given, or that of the full coil.

    Parameters
    ----------
    length : float or None
        Length, m.
    found : mapping of name to float
        Parameters of the model whose part `drive` is the winding drive.

    Raises
    ------
    OptionError
        If the coil would be over-full, or a strip without thickness would never fill it.
    """
    h, r, radius = (found[f"drive.{name}"] for name in ("h", "r", "R"))
    full = capacity(radius, h, r)
    length = full if length is None else length
    if not np.isfinite(length):
        raise OptionError("Strip without thickness, drive.h = 0 m, fills no coil: give its length.")
    if length > full * (1 + 1e-9):
        grown = np.sqrt(r**2 + h * length / np.pi)
        raise OptionError(
            f"A strip of {length:g} m and {1e3 * h:g} mm makes a coil of {grown:.4g} m radius; the "
            f"full coil has {radius:g} m. At most {full:.6g} m fit: shear the strip."
        )
    return length


def winding(
    length: float | None = None,
    gear: float = HIGH,
    v: float = SPEED,
    a: float = ACCELERATION,
    b: float = DECELERATION,
    model: UnderTension | None = None,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Whole winding run at given tension and line speed: the torque at the motor follows.

    The motor follows the strip, by the drive's own ratio, radius and thickness.

    Parameters
    ----------
    length : float, optional
        Length of the strip, m; that of a full coil unless given.
    gear : float
        `HIGH` or `LOW`.
    v, a, b : float
        Line speed m/s, acceleration and deceleration m/s2.
    model : UnderTension, optional
        Drive, whose motor is a prescribed angle, under its strip; that of the source unless given.
    parameters : mapping of name to value, optional
        Parameters to change, such as ``{"drive.h": 2e-3}``.
    **options
        Passed to `lumped.simulate`.

    Raises
    ------
    OptionError
        If the coil would be over-full, or the strip too short.
    """
    model = (UnderTension() if model is None else model).with_({"drive.gear.u": gear})
    found = lp.assemble(model).parameter_values(parameters)
    travel, _, _, end = line_speed(check_length(length, found), v, a, b)
    ratio = WindingDrive.gear.ratio_1 if gear == HIGH else WindingDrive.gear.ratio_2
    system = lp.assemble(model.with_({"drive.motor.phi": ratio * turn_mandrel(travel)}))
    return lp.simulate(system, until=end, parameters=parameters, **({"rtol": 1e-11} | options))
