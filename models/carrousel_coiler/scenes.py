"""Carrousel coiler with an elastic strip: inertia compensation, lost tension, gear changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Position, Strip, Torque, translation
from lumped.errors import OptionError, SolverError, doubt
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler.drive import UnderTension, WindingDrive
from lumped.models.sources import Given
from lumped.ops import pi, sqrt, where

MODULUS = Given(2.1e11, "Pa", "A", "modulus of elasticity of the strip")
FREE = Given(10.0, "m", "A", "length of the strip before the coil")
DAMPING = Given(0.05, "1", "A", "damping ratio of the empty drive on the strip")
J_EMPTY = coiler.J_MANDREL + coiler.J_MOTOR * coiler.I_HIGH**2  # kg.m2  at the mandrel, high gear


class TensionControl(lp.Component):
    """Motor torque for a tension that is not measured: ``tau = (T R + M_s + M_f) / (i eta)``.

    With the compensation it adds ``J_m i dw + (J_0 + J_c) dw / (i eta)``, where
    ``dw = a / R - h v^2 / (2 pi R^3)`` and J_c is the inertia of the coil. Both are written for a
    motor that drives. R is measured, v and a are those of the line.
    """

    R: lp.Input = lp.Input("m", "radius of the coil")
    v: lp.Input = lp.Input("m/s", "line speed")
    a: lp.Input = lp.Input("m/s2", "acceleration of the line")
    tau = lp.Output("N.m", "motor torque")
    compensation: lp.Param = lp.param("1", "share of the inertia compensated", 1.0)
    T: lp.Param = lp.param("N", "wanted tension", coiler.TENSION)
    i: lp.Param = lp.param("1", "ratio of the gear", coiler.I_HIGH)
    eta: lp.Param = lp.param("1", "efficiency", coiler.ETA)
    h: lp.Param = lp.param("m", "thickness of the strip", coiler.THICKNESS)
    b: lp.Param = lp.param("m", "width of the strip", coiler.WIDTH)
    rho: lp.Param = lp.param("kg/m3", "density of the strip", coiler.DENSITY)
    sigma_s: lp.Param = lp.param("Pa", "yield stress of the strip", coiler.YIELD)
    r: lp.Param = lp.param("m", "radius of the mandrel", coiler.MANDREL)
    m_0: lp.Param = lp.param("kg", "mass of the mandrel", coiler.M_MANDREL)
    J_0: lp.Param = lp.param("kg.m2", "inertia of gears and mandrel", coiler.J_MANDREL)
    J_m: lp.Param = lp.param("kg.m2", "inertia of the motor", coiler.J_MOTOR)
    mu: lp.Param = lp.param("1", "friction of the bearings", coiler.MU)
    d: lp.Param = lp.param("m", "diameter of the bearings", coiler.BEARING)
    g: lp.Param = lp.param("m/s2", "acceleration of free fall", 9.80665)

    def equations(self) -> Iterator[lp.Equation]:
        R, v, h = self.R, self.v, self.h
        mass = pi * self.rho * self.b * (R**2 - self.r**2)
        J = self.J_0 + mass * (R**2 + self.r**2) / 2
        bending = self.sigma_s * self.b * h**2 / 4
        load = sqrt(self.T**2 + (self.g * (mass + self.m_0)) ** 2)
        static = self.T * R + bending + self.mu * self.d / 2 * load
        dw = self.a / R - h * v**2 / (2 * pi * R**3)
        share = self.compensation * dw
        at_mandrel = static + share * J
        yield self.tau == at_mandrel / (self.i * self.eta) + share * self.J_m * self.i


class ControlledDrive(WindingDrive):
    """Winding drive whose motor torque is set for a tension."""

    motor: Torque = Torque()
    control: TensionControl = TensionControl(
        i=WindingDrive.gear.ratio_1,
        eta=WindingDrive.eta,
        h=WindingDrive.h,
        b=WindingDrive.coil.b,
        rho=WindingDrive.coil.rho,
        sigma_s=WindingDrive.sigma_s,
        r=WindingDrive.r,
        m_0=WindingDrive.coil.m_0,
        J_0=WindingDrive.mandrel.J,
        J_m=WindingDrive.rotor.J,
        mu=WindingDrive.mu,
        g=WindingDrive.coil.g,
    )

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.coil.R, self.control.R)
        yield lp.connect(self.control.tau, self.motor.tau)


class ElasticStrip(lp.Component):
    """Winding drive on an elastic strip whose far end runs with the line."""

    free: lp.Param = lp.param("m", "length of the strip before the coil", FREE, above=0)
    E: lp.Param = lp.param("Pa", "modulus of elasticity of the strip", MODULUS, above=0)
    drive: ControlledDrive = ControlledDrive()
    stiffness = E * drive.coil.b * drive.h / free
    J_empty = drive.mandrel.J + drive.rotor.J * drive.gear.ratio_1**2
    strip: Strip = Strip(
        c=stiffness,
        d=2 * DAMPING / drive.r * sqrt(J_empty * stiffness),
        s_rel=drive.control.T / stiffness,  # at the wanted tension
    )
    line: translation.Speed = translation.Speed(v=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        # The stretch of the strip is the lead of the coil over the line.
        yield from lp.chain(self.line, self.strip)
        yield lp.connect(self.strip.flange_b, self.drive.strip)


def elastic_winding(
    compensation: float = 1.0,
    length: float | None = None,
    until: float = np.inf,
    v: float = coiler.SPEED,
    a: float = coiler.ACCELERATION,
    b: float = coiler.DECELERATION,
    model: ElasticStrip | None = None,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Winding under torque control, from rest to rest, the strip at the wanted tension before.

    Parameters
    ----------
    compensation : float
        Share of the inertia that the motor torque compensates.
    length : float, optional
        Length of the strip, m; that of a full coil unless given.
    until : float
        End, s; that of the strip if infinite.
    v, a, b : float
        Line speed m/s, acceleration and deceleration m/s2.
    model : ElasticStrip, optional
        Drive and strip; those of the source unless given.
    parameters : mapping of name to value, optional
        Parameters to change besides, such as ``{"drive.h": 5e-3}``.
    **options
        Passed to `lumped.simulate`.

    Raises
    ------
    OptionError
        If the coil would be over-full, the strip too short to reach the speed, or at its end
        before.
    SolverError
        If the strip loses its tension; `partial` is the run.
    """
    model = ElasticStrip() if model is None else model
    at_rest = {"line.v": 0.0, "drive.control.v": 0.0, "drive.control.a": 0.0}
    found = lp.assemble(model.with_(at_rest)).parameter_values(parameters)
    _, speed, acceleration, end = coiler.line_speed(coiler.check_length(length, found), v, a, b)
    if end * (1 + 1e-9) < until < np.inf:
        raise OptionError(
            f"elastic_winding: until = {until:g} s, but the strip ends at {end:.6g} s: wind a "
            "longer one, or stop there."
        )
    moving = {"line.v": speed, "drive.control.v": speed, "drive.control.a": acceleration}
    run = lp.simulate(
        lp.assemble(model.with_(moving)),
        until=end if until == np.inf else until,
        parameters={"drive.control.compensation": compensation} | dict(parameters or {}),
        **options,
    )
    _refuse_lost_tension(run, found["drive.control.T"], options.get("rtol", 1e-6))
    return run


