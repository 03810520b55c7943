"""Mechanisms, coils and cranks."""

import numpy as np

import lumped as lp
from lumped.components import (
    Belt,
    CamSwitch,
    Coil,
    CrankSlider,
    EllipticalGear,
    HarmonicTorque,
    Inertia,
    NonCircularGear,
    PeriodicTorque,
    Planetary,
    Position,
    PulseTorque,
    Ravigneaux,
    RollingTorque,
    Speed,
    Strip,
    StripPath,
    StrokeLoad,
    translation,
)
from lumped.errors import DeclarationError, EquationError, OptionError, ParameterError, SolverError
from lumped.transmissions import from_ratio, through
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import build

mechanisms = Table("Mechanisms")


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


@mechanisms(ParameterError, "part.e = 1", "eccentricity", "less than 1")
def ellipse_that_is_a_line():
    """An elliptical gear has the eccentricity one."""
    shear(EllipticalGear(e=1.0))


@mechanisms(OptionError, "distance = 0.149 m", "the teeth jam by", "Without backlash it is 0.15 m")
def teeth_that_jam():
    """The axes of a pair of gears are closer than their teeth allow."""
    lp.life.GearPair((20, 40), "5 mm", "50 mm", distance="149 mm")


@mechanisms(EquationError, "part (NonCircularGear)", "a function of the angle", "lambda x")
def transmission_without_a_function():
    """A non-circular gear is given a ratio for its transmission function."""
    shear(NonCircularGear(transmission=2.0))


@mechanisms(OptionError, "by 1.02062073 turns", "turns = 1", "by 0.979795897")
def ratio_that_does_not_close():
    """The wanted ratio of a non-circular gear makes more than a turn of one."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 / (1 + 0.2 * lp.ops.cos(x)))))


@mechanisms(OptionError, "w_b / w_a is -0.00", "at 2.09", "makes 1 turns", "keeps the sign")
def ratio_that_turns_back():
    """The wanted ratio of a non-circular gear changes its sign."""
    shear(NonCircularGear(transmission=from_ratio(lambda x: 1 + 2 * lp.ops.cos(x))))


@mechanisms(OptionError, "from 0 to 3.14159 rad", "0.5 turns", "exactly one")
def points_of_half_a_turn():
    """The points of a non-circular gear cover half a turn."""
    angles = np.linspace(0, np.pi, 13)
    shear(NonCircularGear(transmission=through(np.column_stack([angles, -angles]))))


@mechanisms(EquationError, "periodic_spline", "must increase, but 3 -> 2")
def points_out_of_order():
    """The points of a non-circular gear are out of order."""
    rows = [(0, 0), (3, 3), (2, 2), (5, 5), (2 * np.pi, 2 * np.pi)]
    shear(NonCircularGear(transmission=through(rows)))


@mechanisms(ParameterError, "part.distance = 0.3 m", "greater than r_a + r_b = 0.35 m")
def pulleys_that_overlap():
    """The pulleys of a belt are larger than the distance of their axes allows."""
    shear(Belt(r_a=0.1, r_b=0.25, distance=0.3, EA=1e5, F_0=100.0))


@mechanisms(ParameterError, "part.F_0 = -100 N", "pretension", "at least 0")
def belt_that_pushes():
    """A belt has a negative pretension."""
    shear(Belt(r_a=0.1, r_b=0.1, distance=0.5, EA=1e5, F_0=-100.0))


@mechanisms(ParameterError, "set.ratio = -2.5", "ring teeth over sun teeth", "greater than 0")
def planetary_of_negative_ratio():
    """A planetary gear is given its ratio with held carrier, which is negative."""
    assemble_rows(
        "motor.flange_a set.sun",
        "load.flange_a set.carrier",
        motor=Inertia(J=0.1),
        set=Planetary(ratio=-2.5),
        load=Inertia(J=1.0),
    )


@mechanisms(EquationError, "part (PulseTorque)", "'triangle'", "'half-sine' or 'rectangle'")
def pulse_of_unknown_shape():
    """A pulse of torque has a shape that does not exist."""
    shear(PulseTorque(shape="triangle", tau_max=-5.0, centre=2.0, width=1.0))


@mechanisms(ParameterError, "part.width = 7 rad", "range of the angle", "less than 6.28319")
def cam_wider_than_a_turn():
    """The range of a cam switch is more than a turn."""
    shear(CamSwitch(centre=0.0, width=7.0))


@mechanisms(EquationError, "part (HarmonicTorque)", "harmonics = ((2, 340.0),)", "phase")
def harmonic_without_phase():
    """A harmonic of a torque is given without its phase."""
    shear(HarmonicTorque(harmonics=((2, 340.0),)))


@mechanisms(EquationError, "part (HarmonicTorque)", "order 0", "'mean'")
def harmonic_of_order_zero():
    """The mean of a torque is given as a harmonic of order zero."""
    shear(HarmonicTorque(harmonics=((0, 50.0, 0.0), (2, 340.0, 0.0))))


@mechanisms(EquationError, "part (PeriodicTorque)", "increase", "2 -> 1 rad")
def periodic_table_out_of_order():
    """The points of a periodic torque are not in the order of their angles."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0), (1.0, 3.0))))


@mechanisms(EquationError, "part (PeriodicTorque)", "360 rad", "6.28319 rad", "in rad")
def periodic_table_in_degrees():
    """The angles of a periodic torque are given in degrees, the closing point among them."""
    shear(PeriodicTorque(points=((0.0, 1.0), (180.0, 5.0), (360.0, 1.0))))


