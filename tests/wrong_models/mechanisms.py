"""Non-circular gears, belts, cams, planetary sets and torques over the angle."""

import numpy as np

import lumped as lp
from lumped.components import (
    Belt,
    CamSwitch,
    EllipticalGear,
    HarmonicTorque,
    Inertia,
    NonCircularGear,
    PeriodicTorque,
    Planetary,
    PulseTorque,
    RollingTorque,
)
from lumped.errors import EquationError, OptionError, ParameterError
from lumped.transmissions import from_ratio, through

from . import Table
from .parts import build, build_rows

wrong = Table("Mechanisms")


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


@wrong(ParameterError, "part.e = 1", "eccentricity", "less than 1")
def ellipse_that_is_a_line():
    """An elliptical gear has the eccentricity one."""
    shear(EllipticalGear(e=1.0))


@wrong(EquationError, "part (NonCircularGear)", "a function of the angle", "lambda x")
def transmission_without_a_function():
    """A non-circular gear is given a ratio for its transmission function."""
    shear(NonCircularGear(transmission=2.0))


@wrong(OptionError, "by 1.02062073 turns", "turns = 1", "by 0.979795897")
def ratio_that_does_not_close():
    """The wanted ratio of a non-circular gear makes more than a turn of one."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 / (1 + 0.2 * lp.ops.cos(x)))))


@wrong(OptionError, "w_b / w_a is -0.00", "at 2.09", "makes 1 turns", "keeps the sign")
def ratio_that_turns_back():
    """The wanted ratio of a non-circular gear changes its sign."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 + 2 * lp.ops.cos(x))))


@wrong(OptionError, "from 0 to 3.14159 rad", "0.5 turns", "exactly one")
def points_of_half_a_turn():
    """The points of a non-circular gear cover half a turn."""
    angles = np.linspace(0, np.pi, 13)
    shear(NonCircularGear(transmission=through(np.column_stack([angles, -angles]))))


@wrong(EquationError, "periodic_spline", "must increase, but 3 -> 2")
def points_out_of_order():
    """The points of a non-circular gear are out of order."""
    rows = [(0, 0), (3, 3), (2, 2), (5, 5), (2 * np.pi, 2 * np.pi)]
    shear(NonCircularGear(transmission=through(rows)))


@wrong(ParameterError, "part.distance = 0.3 m", "greater than r_a + r_b = 0.35 m")
def pulleys_that_overlap():
    """The pulleys of a belt are larger than the distance of their axes allows."""
    shear(Belt(r_a=0.1, r_b=0.25, distance=0.3, EA=1e5, F_0=100.0))


@wrong(ParameterError, "part.F_0 = -100 N", "pretension", "at least 0")
def belt_that_pushes():
    """A belt has a negative pretension."""
    shear(Belt(r_a=0.1, r_b=0.1, distance=0.5, EA=1e5, F_0=-100.0))


@wrong(ParameterError, "set.ratio = -2.5", "ring teeth over sun teeth", "greater than 0")
def planetary_of_negative_ratio():
    """A planetary gear is given its ratio with held carrier, which is negative."""
    build_rows(
        "motor.flange_a set.sun",
        "load.flange_a set.carrier",
        motor=Inertia(J=0.1),
        set=Planetary(ratio=-2.5),
        load=Inertia(J=1.0),
    )


@wrong(EquationError, "part (PulseTorque)", "'triangle'", "'half-sine' or 'rectangle'")
def pulse_of_unknown_shape():
    """A pulse of torque has a shape that does not exist."""
    shear(PulseTorque(shape="triangle", tau_max=-5.0, centre=2.0, width=1.0))


@wrong(ParameterError, "part.width = 7 rad", "range of the angle", "less than 6.28319")
def cam_wider_than_a_turn():
    """The range of a cam switch is more than a turn."""
    shear(CamSwitch(centre=0.0, width=7.0))


@wrong(EquationError, "part (HarmonicTorque)", "harmonics = ((2, 340.0),)", "phase")
def harmonic_without_phase():
    """A harmonic of a torque is given without its phase."""
    shear(HarmonicTorque(harmonics=((2, 340.0),)))


@wrong(EquationError, "part (HarmonicTorque)", "order 0", "'mean'")
def harmonic_of_order_zero():
    """The mean of a torque is given as a harmonic of order zero."""
    shear(HarmonicTorque(harmonics=((0, 50.0, 0.0), (2, 340.0, 0.0))))


@wrong(EquationError, "part (PeriodicTorque)", "increase", "2 -> 1 rad")
def periodic_table_out_of_order():
    """The points of a periodic torque are not in the order of their angles."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0), (1.0, 3.0))))


@wrong(EquationError, "part (PeriodicTorque)", "360 rad", "6.28319 rad", "in rad")
def periodic_table_in_degrees():
    """The angles of a periodic torque are given in degrees, the closing point among them."""
    shear(PeriodicTorque(points=((0.0, 1.0), (180.0, 5.0), (360.0, 1.0))))


@wrong(EquationError, "part (PeriodicTorque)", "period = -1 rad", "2 pi for a turn")
def period_below_zero():
    """A periodic torque has a negative period."""
    shear(PeriodicTorque(points=((0.0, 1.0),), period=-1))


@wrong(EquationError, "part (PeriodicTorque)", "'spline'", "'smooth' or 'lines'")
def periodic_table_of_unknown_shape():
    """A periodic torque is to be joined in a way that does not exist."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0)), shape="spline"))


@wrong(ParameterError, "part.R = 0 m", "radius of the rolls", "greater than 0")
def rolls_without_radius():
    """Rolls have no radius."""
    shear(RollingTorque(F=1e6, a=0.01, R=0.0, T_back=0.0, T_front=0.0))
