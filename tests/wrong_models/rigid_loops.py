"""Rigid loops, whose parts cannot share their load."""

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
from .parts import build_rows

wrong = Table("Rigid loops")


def in_parallel(motor, **parts):
    """Assemble a motor and a load with parts that all join the same two shafts."""
    rows = [f"motor {name} load" for name in parts]
    build_rows(*rows, motor=motor, **parts, load=Inertia(J=1.0))


@wrong(SingularModelError, "in gear_1", "in gear_2", "closed loop", "elastic")
def gears_in_parallel():
    """Two rigid gears of equal ratio join the same two shafts."""
    in_parallel(Inertia(J=1.0), gear_1=IdealGear(ratio=3.0), gear_2=IdealGear(ratio=3.0))


@wrong(
    SingularModelError,
    "leave no motion of motor.phi, load.phi",
    "runs through gear_1, gear_2: gear_1.ratio = 2, gear_2.ratio = 3.",
    "ratios agree",
)
def gears_of_unequal_ratio():
    """Two rigid gears of unequal ratio join the same two shafts."""
    in_parallel(Inertia(J=1.0), gear_1=IdealGear(ratio=2.0), gear_2=IdealGear(ratio=3.0))


@wrong(SingularModelError, "runs through gear_1, gear_2: gear_1.ratio = 2", "ratios agree")
def gears_of_unequal_ratio_at_a_speed():
    """A prescribed speed drives two gears of unequal ratio between the same two shafts."""
    in_parallel(Speed(w=100.0), gear_1=IdealGear(ratio=2.0), gear_2=IdealGear(ratio=3.0))


@wrong(SingularModelError, "leave no motion of motor.phi", "runs through gear: gear.ratio = 4.")
def gear_beside_a_rigid_shaft():
    """A gear joins two rotors that are also joined directly."""
    build_rows(
        "motor gear load motor",
        motor=Inertia(J=1.0),
        gear=IdealGear(ratio=4.0),
        load=Inertia(J=1.0),
    )


@wrong(SingularModelError, "in set (Planetary)", "set.ratio = 2", "lower.ratio = 2.5")
def planetary_set_tied_by_two_gears():
    """Two gears tie all three shafts of a planetary set to each other."""
    build_rows(
        "set.sun motor.flange_b upper.flange_a",
        "set.ring upper.flange_b lower.flange_a",
        "set.carrier load.flange_a lower.flange_b",
        motor=Inertia(J=1.0),
        set=Planetary(ratio=2.0),
        upper=IdealGear(ratio=-1.5),
        lower=IdealGear(ratio=2.5),
        load=Inertia(J=1.0),
    )


@wrong(SingularModelError, "runs through pinion_1, pinion_2: pinion_1.radius = 0.1 m")
def rack_with_two_pinions_on_a_shaft():
    """Two pinions of unequal radius on one shaft mesh with one rack."""
    build_rows(
        "motor pinion_1 table",
        "motor pinion_2 table",
        motor=Inertia(J=1.0),
        pinion_1=RackAndPinion(radius=0.1),
        pinion_2=RackAndPinion(radius=0.12),
        table=translation.Mass(m=1.0),
    )


@wrong(SingularModelError, "runs through rotor, sensor", "share the load")
def torque_sensor_across_a_rotor():
    """A torque sensor is connected across a rigid rotor instead of in the power path."""
    build_rows(
        "drive rotor",
        "drive sensor",
        "rotor.flange_b sensor.flange_b",
        drive=Torque(tau=1.0),
        rotor=Inertia(J=1.0),
        sensor=TorqueSensor(),
    )


@wrong(SingularModelError, "runs through sensor_1, sensor_2", "share the load")
def two_torque_sensors_in_parallel():
    """Two torque sensors join the same two rotors."""
    build_rows(
        "a sensor_1 b",
        "a sensor_2 b",
        a=Inertia(J=1.0),
        b=Inertia(J=1.0),
        sensor_1=TorqueSensor(),
        sensor_2=TorqueSensor(),
    )


@wrong(SingularModelError, "body.flange_a", "body.flange_b", "share the load")
def mass_attached_twice():
    """Both flanges of one rotor are connected to the same shaft end."""
    build_rows(
        "wall shaft",
        "shaft.flange_b body.flange_a body.flange_b",
        wall=Fixed(),
        shaft=Spring(c=100.0),
        body=Inertia(J=1.0),
    )
