"""Draw the picture of planetary stages: ``python docs/elements/draw_planetary.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import Fixed, Inertia, PlanetaryStage, Torque

FOLDER = Path(__file__).parent
MICRONS = np.linspace(-20.0, 12.0, 65)


def loaded(n):
    """Torque of each planet and load sharing factor over the error of the first pin."""
    stage = PlanetaryStage(
        z_s=42,
        z_p=18,
        z_r=78,
        r_s=0.1,
        alpha=0.4,
        m_p=20.0,
        J_p=0.05,
        n=n,
        c_s=1e9,
        c_r=1.2e9,
    )
    system = lp.assemble(
        lp.compose(
            motor=Torque(tau=5000.0),
            rotor=Inertia(J=1.0),
            stage=stage,
            carrier=Fixed(),
            ring=Fixed(),
            connections=lambda m: [
                *lp.chain(m.motor, m.rotor, m.stage.sun),
                lp.connect(m.stage.carrier, m.carrier.flange),
                lp.connect(m.stage.ring, m.ring.flange),
            ],
        )
    )
    points = [
        lp.equilibrium(system, parameters={"stage.planets[0].pin_t": 1e-6 * error})
        for error in MICRONS
    ]
    torques = [[at[f"stage.planets[{i}].tau"] for i in range(n)] for at in points]
    return np.array(torques), np.array([at["stage.sharing"] for at in points])


def main():
    """Load sharing factors of stages of three to five planets, and the torques of four."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.1))
    for n in (3, 4, 5):
        torques, sharing = loaded(n)
        left.plot(MICRONS, sharing, label=f"{n} planets")
        if n == 4:
            right.plot(MICRONS, torques[:, 0] / 1e3, label="planet 0")
            right.plot(MICRONS, torques[:, 1] / 1e3, label="each other")
    for axes in (left, right):
        axes.set(xlabel="pin_t of planet 0, \u00b5m")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    left.set(ylabel="load sharing factor", title="5 kN.m on the sun")
    right.set(ylabel="torque of a planet, kN.m", title="4 planets")
    figure.tight_layout()
    figure.savefig(FOLDER / "planetary.png", dpi=80)


if __name__ == "__main__":
    main()
