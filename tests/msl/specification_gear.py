"""Lossy gears, wheels, vehicles, loads and heat in the specifications of reference cases."""

import lumped as lp
from lumped.components import (
    EddyCurrentBrake,
    HeatCapacitor,
    InverseTorque,
    LinearTorque,
    LossyGear,
    QuadraticTorque,
    RackAndPinion,
    SignTorque,
    Torque,
    Vehicle,
    translation,
)

LOADS = {
    "load_linear": (LinearTorque, translation.LinearForce),
    "load_quadratic": (QuadraticTorque, translation.QuadraticForce),
    "load_sign": (SignTorque, translation.SignForce),
    "load_inverse": (InverseTorque, translation.InverseForce),
}
EFFORTS = {False: ("tau", "w"), True: ("f", "v")}


def load(facts, slides, signal):
    effort, speed = EFFORTS[slides]
    names = {"nominal": f"{effort}_nominal", "v_nominal": f"{speed}_nominal", "v0": f"{speed}0"}
    given = {
        names.get(k, k): signal(v) if isinstance(v, str) else v
        for k, v in facts.items()
        if k in {*names, "same_direction"}
    }
    if "regularisation" in facts:
        given["smooth"] = facts["regularisation"] == "exp"
    return LOADS[facts["type"]][slides](**given)


def source(slides, value):
    return translation.Force(f=value) if slides else Torque(tau=value)


def constant_load(facts, slides, _):
    return source(slides, facts["value"])


def step_load(facts, slides, _):
    jump = lp.ops.where(lp.time >= facts["t_step"], facts["step"], 0)
    return source(slides, facts["offset"] + jump)


def eddy_current_brake(facts, slides, signal):
    effort, speed = EFFORTS[slides]
    given = {f"{effort}_max": facts["nominal"], f"{speed}_nominal": facts["v_nominal"]}
    given |= {name: facts[name] for name in ("alpha", "T_ref")}
    kind = translation.EddyCurrentBrake if slides else EddyCurrentBrake
    return kind(**given, e=signal(facts["e"]))


def vehicle(facts, _, signal):
    renamed = {"Cd": "cd", "Cr": "cr"}
    known = ("m", "J", "R", "A", "Cd", "Cr", "rho", "v_reg", "g")
    given = {renamed.get(name, name): facts[name] for name in known if name in facts}
    for name in ("inclination", "v_wind"):
        value = facts.get(name, 0.0)
        given[name] = signal(value) if isinstance(value, str) else value
    return Vehicle(**given)


MAKERS = {
    **dict.fromkeys(LOADS, load),
    "load_constant": constant_load,
    "load_step": step_load,
    "eddy_current_brake": eddy_current_brake,
    "heat_capacitor": lambda facts, *_: HeatCapacitor(C=facts["C"]),
    "lossy_gear": lambda facts, *_: LossyGear(ratio=facts["ratio"], losses=facts["loss_table"]),
    "rolling_wheel": lambda facts, *_: RackAndPinion(radius=facts["radius"]),
    "vehicle": vehicle,
}
"""Functions (facts, slides, signal) -> component."""

MIXED = {"rolling_wheel", "vehicle"}
"""Types with a port R that turns and a port T that slides."""

PORTS = {
    ("rolling_wheel", "R"): "flange_a",
    ("rolling_wheel", "T"): "flange_b",
    ("vehicle", "R"): "wheel",
    ("vehicle", "T"): "coupling",
    ("eddy_current_brake", "thermal"): "heat",
    ("heat_capacitor", "port"): "port",
}
QUANTITIES = {"temperature": "T", "loss_power": "heat.Q"}
