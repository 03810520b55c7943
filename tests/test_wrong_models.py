"""Wrong drive trains: each gets an error that names the guilty parts and says what to do.

The same table makes the error catalogue; `python -m tests.test_wrong_models` rewrites it.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import lumped as lp
from lumped.components import (
    AngleSensor,
    Backlash,
    BearingFriction,
    Belt,
    CamSwitch,
    CascadeControl,
    Clutch,
    Coil,
    Constant,
    CrankSlider,
    Damper,
    DCMotor,
    EddyCurrentBrake,
    EfficientGear,
    ElastoBacklash,
    EllipticalGear,
    Fixed,
    Ground,
    HarmonicTorque,
    IdealGear,
    InductionMotor,
    Inertia,
    JournalFriction,
    Latch,
    LimitedPI,
    LossyGear,
    NonCircularGear,
    PeriodicTorque,
    Planetary,
    Position,
    PositionSequencer,
    PulseTorque,
    QuadraticTorque,
    QuasiStaticDCMotor,
    RackAndPinion,
    RelativeAngleSensor,
    RollingTorque,
    SampledPI,
    SlipCoupling,
    Speed,
    SpeedProfile,
    SpeedSensor,
    Spring,
    SquirrelCageMotor,
    Stribeck,
    Strip,
    StripPath,
    StrokeLoad,
    SynchronousMotor,
    Torque,
    TorqueSensor,
    Vehicle,
    VoltageSource,
    friction,
    translation,
)
from lumped.errors import (
    ConnectError,
    DeclarationError,
    EquationError,
    LumpedError,
    OptionError,
    ParameterError,
    SingularModelError,
    SolverError,
    StartError,
    UnitError,
    UnknownNameError,
)
from lumped.transmissions import from_ratio, through

CATALOGUE = Path(__file__).parent.parent / "docs" / "errors.md"


@dataclass(frozen=True)
class Case:
    """A mistake: its kind, what the user did, how, and what the answer must hold."""

    kind: str
    mistake: str
    name: str
    make: Callable[[], object]
    error: type[LumpedError]
    words: tuple[str, ...]


CASES: list[Case] = []


def wrong(kind, error, *words):
    """Enter a function into the table; its docstring says what the user did."""

    def enter(make):
        CASES.append(Case(kind, make.__doc__, make.__name__, make, error, words))
        return make

    return enter


def build(connections=(), **parts):
    """Assemble a model of these parts."""
    return lp.assemble(lp.compose(connections=connections, **parts))


# -- parts that the library does not have ------------------------------------------------------


class Resistor(lp.Component):
    """Resistor: v_p - v_n = R i."""

    p = lp.Pin()
    n = lp.Pin()
    R: lp.Param = lp.param("Ohm", "resistance", 1.0, above=0)

    def equations(self):
        yield self.p.v - self.n.v == self.R * self.p.i
        yield self.p.i + self.n.i == 0


class Battery(lp.Component):
    """Voltage source: v_p - v_n = U."""

    p = lp.Pin()
    n = lp.Pin()
    U: lp.Param = lp.param("V", "voltage", 24.0)

    def equations(self):
        yield self.p.v - self.n.v == self.U
        yield self.p.i + self.n.i == 0


class Machine(lp.Component):
    """DC machine: torque k i, voltage k w + R i."""

    p = lp.Pin()
    n = lp.Pin()
    flange = lp.Flange()
    k: lp.Param = lp.param("N.m/A", "machine constant", 0.1)
    R: lp.Param = lp.param("Ohm", "resistance of the windings", 0.5, above=0)

    def equations(self):
        yield self.p.v - self.n.v == self.R * self.p.i + self.k * lp.der(self.flange.phi)
        yield self.p.i + self.n.i == 0
        yield self.flange.tau == -self.k * self.p.i


class Shaft(lp.Component):
    """Elastic shaft with its inertia: two halves and a spring, joined inside."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    J: lp.Param = lp.param("kg.m2", "moment of inertia", 0.1, above=0)
    left: Inertia = Inertia(J=J / 2)
    twist: Spring = Spring(c=100.0)
    right: Inertia = Inertia(J=J / 2)

    def connections(self):
        yield from lp.chain(self.flange_a, self.left, self.twist, self.right, self.flange_b)


