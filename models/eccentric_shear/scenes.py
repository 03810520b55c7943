"""Motions of the eccentric shear: constant speed of the crank or the motor, and a free drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import (
    AngleSensor,
    DCMotor,
    Ground,
    Inertia,
    PController,
    Position,
    Sum,
    VoltageSource,
)
from lumped.components.gearing.noncircular import elliptical
from lumped.models.eccentric_shear import stand
from lumped.models.eccentric_shear.stand import SPEED, GuidedShear, Loaded, PrintedShear, Shear
from lumped.models.sources import Given

PULSES = {
    "half-sine": (stand.HALF_SINE, stand.CENTRE_SINE),
    "rectangle": (stand.RECTANGLE, stand.CENTRE_RECTANGLE),
}
SLOW = 1e-5
"""Speed over `SPEED` at which inertia no longer counts: its torque falls with the square."""
FLUX = Given(571.0, "V.s", "A", "flux of the motor, voltage over speed")
RESISTANCE = Given(0.06, "Ohm", "A", "resistance of the motor's armature")
INDUCTANCE = Given(0.3e-3, "H", "A", "inductance of the motor's armature")
GAIN = Given(1500.0, "V/rad", "A", "gain of the controller of the motor's angle")


class CrankTurned(lp.Component):
    """Crank turned at constant speed; the drive follows the ellipses."""

    w: lp.Param = lp.param("rad/s", "crank speed", SPEED, above=0)
    eps: lp.Param = lp.param("1", "eccentricity of the ellipses", 0.0, min=0, below=1)
    slowest: lp.Param = lp.param(
        "rad", "crank angle at which the ratio is greatest", stand.CENTRE_SINE
    )
    drive: Position = Position(phi=elliptical(w * lp.time, eps, slowest))
    motor: Inertia = Inertia(J=stand.J_MOTOR)
    loaded: Loaded = Loaded(eps=eps, slowest=slowest)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.drive.flange, self.motor, self.loaded.flange)


class MotorTurned(CrankTurned):
    """Motor turned at constant speed."""

    drive: Position = Position(phi=CrankTurned.w * lp.time)


class FreeShear(lp.Component):
    """Direct-current motor with a controller of its angle, ``U = k w + Ki (w t - phi)`` [A]."""

    w: lp.Param = lp.param("rad/s", "wanted motor speed", SPEED)
    eps: lp.Param = lp.param("1", "eccentricity of the ellipses", 0.0, min=0, below=1)
    motor: DCMotor = DCMotor(k=FLUX, R=RESISTANCE, L=INDUCTANCE, J=stand.J_MOTOR, w=w)
    loaded: Loaded = Loaded(eps=eps)
    source: VoltageSource = VoltageSource()
    ground: Ground = Ground()
    sensor: AngleSensor = AngleSensor()
    control: PController = PController(wanted=w * lp.time, k=GAIN)
    voltage: Sum = Sum(b=motor.k * w)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.motor.flange, self.loaded.flange, self.sensor.flange)
        yield lp.connect(self.source.p, self.motor.p)
        yield lp.connect(self.source.n, self.motor.n, self.ground.pin)
        yield lp.connect(self.sensor.phi, self.control.measured)
        yield lp.connect(self.control.y, self.voltage.a)
        yield lp.connect(self.voltage.y, self.source.v)


def seat_support(shear: type[Shear], path: str = "loaded.shear") -> dict[str, float]:
    """Start values of a shear whose lower support is at rest.

    Parameters
    ----------
    shear : PrintedShear or GuidedShear, or a class made from one
        Reading of the source.
    path : str
        Its path in the model.
    """
    if issubclass(shear, GuidedShear):
        return {f"{path}.seat.v_rel": 0.0}
    bodies = (("mass_x", "v"), ("mass_y", "v"), ("body", "w"))
    resting = {f"{path}.lower.{body}.{speed}": 0.0 for body, speed in bodies}
    moving = {f"{path}.upper.{body}.{speed}_rel": 0.0 for body, speed in bodies}
    holds = {f"{path}.journal_{axis}.v_rel": 0.0 for axis in "xy"}
    return resting | moving | holds


@dataclass(frozen=True, eq=False)
class Demand:
    """Motor torque over a turn.

    Attributes
    ----------
    run : Trajectory
        The turn.
    phi : ndarray
        Crank angle, rad.
    ratio : ndarray
        Speed of the motor over that of the crank.
    tau : ndarray
        Motor torque, N.m; at a jump both sides.
    peak, rms : float
        Greatest, and root of the mean square over the time, N.m.
    """

    run: lp.Trajectory

    @property
    def phi(self) -> np.ndarray:
        return self.run["loaded.shear.crank.phi"]

    @property
    def ratio(self) -> np.ndarray:
        return np.asarray(self.run["motor.w"] / self.run["loaded.shear.shaft.body.w"])

    @property
    def tau(self) -> np.ndarray:
        return -self.run["drive.flange.tau"]

    @property
    def peak(self) -> float:
        return float(self.tau.max())

    @property
    def rms(self) -> float:
        t = self.run.t
        return float(np.sqrt(np.trapezoid(self.tau**2, t) / t[-1]))


@cache
def _system(motion: type[CrankTurned], pulse: str, shear: type[Shear]) -> lp.System:
    return lp.assemble(motion().with_({"loaded.cut": PULSES[pulse][0], "loaded.shear": shear()}))


def turn(
    motion: type[CrankTurned],
    eps: float = 0.0,
    pulse: str = "half-sine",
    slowest: float | None = None,
    speed: float = SPEED,
    shear: type[Shear] = PrintedShear,
    grid: Any = 2000,
    parameters: Mapping[str, float] | None = None,
) -> Demand:
    """Motor torque over one turn at constant speed.

    Parameters
    ----------
    motion : CrankTurned or MotorTurned
        Whether crank or motor turns at constant speed.
    eps : float
        Eccentricity of the ellipses.
    pulse : {"half-sine", "rectangle"}
        Cutting torque.
    slowest : float, optional
        Crank angle at which the ratio is greatest, rad; the middle of the pulse unless given.
    speed : float
        Speed, rad/s.
    shear : PrintedShear or GuidedShear
        Reading of the source.
    grid : int or sequence of float
        Output intervals or times, as for `lumped.simulate`.
    parameters : mapping of name to float, optional
        Parameters to change besides.
    """
    centre = PULSES[pulse][1] if slowest is None else slowest
    changes = {"eps": eps, "slowest": centre, "w": speed} | dict(parameters or {})
    run = _turn_crank(_system(motion, pulse, shear), shear, changes, grid)  # type: ignore[arg-type] # classes do have a hash
    return Demand(run)


def _turn_crank(
    system: lp.System, shear: type[Shear], changes: dict[str, float], grid: Any
) -> lp.Trajectory:
    until = 2 * np.pi / system.parameter_values(changes)["w"]
    start = seat_support(shear)
    return lp.simulate(system, until=until, parameters=changes, start=start, grid=grid, rtol=1e-10)


def inertia(shear: type[Shear], grid: Any = 720, width: float = 2 * stand.MEETS) -> lp.Trajectory:
    """A turn of the crank at `SPEED` without loads and without the motor's inertia.

    Parameters
    ----------
    shear : PrintedShear or GuidedShear
        Reading of the source.
    grid : int or sequence of float
        Output intervals or times, as for `lumped.simulate`.
    width : float
        Crank angle over which the lower support is seated, about the upper position, rad.
    """
    bare = {"motor.J": 1e-9, "loaded.idle.tau": 0.0, "loaded.cut.tau_max": 0.0}
    system = _system(CrankTurned, "half-sine", shear)  # type: ignore[arg-type] # as above
    return _turn_crank(system, shear, bare | {"loaded.shear.switch.width": width}, grid)


def motions(run: lp.Trajectory, shear: type[Shear]) -> np.ndarray:
    """Speeds of all bodies in a run of `inertia`, times the roots of their masses.

    They are over the crank speed, so that the sum of their squares is the reduced inertia, kg.m2.

    Returns
    -------
    ndarray, shape (n, 9)
        sqrt(kg) m: shaft, upper and lower support, each along x, along y and turning.
    """
    path = "loaded.shear"
    bodies = {
        "shaft": (stand.M_SHAFT, stand.M_SHAFT, stand.J_SHAFT),
        "upper": (stand.M_UPPER, stand.M_UPPER, stand.J_UPPER),
        "lower": (stand.M_LOWER, stand.M_LOWER, stand.J_LOWER),
    }
    columns = []
    for body, masses in bodies.items():
        names = [f"{path}.{body}.{part}" for part in ("mass_x.v", "mass_y.v", "body.w")]
        if body == "lower" and shear is GuidedShear:  # upright
            names = ["", f"{path}.lower.v", ""]
        for name, mass in zip(names, masses, strict=True):
            speed = run[name] if name else np.zeros_like(run.t)
            columns.append(np.sqrt(mass) * speed / SPEED)
    return np.column_stack(columns)


def upright(shear: type[Shear]) -> dict[str, float]:
    """Start values of `free_run`: upper position, no current."""
    return {"motor.phi": 0.0, "motor.i": 0.0} | seat_support(shear)


def free_run(
    eps: float | None = None,
    turns: int = 2,
    shear: type[Shear] = PrintedShear,
    model: FreeShear | None = None,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Controlled motor and free speed from the upper position, motor at its wanted speed.

    Parameters
    ----------
    eps : float, optional
        Eccentricity of the ellipses; that of the model unless given.
    turns : int
        Turns at the wanted speed.
    shear : PrintedShear or GuidedShear, or a class made from one
        Reading of the source.
    model : FreeShear, optional
        Motor and shear, used instead of `shear`; those of the source unless given.
    parameters, start : mapping of name to value, optional
        Parameters to change, and start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    model = FreeShear().with_({"loaded.shear": shear()}) if model is None else model
    system = lp.assemble(model)
    changed = ({} if eps is None else {"eps": eps}) | dict(parameters or {})
    begin = upright(type(model.loaded.shear)) | dict(start or {})
    turn = 2 * np.pi / system.parameter_values(changed)["w"]
    options = {"until": turns * turn} | options
    return lp.simulate(system, parameters=changed, start=begin, **options)


def compare_speeds(run: lp.Trajectory) -> list[float]:
    """Speed of the crank after over that before, for each change of the carriage."""
    instants = sorted({e.time for e in run.events if e.component.endswith("shear.switch")})
    w = run["loaded.shear.shaft.body.w"]
    sides = [np.flatnonzero(run.t == t) for t in instants]
    return [float(w[at[-1]] / w[at[0]]) for at in sides]


def landing(run: lp.Trajectory) -> float:
    """Greatest motor torque of the last turn outside of the cut over that within it.

    The peak after the landing is 10 ms wide: output times must be less than 1 ms apart.
    """
    phi, tau = run["loaded.shear.crank.phi"], run["motor.tau"]
    last = np.flatnonzero(phi >= phi[-1] - 2 * np.pi)
    angle = np.mod(phi[last], 2 * np.pi)
    cutting = (angle >= stand.CUT_BEGINS) & (angle <= stand.CUT_ENDS)
    return _peak(run.t, tau, last[~cutting]) / _peak(run.t, tau, last[cutting])


def _peak(t: np.ndarray, y: np.ndarray, places: np.ndarray) -> float:
    """Top of the parabola through the greatest value at some places and its neighbours."""
    i = places[y[places].argmax()]
    near = slice(max(i - 1, 0), i + 2)
    if len(set(t[near])) < 3 or y[near].argmax() != 1:  # an end, or a jump
        return float(y[i])
    a, b, c = np.polyfit(t[near] - t[i], y[near] / y[i], 2)
    return float(y[i] * (c - b**2 / (4 * a)))
