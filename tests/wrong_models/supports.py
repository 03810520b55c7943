"""What is held twice, in a rigid loop, or by nothing."""

import lumped as lp
from lumped.components import (
    AngleSensor,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    Position,
    QuasiStaticDCMotor,
    RackAndPinion,
    RelativeAngleSensor,
    Resistor,
    Speed,
    SpeedSensor,
    Spring,
    Torque,
    TorqueSensor,
    VoltageSource,
    translation,
)
from lumped.errors import SingularModelError
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import build

twice = Table("Motion held or prescribed twice")


@twice(SingularModelError, "bearing.flange", "brake.flange", "Nothing determines", "spring between")
def two_supports():
    """Two rigid supports hold the two ends of one rigid rotor."""
    assemble_row(bearing=Fixed(), rotor=Inertia(J=1.0), brake=Fixed())


@twice(SingularModelError, "stand.motor_mount", "stand.foot", "spring between")
def two_supports_inside_a_part():
    """Two supports meet deep in a composite."""

    class Stand(lp.Component):
        """Two mounts at one flange."""

        flange = lp.Flange()
        motor_mount: Fixed = Fixed()
        foot: Fixed = Fixed()

        def connections(self):
            yield lp.connect(self.flange, self.motor_mount.flange, self.foot.flange)

    assemble_row(stand=Stand(), spring=Spring(c=1.0), load=Inertia(J=1.0))


@twice(SingularModelError, "mill.w = 10", "grid.w = 12", "rotor")
def two_speeds_on_one_shaft():
    """Two speed sources drive the two ends of one rigid rotor."""
    assemble_rows(
        "mill rotor",
        "grid.flange rotor.flange_b",
        mill=Speed(w=10.0),
        rotor=Inertia(J=1.0),
        grid=Speed(w=12.0),
    )


@twice(SingularModelError, "fast.flange", "slow.flange", "gear")
def two_speeds_through_a_gear():
    """Two speed sources drive the two sides of a rigid gear."""
    assemble_row(fast=Speed(w=30.0), gear=IdealGear(ratio=3.0), slow=Speed(w=10.0))


@twice(SingularModelError, "servo.phi = 1", "motor.w = 10", "prescribed motions meet at")
def speed_and_position():
    """A speed source and a position source drive the same shaft."""
    assemble_row(motor=Speed(w=10.0), body=Inertia(J=1.0), servo=Position(phi=1.0))


@twice(SingularModelError, "wall.flange.phi = wall.phi0", "motor")
def speed_on_a_fixed_shaft():
    """A speed source drives a rotor that a support holds."""
    assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0), wall=Fixed())


@twice(SingularModelError, "left.flange", "right.flange", "rack")
def rack_between_two_fixed_points():
    """A rack and its pinion are both held."""
    assemble_row(left=Fixed(), rack=RackAndPinion(radius=0.1), right=translation.Fixed())


@twice(SingularModelError, "set", "hold_sun", "hold_ring", "hold_carrier")
def planetary_held_three_times():
    """All three shafts of a planetary gear are held."""
    assemble_rows(
        "hold_sun.flange set.sun",
        "hold_ring.flange set.ring",
        "hold_carrier.flange set.carrier",
        set=Planetary(ratio=2.0),
        hold_sun=Fixed(),
        hold_ring=Fixed(),
        hold_carrier=Fixed(),
    )


@twice(SingularModelError, "set", "engine", "generator", "axle")
def planetary_driven_three_times():
    """All three shafts of a planetary gear have a speed source."""
    assemble_rows(
        "engine.flange set.carrier",
        "generator.flange set.sun",
        "axle.flange set.ring",
        set=Planetary(ratio=2.0),
        engine=Speed(w=100.0),
        generator=Speed(w=200.0),
        axle=Speed(w=50.0),
    )


loops = Table("Rigid loops")


def in_parallel(motor, **parts):
    """Assemble a motor and a load with parts that all join the same two shafts."""
    rows = [f"motor {name} load" for name in parts]
    assemble_rows(*rows, motor=motor, **parts, load=Inertia(J=1.0))


@loops(SingularModelError, "in gear_1", "in gear_2", "closed loop", "elastic")
def gears_in_parallel():
    """Two rigid gears of equal ratio join the same two shafts."""
    in_parallel(Inertia(J=1.0), gear_1=IdealGear(ratio=3.0), gear_2=IdealGear(ratio=3.0))


@loops(
    SingularModelError,
    "leave no motion of motor.phi, load.phi",
    "runs through gear_1, gear_2: gear_1.ratio = 2, gear_2.ratio = 3.",
    "ratios agree",
)
def gears_of_unequal_ratio():
    """Two rigid gears of unequal ratio join the same two shafts."""
    in_parallel(Inertia(J=1.0), gear_1=IdealGear(ratio=2.0), gear_2=IdealGear(ratio=3.0))


@loops(SingularModelError, "runs through gear_1, gear_2: gear_1.ratio = 2", "ratios agree")
def gears_of_unequal_ratio_at_a_speed():
    """A prescribed speed drives two gears of unequal ratio between the same two shafts."""
    in_parallel(Speed(w=100.0), gear_1=IdealGear(ratio=2.0), gear_2=IdealGear(ratio=3.0))


@loops(SingularModelError, "leave no motion of motor.phi", "runs through gear: gear.ratio = 4.")
def gear_beside_a_rigid_shaft():
    """A gear joins two rotors that are also joined directly."""
    assemble_rows(
        "motor gear load motor",
        motor=Inertia(J=1.0),
        gear=IdealGear(ratio=4.0),
        load=Inertia(J=1.0),
    )


