"""Draw the pictures of engines: ``python docs/elements/draw_engine.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import Cylinder, Engine, Position

FOLDER = Path(__file__).parent
W = 150.0  # rad/s
SIZE = {"bore": 0.105, "r": 0.0685, "L": 0.207, "m": 2.5}
DEGREES = (0, 180, 300, 340, 355, 370, 385, 420, 480, 540, 560, 720)
BAR = (0, 0.5, 8, 35, 60, 110, 80, 25, 9, 4, 0.5, 0)
PRESSURE = tuple(zip(np.radians(DEGREES).tolist(), [1e5 * p for p in BAR], strict=True))


def draw_engine():
    """Torques over a cycle, and firing angles of an order."""
    model = lp.compose(
        turn=Position(phi=W * lp.time),
        cylinder=Cylinder(**SIZE, pressure=PRESSURE),
        connections=lambda m: [lp.connect(m.turn.flange, m.cylinder.flange)],
    )
    run = lp.simulate(lp.assemble(model), until=4 * np.pi / W, grid=720)
    figure = plt.figure(figsize=(8.5, 3.0), layout="constrained")
    grid = figure.add_gridspec(1, 3, width_ratios=(2, 1, 1))
    axis = figure.add_subplot(grid[0])
    angle = np.degrees(run["cylinder.a"])
    for name, line in (("tau_gas", "-"), ("tau_mass", "--"), ("tau", "k-")):
        axis.plot(angle, run[f"cylinder.{name}"], line, label=name)
    axis.set(xlabel="crank angle, deg", ylabel="N.m", xticks=range(0, 721, 180))
    axis.set_title("torques of a cylinder at 150 rad/s", fontsize="medium")
    axis.grid(alpha=0.3)
    axis.legend()
    phases = Engine(cylinders=6, firing_order=(1, 5, 3, 6, 2, 4)).phases
    for place, order in ((1, 0.5), (2, 1.5)):
        polar = figure.add_subplot(grid[place], projection="polar")
        for i, phase in enumerate(phases):
            polar.plot([0, -order * phase], [0, 1], color="C0")
            # cylinders in the same direction stand one after the other
            alike = sum(np.isclose(np.exp(-1j * order * (p - phase)), 1) for p in phases[:i])
            polar.annotate(str(i + 1), (-order * phase, 1.0 - 0.25 * alike))
        polar.set_title(f"order {order:g}", fontsize="medium")
        polar.set_xticklabels([])
        polar.set_yticklabels([])
    figure.savefig(FOLDER / "engine.png", dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    draw_engine()
