"""Rules that every component of the library obeys, found by walking the package.

A new component is covered as it is. It needs an entry below only if it stores, dissipates or
supplies energy, or if a random number is no sensible value for one of its fields.
"""

import importlib
import inspect
import itertools
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest

import lumped as lp
import lumped.components
from lumped.components import (
    Inertia,
    Torque,
    belts,
    cams,
    contact,
    crank,
    dc_motors,
    drives,
    electrical,
    friction,
    gravity,
    impact,
    linkages,
    loads,
    lossy_gear,
    motors,
    noncircular,
    planetary_stage,
    rolling,
    sequence,
    signals,
    sources,
    synchroniser,
    thermal,
    translation,
    tyre,
    vehicle,
    winding,
)
from lumped.components import compliance as rotation
from lumped.language.quantity import Quantity
from lumped.language.switch import Hold, When

STATES = 25
TOLERANCE = 1e-12
ROUNDING = 1e-14  # W, where contacts are open and all powers are zero

UNITS = {
    *("1", "s", "Hz", "W"),
    *("rad", "rad/s", "rad/s2", "N.m", "kg.m2", "N.m/rad", "N.m.s/rad"),
    *("m", "m/s", "m/s2", "N", "kg", "N/m", "N.s/m"),
    *("V", "A", "Ohm", "H", "F", "N.m/A", "N.m/A2", "V.s"),
    *("1/s", "1/s2", "rad/(s.N.m)"),
    *("K", "J/K", "W/K", "1/K"),
    *("m2", "kg/m3", "Pa"),
}

ROWS = ((0.0, 2.0), (1.0, 1.5), (3.0, 1.8))
HARMONICS = ((0.5, 3.0, 0.4), (2.0, -1.0, 2.0))
POINTS = ((-0.5, 3.0), (0.4, -1.0), (2.9, 2.0))
TWISTS = ((-1.0, -3.0), (-0.4, -0.8), (0.5, 0.7), (1.2, 4.0))
MAP = ((0.0, 0.0, 1.0), (0.0, 0.6, 0.8), (2.0, 0.7, 0.9))
FIELDS = {
    drives.MappedMotor: {"limits": ((0.0, 2.0), (1.0, 1.0)), "efficiency": MAP},
    rotation.NonlinearSpring: {"characteristic": TWISTS},
    translation.NonlinearSpring: {"characteristic": TWISTS},
    cams.HarmonicTorque: {"harmonics": HARMONICS},
    cams.PeriodicTorque: {"points": POINTS, "shape": "lines", "period": 5.0},
    signals.Table: {"times": (0.0, 1.0), "values": (2.0, 3.0)},
    friction.BearingFriction: {"characteristic": ROWS},
    translation.SupportFriction: {"characteristic": ROWS},
    translation.MassWithStopAndFriction: {"characteristic": ROWS},
    sequence.PositionSequencer: {"targets": (0.5, -1.0)},
    sequence.SpeedProfile: {"sections": ((-1.0, 0.5), (0.0, 2.0), (1.0, 0.8))},
    noncircular.NonCircularGear: {"transmission": lambda x: -(x + 0.4 * lp.ops.sin(2 * x))},
    lossy_gear.LossyGear: {"losses": ((0.0, 0.9, 0.8, 0.5, 0.7), (3.0, 0.7, 0.8, 0.6, 0.7))},
}
"""Structural fields without a usable default."""

SENSIBLE: dict[type[lp.Component], dict[str, float]] = {
    belts.Belt: {"distance": 6.0},
    crank.CrankSlider: {"L": 6.0},
    crank.StrokeLoad: {"s_0": -10.0, "s_1": 10.0},
    drives.FieldOrientedMotor: {"I_max": 10.0, "psi_n": 2.0, "L_m": 1.0},
    electrical.VariableResistor: {"R": 1.5},
    impact.Backlash: {"b": 10.0},
    linkages.GuidedRod: {"length": 10.0},
    synchroniser.Synchroniser: {"u": 0.7},
    tyre.Tyre: {"T_d": 0.02, "v_low": 0.2},
    translation.Backlash: {"b": 10.0},
    translation.MassWithStopAndFriction: {"s_min": -10.0, "s_max": 10.0},
    translation.MassWithStops: {"s_min": -10.0, "s_max": 10.0},
    winding.Coil: {"r": 10.0, "R_max": 30.0},
    winding.StripPath: {"r_t": 2.0, "d": 10.0},
}
"""Parameters for which a random number is none."""

