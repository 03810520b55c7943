"""Sizing of the winding drive of the carrousel coiler: power, motor, speed ranges, gears."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import lumped as lp
from lumped.components import ConverterDrive, Speed
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.sources import Given

K = Given(1.08, "1", "P", "torque of tension, bending and friction over that of the tension, K")
AMPLIFICATION = Given(
    1.25, "1", "I", "motor power over that of the tension, a, from the printed 2347 kW"
)
SPEED_2 = Given(1300 / 60, "m/s", "P", "greatest line speed of example 3.2: 1300 m/min")
DYNAMIC = (
    Given(1.1, "1", "P", "least factor for the dynamic power"),
    Given(1.2, "1", "P", "greatest factor for the dynamic power"),
)
TWO_GEARS = Given(10.0, "1", "P", "range of mandrel speeds above which gears are to be changed")
SPEED_MIN = Given(400 / 60, "m/s", "P", "least line speed of example 3.2: 400 m/min")


@dataclass(frozen=True)
class Motor:
    """Motor with field weakening: rated torque N.m, rated power W, greatest speed rad/s."""

    torque: float
    power: float
    speed: float

    @property
    def base(self) -> float:
        """Base speed, rad/s."""
        return self.power / self.torque


def tension_power(T: float = coiler.TENSION, v: float = coiler.SPEED) -> float:
    """Power of tension, bending and friction at the motor, W: K T v / eta, (3.4) [R]."""
    return K * T * v / coiler.ETA


def share_of_losses(radius: float, h: float = coiler.THICKNESS) -> float:
    """Bending and friction as a share of the total power of (3.3), from the model at rest.

    The source has 5 to 10 per cent of the total power, and so K = 1.05 to 1.1.

    Parameters
    ----------
    radius, h : float
        Of the coil and thickness of the strip, m.
    """
    model = coiler.UnderTension().with_({"drive.h": h, "drive.motor.phi": lp.time})
    wound = {"drive.coil.theta": 2 * np.pi * (radius - coiler.MANDREL) / h}
    point = lp.start_point(lp.assemble(model), start=wound)
    friction = -point["drive.bearing.flange_a.tau"]
    lost = float(point["drive.coil.M_b"] + abs(friction))
    return lost / (coiler.TENSION * radius + lost)


def speed_range(
    i: float = coiler.I_HIGH, v_max: float = SPEED_2, v_min: float = SPEED_MIN
) -> float:
    """Range of motor speeds: `v_max` in high gear, `v_min` in the gear i, (3.11) [R].

    From the empty coil at `v_max` to the full coil at `v_min`. The gear is chosen for a strip at
    standstill, never changed while it is wound.
    """
    return coiler.RADIUS / coiler.MANDREL * v_max / v_min * coiler.I_HIGH / i


def needs_two_gears(v_max: float = SPEED_2, v_min: float = SPEED_MIN) -> bool:
    """Whether the speeds of the mandrel range over more than ten, so that one gear does not do.

    The gear is then chosen for a strip, `gear_for`, while the drive stands still.
    """
    return speed_range(coiler.I_HIGH, v_max, v_min) > TWO_GEARS


def torque_check(motor: Motor, ratio: float = coiler.I_HIGH) -> float:
    """Rated torque at the mandrel over that of the tension at the full coil, section 3.1.4 [R]."""
    return motor.torque * ratio * coiler.ETA / (coiler.TENSION * coiler.RADIUS)


def choose_motor(v: float = coiler.SPEED, a: float = AMPLIFICATION) -> Motor:
    """Motor of example 3.1, (3.4), text to (3.4), (3.13) [R].

    Its greatest speed is that at the empty coil in high gear. Its power is `a` times that of the
    tension, as its speed range ``n_max / n_N`` is smaller than that of the radii by this factor; so
    it does not keep (3.12), nor the ratio ``n_N / n_c`` of section 3.1.4.
    """
    fastest = coiler.I_HIGH * v / coiler.MANDREL
    power = a * tension_power(v=v)
    base = fastest * a / (coiler.RADIUS / coiler.MANDREL)
    return Motor(power / base, power, fastest)


def drawn_power() -> float:
    """Power of the motor on the drawing, W: a K T v [I].

    The printed 2160 kW are the amplified power of example 3.1 without the efficiency.
    """
    return AMPLIFICATION * tension_power() * coiler.ETA


def drawn_motor() -> Motor:
    """Motor on the drawing, with the base speed and the greatest speed of example 3.1 [I]."""
    motor = choose_motor()
    return Motor(drawn_power() / motor.base, drawn_power(), motor.speed)


def demand(run: lp.Trajectory, motor: Motor) -> lp.simulation.Sizing:
    """Demand of a winding run on a motor, against its rated torque and its field weakening."""
    return lp.simulation.sizing(
        run,
        of=("drive.rotor.flange_a.tau", "drive.rotor.w"),
        rated=motor.torque,
        maximum=limit_rows(motor),
    )


def limit_rows(motor: Motor) -> list[tuple[float, float]]:
    """Speeds and greatest torques of a motor in field weakening."""
    return [(float(w), motor.power / w) for w in np.linspace(motor.base, motor.speed, 400)]


def torque_at_mandrel(torque: ArrayLike, ratio: float = coiler.I_HIGH) -> np.ndarray:
    """Torque of the tension that a motor torque holds at the mandrel, N.m, (3.4) [R]."""
    return np.asarray(torque) * ratio * coiler.ETA / K


def greatest_tension(motor: Motor, speeds: np.ndarray, ratio: float) -> np.ndarray:
    """Tension that the motor can hold from the empty to the full coil at steady speed.

    Parameters
    ----------
    motor : Motor
        Torque and power limits.
    speeds : array_like, shape (n,)
        Line speeds, m/s.
    ratio : float
        Speed of the motor over that of the mandrel.

    Returns
    -------
    ndarray of float, shape (n,)
        Tension, N; zero where the motor would turn too fast on the empty coil.
    """
    speeds = np.asarray(speeds)
    radii = np.linspace(coiler.MANDREL, coiler.RADIUS, 41)
    turning = ratio * speeds[:, None] / radii
    allowed = speeds * ratio / coiler.MANDREL <= motor.speed * (1 + 1e-12)
    tension = torque_at_mandrel(_limit(motor, turning), ratio) / radii
    return np.where(allowed, tension.min(axis=1), 0.0)


def _limit(motor: Motor, speeds: np.ndarray) -> np.ndarray:
    """Greatest torque at speeds, from a motor that runs through all of them."""
    rig = lp.compose(
        turn=Speed(w=lp.time),
        motor=ConverterDrive(
            J=coiler.J_MOTOR, tau_max=motor.torque, P_max=motor.power, T=0.01, wanted=0.0
        ),
        connections=lambda m: [lp.connect(m.turn.flange, m.motor.flange)],
    )
    times, place = np.unique(speeds, return_inverse=True)
    run = lp.simulate(lp.assemble(rig), until=float(times[-1]), grid=times)
    return np.asarray(run["motor.limit"])[place].reshape(speeds.shape)


def gear_for(v: float, T: float, motor: Motor | None = None) -> str | None:
    """Gear for a strip: "high" if this suffices, else "low" if this does, else None."""
    motor = choose_motor() if motor is None else motor
    for name, ratio in (("high", coiler.I_HIGH), ("low", coiler.I_LOW)):
        if T <= greatest_tension(motor, np.array([v]), ratio)[0] * (1 + 1e-12):
            return name
    return None
