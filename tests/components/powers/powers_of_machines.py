"""Energy, losses and supply of electric machines, circuits and heat."""

import numpy as np
from library_rigs import START
from power_terms import Energy, Motion, Power, turning

import lumped as lp
from lumped.components.electric import (
    circuit,
    dc_motors,
    drives,
    magnet_motor,
    motors,
    network,
    synchronous,
    thermal,
)


def voltage(at: Motion) -> complex:
    return at.v["p"] - at.v["n"]


def rotor(at: Motion) -> complex:
    return at.p["J"] * at.v["flange"] ** 2 / 2


def armature(at: Motion) -> complex:
    return rotor(at) + at.p["L"] * at.x["i"] ** 2 / 2


def excited_heat(at: Motion) -> float:
    p, v_f = at.p, at.v["field_p"] - at.v["field_n"]
    i = (voltage(at) - p["k"] * v_f / p["R_f"] * turning(at)) / p["R"]
    return p["R"] * i**2 + v_f**2 / p["R_f"]


def oriented(at: Motion) -> float:
    p, x = at.p, at.x
    per_ampere = 1.5 * p["pairs"] * p["L_m"] / (p["L_m"] + p["L_lr"])
    return per_ampere * x["psi"] * x["i_q"] * turning(at)


def kloss(at: Motion) -> float:
    w_s, s_k, a = at.p["w_s"], at.p["s_k"], at.p["a"]
    s = 1 - turning(at) / w_s
    torque = 2 * at.p["tau_k"] * (1 + a * s_k) / (s / s_k + s_k / s + 2 * a * s_k)
    return np.sign(w_s) * torque * turning(at)


