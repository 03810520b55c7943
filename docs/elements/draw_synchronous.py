"""Draw faults and the start of machines: ``python docs/elements/draw_synchronous.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    Inertia,
    InfiniteBus,
    PerUnit,
    QuadraticTorque,
    ShortCircuit,
    SpringDamper,
    SynchronousMotorStart,
    ThreePhaseLine,
    Torque,
    WoundFieldMachine,
    standard_parameters,
    wires,
)

FOLDER = Path(__file__).parent
BASE = PerUnit(S=892.4e6, V=26e3, f=60.0)
DATA = standard_parameters(
    BASE,
    X_d=(1.79, 0.169, 0.135),
    T_do=(4.3, 0.032),
    X_q=(1.71, 0.228, 0.2),
    T_qo=(0.85, 0.05),
    X_l=0.13,
    R_a=0.0025,
)
LOAD_ANGLE = np.angle(1 + (0.0025 + 1.71j) * (0.9 - 0.436j))
START = (
    *((0.0, 0.80, 0.60), (0.2, 0.85, 0.62), (0.4, 0.90, 0.65), (0.6, 0.95, 0.68)),
    *((0.7, 1.00, 0.70), (0.8, 1.05, 0.72), (0.85, 1.05, 0.70), (0.9, 1.00, 0.65)),
    *((0.95, 0.80, 0.55), (0.98, 0.45, 0.40), (1.0, 0.0, 0.30)),
)
W_S = 60 * np.pi


def faulted(phases, end=1e9):
    """Run of a generator with a fault at the time zero."""
    model = lp.compose(
        bus=InfiniteBus(V=BASE.v, f=BASE.f),
        line=ThreePhaseLine(R=0.02 * BASE.Z, L=0.7 * BASE.L),
        fault=ShortCircuit(begin=0.0, end=end, phases=phases),
        machine=WoundFieldMachine(
            **DATA,
            J=BASE.J(2.894),
            v_f=1e-3 * BASE.v,
            w=BASE.speed,
            steady=True,
            P_0=-0.9 * BASE.S,
            Q_0=-0.436 * BASE.S,
            V_0=BASE.v,
        ),
        turbine=Torque(tau=0.9 * BASE.tau),
        connections=lambda m: [
            *wires(m.bus, m.line, m.fault, m.machine),
            lp.connect(m.turbine.flange, m.machine.flange),
        ],
        initial_equations=lambda m: [lp.der(m.machine.w) == 0],
    )
    return lp.simulate(
        lp.assemble(model),
        begin=-0.02,
        until=0.3,
        grid=3200,
        start={"machine.phi": LOAD_ANGLE - np.pi / 2 - 0.02 * BASE.w},
        free=["bus.V", "bus.phase", "machine.v_f", "turbine.tau"],
    )


def started():
    """Run of a motor and a compressor up to 0.97 of the synchronous speed."""
    model = lp.compose(
        motor=SynchronousMotorStart(J=600.0, tau_n=40e3, f=60.0, pairs=2, torques=START),
        shaft=SpringDamper(c=6.0e6, d=1200.0),
        compressor=Inertia(J=900.0),
        load=QuadraticTorque(tau_nominal=-12e3, w_nominal=W_S),
        connections=lambda m: [
            *lp.chain(m.motor.flange, m.shaft, m.compressor),
            lp.connect(m.compressor.flange_b, m.load.flange),
        ],
    )
    return lp.simulate(lp.assemble(model), until=8.486, grid=8000)


def finish(figure, axes, name):
    """Plain axes, and the file."""
    for ax in axes:
        ax.grid(color="0.9")
        ax.spines[["top", "right"]].set_visible(False)
    figure.savefig(FOLDER / name, dpi=70)


def draw():
    """Both pictures."""
    figure, axes = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained", sharey=True)
    titles = ("three phases, cleared after 0.1 s", "two phases")
    for ax, title, run in zip(axes, titles, (faulted("abc", 0.1), faulted("bc")), strict=True):
        ax.plot(run.t, -run["machine.tau"] / BASE.tau, linewidth=0.9)
        ax.set(title=title, xlabel="time, s")
    axes[0].set_ylabel("air-gap torque over rated torque")
    finish(figure, axes, "synchronous_machine.png")
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), layout="constrained")
    run = started()
    left.plot(run.t, -run["shaft.tau"] / 1e3, linewidth=0.5)
    left.set(title="Torque of the shaft", xlabel="time, s", ylabel="kN.m")
    right.plot(run.t, run["motor.f_p"], label="pulsation")
    right.axhline(20.55, color="0.5", linewidth=0.8, label="natural frequency")
    right.set(title="Frequency", xlabel="time, s", ylabel="Hz")
    right.legend(frameon=False, fontsize=8)
    finish(figure, (left, right), "synchronous_start.png")


if __name__ == "__main__":
    draw()
