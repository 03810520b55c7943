"""Draw what an elastic coupling does; every curve is a run or a response of the component.

Run from the top of the project: python docs/elements/draw_couplings.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import ElasticCoupling, Fixed, Inertia, Speed, Torque

HERE = Path(__file__).parent
ROWS = ((0, 60e3), (1000, 95e3), (2000, 150e3), (3000, 225e3))


def elastic_coupling() -> Figure:
    """Torque over twist, and responses about three mean torques."""
    figure = Figure((8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    wound = lp.compose(
        wall=Fixed(),
        coupling=ElasticCoupling(stiffness=ROWS, psi=0.0, w_loss=90.0),
        drive=Speed(w=0.0265),
        connections=lambda m: lp.chain(m.wall, m.coupling, m.drive),
    )
    run = lp.simulate(lp.assemble(wound), until=1.0)
    for sign in (1, -1):
        left.plot(sign * run["coupling.phi_rel"], sign * run["coupling.tau"], color="C0")
    drive = lp.compose(
        engine=Inertia(J=12.0),
        coupling=ElasticCoupling(stiffness=ROWS, psi=0.8, w_loss=90.0),
        load=Inertia(J=30.0),
        gas=Torque(tau=0.0),
        brake=Torque(tau=0.0),
        connections=lambda m: lp.chain(m.gas, m.engine, m.coupling, m.load, m.brake),
    )
    system = lp.assemble(drive)
    for mean in (0.0, 1000.0, 2000.0):
        point = lp.equilibrium(system, parameters={"gas.tau": mean, "brake.tau": -mean})
        response = lp.vibration.order_response(
            system,
            speeds=np.linspace(30.0, 250.0, 400),
            of=["coupling.tau"],
            excitations={"gas.tau": {1: 100.0}},
            at=point,
        )
        size = response.magnitude("coupling.tau", 1)
        right.plot(response.speeds, size, label=f"mean {mean:g} N.m")
    left.set(title="Torque over twist", xlabel="phi_rel, rad", ylabel="tau, N.m")
    right.set(title="Under 100 N.m of vibration", xlabel="w, rad/s", ylabel="amplitude, N.m")
    right.legend(fontsize="small")
    for axis in (left, right):
        axis.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    elastic_coupling().savefig(HERE / "elastic_coupling.png", dpi=80)