POSITIVE = {
    electrical.VariableResistor: ["R"],
    vehicle.Vehicle: ["cr"],
    friction.JournalFriction: ["f_n"],
    rolling.RollingTorque: ["F", "a"],
    tyre.Tyre: ["f_n"],
}
"""Inputs that make no sense below zero."""

BASES = {thermal.Heated}
"""What only stands before another component."""


def discovered() -> Iterator[type[lp.Component]]:
    package = lumped.components
    for entry in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        module = importlib.import_module(entry.name)
        for _, cls in inspect.getmembers(module, inspect.isclass):
            own = cls.__module__ == entry.name and not cls.__name__.startswith("_")
            if issubclass(cls, lp.Component) and own and cls not in BASES:
                yield cls


LIBRARY = list(discovered())


def every(classes: list[type[lp.Component]]) -> pytest.MarkDecorator:
    names = [f"{cls.__module__.rsplit('.', 1)[1]}.{cls.__name__}" for cls in classes]
    return pytest.mark.parametrize("cls", classes, ids=names)


def declared(cls: type[lp.Component], kind: type) -> dict[str, object]:
    return {name: item for name, item in inspect.getmembers(cls) if isinstance(item, kind)}


def drawn(quantity: lp.Param, rng: np.random.Generator) -> float:
    """A random value in the range of a parameter, away from its ends."""
    low = quantity.min if quantity.above is None else quantity.above
    high = quantity.max if quantity.below is None else quantity.below
    if low is not None and high is not None:
        return low + (high - low) * rng.uniform(0.1, 0.9)
    size = rng.uniform(0.5, 2.0)
    if low is not None:
        return low + size
    if high is not None:
        return high - size
    return size * rng.choice([-1.0, 1.0])


def values(cls: type[lp.Component], rng: np.random.Generator) -> dict[str, float]:
    """Random values of the parameters and inputs."""
    found = {name: drawn(item, rng) for name, item in declared(cls, lp.Param).items()}
    for name, item in declared(cls, lp.Param).items():
        if isinstance(item.exceeds, lp.Param):
            found[name] = found[item.exceeds.name] + rng.uniform(0.5, 2.0)
    found |= {name: rng.uniform(-2.0, 2.0) for name in declared(cls, lp.Input)}
    found |= {name: abs(found[name]) for name in POSITIVE.get(cls, ())}
    return found | SENSIBLE.get(cls, {})


@dataclass(frozen=True)
class Kind:
    """What is joined to a port of one kind: a body, a load, and the names of their quantities."""

    body: type[lp.Component]
    mass: str
    speed: str
    load: type[lp.Component]
    effort: str
    ports: tuple[str, str] = ("flange_a", "flange")
    """Of the body and the load."""


class Node(lp.Component):
    """Capacitance of a wire to the ground: ``C der(v) = i``."""

    pin = lp.Pin()
    C: lp.Param = lp.param("F", "capacitance", above=0)
    v: lp.Var = lp.var("V", "potential")

    def equations(self) -> Iterator[lp.Equation]:
        yield self.pin.v == self.v
        yield self.C * lp.der(self.v) == self.pin.i


class Feed(lp.Component):
    """Current into a wire: ``i_pin = -i``."""

    pin = lp.Pin()
    i = lp.Input("A", "current")

    def equations(self) -> Iterator[lp.Equation]:
        yield self.pin.i == -self.i


KINDS = {
    lp.Flange: Kind(Inertia, "J", "w", Torque, "tau"),
    lp.LinearFlange: Kind(translation.Mass, "m", "v", translation.Force, "f"),
    lp.Pin: Kind(Node, "C", "v", Feed, "i", ("pin", "pin")),
    lp.HeatPort: Kind(thermal.HeatCapacitor, "C", "T", thermal.HeatFlow, "Q", ("port", "port")),
}


def kinds(cls: type[lp.Component]) -> dict[str, Kind]:
    return {name: KINDS[type(port)] for name, port in declared(cls, lp.Port).items()}


