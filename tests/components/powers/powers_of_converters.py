"""Energy and losses of converters and of the clutches of gearboxes."""

import numpy as np
from power_terms import Energy, Motion, Power

import lumped as lp
from lumped.components.converters import clutches, hydrodynamic, limited_slip, variator


def converter_heat(at: Motion) -> float:
    """The rows of the rig; turned about for a pump that turns backwards."""
    p, t = (at.v[port] - at.v["support"] for port in ("flange_a", "flange_b"))
    p, t = np.sign(p) * p, np.sign(p) * t
    if -2 <= t / p <= 2:
        nu = [-2.0, 0.0, 0.8, 1.0, 2.0]
        tau_p = np.interp(t / p, nu, [1.5, 1.5, 1.0, 0.0, -1.2]) * p**2
        tau_t = np.interp(t / p, nu, [2.0, 2.0, 1.1, 1.0, 0.9]) * tau_p
    else:
        tau_p = np.interp(p / t, [-0.5, 0.5], [-1.5 / 4, -1.2 / 4]) * t * abs(t)
        tau_t = np.interp(p / t, [-0.5, 0.5], [-2.0 * 1.5 / 4, -0.9 * 1.2 / 4]) * t * abs(t)
    return tau_p * p - tau_t * t


def coupling_heat(at: Motion) -> float:
    w, w_rel = max(abs(at.v["flange_a"]), abs(at.v["flange_b"])), abs(at.rel(at.v))
    return np.interp(w_rel / w, [0.0, 0.1, 1.0], [0.0, 2.0, 3.0]) * w**2 * w_rel


def sheared_oil(at: Motion) -> float:
    w = abs(at.rel(at.v))
    return np.interp(w, [0.0, 0.5, 3.0, 13.0], [0.0, 2.0, 2.5, 4.5]) * w


def slip_heat(at: Motion) -> float:
    p, (a, b) = at.p, (at.v[port] - at.v["support"] for port in ("flange_a", "flange_b"))
    r_a = 2 * p["R"] / (1 + p["ratio"])
    v_a, v_b = r_a * a, p["ratio"] * r_a * b
    s = abs(v_a - v_b) / max(abs(v_a), abs(v_b), p["v_low"])
    mu = np.interp(s, [0.0, 0.1, 1.0, 3.7], [0.0, 0.8, 0.6, 0.0])
    return mu * p["f_n"] * abs(v_a - v_b)


def lock_heat(at: Motion) -> float:
    cage = at.p["ratio"] * at.flow["flange_a"]
    S = at.p["S_drive"] if cage >= 0 else at.p["S_coast"]
    return (at.p["tau_0"] + S * abs(cage)) / 2 * abs(at.v["right"] - at.v["left"])


def sprags(at: Motion) -> complex:
    return at.p["c"] * at.x["x"] ** 2 / 2


def sprag_drag(at: Motion) -> float:
    slip = at.rel(at.v)
    return 0.0 if at.x["x"] > 0 or slip < 0 else at.p["d"] * slip**2


def warmth(at: Motion) -> complex:
    return at.p["C_lining"] * at.x["lining.T"] + at.p["C_plate"] * at.v["heat"]


def warmth_of_two(at: Motion) -> complex:
    """Linings of 1 J/K and plates of 2 J/K."""
    return sum(at.x[f"clutch_{i}.lining.T"] + 2.0 * at.v[f"heat_{i}"] for i in (1, 2))


STORED: dict[type[lp.Component], Energy] = {
    clutches.DualClutch: warmth_of_two,
    clutches.HeatedClutch: warmth,
    clutches.SpragClutch: sprags,
}

DISSIPATED: dict[type[lp.Component], Power] = {
    clutches.SpragClutch: sprag_drag,
    hydrodynamic.FluidCoupling: coupling_heat,
    hydrodynamic.TorqueConverter: converter_heat,
    limited_slip.LimitedSlipDifferential: lock_heat,
    limited_slip.ViscousCoupling: sheared_oil,
    variator.Variator: slip_heat,
}
