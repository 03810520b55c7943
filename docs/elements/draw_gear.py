"""Draw the pictures of lossy gears, loads and vehicles: ``python docs/elements/draw_gear.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    EddyCurrentBrake,
    ElasticPlanetary,
    Fixed,
    FixedTemperature,
    GearMesh,
    Inertia,
    InverseTorque,
    LinearTorque,
    LossyGear,
    QuadraticTorque,
    SignTorque,
    Speed,
    Torque,
    Vehicle,
)
from lumped.life import GearPair, MeshStiffness

FOLDER = Path(__file__).parent
LOSSES = (
    (0.0, 0.85, 0.75, 0.5, 0.5),
    (50.0, 0.95, 0.9, 0.8, 0.8),
    (100.0, 0.93, 0.88, 1.4, 1.4),
)


def sweep(low, high):
    """A quantity that rises evenly from low to high in one second."""
    return low + (high - low) * lp.time


def gear(w, tau):
    """Torque at side a, speed and loss torque of a gear that is turned at b and loaded at a."""
    model = lp.compose(
        load=Torque(tau=tau),
        gear=LossyGear(ratio=1.0, losses=LOSSES),
        turn=Speed(w=w),
        connections=lambda m: lp.chain(m.load, m.gear, m.turn),
    )
    run = lp.simulate(lp.assemble(model), until=1.0, grid=800)
    return run["gear.flange_a.tau"], run["gear.w"], run["gear.tau_loss"]


def draw_lossy_gear():
    """Loss torque over torque at several speeds, and over speed at several torques."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.1), sharey=True)
    for w in (100.0, 20.0, -20.0, -100.0):
        tau, _, loss = gear(w, sweep(-10.0, 10.0))
        left.plot(tau, loss, label=f"{w:g} rad/s")
    for tau in (10.0, 4.0, -4.0, -10.0):
        _, w, loss = gear(sweep(-120.0, 120.0), tau)
        right.plot(w, loss, label=f"{tau:g} N.m")
    left.set(xlabel="torque on flange a, N.m", ylabel="loss torque, N.m", title="at four speeds")
    right.set(xlabel="speed of flange a, rad/s", title="at four torques")
    left.set_ylim(-4.5, 7)
    finish(figure, "lossy_gear", columns=2)


def draw_elastic_planetary():
    """Force of the sun's mesh on a torque at the sun, over the frequency."""
    figure, axes = plt.subplots(figsize=(5.5, 3.6))
    hertz = np.geomspace(100, 8000, 1200)
    for c in (1e8, 2e8, 4e8):
        stage = ElasticPlanetary(
            ratio=2.8, r_s=0.04, n=3, J_p=2e-4, c_s=c, c_r=1.5 * c, d_s=800.0, d_r=800.0
        )
        model = lp.compose(
            drive=Torque(tau=0.0),
            sun=Inertia(J=0.01),
            stage=stage,
            carrier=Inertia(J=0.15),
            housing=Fixed(),
            connections=lambda m: [
                *lp.chain(m.drive, m.sun, m.stage.sun),
                lp.connect(m.stage.carrier, m.carrier.flange_a),
                lp.connect(m.stage.ring, m.housing.flange),
            ],
        )
        response = lp.frequency_response(
            lp.assemble(model), inputs=["drive.tau"], outputs=["stage.f_s"], hertz=hertz
        )
        found = np.abs(response["stage.f_s", "drive.tau"])
        axes.loglog(hertz, found, label=f"c_s = {c:g} N/m")
    axes.set(xlabel="frequency, Hz", ylabel="force of a mesh over torque, N/N.m")
    axes.set(title="sun 0.01, carrier 0.15 kg.m2, ring held")
    finish(figure, "elastic_planetary")