def rig(cls: type[lp.Component], rng: np.random.Generator) -> lp.Component:
    """The component with a loaded body at each of its ports."""
    part = cls(**FIELDS.get(cls, {}), **values(cls, rng))
    joined = kinds(cls)
    if not joined:
        return part

    def connections(model: lp.Component) -> Iterator[lp.Connection]:
        for name, kind in joined.items():
            ends = zip((model.bodies[name], model.loads[name]), kind.ports, strict=True)
            yield lp.connect(getattr(model.part, name), *(getattr(*end) for end in ends))

    return lp.compose(
        part=part,
        bodies={name: kind.body(**{kind.mass: 1.0}) for name, kind in joined.items()},
        loads={name: kind.load(**{kind.effort: 0.0}) for name, kind in joined.items()},
        connections=connections,
    )


@pytest.mark.parametrize(
    "module",
    ["inertia", "compliance", "gears", "sources", "sensors", "electrical", "motors", "control"],
)
def test_the_walk_finds_the_modules(module: str) -> None:
    received = {cls.__module__ for cls in LIBRARY}
    expected = f"lumped.components.{module}"
    assert expected in received


@every(LIBRARY)
def test_a_user_finds_it_where_the_library_says(cls: type[lp.Component]) -> None:
    slides = cls.__module__.startswith(translation.__name__)
    place = translation if slides else lumped.components
    received = getattr(place, cls.__name__)
    expected = cls
    assert received is expected
    assert cls.__name__ in place.__all__


@pytest.mark.parametrize("place", [lumped.components, translation], ids=["library", "translation"])
def test_public_names_are_sorted_and_unique(place: object) -> None:
    received = place.__all__
    expected = sorted(set(received))
    assert received == expected


def brought(item: object) -> int:
    """Number of equations of one item: a hold determines its reaction, and its mode if named."""
    if isinstance(item, Hold):
        return 1 if item.mode is None else 2
    if isinstance(item, When):
        return 0
    return len(item) if isinstance(item, tuple) else 1


@every([cls for cls in LIBRARY if not declared(cls, lp.Component)])
def test_it_brings_one_equation_per_variable_output_and_port(cls: type[lp.Component]) -> None:
    received = sum(map(brought, cls(**FIELDS.get(cls, {})).equations()))
    expected = sum(len(declared(cls, kind)) for kind in (lp.Var, lp.Output, lp.Port))
    assert received == expected


@every(LIBRARY)
def test_it_assembles_with_a_body_at_each_port(cls: type[lp.Component]) -> None:
    system = lp.assemble(rig(cls, np.random.default_rng(1)))
    received = np.isfinite(lp.start_point(system).x).all()
    expected = True
    assert received == expected


@every(LIBRARY)
def test_each_quantity_has_a_text_and_a_unit_of_the_si(cls: type[lp.Component]) -> None:
    quantities = list(declared(cls, Quantity).values())
    for port in declared(cls, lp.Port).values():
        quantities += [port.potential, port.flow]
    received = {quantity.unit for quantity in quantities}
    expected = UNITS
    assert received <= expected
    assert all(quantity.text.strip() for quantity in quantities)


@every(LIBRARY)
def test_its_equations_join_quantities_of_the_same_kind(cls: type[lp.Component]) -> None:
    checked = lp.check_units(cls(**FIELDS.get(cls, {}), **values(cls, np.random.default_rng(1))))
    assert checked or declared(cls, lp.Component)


@every(LIBRARY)
def test_its_docstring_states_its_law(cls: type[lp.Component]) -> None:
    received = vars(cls).get("__doc__") or ""
    expected = "="
    assert expected in received


# -- power balance -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Motion:
    """What a part is given, and its motion, as plain numbers.

    Parameters; positions, velocities and accelerations by port, where the potential of a pin counts
    as a velocity; states inside the part and their derivatives; powers of what sticks or slides.
    """

    p: dict[str, float]
    q: dict[str, complex]
    v: dict[str, complex]
    a: dict[str, float]
    x: dict[str, complex]
    rates: dict[str, float]
    held: tuple[float, ...] = ()

    def rel(self, by: dict[str, complex]) -> complex:
        return by["flange_b"] - by["flange_a"]


Energy = Callable[[Motion], complex]
Power = Callable[[Motion], float]


def elastic(free_length: str) -> Energy:
    return lambda at: at.p["c"] * (at.rel(at.q) - at.p[free_length]) ** 2 / 2


def kinetic(mass: str) -> Energy:
    return lambda at: at.p[mass] * at.v["flange_a"] ** 2 / 2


