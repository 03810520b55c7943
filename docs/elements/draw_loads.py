"""Draw the pictures of loads: ``python docs/elements/draw_loads.py``."""

import math

from draw_friction import FOLDER, finish, plt

import lumped as lp
from lumped.components import (
    WLTC_3B,
    HoistRope,
    IceTorque,
    Inertia,
    Propeller,
    QuadraticTorque,
    Speed,
    SpringDamper,
    Torque,
    WindRotor,
    extreme_gust,
    operating_gust,
    turbulence,
)
from lumped.components.translation import Force, MassWithStops


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


def draw_drive_cycle():
    """Speeds of the WLTC."""
    figure, axes = plt.subplots(figsize=(7.4, 2.8))
    axes.plot(range(1801), [3.6 * v for v in WLTC_3B], lw=1)
    for second in (589, 1022, 1477):
        axes.axvline(second, color="0.6", lw=0.8)
    axes.set(xlabel="time, s", ylabel="speed, km/h", title="WLTC, class 3b", xlim=(0, 1800))
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(FOLDER / "drive_cycle.png", dpi=80)
    plt.close(figure)


def draw_hoist():
    """A drum takes up a slack rope and lifts a load off the ground."""
    weight = 9.80665 * 2000.0
    model = lp.compose(
        motor=Speed(w=2.0),
        shaft=SpringDamper(c=5e5, d=2e3),
        drum=Inertia(J=60.0, w=2.0),
        rope=HoistRope(r=0.4, EA=4e6, l_0=30.0, D=2e4),
        load=MassWithStops(m=2000.0, s_min=0.0, s_max=100.0),
        weight=Force(f=-weight),
        connections=lambda h: [
            *lp.chain(h.motor, h.shaft, h.drum),
            lp.connect(h.drum.flange_b, h.rope.drum),
            *lp.chain(h.rope.load, h.load, h.weight),
        ],
    )
    start = {"rope.e": -0.1, "load.v": 0.0}
    run = lp.simulate(lp.assemble(model), until=6.0, grid=1000, start=start)
    figure, axes = plt.subplots(figsize=(5.4, 3.6))
    axes.plot(run.t, run["rope.T"] / weight, label="tension over weight")
    axes.plot(run.t, run["load.v"], label="speed of the load, m/s")
    axes.set(xlabel="time, s", title="A load is lifted by a slack rope")
    finish(figure, "hoist")


def draw_wind():
    """A rotor in a gust and in turbulence."""
    rows = ((3.0, 0.08), (5.0, 0.28), (7.0, 0.44), (8.5, 0.47), (10.0, 0.43), (13.0, 0.2))
    size = extreme_gust(9.0, V_ref=50.0, I_ref=0.16, D=80.0, z=80.0)
    gust = operating_gust(9.0, size, begin=20.0)
    storm = lp.ops.table(*turbulence(9.0, 1.4, 80.0, 600.0, 0.5, 1))
    figure, pairs = plt.subplots(2, 2, figsize=(7.4, 4.0), sharex="col")
    for (upper, lower), v, until in zip(pairs.T, (gust, storm), (60.0, 600.0), strict=True):
        model = lp.compose(
            rotor=WindRotor(coefficients=(*rows, (18.0, -0.2)), R=40.0, v=v),
            body=Inertia(J=6e6, w=2.44),
            generator=QuadraticTorque(tau_nominal=-2.1e5, w_nominal=1.9),
            connections=lambda m: lp.chain(m.rotor, m.body, m.generator),
        )
        run = lp.simulate(lp.assemble(model), until=until, grid=1200)
        upper.plot(run.t, 40.0 * run["body.w"] / run["rotor.x"])
        lower.plot(run.t, run["body.w"])
        lower.set(xlabel="time, s")
    pairs[0, 0].set(ylabel="wind, m/s", title="operating gust")
    pairs[0, 1].set(title="turbulence")
    pairs[1, 0].set(ylabel="rotor, rad/s")
    for axes in pairs.flat:
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(FOLDER / "wind.png", dpi=80)
    plt.close(figure)


if __name__ == "__main__":
    draw_drive_cycle()
    draw_hoist()
    draw_ice()
    draw_wind()