class Line(lp.Component):
    """Two elastic shafts in a row, one level further down."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    first: Shaft = Shaft()
    second: Shaft = Shaft()

    def connections(self):
        yield from lp.chain(self.flange_a, self.first, self.second, self.flange_b)


class Hoist(lp.Component):
    """Motor, shafts and drum, with lists and dictionaries of parts."""

    motor: Inertia = Inertia(J=0.1)
    line: Line = Line()
    discs: list[Inertia] = [Inertia(J=1.0), Inertia(J=1.0)]  # noqa: RUF012
    brakes: dict[str, Damper] = {"left": Damper(d=1.0), "right": Damper(d=1.0)}  # noqa: RUF012
    wall: Fixed = Fixed()

    def connections(self):
        yield from lp.chain(self.motor, self.line, *self.discs)
        for brake in self.brakes.values():
            yield from lp.chain(self.discs[-1], brake, self.wall)


# -- motion held or prescribed twice -----------------------------------------------------------

TWICE = "Motion held or prescribed twice"


@wrong(TWICE, SingularModelError, "bearing.flange", "brake.flange", "spring between")
def two_supports():
    """Two rigid supports hold the two ends of one rigid rotor."""
    build(
        lambda m: lp.chain(m.bearing, m.rotor, m.brake),
        bearing=Fixed(),
        rotor=Inertia(J=1.0),
        brake=Fixed(),
    )


@wrong(TWICE, SingularModelError, "stand.motor_mount", "stand.foot", "spring between")
def two_supports_inside_a_part():
    """Two supports meet deep in a composite."""

    class Stand(lp.Component):
        """Two mounts at one flange."""

        flange = lp.Flange()
        motor_mount: Fixed = Fixed()
        foot: Fixed = Fixed()

        def connections(self):
            yield lp.connect(self.flange, self.motor_mount.flange, self.foot.flange)

    build(
        lambda m: lp.chain(m.stand, m.spring, m.load),
        stand=Stand(),
        spring=Spring(c=1.0),
        load=Inertia(J=1.0),
    )


@wrong(TWICE, SingularModelError, "mill.w = 10", "grid.w = 12", "rotor")
def two_speeds_on_one_shaft():
    """Two speed sources drive the two ends of one rigid rotor."""
    build(
        lambda m: [
            lp.connect(m.mill.flange, m.rotor.flange_a),
            lp.connect(m.grid.flange, m.rotor.flange_b),
        ],
        mill=Speed(w=10.0),
        rotor=Inertia(J=1.0),
        grid=Speed(w=12.0),
    )


@wrong(TWICE, SingularModelError, "fast.flange", "slow.flange", "gear")
def two_speeds_through_a_gear():
    """Two speed sources drive the two sides of a rigid gear."""
    build(
        lambda m: lp.chain(m.fast, m.gear, m.slow),
        fast=Speed(w=30.0),
        gear=IdealGear(ratio=3.0),
        slow=Speed(w=10.0),
    )


@wrong(TWICE, SingularModelError, "servo.phi = 1", "motor.w = 10")
def speed_and_position():
    """A speed source and a position source drive the same shaft."""
    build(
        lambda m: lp.chain(m.motor, m.body, m.servo),
        motor=Speed(w=10.0),
        body=Inertia(J=1.0),
        servo=Position(phi=1.0),
    )


@wrong(TWICE, SingularModelError, "wall.flange.phi = wall.phi0", "motor")
def speed_on_a_fixed_shaft():
    """A speed source drives a rotor that a support holds."""
    build(
        lambda m: lp.chain(m.motor, m.rotor, m.wall),
        motor=Speed(w=10.0),
        rotor=Inertia(J=1.0),
        wall=Fixed(),
    )


@wrong(TWICE, SingularModelError, "left.flange", "right.flange", "rack")
def rack_between_two_fixed_points():
    """A rack and its pinion are both held."""
    build(
        lambda m: [
            lp.connect(m.left.flange, m.rack.flange_a),
            lp.connect(m.rack.flange_b, m.right.flange),
        ],
        left=Fixed(),
        rack=RackAndPinion(radius=0.1),
        right=translation.Fixed(),
    )


@wrong(TWICE, SingularModelError, "set", "hold_sun", "hold_ring", "hold_carrier")
def planetary_held_three_times():
    """All three shafts of a planetary gear are held."""
    build(
        lambda m: [
            lp.connect(m.hold_sun.flange, m.set.sun),
            lp.connect(m.hold_ring.flange, m.set.ring),
            lp.connect(m.hold_carrier.flange, m.set.carrier),
        ],
        set=Planetary(ratio=2.0),
        hold_sun=Fixed(),
        hold_ring=Fixed(),
        hold_carrier=Fixed(),
    )


@wrong(TWICE, SingularModelError, "set", "engine", "generator", "axle")
def planetary_driven_three_times():
    """All three shafts of a planetary gear have a speed source."""
    build(
        lambda m: [
            lp.connect(m.engine.flange, m.set.carrier),
            lp.connect(m.generator.flange, m.set.sun),
            lp.connect(m.axle.flange, m.set.ring),
        ],
        set=Planetary(ratio=2.0),
        engine=Speed(w=100.0),
        generator=Speed(w=200.0),
        axle=Speed(w=50.0),
    )


# -- rigid loops -------------------------------------------------------------------------------

LOOPS = "Rigid loops"


@wrong(LOOPS, SingularModelError, "in gear_1", "in gear_2", "closed loop", "elastic")
def gears_in_parallel():
    """Two rigid gears of equal ratio join the same two shafts."""
    build(
        lambda m: [
            lp.connect(m.motor.flange_b, m.gear_1.flange_a, m.gear_2.flange_a),
            lp.connect(m.gear_1.flange_b, m.gear_2.flange_b, m.load.flange_a),
        ],
        motor=Inertia(J=1.0),
        gear_1=IdealGear(ratio=3.0),
        gear_2=IdealGear(ratio=3.0),
        load=Inertia(J=1.0),
    )


@wrong(
    LOOPS,
    SingularModelError,
    "leave no motion of motor.phi, load.phi",
    "runs through gear_1, gear_2: gear_1.ratio = 2, gear_2.ratio = 3.",
    "ratios agree",
)
def gears_of_unequal_ratio():
    """Two rigid gears of unequal ratio join the same two shafts."""
    build(
        lambda m: [
            lp.connect(m.motor.flange_b, m.gear_1.flange_a, m.gear_2.flange_a),
            lp.connect(m.gear_1.flange_b, m.gear_2.flange_b, m.load.flange_a),
        ],
        motor=Inertia(J=1.0),
        gear_1=IdealGear(ratio=2.0),
        gear_2=IdealGear(ratio=3.0),
        load=Inertia(J=1.0),
    )


@wrong(LOOPS, SingularModelError, "runs through gear_1, gear_2: gear_1.ratio = 2", "ratios agree")
def gears_of_unequal_ratio_at_a_speed():
    """A prescribed speed drives two gears of unequal ratio between the same two shafts."""
    build(
        lambda m: [
            lp.connect(m.motor.flange, m.gear_1.flange_a, m.gear_2.flange_a),
            lp.connect(m.gear_1.flange_b, m.gear_2.flange_b, m.load.flange_a),
        ],
        motor=Speed(w=100.0),
        gear_1=IdealGear(ratio=2.0),
        gear_2=IdealGear(ratio=3.0),
        load=Inertia(J=1.0),
    )


@wrong(
    LOOPS, SingularModelError, "leave no motion of motor.phi", "runs through gear: gear.ratio = 4."
)
def gear_beside_a_rigid_shaft():
    """A gear joins two rotors that are also joined directly."""
    build(
        lambda m: [
            *lp.chain(m.motor, m.gear, m.load),
            lp.connect(m.motor.flange_a, m.load.flange_b),
        ],
        motor=Inertia(J=1.0),
        gear=IdealGear(ratio=4.0),
        load=Inertia(J=1.0),
    )


@wrong(LOOPS, SingularModelError, "in set (Planetary)", "set.ratio = 2", "lower.ratio = 2.5")
def planetary_set_tied_by_two_gears():
    """Two gears tie all three shafts of a planetary set to each other."""
    build(
        lambda m: [
            lp.connect(m.set.sun, m.motor.flange_b, m.upper.flange_a),
            lp.connect(m.set.ring, m.upper.flange_b, m.lower.flange_a),
            lp.connect(m.set.carrier, m.load.flange_a, m.lower.flange_b),
        ],
        motor=Inertia(J=1.0),
        set=Planetary(ratio=2.0),
        upper=IdealGear(ratio=-1.5),
        lower=IdealGear(ratio=2.5),
        load=Inertia(J=1.0),
    )


@wrong(LOOPS, SingularModelError, "runs through pinion_1, pinion_2: pinion_1.radius = 0.1 m")
def rack_with_two_pinions_on_a_shaft():
    """Two pinions of unequal radius on one shaft mesh with one rack."""
    build(
        lambda m: [
            lp.connect(m.motor.flange_b, m.pinion_1.flange_a, m.pinion_2.flange_a),
            lp.connect(m.pinion_1.flange_b, m.pinion_2.flange_b, m.table.flange_a),
        ],
        motor=Inertia(J=1.0),
        pinion_1=RackAndPinion(radius=0.1),
        pinion_2=RackAndPinion(radius=0.12),
        table=translation.Mass(m=1.0),
    )


@wrong(LOOPS, SingularModelError, "runs through rotor, sensor", "share the load")
def torque_sensor_across_a_rotor():
    """A torque sensor is connected across a rigid rotor instead of in the power path."""
    build(
        lambda m: [
            lp.connect(m.drive.flange, m.rotor.flange_a, m.sensor.flange_a),
            lp.connect(m.rotor.flange_b, m.sensor.flange_b),
        ],
        drive=Torque(tau=1.0),
        rotor=Inertia(J=1.0),
        sensor=TorqueSensor(),
    )


@wrong(LOOPS, SingularModelError, "runs through sensor_1, sensor_2", "share the load")
def two_torque_sensors_in_parallel():
    """Two torque sensors join the same two rotors."""
    build(
        lambda m: [
            lp.connect(m.a.flange_b, m.sensor_1.flange_a, m.sensor_2.flange_a),
            lp.connect(m.sensor_1.flange_b, m.sensor_2.flange_b, m.b.flange_a),
        ],
        a=Inertia(J=1.0),
        b=Inertia(J=1.0),
        sensor_1=TorqueSensor(),
        sensor_2=TorqueSensor(),
    )


@wrong(LOOPS, SingularModelError, "body.flange_a", "body.flange_b", "share the load")
def mass_attached_twice():
    """Both flanges of one rotor are connected to the same shaft end."""
    build(
        lambda m: [
            lp.connect(m.wall.flange, m.shaft.flange_a),
            lp.connect(m.shaft.flange_b, m.body.flange_a, m.body.flange_b),
        ],
        wall=Fixed(),
        shaft=Spring(c=100.0),
        body=Inertia(J=1.0),
    )


# -- parts that nothing determines -------------------------------------------------------------

LOOSE = "Parts that nothing holds"


@wrong(LOOSE, SingularModelError, "left.tau", "right.tau", "nothing holds left, shaft, right")
def spring_between_two_torques():
    """A spring stands between two torque sources, without any inertia."""
    build(
        lambda m: lp.chain(m.left, m.shaft, m.right),
        left=Torque(tau=1.0),
        shaft=Spring(c=10.0),
        right=Torque(tau=-1.0),
    )


@wrong(LOOSE, SingularModelError, "spare.flange.phi", "nothing holds spare, other")
def sensor_alone():
    """A sensor is connected to another sensor only."""
    build(
        lambda m: [
            lp.connect(m.drive.flange, m.body.flange_a),
            lp.connect(m.spare.flange, m.other.flange),
        ],
        drive=Torque(tau=1.0),
        body=Inertia(J=1.0),
        spare=AngleSensor(),
        other=SpeedSensor(),
    )


@wrong(LOOSE, SingularModelError, "one.flange_a.phi", "nothing holds one, two, three")
def dampers_without_ground():
    """A ring of dampers has neither inertia nor ground."""
    build(
        lambda m: [
            lp.connect(m.one.flange_b, m.two.flange_a),
            lp.connect(m.two.flange_b, m.three.flange_a),
            lp.connect(m.three.flange_b, m.one.flange_a),
        ],
        one=Damper(d=1.0),
        two=Damper(d=2.0),
        three=Damper(d=3.0),
    )


@wrong(LOOSE, SingularModelError, "gear.flange_b.phi", "nothing holds motor, gear, load")
def gear_into_nothing():
    """A torque drives a gear whose other side carries a second torque and no inertia."""
    build(
        lambda m: lp.chain(m.motor, m.gear, m.load),
        motor=Torque(tau=1.0),
        gear=IdealGear(ratio=2.0),
        load=Torque(tau=-2.0),
    )


@wrong(LOOSE, SingularModelError, "nothing holds drives[1].motor, drives[1].shaft", "inertia")
def one_of_several_drives_loose():
    """In one of several equal drives the inertia was forgotten."""

    class Drive(lp.Component):
        """Torque, shaft, and something at its end."""

        motor: Torque = Torque(tau=1.0)
        shaft: Spring = Spring(c=10.0)
        end: lp.Component = Inertia(J=1.0)
        rotor: Inertia = Inertia(J=1.0)
        with_rotor: bool = True

        def connections(self):
            if self.with_rotor:
                yield from lp.chain(self.motor, self.rotor, self.shaft, self.end)
            else:
                yield from lp.chain(self.motor, self.shaft, self.end)

    build(drives=[Drive(), Drive(with_rotor=False, end=Torque(tau=2.0))])


@wrong(LOOSE, SingularModelError, "battery.n.v", "nothing holds battery, load", "ground")
def circuit_without_ground():
    """No pin of an electric circuit is grounded."""
    build(
        lambda m: [lp.connect(m.battery.p, m.load.p), lp.connect(m.battery.n, m.load.n)],
        battery=Battery(),
        load=Resistor(R=2.0),
    )


@wrong(LOOSE, SingularModelError, "battery.n.v", "nothing holds battery, motor", "ground")
def machine_without_ground():
    """A motor on a battery: the shaft is sound, the electric side has no ground."""
    build(
        lambda m: [
            lp.connect(m.battery.p, m.motor.p),
            lp.connect(m.battery.n, m.motor.n),
            lp.connect(m.motor.flange, m.rotor.flange_a),
        ],
        battery=Battery(),
        motor=Machine(),
        rotor=Inertia(J=1.0),
    )


@wrong(LOOSE, SingularModelError, "sensor.flange_a.phi", "nothing holds motor, sensor")
def relative_sensor_in_the_power_path():
    """A sensor of relative angle stands in the power path, where it carries no torque."""
    build(
        lambda m: lp.chain(m.motor, m.sensor, m.load),
        motor=Torque(tau=1.0),
        sensor=RelativeAngleSensor(),
        load=Inertia(J=1.0),
    )


@wrong(LOOSE, SingularModelError, "nothing holds left, right", "prescribed motions meet at grid")
def two_mistakes_at_once():
    """Two torques meet without an inertia, and elsewhere two speed sources meet."""
    build(
        lambda m: [*lp.chain(m.left, m.right), *lp.chain(m.grid, m.rotor, m.mill)],
        left=Torque(tau=1.0),
        right=Torque(tau=-1.0),
        grid=Speed(w=1.0),
        rotor=Inertia(J=1.0),
        mill=Speed(w=2.0),
    )


@wrong(LOOSE, SingularModelError, "in two (Damper)", "are zero: one.d, two.d")
def joint_between_dampers_of_zero():
    """A massless joint is held by two dampers whose damping is zero."""
    system = build(
        lambda m: lp.chain(m.a, m.one, m.two, m.b),
        a=Inertia(J=1.0),
        one=Damper(d=0.0),
        two=Damper(d=0.0),
        b=Inertia(J=1.0),
    )
    lp.simulate(system, until=1.0)


# -- parameters --------------------------------------------------------------------------------

PARAMETERS = "Parameters"


@wrong(PARAMETERS, ParameterError, "line.second.right.J", "no value")
def parameter_missing_deep_inside():
    """A part three levels down has no inertia."""
    lp.assemble(Hoist().with_({"line.second.right": Inertia()}))


@wrong(PARAMETERS, ParameterError, "discs[1].J = -1", "greater than 0")
def negative_in_a_list():
    """A negative inertia stands in a list."""
    lp.assemble(Hoist().with_({"discs[1].J": -1.0}))


@wrong(PARAMETERS, ParameterError, 'brakes["left"].d = -1', "line.first.twist.c = 0", "2 param")
def two_faults_at_once():
    """A negative damping in a dictionary, and a stiffness of zero in a part of a part."""
    lp.assemble(Hoist().with_({'brakes["left"].d': -1.0, "line.first.twist.c": 0.0}))


@wrong(PARAMETERS, ParameterError, "motor.J = nan", "finite")
def parameter_nan():
    """An inertia is not a number."""
    lp.assemble(Hoist().with_({"motor.J": math.nan}))


@wrong(PARAMETERS, ParameterError, "line.first.twist.c = inf", "finite")
def parameter_infinite():
    """A stiffness is infinite, to make the shaft rigid."""
    lp.assemble(Hoist().with_({"line.first.twist.c": math.inf}))


@wrong(PARAMETERS, ParameterError, "stage.gear.ratio = 0", "must not be zero")
def ratio_of_zero():
    """A gear deep inside has the ratio zero."""

    class Stage(lp.Component):
        """One gear."""

        gear: IdealGear = IdealGear(ratio=0.0)

    build(stage=Stage())


@wrong(PARAMETERS, EquationError, "rotor.J", "1 + time", "cannot hold the time")
def parameter_bound_to_the_time():
    """An inertia is bound to the time."""

    class Winder(lp.Component):
        """Reel that grows."""

        rotor: Inertia = Inertia(J=1.0 + lp.time)

    lp.assemble(Winder())


@wrong(PARAMETERS, EquationError, "Winder", "'radius'")
def parameter_bound_to_a_stranger():
    """A part is bound to a parameter of another component."""

    class Winder(lp.Component):
        """Rotor with the radius of something else."""

        rotor: Inertia = Inertia(J=2 * RackAndPinion.radius)

    lp.assemble(Winder())


@wrong(PARAMETERS, UnitError, "Spring(c=...)", "'1e4 N.m'", "N.m/rad", "angle is missing")
def parameter_in_another_unit():
    """A stiffness is given in the unit of a torque."""
    Spring(c="1e4 N.m")


@wrong(PARAMETERS, UnitError, "motor.w = '50 Hz'", "rpm")
def speed_in_hertz():
    """A speed is given in Hz, which leaves open whether turns or radians are meant."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": "50 Hz"})