def viscous(at: Motion) -> float:
    return at.p["d"] * at.rel(at.v) ** 2


def rubbing(at: Motion) -> float:
    return sum(at.held)


def driving(effort: str) -> Power:
    return lambda at: at.p[effort] * (at.v["flange"] - at.v["support"])


def by_rows(free_length: str) -> Energy:
    """Energy of a spring by rows: the trapezoids under the lines from no stretch to this one."""

    def energy(at: Motion) -> complex:
        x = at.rel(at.q) - at.p[free_length]
        places, forces = np.transpose(TWISTS)
        slopes = np.diff(forces) / np.diff(places)

        def force(y: complex) -> complex:
            i = np.clip(np.searchsorted(places, y.real) - 1, 0, len(slopes) - 1)
            return forces[i] + slopes[i] * (y - places[i])

        way = 1 if x.real > 0 else -1
        inner = [p for p in places if 0 < way * p < way * x.real]
        points = [0.0, *sorted(inner, key=abs), x]
        pairs = itertools.pairwise(points)
        return sum((force(a + 0j) + force(b + 0j)) / 2 * (b - a) for a, b in pairs)

    return energy


def squeezed(x: complex, half: float) -> complex:
    """How far a twist is beyond half the play."""
    return x - np.sign(x.real) * half if abs(x.real) > half else 0.0


def play_energy(at: Motion) -> complex:
    return at.p["c"] * squeezed(at.rel(at.q) - at.p["phi_rel0"], at.p["b"] / 2) ** 2 / 2


def play_heat(at: Motion) -> float:
    """Damping is at most as strong as the spring, in both directions."""
    elastic = at.p["c"] * squeezed(at.rel(at.q) - at.p["phi_rel0"], at.p["b"] / 2)
    return np.clip(at.p["d"] * at.rel(at.v), -abs(elastic), abs(elastic)) * at.rel(at.v)


def gap_energy(at: Motion) -> complex:
    short = at.p["s_rel0"] - at.rel(at.q)
    return at.p["c"] * short**2 / 2 if short.real > 0 else 0.0


def gap_heat(at: Motion) -> float:
    elastic = at.p["c"] * max(0.0, at.p["s_rel0"] - at.rel(at.q))
    return np.clip(at.p["d"] * at.rel(at.v), -elastic, elastic) * at.rel(at.v)


def carried(mass: str) -> Energy:
    """Energy of a body that moves with the flange while the command says so."""
    return lambda at: at.p[mass] * at.v["flange"] ** 2 / 2 if at.p["u"] > 0.5 else 0.0


def strip_energy(at: Motion) -> complex:
    return at.p["c"] * at.rel(at.q) ** 2 / 2 if at.rel(at.q).real > 0 else 0.0


def strip_heat(at: Motion) -> float:
    tension = at.p["c"] * max(0.0, at.rel(at.q))
    return np.clip(at.p["d"] * at.rel(at.v), -tension, tension) * at.rel(at.v)


def strands(at: Motion) -> Iterator[tuple[complex, complex]]:
    """Elastic tension of each strand of a belt if it pulls, and its rate of stretch."""
    p = at.p
    c = p["EA"] / np.sqrt(p["distance"] ** 2 - (p["r_a"] - p["r_b"]) ** 2)
    by_load, rate = (
        p["r_a"] * (y["flange_a"] - y["support"]) - p["r_b"] * (y["flange_b"] - y["support"])
        for y in (at.q, at.v)
    )
    for side in (1, -1):
        pull = p["F_0"] + side * c * by_load
        yield (pull if pull.real > 0 else 0.0), side * rate


def belt_energy(at: Motion) -> complex:
    p = at.p
    c = p["EA"] / np.sqrt(p["distance"] ** 2 - (p["r_a"] - p["r_b"]) ** 2)
    return sum(pull**2 for pull, _ in strands(at)) / (2 * c)


def belt_heat(at: Motion) -> float:
    return sum(np.clip(at.p["d"] * rate, -pull, pull) * rate for pull, rate in strands(at))


def coil_radius(at: Motion) -> complex:
    turns = (at.q["flange"] - at.q["tangent"]) / (2 * np.pi)
    return at.p["r"] + at.p["h"] / at.p["fill"] * turns