def _refuse_lost_tension(run: lp.Trajectory, wanted: float, rtol: float) -> None:
    lost = next((event.time for event in run.events if event.component == "strip"), None)
    if lost is not None:
        radius, v = (np.interp(lost, run.t, run[name]) for name in ("drive.coil.R", "line.v"))
        raise SolverError(
            f"{doubt(rtol)}The strip loses its tension, T = 0 N instead of {wanted:g} N, at "
            f"t = {lost:.4g} s, coil radius R = {radius:.4g} m, line speed v = {v:.4g} m/s. "
            "Compensate the inertia or accelerate less.",
            run,
        )


class PlacedDrive(WindingDrive):
    """Winding drive at an instant: wound length, speed and acceleration of the strip are given."""

    L_0: lp.Param = lp.param("m", "wound length at the time zero", 0.0, min=0)
    v: lp.Param = lp.param("m/s", "speed at the time zero", 0.0)
    a: lp.Param = lp.param("m/s2", "acceleration", 0.0)
    motor: Position = Position(
        phi=WindingDrive.gear.ratio_1 * coiler.turn_mandrel(L_0 + v * lp.time + a * lp.time**2 / 2)
    )


class Placed(UnderTension):
    """Winding drive at an instant under a strip of given tension, without the losses."""

    drive: WindingDrive = PlacedDrive(eta=1.0, mu=0.0, sigma_s=0.0)


def tension_deviation(
    radii: np.ndarray, v: float = coiler.SPEED, a: float = 0.0, h: float = coiler.THICKNESS
) -> np.ndarray:
    """Deviation of the tension without compensation, N, from the motor torque of a free strip.

    A / R^4 + B at steady speed, (3.9) [I]; -a J / R^2 at rest with an acceleration.

    Parameters
    ----------
    radii : array_like, shape (n,)
        Radii of the coil, m.
    v, a : float
        Line speed m/s and acceleration m/s2.
    h : float
        Thickness of the strip, m.
    """
    system = lp.assemble(Placed(T=0.0))
    found = []
    for radius in np.asarray(radii):
        at = {"drive.L_0": coiler.capacity(radius, h), "drive.v": v, "drive.a": a, "drive.h": h}
        wound = {"drive.coil.theta": 2 * np.pi * (radius - coiler.MANDREL) / h}
        point = lp.start_point(system, parameters=at, start=wound)
        found.append(point["drive.motor.flange.tau"] * coiler.I_HIGH / radius)
    return np.array(found)


def gear_change(
    at: float = 5.0,
    until: float = 10.0,
    drive: WindingDrive | None = None,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Gear changed from low to high while the empty mandrel turns freely at 20 rad/s.

    Never done on the machine: speeds jump so that momentum is kept, and the event gives the energy
    lost in the dogs.

    Parameters
    ----------
    at, until : float
        Instant of the change, and end, s.
    drive : WindingDrive, optional
        Drive, which runs here without losses, strip and torque; that of the source unless given.
    parameters, start : mapping of name to value, optional
        Parameters to change, and start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    free = {"motor": Torque(tau=0.0), "mu": 0.0, "sigma_s": 0.0, "eta": 1.0, "h": 0.0}
    free["gear.u"] = where(lp.time >= at, coiler.HIGH, coiler.LOW)
    drive = (WindingDrive() if drive is None else drive).with_(free)
    system = lp.assemble(UnderTension(T=0.0, drive=drive))
    ratio = system.parameter_values(parameters)["drive.gear.ratio_2"]
    begin = {"drive.mandrel.w": 20.0, "drive.rotor.w": 20.0 * ratio} | dict(start or {})
    return lp.simulate(system, until=until, parameters=parameters, start=begin, **options)
