"""Draw winding and its gear; the curves are runs of the components.

Run from the top of the project: python docs/elements/draw_winding.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import Coil, Inertia, SelectableGear, Speed, StripPath, Torque, translation
from lumped.ops import where

FOLDER = Path(__file__).parent


def free_coil() -> lp.Trajectory:
    """A coil that turns freely; only from 20 s to 30 s its strip is pulled back."""
    model = lp.compose(
        coil=Coil(r=0.3, R_max=0.9, h=2e-3, b=1.0, rho=7850.0),
        mandrel=Inertia(J=500.0, w=30.0),
        pull=translation.Force(f=where(lp.time >= 30, 0.0, where(lp.time >= 20, -4e3, 0.0))),
        connections=lambda m: [
            lp.connect(m.coil.flange, m.mandrel.flange_a),
            lp.connect(m.coil.strip, m.pull.flange),
        ],
    )
    return lp.simulate(lp.assemble(model), until=45.0, grid=1000)


def turret() -> lp.Trajectory:
    """A coil on a turret that turns evenly, under a tension of 80 kN."""
    model = lp.compose(
        turn=Speed(w=0.5),
        mandrel=Speed(w=8.0),
        coil=Coil(r=0.45, R_max=2.0, h=1e-3, b=1.25, rho=0.0),
        path=StripPath(r_t=1.25, d=4.4),
        pull=translation.Force(f=-8e4),
        connections=lambda m: [
            lp.connect(m.turn.flange, m.path.carrier),
            lp.connect(m.mandrel.flange, m.coil.flange),
            lp.connect(m.coil.strip, m.path.strip),
            lp.connect(m.coil.tangent, m.path.tangent),
            lp.connect(m.coil.R, m.path.R),
            lp.connect(m.path.line, m.pull.flange),
        ],
    )
    return lp.simulate(lp.assemble(model), until=4 * np.pi, grid=600)


def gear() -> lp.Trajectory:
    """A motor with a light flywheel in gear 1, neutral, and gear 2, engaged while turning."""
    model = lp.compose(
        drive=Torque(tau=10.0),
        motor=Inertia(J=0.5),
        gear=SelectableGear(
            ratio_1=3.0,
            ratio_2=1.5,
            u=where(lp.time >= 3.0, 2.0, where(lp.time >= 2.0, 0.0, 1.0)),
        ),
        load=Inertia(J=4.0),
        connections=lambda m: lp.chain(m.drive, m.motor, m.gear, m.load),
    )
    return lp.simulate(lp.assemble(model), until=5.0, grid=1000)


def draw_winding() -> Figure:
    """Free coil, and torques of a coil on a turret."""
    figure = Figure((7.8, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    run = free_coil()
    left.plot(run.t, run["coil.w"], label="speed, rad/s")
    left.plot(run.t, 10 * run["coil.R"], label="radius, 0.1 m")
    left.plot(run.t, run["coil.J"] / 100, label="inertia, 100 kg.m2")
    left.set(title="Free coil, pulled back from 20 to 30 s", xlabel="time, s", xlim=(0, 45))
    run = turret()
    angle = np.degrees(run["path.alpha"])
    right.plot(angle, run["path.length"], label="free strip, m")
    right.plot(angle, -run["turn.flange.tau"] / 1e5, label="turret, 100 kN.m")
    right.plot(angle, -run["mandrel.flange.tau"] / 1e5, label="mandrel, 100 kN.m")
    right.set(title="Torques of 80 kN on a turret", xlabel="angle alpha, degrees", xlim=(0, 360))
    finish(figure)
    return figure


def draw_gear() -> Figure:
    """Speeds over time."""
    run = gear()
    figure = Figure((7.0, 3.0), layout="constrained")
    axis = figure.subplots()
    axis.plot(run.t, run["motor.w"], label="flange a, motor")
    axis.plot(run.t, run["load.w"], label="flange b, load")
    axis.set(title="Gear 1 (ratio 3), neutral from 2 s, gear 2 (ratio 1.5) from 3 s")
    axis.set(xlabel="time, s", ylabel="speed, rad/s", xlim=(0, 5))
    finish(figure)
    return figure


def finish(figure: Figure) -> None:
    """Grids and legends."""
    for axis in figure.axes:
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)


if __name__ == "__main__":
    draw_winding().savefig(FOLDER / "winding.png", dpi=80)
    draw_gear().savefig(FOLDER / "selectable_gear.png", dpi=80)
