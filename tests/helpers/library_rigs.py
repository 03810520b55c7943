"""Every component of the library, with random values and a loaded body at each of its ports.

A new component is covered as it is. It needs an entry here only if a random number is no sensible
value for one of its fields.
"""

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

import lumped as lp
import lumped.components
from lumped.components import (
    Inertia,
    Torque,
    cam_follower,
    cams,
    dynamic_friction,
    friction,
    hysteresis,
    impact,
    linkages,
    rolling,
    translation,
    tyre,
    vehicle,
    winding,
)
from lumped.components import compliance as rotation
from lumped.components.bearings import geometry, rolling_bearing, windage
from lumped.components.control import linear_blocks, sequence, signals
from lumped.components.converters import clutches, hydrodynamic, limited_slip, variator
from lumped.components.couplings import elastic_coupling, maxwell_coupling
from lumped.components.electric import circuit, drives, network, synchronous, thermal
from lumped.components.engines import crank, crankshaft, engine, propeller
from lumped.components.gearing import (
    belts,
    gear_mesh,
    harmonic_drive,
    lossy_gear,
    noncircular,
    planetary_sets,
    planetary_stage,
    planets,
    screws,
    synchroniser,
)
from lumped.components.loads import hoist, ice, wind
from lumped.components.shafts import continuous, notch, notches, sections, shaft

