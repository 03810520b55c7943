"""Names and values of parameters."""

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
from .parts import Hoist, braked, build

names = Table("Misspelt names")


@names(UnknownNameError, "Inertia has no 'j'", "J")
def parameter_misspelt_at_construction():
    """A parameter's name is misspelt when a part is made."""
    Inertia(j=1.0)


@names(UnknownNameError, "stiffness", "c")
def word_instead_of_letter():
    """A word is used instead of the letter."""
    Spring(stiffness=100.0)


@names(UnknownNameError, "Line has no part 'secnd'", "second")
def part_misspelt_in_with():
    """A part's name is misspelt in with_."""
    Hoist().with_({"line.secnd.J": 1.0})


@names(UnknownNameError, "discs", "[7]")
def list_index_too_large():
    """A list of parts is asked for a member that it does not have."""
    Hoist().with_({"discs[7].J": 1.0})


@names(UnknownNameError, "brakes", "middle")
def dictionary_key_unknown():
    """A dictionary of parts is asked for a key that it does not have."""
    Hoist().with_({'brakes["middle"].d': 1.0})


@names(UnknownNameError, "'discs' holds several parts", "[0], [1]")
def list_without_index():
    """A parameter of a list of parts is set without saying of which."""
    Hoist().with_({"discs.J": 2.0})


@names(UnknownNameError, "line.first.twist.C", "line.first.twist.c")
def parameter_misspelt_in_a_run():
    """A parameter's name is misspelt in a run."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.twist.C": 1.0})


@names(UnknownNameError, "line.first.twist.phi", "line.first.twist.phi_rel")
def start_value_misspelt():
    """A start value's name is misspelt."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"line.first.twist.phi": 1.0})


@names(UnknownNameError, "motor.speed", "motor.w")
def result_misspelt():
    """A result is asked for by a wrong name."""
    lp.simulate(lp.assemble(Hoist()), until=0.01, grid=1)["motor.speed"]


@names(UnknownNameError, "motor.J", "parameter")
def parameter_is_an_output_in_assemble():
    """A parameter is an output in assemble."""
    lp.assemble(Hoist(), of=["motor.J"])


@names(UnknownNameError, "line.first.torque", "line.first.twist.tau")
def output_misspelt_in_assemble():
    """An output's name is misspelt in assemble."""
    lp.assemble(Hoist(), of=["line.first.torque"])


@names(UnknownNameError, "brake.d", 'brakes["left"].d')
def input_misspelt_in_linearise():
    """A parameter's name is misspelt in linearise."""
    lp.linearise(lp.assemble(Hoist()), inputs=["brake.d"], outputs=["motor.w"])


@names(UnknownNameError, "'discs' has no member [5]")
def list_member_replaced_outside():
    """A member that a list of parts does not have is replaced."""
    Hoist().with_({"discs[5]": Inertia(J=1.0)})


@names(UnknownNameError, "shaft (Spring) has no 'ratio'")
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


@names(UnknownNameError, "line.first (Shaft) has no 'axle'")
def part_of_a_part_misnamed():
    """An equation uses a part of a part that does not exist."""

    class Cart(Hoist):
        """Speed from a part misnamed."""

        v: lp.Var = lp.var("m/s", "velocity")

        def equations(self):
            yield self.v == 0.3 * self.line.first.axle.w

    build(cart=Cart())


@names(
    UnknownNameError,
    "Brake.flange (rotational flange) has no 'w'",
    "phi and tau",
    "der(flange.phi)",
)
def speed_of_a_flange():
    """An equation uses the speed of a flange, which has an angle and a torque only."""
    braked(lambda self: [self.flange.tau == self.d * self.flange.w])


values = Table("Parameters")


@values(ParameterError, "line.second.right.J", "no value")
def parameter_missing_deep_inside():
    """A part three levels down has no inertia."""
    lp.assemble(Hoist().with_({"line.second.right": Inertia()}))


@values(ParameterError, "discs[1].J = -1", "greater than 0")
def negative_in_a_list():
    """A negative inertia stands in a list."""
    lp.assemble(Hoist().with_({"discs[1].J": -1.0}))


@values(ParameterError, 'brakes["left"].d = -1', "line.first.twist.c = 0", "2 param")
def two_faults_at_once():
    """A negative damping in a dictionary, and a stiffness of zero in a part of a part."""
    lp.assemble(Hoist().with_({'brakes["left"].d': -1.0, "line.first.twist.c": 0.0}))


@values(ParameterError, "motor.J = nan", "finite")
def parameter_nan():
    """An inertia is not a number."""
    lp.assemble(Hoist().with_({"motor.J": math.nan}))