@wrong(PARAMETERS, UnitError, "Vehicle(inclination=...)", "'3 deg'", "a slope is a tangent")
def an_angle_as_a_slope():
    """A slope is given as an angle."""
    Vehicle(m=1000.0, R=0.3, inclination="3 deg")


@wrong(PARAMETERS, DeclarationError, "Torque(tau=...)", "lumped.time", "lumped.ops.table")
def a_function_as_an_input():
    """A torque is given as a Python function of time."""
    Torque(tau=lambda t: 5.0 * t)


@wrong(PARAMETERS, ParameterError, "rotor.J = 1e+120 kg.m2", "must be smaller than 1e+100")
def a_number_beyond_all_quantities():
    """An inertia is larger than anything, and its square could not be computed."""
    build(rotor=Inertia(J=1e120))


@wrong(PARAMETERS, UnitError, "Inertia(J=...)", "'0.3 kgm2'", "kg.m2")
def misspelt_unit():
    """A unit lacks the dot between its parts."""
    Inertia(J="0.3 kgm2")


@wrong(PARAMETERS, DeclarationError, "Inertia(J=...): [1.0, 2.0]", "number in kg.m2")
def parameter_as_list():
    """An inertia is given as a list."""
    Inertia(J=[1.0, 2.0])


@wrong(PARAMETERS, DeclarationError, "Inertia(J=...): None", "number in kg.m2")
def parameter_as_none():
    """An inertia is given as None."""
    Inertia(J=None)


@wrong(PARAMETERS, ParameterError, "rotor.J = -0.5", "greater than 0")
def bound_parameter_out_of_range():
    """A parameter computed from others leaves its range."""

    class Pump(lp.Component):
        """Rotor with what is left of the inertia."""

        total: lp.Param = lp.param("kg.m2", "inertia of all", 1.0)
        rotor: Inertia = Inertia(J=total - 1.5)

    lp.assemble(Pump())


@wrong(PARAMETERS, ParameterError, "rotor.J", "finite")
def bound_parameter_divides_by_zero():
    """A parameter is computed by a division by zero."""

    class Pump(lp.Component):
        """Inertia from a natural frequency."""

        c: lp.Param = lp.param("N.m/rad", "stiffness", 1.0)
        omega: lp.Param = lp.param("rad/s", "natural frequency", 0.0)
        rotor: Inertia = Inertia(J=c / omega**2)

    lp.assemble(Pump())


@wrong(PARAMETERS, ParameterError, "fan.a", "fan.b", "circle", "a number")
def parameters_in_a_circle():
    """Two parameters are bound to each other."""

    class Fan(lp.Component):
        """Blades and hub, each half of the other."""

        a: lp.Param = lp.param("kg.m2", "hub", 1.0)
        b: lp.Param = lp.param("kg.m2", "blades", 2 * a)
        rotor: Inertia = Inertia(J=a + b)

    Fan.a.default = Fan.b / 2
    build(fan=Fan())


@wrong(PARAMETERS, UnitError, "line.first.J", "'heavy'", "kg.m2")
def text_in_a_run():
    """A run changes a parameter to a text."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.J": "heavy"})


@wrong(PARAMETERS, UnknownNameError, "line.first.left.J", "bound", "line.first.J")
def bound_parameter_set_in_a_run():
    """A run sets a parameter that is bound to one of its parent."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.left.J": 1.0})


# -- mechanisms --------------------------------------------------------------------------------

MECHANISMS = "Mechanisms"


def shear(part):
    """A motor drives a flywheel through or beside a part."""
    build(
        lambda m: (
            lp.chain(m.motor, m.part, m.wheel)
            if "flange_a" in part._ports
            else lp.chain(m.motor, m.wheel, m.part.flange)
        ),
        motor=Inertia(J=0.1),
        part=part,
        wheel=Inertia(J=2.0),
    )


@wrong(MECHANISMS, ParameterError, "part.e = 1 1", "eccentricity", "less than 1")
def ellipse_that_is_a_line():
    """An elliptical gear has the eccentricity one."""
    shear(EllipticalGear(e=1.0))


@wrong(MECHANISMS, EquationError, "part (NonCircularGear)", "a function of the angle", "lambda x")
def transmission_without_a_function():
    """A non-circular gear is given a ratio for its transmission function."""
    shear(NonCircularGear(transmission=2.0))


@wrong(MECHANISMS, OptionError, "by 1.02062073 turns", "turns = 1", "by 0.979795897")
def ratio_that_does_not_close():
    """The wanted ratio of a non-circular gear makes more than a turn of one."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 / (1 + 0.2 * lp.ops.cos(x)))))


@wrong(MECHANISMS, OptionError, "w_b / w_a is -0.00", "at 2.09", "makes 1 turns", "keeps the sign")
def ratio_that_turns_back():
    """The wanted ratio of a non-circular gear changes its sign."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 + 2 * lp.ops.cos(x))))


@wrong(MECHANISMS, OptionError, "from 0 to 3.14159 rad", "0.5 turns", "exactly one")
def points_of_half_a_turn():
    """The points of a non-circular gear cover half a turn."""
    angles = np.linspace(0, np.pi, 13)
    shear(NonCircularGear(transmission=through(np.column_stack([angles, -angles]))))


@wrong(MECHANISMS, EquationError, "periodic_spline", "must increase, but 3 -> 2")
def points_out_of_order():
    """The points of a non-circular gear are out of order."""
    rows = [(0, 0), (3, 3), (2, 2), (5, 5), (2 * np.pi, 2 * np.pi)]
    shear(NonCircularGear(transmission=through(rows)))


@wrong(MECHANISMS, ParameterError, "part.distance = 0.3 m", "greater than r_a + r_b = 0.35 m")
def pulleys_that_overlap():
    """The pulleys of a belt are larger than the distance of their axes allows."""
    shear(Belt(r_a=0.1, r_b=0.25, distance=0.3, EA=1e5, F_0=100.0))


@wrong(MECHANISMS, ParameterError, "part.F_0 = -100 N", "pretension", "at least 0")
def belt_that_pushes():
    """A belt has a negative pretension."""
    shear(Belt(r_a=0.1, r_b=0.1, distance=0.5, EA=1e5, F_0=-100.0))


@wrong(
    MECHANISMS, ParameterError, "set.ratio = -2.5 1", "ring teeth over sun teeth", "greater than 0"
)
def planetary_of_negative_ratio():
    """A planetary gear is given its ratio with held carrier, which is negative."""
    build(
        lambda m: [
            lp.connect(m.motor.flange_a, m.set.sun),
            lp.connect(m.load.flange_a, m.set.carrier),
        ],
        motor=Inertia(J=0.1),
        set=Planetary(ratio=-2.5),
        load=Inertia(J=1.0),
    )


@wrong(MECHANISMS, EquationError, "part (PulseTorque)", "'triangle'", "'half-sine' or 'rectangle'")
def pulse_of_unknown_shape():
    """A pulse of torque has a shape that does not exist."""
    shear(PulseTorque(shape="triangle", tau_max=-5.0, centre=2.0, width=1.0))


@wrong(MECHANISMS, ParameterError, "part.width = 7 rad", "range of the angle", "less than 6.28319")
def cam_wider_than_a_turn():
    """The range of a cam switch is more than a turn."""
    shear(CamSwitch(centre=0.0, width=7.0))


@wrong(MECHANISMS, EquationError, "part (HarmonicTorque)", "harmonics = ((2, 340.0),)", "phase")
def harmonic_without_phase():
    """A harmonic of a torque is given without its phase."""
    shear(HarmonicTorque(harmonics=((2, 340.0),)))


@wrong(MECHANISMS, EquationError, "part (HarmonicTorque)", "order 0", "'mean'")
def harmonic_of_order_zero():
    """The mean of a torque is given as a harmonic of order zero."""
    shear(HarmonicTorque(harmonics=((0, 50.0, 0.0), (2, 340.0, 0.0))))


@wrong(MECHANISMS, EquationError, "part (PeriodicTorque)", "increase", "2 -> 1 rad")
def periodic_table_out_of_order():
    """The points of a periodic torque are not in the order of their angles."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0), (1.0, 3.0))))


@wrong(MECHANISMS, EquationError, "part (PeriodicTorque)", "360 rad", "6.28319 rad", "in rad")
def periodic_table_in_degrees():
    """The angles of a periodic torque are given in degrees, the closing point among them."""
    shear(PeriodicTorque(points=((0.0, 1.0), (180.0, 5.0), (360.0, 1.0))))


@wrong(MECHANISMS, EquationError, "part (PeriodicTorque)", "period = -1 rad", "2 pi for a turn")
def period_below_zero():
    """A periodic torque has a negative period."""
    shear(PeriodicTorque(points=((0.0, 1.0),), period=-1))


@wrong(MECHANISMS, EquationError, "part (PeriodicTorque)", "'spline'", "'smooth' or 'lines'")
def periodic_table_of_unknown_shape():
    """A periodic torque is to be joined in a way that does not exist."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0)), shape="spline"))


@wrong(MECHANISMS, ParameterError, "part.R = 0 m", "radius of the rolls", "greater than 0")
def rolls_without_radius():
    """Rolls have no radius."""
    shear(RollingTorque(F=1e6, a=0.01, R=0.0, T_back=0.0, T_front=0.0))


# -- winding -----------------------------------------------------------------------------------

WINDING = "Winding"


def coiler(*, strip=None, path=None, **given):
    """A coil on a mandrel that is driven, with its strip or the path of it."""
    values = {"r": 0.3, "R_max": 1.0, "h": 2e-3, "b": 1.2, "rho": 7850.0} | given
    line = strip or path

    def connections(m):
        yield lp.connect(m.drive.flange, m.coil.flange)
        if path:
            yield lp.connect(m.coil.strip, m.path.strip)
            yield lp.connect(m.coil.tangent, m.path.tangent)
            yield lp.connect(m.coil.R, m.path.R)
            yield lp.connect(m.path.line, m.pull.flange)
        elif strip:
            yield from lp.chain(m.pull.flange, m.strip, m.coil.strip)
        else:
            yield lp.connect(m.coil.strip, m.pull.flange)

    parts = {"path" if path else "strip": line} if line else {}
    build(
        connections,
        drive=Speed(w=10.0),
        coil=Coil(**values),
        pull=translation.Speed(v=0.0) if strip else translation.Force(f=-5e4),
        **parts,
    )


@wrong(WINDING, ParameterError, "coil.h = -0.001 m", "thickness of the strip", "at least 0")
def strip_of_negative_thickness():
    """The thickness of a strip is negative."""
    coiler(h=-1e-3)


@wrong(WINDING, ParameterError, "coil.R_max = 0.2 m", "radius of a full coil", "coil.r = 0.3 m")
def full_coil_smaller_than_its_mandrel():
    """A full coil is smaller than its mandrel."""
    coiler(R_max=0.2)


@wrong(WINDING, ParameterError, "coil.fill = 95 1", "at most 1")
def fill_in_percent():
    """The fill of a coil is given in percent."""
    coiler(fill=95.0)


@wrong(WINDING, ParameterError, "strip.c = 0 N/m (stiffness)", "greater than 0")
def strip_without_stiffness():
    """An elastic strip has no stiffness."""
    coiler(strip=Strip(c=0.0))


@wrong(WINDING, ParameterError, "path.d = 1 m", "greater than path.r_t = 1.25 m")
def roll_inside_the_turret():
    """The roll before a turret stands inside the circle of its coils."""
    coiler(path=StripPath(r_t=1.25, d=1.0))


