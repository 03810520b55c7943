"""Reference cases of electric drives: models built from the specification or written out."""

import numpy as np
from specification_signals import ramp, step

import lumped as lp
from lumped.components import (
    CurrentController,
    CurrentSensor,
    DCMotor,
    Filter,
    Gain,
    Ground,
    Inertia,
    Inverter,
    LimitedPI,
    PIController,
    PointToPoint,
    QuadraticTorque,
    Resistor,
    SampledPI,
    SeriesDCMotor,
    SpeedSensor,
    SpringDamper,
    Torque,
    VariableResistor,
    VoltageSensor,
    VoltageSource,
)

W_N = 1425 * 2 * np.pi / 60  # rad/s
TAU_N = 9500 / W_N  # N.m
K = TAU_N / 100  # N.m/A


COLUMNS = {
    "motor.current": "motor.i",
    "controller_I.value": "controller.x",
    "reference_speed.value": "profile.v",
    "currentController_I.value": "controller.x",
    "inverter_x_p.value": "inverter.i_dc",
    "inverter_y_d.value": "inverter.v_out",
    "vDC_f.value": "inverter.v_f",
    "i_f.value": "i_f.x",
    "vmot_f.value": "vmot_f.x",
    "ibat_f.value": "ibat_f.x",
}
PORTS = {
    ("dc_motor_pm", "shaft"): "flange",
    ("dc_motor_series", "shaft"): "flange",
}


def magnets(f, _, number):
    """Motor of a data sheet: the constant follows from the rated point."""
    k = (f["Va_N"] - f["Ra"] * f["Ia_N"]) / number(f["w_N"])
    return DCMotor(k=k, R=f["Ra"], L=f["La"], J=f["Jr"])


def series(f, _, number):
    """The same for a motor with its field in series."""
    R, L = f["Ra"] + f["Re"], f["La"] + f["Le"]
    k = (f["Va_N"] - R * f["Ia_N"]) / (number(f["w_N"]) * f["Ia_N"])
    return SeriesDCMotor(k=k, R=R, L=L, J=f["Jr"])


MAKERS = {
    "dc_motor_pm": magnets,
    "dc_motor_series": series,
    "ground": lambda *_: Ground(),
    "variable_resistor": lambda f, _, signal: VariableResistor(R=signal(f["R"])),
    "voltage_source": lambda f, _, signal: VoltageSource(v=signal(f["signal"])),
}


class Controlled(lp.Component):
    """Inertia under a speed controller."""

    controller: lp.Component = PIController(k=110.0, T_i=0.1, wanted=ramp(1.0, 2.0))
    drive: Torque = Torque()
    load: Inertia = Inertia(J=10.0)
    sensor: SpeedSensor = SpeedSensor()

    def connections(self):
        yield lp.connect(self.drive.flange, self.load.flange_a)
        yield lp.connect(self.load.flange_b, self.sensor.flange)
        yield lp.connect(self.sensor.w, self.controller.measured)
        yield lp.connect(self.controller.y, self.drive.tau)


class Sampled(Controlled):
    """Inertia under a speed controller in a computer."""

    controller: SampledPI = SampledPI(k=110.0, T_i=0.1, T_s=0.1, wanted=ramp(1.0, 2.0))


class ElasticDrive(lp.Component):
    """Elastic drive train under a limited speed controller, loaded from the start."""

    profile: PointToPoint = PointToPoint(distance=np.pi / 2, v_max=1.0, a_max=1.0, start_time=0.5)
    controller: LimitedPI = LimitedPI(k=100.0, T_i=0.1, N_i=0.1, y_min=-12.0, y_max=12.0)
    drive: Torque = Torque()
    inertia1: Inertia = Inertia(J=1.0)
    spring: SpringDamper = SpringDamper(c=1e4, d=100.0)
    inertia2: Inertia = Inertia(J=2.0)
    load: Torque = Torque(tau=10.0)
    sensor: SpeedSensor = SpeedSensor()

    def connections(self):
        yield from lp.chain(self.drive, self.inertia1, self.spring, self.inertia2, self.load)
        yield lp.connect(self.inertia1.flange_b, self.sensor.flange)
        yield lp.connect(self.profile.v, self.controller.wanted)
        yield lp.connect(self.sensor.w, self.controller.measured)
        yield lp.connect(self.controller.y, self.drive.tau)


class CurrentControlled(lp.Component):
    """Motor on an inverter and a battery, its current controlled, with a fan."""

    battery: VoltageSource = VoltageSource(v=120.0)
    wire: Resistor = Resistor(R=0.06)
    battery_i: CurrentSensor = CurrentSensor()
    inverter: Inverter = Inverter(T_d=2.5e-4, T_f=1e-3, v_f=120.0, v_out=0.0)
    motor_i: CurrentSensor = CurrentSensor()
    motor_v: VoltageSensor = VoltageSensor()
    motor: DCMotor = DCMotor(k=K, R=0.05, L=1.5e-3, J=0.15)
    ground: Ground = Ground()
    loadInertia: Inertia = Inertia(J=0.15)  # noqa: N815
    load: QuadraticTorque = QuadraticTorque(tau_nominal=-TAU_N, w_nominal=W_N)
    speed: SpeedSensor = SpeedSensor()
    i_f: Filter = Filter(T=1e-3, x=0.0)
    vmot_f: Filter = Filter(T=1e-3, x=0.0)
    ibat_f: Filter = Filter(T=1e-3, x=0.0)
    induced: Gain = Gain(k=K)
    controller: CurrentController = CurrentController(
        k=0.6, T_i=0.03, wanted=step(TAU_N / K, 0.2), u=0.0
    )

    def connections(self):
        yield lp.connect(self.battery.p, self.wire.p)
        yield lp.connect(self.wire.n, self.battery_i.p)
        yield lp.connect(self.battery_i.n, self.inverter.dc_p)
        yield lp.connect(self.inverter.p, self.motor_i.p, self.motor_v.p)
        yield lp.connect(self.motor_i.n, self.motor.p)
        returns = (self.battery.n, self.inverter.dc_n, self.inverter.n)
        yield lp.connect(*returns, self.motor.n, self.motor_v.n, self.ground.pin)
        yield lp.connect(self.motor.flange, self.loadInertia.flange_a)
        yield lp.connect(self.loadInertia.flange_b, self.load.flange, self.speed.flange)
        yield lp.connect(self.motor_i.i, self.i_f.u)
        yield lp.connect(self.motor_v.v, self.vmot_f.u)
        yield lp.connect(self.battery_i.i, self.ibat_f.u)
        yield lp.connect(self.speed.w, self.induced.u)
        yield lp.connect(self.induced.y, self.controller.feed)
        yield lp.connect(self.inverter.v_dc, self.controller.limit)
        yield lp.connect(self.i_f.y, self.controller.measured)
        yield lp.connect(self.controller.y, self.inverter.v)


WRITTEN_OUT = {
    "drive_current_controlled": CurrentControlled,
    "drive_speed_pi": Controlled,
    "drive_speed_pi_sampled": Sampled,
    "pid_drive": ElasticDrive,
}
