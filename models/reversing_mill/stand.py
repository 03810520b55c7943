"""Stand drive of the reversing cold rolling mill 400: two motors meet in the roll gap.

Source: A. S. Filatov, Electric drive and automation of reversing cold rolling mills (Elektroprivod
i avtomatizatsiya reversivnykh stanov kholodnoy prokatki), book, pages 70 to 73, equations (43) to
(56); the copy used names neither publisher nor year. Marks: [P] printed, [R] restored by derivation
and in agreement with the print, [I] inferred, [A] assumed because the source does not give it.

Each backup roll has its own drive, everything referred to the motor shaft (43), (44) [R]:

    upper branch   motor J1 - long shaft B1 - gearbox J3 - spindle B2 - rolls       3 masses
    lower branch   motor and gearbox on the short, rigid shaft B4 - spindle B3 - rolls    2 masses

Equation (46) calls the lower J2 that of the motor; with the gearbox [I] all three
frequencies agree within rounding.

The branches meet only in the roll gap. Without strip it is open. Under load the rolls roll on each
other through the strip: joined (56), or with creep, M_u = (K_s / 2)(w_v - w_n) [R]; the print (55)
leaves out the inertia of the rolls and is wrong for small K_s. M_pr of (54) is the torque of both
pairs of rolls, here `M_pr` and the loads are those of one. Torques, speeds and angles of both
branches count positive in the direction of rolling, and a shaft torque is positive when the motor
drives. The motions are deviations from steady idling.

The printed frequencies follow from the printed parameters only to 0.6 %. With J and C that round
to the printed ones (for example J1 = 3.006, J3 = 2.446, backup roll 0.1583 kgf m s2,
C1 = 26240, C2 = 9182 kgf m) all three round to the printed digits. The statement
that the mass of the shafts changes them by less than 0.1 Hz needs dimensions that are not given.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import (
    Damper,
    ElastoBacklash,
    IdealGear,
    Inertia,
    Planetary,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.models.sources import Given

KGF = 9.80665  # N
RATED = Given(365 * KGF, "N.m", "P", "rated torque of a motor, Mr: 365 kgf m")
J_MOTOR = Given(3.01 * KGF, "kg.m2", "P", "motor, J1: 3.01 kgf m s2")
J_GEARBOX = Given(2.45 * KGF, "kg.m2", "P", "gearbox at the motor shaft, J3: 2.45 kgf m s2")
J_BACKUP = Given(0.16 * KGF, "kg.m2", "P", "backup roll at the motor shaft: 0.16 kgf m s2")
J_WORK = Given(
    0.0001 * KGF, "kg.m2", "P", "work roll at the motor shaft: 0.0001 kgf m s2, implausibly small"
)
C_SHAFT = Given(2.62e4 * KGF, "N.m/rad", "R", "long shaft B1, C1: 2.62 kgf m, exponent illegible")
C_SPINDLE = Given(
    0.918e4 * KGF,
    "N.m/rad",
    "R",
    "spindles B2 and B3 at the motor shaft, C2: 0.918 kgf m, exponent illegible",
)
CREEP = Given(
    300 * KGF,
    "N.m.s/rad",
    "A",
    "creep coefficient of the roll gap, K_s: middle of a plausible 210 to 420 kgf m s",
)
BACKUP_DIAMETER = Given(0.5, "m", "I", "backup roll, from (47) and the printed 9.55 Hz at 15 m/s")

MOTOR_ONLY = {
    part: Given(
        J_MOTOR / 2, "kg.m2", "I", f"lower {part[:-2]} by the other reading of J2, motor alone"
    )
    for part in ("motor.J", "gearbox.J")
}
_ROUNDS = "rounds to the printed digits and gives the printed frequencies"
INSIDE = {
    "motor.J": Given(3.006 * KGF, "kg.m2", "I", f"motor that {_ROUNDS}"),
    "gearbox.J": Given(2.446 * KGF, "kg.m2", "I", f"gearbox that {_ROUNDS}"),
    "rolls.J": Given((0.1583 + 0.0001) * KGF, "kg.m2", "I", f"rolls whose inertia {_ROUNDS}"),
    "spindle.c": Given(9182 * KGF, "N.m/rad", "I", f"spindle whose stiffness {_ROUNDS}"),
}
C_INSIDE = Given(26240 * KGF, "N.m/rad", "I", f"shaft B1 whose stiffness {_ROUNDS}")

SHAFTS = ("upper.shaft.tau", "upper.spindle.tau", "lower.spindle.tau")
SHAFT_LABELS = ("shaft B1", "upper spindle B2", "lower spindle B3")


class Branch(lp.Component):
    """Drive of one pair of rolls, whose `barrel` meets the other one in the gap."""

    barrel = lp.Flange(free=True)


class UpperBranch(Branch):
    """Motor, long shaft B1, gearbox, spindle B2, backup and work roll."""

    drive: lp.Component = Torque(tau=0.0)
    motor: Inertia = Inertia(J=J_MOTOR)
    shaft: Spring | SpringDamper = Spring(c=C_SHAFT)
    gearbox: Inertia = Inertia(J=J_GEARBOX)
    spindle: Spring | ElastoBacklash = Spring(c=C_SPINDLE)
    rolls: Inertia | IdealGear = Inertia(J=J_BACKUP + J_WORK)

    def connections(self) -> Iterator[lp.Connection]:
        # From the rolls to the motor: a spring torque is positive when flange b leads.
        yield from lp.chain(
            self.rolls, self.spindle, self.gearbox, self.shaft, self.motor, self.drive
        )
        yield lp.connect(self.barrel, self.rolls.flange_a)


class LowerBranch(Branch):
    """Motor and gearbox on a rigid shaft (B4 [R]), spindle B3, backup and work roll."""

    drive: lp.Component = Torque(tau=0.0)
    motor: Inertia = Inertia(J=J_MOTOR)
    gearbox: Inertia = Inertia(J=J_GEARBOX)
    spindle: Spring | ElastoBacklash = Spring(c=C_SPINDLE)
    rolls: Inertia | IdealGear = Inertia(J=J_BACKUP + J_WORK)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.rolls, self.spindle, self.gearbox, self.motor, self.drive)
        yield lp.connect(self.barrel, self.rolls.flange_a)


class OpenGap(lp.Component):
    """No strip: the two branches turn independently, each under its load."""

    upper: Branch = UpperBranch()
    lower: Branch = LowerBranch()
    upper_load: Torque = Torque(tau=0.0)
    lower_load: Torque = Torque(tau=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.upper.barrel, self.upper_load.flange)
        yield lp.connect(self.lower.barrel, self.lower_load.flange)


class ClosedGap(OpenGap):
    """Rolls joined by the strip: one body."""

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.upper.barrel, self.lower.barrel)


class CreepingGap(OpenGap):
    """Rolls that creep against each other under the torque M_u = (K_s / 2)(w_v - w_n)."""

    K_s: lp.Param = lp.param("N.m.s/rad", "creep coefficient", CREEP, min=0)
    creep: Damper = Damper(d=K_s / 2)

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield from lp.chain(self.upper.barrel, self.creep, self.lower.barrel)


class PrintedGap(OpenGap):
    """Creep by (54) and (55) as printed, without the rolls' difference of inertia torques.

    This is a differential whose carrier is the body of both rolls. It comes close to `CreepingGap`
    only for large K_s; for K_s = 0 the model is singular.
    """

    K_s: lp.Param = lp.param("N.m.s/rad", "creep coefficient", CREEP, min=0)
    upper: UpperBranch = UpperBranch(rolls=IdealGear(ratio=1.0))
    lower: LowerBranch = LowerBranch(rolls=IdealGear(ratio=1.0))
    creep: Damper = Damper(d=K_s / 2)
    mean: Planetary = Planetary(ratio=1.0)
    rolls: Inertia = Inertia(J=2 * (J_BACKUP + J_WORK))

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.upper.barrel, self.creep.flange_a, self.mean.sun)
        yield lp.connect(self.lower.barrel, self.creep.flange_b, self.mean.ring)
        yield lp.connect(self.mean.carrier, self.rolls.flange_a)


def critical_strip_speeds(gap: OpenGap, orders: int = 4) -> np.ndarray:
    """Strip speeds at which an order of the eccentricity meets a mode, m/s: modes by orders."""
    modes = lp.modes(lp.assemble(gap))
    found = np.zeros((len(modes.hertz), orders))
    for met in lp.vibration.critical_speeds(modes, range(1, orders + 1)):
        found[met.mode, int(met.order) - 1] = met.speed * BACKUP_DIAMETER / 2
    return found


def strip_entry(
    gap: OpenGap,
    motor_torque: float = 0.0,
    until: float = 0.2,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Load of rated torque on each pair of rolls from the time zero.

    Parameters
    ----------
    gap : OpenGap, ClosedGap or CreepingGap
        Stand.
    motor_torque : float
        Step of each motor's torque at the same instant, N.m; zero leaves the motors unchanged.
    until : float
        End, s.
    parameters : mapping of name to value, optional
        Parameters to change besides.
    **options
        Passed to `lumped.simulate`.
    """
    steps = {
        "upper.drive.tau": motor_torque,
        "lower.drive.tau": motor_torque,
        "upper_load.tau": -RATED,
        "lower_load.tau": -RATED,
    }
    changed = steps | dict(parameters or {})
    return lp.simulate(lp.assemble(gap), until=until, parameters=changed, **options)