# -- gears with loss, and heat -----------------------------------------------------------------

LOSSES = "Gears with loss, and heat"


def hoist(**given):
    """Two bodies joined by a lossy gear."""
    build(
        lambda m: lp.chain(m.motor, m.gear, m.drum),
        motor=Inertia(J=0.1),
        gear=LossyGear(ratio=5.0, **given),
        drum=Inertia(J=2.0),
    )


@wrong(LOSSES, EquationError, "gear (LossyGear)", "while b drives", "10 rad/s", "1.2", "at most 1")
def efficiency_above_one():
    """An efficiency of a loss table is greater than one."""
    hoist(losses=[(0.0, 0.9, 0.9, 0.0, 0.0), (10.0, 0.95, 1.2, 0.0, 0.0)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "while b drives", "is 0;", "greater than 0")
def efficiency_zero():
    """A gear that locks itself is given the efficiency zero."""
    hoist(losses=[(0.0, 0.4, 0.0, 0.0, 0.0)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "bearing friction", "-0.5 N.m", "zero or greater")
def bearing_torque_negative():
    """A bearing torque is given with the sign of a load."""
    hoist(losses=[(0.0, 0.9, 0.9, -0.5, 0.5)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "increase", "20 -> 10 rad/s")
def loss_table_not_increasing():
    """The speeds of a loss table do not increase."""
    hoist(losses=[(0.0, 0.9, 0.9, 0, 0), (20.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "first speed", "-10 rad/s", "zero")
def loss_table_from_negative_speed():
    """A loss table begins at a negative speed."""
    hoist(losses=[(-10.0, 0.9, 0.9, 0, 0), (10.0, 0.9, 0.9, 0, 0)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "five numbers", "bearing friction")
def loss_table_with_short_rows():
    """A row of a loss table holds an efficiency only."""
    hoist(losses=[(0.0, 0.9)])


@wrong(LOSSES, EquationError, "gear (LossyGear)", "'losses.csv'", "five numbers")
def loss_table_from_a_file():
    """The name of a file stands for a loss table."""
    hoist(losses="losses.csv")


@wrong(LOSSES, ParameterError, "gear.eta = 1.1 1", "efficiency", "at most 1")
def efficient_gear_above_one():
    """The efficiency of a gear is greater than one."""
    build(
        lambda m: lp.chain(m.motor, m.gear, m.drum),
        motor=Inertia(J=0.1),
        gear=EfficientGear(ratio=5.0, eta=1.1),
        drum=Inertia(J=2.0),
    )


@wrong(LOSSES, SingularModelError, "gear", "no inertia", "Put an Inertia")
def lossy_gear_between_springs():
    """A lossy gear without inertia stands between elastic shafts."""
    build(
        lambda m: lp.chain(m.motor, m.left, m.gear, m.right, m.drum),
        motor=Inertia(J=0.1),
        left=Spring(c=100.0),
        gear=EfficientGear(ratio=5.0, eta=0.9),
        right=Spring(c=1000.0),
        drum=Inertia(J=2.0),
    )


@wrong(LOSSES, ParameterError, "fan.w_nominal = 0 rad/s", "nominal speed", "greater than 0")
def load_with_nominal_speed_zero():
    """A load has no nominal speed."""
    build(
        lambda m: [lp.connect(m.shaft.flange_b, m.fan.flange)],
        shaft=Inertia(J=0.1),
        fan=QuadraticTorque(tau_nominal=-5.0, w_nominal=0.0),
    )


@wrong(LOSSES, ConnectError, "brake.heat", "not connected")
def eddy_current_brake_without_temperature():
    """An eddy-current brake is given no temperature."""
    build(
        lambda m: [lp.connect(m.shaft.flange_b, m.brake.flange)],
        shaft=Inertia(J=0.1),
        brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0),
    )


@wrong(LOSSES, ConnectError, "brake.heat", "shaft.flange_b", "thermal port", "rotational flange")
def heat_led_into_a_shaft():
    """A thermal port is connected to a flange."""
    build(
        lambda m: [
            lp.connect(m.shaft.flange_b, m.brake.flange),
            lp.connect(m.brake.heat, m.shaft.flange_b),
        ],
        shaft=Inertia(J=0.1),
        brake=EddyCurrentBrake(tau_max=5.0, w_nominal=10.0, e=1.0),
    )


# -- names -------------------------------------------------------------------------------------

NAMES = "Misspelt names"


@wrong(NAMES, UnknownNameError, "Inertia has no 'j'", "J")
def parameter_misspelt_at_construction():
    """A parameter's name is misspelt when a part is made."""
    Inertia(j=1.0)


@wrong(NAMES, UnknownNameError, "stiffness", "c")
def word_instead_of_letter():
    """A word is used instead of the letter."""
    Spring(stiffness=100.0)


@wrong(NAMES, UnknownNameError, "Line has no part 'secnd'", "second")
def part_misspelt_in_with():
    """A part's name is misspelt in with_."""
    Hoist().with_({"line.secnd.J": 1.0})


@wrong(NAMES, UnknownNameError, "discs", "[7]")
def list_index_too_large():
    """A list of parts is asked for a member that it does not have."""
    Hoist().with_({"discs[7].J": 1.0})


@wrong(NAMES, UnknownNameError, "brakes", "middle")
def dictionary_key_unknown():
    """A dictionary of parts is asked for a key that it does not have."""
    Hoist().with_({'brakes["middle"].d': 1.0})


@wrong(NAMES, UnknownNameError, "'discs' holds several parts", "[0], [1]")
def list_without_index():
    """A parameter of a list of parts is set without saying of which."""
    Hoist().with_({"discs.J": 2.0})


@wrong(NAMES, UnknownNameError, "line.first.twist.C", "line.first.twist.c")
def parameter_misspelt_in_a_run():
    """A parameter's name is misspelt in a run."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.twist.C": 1.0})


@wrong(NAMES, UnknownNameError, "line.first.twist.phi", "line.first.twist.phi_rel")
def start_value_misspelt():
    """A start value's name is misspelt."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"line.first.twist.phi": 1.0})


@wrong(NAMES, UnknownNameError, "motor.speed", "motor.w")
def result_misspelt():
    """A result is asked for by a wrong name."""
    lp.simulate(lp.assemble(Hoist()), until=0.01, grid=1)["motor.speed"]


@wrong(NAMES, UnknownNameError, "motor.J", "parameter")
def result_is_a_parameter():
    """A parameter is asked for as a result."""
    lp.simulate(lp.assemble(Hoist()), until=0.01, grid=1)["motor.J"]


@wrong(NAMES, UnknownNameError, "line.first.torque", "line.first.twist.tau")
def output_misspelt_in_assemble():
    """An output's name is misspelt in assemble."""
    lp.assemble(Hoist(), outputs=["line.first.torque"])


@wrong(NAMES, UnknownNameError, "brake.d", 'brakes["left"].d')
def input_misspelt_in_linearise():
    """A parameter's name is misspelt in linearise."""
    lp.linearise(lp.assemble(Hoist()), inputs=["brake.d"], outputs=["motor.w"])


@wrong(NAMES, UnknownNameError, "'discs' has no member [5]")
def list_member_replaced_outside():
    """A member that a list of parts does not have is replaced."""
    Hoist().with_({"discs[5]": Inertia(J=1.0)})


@wrong(NAMES, UnknownNameError, "shaft (Spring) has no 'ratio'")
def quantity_misspelt_in_an_equation():
    """An equation uses a quantity that a part does not have."""

    class Stage(lp.Component):
        """Shaft between two bodies and a law for its torque."""

        motor: Inertia = Inertia(J=1.0)
        shaft: Spring = Spring(c=1.0)
        load: Inertia = Inertia(J=1.0)
        y: lp.Var = lp.var("1", "torque over ratio")

        def connections(self):
            yield from lp.chain(self.motor, self.shaft, self.load)

        def equations(self):
            yield self.y == self.shaft.tau / self.shaft.ratio

    build(stage=Stage())


# -- connections -------------------------------------------------------------------------------

CONNECTIONS = "Ports and connections"


@wrong(CONNECTIONS, ConnectError, "shaft.flange_b", "not connected")
def port_open():
    """The end of a shaft is not connected."""
    build(lambda m: lp.chain(m.motor, m.shaft), motor=Inertia(J=1.0), shaft=Spring(c=1.0))


@wrong(CONNECTIONS, ConnectError, "hoist.line.second.twist.flange_b", "not connected")
def port_open_deep_inside():
    """A port three levels down is not connected."""

    class Half(Shaft):
        """Shaft whose spring has a loose end."""

        def connections(self):
            yield from lp.chain(self.flange_a, self.left, self.twist)
            yield lp.connect(self.right.flange_b, self.flange_b)

    build(hoist=Hoist().with_({"line.second": Half()}))


@wrong(CONNECTIONS, SingularModelError, "line.second", "flange_b", "inside")
def composite_port_not_connected_inside():
    """A composite declares a port and connects nothing to it inside."""

    class Stub(Shaft):
        """Shaft that forgets its second port."""

        def connections(self):
            yield from lp.chain(self.flange_a, self.left, self.twist, self.right)

    lp.assemble(Hoist().with_({"line.second": Stub()}))


@wrong(CONNECTIONS, ConnectError, "line.first.twist.flange_a", "direct parts")
def port_of_a_grandchild():
    """A model connects to a port of a part of its part."""
    build(
        lambda m: [
            *lp.chain(m.motor, m.line, m.load),
            lp.connect(m.brake.flange_b, m.line.first.twist.flange_a),
            lp.connect(m.brake.flange_a, m.wall.flange),
        ],
        motor=Inertia(J=1.0),
        line=Line(),
        load=Inertia(J=1.0),
        brake=Damper(d=1.0),
        wall=Fixed(),
    )


@wrong(CONNECTIONS, ConnectError, "Crane", "IdealGear", "direct parts")
def part_of_another_model():
    """A model is connected to a part that was made outside of it."""
    gear = IdealGear(ratio=2.0)

    class Crane(lp.Component):
        """Connects what is not its own."""

        motor: Inertia = Inertia(J=1.0)

        def connections(self):
            yield from lp.chain(self.motor, gear)

    lp.assemble(Crane())


@wrong(CONNECTIONS, ConnectError, "rotational flange", "translational flange", "rack and pinion")
def rotation_on_translation():
    """A shaft is connected to a sliding mass."""
    build(lambda m: lp.chain(m.shaft, m.slide), shaft=Inertia(J=1.0), slide=translation.Mass(m=1.0))


@wrong(CONNECTIONS, ConnectError, "motor.p (electrical pin)", "rotor.flange_a (rotational flange)")
def pin_on_a_flange():
    """An electric pin is connected to a shaft."""
    build(
        lambda m: [lp.connect(m.motor.p, m.rotor.flange_a)],
        motor=Machine(),
        rotor=Inertia(J=1.0),
    )


@wrong(CONNECTIONS, ConnectError, "command.y (signal)", "rotor.flange_a (rotational flange)")
def signal_on_a_flange():
    """A signal is connected to a flange instead of to the input of a source."""
    build(
        lambda m: [lp.connect(m.command.y, m.rotor.flange_a)],
        command=Constant(k=1.0),
        rotor=Inertia(J=1.0),
    )


@wrong(CONNECTIONS, ConnectError, "sensor.w (signal)", "load.flange_a (rotational flange)")
def signal_of_a_sensor_on_a_shaft():
    """The output of a speed sensor is connected to the next shaft."""
    build(
        lambda m: [*lp.chain(m.motor, m.sensor), lp.connect(m.sensor.w, m.load.flange_a)],
        motor=Inertia(J=1.0),
        sensor=SpeedSensor(),
        load=Inertia(J=1.0),
    )


@wrong(CONNECTIONS, ConnectError, "motor (Inertia)", "flange_a, flange_b")
def part_instead_of_port():
    """A part is connected, not one of its ports."""
    build(
        lambda m: [lp.connect(m.motor, m.shaft.flange_a)],
        motor=Inertia(J=1.0),
        shaft=Spring(c=1.0),
    )


@wrong(CONNECTIONS, ConnectError, "'motor.w'", "ports and signals")
def variable_instead_of_port():
    """A variable of a body is connected to the input of a source."""
    build(
        lambda m: [lp.connect(m.motor.w, m.drive.tau)],
        motor=Inertia(J=1.0),
        drive=Torque(),
    )


@wrong(CONNECTIONS, ConnectError, "Planetary set", "'flange_a'", "sun, carrier, ring")
def planetary_in_a_chain():
    """A chain runs through a planetary gear, which has no flange_a."""
    build(
        lambda m: lp.chain(m.motor, m.set, m.load),
        motor=Inertia(J=1.0),
        set=Planetary(ratio=2.0),
        load=Inertia(J=1.0),
    )


@wrong(CONNECTIONS, ConnectError, "motor.flange_b", "at least two ports")
def one_end_only():
    """A connection has a single end."""
    build(lambda m: [lp.connect(m.motor.flange_b)], motor=Inertia(J=1.0))


@wrong(CONNECTIONS, EquationError, "Drive", "connections", "yield")
def connections_return_ports():
    """connections() yields a pair of ports without connect."""

    class Drive(lp.Component):
        """Pairs instead of connections."""

        motor: Inertia = Inertia(J=1.0)
        shaft: Spring = Spring(c=1.0)

        def connections(self):
            yield self.motor.flange_b, self.shaft.flange_a

    lp.assemble(Drive())


@wrong(CONNECTIONS, DeclarationError, "left", "right", "same Inertia object")
def same_object_twice():
    """The same object stands for two parts."""
    wheel = Inertia(J=1.0)
    lp.compose(left=wheel, right=wheel)


@wrong(CONNECTIONS, DeclarationError, "wheels[0]", "wheels[1]", "same Inertia object")
def list_multiplied():
    """A list of parts is made by multiplication."""
    lp.compose(wheels=[Inertia(J=1.0)] * 4)


@wrong(CONNECTIONS, DeclarationError, "Drive.motor", "parentheses")
def class_instead_of_part():
    """A class stands where a part must, without parentheses."""

    class Drive(lp.Component):
        """Forgotten parentheses."""

        motor: Inertia = Inertia


@wrong(CONNECTIONS, DeclarationError, "J of motor (Inertia)", "with_")
def assignment_to_a_part():
    """A parameter of a finished part is assigned."""
    Hoist().motor.J = 2.0


# -- signals -----------------------------------------------------------------------------------

SIGNALS = "Signals"


@wrong(SIGNALS, ConnectError, "motor.tau", "no source", "tau=")
def input_without_source():
    """A torque source gets no torque."""
    build(lambda m: lp.chain(m.motor, m.rotor), motor=Torque(), rotor=Inertia(J=1.0))


@wrong(SIGNALS, ConnectError, "motor.tau", "one.y", "two.y", "2 sources")
def input_with_two_sources():
    """Two signals feed one input."""
    build(
        lambda m: [
            *lp.chain(m.motor, m.rotor),
            lp.connect(m.one.y, m.motor.tau),
            lp.connect(m.two.y, m.motor.tau),
        ],
        motor=Torque(),
        rotor=Inertia(J=1.0),
        one=Constant(k=1.0),
        two=Constant(k=2.0),
    )


@wrong(SIGNALS, ConnectError, "motor.tau", "connected and given")
def input_connected_and_given():
    """An input is given a number and connected."""
    build(
        lambda m: [*lp.chain(m.motor, m.rotor), lp.connect(m.one.y, m.motor.tau)],
        motor=Torque(tau=3.0),
        rotor=Inertia(J=1.0),
        one=Constant(k=1.0),
    )


@wrong(SIGNALS, ConnectError, "left.tau", "right.tau", "no source")
def inputs_joined_only():
    """Two inputs are joined, and nothing feeds them."""
    build(
        lambda m: [
            *lp.chain(m.left, m.rotor, m.right),
            lp.connect(m.left.tau, m.right.tau),
        ],
        left=Torque(),
        rotor=Inertia(J=1.0),
        right=Torque(),
    )


@wrong(SIGNALS, ConnectError, "one.y", "two.y", "2 sources")
def two_outputs_joined():
    """Two outputs are connected to each other."""
    build(
        lambda m: [lp.connect(m.one.y, m.two.y)],
        one=Constant(k=1.0),
        two=Constant(k=2.0),
    )


@wrong(SIGNALS, SingularModelError, "control (Control)", "y == 2 * time", "too many")
def output_driven_twice():
    """An output is connected inside and has an equation too."""

    class Control(lp.Component):
        """Constant command with a second law."""

        inner: Constant = Constant(k=1.0)
        y = lp.Output("N.m", "command")

        def connections(self):
            yield lp.connect(self.inner.y, self.y)

        def equations(self):
            yield self.y == 2 * lp.time

    build(
        lambda m: [*lp.chain(m.motor, m.rotor), lp.connect(m.control.y, m.motor.tau)],
        control=Control(),
        motor=Torque(),
        rotor=Inertia(J=1.0),
    )


@wrong(SIGNALS, SingularModelError, "control (Control)", "its y must be determined")
def output_not_driven():
    """An output of a composite is neither connected inside nor computed."""

    class Control(lp.Component):
        """Forgets its output."""

        inner: Constant = Constant(k=1.0)
        y = lp.Output("N.m", "command")

    build(
        lambda m: [*lp.chain(m.motor, m.rotor), lp.connect(m.control.y, m.motor.tau)],
        control=Control(),
        motor=Torque(),
        rotor=Inertia(J=1.0),
    )


@wrong(SIGNALS, DeclarationError, "SpeedSensor(w=", "output")
def output_given():
    """The output of a sensor is given a value."""
    SpeedSensor(w=1.0)


@wrong(SIGNALS, ConnectError, "sensor.flange", "not connected")
def sensor_not_attached():
    """A sensor's signal is used, but its flange is not connected."""
    build(
        lambda m: [*lp.chain(m.motor, m.rotor), lp.connect(m.sensor.w, m.motor.tau)],
        motor=Torque(),
        rotor=Inertia(J=1.0),
        sensor=SpeedSensor(),
    )


@wrong(SIGNALS, SingularModelError, "one, two only repeat each other")
def signals_in_a_circle():
    """Two signals are each the other: an algebraic loop that determines nothing."""

    class Follow(lp.Component):
        """Repeats its input."""

        u = lp.Input("1", "in")
        y = lp.Output("1", "out")

        def equations(self):
            yield self.y == self.u

    build(
        lambda m: [lp.connect(m.one.y, m.two.u), lp.connect(m.two.y, m.one.u)],
        one=Follow(),
        two=Follow(),
    )


# -- friction ----------------------------------------------------------------------------------

FRICTION = "Friction"


def rubbing(characteristic=((0, 1),), **values):
    """Assemble a shaft in a bearing of this friction."""
    build(
        lambda m: lp.chain(m.motor, m.bearing),
        motor=Inertia(J=1.0),
        bearing=BearingFriction(characteristic=characteristic, **values),
    )


@wrong(FRICTION, EquationError, "bearing (BearingFriction)", "characteristic", "rows")
def bearing_without_friction():
    """A bearing friction is given no characteristic."""
    rubbing(())


@wrong(FRICTION, EquationError, "bearing", "-5", "first row", "speed 0")
def characteristic_of_negative_speeds():
    """A characteristic is measured in both directions."""
    rubbing(((-5, -1.2), (0, 1.0), (5, 1.2)))


@wrong(FRICTION, EquationError, "bearing", "must increase", "10 -> 10")
def characteristic_with_a_jump():
    """A characteristic jumps at a sliding speed."""
    rubbing(((0, 1.0), (10, 0.8), (10, 0.5)))


@wrong(FRICTION, EquationError, "bearing", "-0.2", "speed 20", "against the motion")
def characteristic_that_drives():
    """A characteristic falls below zero."""
    rubbing(((0, 1.0), (20, -0.2)))


@wrong(FRICTION, EquationError, "bearing", "rows of two numbers")
def characteristic_in_columns():
    """A characteristic is given as columns instead of rows."""
    rubbing(((0, 10, 50), (1.0, 0.8, 0.7)))


@wrong(FRICTION, EquationError, "bearing", "-3", "standstill", "against the motion")
def characteristic_of_the_wrong_sign():
    """A characteristic is a function with the wrong sign."""
    rubbing(lambda w: -3 - 0.1 * w)


@wrong(FRICTION, EquationError, "bearing", "static = 2", "at least coulomb")
def stribeck_curve_upside_down():
    """The friction of a Stribeck curve is smaller at standstill."""
    rubbing(Stribeck(coulomb=3.0, static=2.0, decay=1.0))


@wrong(FRICTION, ParameterError, "journal.mu = -0.15 1", "journal.d = 0 m")
def journal_that_drives():
    """A journal has a negative friction coefficient and no diameter."""
    build(
        lambda m: lp.chain(m.motor, m.journal),
        motor=Inertia(J=1.0),
        journal=JournalFriction(mu=-0.15, d=0.0, f_n=100.0),
    )


@wrong(FRICTION, ParameterError, "bearing.peak = 0.8", "at least 1")
def peak_below_one():
    """Static friction is said to be smaller than kinetic friction."""
    rubbing(peak=0.8)


@wrong(FRICTION, ParameterError, "clutch.f_max = -500 N", "at least 0", "clutch.c_geo = -0.1 m")
def clutch_pulled_apart():
    """The normal force and the geometry of a clutch are negative."""
    build(
        lambda m: lp.chain(m.motor, m.clutch, m.load),
        motor=Inertia(J=1.0),
        clutch=Clutch(f_max=-500.0, c_geo=-0.1, u=1.0),
        load=Inertia(J=1.0),
    )


@wrong(FRICTION, SingularModelError, "clutch", "no inertia", "Inertia or Mass on each side")
def clutch_without_a_body_on_one_side():
    """A clutch drives a shaft without inertia."""
    build(
        lambda m: lp.chain(m.motor, m.clutch, m.shaft, m.load),
        motor=Inertia(J=1.0),
        clutch=Clutch(f_max=10.0, u=1.0),
        shaft=Spring(c=100.0),
        load=Inertia(J=1.0),
    )


@wrong(FRICTION, ConnectError, "brake.u", "normal force")
def brake_that_nobody_presses():
    """The normal force of a brake is not given."""
    build(
        lambda m: lp.chain(m.motor, m.brake),
        motor=Inertia(J=1.0),
        brake=friction.Brake(f_max=10.0),
    )


# -- electric drives ---------------------------------------------------------------------------

DRIVES = "Electric drives"


@wrong(FRICTION, SingularModelError, "first, second hold and slide without inertia", "Inertia")
def two_clutches_in_a_row():
    """Two clutches stand in a row with nothing between them."""
    build(
        lambda m: lp.chain(m.motor, m.first, m.second, m.load),
        motor=Inertia(J=1.0),
        first=Clutch(f_max=10.0, u=1.0),
        second=Clutch(f_max=10.0, u=1.0),
        load=Inertia(J=1.0),
    )


def fed(motor):
    """Assemble a motor on a battery."""
    return build(
        lambda m: [
            lp.connect(m.battery.p, m.motor.p),
            lp.connect(m.battery.n, m.motor.n, m.ground.pin),
        ],
        battery=VoltageSource(v=48.0),
        motor=motor,
        ground=Ground(),
    )


@wrong(DRIVES, ParameterError, "motor.L = 0 H", "QuasiStaticDCMotor", "greater than 0")
def motor_without_inductance():
    """A motor is given no inductance."""
    fed(DCMotor(k=0.5, R=0.2, L=0.0, J=0.01))


@wrong(DRIVES, ParameterError, "motor.R = 0 Ohm", "greater than 0")
def motor_without_inductance_and_resistance():
    """A motor has neither inductance nor resistance, so that nothing limits its current."""
    fed(QuasiStaticDCMotor(k=0.5, R=0.0, J=0.01))


@wrong(DRIVES, ParameterError, "motor.w_s = 0 rad/s", "motor.tau_k = -60 N.m", "motor.s_k = 1.2 1")
def induction_motor_out_of_range():
    """A torque curve of Kloss is given impossible values."""
    build(motor=InductionMotor(w_s=0.0, tau_k=-60.0, s_k=1.2, J=0.05))


@wrong(
    DRIVES, SingularModelError, "bus.v = 48", "battery.v = 24", "at bus.p = battery.p", "resistor"
)
def two_sources_of_voltage_in_parallel():
    """Two ideal sources of voltage feed the same wires."""
    build(
        lambda m: [
            lp.connect(m.bus.p, m.battery.p),
            lp.connect(m.bus.n, m.battery.n, m.ground.pin),
        ],
        bus=VoltageSource(v=48.0),
        battery=VoltageSource(v=24.0),
        ground=Ground(),
    )


@wrong(DRIVES, SingularModelError, "source.v = 48", "source.p = source.n", "Likely", "resistor")
def source_short_circuited():
    """Both pins of an ideal source of voltage are on the ground."""
    build(
        lambda m: [lp.connect(m.source.p, m.source.n, m.ground.pin)],
        source=VoltageSource(v=48.0),
        ground=Ground(),
    )


@wrong(DRIVES, SingularModelError, "left.pin.v = 0", "right.pin.v = 0", "Remove one")
def grounded_twice():
    """Two grounds are on one wire."""
    build(
        lambda m: [
            lp.connect(m.source.p, m.load.p),
            lp.connect(m.source.n, m.load.n, m.left.pin, m.right.pin),
        ],
        source=VoltageSource(v=48.0),
        load=Resistor(),
        left=Ground(),
        right=Ground(),
    )


@wrong(DRIVES, ParameterError, "pi.y_max = -12 1", "greater than pi.y_min = 12 1")
def limits_crossed():
    """The limits of a controller are in the wrong order."""
    build(pi=LimitedPI(k=2.0, T_i=0.1, y_min=12.0, y_max=-12.0, wanted=1.0, measured=0.0))


@wrong(DRIVES, ParameterError, "safety.static = 30 N.m", "at least safety.kinetic = 50 N.m")
def limits_of_a_slip_coupling_exchanged():
    """A coupling holds less at rest than it carries while it slips."""
    build(
        motor=Inertia(J=1.0),
        safety=SlipCoupling(static=30.0, kinetic=50.0, u=1.0),
        load=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.motor, m.safety, m.load),
    )


@wrong(DRIVES, ParameterError, "switch.off = 1 1", "greater than switch.on = 2 1")
def latch_that_opens_before_it_closes():
    """A position switch opens before it closes."""
    build(switch=Latch(on=2.0, off=1.0, u=0.0))


@wrong(DRIVES, EquationError, "profile (SpeedProfile)", "increase", "3 -> 2")
def sections_in_the_wrong_order():
    """The sections of a speed profile are not in the order of the way."""
    build(profile=SpeedProfile(sections=((0.0, 0.2), (3.0, 1.0), (2.0, 0.2)), a=1.0, u=0.0))


@wrong(DRIVES, EquationError, "profile (SpeedProfile)", "speed -0.2", "not negative")
def section_for_the_way_back():
    """A speed profile is to serve for the way back, too."""
    build(profile=SpeedProfile(sections=((0.0, 1.0), (3.0, -0.2)), a=1.0, u=0.0))


@wrong(DRIVES, ParameterError, "pi.k = -2 1 (gain)", "pi.T_s = 0 s (sampling time)")
def sampling_time_of_zero():
    """A controller has a negative gain and samples without end."""
    build(pi=SampledPI(k=-2.0, T_i=0.1, T_s=0.0, wanted=1.0, measured=0.0))


@wrong(DRIVES, ParameterError, "motor.L_ls = 0 H", "leakage", "motor.pairs = 0 1 (pole pairs)")
def cage_without_leakage():
    """A squirrel-cage motor has no leakage and no pole pairs."""
    build(
        motor=SquirrelCageMotor(
            R_s=0.4, R_r=0.8, L_m=0.07, L_ls=0.0, L_lr=2e-3, pairs=0.0, J=0.1, V=180.0, f=50.0
        )
    )


@wrong(DRIVES, ConnectError, "motor.f: the input (frequency of the supply, Hz)")
def cage_without_frequency():
    """A squirrel-cage motor is given a voltage but no frequency."""
    build(
        motor=SquirrelCageMotor(
            R_s=0.4, R_r=0.8, L_m=0.07, L_ls=2e-3, L_lr=2e-3, pairs=2.0, J=0.1, V=180.0
        )
    )


@wrong(DRIVES, ParameterError, "servo.psi = 0 V.s", "magnets", "servo.L_q = -0.004 H")
def servo_without_magnets():
    """A synchronous motor has no magnets and a negative inductance."""
    build(
        servo=SynchronousMotor(
            psi=0.0, R=0.3, L_d=4e-3, L_q=-4e-3, pairs=3.0, J=0.01, v_d=0.0, v_q=20.0
        )
    )


@wrong(DRIVES, ParameterError, "axis.v_max = -2 1/s", "axis.a = 0 1/s2", "greater than 0")
def cascade_with_negative_limits():
    """A cascade control has a negative limit of the speed and no deceleration."""
    loop = {"wanted": 1.0, "measured": 0.0, "v_measured": 0.0, "v_feed": 0.0, "f_feed": 0.0}
    build(axis=CascadeControl(K=5.0, a=0.0, v_max=-2.0, k=10.0, T_i=0.1, f_max=8.0, **loop))


@wrong(DRIVES, EquationError, "order (PositionSequencer)", "targets = (0.5, None)", "finite number")
def target_that_is_none():
    """A sequence of positions holds something that is no number."""
    build(
        order=PositionSequencer(targets=(0.5, None), tolerance=0.01, dwell=0.2, measured=0.0),
    )


@wrong(DRIVES, ParameterError, "order.tolerance = 0 1", "order.dwell = -1 s", "greater than 0")
def sequence_without_tolerance():
    """A sequence of positions wants them exactly, and a negative dwell."""
    build(order=PositionSequencer(targets=(0.5,), tolerance=0.0, dwell=-1.0, measured=0.0))


# -- own components ----------------------------------------------------------------------------

OWN = "Equations of own components"


class Brake(lp.Component):
    """Brake whose law a test supplies."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "damping", 2.0)
    w: lp.Var = lp.var("rad/s", "speed")


def braked(law):
    """Assemble a rotor with a brake of this law."""
    kind = type("Brake", (Brake,), {"__doc__": "Brake under test.", "equations": law})
    return build(lambda m: lp.chain(m.rotor, m.brake), rotor=Inertia(J=1.0, w=1.0), brake=kind())


@wrong(OWN, SingularModelError, "brake (Brake) brings 1 equation", "needs 2", "w", "flange")
def equation_missing():
    """A component has an equation too few."""

    def law(self):
        yield self.flange.tau == self.d * self.w

    braked(law)


@wrong(OWN, SingularModelError, "brake (Brake) brings 3 equations but needs 2", "too many")
def equation_surplus():
    """A component has an equation too many."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.d * self.w
        yield self.flange.tau == 5.0

    braked(law)


@wrong(OWN, SingularModelError, "in brake", "equations of brake (Brake)", "twice")
def equation_twice():
    """A component states one law twice and forgets another: the count is right."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield 2 * self.w == 2 * lp.der(self.flange.phi)

    braked(law)


@wrong(OWN, SingularModelError, "brake.w = brake.w", "no unknown is left", "cancel")
def equation_of_itself():
    """A quantity is said to equal itself."""

    def law(self):
        yield self.w == self.w
        yield self.flange.tau == self.d * lp.der(self.flange.phi)

    braked(law)


@wrong(OWN, EquationError, "brake (Brake)", "must be an equation")
def expression_instead_of_equation():
    """An equation is written as an expression that should be zero."""

    def law(self):
        yield self.w - lp.der(self.flange.phi)
        yield self.flange.tau == self.d * self.w

    braked(law)


@wrong(OWN, EquationError, "brake", "w", "where")
def if_on_a_variable():
    """A law is chosen by `if` on a variable."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        if self.w > 0:
            yield self.flange.tau == self.d
        else:
            yield self.flange.tau == -self.d

    braked(law)


@wrong(OWN, EquationError, "brake", "lumped.ops")
def math_function():
    """A function of math is applied to a variable."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.d * math.sin(self.w)

    braked(law)


@wrong(OWN, EquationError, "brake", "w == der(flange.phi)", "two equations")
def chained_equations():
    """Two equations are written in one: a == b == c."""

    def law(self):
        yield self.w == lp.der(self.flange.phi) == self.flange.tau / self.d

    braked(law)


@wrong(OWN, SolverError, "changes of mode within", "t = 0.5 s", "in brake", "lumped.hold")
def friction_by_the_sign_of_a_speed():
    """Dry friction is written with a condition on the speed, so that it cannot stick."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == lp.ops.where(self.w >= 0, self.d, -self.d)

    lp.simulate(braked(law), until=5.0)


@wrong(OWN, StartError, "no values of brake.w meet", "t = 0 s", "start values")
def implicit_equation_without_solution():
    """A quantity is given only implicitly, by an equation that no value of it fulfils."""

    def law(self):
        yield lp.der(self.flange.phi) == self.w**2 + 2.0
        yield self.flange.tau == self.d * self.w

    lp.simulate(braked(law), until=1.0)


@wrong(OWN, EquationError, "cart (Cart)", "uses w", "Inertia")
def part_of_a_stranger_in_an_equation():
    """An equation uses a quantity of a component that is not below it."""
    wheel = Inertia(J=1.0)

    class Cart(lp.Component):
        """Speed from a foreign wheel."""

        axle: Inertia = Inertia(J=1.0)
        v: lp.Var = lp.var("m/s", "velocity")

        def equations(self):
            yield self.v == 0.3 * wheel.w

    build(cart=Cart())


@wrong(OWN, EquationError, "gear", "left side")
def lossless_without_an_explicit_angle():
    """The kinematics of a lossless part have no angle alone on the left."""

    class Gear(lp.Component):
        """Gear of ratio 2, the other way round."""

        flange_a = lp.Flange()
        flange_b = lp.Flange()

        def equations(self):
            a, b = self.flange_a, self.flange_b
            yield lp.lossless(2 * b.phi == a.phi, a, b)

    build(lambda m: lp.chain(m.a, m.gear, m.b), a=Inertia(J=1.0), gear=Gear(), b=Inertia(J=1.0))


@wrong(NAMES, UnknownNameError, "line.first (Shaft) has no 'axle'")
def part_of_a_part_misnamed():
    """An equation uses a part of a part that does not exist."""

    class Cart(Hoist):
        """Speed from a part misnamed."""

        v: lp.Var = lp.var("m/s", "velocity")

        def equations(self):
            yield self.v == 0.3 * self.line.first.axle.w

    build(cart=Cart())


@wrong(
    NAMES,
    UnknownNameError,
    "Brake.flange (rotational flange) has no 'w'",
    "phi and tau",
    "der(flange.phi)",
)
def speed_of_a_flange():
    """An equation uses the speed of a flange, which has an angle and a torque only."""
    braked(lambda self: [self.flange.tau == self.d * self.flange.w])


@wrong(OWN, EquationError, "brake (Brake)", "yield a == b")
def equations_return_nothing():
    """equations() returns nothing: yield was forgotten."""

    def law(self):
        self.w == lp.der(self.flange.phi)  # noqa: B015

    braked(law)


@wrong(OWN, EquationError, "brake (Brake)", "der(d)", "a parameter is constant")
def derivative_of_a_parameter():
    """The derivative of a parameter is taken."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.d * self.w + lp.der(self.d)

    braked(law)


@wrong(OWN, EquationError, "brake (Brake)", "numpy.sin", "lumped.ops")
def numpy_function():
    """A function of NumPy is applied to a variable."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.d * np.sin(self.w)

    braked(law)


# -- start values ------------------------------------------------------------------------------

START = "Start values"


@wrong(START, StartError, "motor.w = 10", "load.w = 10")
def speeds_against_a_gear():
    """The start speeds on both sides of a gear do not fit its ratio."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.motor, m.gear, m.load),
            motor=Inertia(J=1.0, w=10.0),
            gear=IdealGear(ratio=2.0),
            load=Inertia(J=1.0, w=10.0),
        )
    )


@wrong(START, StartError, "motor.w = 10", "load.w = 12")
def speeds_against_a_rigid_coupling():
    """Two rigidly joined rotors start at different speeds."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.motor, m.load),
            motor=Inertia(J=1.0, w=10.0),
            load=Inertia(J=1.0, w=12.0),
        )
    )


@wrong(
    START,
    StartError,
    "rotor.w = 5",
    "sources",
)
def speed_of_a_held_body():
    """A body that a support holds starts with a speed."""
    lp.start_point(
        build(lambda m: lp.chain(m.wall, m.rotor), wall=Fixed(), rotor=Inertia(J=1.0, w=5.0))
    )


@wrong(START, StartError, "rotor.phi = 1", "make it 0")
def angle_of_a_held_body():
    """A body starts at another angle than that of its support."""
    lp.start_point(
        build(lambda m: lp.chain(m.wall, m.rotor), wall=Fixed(), rotor=Inertia(J=1.0, phi=1.0))
    )


@wrong(
    START,
    StartError,
    "rotor.w = 5",
    "sources",
)
def speed_against_a_speed_source():
    """A body on a speed source starts at another speed."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.motor, m.rotor),
            motor=Speed(w=10.0),
            rotor=Inertia(J=1.0, w=5.0),
        )
    )


@wrong(START, StartError, "s_1.phi_rel", "s_2.phi_rel", "s_3.phi_rel")
def twists_around_a_loop():
    """The start twists of three springs around a closed loop do not add up to zero."""
    lp.start_point(
        build(
            lambda m: [*lp.chain(m.a, m.s_1, m.b, m.s_2, m.c, m.s_3, m.a)],
            a=Inertia(J=1.0),
            b=Inertia(J=1.0),
            c=Inertia(J=1.0),
            s_1=Spring(c=1.0, phi_rel=0.1),
            s_2=Spring(c=1.0, phi_rel=0.1),
            s_3=Spring(c=1.0, phi_rel=0.1),
        )
    )


@wrong(START, StartError, "shaft.tau = 50", "shaft.phi_rel = 0")
def torque_against_twist():
    """A spring starts with a torque and a twist that do not fit."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.a, m.shaft, m.b),
            a=Inertia(J=1.0),
            shaft=Spring(c=100.0, tau=50.0, phi_rel=0.0),
            b=Inertia(J=1.0),
        )
    )


