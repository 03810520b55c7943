"""Draw what contact elements do; every curve is a run of the component.

Run from the top of the project: python docs/elements/draw_contact.py
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    Backlash,
    Coupling,
    ElastoBacklash,
    Fixed,
    IdealGear,
    Inertia,
    PickUp,
    Speed,
    Torque,
    translation,
)

HERE = Path(__file__).parent


def picture(columns: int = 1) -> tuple[Figure, list[Axes]]:
    """An empty picture with axes side by side."""
    figure = Figure((8.0, 3.2), layout="constrained")
    axes = figure.subplots(1, columns, squeeze=False).ravel()
    for axis in axes:
        axis.grid(alpha=0.3)
    return figure, list(axes)


def label(axis: Axes, title: str, x: str, y: str) -> None:
    """Title and names of the axes."""
    axis.set(title=title, xlabel=x, ylabel=y)


def command(*instants: float) -> lp.Expr:
    """A command that changes between 0 and 1 at these instants."""
    return sum(
        (-1) ** i * lp.ops.where(lp.time >= instant, 1, 0) for i, instant in enumerate(instants)
    )


def swept(speed: float, limited: bool) -> lp.Trajectory:
    """Torque of an elastic play that is turned at a constant speed from flank to flank."""
    reach = 0.03 * np.sign(speed)
    model = lp.compose(
        wall=Fixed(),
        play=ElastoBacklash(c=1000.0, d=10.0, b=0.02, limited=limited, phi_rel=-reach),
        drive=Speed(w=speed),
        connections=lambda m: lp.chain(m.wall, m.play, m.drive),
    )
    return lp.simulate(lp.assemble(model), until=2 * abs(reach / speed), grid=800)


def elasto_backlash() -> Figure:
    """Torque over twist at several speeds, both variants."""
    figure, axes = picture(2)
    for axis, limited in zip(axes, (True, False), strict=True):
        for i, speed in enumerate((0.01, 0.5, 1.0)):
            for way in (1, -1):
                run = swept(way * speed, limited)
                style = "-" if way > 0 else "--"
                name = f"{speed:g} rad/s" if way > 0 else None
                axis.plot(run["play.phi_rel"], run["play.tau"], style, color=f"C{i}", label=name)
        label(axis, f"limited={limited}", "phi_rel, rad", "tau, N.m")
    axes[0].legend(title="w_rel (dashed: backwards)", fontsize="small")
    return figure


def elasto_gap() -> Figure:
    """Force over distance at several speeds, both variants."""
    figure, axes = picture(2)
    for axis, limited in zip(axes, (True, False), strict=True):
        for i, speed in enumerate((0.01, 0.5, 1.0)):
            for way in (1, -1):
                begin = 0.03 if way < 0 else -0.03
                model = lp.compose(
                    wall=translation.Fixed(),
                    gap=translation.ElastoGap(c=1000.0, d=10.0, limited=limited, s_rel=begin),
                    drive=translation.Speed(v=way * speed),
                    connections=lambda m: lp.chain(m.wall, m.gap, m.drive),
                )
                run = lp.simulate(lp.assemble(model), until=0.06 / speed, grid=800)
                style, name = ("--", None) if way > 0 else ("-", f"{speed:g} m/s")
                axis.plot(run["gap.s_rel"], run["gap.f"], style, color=f"C{i}", label=name)
        label(axis, f"limited={limited}", "s_rel, m", "f, N")
    axes[0].legend(title="closing (dashed: opening)", fontsize="small")
    return figure


def stop() -> Figure:
    """A bouncing ball."""
    figure, (axis,) = picture()
    for restitution in (0.9, 0.7, 0.0):
        model = lp.compose(
            floor=translation.Stop(restitution=restitution),
            ball=translation.Mass(m=1.0, s=1.0, v=0.0),
            weight=translation.Force(f=-9.81),
            connections=lambda m: [
                lp.connect(m.floor.flange_b, m.ball.flange_a, m.weight.flange),
            ],
        )
        run = lp.simulate(lp.assemble(model), until=4.0, grid=800)
        axis.plot(run.t, run["ball.s"], label=f"restitution {restitution:g}")
    label(axis, "A ball on a stop", "time, s", "height, m")
    axis.legend(fontsize="small")
    return figure


def backlash() -> Figure:
    """A gear that rattles."""
    figure, (above, below) = picture(2)
    model = lp.compose(
        drive=Torque(tau=2.0 + 8.0 * lp.ops.sin(40 * lp.time)),
        motor=Inertia(J=0.2, w=0.0),
        play=Backlash(b=0.02, restitution=0.3),
        gear=IdealGear(ratio=3.0),
        load=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.drive, m.motor, m.play, m.gear, m.load),
    )
    run = lp.simulate(lp.assemble(model), until=0.5, grid=1000)
    above.plot(run.t, run["play.phi_rel"])
    label(above, "Rattling: b = 0.02 rad", "time, s", "phi_rel, rad")
    below.plot(run.t, run["play.tau"])
    label(below, "Torque while a flank is closed", "time, s", "tau, N.m")
    return figure


def coupling() -> Figure:
    """Speeds before and behind a coupling that closes and opens."""
    figure, (axis,) = picture()
    model = lp.compose(
        motor=Inertia(J=1.0, w=10.0),
        coupling=Coupling(u=command(0.2, 0.7)),
        load=Inertia(J=2.0, w=0.0),
        brake=Torque(tau=-6.0),
        connections=lambda m: lp.chain(m.motor, m.coupling, m.load, m.brake),
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    for name in ("motor", "load"):
        axis.plot(run.t, run[f"{name}.w"], label=f"{name}.w")
    label(axis, "Closed from 0.2 to 0.7 s; the load is braked", "time, s", "speed, rad/s")
    axis.legend(fontsize="small")
    return figure


def pick_up() -> Figure:
    """Speeds of an arm and of the body that it carries for a while."""
    figure, (axis,) = picture()
    model = lp.compose(
        drive=Torque(tau=2.0),
        arm=Inertia(J=1.0, w=3.0),
        load=PickUp(J=1.5, u=command(0.3, 0.7)),
        connections=lambda m: [
            *lp.chain(m.drive, m.arm),
            lp.connect(m.arm.flange_b, m.load.flange),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    for name in ("arm", "load"):
        axis.plot(run.t, run[f"{name}.w"], label=f"{name}.w")
    label(axis, "Carried from 0.3 to 0.7 s", "time, s", "speed, rad/s")
    axis.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    for draw in (elasto_backlash, elasto_gap, stop, backlash, coupling, pick_up):
        draw().savefig(HERE / f"{draw.__name__}.png", dpi=80)