@loops(SingularModelError, "in set (Planetary)", "set.ratio = 2", "lower.ratio = 2.5")
def planetary_set_tied_by_two_gears():
    """Two gears tie all three shafts of a planetary set to each other."""
    assemble_rows(
        "set.sun motor.flange_b upper.flange_a",
        "set.ring upper.flange_b lower.flange_a",
        "set.carrier load.flange_a lower.flange_b",
        motor=Inertia(J=1.0),
        set=Planetary(ratio=2.0),
        upper=IdealGear(ratio=-1.5),
        lower=IdealGear(ratio=2.5),
        load=Inertia(J=1.0),
    )


@loops(SingularModelError, "runs through pinion_1, pinion_2: pinion_1.radius = 0.1 m")
def rack_with_two_pinions_on_a_shaft():
    """Two pinions of unequal radius on one shaft mesh with one rack."""
    assemble_rows(
        "motor pinion_1 table",
        "motor pinion_2 table",
        motor=Inertia(J=1.0),
        pinion_1=RackAndPinion(radius=0.1),
        pinion_2=RackAndPinion(radius=0.12),
        table=translation.Mass(m=1.0),
    )


@loops(SingularModelError, "runs through rotor, sensor", "share the load")
def torque_sensor_across_a_rotor():
    """A torque sensor is connected across a rigid rotor instead of in the power path."""
    assemble_rows(
        "drive rotor",
        "drive sensor",
        "rotor.flange_b sensor.flange_b",
        drive=Torque(tau=1.0),
        rotor=Inertia(J=1.0),
        sensor=TorqueSensor(),
    )


@loops(SingularModelError, "runs through sensor_1, sensor_2", "share the load")
def two_torque_sensors_in_parallel():
    """Two torque sensors join the same two rotors."""
    assemble_rows(
        "a sensor_1 b",
        "a sensor_2 b",
        a=Inertia(J=1.0),
        b=Inertia(J=1.0),
        sensor_1=TorqueSensor(),
        sensor_2=TorqueSensor(),
    )


@loops(SingularModelError, "body.flange_a", "body.flange_b", "share the load")
def mass_attached_twice():
    """Both flanges of one rotor are connected to the same shaft end."""
    assemble_rows(
        "wall shaft",
        "shaft.flange_b body.flange_a body.flange_b",
        wall=Fixed(),
        shaft=Spring(c=100.0),
        body=Inertia(J=1.0),
    )


loose = Table("Parts that nothing holds")


@loose(SingularModelError, "left.tau", "right.tau", "nothing holds left, shaft, right")
def spring_between_two_torques():
    """A spring stands between two torque sources, without any inertia."""
    assemble_row(left=Torque(tau=1.0), shaft=Spring(c=10.0), right=Torque(tau=-1.0))


@loose(SingularModelError, "spare.flange.phi", "nothing holds spare, other")
def sensor_alone():
    """A sensor is connected to another sensor only."""
    assemble_rows(
        "drive body",
        "spare other",
        drive=Torque(tau=1.0),
        body=Inertia(J=1.0),
        spare=AngleSensor(),
        other=SpeedSensor(),
    )


@loose(SingularModelError, "one.flange_a.phi", "nothing holds one, two, three")
def dampers_without_ground():
    """A ring of dampers has neither inertia nor ground."""
    assemble_rows("one two three one", one=Damper(d=1.0), two=Damper(d=2.0), three=Damper(d=3.0))


@loose(SingularModelError, "gear.flange_b.phi", "nothing holds motor, gear, load")
def gear_into_nothing():
    """A torque drives a gear whose other side carries a second torque and no inertia."""
    assemble_row(motor=Torque(tau=1.0), gear=IdealGear(ratio=2.0), load=Torque(tau=-2.0))


@loose(SingularModelError, "nothing holds drives[1].motor, drives[1].shaft", "inertia")
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


@loose(SingularModelError, "battery.n.v", "nothing holds battery, load", "ground")
def circuit_without_ground():
    """No pin of an electric circuit is grounded."""
    assemble_rows(
        "battery.p load.p", "battery.n load.n", battery=VoltageSource(v=24.0), load=Resistor(R=2.0)
    )


@loose(SingularModelError, "battery.n.v", "nothing holds battery, motor", "ground")
def machine_without_ground():
    """A motor on a battery: the shaft is sound, the electric side has no ground."""
    assemble_rows(
        "battery.p motor.p",
        "battery.n motor.n",
        "motor rotor",
        battery=VoltageSource(v=24.0),
        motor=QuasiStaticDCMotor(k=0.1, R=0.5, J=0.01),
        rotor=Inertia(J=1.0),
    )


@loose(SingularModelError, "sensor.flange_a.phi", "nothing holds motor, sensor")
def relative_sensor_in_the_power_path():
    """A sensor of relative angle stands in the power path, where it carries no torque."""
    assemble_row(motor=Torque(tau=1.0), sensor=RelativeAngleSensor(), load=Inertia(J=1.0))


@loose(SingularModelError, "nothing holds left, right", "prescribed motions meet at grid")
def two_mistakes_at_once():
    """Two torques meet without an inertia, and elsewhere two speed sources meet."""
    assemble_rows(
        "left right",
        "grid rotor mill",
        left=Torque(tau=1.0),
        right=Torque(tau=-1.0),
        grid=Speed(w=1.0),
        rotor=Inertia(J=1.0),
        mill=Speed(w=2.0),
    )


@loose(SingularModelError, "in two (Damper)", "are zero: one.d, two.d")
def joint_between_dampers_of_zero():
    """A massless joint is held by two dampers whose damping is zero."""
    system = assemble_row(a=Inertia(J=1.0), one=Damper(d=0.0), two=Damper(d=0.0), b=Inertia(J=1.0))
    lp.simulate(system, until=1.0)
