"""Draw the pictures of loads: ``python docs/elements/draw_loads.py``."""

import math

from draw_friction import finish, plt

import lumped as lp
from lumped.components import IceTorque, Inertia, Propeller, SpringDamper, Torque


def draw_ice():
    """A propeller of four blades meets a sequence of ice."""
    model = lp.compose(
        motor=Torque(tau=4e5),
        rotor=Inertia(J=8e3, w=12.0),
        shaft=SpringDamper(c=2e7, d=2e4),
        screw=Inertia(J=2e4, w=12.0),
        water=Propeller(tau_nominal=4e5, w_nominal=12.0),
        ice=IceTorque(blocks=((0.75, math.pi / 2, 0.0),), Z=4, Q_max=3e5, turns=6.0),
        connections=lambda m: [
            *lp.chain(m.motor, m.rotor, m.shaft, m.screw),
            lp.connect(m.screw.flange_b, m.water.flange, m.ice.flange),
        ],
    )
    start = {"shaft.phi_rel": -4e5 / 2e7}
    run = lp.simulate(lp.assemble(model), until=4.0, grid=2000, start=start)
    figure, axes = plt.subplots(figsize=(5.4, 3.6))
    axes.plot(run.t, -1e-3 * run["shaft.tau"], label="shaft")
    axes.plot(run.t, 1e-3 * run["ice.tau"], label="ice")
    axes.set(xlabel="time, s", ylabel="torque, kN.m", title="Ice on a propeller of four blades")
    finish(figure, "ice")


if __name__ == "__main__":
    draw_ice()
