"""Parts that nothing holds."""

import lumped as lp
from lumped.components import (
    AngleSensor,
    Damper,
    IdealGear,
    Inertia,
    RelativeAngleSensor,
    Speed,
    SpeedSensor,
    Spring,
    Torque,
)
from lumped.errors import SingularModelError

from . import Table
from .parts import Battery, Machine, Resistor, assemble_row, build, build_rows

wrong = Table("Parts that nothing holds")


@wrong(SingularModelError, "left.tau", "right.tau", "nothing holds left, shaft, right")
def spring_between_two_torques():
    """A spring stands between two torque sources, without any inertia."""
    assemble_row(left=Torque(tau=1.0), shaft=Spring(c=10.0), right=Torque(tau=-1.0))


@wrong(SingularModelError, "spare.flange.phi", "nothing holds spare, other")
def sensor_alone():
    """A sensor is connected to another sensor only."""
    build_rows(
        "drive body",
        "spare other",
        drive=Torque(tau=1.0),
        body=Inertia(J=1.0),
        spare=AngleSensor(),
        other=SpeedSensor(),
    )


@wrong(SingularModelError, "one.flange_a.phi", "nothing holds one, two, three")
def dampers_without_ground():
    """A ring of dampers has neither inertia nor ground."""
    build_rows("one two three one", one=Damper(d=1.0), two=Damper(d=2.0), three=Damper(d=3.0))


@wrong(SingularModelError, "gear.flange_b.phi", "nothing holds motor, gear, load")
def gear_into_nothing():
    """A torque drives a gear whose other side carries a second torque and no inertia."""
    assemble_row(motor=Torque(tau=1.0), gear=IdealGear(ratio=2.0), load=Torque(tau=-2.0))


@wrong(SingularModelError, "nothing holds drives[1].motor, drives[1].shaft", "inertia")
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


@wrong(SingularModelError, "battery.n.v", "nothing holds battery, load", "ground")
def circuit_without_ground():
    """No pin of an electric circuit is grounded."""
    build_rows("battery.p load.p", "battery.n load.n", battery=Battery(), load=Resistor(R=2.0))


@wrong(SingularModelError, "battery.n.v", "nothing holds battery, motor", "ground")
def machine_without_ground():
    """A motor on a battery: the shaft is sound, the electric side has no ground."""
    build_rows(
        "battery.p motor.p",
        "battery.n motor.n",
        "motor rotor",
        battery=Battery(),
        motor=Machine(),
        rotor=Inertia(J=1.0),
    )


@wrong(SingularModelError, "sensor.flange_a.phi", "nothing holds motor, sensor")
def relative_sensor_in_the_power_path():
    """A sensor of relative angle stands in the power path, where it carries no torque."""
    assemble_row(motor=Torque(tau=1.0), sensor=RelativeAngleSensor(), load=Inertia(J=1.0))


@wrong(SingularModelError, "nothing holds left, right", "prescribed motions meet at grid")
def two_mistakes_at_once():
    """Two torques meet without an inertia, and elsewhere two speed sources meet."""
    build_rows(
        "left right",
        "grid rotor mill",
        left=Torque(tau=1.0),
        right=Torque(tau=-1.0),
        grid=Speed(w=1.0),
        rotor=Inertia(J=1.0),
        mill=Speed(w=2.0),
    )


@wrong(SingularModelError, "in two (Damper)", "are zero: one.d, two.d")
def joint_between_dampers_of_zero():
    """A massless joint is held by two dampers whose damping is zero."""
    system = assemble_row(a=Inertia(J=1.0), one=Damper(d=0.0), two=Damper(d=0.0), b=Inertia(J=1.0))
    lp.simulate(system, until=1.0)