def coil_energy(at: Motion) -> complex:
    J = np.pi * at.p["rho"] * at.p["b"] * at.p["fill"] / 2 * (coil_radius(at) ** 4 - at.p["r"] ** 4)
    return J * at.v["flange"] ** 2 / 2


def strip_brought_in(at: Motion) -> float:
    """Kinetic energy of the strip that enters, with the speed of the coil's surface."""
    p, R = at.p, coil_radius(at)
    mass_flow = p["rho"] * p["b"] * p["h"] * R * (at.v["flange"] - at.v["tangent"])
    return mass_flow * (R * at.v["flange"]) ** 2 / 2


def voltage(at: Motion) -> complex:
    return at.v["p"] - at.v["n"]


def turning(at: Motion) -> complex:
    return at.v["flange"] - at.v["support"]


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


def against(effort: str, law: Callable[[dict[str, float], float], float]) -> Power:
    """Power of a load whose torque or force is a law of parameters and speed."""

    def power(at: Motion) -> float:
        speed = at.v["flange"] - at.v["support"]
        return at.p[f"{effort}_nominal"] * law(at.p, speed) * speed

    return power


def bounded(speed: float, limit: float) -> float:
    return np.clip(speed / limit, -1, 1)


def inverse(speed: float, nominal: float, least: float) -> float:
    return nominal / speed if abs(speed) >= least else speed / least


def in_plane(angle: complex) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def frame(at: dict[str, complex]) -> np.ndarray:
    return np.array([at["frame_x"], at["frame_y"]])


def crank_slider(at: Motion) -> complex:
    """Energy of the slider and of the rod by the motion of its own centre, and their weights."""
    p, along = at.p, in_plane(at.p["axis"])
    angle, w = at.q["flange"] + p["phase"], at.v["flange"]
    pin, v_pin = p["r"] * in_plane(angle), p["r"] * w * in_plane(angle + np.pi / 2)
    s, v = (y["slider"] - frame(y) @ along for y in (at.q, at.v))
    end = s * along + p["e"] * in_plane(p["axis"] + np.pi / 2)
    rod, v_rod = end - pin, v * along - v_pin
    w_rod = (rod[0] * v_rod[1] - rod[1] * v_rod[0]) / p["L"] ** 2
    mid, v_mid = (
        frame(y) + z for y, z in ((at.q, pin + p["k"] * rod), (at.v, v_pin + p["k"] * v_rod))
    )
    end, v_end = frame(at.q) + end, frame(at.v) + v * along
    moving = p["m_rod"] * v_mid @ v_mid + p["J_rod"] * w_rod**2 + p["m"] * v_end @ v_end
    return moving / 2 - p["g"] * in_plane(p["down"]) @ (p["m_rod"] * mid + p["m"] * end)


def rotating_mass(at: Motion) -> complex:
    p, angle = at.p, at.q["flange"] + at.p["phase"]
    place = frame(at.q) + p["r"] * in_plane(angle)
    v = frame(at.v) + p["r"] * at.v["flange"] * in_plane(angle + np.pi / 2)
    moving = p["m"] * v @ v + p["J"] * at.v["flange"] ** 2
    return moving / 2 - p["g"] * in_plane(p["down"]) @ (p["m"] * place)


def working(at: Motion) -> float:
    """Shape of a beta function, the greatest value 1."""
    p, v = at.p, at.v["flange"] - at.v["support"]
    z = (at.q["flange"] - at.q["support"] + 10) / 20
    top = p["p"] / (p["p"] + p["q"])
    shape = (z / top) ** p["p"] * ((1 - z) / (1 - top)) ** p["q"]
    force = p["forward"] if v > 0 else p["backward"]
    return v * bounded(v, p["v_0"]) * force * shape


def downhill_and_wind(at: Motion) -> float:
    p, v = at.p, at.v["coupling"]
    drag = p["rho"] / 2 * p["cd"] * p["A"] * (v - p["v_wind"]) * abs(v - p["v_wind"])
    return -v * (drag + p["m"] * p["g"] * np.sin(np.arctan(p["inclination"])))


def rolling_resistance(at: Motion) -> float:
    p, v = at.p, at.v["coupling"]
    level = np.cos(np.arctan(p["inclination"]))
    return p["cr"] * p["m"] * p["g"] * level * bounded(v, p["v_reg"]) * v


