"""Rigid loops, whose parts cannot share their load."""

import lumped as lp
from lumped.components import (
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    RackAndPinion,
    Speed,
    Spring,
    Torque,
    TorqueSensor,
    translation,
)
from lumped.errors import SingularModelError

from . import Table
from .parts import build

wrong = Table("Rigid loops")


@wrong(SingularModelError, "in gear_1", "in gear_2", "closed loop", "elastic")
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


@wrong(SingularModelError, "runs through gear_1, gear_2: gear_1.ratio = 2", "ratios agree")
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


@wrong(SingularModelError, "leave no motion of motor.phi", "runs through gear: gear.ratio = 4.")
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


@wrong(SingularModelError, "in set (Planetary)", "set.ratio = 2", "lower.ratio = 2.5")
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


@wrong(SingularModelError, "runs through pinion_1, pinion_2: pinion_1.radius = 0.1 m")
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


@wrong(SingularModelError, "runs through rotor, sensor", "share the load")
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


@wrong(SingularModelError, "runs through sensor_1, sensor_2", "share the load")
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


@wrong(SingularModelError, "body.flange_a", "body.flange_b", "share the load")
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
