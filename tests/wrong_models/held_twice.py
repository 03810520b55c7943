"""Motion that is held or prescribed twice."""

import lumped as lp
from lumped.components import (
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    Position,
    RackAndPinion,
    Speed,
    Spring,
    translation,
)
from lumped.errors import SingularModelError

from . import Table
from .parts import assemble_row, build_rows

wrong = Table("Motion held or prescribed twice")


@wrong(SingularModelError, "bearing.flange", "brake.flange", "Nothing determines", "spring between")
def two_supports():
    """Two rigid supports hold the two ends of one rigid rotor."""
    assemble_row(bearing=Fixed(), rotor=Inertia(J=1.0), brake=Fixed())


@wrong(SingularModelError, "stand.motor_mount", "stand.foot", "spring between")
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


@wrong(SingularModelError, "mill.w = 10", "grid.w = 12", "rotor")
def two_speeds_on_one_shaft():
    """Two speed sources drive the two ends of one rigid rotor."""
    build_rows(
        "mill rotor",
        "grid.flange rotor.flange_b",
        mill=Speed(w=10.0),
        rotor=Inertia(J=1.0),
        grid=Speed(w=12.0),
    )


@wrong(SingularModelError, "fast.flange", "slow.flange", "gear")
def two_speeds_through_a_gear():
    """Two speed sources drive the two sides of a rigid gear."""
    assemble_row(fast=Speed(w=30.0), gear=IdealGear(ratio=3.0), slow=Speed(w=10.0))


@wrong(SingularModelError, "servo.phi = 1", "motor.w = 10", "prescribed motions meet at")
def speed_and_position():
    """A speed source and a position source drive the same shaft."""
    assemble_row(motor=Speed(w=10.0), body=Inertia(J=1.0), servo=Position(phi=1.0))


@wrong(SingularModelError, "wall.flange.phi = wall.phi0", "motor")
def speed_on_a_fixed_shaft():
    """A speed source drives a rotor that a support holds."""
    assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0), wall=Fixed())


@wrong(SingularModelError, "left.flange", "right.flange", "rack")
def rack_between_two_fixed_points():
    """A rack and its pinion are both held."""
    assemble_row(left=Fixed(), rack=RackAndPinion(radius=0.1), right=translation.Fixed())


@wrong(SingularModelError, "set", "hold_sun", "hold_ring", "hold_carrier")
def planetary_held_three_times():
    """All three shafts of a planetary gear are held."""
    build_rows(
        "hold_sun.flange set.sun",
        "hold_ring.flange set.ring",
        "hold_carrier.flange set.carrier",
        set=Planetary(ratio=2.0),
        hold_sun=Fixed(),
        hold_ring=Fixed(),
        hold_carrier=Fixed(),
    )


@wrong(SingularModelError, "set", "engine", "generator", "axle")
def planetary_driven_three_times():
    """All three shafts of a planetary gear have a speed source."""
    build_rows(
        "engine.flange set.carrier",
        "generator.flange set.sun",
        "axle.flange set.ring",
        set=Planetary(ratio=2.0),
        engine=Speed(w=100.0),
        generator=Speed(w=200.0),
        axle=Speed(w=50.0),
    )
