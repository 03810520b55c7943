"""Draw the pictures of motors and controllers: ``python docs/elements/draw_drives.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    ConverterDrive,
    DCMotor,
    FieldOrientedMotor,
    Ground,
    InductionMotor,
    Inertia,
    LimitedPI,
    MappedMotor,
    PIController,
    QuasiStaticSeriesDCMotor,
    SampledPI,
    SeparatelyExcitedDCMotor,
    SeriesDCMotor,
    SpeedSensor,
    SquareRootController,
    Torque,
    VoltageSource,
)

FOLDER = Path(__file__).parent
RPM = 30 / np.pi
SWEEP = 2000.0
"""Length of a run along a characteristic, s: so slow that currents are settled."""


class Ramp(lp.Component):
    """A source of speed that rises evenly.

    The speed is a state: along a formula of time all switches are sought before the run, and two
    limits of a motor that agree over a while touch too often for that.
    """

    flange = lp.Flange()
    low: lp.Param = lp.param("rad/s", "first speed", 0.0)
    high: lp.Param = lp.param("rad/s", "last speed", 100.0)
    w: lp.Var = lp.var("rad/s", "speed", start=low)

    def equations(self):
        """Yield the motion."""
        yield lp.der(self.flange.phi) == self.w
        yield lp.der(self.w) == (self.high - self.low) / SWEEP


class MotorOn100V(lp.Component):
    """A direct-current motor on 100 V, turned by a source of speed."""

    source: VoltageSource = VoltageSource(v=100.0)
    ground: Ground = Ground()
    motor: lp.Component = DCMotor(k=0.637, R=0.05, L=1.5e-3, J=0.15)
    turn: Ramp = Ramp()

    def connections(self):
        """Yield the circuit and the shaft."""
        yield lp.connect(self.source.p, self.motor.p)
        yield lp.connect(self.source.n, self.motor.n, self.ground.pin)
        yield lp.connect(self.motor.flange, self.turn.flange)


class Excited(MotorOn100V):
    """The same with a field on a voltage of its own."""

    field: VoltageSource = VoltageSource(v=100.0)
    motor: SeparatelyExcitedDCMotor = SeparatelyExcitedDCMotor(
        k=0.382, R=0.05, L=1.5e-3, R_f=60.0, L_f=12.0, J=0.15
    )

    def connections(self):
        """Yield the circuit of the field, too."""
        yield from super().connections()
        yield lp.connect(self.field.p, self.motor.field_p)
        yield lp.connect(self.field.n, self.motor.field_n, self.source.n)


class MotorStand(lp.Component):
    """A motor turned by a source of speed."""

    motor: lp.Component = InductionMotor(w_s=157.08, tau_k=140.0, s_k=0.2, J=0.1)
    turn: Ramp = Ramp()

    def connections(self):
        """Yield the shaft."""
        yield lp.connect(self.motor.flange, self.turn.flange)


def sweep(model, low, high, names=("motor.tau",)):
    """Speed in 1/min and quantities while the speed rises evenly."""
    system = lp.assemble(model.with_({"turn.low": low, "turn.high": high}))
    run = lp.simulate(system, until=SWEEP, grid=600, rtol=1e-8)
    seen = run.t > 0.01 * SWEEP  # before, currents settle from rest
    return run["motor.w"][seen] * RPM, *(run[name][seen] for name in names)


def style(axes):
    """A light grid without a frame."""
    axes.grid(color="0.9")
    axes.spines[["top", "right"]].set_visible(False)


def panel(title, x, y):
    """A figure of one panel."""
    figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
    axes.set(title=title, xlabel=x, ylabel=y)
    style(axes)
    return figure, axes


def save(figure, name):
    """Write a picture beside this file."""
    figure.savefig(FOLDER / f"{name}.png", dpi=80)
    plt.close(figure)


def dc_motors():
    """Torque over speed of direct-current motors."""
    figure, axes = panel("Direct-current motors on 100 V", "speed, 1/min", "torque, N.m")
    series = SeriesDCMotor(k=0.00637, R=0.06, L=2e-3, J=0.15)
    quasi_static = QuasiStaticSeriesDCMotor(k=0.00637, R=0.06, J=0.15)
    for label, model, low, high, line in (
        ("permanent magnets", MotorOn100V(), 110, 157, "-"),
        ("separate field, full", Excited(), 110, 157, "--"),
        ("separate field, 70 %", Excited().with_({"field.v": 70.0}), 150, 224, "-"),
        ("series", MotorOn100V(motor=series), 95, 300, "-"),
        ("series, quasi-static", MotorOn100V(motor=quasi_static), 95, 300, "k:"),
    ):
        axes.plot(*sweep(model, low, high), line, label=label)
    axes.set_ylim(0, 180)
    axes.legend(frameon=False)
    save(figure, "dc_motors")


def induction_motor():
    """Torque over speed of an induction motor."""
    figure, axes = panel(
        "Induction motor: breakdown torque 140 N.m at slip 0.2", "speed, 1/min", "torque, N.m"
    )
    for a in (0.0, 1.0):
        motor = InductionMotor(w_s=157.08, tau_k=140.0, s_k=0.2, a=a, J=0.1)
        axes.plot(*sweep(MotorStand(motor=motor), -30.0, 200.0), label=f"a = {a:g}")
    axes.axhline(0, color="0.6", linewidth=0.8)
    axes.axvline(1500, color="0.6", linewidth=0.8)
    axes.annotate(
        "synchronous", (1500, -120), xytext=(-4, 0), textcoords="offset points", ha="right"
    )
    axes.legend(frameon=False)
    save(figure, "induction_motor")


def converter_drive():
    """Torque over speed of a converter drive."""
    figure, axes = panel("Converter drive: 50 N.m and 5 kW at most", "speed, 1/min", "torque, N.m")
    for wanted in (80.0, 30.0, -80.0):
        motor = ConverterDrive(tau_max=50.0, P_max=5e3, T=5e-3, J=0.1, wanted=wanted)
        axes.plot(*sweep(MotorStand(motor=motor), 0.0, 300.0), label=f"wanted {wanted:g} N.m")
    axes.axvline(100 * RPM, color="0.6", linewidth=0.8)
    axes.annotate(
        "base speed", (100 * RPM, 0), xytext=(4, 0), textcoords="offset points", va="center"
    )
    axes.legend(frameon=False, loc="center right")
    save(figure, "converter_drive")


def field_oriented_motor():
    """Torque, flux and power over speed at the limit of a field-oriented motor."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
    V_max, I_max = 310.0, 150.0
    motor = FieldOrientedMotor(
        pairs=2, R_s=0.05, R_r=0.04, L_m=0.03, L_ls=1.2e-3, L_lr=1e-3,
        psi_n=0.9, V_max=V_max, I_max=I_max, T=1e-3, J=0.4, wanted=1e6,
    )  # fmt: skip
    for wanted, label in (
        (1e6, "at its limit"),
        (150.0, "wanted 150 N.m"),
        (50.0, "wanted 50 N.m"),
    ):
        model = MotorStand(motor=motor.with_({"wanted": wanted}))
        left.plot(*sweep(model, 0.0, 700.0), label=label)
    names = ("motor.psi", "motor.i", "motor.V")
    speed, flux, current, voltage = sweep(MotorStand(motor=motor), 0.0, 700.0, names)
    right.plot(speed, flux, label="flux of the rotor, V.s")
    right.plot(speed, current / I_max, label="current over I_max")
    right.plot(speed, voltage / V_max, label="voltage over V_max")
    left.set(title="torque, N.m", xlabel="speed, 1/min", ylim=(0, 410))
    right.set(title="at its limit", xlabel="speed, 1/min", ylim=(0, 1.45))
    for axes in (left, right):
        style(axes)
        axes.legend(frameon=False, fontsize="small")
    save(figure, "field_oriented_motor")