@wrong(START, StartError, "body.a = 3", "make it 1")
def acceleration_given():
    """A body starts with an acceleration other than what the torques give."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.drive, m.body), drive=Torque(tau=1.0), body=Inertia(J=1.0, a=3.0)
        )
    )


@wrong(START, StartError, "motor.w = nan", "finite")
def start_value_nan():
    """A start value is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": math.nan})


@wrong(START, UnitError, "motor.w", "'fast'")
def start_value_text():
    """A start value is a text."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": "fast"})


def turning(law, **changes):
    """Motor, shaft and load with initial equations."""
    return build(
        lambda m: lp.chain(m.motor, m.shaft, m.load),
        motor=Inertia(J=1.0, w=10.0),
        shaft=Spring(c=100.0),
        load=Inertia(J=2.0),
        initial_equations=law,
        **changes,
    )


@wrong(START, StartError, "Too much", "der(motor.w) = 0 in Model", "shaft.c * shaft.phi_rel = 5")
def initial_equations_too_many():
    """Two initial equations ask for the same twist."""
    lp.start_point(
        turning(
            lambda m: [lp.der(m.motor.w) == 0, m.shaft.c * m.shaft.phi_rel == 5],
        )
    )


@wrong(START, StartError, "load.w = 2 * motor.w in Model", "motor.w = 10", "load.w = 5")
def initial_equation_against_start_values():
    """An initial equation does not fit the start values."""
    lp.start_point(turning(lambda m: [m.load.w == 2 * m.motor.w]), start={"load.w": 5.0})


@wrong(START, StartError, "der(rotor.w) = 0 in rotor (Steady)", "no state", "differ by 3")
def initial_equation_that_nothing_meets():
    """A body shall start without acceleration, but a torque acts on it and nothing else."""

    class Steady(Inertia):
        """Inertia that starts steadily."""

        def initial_equations(self):
            yield lp.der(self.w) == 0

    lp.start_point(
        build(lambda m: lp.chain(m.drive, m.rotor), drive=Torque(tau=6.0), rotor=Steady(J=2.0))
    )


@wrong(START, StartError, "No start state", "load.w**2 = -1 in Model")
def initial_equation_without_solution():
    """An initial equation has no solution."""
    lp.start_point(turning(lambda m: [m.load.w**2 == -1]))


@wrong(START, StartError, "shaft.c", "not determined", "initial equation")
def free_parameter_undetermined():
    """A free parameter has no start value that depends on it."""
    lp.start_point(turning(lambda m: [m.load.w == 5]), free=["shaft.c"])


@wrong(START, EquationError, "Steady", "initial_equations() gave nothing back")
def initial_equations_returned_nothing():
    """Initial equations are written without yield."""

    class Steady(Inertia):
        """Inertia without a word."""

        def initial_equations(self):
            lp.der(self.w) == 0  # noqa: B015

    build(lambda m: lp.chain(m.drive, m.rotor), drive=Torque(tau=6.0), rotor=Steady(J=2.0))


@wrong(START, EquationError, "w of a component Inertia", "not one of its parts")
def initial_equation_of_a_stranger():
    """An initial equation names a part of no model."""
    stranger = Inertia(J=1.0)
    turning(lambda m: [m.load.w == stranger.w])


@wrong(START, StartError, "wheel.w = 5 rad/s", "at rest (together=True)", "fewer start values")
def together_with_two_speeds():
    """Parts shall move together, and two of them are given different speeds."""
    lp.start_point(
        build(
            lambda m: lp.chain(m.motor, m.shaft, m.wheel),
            motor=Inertia(J=1.0, w=10.0),
            shaft=Spring(c=1e3),
            wheel=Inertia(J=2.0, w=5.0),
        ),
        together=True,
    )


class Contrary(lp.Component):
    """A signal above zero for a state below it, and the other way round."""

    x: lp.Var = lp.var("1", "state")
    y: lp.Var = lp.var("1", "signal")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y == self.x - lp.ops.where(self.x < 0.0, 1.0, -1.0)


@wrong(START, StartError, "part.y = 0 1", "positions of conditions", "demand less")
def start_in_no_position():
    """A start value holds on neither side of a condition."""
    lp.start_point(build(lambda m: [], part=Contrary()), start={"part.y": 0.0})


@wrong(START, OptionError, "start = Model at t = 2 s", "names as keys")
def derivatives_from_a_point():
    """Derivatives of a run that goes on from a point."""
    system = braked_drive()
    of = [lp.functionals.final("rotor.w")]
    lp.gradient(system, of=of, until=3.0, start=lp.start_point(system, time=2.0))


# -- equilibria --------------------------------------------------------------------------------

STEADY = "Equilibria"


@wrong(START, UnknownNameError, "'drive.tau' is no parameter", "3 * sin(time)", "give a number")
def a_free_expression():
    """A torque that is given as an expression shall be found by the start values."""
    system = build(
        lambda m: lp.chain(m.drive, m.rotor),
        drive=Torque(tau=3 * lp.ops.sin(lp.time)),
        rotor=Inertia(J=1.0, a=2.0),
    )
    lp.simulate(system, until=1.0, free=["drive.tau"])


def braked_drive():
    """A motor against a damper."""
    return build(
        lambda m: lp.chain(m.drive, m.rotor, m.brake, m.wall),
        drive=Torque(tau=6.0),
        rotor=Inertia(J=2.0),
        brake=Damper(d=0.5),
        wall=Fixed(),
    )


@wrong(STEADY, SolverError, "no rest", "der(rotor.w) stays at 3", "springs or supports")
def rest_of_a_driven_shaft():
    """A driven shaft that only a damper holds shall rest."""
    lp.equilibrium(braked_drive(), rest=True)


@wrong(STEADY, SolverError, "no rest", "rotor.w = 10 rad/s", "sources of motion")
def rest_on_a_speed_source():
    """A body on a speed source shall rest."""
    lp.equilibrium(
        build(
            lambda m: lp.chain(m.motor, m.rotor),
            motor=Speed(w=10.0),
            rotor=Inertia(J=1.0),
        ),
        rest=True,
    )


@wrong(STEADY, StartError, "rotor.w = 4 rad/s", "rest")
def rest_with_a_speed():
    """Rest is asked for, and a speed."""
    lp.equilibrium(braked_drive(), rest=True, start={"rotor.w": 4.0})


@wrong(STEADY, StartError, "drive.tau, brake.d", "speed")
def equilibrium_with_too_many_free_parameters():
    """The torque and the load are both free."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["drive.tau", "brake.d"])