def plane_length(at: Motion) -> complex:
    return np.sqrt((at.q["b_x"] - at.q["a_x"]) ** 2 + (at.q["b_y"] - at.q["a_y"]) ** 2)


def plane_elastic(at: Motion) -> complex:
    return at.p["c"] * (plane_length(at) - at.p["length0"]) ** 2 / 2


def plane_viscous(at: Motion) -> float:
    stretching = sum(
        (at.q[f"b_{i}"] - at.q[f"a_{i}"]) * (at.v[f"b_{i}"] - at.v[f"a_{i}"]) for i in "xy"
    )
    return at.p["d"] * (stretching / plane_length(at)) ** 2


def bar_energy(at: Motion) -> complex:
    """By the velocities of both ends, which say how fast it turns and where its centre goes."""
    p, k = at.p, at.p["k"]
    v = [(1 - k) * at.v[f"a_{i}"] + k * at.v[f"b_{i}"] for i in "xy"]
    y = (1 - k) * at.q["a_y"] + k * at.q["b_y"]
    turning = sum((at.v[f"b_{i}"] - at.v[f"a_{i}"]) ** 2 for i in "xy") / p["length"] ** 2
    return (p["m"] * (v[0] ** 2 + v[1] ** 2) + p["J"] * turning) / 2 + p["m"] * p["g"] * y


def tread_energy(at: Motion) -> complex:
    p = at.p
    return p["f_n"] * p["mu"] * p["B"] * p["C"] * p["sigma"] * at.x["z"] ** 2 / 2


def tread_heat(at: Motion) -> float:
    """What the tread slips, and its damper takes."""
    p, z = at.p, at.x["z"]
    v, u = at.v["hub"], p["R"] * at.v["wheel"]
    V = (abs(v) + abs(u)) / 2
    x = p["B"] * abs(u - v) / V
    magic = np.sin(p["C"] * np.arctan(x - p["E"] * (x - np.arctan(x))))
    slips = p["C"] * abs(u - v) * p["B"] * z / magic
    stretched = p["T_d"] * np.exp(-((V / p["v_low"]) ** 2)) * (u - v - slips) / p["sigma"]
    return p["f_n"] * p["mu"] * p["B"] * p["C"] * (z * slips + stretched * (u - v))


def stage_energy(at: Motion) -> complex:
    p, x = at.p, at.x
    return (
        p["n"]
        * (p["c_s"] * x["s_s"] ** 2 + p["c_r"] * x["s_r"] ** 2 + p["J_p"] * x["w_p"] ** 2)
        / 2
    )


def stage_heat(at: Motion) -> float:
    p, v = at.p, at.v
    r_s, r_r = p["r_s"], p["ratio"] * p["r_s"]
    rolled = (r_r - r_s) / 2 * (at.x["w_p"] - v["carrier"])
    at_sun = r_s * (v["sun"] - v["carrier"]) + rolled
    at_ring = r_r * (v["ring"] - v["carrier"]) - rolled
    return p["n"] * (p["d_s"] * at_sun**2 + p["d_r"] * at_ring**2)


def swinging(at: Motion) -> complex:
    p = at.p
    height = p["R"] * np.sin(at.q["flange"] + p["phi0"])
    return (p["J"] + p["m"] * p["R"] ** 2) * at.v["flange"] ** 2 / 2 + p["m"] * p["g"] * height


def lowered(at: Motion) -> float:
    return -at.p["f"] * at.p["R"] * np.cos(at.q["flange"] + at.p["phi0"]) * at.v["flange"]


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


