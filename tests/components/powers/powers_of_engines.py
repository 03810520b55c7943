"""Energy, losses and supply of cylinders, engines, gear meshes, propellers and air gaps."""

import numpy as np
from library_rigs import FIELDS
from power_terms import Energy, Motion, Power, turning
from powers_of_elements import squeezed

import lumped as lp
from lumped.components.electric import air_gap
from lumped.components.engines import crankshaft, engine, propeller
from lumped.components.gearing import gear_mesh


def lever(p: dict[str, float], a: complex) -> complex:
    tilt = p["r"] / p["L"] * np.sin(a)
    return p["r"] * (np.sin(a) + np.cos(a) * tilt / np.sqrt(1 - tilt**2))


def gas(p: dict[str, float], a: float) -> float:
    """Torque of a cylinder, in which the table covers a part of four strokes."""
    angles, values = zip(*FIELDS[engine.Cylinder]["pressure"], strict=True)
    pressure = np.interp(a % (4 * np.pi), [*angles, 4 * np.pi], [*values, values[0]])
    return p["load"] * pressure * np.pi / 4 * p["bore"] ** 2 * lever(p, a).real


def moving_piston(at: Motion) -> complex:
    a = at.q["flange"] - at.p["phase"]
    return at.p["m"] * (lever(at.p, a) * at.v["flange"]) ** 2 / 2


def fired(at: Motion) -> float:
    return gas(at.p, at.q["flange"] - at.p["phase"]) * at.v["flange"]


def engine_energy(at: Motion) -> complex:
    """Two throws, their pistons, and the shaft between them; the second fires a turn later."""
    p = at.p
    throws = sum(
        (1.0 + p["m"] * lever(p, at.q[end]) ** 2) * at.v[end] ** 2 / 2 for end in ("front", "rear")
    )
    return throws + FIELDS[crankshaft.Engine]["c"] * (at.q["rear"] - at.q["front"]) ** 2 / 2


def both_fired(at: Motion) -> float:
    later = at.q["rear"] - 2 * np.pi
    return gas(at.p, at.q["front"]) * at.v["front"] + gas(at.p, later) * at.v["rear"]


def harmonics(rows: tuple, x: complex) -> complex:
    return sum(amplitude * np.cos(k * x + phase) for k, amplitude, phase in rows)


def deflection(at: Motion) -> tuple[complex, complex]:
    """Of the teeth, and the angle of the mesh."""
    phi_a, phi_b = (at.q[end] - at.q["support"] for end in ("flange_a", "flange_b"))
    x = at.p["z"] * phi_a
    error = harmonics(FIELDS[gear_mesh.GearMesh]["error"], x)
    return at.p["r_a"] * phi_a + at.p["r_b"] * phi_b - error, x


def mesh_energy(at: Motion) -> complex:
    s, x = deflection(at)
    share = harmonics(FIELDS[gear_mesh.GearMesh]["stiffness"], x)
    return at.p["c"] * (1 + share) * squeezed(s, at.p["b"] / 2) ** 2 / 2


def mesh_heat(at: Motion) -> float:
    h = 1e-30
    ahead = {port: at.q[port] + 1j * h * at.v[port] for port in at.q}
    s, x = deflection(Motion(at.p, ahead, at.v, at.a, at.x, at.rates))
    share = harmonics(FIELDS[gear_mesh.GearMesh]["stiffness"], x).real
    elastic = abs(at.p["c"] * (1 + share) * squeezed(s.real, at.p["b"] / 2))
    return np.clip(at.p["d"] * s.imag / h, -elastic, elastic) * s.imag / h


def to_the_water(at: Motion) -> float:
    w, a = turning(at) / at.p["w_nominal"], at.q["flange"] - at.q["support"] - at.p["phase"]
    factor = 1 + harmonics(FIELDS[propeller.Propeller]["blades"], a)
    return at.p["tau_nominal"] * w * abs(w) * factor * turning(at)


def gap_torque(at: Motion) -> float:
    p = at.p
    return p["tau_max"] * np.sin(p["p"] * at.x["theta"]) + p["d"] * (turning(at) - p["w_s"])


STORED: dict[type[lp.Component], Energy] = {
    engine.Cylinder: moving_piston,
    crankshaft.Engine: engine_energy,
    gear_mesh.GearMesh: mesh_energy,
    air_gap.AirGap: lambda at: -at.p["tau_max"] * np.cos(at.p["p"] * at.x["theta"]) / at.p["p"],
}

DISSIPATED: dict[type[lp.Component], Power] = {
    gear_mesh.GearMesh: mesh_heat,
    propeller.Propeller: to_the_water,
    air_gap.AirGap: lambda at: at.p["d"] * (turning(at) - at.p["w_s"]) ** 2,
}

SUPPLIED: dict[type[lp.Component], Power] = {
    engine.Cylinder: fired,
    crankshaft.Engine: both_fired,
    air_gap.AirGap: lambda at: -gap_torque(at) * at.p["w_s"],
}
