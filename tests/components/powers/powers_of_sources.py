"""Supply of sources and loads, and the sources of prescribed motion."""

from collections.abc import Callable

import numpy as np
from library_rigs import BLOCKS, HARMONICS, POINTS
from power_terms import Motion, Power, turning

import lumped as lp
from lumped.components import Torque, cams, rolling, sources
from lumped.components.electric import circuit, network, thermal
from lumped.components.loads import ice, speed_torques, wind


def against(law: Callable[[dict[str, float], float], float]) -> Power:
    """Power of a load whose torque is a law of parameters and speed."""
    return lambda at: at.p["tau_nominal"] * law(at.p, turning(at)) * turning(at)


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


def iced(at: Motion) -> float:
    a = at.q["flange"] - at.q["support"] - at.p["begin"]
    left = 2 * np.pi * at.p["turns"] - a
    share = np.clip(min(a, left) / at.p["ramp"], 0.0, 1.0)
    met = 0.0
    for factor, width, first in BLOCKS:
        x = (a - first - 2 * np.pi / 3 * np.arange(3)) % (2 * np.pi)
        met += factor * np.sum(np.where(x < width, np.sin(np.pi * x / width), 0.0))
    return -at.p["Q_max"] * share * met * turning(at)


def by_tensions(at: Motion) -> float:
    return (at.p["T_front"] - at.p["T_back"]) * at.p["R"] * turning(at)


def blown(at: Motion) -> float:
    """The rig's rows: c_p / x of 0.2 up to x = 1, then falling towards 1e-5 at 1e4."""
    v, R = at.p["v"], at.p["R"]
    c_q = np.interp(turning(at) * R / v, [1.0, 1e4], [0.2, 1e-5])
    return at.p["rho"] / 2 * np.pi * R**3 * v**2 * c_q * turning(at)


# A prescribed motion takes or gives whatever power the drive asks for.
PRESCRIBED = {
    *(sources.Acceleration, sources.Position, sources.RelativeSpeed, sources.Speed),
    *(sources.FilteredPosition, sources.FilteredSpeed),
    *(thermal.FixedTemperature, circuit.VoltageSource, circuit.Ground, network.InfiniteBus),
}


SUPPLIED: dict[type[lp.Component], Power] = {
    Torque: lambda at: at.p["tau"] * turning(at),
    cams.HarmonicTorque: harmonic,
    cams.PeriodicTorque: tabulated,
    cams.PulseTorque: pulse,
    ice.IceTorque: iced,
    wind.WindRotor: blown,
    rolling.RollingTorque: by_tensions,
    rolling.StripPass: by_tensions,
    speed_torques.LinearTorque: against(lambda p, w: w / p["w_nominal"]),
    speed_torques.QuadraticTorque: against(lambda p, w: w * abs(w) / p["w_nominal"] ** 2),
    speed_torques.SignTorque: against(lambda p, w: np.tanh(w / (0.02 * p["w0"]))),
    speed_torques.InverseTorque: against(lambda p, w: inverse(w, p["w_nominal"], p["w0"])),
}