STORED: dict[type[lp.Component], Energy] = {
    Inertia: kinetic("J"),
    belts.Belt: belt_energy,
    planetary_stage.ElasticPlanetary: stage_energy,
    linkages.Bar: bar_energy,
    linkages.PlaneSpring: plane_elastic,
    tyre.Tyre: tread_energy,
    contact.ElastoBacklash: play_energy,
    gravity.SwingingMass: swinging,
    crank.CrankSlider: crank_slider,
    crank.RotatingMass: rotating_mass,
    impact.PickUp: carried("J"),
    rotation.NonlinearSpring: by_rows("phi_rel0"),
    translation.NonlinearSpring: by_rows("s_rel0"),
    rotation.Spring: elastic("phi_rel0"),
    rotation.SpringDamper: elastic("phi_rel0"),
    translation.ElastoGap: gap_energy,
    translation.Mass: kinetic("m"),
    translation.MassWithLength: kinetic("m"),
    translation.MassWithStops: kinetic("m"),
    translation.PickUp: carried("m"),
    translation.MassWithStopAndFriction: kinetic("m"),
    translation.Spring: elastic("s_rel0"),
    translation.SpringDamper: elastic("s_rel0"),
    electrical.Capacitor: lambda at: at.p["C"] * voltage(at) ** 2 / 2,
    electrical.Inverter: lambda at: -at.p["psi"] * at.x["i_dc"],
    electrical.Inductor: lambda at: at.p["L"] * at.x["i"] ** 2 / 2,
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
    motors.SynchronousMotor: lambda at: (
        rotor(at) + 0.75 * (at.p["L_d"] * at.x["i_d"] ** 2 + at.p["L_q"] * at.x["i_q"] ** 2)
    ),
    thermal.HeatCapacitor: lambda at: at.p["C"] * at.v["port"],
    vehicle.Vehicle: lambda at: (
        (at.p["m"] + at.p["J"] / at.p["R"] ** 2) * at.v["coupling"] ** 2 / 2
    ),
    winding.Coil: coil_energy,
    winding.Strip: strip_energy,
}
DISSIPATED: dict[type[lp.Component], Power] = {
    belts.Belt: belt_heat,
    planetary_stage.ElasticPlanetary: stage_heat,
    linkages.PlaneSpring: plane_viscous,
    tyre.Tyre: tread_heat,
    contact.ElastoBacklash: play_heat,
    crank.StrokeLoad: working,
    rotation.Damper: viscous,
    rotation.SpringDamper: viscous,
    translation.Damper: viscous,
    translation.ElastoGap: gap_heat,
    translation.SpringDamper: viscous,
    electrical.Resistor: lambda at: voltage(at) ** 2 / at.p["R"],
    electrical.VariableResistor: lambda at: voltage(at) ** 2 / at.p["R"],
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
    motors.SynchronousMotor: lambda at: 1.5 * at.p["R"] * (at.x["i_d"] ** 2 + at.x["i_q"] ** 2),
    vehicle.Vehicle: rolling_resistance,
    winding.Strip: strip_heat,
}
SUPPLIED: dict[type[lp.Component], Power] = {
    Torque: driving("tau"),
    gravity.Weight: lowered,
    cams.HarmonicTorque: harmonic,
    cams.PeriodicTorque: tabulated,
    cams.PulseTorque: pulse,
    translation.Force: driving("f"),
    electrical.CurrentSource: lambda at: at.p["i"] * voltage(at),
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
    rolling.RollingTorque: lambda at: (at.p["T_front"] - at.p["T_back"]) * at.p["R"] * turning(at),
    loads.LinearTorque: against("tau", lambda p, w: w / p["w_nominal"]),
    loads.QuadraticTorque: against("tau", lambda p, w: w * abs(w) / p["w_nominal"] ** 2),
    loads.SignTorque: against("tau", lambda p, w: np.tanh(w / (0.02 * p["w0"]))),
    loads.InverseTorque: against("tau", lambda p, w: inverse(w, p["w_nominal"], p["w0"])),
    translation.LinearForce: against("f", lambda p, v: v / p["v_nominal"]),
    translation.QuadraticForce: against("f", lambda p, v: v * abs(v) / p["v_nominal"] ** 2),
    translation.SignForce: against("f", lambda p, v: np.tanh(v / (0.02 * p["v0"]))),
    translation.InverseForce: against("f", lambda p, v: inverse(v, p["v_nominal"], p["v0"])),
    thermal.HeatFlow: lambda at: at.p["Q"],
    vehicle.Vehicle: downhill_and_wind,
    winding.Coil: strip_brought_in,
}
# A prescribed motion takes or gives whatever power the drive asks for.
PRESCRIBED = {
    getattr(place, f"{filtered}{name}")
    for place in (sources, translation)
    for filtered, name in (
        *(("", name) for name in ("Acceleration", "Position", "RelativeSpeed", "Speed")),
        *(("Filtered", name) for name in ("Position", "Speed")),
    )
}
PRESCRIBED |= {thermal.FixedTemperature, electrical.VoltageSource, electrical.Ground}