@mechanisms(EquationError, "part (PeriodicTorque)", "period = -1 rad", "2 pi for a turn")
def period_below_zero():
    """A periodic torque has a negative period."""
    shear(PeriodicTorque(points=((0.0, 1.0),), period=-1))


@mechanisms(EquationError, "part (PeriodicTorque)", "'spline'", "'smooth' or 'lines'")
def periodic_table_of_unknown_shape():
    """A periodic torque is to be joined in a way that does not exist."""
    shear(PeriodicTorque(points=((0.0, 1.0), (2.0, 5.0)), shape="spline"))


@mechanisms(ParameterError, "part.R = 0 m", "radius of the rolls", "greater than 0")
def rolls_without_radius():
    """Rolls have no radius."""
    shear(RollingTorque(F=1e6, a=0.01, R=0.0, T_back=0.0, T_front=0.0))


winding = Table("Winding")


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


@winding(ParameterError, "coil.h = -0.001 m", "thickness of the strip", "at least 0")
def strip_of_negative_thickness():
    """The thickness of a strip is negative."""
    coiler(h=-1e-3)


@winding(ParameterError, "coil.R_max = 0.2 m", "radius of a full coil", "coil.r = 0.3 m")
def full_coil_smaller_than_its_mandrel():
    """A full coil is smaller than its mandrel."""
    coiler(R_max=0.2)


@winding(ParameterError, "coil.fill = 95", "at most 1")
def fill_in_percent():
    """The fill of a coil is given in percent."""
    coiler(fill=95.0)


@winding(ParameterError, "strip.c = 0 N/m (stiffness)", "greater than 0")
def strip_without_stiffness():
    """An elastic strip has no stiffness."""
    coiler(strip=Strip(c=0.0))


@winding(ParameterError, "path.d = 1 m", "greater than path.r_t = 1.25 m")
def roll_inside_the_turret():
    """The roll before a turret stands inside the circle of its coils."""
    coiler(path=StripPath(r_t=1.25, d=1.0))


cranks = Table("Cranks")


def turned_crank(**given):
    """A crank-slider on a shaft of prescribed angle."""
    return assemble_row(turn=Position(phi=lp.time), crank=CrankSlider(r=0.6, **given))


@cranks(EquationError, "crank (CrankSlider)", "assembly = 2", "the start values choose")
def unknown_assembly():
    """The assembly of a crank-slider is given a number that means none."""
    turned_crank(L=2.0, assembly=2)


@cranks(ParameterError, "crank.L = 0.2 m (length of the rod)", "max(0, abs(e) - r) = 0.4 m")
def rod_that_never_reaches_the_slide():
    """The slide of a crank passes further away than crank and rod reach."""
    turned_crank(L=0.2, e=1.0, assembly=0)


@cranks(
    ParameterError,
    "crank.L = 0.8 m (length of the rod)",
    "r + abs(e) + 1e-08 * (r + abs(e)) = 0.9 m",
)
def rod_too_short_for_a_turn():
    """A rod is shorter than crank radius and offset together."""
    turned_crank(L=0.8, e=-0.3)


@cranks(SolverError, "rod.phi is not a number", "t = 0.986", "prescribed motion")
def prescribed_beyond_reach():
    """A rod on a crank that is turned evenly is too short for a whole turn."""

    class Rod(lp.Component):
        """Rod on a crank of radius 0.6 m, its foot on the line through the axis."""

        flange = lp.Flange()
        phi: lp.Var = lp.var("rad", "angle of the rod")

        def equations(self):
            yield self.flange.tau == 0
            yield self.phi == lp.ops.asin(0.6 / 0.5 * lp.ops.sin(self.flange.phi))

    system = assemble_row(turn=Position(phi=lp.time), rod=Rod())
    lp.simulate(system, until=2.0, grid=2000)["rod.phi"]


@cranks(ParameterError, "press.s_1 = 0 m", "s_0")
def stroke_backwards():
    """The end of a working stroke lies before its begin."""
    model = assemble_row(
        press=StrokeLoad(forward=1.0, backward=0.0, s_0=0.3, s_1=0.0, p=1.0, q=1.0),
        ram=translation.Mass(m=1.0),
    )
    lp.start_point(model)


def planetary_set(**given):
    """A motor and two bodies on a Ravigneaux set."""
    teeth = {"z_small": 30, "z_large": 36, "z_short": 17, "z_long": 18, "z_r": 72}
    build(
        lambda m: [
            lp.connect(m.motor.flange_a, m.gears.small_sun),
            lp.connect(m.wheel.flange_a, m.gears.ring),
        ],
        motor=Inertia(J=0.1),
        gears=Ravigneaux(**teeth | given),
        wheel=Inertia(J=2.0),
    )


@mechanisms(DeclarationError, "gears (Ravigneaux)", "z_r = 75", "72 teeth are needed")
def ring_that_does_not_mesh():
    """The ring of a planetary set has teeth that do not fit those of sun and planets."""
    planetary_set(z_r=75)


@mechanisms(DeclarationError, "n = 4 planets", "10.5 is not whole", "n = 1, 2, 3, 6")
def planets_that_cannot_be_assembled():
    """Four planets at equal angles, with teeth for three."""
    planetary_set(n=4)


@mechanisms(DeclarationError, "collide", "19.5 modules", "fewer planets")
def planets_that_collide():
    """So many planets that neighbours touch."""
    planetary_set(n=6)
