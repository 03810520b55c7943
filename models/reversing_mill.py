"""Stand drive of the reversing cold rolling mill 400: two motors meet in the roll gap.

Source: Filatov's calculation of the torsional vibrations of this drive, equations (43) to (56).
The copy at hand is damaged: title, year and page numbers are lost, so that places are given by
the equations to which a number belongs. Marks: [P] printed, [R] restored by derivation and in
agreement with the damaged print, [I] inferred, [A] assumed because the source does not give it.

Each backup roll has its own drive, everything referred to the motor shaft (43), (44) [R]:

    upper branch   motor J1 - long shaft B1 - gearbox J3 - spindle B2 - rolls       3 masses
    lower branch   motor and gearbox on the short, rigid shaft B4 - spindle B3 - rolls    2 masses

The branches meet only in the roll gap. Without strip it is open. Under load the rolls roll on
each other through the strip: joined (56), or with creep, M_u = (K_s / 2)(w_v - w_n) [R]; the
print (55) leaves out the inertia of the rolls and is wrong for small K_s. Torques, speeds and
angles of both branches count positive in the direction of rolling, and a shaft torque is
positive when the motor drives. The motions are deviations from steady idling.

The printed frequencies follow from the printed parameters to 0.6 % and no better, but within the
rounding of every J and C (for example J1 = 3.0102, J3 = 2.4467, backup roll 0.15842 kgf m s2,
C1 = 26233, C2 = 9180 kgf m) all three come within half a unit of the printed digit. The statement
that the mass of the shafts changes them by less than 0.1 Hz needs dimensions that are not given.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

import lumped as lp
from lumped.components import Damper, Inertia, Spring, Torque
from lumped.models import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KGF = 9.80665  # N
RATED = 365 * KGF  # N.m       rated torque of one motor [P]
J_MOTOR = 3.01 * KGF  # kg.m2      J1 [P]
J_GEARBOX = 2.45 * KGF  # kg.m2      J3, at the motor shaft [P]
J_BACKUP = 0.16 * KGF  # kg.m2      backup roll, referred [P]
J_WORK = 0.0001 * KGF  # kg.m2      work roll, referred [P]; implausibly small, but used in print
C_SHAFT = 2.62e4 * KGF  # N.m/rad    C1', shaft B1 [P]
C_SPINDLE = 0.918e4 * KGF  # N.m/rad    C2', spindles B2 and B3, referred [P]
CREEP = 300 * KGF  # N.m.s/rad  K_s, the middle of a plausible 210 to 420 kgf m s [A]
BACKUP_DIAMETER = 0.5  # m          from (47) and the printed 9.55 Hz at 15 m/s [I]

SHAFTS = ("upper.shaft.tau", "upper.spindle.tau", "lower.spindle.tau")
SHAFT_LABELS = ("shaft B1", "upper spindle B2", "lower spindle B3")


class UpperBranch(lp.Component):
    """Motor, long shaft B1, gearbox, spindle B2, backup and work roll."""

    barrel = lp.Flange(free=True)
    drive: Torque = Torque(tau=0.0)
    motor: Inertia = Inertia(J=J_MOTOR)
    shaft: Spring = Spring(c=C_SHAFT)
    gearbox: Inertia = Inertia(J=J_GEARBOX)
    spindle: Spring = Spring(c=C_SPINDLE)
    rolls: Inertia = Inertia(J=J_BACKUP + J_WORK)
    load: Torque = Torque(tau=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        # From the rolls to the motor: a spring torque is positive when flange b leads.
        yield from lp.chain(
            self.rolls, self.spindle, self.gearbox, self.shaft, self.motor, self.drive
        )
        yield lp.connect(self.barrel, self.rolls.flange_a, self.load.flange)


class LowerBranch(lp.Component):
    """Motor and gearbox on a rigid shaft (B4 [R]), spindle B3, backup and work roll."""

    barrel = lp.Flange(free=True)
    drive: Torque = Torque(tau=0.0)
    motor: Inertia = Inertia(J=J_MOTOR)
    gearbox: Inertia = Inertia(J=J_GEARBOX)
    spindle: Spring = Spring(c=C_SPINDLE)
    rolls: Inertia = Inertia(J=J_BACKUP + J_WORK)
    load: Torque = Torque(tau=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.rolls, self.spindle, self.gearbox, self.motor, self.drive)
        yield lp.connect(self.barrel, self.rolls.flange_a, self.load.flange)


class OpenGap(lp.Component):
    """No strip: the two branches turn without each other."""

    upper: UpperBranch = UpperBranch()
    lower: LowerBranch = LowerBranch()


class ClosedGap(OpenGap):
    """Rolls joined by the strip: one body."""

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.upper.barrel, self.lower.barrel)


class CreepingGap(OpenGap):
    """Rolls that creep against each other under the torque M_u = (K_s / 2)(w_v - w_n)."""

    K_s: lp.Param = lp.param("N.m.s/rad", "creep coefficient", CREEP, min=0)
    creep: Damper = Damper(d=K_s / 2)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.upper.barrel, self.creep, self.lower.barrel)


def strip_entry(
    gap: OpenGap, motor_torque: float = 0.0, until: float = 0.2, **options: Any
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
    **options
        Passed to `lumped.simulate`.
    """
    return lp.simulate(
        lp.assemble(gap),
        until=until,
        parameters={
            "upper.drive.tau": motor_torque,
            "lower.drive.tau": motor_torque,
            "upper.load.tau": -RATED,
            "lower.load.tau": -RATED,
        },
        **options,
    )