ROWS = ((0.0, 2.0), (1.0, 1.5), (3.0, 1.8))
HARMONICS = ((0.5, 3.0, 0.4), (2.0, -1.0, 2.0))
POINTS = ((-0.5, 3.0), (0.4, -1.0), (2.9, 2.0))
TWISTS = ((-1.0, -3.0), (-0.4, -0.8), (0.5, 0.7), (1.2, 4.0))
START = ((0.0, 0.8, 0.6), (0.5, 1.1, 0.7), (1.0, 0.0, 0.3))
GAS = ((0.0, 2.0), (2.0, 5.0), (9.0, 1.0))
MESH = ((1.0, 0.3, 0.2), (2.0, -0.1, 1.0))
BLOCKS = ((0.75, 1.5, 0.2), (0.4, 0.7, 2.5))
BEARING = {"kind": geometry.DeepGroove(2e4, *geometry.DEEP_GROOVE["62"])}
BORE = {"d": 0.05, "D": 0.09, "nu_100": 7e-6, "nu_40": 4.6e-5, "K_rs": 3e-8, "T": 340.0}
COUPLING = ((0.0, 0.0), (0.4, 0.8), (1.2, 4.0))
MAP = ((0.0, 0.0, 1.0), (0.0, 0.6, 0.8), (2.0, 0.7, 0.9))
MATRICES = {
    "A": ((-1.0, 0.4), (-0.4, -2.0)),
    "B": ((1.0,), (0.5,)),
    "C": ((1.0, 2.0),),
    "D": ((0.3,),),
}
PLANET = {"z_s": 20, "z_p": 25, "z_r": 69, "flank": -1, "stiffness_s": MESH, "error_r": MESH}
RAVIGNEAUX = {"z_small": 30, "z_large": 36, "z_short": 17, "z_long": 18, "z_r": 72}
STAGE = {"n": 2, "z_s": 20, "z_p": 25, "z_r": 70, "c_s": (2.0, 1.2), "c_r": 3.0, "d_s": 0.4}
POLYNOMIALS = {"numerator": (1.0, 2.0), "denominator": (2.0, 1.5, 0.7)}
RISES = cam_follower.cam_motion(((0.3, 0.0), (1.5, 0.4), (2.0, 0.4), (3.5, 0.1)), "polynomial")
HYDRAULIC = {"T_p": 0.5, "A": 2.0, "n": 2.0, "r": 0.5, "C_lining": 1.0, "C_plate": 2.0, "G": 0.7}
FIELDS = {
    clutches.DualClutch: {
        "clutch_1": clutches.HeatedClutch(**HYDRAULIC),
        "clutch_2": clutches.HeatedClutch(**HYDRAULIC),
    },
    hydrodynamic.FluidCoupling: {"characteristic": ((0.0, 0.0), (0.1, 2.0), (1.0, 3.0))},
    hydrodynamic.TorqueConverter: {
        "characteristic": ((0.0, 2.0, 1.5), (0.8, 1.1, 1.0), (1.0, 1.0, 0.0), (2.0, 0.9, -1.2))
    },
    limited_slip.ViscousCoupling: {"characteristic": ((0.0, 0.0), (0.5, 2.0), (3.0, 2.5))},
    variator.Variator: {"characteristic": ((0.0, 0.0), (0.1, 0.8), (1.0, 0.6))},
    linear_blocks.StateSpaceBlock: MATRICES,
    linear_blocks.SampledStateSpace: MATRICES,
    linear_blocks.TransferFunction: POLYNOMIALS,
    linear_blocks.SampledTransferFunction: POLYNOMIALS,
    circuit.Battery: {"ocv": ((0.0, 2.0), (0.5, 3.0), (1.0, 3.2))},
    drives.MappedMotor: {"limits": ((0.0, 2.0), (1.0, 1.0)), "efficiency": MAP},
    synchronous.SynchronousMotorStart: {"torques": START},
    synchronous.WoundFieldMachine: {"dampers_d": 2, "dampers_q": 2},
    engine.Cylinder: {"pressure": GAS},
    crankshaft.Engine: {"cylinders": 2, "firing_order": (1, 2), "c": 2.0, "pressure": GAS},
    gear_mesh.GearMesh: {"stiffness": MESH, "error": MESH},
    harmonic_drive.HarmonicDrive: {"errors": HARMONICS},
    planetary_sets.CompoundPlanetary: {"z_s": 20, "z_1": 28, "z_2": 16, "z_r": 64},
    planetary_sets.Ravigneaux: RAVIGNEAUX,
    planetary_sets.Simpson: {"z_s": 30, "z_p1": 18, "z_r1": 66, "z_p2": 21, "z_r2": 72},
    planetary_stage.PlanarPlanetaryStage: STAGE | {"c_b": 1.5},
    planetary_stage.PlanetaryStage: STAGE,
    planets.Planet: PLANET,
    planets.PlanetOnBearing: PLANET,
    propeller.Propeller: {"blades": MESH},
    rotation.NonlinearSpring: {"characteristic": TWISTS},
    translation.NonlinearSpring: {"characteristic": TWISTS},
    elastic_coupling.ElasticCoupling: {"twist": COUPLING, "extrapolate": True},
    maxwell_coupling.MaxwellBranch: {"stiffness": ((0.0, 3.0),), "static": 0.5},
    maxwell_coupling.MaxwellCoupling: {
        "stiffness": ((0.0, 3.0),),
        "static": 0.5,
        "psi": 0.8,
        "band": (1.0, 1.4),
        "n_branches": 2,
        "extrapolate": True,
    },
    cam_follower.Cam: {"profile": RISES},
    cam_follower.CamFollower: {"cam": cam_follower.Cam(profile=RISES)},
    cams.HarmonicTorque: {"harmonics": HARMONICS},
    cams.PeriodicTorque: {"points": POINTS, "shape": "lines", "period": 5.0},
    signals.Table: {"times": (0.0, 1.0), "values": (2.0, 3.0)},
    rolling_bearing.BallBearingInBath: BEARING,
    rolling_bearing.RollingBearing: BEARING,
    wind.WindRotor: {"coefficients": ((1.0, 0.2), (1e4, 0.1))},
    ice.IceTorque: {"blocks": BLOCKS, "Z": 3},
    hysteresis.Iwan: {"backbone": ((0.0, 0.0), (0.5, 2.0), (1.0, 3.0), (2.0, 4.0))},
    hysteresis.ClutchDisc: {"drive": ((0.0, 1.0, 0.2), (0.3, 3.0, 0.5), (0.8, 40.0, 0.5))},
    dynamic_friction.LuGre: {"characteristic": ROWS},
    friction.BearingFriction: {"characteristic": ROWS},
    translation.SupportFriction: {"characteristic": ROWS},
    translation.MassWithStopAndFriction: {"characteristic": ROWS},
    sequence.PositionSequencer: {"targets": (0.5, -1.0)},
    sequence.SpeedProfile: {"sections": ((-1.0, 0.5), (0.0, 2.0), (1.0, 0.8))},
    sequence.StepSequencer: {"sections": ((-1.0, 0.5), (0.0, 2.0), (1.0, 0.8)), "waits": (1,)},
    noncircular.NonCircularGear: {"transmission": lambda x: -(x + 0.4 * lp.ops.sin(2 * x))},
    shaft.Shaft: {
        "sections": (sections.Solid(d=1.0, L=2.0), sections.Solid(d=1.0, L=1.0)),
        "continuous": True,
    },
    sections.Disc: {"continuous": True},
    sections.Hollow: {"continuous": True},
    sections.Keyed: {"continuous": True},
    sections.Solid: {"continuous": True},
    sections.Splined: {"continuous": True},
    sections.Taper: {"continuous": True},
    lossy_gear.LossyGear: {"losses": ((0.0, 0.9, 0.8, 0.5, 0.7), (3.0, 0.7, 0.8, 0.6, 0.7))},
}
"""Structural fields without a usable default."""