@wrong(STEADY, SolverError, "no equilibrium", "der(rotor.w)", "free")
def equilibrium_with_a_useless_free_parameter():
    """The free parameter does not change the balance of torques."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["rotor.J"])


# -- runs --------------------------------------------------------------------------------------

RUNS = "Runs"


@wrong(RUNS, OptionError, "until = -1")
def until_negative():
    """A run ends before it starts."""
    lp.simulate(lp.assemble(Hoist()), until=-1.0)


@wrong(RUNS, OptionError, "simulate: system = Model()", "assemble it first")
def simulate_a_model():
    """A model is simulated before it is assembled."""
    lp.simulate(lp.compose(rotor=Inertia(J=1.0)), until=1.0)


@wrong(RUNS, OptionError, "linearise: inputs = 'drive.tau'", "Write ['drive.tau']")
def a_text_for_a_list():
    """One input is named without the brackets of a list."""
    system = build(
        lambda m: lp.chain(m.drive, m.rotor), drive=Torque(tau=1.0), rotor=Inertia(J=1.0)
    )
    lp.linearise(system, inputs="drive.tau")


@wrong(RUNS, OptionError, "simulate: no option 'untill'", "Nearest: until")
def an_option_that_does_not_exist():
    """An option is misspelt."""
    lp.simulate(build(rotor=Inertia(J=1.0)), untill=1.0)


@wrong(RUNS, OptionError, "modes: at belongs to another system")
def a_point_of_another_system():
    """An operating point of one system is given to another."""
    first, second = build(rotor=Inertia(J=1.0)), build(rotor=Inertia(J=1.0))
    lp.modes(first, at=lp.start_point(second))


@wrong(RUNS, OptionError, "Inertia", "parentheses")
def assemble_a_class():
    """The class is assembled, not an instance."""
    lp.assemble(Inertia)


@wrong(RUNS, SolverError, "drum.phi would have to jump", "0.5 s")
def prescribed_jump():
    """A prescribed angle jumps, and a rigid body would have to follow."""
    step = lp.ops.where(lp.time >= 0.5, 1.0, 0.0)
    system = build(
        lambda m: lp.chain(m.servo, m.drum), servo=Position(phi=step), drum=Inertia(J=1.0)
    )
    lp.simulate(system, until=1.0)


class Point(lp.Component):
    """Motion with a law that a test supplies."""

    x: lp.Var = lp.var("m", "position")
    y: lp.Var = lp.var("m", "distance")


def moved(law, **start):
    kind = type("Point", (Point,), {"__doc__": "Point under test.", "equations": law})
    return build(part=kind(**start))


@wrong(RUNS, SolverError, "part.x", "not a finite number", "t = 0 s")
def division_by_zero_at_the_start():
    """A law divides by a state that starts at zero."""

    def law(self):
        yield lp.der(self.x) == 1 / self.x
        yield lp.der(self.y) == 1

    lp.simulate(moved(law), until=1.0)


@wrong(RUNS, SolverError, "part.y", "t = 1 s", "outside its range")
def root_of_a_negative_number():
    """The argument of a square root becomes negative during the run."""

    def law(self):
        yield lp.der(self.x) == -1
        yield lp.der(self.y) == lp.ops.sqrt(self.x)

    lp.simulate(moved(law, x=1.0), until=2.0)


@wrong(RUNS, SolverError, "rotor.w", "accelerates for ever")
def no_equilibrium():
    """A free drive with a net torque is asked for its equilibrium."""
    lp.equilibrium(
        build(lambda m: lp.chain(m.motor, m.rotor), motor=Torque(tau=3.0), rotor=Inertia(J=2.0))
    )


@wrong(RUNS, UnitError, "until", "'1 m'", "of the kind s")
def until_in_metres():
    """The end of a run is given in another unit."""
    lp.simulate(lp.assemble(Hoist()), until="1 m")


@wrong(RUNS, OptionError, "grid", "nan", "finite numbers")
def output_time_that_is_no_number():
    """One of the output times is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, grid=[0.0, float("nan"), 1.0])


