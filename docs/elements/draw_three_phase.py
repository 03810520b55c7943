"""Draw the start of a squirrel-cage motor: ``python docs/elements/draw_three_phase.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import QuadraticTorque, SquirrelCageMotor
from lumped.ops import minimum

FOLDER = Path(__file__).parent
X = 2 * np.pi * 60
CAGE = {"R_s": 0.435, "R_r": 0.816, "L_m": 26.13 / X, "L_ls": 0.754 / X, "L_lr": 0.754 / X}


def start(share):
    """Run of a motor of 2 kW and a fan, fed with a share of its voltage and frequency."""
    model = lp.compose(
        motor=SquirrelCageMotor(
            **CAGE, pairs=2, J=0.089, V=180 * (0.05 + 0.95 * share), f=60 * share
        ),
        fan=QuadraticTorque(tau_nominal=-10.0, w_nominal=185.0),
        connections=lambda m: [lp.connect(m.motor.flange, m.fan.flange)],
    )
    return lp.simulate(lp.assemble(model), until=2.0, grid=3000, rtol=1e-7)


def draw():
    """Torque and current over time and speed."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained")
    ramp = minimum(lp.time / 1.5, 1.0)
    for label, share in (("on 220 V, 60 Hz", 1 + 0 * lp.time), ("ramp of 1.5 s", ramp)):
        run = start(share)
        left.plot(run["motor.w"] * 30 / np.pi, run["motor.tau"], label=label, linewidth=0.9)
        right.plot(run.t, run["motor.i"], label=label, linewidth=0.9)
    left.set(title="Torque of the start", xlabel="speed, 1/min", ylabel="torque, N.m")
    right.set(title="Amplitude of the current", xlabel="time, s", ylabel="current, A")
    for axes in (left, right):
        axes.grid(color="0.9")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(FOLDER / "three_phase_motors.png", dpi=80)


if __name__ == "__main__":
    draw()
