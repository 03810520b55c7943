"""Values of parameters: out of range, of another unit, bound wrongly."""

import math

import lumped as lp
from lumped.components import IdealGear, Inertia, RackAndPinion, Spring, Torque, Vehicle
from lumped.errors import (
    DeclarationError,
    EquationError,
    ParameterError,
    UnitError,
    UnknownNameError,
)

from . import Table
from .parts import Hoist, build

wrong = Table("Parameters")


@wrong(ParameterError, "line.second.right.J", "no value")
def parameter_missing_deep_inside():
    """A part three levels down has no inertia."""
    lp.assemble(Hoist().with_({"line.second.right": Inertia()}))


@wrong(ParameterError, "discs[1].J = -1", "greater than 0")
def negative_in_a_list():
    """A negative inertia stands in a list."""
    lp.assemble(Hoist().with_({"discs[1].J": -1.0}))


@wrong(ParameterError, 'brakes["left"].d = -1', "line.first.twist.c = 0", "2 param")
def two_faults_at_once():
    """A negative damping in a dictionary, and a stiffness of zero in a part of a part."""
    lp.assemble(Hoist().with_({'brakes["left"].d': -1.0, "line.first.twist.c": 0.0}))


@wrong(ParameterError, "motor.J = nan", "finite")
def parameter_nan():
    """An inertia is not a number."""
    lp.assemble(Hoist().with_({"motor.J": math.nan}))


@wrong(ParameterError, "line.first.twist.c = inf", "finite")
def parameter_infinite():
    """A stiffness is infinite, to make the shaft rigid."""
    lp.assemble(Hoist().with_({"line.first.twist.c": math.inf}))


@wrong(ParameterError, "stage.gear.ratio = 0", "must not be zero")
def ratio_of_zero():
    """A gear deep inside has the ratio zero."""

    class Stage(lp.Component):
        """One gear."""

        gear: IdealGear = IdealGear(ratio=0.0)

    build(stage=Stage())


@wrong(EquationError, "rotor.J", "1 + time", "cannot hold the time")
def parameter_bound_to_the_time():
    """An inertia is bound to the time."""

    class Winder(lp.Component):
        """Reel that grows."""

        rotor: Inertia = Inertia(J=1.0 + lp.time)

    lp.assemble(Winder())


@wrong(EquationError, "Winder", "'radius'")
def parameter_bound_to_a_stranger():
    """A part is bound to a parameter of another component."""

    class Winder(lp.Component):
        """Rotor with the radius of something else."""

        rotor: Inertia = Inertia(J=2 * RackAndPinion.radius)

    lp.assemble(Winder())


@wrong(UnitError, "Spring(c=...)", "'1e4 N.m'", "N.m/rad", "angle is missing")
def parameter_in_another_unit():
    """A stiffness is given in the unit of a torque."""
    Spring(c="1e4 N.m")


@wrong(UnitError, "motor.w = '50 Hz'", "rpm")
def speed_in_hertz():
    """A speed is given in Hz, which leaves open whether turns or radians are meant."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": "50 Hz"})


@wrong(UnitError, "Vehicle(inclination=...)", "'3 deg'", "a slope is a tangent")
def an_angle_as_a_slope():
    """A slope is given as an angle."""
    Vehicle(m=1000.0, R=0.3, inclination="3 deg")


@wrong(DeclarationError, "Torque(tau=...)", "lumped.time", "lumped.ops.table")
def a_function_as_an_input():
    """A torque is given as a Python function of time."""
    Torque(tau=lambda t: 5.0 * t)


@wrong(ParameterError, "rotor.J = 1e+120 kg.m2", "must be smaller than 1e+100")
def a_number_beyond_all_quantities():
    """An inertia is larger than anything, and its square could not be computed."""
    build(rotor=Inertia(J=1e120))


@wrong(UnitError, "Inertia(J=...)", "'0.3 kgm2'", "kg.m2")
def misspelt_unit():
    """A unit lacks the dot between its parts."""
    Inertia(J="0.3 kgm2")


@wrong(DeclarationError, "Inertia(J=...): [1.0, 2.0]", "number in kg.m2")
def parameter_as_list():
    """An inertia is given as a list."""
    Inertia(J=[1.0, 2.0])


@wrong(DeclarationError, "Inertia(J=...): None", "number in kg.m2")
def parameter_as_none():
    """An inertia is given as None."""
    Inertia(J=None)


@wrong(ParameterError, "rotor.J = -0.5", "greater than 0")
def bound_parameter_out_of_range():
    """A parameter computed from others leaves its range."""

    class Pump(lp.Component):
        """Rotor with what is left of the inertia."""

        total: lp.Param = lp.param("kg.m2", "inertia of all", 1.0)
        rotor: Inertia = Inertia(J=total - 1.5)

    lp.assemble(Pump())


@wrong(ParameterError, "rotor.J", "finite")
def bound_parameter_divides_by_zero():
    """A parameter is computed by a division by zero."""

    class Pump(lp.Component):
        """Inertia from a natural frequency."""

        c: lp.Param = lp.param("N.m/rad", "stiffness", 1.0)
        omega: lp.Param = lp.param("rad/s", "natural frequency", 0.0)
        rotor: Inertia = Inertia(J=c / omega**2)

    lp.assemble(Pump())


@wrong(ParameterError, "fan.a", "fan.b", "circle", "a number")
def parameters_in_a_circle():
    """Two parameters are bound to each other."""

    class Fan(lp.Component):
        """Blades and hub, each half of the other."""

        a: lp.Param = lp.param("kg.m2", "hub", 1.0)
        b: lp.Param = lp.param("kg.m2", "blades", 2 * a)
        rotor: Inertia = Inertia(J=a + b)

    Fan.a.default = Fan.b / 2
    build(fan=Fan())


@wrong(UnitError, "line.first.J", "'heavy'", "kg.m2")
def text_in_a_run():
    """A run changes a parameter to a text."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.J": "heavy"})


@wrong(UnknownNameError, "line.first.left.J", "bound", "line.first.J")
def bound_parameter_set_in_a_run():
    """A run sets a parameter that is bound to one of its parent."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.left.J": 1.0})
