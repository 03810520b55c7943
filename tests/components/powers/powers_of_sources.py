"""Supply of sources and loads, and the sources of prescribed motion."""

from collections.abc import Callable

import numpy as np
from library_rigs import HARMONICS, POINTS
from power_terms import Motion, Power, turning

import lumped as lp
from lumped.components import Torque, cams, loads, rolling, sources, translation
from lumped.components.electric import circuit, network, thermal


def driving(effort: str) -> Power:
    return lambda at: at.p[effort] * (at.v["flange"] - at.v["support"])


def against(effort: str, law: Callable[[dict[str, float], float], float]) -> Power:
    """Power of a load whose torque or force is a law of parameters and speed."""

    def power(at: Motion) -> float:
        speed = at.v["flange"] - at.v["support"]
        return at.p[f"{effort}_nominal"] * law(at.p, speed) * speed

    return power


def inverse(speed: float, nominal: float, least: float) -> float:
    return nominal / speed if abs(speed) >= least else speed / least


def pulse(at: Motion) -> float:
    x = at.q["flange"] - at.q["support"] - at.p["centre"]
    x -= 2 * np.pi * np.round(x / (2 * np.pi))
    inside = abs(x) < at.p["width"] / 2
    return at.p["tau_max"] * np.cos(np.pi * x / at.p["width"]) * inside * turning(at)


def harmonic(at: Motion) -> float:
    phi = at.q["flange"] - at.q["support"]
    waves = [a * np.sin(k * phi + p) for k, a, p in HARMONICS]
    return (at.p["mean"] + sum(waves)) * turning(at)


def tabulated(at: Motion) -> float:
    angles, values = np.transpose(POINTS)
    return np.interp(at.q["flange"] - at.q["support"], angles, values, period=5.0) * turning(at)


# A prescribed motion takes or gives whatever power the drive asks for.
PRESCRIBED = {
    getattr(place, f"{filtered}{name}")
    for place in (sources, translation)
    for filtered, name in (
        *(("", name) for name in ("Acceleration", "Position", "RelativeSpeed", "Speed")),
        *(("Filtered", name) for name in ("Position", "Speed")),
    )
}
PRESCRIBED |= {thermal.FixedTemperature, circuit.VoltageSource, circuit.Ground}
PRESCRIBED |= {network.InfiniteBus}


SUPPLIED: dict[type[lp.Component], Power] = {
    Torque: driving("tau"),
    cams.HarmonicTorque: harmonic,
    cams.PeriodicTorque: tabulated,
    cams.PulseTorque: pulse,
    translation.Force: driving("f"),
    rolling.RollingTorque: lambda at: (at.p["T_front"] - at.p["T_back"]) * at.p["R"] * turning(at),
    loads.LinearTorque: against("tau", lambda p, w: w / p["w_nominal"]),
    loads.QuadraticTorque: against("tau", lambda p, w: w * abs(w) / p["w_nominal"] ** 2),
    loads.SignTorque: against("tau", lambda p, w: np.tanh(w / (0.02 * p["w0"]))),
    loads.InverseTorque: against("tau", lambda p, w: inverse(w, p["w_nominal"], p["w0"])),
    translation.LinearForce: against("f", lambda p, v: v / p["v_nominal"]),
    translation.QuadraticForce: against("f", lambda p, v: v * abs(v) / p["v_nominal"] ** 2),
    translation.SignForce: against("f", lambda p, v: np.tanh(v / (0.02 * p["v0"]))),
    translation.InverseForce: against("f", lambda p, v: inverse(v, p["v_nominal"], p["v0"])),
}
