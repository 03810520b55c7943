"""Draw loops of springs with friction and of bristles: ``python docs/elements/draw_hysteresis.py``.

All curves are runs of the components.
"""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    BoucWen,
    ClutchDisc,
    Dahl,
    Fixed,
    Inertia,
    Iwan,
    Jenkin,
    LuGre,
    Speed,
    Spring,
    Stribeck,
)

BACKBONE = ((0, 0), (0.004, 40), (0.008, 70), (0.014, 95), (0.022, 110), (0.03, 115), (0.04, 115))
DISC = {
    "drive": ((0.0, 40.0, 2.0), (0.12, 300.0, 12.0), (0.3, 3e3, 12.0)),
    "coast": ((0.0, 40.0, 2.0), (0.08, 200.0, 8.0), (0.3, 3e3, 8.0)),
}
LUGRE = {"c": 2e4, "d": 5.0, "characteristic": Stribeck(coulomb=3.0, static=5.0, decay=300.0)}


def swung(part: lp.Component, amplitude: float, until: float = 3.0) -> lp.Trajectory:
    """A part whose flange b moves as a sine of period 1 s with this amplitude."""
    w = amplitude * 2 * lp.ops.pi * lp.ops.cos(2 * lp.ops.pi * lp.time)
    model = lp.compose(
        wall=Fixed(),
        part=part,
        drive=Speed(w=w),
        connections=lambda m: lp.chain(m.wall, m.part, m.drive),
    )
    return lp.simulate(lp.assemble(model), until=until, grid=1500)


def loop(axes: Axes, part: lp.Component, amplitudes: tuple[float, ...], title: str) -> None:
    """Torque over twist for some amplitudes."""
    for amplitude in amplitudes:
        run = swung(part, amplitude)
        axes.plot(run["part.phi_rel"], run["part.tau"], label=f"{amplitude:g} rad")
    axes.set(title=title, xlabel="twist, rad", ylabel="torque, N.m")
    axes.margins(y=0.22)
    axes.locator_params(axis="x", nbins=5)
    axes.legend(fontsize=8, loc="upper left")


def draw_hysteresis() -> Figure:
    """Loops of Jenkin, Iwan and a clutch disc."""
    figure = Figure((11.0, 3.6), layout="constrained")
    one, many, disc = figure.subplots(1, 3)
    loop(one, Jenkin(c=5000.0, tau_max=50.0), (0.015, 0.03), "Jenkin")
    loop(many, Iwan(backbone=BACKBONE), (0.01, 0.02, 0.035), "Iwan")
    loop(disc, ClutchDisc(**DISC), (0.31, 0.25, 0.07), "ClutchDisc")
    return figure


def draw_dynamic_friction() -> Figure:
    """Loops of Dahl and Bouc-Wen; stick-slip of LuGre."""
    figure = Figure((11.0, 3.6), layout="constrained")
    dahl, wen, slip = figure.subplots(1, 3)
    loop(dahl, Dahl(c=2000.0, tau_c=4.0), (0.002, 0.01), "Dahl")
    for beta, n in ((0.5, 1.0), (0.8, 1.0), (0.5, 6.0)):
        run = swung(BoucWen(c=1000.0, alpha=0.1, phi_y=0.005, beta=beta, n=n), 0.02)
        wen.plot(run["part.phi_rel"], run["part.tau"], label=f"beta = {beta:g}, n = {n:g}")
    wen.set(title="Bouc-Wen", xlabel="twist, rad", ylabel="torque, N.m")
    wen.margins(y=0.3)
    wen.legend(fontsize=8, loc="upper left")
    model = lp.compose(
        wall=Fixed(),
        part=LuGre(**LUGRE),
        body=Inertia(J=0.5),
        spring=Spring(c=20.0),
        drive=Speed(w=0.05),
        connections=lambda m: lp.chain(m.wall, m.part, m.body, m.spring, m.drive),
    )
    run = lp.simulate(lp.assemble(model), until=12.0, grid=3000)
    slip.plot(run.t, run["part.phi_rel"], label="body")
    slip.plot(run.t, 0.05 * run.t, "k--", lw=0.8, label="drive")
    slip.set(title="LuGre: stick-slip", xlabel="time, s", ylabel="angle, rad")
    slip.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    for draw in (draw_hysteresis, draw_dynamic_friction):
        figure = draw()
        for axes in figure.axes:
            axes.grid(alpha=0.3)
        figure.savefig(Path(__file__).with_name(f"{draw.__name__[5:]}.png"), dpi=80)