def cage_currents(at: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Currents of stator and rotor, rows d and q, from the flux linkages."""
    p, x = at.p, at.x
    psi = np.array([[x["psi_sd"], x["psi_rd"]], [x["psi_sq"], x["psi_rq"]]])
    L = np.diag([p["L_ls"], p["L_lr"]]) + p["L_m"]
    return psi, np.linalg.solve(L, psi.T).T


def cage_energy(at: Motion) -> complex:
    psi, i = cage_currents(at)
    return rotor(at) + 0.75 * (psi * i).sum()


def cage_heat(at: Motion) -> float:
    _, i = cage_currents(at)
    return 1.5 * (i**2 @ [at.p["R_s"], at.p["R_r"]]).sum()


def cage_supply(at: Motion) -> float:
    _, i = cage_currents(at)
    return 1.5 * at.p["V"] * i[0, 0]


D = ("d", "f", "1d", "2d")
Q = ("q", "1q", "2q")
OWN = {"d": ("L_ls", "R_s"), "q": ("L_ls", "R_s")}
"""Leakage and resistance of the stator; those of the rotor follow the names of its windings."""


def wound_currents(at: Motion) -> dict[str, tuple[complex, complex]]:
    """Flux linkage and current of each winding of a machine with field winding."""
    found = {}
    for axis, shared in ((D, "L_md"), (Q, "L_mq")):
        leakage = [at.p[OWN.get(name, (f"L_l{name}",))[0]] for name in axis]
        psi = np.array([at.x[f"psi_{name}"] for name in axis])
        i = np.linalg.solve(np.diag(leakage) + at.p[shared], psi)
        found |= dict(zip(axis, zip(psi, i, strict=True), strict=True))
    return found


def wound_energy(at: Motion) -> complex:
    return rotor(at) + 0.75 * sum(psi * i for psi, i in wound_currents(at).values())


def wound_heat(at: Motion) -> float:
    return 1.5 * sum(
        at.p[OWN.get(name, (None, f"R_{name}"))[1]] * i**2
        for name, (_, i) in wound_currents(at).items()
    )


def starting(at: Motion) -> float:
    share = at.p["pairs"] * turning(at) / (2 * np.pi * at.p["f"])
    speeds, average, pulsating = np.transpose(START)
    torque = np.interp(share, speeds, average)
    torque += np.interp(share, speeds, pulsating) * np.cos(at.x["angle"])
    return at.p["tau_n"] * torque * turning(at)


def line_energy(at: Motion) -> complex:
    return at.p["L"] * sum(at.x[f"i_{name}"] ** 2 for name in "abc") / 2


def line_heat(at: Motion) -> float:
    return at.p["R"] * sum(at.x[f"i_{name}"] ** 2 for name in "abc")


def magnet_energy(at: Motion) -> complex:
    currents = at.p["L_d"] * at.x["i_d"] ** 2 + at.p["L_q"] * at.x["i_q"] ** 2
    return rotor(at) + 0.75 * currents


def magnet_heat(at: Motion) -> float:
    return 1.5 * at.p["R"] * (at.x["i_d"] ** 2 + at.x["i_q"] ** 2)


def battery(at: Motion) -> tuple[float, float]:
    """Voltage without current, of lines that go on beyond the rows, and current."""
    soc = at.x["soc"]
    open_circuit = 2 + 2 * soc if soc < 0.5 else 3 + 0.4 * (soc - 0.5)
    return open_circuit, (open_circuit - at.p["R_1"] * at.x["i_1"] - voltage(at)) / at.p["R"]


def battery_heat(at: Motion) -> float:
    _, i = battery(at)
    return at.p["R"] * i**2 + at.p["R_1"] * at.x["i_1"] ** 2


STORED: dict[type[lp.Component], Energy] = {
    circuit.Battery: lambda at: at.p["T_1"] * at.p["R_1"] * at.x["i_1"] ** 2 / 2,
    circuit.Capacitor: lambda at: at.p["C"] * voltage(at) ** 2 / 2,
    circuit.Inverter: lambda at: -at.p["psi"] * at.x["i_dc"],
    circuit.Inductor: lambda at: at.p["L"] * at.x["i"] ** 2 / 2,
    drives.ConverterDrive: rotor,
    drives.FieldOrientedMotor: rotor,
    drives.MappedMotor: rotor,
    dc_motors.QuasiStaticExcitedDCMotor: rotor,
    dc_motors.QuasiStaticSeriesDCMotor: rotor,
    dc_motors.DCMotor: armature,
    motors.InductionMotor: rotor,
    motors.InverterInductionMotor: rotor,
    dc_motors.QuasiStaticDCMotor: rotor,
    dc_motors.SeparatelyExcitedDCMotor: lambda at: (
        armature(at) + at.p["L_f"] * at.x["i_f"] ** 2 / 2
    ),
    dc_motors.SeriesDCMotor: armature,
    drives.SpeedDrive: rotor,
    motors.SquirrelCageMotor: cage_energy,
    magnet_motor.MagnetMotor: lambda at: magnet_energy(at) - at.p["psi_dc"] * at.x["i_dc"],
    motors.SynchronousMotor: magnet_energy,
    network.SeriesCapacitor: lambda at: 0.75 * at.p["C"] * (at.x["v_d"] ** 2 + at.x["v_q"] ** 2),
    network.ThreePhaseLine: line_energy,
    synchronous.SynchronousMotorStart: rotor,
    synchronous.WoundFieldMachine: wound_energy,
    thermal.HeatCapacitor: lambda at: at.p["C"] * at.v["port"],
}


DISSIPATED: dict[type[lp.Component], Power] = {
    circuit.Battery: battery_heat,
    circuit.Resistor: lambda at: voltage(at) ** 2 / at.p["R"],
    circuit.VariableResistor: lambda at: voltage(at) ** 2 / at.p["R"],
    dc_motors.DCMotor: lambda at: at.p["R"] * at.x["i"] ** 2,
    dc_motors.QuasiStaticDCMotor: lambda at: (
        (voltage(at) - at.p["k"] * turning(at)) ** 2 / at.p["R"]
    ),
    dc_motors.QuasiStaticExcitedDCMotor: excited_heat,
    dc_motors.QuasiStaticSeriesDCMotor: lambda at: (
        at.p["R"] * (voltage(at) / (at.p["R"] + at.p["k"] * turning(at))) ** 2
    ),
    dc_motors.SeparatelyExcitedDCMotor: lambda at: (
        at.p["R"] * at.x["i"] ** 2 + at.p["R_f"] * at.x["i_f"] ** 2
    ),
    dc_motors.SeriesDCMotor: lambda at: at.p["R"] * at.x["i"] ** 2,
    motors.SquirrelCageMotor: cage_heat,
    network.ThreePhaseLine: line_heat,
    synchronous.WoundFieldMachine: wound_heat,
    magnet_motor.MagnetMotor: magnet_heat,
    motors.SynchronousMotor: magnet_heat,
}


SUPPLIED: dict[type[lp.Component], Power] = {
    circuit.Battery: lambda at: np.prod(battery(at)),
    circuit.CurrentSource: lambda at: at.p["i"] * voltage(at),
    drives.ConverterDrive: lambda at: at.x["tau"] * turning(at),
    drives.FieldOrientedMotor: oriented,
    drives.MappedMotor: lambda at: at.x["tau"] * turning(at),
    motors.InductionMotor: kloss,
    motors.InverterInductionMotor: lambda at: at.x["tau"] * turning(at),
    drives.SpeedDrive: lambda at: at.x["tau"] * turning(at),
    motors.SquirrelCageMotor: cage_supply,
    motors.SynchronousMotor: lambda at: (
        1.5 * (at.p["v_d"] * at.x["i_d"] + at.p["v_q"] * at.x["i_q"])
    ),
    synchronous.SynchronousMotorStart: starting,
    synchronous.WoundFieldMachine: lambda at: 1.5 * at.p["v_f"] * wound_currents(at)["f"][1],
    thermal.HeatFlow: lambda at: at.p["Q"],
}
