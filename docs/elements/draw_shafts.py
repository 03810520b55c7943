"""Draw the picture of shafts: ``python docs/elements/draw_shafts.py``."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import Shaft, Solid
from lumped.components.shafts.materials import MATERIALS

HERE = Path(__file__).parent


def shafts() -> Figure:
    """Errors of the natural frequencies of a free bar, by number of elements."""
    steel, L = MATERIALS["steel"], 3.0
    speed = (steel.G / steel.rho) ** 0.5
    figure = Figure((8.0, 3.2), layout="constrained")
    axis = figure.subplots()
    for accuracy in (0.05, 0.01, 0.002):
        bar = Shaft(sections=[Solid(d=0.1, L=L)], f_max=2500.0, accuracy=accuracy)
        found = lp.modes(lp.assemble(lp.compose(bar=bar))).hertz
        found = found[found > 1.0]
        exact = np.arange(1, len(found) + 1) * speed / (2 * L)
        name = f"accuracy {accuracy:g}: {len(found)} elements"
        axis.loglog(exact, 1 - found / exact, "o-", markersize=3, label=name)
    axis.axvline(2500.0, color="black", linewidth=0.8)
    axis.set(xlabel="natural frequency, Hz", ylabel="relative error", title="f_max = 2500 Hz")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    shafts().savefig(HERE / "shafts.png", dpi=80)
