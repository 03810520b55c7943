"""Names that do not exist."""

import lumped as lp
from lumped.components import Inertia, Spring
from lumped.errors import UnknownNameError

from . import Table
from .parts import Hoist, braked, build

wrong = Table("Misspelt names")


@wrong(UnknownNameError, "Inertia has no 'j'", "J")
def parameter_misspelt_at_construction():
    """A parameter's name is misspelt when a part is made."""
    Inertia(j=1.0)


@wrong(UnknownNameError, "stiffness", "c")
def word_instead_of_letter():
    """A word is used instead of the letter."""
    Spring(stiffness=100.0)


@wrong(UnknownNameError, "Line has no part 'secnd'", "second")
def part_misspelt_in_with():
    """A part's name is misspelt in with_."""
    Hoist().with_({"line.secnd.J": 1.0})


@wrong(UnknownNameError, "discs", "[7]")
def list_index_too_large():
    """A list of parts is asked for a member that it does not have."""
    Hoist().with_({"discs[7].J": 1.0})


@wrong(UnknownNameError, "brakes", "middle")
def dictionary_key_unknown():
    """A dictionary of parts is asked for a key that it does not have."""
    Hoist().with_({'brakes["middle"].d': 1.0})


@wrong(UnknownNameError, "'discs' holds several parts", "[0], [1]")
def list_without_index():
    """A parameter of a list of parts is set without saying of which."""
    Hoist().with_({"discs.J": 2.0})


@wrong(UnknownNameError, "line.first.twist.C", "line.first.twist.c")
def parameter_misspelt_in_a_run():
    """A parameter's name is misspelt in a run."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, parameters={"line.first.twist.C": 1.0})


@wrong(UnknownNameError, "line.first.twist.phi", "line.first.twist.phi_rel")
def start_value_misspelt():
    """A start value's name is misspelt."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"line.first.twist.phi": 1.0})


@wrong(UnknownNameError, "motor.speed", "motor.w")
def result_misspelt():
    """A result is asked for by a wrong name."""
    lp.simulate(lp.assemble(Hoist()), until=0.01, grid=1)["motor.speed"]


@wrong(UnknownNameError, "motor.J", "parameter")
def result_is_a_parameter():
    """A parameter is asked for as a result."""
    lp.simulate(lp.assemble(Hoist()), until=0.01, grid=1)["motor.J"]


@wrong(UnknownNameError, "line.first.torque", "line.first.twist.tau")
def output_misspelt_in_assemble():
    """An output's name is misspelt in assemble."""
    lp.assemble(Hoist(), of=["line.first.torque"])


@wrong(UnknownNameError, "brake.d", 'brakes["left"].d')
def input_misspelt_in_linearise():
    """A parameter's name is misspelt in linearise."""
    lp.linearise(lp.assemble(Hoist()), inputs=["brake.d"], outputs=["motor.w"])


@wrong(UnknownNameError, "'discs' has no member [5]")
def list_member_replaced_outside():
    """A member that a list of parts does not have is replaced."""
    Hoist().with_({"discs[5]": Inertia(J=1.0)})


@wrong(UnknownNameError, "shaft (Spring) has no 'ratio'")
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


@wrong(UnknownNameError, "line.first (Shaft) has no 'axle'")
def part_of_a_part_misnamed():
    """An equation uses a part of a part that does not exist."""

    class Cart(Hoist):
        """Speed from a part misnamed."""

        v: lp.Var = lp.var("m/s", "velocity")

        def equations(self):
            yield self.v == 0.3 * self.line.first.axle.w

    build(cart=Cart())


@wrong(
    UnknownNameError,
    "Brake.flange (rotational flange) has no 'w'",
    "phi and tau",
    "der(flange.phi)",
)
def speed_of_a_flange():
    """An equation uses the speed of a flange, which has an angle and a torque only."""
    braked(lambda self: [self.flange.tau == self.d * self.flange.w])
