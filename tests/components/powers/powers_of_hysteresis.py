"""Energy and losses of springs and friction together, and of bristles."""

import numpy as np
from power_terms import Energy, Motion, Power
from powers_of_elements import by_rows

import lumped as lp
from lumped.components import dynamic_friction, hysteresis

ELEMENTS = {"elements[0]": 2.0, "elements[1]": 1.0}  # of the backbone in library_rigs
DISC = ((-2.0, -49.8), (-0.8, -1.8), (-0.3, -0.3), (0.3, 0.3), (0.8, 1.8), (2.0, 49.8))


def sliding_and_elastic(at: Motion) -> complex:
    own = sum(c * at.x[f"{name}.phi"] ** 2 / 2 for name, c in ELEMENTS.items())
    return own + at.rel(at.q) ** 2 / 2


def slid(at: Motion) -> float:
    return sum(
        c * at.x[f"{name}.phi"] * (at.rel(at.v) - at.rates[f"{name}.phi"])
        for name, c in ELEMENTS.items()
    )


def bent(at: Motion) -> complex:
    return at.p["c"] * at.x["phi"] ** 2 / 2


def dragged(at: Motion) -> float:
    return at.p["c"] * at.x["phi"] * (at.rel(at.v) - at.rates["phi"])


def lubricated(at: Motion) -> float:
    w = at.rel(at.v)
    return dragged(at) + w * (at.p["d"] * at.rates["phi"] + at.p["d_viscous"] * w)


def yielding(at: Motion) -> complex:
    alpha = at.p["alpha"]
    return at.p["c"] * (alpha * at.rel(at.q) ** 2 + (1 - alpha) * at.x["z"] ** 2) / 2


def yielded(at: Motion) -> float:
    w, size = at.rel(at.v), abs(at.x["z"] / at.p["phi_y"]) ** at.p["n"]
    shape = at.p["beta"] * abs(w) * np.sign(at.x["z"]) + (1 - at.p["beta"]) * w
    return (1 - at.p["alpha"]) * at.p["c"] * at.x["z"] * size * shape


STORED: dict[type[lp.Component], Energy] = {
    dynamic_friction.BoucWen: yielding,
    dynamic_friction.Dahl: bent,
    dynamic_friction.LuGre: bent,
    hysteresis.ClutchDisc: by_rows(None, DISC),
    hysteresis.Iwan: sliding_and_elastic,
    hysteresis.Jenkin: bent,
}

DISSIPATED: dict[type[lp.Component], Power] = {
    dynamic_friction.BoucWen: yielded,
    dynamic_friction.Dahl: dragged,
    dynamic_friction.LuGre: lubricated,
    hysteresis.Iwan: slid,
}