def eccentricity_hertz(speed: float) -> float:
    """Frequency of the backup rolls' eccentricity at a strip speed in m/s, (47) [I]."""
    return speed / (np.pi * BACKUP_DIAMETER)


def eccentricity_gains(gap: OpenGap, speeds: np.ndarray, torque: float) -> np.ndarray:
    """Shaft torques in the steady state under eccentric rolls, order 1.

    Parameters
    ----------
    gap : OpenGap, ClosedGap or CreepingGap
        Stand.
    speeds : array_like, shape (k,)
        Strip speeds, m/s.
    torque : float
        Amplitude on each pair of rolls.

    Returns
    -------
    ndarray of complex, shape (k, 3)
        Amplitudes of the torques `SHAFTS`.
    """
    return rolling_gains(gap, eccentricity_hertz(1) * np.asarray(speeds), torque)


def rolling_gains(gap: OpenGap, hertz: np.ndarray, torque: float) -> np.ndarray:
    """Shaft torques in the steady state under a harmonic torque on the rolls.

    Parameters
    ----------
    gap : OpenGap, ClosedGap or CreepingGap
        Stand.
    hertz : array_like, shape (k,)
        Frequencies.
    torque : float
        Amplitude on each pair of rolls.

    Returns
    -------
    ndarray of complex, shape (k, 3)
        Amplitudes of the torques `SHAFTS`.
    """
    upper, lower = loads = ("upper_load.tau", "lower_load.tau")
    found = lp.frequency_response(lp.assemble(gap), inputs=loads, outputs=SHAFTS, hertz=hertz)
    return torque * np.transpose([found[shaft, upper] + found[shaft, lower] for shaft in SHAFTS])