def mapped_motor():
    """Torque limit and efficiency over speed."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2), layout="constrained")
    motor = MappedMotor(
        limits=((0, 200), (250, 200), (500, 110), (900, 50)),
        efficiency=(
            (0, 0, 50, 100, 200),
            (0, 0.30, 0.60, 0.55, 0.45),
            (200, 0.70, 0.92, 0.93, 0.90),
            (500, 0.75, 0.94, 0.95, 0.94),
            (900, 0.65, 0.90, 0.92, 0.91),
        ),
        T=5e-3, J=0.05, wanted=0.0,
    )  # fmt: skip
    for wanted in (300.0, 100.0, 40.0):
        model = MotorStand(motor=motor.with_({"wanted": wanted}))
        speed, torque, efficiency = sweep(model, 0.0, 900.0, ("motor.tau", "motor.eta"))
        label = f"wanted {wanted:g} N.m"
        left.plot(speed, torque, label=label)
        right.plot(speed, efficiency, label=label)
    left.set(title="torque, N.m", xlabel="speed, 1/min", ylim=(0, 220))
    right.set(title="efficiency", xlabel="speed, 1/min")
    for axes in (left, right):
        style(axes)
        axes.legend(frameon=False, fontsize="small")
    save(figure, "mapped_motor")


class Loop(lp.Component):
    """A body of 2 kg.m2 that is brought to 10 rad/s."""

    controller: lp.Component = PIController(k=20.0, T_i=0.4, wanted=10.0)
    drive: Torque = Torque()
    body: Inertia = Inertia(J=2.0)
    sensor: SpeedSensor = SpeedSensor()

    def connections(self):
        """Yield the loop."""
        yield lp.connect(self.drive.flange, self.body.flange_a)
        yield lp.connect(self.body.flange_b, self.sensor.flange)
        yield lp.connect(self.sensor.w, self.controller.measured)
        yield lp.connect(self.controller.y, self.drive.tau)


def controllers():
    """Speed and torque after a step of the wanted speed."""
    figure, (above, below) = plt.subplots(2, figsize=(6, 4.6), sharex=True, layout="constrained")
    limits = {"y_min": -40.0, "y_max": 40.0}
    for label, controller in (
        ("PI", PIController(k=20.0, T_i=0.4, wanted=10.0)),
        ("limited to 40 N.m, back calculation", LimitedPI(k=20.0, T_i=0.4, wanted=10.0, **limits)),
        (
            "the same, hardly any back calculation",
            LimitedPI(k=20.0, T_i=0.4, N_i=1e6, wanted=10.0, **limits),
        ),
        ("sampled every 0.05 s", SampledPI(k=20.0, T_i=0.4, T_s=0.05, wanted=10.0)),
    ):
        run = lp.simulate(lp.assemble(Loop(controller=controller)), until=2.0, grid=1000)
        above.plot(run.t, run["body.w"], label=label)
        below.plot(run.t, run["drive.tau"])
    above.set(title="A step of the wanted speed to 10 rad/s", ylabel="speed, rad/s")
    below.set(xlabel="time, s", ylabel="torque, N.m")
    for axes in (above, below):
        style(axes)
    above.legend(frameon=False, fontsize="small", loc="lower right")
    save(figure, "controllers")


def square_root_controller():
    """Wanted speed over the error of position."""
    figure, axes = panel(
        "Square-root position controller: a = 3 rad/s2, K = 8 1/s", "error, rad", "speed, rad/s"
    )
    run = lp.simulate(
        lp.assemble(
            lp.compose(
                controller=SquareRootController(
                    K=8.0, a=3.0, measured=0.0, wanted=0.3 * (lp.time - 1)
                )
            ),
        ),
        until=2.0,
        grid=400,
    )
    axes.plot(0.3 * (run.t - 1), run["controller.y"])
    for side in (-1, 1):
        axes.plot(side * 3 / 64, side * 3 / 8, "o", color="C1")
    axes.annotate("e_0 = a / K^2", (3 / 64, 3 / 8), xytext=(8, -8), textcoords="offset points")
    save(figure, "square_root_controller")


if __name__ == "__main__":
    for draw in (
        dc_motors,
        induction_motor,
        converter_drive,
        field_oriented_motor,
        mapped_motor,
        controllers,
        square_root_controller,
    ):
        draw()