@wrong(RUNS, UnknownNameError, "motor.w", "run.table([...])")
def several_names_at_once():
    """A run is asked for two quantities at once."""
    lp.simulate(lp.assemble(Hoist()), until=0.1)[["motor.w", "discs[1].w"]]


# -- contact -----------------------------------------------------------------------------------

CONTACT = "Contact"


def resting(stop, **start):
    """Assemble a weight above a stop and start it."""
    system = build(
        lambda m: [lp.connect(m.stop.flange_b, m.mass.flange_a, m.weight.flange)],
        stop=stop,
        mass=translation.Mass(m=2.0, **start),
        weight=translation.Force(f=-20.0),
    )
    return lp.simulate(system, until=1.0)


@wrong(CONTACT, ParameterError, "mesh.b = -0.001 rad", "whole play", "at least 0")
def negative_play():
    """The play of an elastic mesh is negative."""
    build(
        lambda m: lp.chain(m.pinion, m.mesh, m.wheel),
        pinion=Inertia(J=1.0),
        mesh=ElastoBacklash(c=1e5, b=-1e-3),
        wheel=Inertia(J=1.0),
    )


@wrong(CONTACT, ParameterError, "mesh.b = 0 rad", "greater than 0")
def rigid_play_of_nothing():
    """Rigid flanks without play between them: that is a rigid joint."""
    build(
        lambda m: lp.chain(m.pinion, m.mesh, m.wheel),
        pinion=Inertia(J=1.0),
        mesh=Backlash(b=0.0),
        wheel=Inertia(J=1.0),
    )