def rate(energy: Energy, at: Motion) -> float:
    """Time derivative of an energy along the motion, by a complex step: exact to rounding."""
    h = 1e-30
    q = {port: at.q[port] + 1j * h * at.v[port] for port in at.q}
    v = {port: at.v[port] + 1j * h * at.a[port] for port in at.v}
    x = {name: at.x[name] + 1j * h * at.rates[name] for name in at.x}
    return energy(Motion(at.p, q, v, at.a, x, at.rates)).imag / h


def nothing(at: Motion) -> float:
    return 0.0


def holds(cls: type[lp.Component]) -> list[tuple[str, str]]:
    """Names of the reactions of what sticks and slides, and of their speeds."""
    items = cls(**FIELDS.get(cls, {})).equations()
    found = [item for item in items if isinstance(item, Hold)]
    return [(f"part.{h.reaction.name}", f"part.{h.speed.name}") for h in found]


def motions(cls: type[lp.Component]) -> Iterator[tuple[Motion, np.ndarray]]:
    """Random parameters, bodies, loads and states of the rig, and the power into each port.

    What sticks and slides stands still in every third state.
    """
    rng = np.random.default_rng(20)
    ports, joined = declared(cls, lp.Port), kinds(cls)
    positions = [f"part.{name}.{port.potential_name}" for name, port in ports.items()]
    speeds = [f'bodies["{name}"].{kind.speed}' for name, kind in joined.items()]
    flows = [f"part.{name}.{port.flow_name}" for name, port in ports.items()]
    system = lp.assemble(rig(cls, rng), keep=positions)
    held = [] if declared(cls, lp.Component) else holds(cls)
    sizes = np.cumsum([len(ports)] * 3 + [len(held)])
    read = system.function(
        [*positions, *speeds, *flows, *(r for r, _ in held), *(s for _, s in held)]
    )
    for number in range(STATES):
        own = values(cls, rng)
        mass, load = rng.uniform(0.5, 2.0, len(ports)), rng.uniform(-2.0, 2.0, len(ports))
        changed = {f"part.{name}": value for name, value in own.items()}
        for i, (name, kind) in enumerate(joined.items()):
            changed[f'bodies["{name}"].{kind.mass}'] = mass[i]
            changed[f'loads["{name}"].{kind.effort}'] = load[i]
        start = {name: rng.uniform(-2.0, 2.0) for name in system.state_names}
        start |= {name: abs(value) for name, value in start.items() if name.endswith(".gap")}
        if number % 3 == 0:
            start |= {speed: 0.0 for _, speed in held if speed in start}
        point = lp.start_point(system, parameters=changed, start=start)
        found = np.asarray(read(point.x, point.theta, point.time, point.modes)).ravel()
        q, v, flow, reaction, sliding = np.split(found, sizes)
        a = (load - flow) / mass
        rates = np.asarray(system.rhs(point.x, point.theta, point.time, point.modes)).ravel()
        inside = {
            name.removeprefix("part."): i
            for i, name in enumerate(system.state_names)
            if name.startswith("part.")
        }
        x, der_x = ({name: values[i] for name, i in inside.items()} for values in (point.x, rates))
        qva = (dict(zip(ports, y, strict=True)) for y in (q, v, a))
        warm = [isinstance(port, lp.HeatPort) for port in ports.values()]
        held_power = tuple(reaction * sliding)
        yield Motion(own, *qva, x, der_x, held_power), np.where(warm, flow, flow * v)


@every([cls for cls in LIBRARY if declared(cls, lp.Port) and cls not in PRESCRIBED])
def test_power_into_its_ports_is_stored_or_dissipated(cls: type[lp.Component]) -> None:
    worst = 0.0
    for at, power in motions(cls):
        received = power.sum()
        stored = rate(STORED.get(cls, nothing), at)
        dissipated = DISSIPATED.get(cls, rubbing)(at)
        supplied = SUPPLIED.get(cls, nothing)(at)
        expected = stored + dissipated - supplied
        scale = np.abs(power).sum() + abs(stored) + abs(dissipated) + abs(supplied)
        error = abs(received - expected)
        assert error <= TOLERANCE * scale + ROUNDING
        assert received - stored + supplied >= -TOLERANCE * scale - ROUNDING
        assert min(at.held, default=0.0) >= 0
        worst = max(worst, error / scale if scale else 0.0)
    print(f"{cls.__name__}: power balance, largest relative error {worst:.1e}")