def eccentricity_hertz(speed: float) -> float:
    """Frequency of the backup rolls' eccentricity at a strip speed in m/s, (47) [I]."""
    return speed / (np.pi * BACKUP_DIAMETER)


def eccentricity_gains(gap: OpenGap, speeds: np.ndarray, torque: float) -> np.ndarray:
    """Shaft torques in the steady state under a harmonic torque on the rolls, order 1.

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
    line = lp.linearise(
        lp.assemble(gap), inputs=["upper.load.tau", "lower.load.tau"], outputs=SHAFTS
    )
    push = line.B.sum(axis=1) * torque
    omegas = 2 * np.pi * eccentricity_hertz(1) * np.asarray(speeds)
    unit = np.eye(len(push))
    return np.array([line.C @ np.linalg.solve(1j * w * unit - line.A, push) for w in omegas])


ROUNDING = "within the rounding of the printed J and C"
PUBLISHED = (  # quantity, unit, value, place, remark
    ("upper branch, gap open, f1", "Hz", 39.8, "equations (48) to (51)", ROUNDING),
    ("upper branch, gap open, f2", "Hz", 21.7, "equations (48) to (51)", ROUNDING),
    ("lower branch, gap open", "Hz", 38.9, "equation (46)", ROUNDING),
    ("eccentricity at 15 m/s", "Hz", 9.55, "equation (47)", "used to find the lost roll diameter"),
    ("eccentricity at 10 m/s", "Hz", 6.36, "equation (47)", "print cut off, not rounded"),
)
NOT = "not published"
UNPUBLISHED = (  # quantity, unit, None, place, reference and its origin
    ("closed gap, mode 1", "Hz", None, NOT, "6.34431 from the roots of equation (56)"),
    ("closed gap, mode 2", "Hz", None, NOT, "22.50599 from the roots of equation (56)"),
    ("closed gap, mode 3", "Hz", None, NOT, "39.17282 from the roots of equation (56)"),
    ("speed that excites closed mode 1", "m/s", None, NOT, "9.97 from equations (47) and (56)"),
    ("damping ratio of closed mode 1", "1", None, NOT, "0.27 at K_s = 400 kgf m s, eigenvalues"),
    ("strip entry, peak / mean, shaft B1", "1", None, NOT, "2.491 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B2", "1", None, NOT, "2.124 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B3", "1", None, NOT, "2.192 from modal sums over 2 s"),
)


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
    opened, closed = (lp.modes(lp.assemble(gap)).hertz for gap in (OpenGap(), ClosedGap()))
    creeping = lp.modes(lp.assemble(CreepingGap()), parameters={"K_s": 400 * KGF})
    entry = strip_entry(ClosedGap(), RATED, until=2.0, grid=20_000, rtol=1e-8)
    computed = [
        *(opened[2], opened[0], opened[1]),
        *(eccentricity_hertz(15), eccentricity_hertz(10)),
        *closed,
        closed[0] / eccentricity_hertz(1),
        creeping.damping[0],
        *(entry.table(SHAFTS).max(axis=0) / RATED),
    ]
    return [
        Row(quantity, unit, value, float(found), place, remark)
        for (quantity, unit, value, place, remark), found in zip(
            (*PUBLISHED, *UNPUBLISHED), computed, strict=True
        )
    ]


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.plot import mode_shapes

    return {
        "modes_upper": mode_shapes(lp.modes(lp.assemble(UpperBranch()))),
        "modes_lower": mode_shapes(lp.modes(lp.assemble(LowerBranch()))),
        "modes_closed": mode_shapes(lp.modes(lp.assemble(ClosedGap()))),
        "strip_entry": _draw_entry(),
        "eccentricity": _draw_eccentricity(),
        "creep": _draw_creep(),
    }


def _draw_entry() -> Figure:
    from matplotlib.figure import Figure

    figure = Figure((8, 6), layout="constrained")
    axes = figure.subplots(2, sharex=True, sharey=True)
    cases = (("motors unchanged", 0.0), ("motors stepping to rated torque", RATED))
    for axis, (title, motor_torque) in zip(axes, cases, strict=True):
        run = strip_entry(ClosedGap(), motor_torque, grid=1000)
        axis.plot(1e3 * run.t, run.table(SHAFTS) / RATED, label=SHAFT_LABELS)
        axis.axhline(0, color="black", linewidth=0.8)
        axis.set(title=f"Strip entry, {title}", ylabel="torque / rated torque")
        axis.grid(alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    axes[1].set(xlabel="time, ms", xlim=(0, 200))
    return figure


def _draw_eccentricity() -> Figure:
    from matplotlib.figure import Figure

    figure = Figure((8, 8), layout="constrained")
    gains, orders = figure.subplots(2, sharex=True)
    speeds = np.linspace(0.05, 22.5, 2000)
    cases = ((ClosedGap(), 0.5, "-", "closed gap"), (OpenGap(), 1.0, "--", "open gap"))
    for gap, torque, line, label in cases:
        torques = np.abs(eccentricity_gains(gap, speeds, torque))
        for i, name in enumerate(SHAFT_LABELS):
            gains.semilogy(speeds, torques[:, i], line, color=f"C{i}", label=f"{name}, {label}")
        hertz = lp.modes(lp.assemble(gap)).hertz
        orders.hlines(hertz, 0, speeds[-1], linestyle=line, color="black", label=label)
        if label == "closed gap":
            critical = [(f / n / eccentricity_hertz(1), f) for f in hertz for n in range(1, 5)]
            orders.plot(*np.transpose(critical), "oC3", zorder=3, label="critical, closed gap")
    for n in range(1, 5):
        orders.plot(speeds, n * eccentricity_hertz(1) * speeds, color="C0", linewidth=1)
        speed = min(21.5, 43 / n / eccentricity_hertz(1))
        orders.text(speed, n * eccentricity_hertz(speed) + 1, f"order {n}", color="C0", ha="right")
    gains.set(title="Eccentricity, order 1: torque on the joined rolls, or on each pair if open")
    gains.set_ylabel("torque / exciting torque")
    gains.legend(fontsize="small", loc="lower right")
    orders.set(title="Critical speeds", ylabel="frequency, Hz", ylim=(0, 47))
    orders.set(xlabel="strip speed, m/s", xlim=(0, speeds[-1]))
    orders.legend(loc="lower right", fontsize="small")
    for axis in (gains, orders):
        axis.grid(alpha=0.3)
    return figure


def _draw_creep() -> Figure:
    from matplotlib.figure import Figure

    system = lp.assemble(CreepingGap())
    points = [
        (K_s, damping, hertz)
        for K_s in np.geomspace(1, 1e4, 600)
        for found in [lp.modes(system, parameters={"K_s": K_s * KGF})]
        for damping, hertz in zip(found.damping, found.hertz, strict=True)
    ]
    figure = Figure((8, 5), layout="constrained")
    axis = figure.subplots()
    axis.axvspan(210, 420, color="grey", alpha=0.2, label="plausible $K_s$ (assumed)")
    K_s, damping, hertz = np.transpose(points)
    dots = axis.scatter(K_s, damping, s=6, c=hertz, cmap="turbo")
    figure.colorbar(dots, label="natural frequency, Hz")
    axis.loglog()
    axis.set(title="Damping by creep in the gap", xlim=(1, 1e4))
    axis.set(xlabel="creep coefficient $K_s$, kgf m s", ylabel="damping ratio")
    axis.grid(alpha=0.3)
    axis.legend()
    return figure