@wrong(CONTACT, ParameterError, "stop.restitution = 1.2", "at most 1")
def impact_that_gives_energy():
    """The coefficient of restitution is greater than one."""
    resting(translation.Stop(restitution=1.2), s=1.0, v=0.0)


@wrong(CONTACT, StartError, "stop starts 0.2 m inside", "a gap, or none")
def start_inside_a_stop():
    """A body starts beyond its stop."""
    resting(translation.Stop(s_min=0.5), s=0.3, v=0.0)


@wrong(CONTACT, StartError, "mesh starts 0.03 rad inside", "a gap, or none")
def start_beyond_a_flank():
    """Two gears start with their teeth inside each other."""
    system = build(
        lambda m: lp.chain(m.pinion, m.mesh, m.wheel),
        pinion=Inertia(J=1.0, phi=0.0, w=0.0),
        mesh=Backlash(b=0.04),
        wheel=Inertia(J=1.0, phi=0.05),
    )
    lp.start_point(system)


@wrong(CONTACT, StartError, "cylinder starts 0.1 m inside")
def stops_in_the_wrong_order():
    """The lower stop of a body stands above its upper one."""
    lp.start_point(build(cylinder=translation.MassWithStops(m=1.0, s_min=0.1, s_max=0.0)))


@wrong(CONTACT, SolverError, "relay", "t = 0.5", "changes of mode")
def relay_without_hysteresis():
    """A relay drives its own input back to the point where it switches."""

    class Relay(lp.Component):
        """Drives x towards zero from both sides: der(x) = -sign(x)."""

        x: lp.Var = lp.var("1", "state", 0.5, state="always")

        def equations(self):
            yield lp.der(self.x) == lp.ops.where(self.x > 0, -1, 1)

    lp.simulate(build(relay=Relay()), until=1.0)


# -- cranks ------------------------------------------------------------------------------------

CRANKS = "Cranks"


def turned_crank(**given):
    """A crank-slider on a shaft of prescribed angle."""
    return build(
        lambda m: [lp.connect(m.turn.flange, m.crank.flange)],
        turn=Position(phi=lp.time),
        crank=CrankSlider(r=0.6, **given),
    )


@wrong(CRANKS, EquationError, "crank (CrankSlider)", "assembly = 2", "the start values choose")
def unknown_assembly():
    """The assembly of a crank-slider is given a number that means none."""
    turned_crank(L=2.0, assembly=2)


@wrong(CRANKS, ParameterError, "crank.L = 0.2 m (length of the rod)", "abs(e) - r = 0.4 m")
def rod_that_never_reaches_the_slide():
    """The slide of a crank passes further away than crank and rod reach."""
    turned_crank(L=0.2, e=1.0, assembly=0)


@wrong(CRANKS, ParameterError, "crank.L = 0.8 m (length of the rod)", "r + abs(e) = 0.9 m")
def rod_too_short_for_a_turn():
    """A rod is shorter than crank radius and offset together."""
    turned_crank(L=0.8, e=-0.3)


@wrong(CRANKS, SolverError, "rod.phi is not a number", "t = 0.986", "prescribed motion")
def prescribed_beyond_reach():
    """A rod on a crank that is turned evenly is too short for a whole turn."""

    class Rod(lp.Component):
        """Rod on a crank of radius 0.6 m, its foot on the line through the axis."""

        flange = lp.Flange()
        phi: lp.Var = lp.var("rad", "angle of the rod")

        def equations(self):
            yield self.flange.tau == 0
            yield self.phi == lp.ops.asin(0.6 / 0.5 * lp.ops.sin(self.flange.phi))

    system = build(
        lambda m: [lp.connect(m.turn.flange, m.rod.flange)],
        turn=Position(phi=lp.time),
        rod=Rod(),
    )
    lp.simulate(system, until=2.0, grid=2000)["rod.phi"]


@wrong(CRANKS, ParameterError, "press.s_1 = 0 m", "s_0")
def stroke_backwards():
    """The end of a working stroke lies before its begin."""
    model = build(
        lambda m: [lp.connect(m.press.flange, m.ram.flange_a)],
        press=StrokeLoad(forward=1.0, backward=0.0, s_0=0.3, s_1=0.0, p=1.0, q=1.0),
        ram=translation.Mass(m=1.0),
    )
    lp.start_point(model)


# -- tests and catalogue -----------------------------------------------------------------------

INTRODUCTION = """\
# Errors

<!-- Written by `python -m tests.test_wrong_models`. Do not edit. -->

What a wrong model is answered, kind by kind. Every error is a `lumped.errors.LumpedError`.

How to read a text:

* The first line says what is wrong, and in which model.
* Paths lead from the top of the model to the part: `line.second.twist.c` is the stiffness of
  `twist`, in `second`, in `line`; `discs[1]` and `brakes["left"]` stand in a list and a dictionary.
  The class stands behind in brackets.
* Equations are shown as written, with full names, and where they stand: *in* a part, or *at* the
  ports that a connection joins.
* Where equations and unknowns do not fit, there are always both: equations that determine something
  too often, and something that nothing determines. "Left after joining what is equal" counts the
  equations that remain when quantities that are simply equal have become one.
* The last line says what is likely meant, and what to do. Only it is a guess.

A part that is connected to nothing, or has all its ends in one place, is no error: the model is
computed, and a `lumped.errors.ModelWarning` names the part. Python's `warnings` turns it off, or
into an error.

Long numbers are rounded here.
"""
LONG = re.compile(r"-?\d+(\.\d{4,}(e[+-]\d+)?|(\.\d+)?e-\d+)")


def answer(case):
    """The error that a case raises."""
    with pytest.raises(LumpedError) as caught:
        case.make()
    return caught.value


def rounded(number):
    """A long number to three digits, and zero where it is rounding."""
    value = float(number[0])
    return f"{value:.3g}" if abs(value) > 1e-12 else "0"


def catalogue():
    """The text of docs/errors.md."""
    lines = [INTRODUCTION]
    for kind in dict.fromkeys(case.kind for case in CASES):
        lines.append(f"## {kind}\n")
        for case in CASES:
            if case.kind == kind:
                error = answer(case)
                text = LONG.sub(rounded, f"{type(error).__name__}: {error}")
                lines.append(f"{case.mistake}\n\n```text\n{text}\n```\n")
    return "\n".join(lines)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_a_wrong_model_is_answered_in_words_of_the_model(case):
    error = answer(case)
    print(f"\n{type(error).__name__}: {error}")
    assert type(error) is case.error
    for word in case.words:
        assert word in str(error)


def test_the_catalogue_of_errors_shows_the_texts_of_today():
    received = CATALOGUE.read_text(encoding="utf-8")
    expected = catalogue()
    assert received == expected, "run: python -m tests.test_wrong_models"


if __name__ == "__main__":
    CATALOGUE.write_text(catalogue(), encoding="utf-8")