@values(ParameterError, "line.first.twist.c = inf", "finite")
def parameter_infinite():
    """A stiffness is infinite, to make the shaft rigid."""
    lp.assemble(Hoist().with_({"line.first.twist.c": math.inf}))


@values(ParameterError, "stage.gear.ratio = 0", "must not be zero")
def ratio_of_zero():
    """A gear deep inside has the ratio zero."""

    class Stage(lp.Component):
        """One gear."""

        gear: IdealGear = IdealGear(ratio=0.0)

    build(stage=Stage())


@values(EquationError, "rotor.J", "1 + time", "cannot hold the time")
def parameter_bound_to_the_time():
    """An inertia is bound to the time."""

    class Winder(lp.Component):
        """Reel that grows."""

        rotor: Inertia = Inertia(J=1.0 + lp.time)

    lp.assemble(Winder())


@values(EquationError, "Winder", "'radius'")
def parameter_bound_to_a_stranger():
    """A part is bound to a parameter of another component."""

    class Winder(lp.Component):
        """Rotor with the radius of something else."""

        rotor: Inertia = Inertia(J=2 * RackAndPinion.radius)

    lp.assemble(Winder())


@values(UnitError, "Spring(c=...)", "'1e4 N.m'", "N.m/rad", "angle is missing")
def parameter_in_another_unit():
    """A stiffness is given in the unit of a torque."""
    Spring(c="1e4 N.m")


@values(UnitError, "motor.w = '50 Hz'", "rpm")
def speed_in_hertz():
    """A speed is given in Hz, which leaves open whether turns or radians are meant."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": "50 Hz"})


@values(UnitError, "Vehicle(inclination=...)", "'3 deg'", "a slope is a tangent")
def an_angle_as_a_slope():
    """A slope is given as an angle."""
    Vehicle(m=1000.0, R=0.3, inclination="3 deg")


@values(DeclarationError, "Torque(tau=...)", "lumped.time", "lumped.ops.table")
def a_function_as_an_input():
    """A torque is given as a Python function of time."""
    Torque(tau=lambda t: 5.0 * t)


@values(ParameterError, "rotor.J = 1e+120 kg.m2", "must be smaller than 1e+100")
def a_number_beyond_all_quantities():
    """An inertia is larger than anything, and its square could not be computed."""
    build(rotor=Inertia(J=1e120))


@values(UnitError, "Inertia(J=...)", "'0.3 kgm2'", "kg.m2")
def misspelt_unit():
    """A unit lacks the dot between its parts."""
    Inertia(J="0.3 kgm2")


@values(DeclarationError, "Inertia(J=...): [1.0, 2.0]", "number in kg.m2")
def parameter_as_list():
    """An inertia is given as a list."""
    Inertia(J=[1.0, 2.0])


@values(DeclarationError, "Inertia(J=...): None", "number in kg.m2")
def parameter_as_none():
    """An inertia is given as None."""
    Inertia(J=None)


@values(ParameterError, "rotor.J = -0.5", "greater than 0")
def bound_parameter_out_of_range():
    """A parameter computed from others leaves its range."""

    class Pump(lp.Component):
        """Rotor with what is left of the inertia."""

        total: lp.Param = lp.param("kg.m2", "inertia of all", 1.0)
        rotor: Inertia = Inertia(J=total - 1.5)

    lp.assemble(Pump())


@values(ParameterError, "rotor.J", "finite")
def bound_parameter_divides_by_zero():
    """A parameter is computed by a division by zero."""

    class Pump(lp.Component):
        """Inertia from a natural frequency."""

        c: lp.Param = lp.param("N.m/rad", "stiffness", 1.0)
        omega: lp.Param = lp.param("rad/s", "natural frequency", 0.0)
        rotor: Inertia = Inertia(J=c / omega**2)

    lp.assemble(Pump())


@values(ParameterError, "fan.a", "fan.b", "circle", "a number")
def parameters_in_a_circle():
    """Two parameters are bound to each other."""

    class Fan(lp.Component):
        """Blades and hub, each half of the other."""

        a: lp.Param = lp.param("kg.m2", "hub", 1.0)
        b: lp.Param = lp.param("kg.m2", "blades", 2 * a)
        rotor: Inertia = Inertia(J=a + b)

    Fan.a.default = Fan.b / 2
    build(fan=Fan())


@values(UnitError, "line.first.J", "'heavy'", "kg.m2")
def text_in_a_run():
    """A run changes a parameter to a text."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.J": "heavy"})


@values(UnknownNameError, "line.first.left.J", "bound", "line.first.J")
def bound_parameter_set_in_a_run():
    """A run sets a parameter that is bound to one of its parent."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.left.J": 1.0})
