"""Reference cases of electric drives: models built from the specification or written out."""

import numpy as np
from rows import in_rows
from specification_signals import ramp, step

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


def controlled(controller):
    """Inertia under a speed controller."""
    return in_rows(
        *("drive load sensor", "sensor.w controller.measured", "controller.y drive.tau"),
        controller=controller,
        drive=Torque(),
        load=Inertia(J=10.0),
        sensor=SpeedSensor(),
    )


def elastic_drive():
    """Elastic drive train under a limited speed controller, loaded from the start."""
    return in_rows(
        *("drive inertia1 spring inertia2 load", "inertia1 sensor", "profile.v controller.wanted"),
        *("sensor.w controller.measured", "controller.y drive.tau"),
        profile=PointToPoint(distance=np.pi / 2, v_max=1.0, a_max=1.0, start_time=0.5),
        controller=LimitedPI(k=100.0, T_i=0.1, N_i=0.1, y_min=-12.0, y_max=12.0),
        drive=Torque(),
        inertia1=Inertia(J=1.0),
        spring=SpringDamper(c=1e4, d=100.0),
        inertia2=Inertia(J=2.0),
        load=Torque(tau=10.0),
        sensor=SpeedSensor(),
    )


def current_controlled():
    """Motor on an inverter and a battery, its current controlled, with a fan."""
    return in_rows(
        *("battery.p wire.p", "wire.n battery_i.p", "battery_i.n inverter.dc_p"),
        *("inverter.p motor_i.p motor_v.p", "motor_i.n motor.p"),
        "battery.n inverter.dc_n inverter.n motor.n motor_v.n ground.pin",
        *("motor loadInertia load speed", "motor_i.i i_f.u", "motor_v.v vmot_f.u"),
        *("battery_i.i ibat_f.u", "speed.w induced.u", "induced.y controller.feed"),
        *("inverter.v_dc controller.limit", "i_f.y controller.measured"),
        "controller.y inverter.v",
        battery=VoltageSource(v=120.0),
        wire=Resistor(R=0.06),
        battery_i=CurrentSensor(),
        inverter=Inverter(T_d=2.5e-4, T_f=1e-3, v_f=120.0, v_out=0.0),
        motor_i=CurrentSensor(),
        motor_v=VoltageSensor(),
        motor=DCMotor(k=K, R=0.05, L=1.5e-3, J=0.15),
        ground=Ground(),
        loadInertia=Inertia(J=0.15),
        load=QuadraticTorque(tau_nominal=-TAU_N, w_nominal=W_N),
        speed=SpeedSensor(),
        **{name: Filter(T=1e-3, x=0.0) for name in ("i_f", "vmot_f", "ibat_f")},
        induced=Gain(k=K),
        controller=CurrentController(k=0.6, T_i=0.03, wanted=step(TAU_N / K, 0.2), u=0.0),
    )


SPEED = {"k": 110.0, "T_i": 0.1, "wanted": ramp(1.0, 2.0)}
WRITTEN_OUT = {
    "drive_current_controlled": current_controlled,
    "drive_speed_pi": lambda: controlled(PIController(**SPEED)),
    "drive_speed_pi_sampled": lambda: controlled(SampledPI(**SPEED, T_s=0.1)),
    "pid_drive": elastic_drive,
}
