"""Draw the pictures of converters and clutches: ``python docs/elements/draw_converters.py``."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    CentrifugalClutch,
    Fixed,
    FluidCoupling,
    HeatedClutch,
    Inertia,
    LimitedSlipDifferential,
    PowerLaw,
    Speed,
    SpragClutch,
    Torque,
    TorqueConverter,
    Variator,
    ViscousCoupling,
)

CONVERTER = (
    *((0.0, 1.8, 0.0345), (0.2, 1.61, 0.0322), (0.4, 1.42, 0.0299), (0.6, 1.23, 0.0276)),
    *((0.8, 1.04, 0.0207), (0.9, 1.02, 0.0172), (1.0, 1.0, 0.0), (1.222, 0.998, -0.0073)),
    *((1.571, 0.996, -0.0197), (2.2, 0.994, -0.0482), (4.4, 0.992, -0.2245)),
)
COUPLING = ((0.0, 0.0), (0.03, 0.006), (0.1, 0.014), (0.4, 0.024), (1.0, 0.03))
TRACTION = ((0.0, 0.0), (0.01, 0.05), (0.02, 0.075), (0.03, 0.08), (0.2, 0.06), (2.0, 0.05))


def at(part: lp.Component, name: str, speeds: np.ndarray) -> np.ndarray:
    """A quantity of a part between two bodies, at pairs of their speeds."""
    model = lp.compose(
        a=Inertia(J=1.0),
        part=part,
        b=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.a, m.part, m.b),
    )
    system = lp.assemble(model, keep=["a.w", "b.w"])
    points = (lp.start_point(system, start={"a.w": w_a, "b.w": w_b}) for w_a, w_b in speeds)
    return np.array([point[f"part.{name}"] for point in points])


def pairs(a: np.ndarray | float, b: np.ndarray | float) -> np.ndarray:
    """Pairs of speeds."""
    return np.column_stack(np.broadcast_arrays(a, b))


def draw_torque_converter() -> Figure:
    """Torques and efficiency over the speed ratio, and a fluid coupling."""
    figure = Figure((8.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    nu = np.linspace(-0.5, 2.0, 126)
    converter = TorqueConverter(characteristic=CONVERTER)
    pump, turbine = (at(converter, name, pairs(100.0, 100.0 * nu)) for name in ("tau_p", "tau_t"))
    left.plot(nu, pump, label="pump takes")
    left.plot(nu, turbine, label="turbine gives")
    left.set(xlabel="speed ratio", ylabel="torque, N.m", title="Converter, pump at 100 rad/s")
    drives = (nu >= 0) & (nu < 1)
    twin = left.twinx()
    twin.plot(nu[drives], nu[drives] * turbine[drives] / pump[drives], "k:", label="efficiency")
    twin.set(ylim=(-1.2, 1.2), yticks=[0, 0.5, 1])
    twin.legend(loc="lower left", fontsize=8)
    w_b = np.linspace(-100.0, 200.0, 151)
    for w_a in (50.0, 100.0):
        tau = at(FluidCoupling(characteristic=COUPLING), "tau", pairs(w_a, w_b))
        right.plot(w_b, -tau, label=f"a at {w_a:g} rad/s")
    right.set(xlabel="speed of b, rad/s", ylabel="torque from a to b, N.m", title="Fluid coupling")
    return finished(figure, left, right)


def draw_variator() -> Figure:
    """Traction and efficiency over slip, and a sweep of the ratio."""
    figure = Figure((8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    belt = Variator(characteristic=TRACTION, ratio=1.0, f_n=8e3, R=0.05, v_low=0.01)
    s = np.linspace(0.0, 0.3, 121)
    tau = at(belt, "r_b", pairs(200.0, 200.0)) * at(belt, "f_t", pairs(200.0, 200.0 * (1 - s)))
    left.plot(s, tau, label="torque at b, N.m")
    left.plot(s, 40 * (1 - s), ":", label="efficiency x 40")
    left.set(xlabel="slip", title="8 kN, both radii 50 mm", ylim=(0, 42))
    sweep = lp.ops.table([0.5, 1.5, 2.5, 3.5], [2.4, 2.4, 0.5, 0.5])
    model = lp.compose(
        drive=Speed(w=200.0),
        belt=belt.with_({"ratio": sweep, "f_n": 16e3}),
        body=Inertia(J=0.02),
        load=Torque(tau=-15.0),
        connections=lambda m: lp.chain(m.drive, m.belt, m.body, m.load),
    )
    run = lp.simulate(lp.assemble(model), until=3.5, start={"body.w": 200.0 / 2.4}, grid=1500)
    right.plot(run.t, run["body.w"], label="speed of b, rad/s")
    right.plot(run.t, 1e4 * run["belt.s"], label="slip, 1e-4")
    right.plot(run.t, 100 * run["belt.ratio"], "--", label="ratio, 1e-2")
    right.set(xlabel="time, s", title="a at 200 rad/s, 16 kN, load 15 N.m")
    return finished(figure, left, right)


def draw_limited_slip() -> Figure:
    """Drag of viscous couplings, and how differentials share the torque."""
    figure = Figure((8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    slip = np.linspace(-60.0, 60.0, 121)
    power = PowerLaw(nominal=300.0, v_nominal=50.0, n=0.6, v_low=0.5)
    for label, law in (("PowerLaw, n = 0.6", power), ("rows", ((0, 0), (10, 60), (60, 150)))):
        visco = ViscousCoupling(characteristic=law)
        left.plot(slip, at(visco, "tau", pairs(0.0, slip)), label=label)
    left.set(xlabel="speed of b relative to a, rad/s", ylabel="torque on flange b, N.m")
    left.set(title="Viscous coupling")
    push = np.linspace(-400.0, 400.0, 161)
    for name, style in (("left", "C0"), ("right", "C1")):
        right.plot(push, [shared(name, tau) for tau in push], style, label=f"{name} wheel")
    right.set(xlabel="torque on the cage, N.m", ylabel="torque to a wheel, N.m")
    right.set(title="S = 0.4 and 0.2, left wheel faster")
    return finished(figure, left, right)


def shared(side: str, push: float) -> float:
    """Torque to a wheel of a locking differential, the left one turning faster."""
    model = lp.compose(
        push=Torque(tau=push),
        gear=LimitedSlipDifferential(ratio=1.0, S_drive=0.4, S_coast=0.2, tau_0=40.0),
        left=Speed(w=11.0),
        right=Speed(w=10.0),
        connections=lambda m: [
            lp.connect(m.push.flange, m.gear.flange_a),
            lp.connect(m.left.flange, m.gear.left),
            lp.connect(m.right.flange, m.gear.right),
        ],
    )
    return -lp.start_point(lp.assemble(model))[f"gear.{side}.tau"]


def draw_gearbox_clutches() -> Figure:
    """A run-up by shoes, sprags that catch a body, and the heat of an engagement."""
    figure = Figure((9.0, 3.1), layout="constrained")
    shoes, sprags, heat = figure.subplots(1, 3)
    run = row(
        2.5,
        push=Torque(tau=8.0),
        hub=Inertia(J=0.02, w=0.0),
        clutch=CentrifugalClutch(m=0.4, r_g=0.06, r=0.08, n=3.0, f_spring=150.0),
        drum=Inertia(J=0.15, w=0.0),
    )
    for name in ("hub.w", "drum.w"):
        shoes.plot(run.t, run[name], label=f"{name[:-2]}, rad/s")
    shoes.plot(run.t, -10 * run["clutch.tau"], ":", label="torque, 0.1 N.m")
    shoes.set(xlabel="time, s", title="CentrifugalClutch")
    run = row(
        0.16,
        ground=Fixed(),
        sprag=SpragClutch(c=5e3, d=1.0),
        body=Inertia(J=0.3, w=0.6),
        pull=Torque(tau=-15.0),
    )
    sprags.plot(run.t, 20 * run["body.w"], label="speed, 0.05 rad/s")
    sprags.plot(run.t, -run["sprag.tau"], label="torque of the sprags, N.m")
    sprags.set(xlabel="time, s", title="SpragClutch", ylim=(-10, 48))
    run = row(
        2.5,
        body=Inertia(J=0.5, w=180.0),
        clutch=HeatedClutch(
            T_p=0.1,
            A=0.004,
            f_spring=600.0,
            n=8.0,
            r=0.07,
            C_lining=60.0,
            C_plate=900.0,
            G=120.0,
            p_wanted=4e5,
        ),
        ground=Fixed(),
    )
    heat.plot(run.t, run["body.w"], label="speed, rad/s")
    heat.plot(run.t, run["clutch.lining.T"] - 273.15, label="linings, degC")
    heat.plot(run.t, run["clutch.plate.T"] - 273.15, label="plates, degC")
    heat.plot(run.t, 1e-4 * run["clutch.friction.p"], ":", label="pressure, 0.1 bar")
    heat.set(xlabel="time, s", title="HeatedClutch")
    return finished(figure, shoes, sprags, heat)


def row(until: float, **parts: lp.Component) -> lp.Trajectory:
    """A run of parts in a row."""
    model = lp.compose(
        **parts, connections=lambda m: lp.chain(*(getattr(m, name) for name in parts))
    )
    kept = ["clutch.plate.T"] if isinstance(parts.get("clutch"), HeatedClutch) else []
    return lp.simulate(lp.assemble(model, keep=kept), until=until, grid=1500)


def finished(figure: Figure, *all_axes: Axes) -> Figure:
    """Finish the axes."""
    for axes in all_axes:
        axes.grid(alpha=0.3)
        axes.axhline(0, color="0.6", lw=0.8)
        axes.legend(fontsize=8)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    "torque_converter": draw_torque_converter,
    "variator": draw_variator,
    "limited_slip": draw_limited_slip,
    "gearbox_clutches": draw_gearbox_clutches,
}

if __name__ == "__main__":
    for name, draw in PICTURES.items():
        draw().savefig(Path(__file__).with_name(f"{name}.png"), dpi=80)
