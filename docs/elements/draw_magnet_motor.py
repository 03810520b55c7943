"""Draw limits and currents of a magnet motor: ``python docs/elements/draw_magnet_motor.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import Ground, MagnetMotor, Speed, VoltageSource

FOLDER = Path(__file__).parent
RPM = 30 / np.pi
PAIRS, PSI, L_D, L_Q, I_MAX, R, V_DC = 4, 0.06, 2e-4, 5e-4, 400.0, 0.01, 300.0


def stand():
    """The motor on a direct voltage, turned by a source of speed."""
    return lp.compose(
        source=VoltageSource(v=V_DC),
        ground=Ground(),
        motor=MagnetMotor(
            pairs=PAIRS, psi=PSI, L_d=L_D, L_q=L_Q, R=R, I_max=I_MAX, T=1e-3, J=0.05, wanted=0.0
        ),
        turn=Speed(w=0.0),
        connections=lambda m: [
            lp.connect(m.source.p, m.motor.p),
            lp.connect(m.source.n, m.motor.n, m.ground.pin),
            lp.connect(m.motor.flange, m.turn.flange),
        ],
    )


def settle(system, w, wanted):
    """Torque and currents in steady state."""
    point = lp.equilibrium(system, parameters={"turn.w": w, "motor.wanted": wanted})
    return [point[f"motor.{name}"] for name in ("tau", "i_d", "i_q")]


def draw():
    """Torque and power over speed; the way of the currents."""
    system = lp.assemble(stand())
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.2, 3.6), layout="constrained")
    speeds = np.linspace(0.0, 1600.0, 81)
    most = np.array([settle(system, w, 1e4) for w in speeds])
    left.plot(speeds * RPM, most[:, 0], label="greatest torque, N.m")
    left.plot(speeds * RPM, most[:, 0] * speeds / 1e3, label="its power, kW")
    left.set(xlabel="speed, 1/min", xlim=(0, 1600 * RPM), ylim=(0, None))
    left.legend(frameon=False)
    angle = np.linspace(np.pi / 2, np.pi, 100)
    right.plot(I_MAX * np.cos(angle), I_MAX * np.sin(angle), "k", linewidth=0.8)
    low = np.array([settle(system, 0.0, tau) for tau in np.linspace(0.0, 1e3, 60)])
    right.plot(low[:, 1], low[:, 2], label="MTPA, below base speed")
    right.plot(most[:, 1], most[:, 2], label="greatest torque")
    for w in (400.0, 1000.0):
        part = np.array([settle(system, w, tau) for tau in np.linspace(0.0, 1e3, 200)])
        right.plot(part[:, 1], part[:, 2], "--", label=f"any torque, {w * RPM:.0f} 1/min")
        X = (V_DC / 3**0.5 - R * I_MAX) / (PAIRS * w)
        turn = np.linspace(0.0, np.pi, 400)
        i_d, i_q = (X * np.cos(turn) - PSI) / L_D, X * np.sin(turn) / L_Q
        right.plot(i_d, i_q, color="0.7", linewidth=0.8, zorder=0)
    right.set(xlabel="i_d, A", ylabel="i_q, A", xlim=(-420, 60), ylim=(0, 560), aspect="equal")
    right.annotate("MTPV", (-345, 62), (-330, 20), fontsize="small")
    right.legend(frameon=False, fontsize="x-small", loc="upper center", ncols=2, columnspacing=0.8,
                 handlelength=1.2)  # fmt: skip
    for axes in (left, right):
        axes.grid(color="0.9")
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(FOLDER / "magnet_motor.png", dpi=75)


if __name__ == "__main__":
    draw()
