"""Draw the swing of a generator: ``python docs/elements/draw_power_system.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    InfiniteBus,
    PerUnit,
    PowerSystemStabiliser,
    SpeedSensor,
    StaticExciter,
    ThreePhaseLine,
    Torque,
    WoundFieldMachine,
    standard_parameters,
    wires,
)

FOLDER = Path(__file__).parent
BASE = PerUnit(S=2220e6, V=24e3, f=60.0)
DATA = standard_parameters(
    BASE,
    X_d=(1.81, 0.3, 0.23),
    T_do=(8.0, 0.03),
    X_q=(1.76, 0.65, 0.25),
    T_qo=(1.0, 0.07),
    X_l=0.15,
    R_a=0.003,
)
FREE = ["bus.V", "bus.phase", "turbine.tau", "exciter.V_ref"]


def plant():
    """The generator on its line, with a pulse of torque at 1 s."""
    pulse = lp.ops.where(lp.time < 1.1, 0.2 * BASE.tau, 0.0)
    return lp.compose(
        bus=InfiniteBus(V=BASE.v, f=BASE.f),
        line=ThreePhaseLine(L=0.475 * BASE.L),
        machine=WoundFieldMachine(
            **DATA,
            J=BASE.J(3.5),
            w=BASE.speed,
            steady=True,
            P_0=-0.9 * BASE.S,
            Q_0=-0.436 * BASE.S,
            V_0=BASE.v,
        ),
        turbine=Torque(tau=0.9 * BASE.tau),
        push=Torque(tau=lp.ops.where(lp.time < 1.0, 0.0, pulse)),
        sensor=SpeedSensor(),
        exciter=StaticExciter(
            V_n=BASE.v,
            v_n=DATA["R_f"] * BASE.v / (BASE.w * DATA["L_md"]),
            T_R=0.015,
            K_A=200.0,
            T_A=0.01,
            E_min=-6.4,
            E_max=7.0,
            steady=True,
        ),
        stabiliser=PowerSystemStabiliser(
            w_s=BASE.speed, K=9.5, T_w=1.41, T_1=0.154, T_2=0.033, y_min=-0.2, y_max=0.2
        ),
        connections=lambda m: [
            *wires(m.bus, m.line, m.machine),
            lp.connect(m.turbine.flange, m.push.flange, m.machine.flange, m.sensor.flange),
            lp.connect(m.machine.V_meas, m.exciter.V),
            lp.connect(m.sensor.w, m.stabiliser.w),
            lp.connect(m.stabiliser.y, m.exciter.u),
            lp.connect(m.exciter.y, m.machine.v_f),
        ],
        initial_equations=lambda m: [lp.der(m.machine.w) == 0],
    )


def draw():
    """Speed after the pulse; damping ratio over the gain."""
    system = lp.assemble(plant())
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.8, 3.2), layout="constrained")
    for K, text in ((0.0, "without stabiliser"), (9.5, "with")):
        run = lp.simulate(system, until=6.0, grid=1500, free=FREE, parameters={"stabiliser.K": K})
        left.plot(run.t, 100 * (run["machine.w"] / BASE.speed - 1), label=text)
    left.set(xlabel="time, s", title="speed less the synchronous one, %")
    gains = np.linspace(0.0, 30.0, 61)
    ratios = []
    for K in gains:
        point = lp.start_point(system, free=FREE, parameters={"stabiliser.K": K})
        roots = np.linalg.eigvals(lp.linearise(system, at=point).A)
        ratios.append([-r.real / abs(r) for r in roots if 1.0 < r.imag < 100.0])
    ratios = np.sort(np.array(ratios), axis=1)
    right.plot(gains, ratios[:, 0])
    right.axhline(0, color="0.5", linewidth=0.8)
    right.set(xlabel="gain of the stabiliser", title="least damping ratio")
    for axes in (left, right):
        axes.grid(color="0.9")
        axes.spines[["top", "right"]].set_visible(False)
    left.legend(frameon=False)
    figure.savefig(FOLDER / "power_system.png", dpi=75)


if __name__ == "__main__":
    draw()