SENSIBLE: dict[type[lp.Component], dict[str, float]] = {
    rolling_bearing.BallBearingInBath: BORE | {"H": 0.02},
    rolling_bearing.RollingBearing: BORE,
    hoist.HoistRope: {"l_0": 20.0},
    belts.Belt: {"distance": 6.0},
    continuous.ContinuousElement: {"w": 0.4},
    crank.CrankSlider: {"L": 6.0},
    crank.StrokeLoad: {"s_0": -10.0, "s_1": 10.0},
    drives.FieldOrientedMotor: {"I_max": 10.0, "psi_n": 2.0, "L_m": 1.0},
    circuit.VariableResistor: {"R": 1.5},
    synchronous.WoundFieldMachine: {
        f"{kind}{number}{axis}": 0.3 + 0.4 * number
        for kind in ("R_", "L_l")
        for number in (1, 2)
        for axis in "dq"
    },
    clutches.DualClutch: {"p_1": 1.5, "p_2": 0.7},
    clutches.HeatedClutch: {"p_wanted": 1.5},
    clutches.PressureClutch: {"p_wanted": 1.5},
    impact.Backlash: {"b": 10.0},
    screws.LeadScrew: {"mu": 0.3, "d": 2.0},
    screws.WormGear: {"gamma": 0.3, "mu": 0.2},
    linkages.GuidedRod: {"length": 10.0},
    notches.Fillet: {"r": 0.2, "d": 1.0, "D": 1.4},
    notches.Keyway: {"r": 0.03, "d": 1.0},
    notches.RadialHole: {"bore": 0.5, "d_hole": 0.1, "d": 1.2},
    **{kind: {"alpha": 0.4} for kind in (planets.Planet, planets.PlanetOnBearing)},
    **{kind: {"L": 5.0} for kind in (sections.Disc, sections.Hollow, sections.Solid)},
    sections.Splined: {"L": 5.0, "bore": 0.5, "d_root": 1.0, "d": 1.2},
    sections.Keyed: {"L": 5.0, "bore": 0.5, "t": 0.1, "d": 1.2},
    sections.Taper: {"L": 5.0, "bore": 0.5, "d_a": 0.9, "d_b": 1.4},
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
    rolling_bearing.BallBearingInBath: ["F_r", "F_a"],
    rolling_bearing.RollingBearing: ["F_r", "F_a"],
    wind.WindRotor: ["v"],
    windage.DiscWindage: ["rho", "nu"],
    circuit.VariableResistor: ["R"],
    variator.Variator: ["ratio", "f_n"],
    vehicle.Vehicle: ["cr"],
    friction.JournalFriction: ["f_n"],
    rolling.RollingTorque: ["F", "a"],
    rolling.StripPass: ["F", "a"],
    tyre.Tyre: ["f_n"],
}
"""Inputs that make no sense below zero."""

BASES = {
    *(linear_blocks.LinearBlock, linear_blocks.SampledLinearBlock),
    *(thermal.Heated, notch.Notch, shaft.Section, lossy_gear.Meshing),
}
"""What only stands before another component, or is the base of several."""


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


@cache
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


class Choke(lp.Component):
    """Inductance from a wire to the ground: ``L der(i) = v``."""

    pin = lp.Pin()
    L: lp.Param = lp.param("H", "inductance", above=0)
    v: lp.Var = lp.var("V", "potential")
    i: lp.Var = lp.var("A", "current to the ground")

    def equations(self) -> Iterator[lp.Equation]:
        yield self.pin.v == self.v
        yield self.pin.i == self.i
        yield self.L * lp.der(self.i) == self.v


CONTACTS = {network.CircuitBreaker, network.ShortCircuit}
"""What interrupts currents of inductances."""


def kinds(cls: type[lp.Component]) -> dict[str, Kind]:
    found = {name: KINDS[type(port)] for name, port in declared(cls, lp.Port).items()}
    if cls in CONTACTS:
        found |= dict.fromkeys(found, Kind(Choke, "L", "v", Feed, "i", ("pin", "pin")))
    return found


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
