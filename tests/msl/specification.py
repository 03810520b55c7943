"""Reference cases: a neutral specification beside a table, and the model built from them."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import specification_drives as drives
import specification_friction as friction
import specification_gear as gear
import yaml
from specification_signals import SIGNALS

import lumped as lp
from lumped.components import (
    Damper,
    ElastoBacklash,
    FilteredSpeed,
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    Spring,
    SpringDamper,
    Torque,
    translation,
)

DATA = Path(__file__).parents[1] / "data" / "msl"


class MeasuredSpring(translation.Spring):
    """Spring with its relative velocity: ``v_rel = der(s_rel)``."""

    v_rel: lp.Var = lp.var("m/s", "relative velocity")

    def equations(self):
        yield from super().equations()
        yield self.v_rel == lp.der(self.s_rel)


class TurnSource(lp.Component):
    """Prescribed angular velocity: ``w = ref``."""

    flange = lp.Flange()
    ref = lp.Input("rad/s", "wanted angular velocity")
    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "angular velocity")

    def equations(self):
        yield self.phi == self.flange.phi
        yield self.w == lp.der(self.phi)
        yield self.w == self.ref


class SlideSource(lp.Component):
    """Prescribed velocity: ``v = ref``."""

    flange = lp.LinearFlange()
    ref = lp.Input("m/s", "wanted velocity")
    s: lp.Var = lp.var("m", "position")
    v: lp.Var = lp.var("m/s", "velocity")

    def equations(self):
        yield self.s == self.flange.s
        yield self.v == lp.der(self.s)
        yield self.v == self.ref


class FilteredPlaceSource(lp.Component):
    """Position after a Bessel filter of second order with the corner frequency `f_crit`."""

    flange = lp.LinearFlange()
    ref = lp.Input("m", "wanted position")
    f_crit: lp.Param = lp.param("Hz", "corner frequency", 50.0)
    s: lp.Var = lp.var("m", "position")
    v: lp.Var = lp.var("m/s", "velocity")

    def equations(self):
        corner = 2 * lp.ops.pi * self.f_crit
        yield self.s == self.flange.s
        yield self.v == lp.der(self.s)
        push = (self.ref - self.s) * corner - 1.3617 * self.v
        yield lp.der(self.v) == push * corner / 0.6180


ROTATION = {
    "damper": Damper,
    "elastic_backlash": ElastoBacklash,
    "elastic_backlash_jump": partial(ElastoBacklash, limited=False),
    "fixed": Fixed,
    "ideal_gear": IdealGear,
    "inertia": Inertia,
    "planetary": Planetary,
    "spring": Spring,
    "spring_damper": SpringDamper,
    "speed_source": TurnSource,
    "filtered speed_source": FilteredSpeed,
    "torque_source": Torque,
    **friction.ROTATION,
}
TRANSLATION = {
    "acceleration_source": translation.Acceleration,
    "contact_gap": translation.ElastoGap,
    "damper": translation.Damper,
    "fixed": translation.Fixed,
    "force_source": translation.Force,
    "filtered angle_source": FilteredPlaceSource,
    "mass": partial(translation.MassWithLength, length=0.0),
    "rod": translation.Rod,
    "spring": MeasuredSpring,
    "spring_damper": translation.SpringDamper,
    "speed_source": SlideSource,
    "filtered speed_source": translation.FilteredSpeed,
    **friction.TRANSLATION,
}
PORTS = {"a": "flange_a", "b": "flange_b", "port": "flange", **gear.PORTS, **drives.PORTS}
"""Names of ports, in general or of one type: (type, port)."""

QUANTITIES = {
    "angle": "phi",
    "angular_velocity": "w",
    "angular_acceleration": "a",
    "position": "s",
    "velocity": "v",
    "mode": "position",
    "relative_angle": "phi_rel",
    "relative_angular_velocity": "w_rel",
    "relative_distance": "s_rel",
    "relative_velocity": "v_rel",
    **gear.QUANTITIES,
}
MAKERS = gear.MAKERS | drives.MAKERS
PARAMETERS = {
    ("fixed", False): {"at": "phi0"},
    ("fixed", True): {"at": "s0"},
    ("contact_gap", True): {"rest": "s_rel0"},
    ("elastic_backlash", False): {"rest": "phi_rel0"},
    ("elastic_backlash_jump", False): {"rest": "phi_rel0"},
    ("rod", True): {"L": "length"},
    ("spring", False): {"rest": "phi_rel0"},
    ("spring", True): {"rest": "s_rel0"},
    ("spring_damper", False): {"rest": "phi_rel0"},
    ("spring_damper", True): {"rest": "s_rel0"},
    ("mass", True): {"L": "length"},
    ("torque_source", False): {"signal": "tau"},
    ("force_source", True): {"signal": "f"},
    ("acceleration_source", True): {"ref": "a"},
    ("speed_source", False): {"x0": "phi"},
    ("speed_source", True): {"x0": "s"},
    ("filtered speed_source", False): {"x0": "phi", "ref": "w_ref"},
    ("filtered speed_source", True): {"x0": "s", "ref": "v_ref"},
    **friction.PARAMETERS,
}


def signal(text, names):
    """An expression of the time from a text such as ``sine(10, 5) * step(1, 0.2)``."""
    known = {"__builtins__": {}, "pi": np.pi, **SIGNALS}
    return eval(text.replace("^", "**"), known, names)


class Named(dict):
    """Signals with a name, read when another one uses them."""

    def __init__(self, texts):
        super().__init__()
        self.texts = texts

    def __missing__(self, name):
        self[name] = signal(self.texts[name], self)
        return self[name]


def quantity(name):
    """``inertia1.angle`` as lumped names it."""
    if name in drives.COLUMNS:
        return drives.COLUMNS[name]
    part, _, tail = name.rpartition(".")
    return f"{part}.{QUANTITIES.get(tail, tail)}"


@dataclass(frozen=True)
class Case:
    """A reference case.

    Attributes
    ----------
    facts : dict
        The specification.
    t : ndarray, shape (n,)
        Reference times, s.
    columns : dict of str to ndarray, shape (n,)
        Reference values of each quantity, by the name that lumped gives it.
    """

    facts: dict
    t: np.ndarray
    columns: dict

    @property
    def stop(self):
        return self.facts["experiment"]["stop_time"]

    @property
    def start(self):
        given = self.facts["initial_conditions"]["given"]
        return {quantity(name): float(value) for name, value in given.items() if "." in name}


def read(name):
    """The case of a name."""
    facts = yaml.safe_load((DATA / f"{name}.yaml").read_text(encoding="utf-8"))
    path = DATA / f"{name}.csv"
    header = path.read_text(encoding="utf-8").partition("\n")[0].split(",")
    values = np.loadtxt(path, delimiter=",", skiprows=1)
    columns = {quantity(h): c for h, c in zip(header[1:], values.T[1:], strict=True)}
    return Case(facts, values[:, 0], columns)


def build(case):
    """The model of a case from its components and connections."""
    facts_of = {facts["name"]: facts for facts in case.facts["components"]}
    facts_of.setdefault("ground", {"type": "ground"})
    listed = [*case.facts["connections"], *case.facts.get("thermal_connections", [])]
    joints = [[(end if "." in end else f"{end}.pin").split(".") for end in ends] for ends in listed]
    joined = {part for ends in joints for part, _ in ends}
    sliding = _sliding(facts_of, joints)
    names = Named(case.facts.get("signals_and_tables", {}))
    parts = {
        name: _part(facts, name in sliding, lambda text: signal(text, names))
        for name, facts in facts_of.items()
        if name in joined or facts["type"] in ("inertia", "mass")
    }

    def port(part, name):
        own = PORTS.get((facts_of[part]["type"], name), PORTS.get(name, name))
        return getattr(parts[part], own)

    connections = [lp.connect(*(port(*end) for end in ends)) for ends in joints]
    return lp.compose(**parts, connections=connections)


def _sliding(facts_of, joints):
    """Names of the components that belong to straight-line motion."""
    found = {
        name
        for name, facts in facts_of.items()
        if facts["type"].startswith(("mass", "force")) or facts.get("domain") == "translational"
    }
    for _ in joints:
        for ends in joints:
            mixed = [end for end in ends if facts_of[end[0]]["type"] in gear.MIXED]
            names = {part for part, _ in ends} - {part for part, _ in mixed}
            if names & found or any(port == "T" for _, port in mixed):
                found |= names
    return found


def _part(facts, slides, read_signal):
    kind, facts = facts["type"], friction.plain(facts)
    if kind in MAKERS:
        return MAKERS[kind](facts, slides, read_signal)
    kind = kind if facts.get("exact", True) else f"filtered {kind}"
    names = PARAMETERS.get((kind, slides), {})
    given = {
        names.get(key, key): read_signal(value) if isinstance(value, str) else value
        for key, value in facts.items()
        if key not in ("name", "type", "domain", "exact")
    }
    if "x0" in names:
        given.setdefault(names["x0"], 0.0)
    return (TRANSLATION if slides else ROTATION)[kind](**given)
