"""Draw an overload that a slip coupling limits; the curves are a run of the component.

Run from the top of the project: python docs/elements/draw_slip_coupling.py
"""

from pathlib import Path

from matplotlib.figure import Figure

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, SlipCoupling, SpringDamper, Torque
from lumped.ops import where

STATIC, KINETIC = 50.0, 35.0


def overload() -> lp.Trajectory:
    """A motor whose torque is too high for 0.2 s; the coupling is released at 0.9 s."""
    torque = where(lp.time >= 0.4, 5.0, where(lp.time >= 0.2, 90.0, 20.0))
    model = lp.compose(
        drive=Torque(tau=torque),
        motor=Inertia(J=0.4),
        coupling=SlipCoupling(static=STATIC, kinetic=KINETIC, u=where(lp.time >= 0.9, 0.0, 1.0)),
        load=Inertia(J=0.3),
        shaft=SpringDamper(c=400.0, d=1.0),
        machine=Inertia(J=0.5),
        brake=Damper(d=2.0),
        ground=Fixed(),
        connections=lambda m: lp.chain(
            m.drive, m.motor, m.coupling, m.load, m.shaft, m.machine, m.brake, m.ground
        ),
    )
    return lp.simulate(lp.assemble(model), until=1.1, grid=2000)


def draw() -> Figure:
    """Torque and slip over time."""
    run = overload()
    figure = Figure((8.0, 4.2), layout="constrained")
    torque, slip = figure.subplots(2, sharex=True)
    torque.plot(run.t, -run["coupling.tau"])
    for name, limit in (("static", STATIC), ("kinetic", KINETIC)):
        torque.axhline(limit, color="grey", linestyle="--", linewidth=0.8)
        torque.text(1.09, limit + 1, name, ha="right")
    torque.set(
        title="Motor torque 20, from 0.2 s 90, from 0.4 s 5 N.m; released at 0.9 s", ylim=(-5, 60)
    )
    torque.set_ylabel("torque to the load, N.m")
    slip.plot(run.t, -run["coupling.w_rel"], color="C1")
    slip.set(xlabel="time, s", ylabel="slip, rad/s", xlim=(0, 1.1))
    for axis in (torque, slip):
        axis.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    draw().savefig(Path(__file__).with_name("slip_coupling.png"), dpi=80)