def draw_gear_mesh():
    """Force over deflection at two speeds; stiffness and static error over the pitch."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(9.0, 3.1))
    for speed in (0.01, 0.3):
        for way in (1, -1):
            mesh = GearMesh(r_a=1.0, r_b=1.0, z=1, c=4e8, d=2e5, b=5e-5, s=-way * 5e-5)
            model = lp.compose(
                drive=Speed(w=way * speed),
                mesh=mesh,
                wall=Fixed(),
                connections=lambda m: lp.chain(m.drive, m.mesh, m.wall),
            )
            run = lp.simulate(lp.assemble(model), until=1e-4 / speed, grid=600)
            label = f"{speed:g} m/s" if way > 0 else None
            style, color = ("-" if way > 0 else "--"), ("C0" if speed < 0.1 else "C1")
            left.plot(1e6 * run["mesh.s"], run["mesh.f"] / 1e3, style, color=color, label=label)
    left.set(xlabel="s, um", ylabel="f, kN", title="b = 50 um (dashed: back)")
    for helix in (0.0, 10.0, 20.0):
        pair = GearPair((25, 40), "4 mm", "30 mm", helix=f"{helix} deg")
        model = lp.compose(
            drive=Speed(w=2 * np.pi / 25),
            mesh=GearMesh(teeth=MeshStiffness(pair), harmonics=12),
            wheel=Inertia(J=1.0),
            connections=lambda m: lp.chain(m.drive, m.mesh, m.wheel),
        )
        system = lp.assemble(model)
        run = lp.simulate(system, until=1.0, grid=400, start={"wheel.w": -0.1})
        error = run[system.model.mesh.static_error(3000.0)]
        middle.plot(run.t, 3000.0 / error / 1e6, label=f"helix {helix:g} deg")
        right.plot(run.t, 1e6 * error, label=f"helix {helix:g} deg")
    middle.set(xlabel="position in the pitch", title="stiffness, N/um", ylim=(0, 1100))
    right.set(xlabel="position in the pitch", title="static error under 3 kN, um", ylim=(0, 15))
    finish(figure, "gear_mesh")


def loaded(part, **given):
    """A load turned by a source whose speed rises evenly."""
    return lp.compose(
        turn=Speed(w=sweep(-30.0, 30.0)),
        part=part,
        **given,
        connections=lambda m: [
            lp.connect(m.turn.flange, m.part.flange),
            *(lp.connect(m.part.heat, m.air.port) for _ in given),
        ],
    )


def draw_loads():
    """Driving torque over speed."""
    parts = {
        "linear": LinearTorque(tau_nominal=-10.0, w_nominal=20.0),
        "quadratic": QuadraticTorque(tau_nominal=-10.0, w_nominal=20.0),
        "sign": SignTorque(tau_nominal=-10.0, w0=50.0),
        "inverse": InverseTorque(tau_nominal=-10.0, w_nominal=20.0, w0=10.0),
    }
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.1), sharey=True)
    for name, part in parts.items():
        run = lp.simulate(lp.assemble(loaded(part)), until=1.0, grid=600)
        left.plot(run["part.w"], run["part.tau"], label=name)
        if name != "sign":
            run = lp.simulate(
                lp.assemble(loaded(part.with_({"same_direction": True}))), until=1.0, grid=600
            )
            right.plot(run["part.w"], run["part.tau"], label=name)
    left.set(xlabel="speed, rad/s", ylabel="driving torque, N.m", title="reversing with the speed")
    right.set(xlabel="speed, rad/s", title="same_direction=True")
    left.set_ylim(-24, 38)
    finish(figure, "loads", columns=2)


def draw_eddy_current_brake():
    """Braking torque over speed at two temperatures."""
    figure, axes = plt.subplots(figsize=(5.5, 3.6))
    for temperature in (293.15, 493.15):
        brake = EddyCurrentBrake(tau_max=100.0, w_nominal=6.0, alpha=0.0039, e=1.0)
        model = loaded(brake, air=FixedTemperature(T=temperature))
        run = lp.simulate(lp.assemble(model), until=1.0, grid=600)
        axes.plot(run["part.w"], run["part.tau"], label=f"{temperature:g} K")
    axes.set(xlabel="speed, rad/s", ylabel="braking torque, N.m", title="w_nominal = 6 rad/s")
    finish(figure, "eddy_current_brake")


def draw_vehicle():
    """Resistances over speed."""
    model = lp.compose(
        turn=Speed(w=sweep(0.0, 50.0 / 0.3)),
        car=Vehicle(m=1400.0, R=0.3, A=2.2, cd=0.3, cr=0.012, inclination=0.03, v_wind=0.0),
        connections=lambda m: [lp.connect(m.turn.flange, m.car.wheel)],
    )
    run = lp.simulate(lp.assemble(model), until=1.0, grid=600)
    figure, axes = plt.subplots(figsize=(5.5, 3.6))
    for name, label in (("f_drag", "air"), ("f_roll", "rolling"), ("f_grade", "3 % uphill")):
        axes.plot(run["car.v"], run[f"car.{name}"], label=label)
    axes.set(xlabel="velocity, m/s", ylabel="resistance, N", title="car of 1400 kg")
    finish(figure, "vehicle")


def finish(figure, name, columns=1):
    """Grid, legend, file."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
        if axes.get_yscale() == "linear":
            axes.axhline(0, color="0.4", lw=0.6)
        axes.legend(fontsize=8, ncols=columns, loc="upper left" if columns == 1 else "upper center")
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=80)
    plt.close(figure)


if __name__ == "__main__":
    draw_lossy_gear()
    draw_elastic_planetary()
    draw_gear_mesh()
    draw_loads()
    draw_eddy_current_brake()
    draw_vehicle()
