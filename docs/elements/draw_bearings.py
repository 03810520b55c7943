"""Draw the picture of rolling bearings: ``python docs/elements/draw_bearings.py``."""

import numpy as np
from draw_friction import finish, plt

import lumped as lp
from lumped.components import DEEP_GROOVE, DeepGroove, RollingBearing, Speed

BEARING = RollingBearing(
    kind=DeepGroove(23200.0, *DEEP_GROOVE["62"]),
    d=0.05,
    D=0.09,
    nu_40=46e-6,
    nu_100=6.8e-6,
    K_rs=3e-8,
    mu_film=0.05,
    F_r=3000.0,
    F_a=0.0,
    T=293.15,
)


def draw_bearings():
    """Friction over speed of a 6210 under 3 kN, for four temperatures of the oil."""
    figure, axes = plt.subplots(figsize=(5.4, 3.6))
    for celsius in (20, 40, 60, 90):
        model = lp.compose(
            turn=Speed(w=np.pi / 30 * 10 ** (4 * lp.time)),
            bearing=BEARING.with_({"T": celsius + 273.15}),
            connections=lambda m: lp.chain(m.turn, m.bearing),
        )
        run = lp.simulate(lp.assemble(model), until=1.0, grid=200)
        axes.semilogx(30 / np.pi * run["bearing.w"], run["bearing.tau"], label=f"{celsius} °C")
    axes.set(xlabel="speed, 1/min", ylabel="friction torque, N.m", title="6210, 3 kN, ISO VG 46")
    axes.set_ylim(bottom=0)
    finish(figure, "bearings")


if __name__ == "__main__":
    draw_bearings()
