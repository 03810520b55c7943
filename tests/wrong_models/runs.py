"""Runs and the arguments of analyses."""

import lumped as lp
from lumped.components import Inertia, Position, Torque
from lumped.errors import OptionError, SolverError, UnitError, UnknownNameError

from . import Table
from .parts import Hoist, assemble_row, build

wrong = Table("Runs")


@wrong(OptionError, "until = -1")
def until_negative():
    """A run ends before it starts."""
    lp.simulate(lp.assemble(Hoist()), until=-1.0)


@wrong(OptionError, "simulate: system = Model()", "assemble it first")
def simulate_a_model():
    """A model is simulated before it is assembled."""
    lp.simulate(lp.compose(rotor=Inertia(J=1.0)), until=1.0)


@wrong(OptionError, "linearise: inputs = 'drive.tau'", "Write ['drive.tau']")
def a_text_for_a_list():
    """One input is named without the brackets of a list."""
    system = assemble_row(drive=Torque(tau=1.0), rotor=Inertia(J=1.0))
    lp.linearise(system, inputs="drive.tau")


@wrong(OptionError, "simulate: no option 'untill'", "Nearest: until")
def an_option_that_does_not_exist():
    """An option is misspelt."""
    lp.simulate(build(rotor=Inertia(J=1.0)), untill=1.0)


@wrong(OptionError, "modes: at belongs to another system")
def a_point_of_another_system():
    """An operating point of one system is given to another."""
    first, second = build(rotor=Inertia(J=1.0)), build(rotor=Inertia(J=1.0))
    lp.modes(first, at=lp.start_point(second))


@wrong(OptionError, "Inertia", "parentheses")
def assemble_a_class():
    """The class is assembled, not an instance."""
    lp.assemble(Inertia)


@wrong(SolverError, "drum.phi would have to jump", "0.5 s")
def prescribed_jump():
    """A prescribed angle jumps, and a rigid body would have to follow."""
    step = lp.ops.where(lp.time >= 0.5, 1.0, 0.0)
    system = assemble_row(servo=Position(phi=step), drum=Inertia(J=1.0))
    lp.simulate(system, until=1.0)


class Point(lp.Component):
    """Motion with a law that a test supplies."""

    x: lp.Var = lp.var("m", "position")
    y: lp.Var = lp.var("m", "distance")


def moved(law, **start):
    kind = type("Point", (Point,), {"__doc__": "Point under test.", "equations": law})
    return build(part=kind(**start))


@wrong(SolverError, "part.x", "not a finite number", "t = 0 s")
def division_by_zero_at_the_start():
    """A law divides by a state that starts at zero."""

    def law(self):
        yield lp.der(self.x) == 1 / self.x
        yield lp.der(self.y) == 1

    lp.simulate(moved(law), until=1.0)


@wrong(SolverError, "part.y", "t = 1 s", "outside its range")
def root_of_a_negative_number():
    """The argument of a square root becomes negative during the run."""

    def law(self):
        yield lp.der(self.x) == -1
        yield lp.der(self.y) == lp.ops.sqrt(self.x)

    lp.simulate(moved(law, x=1.0), until=2.0)


@wrong(SolverError, "rotor.w", "accelerates for ever")
def no_equilibrium():
    """A free drive with a net torque is asked for its equilibrium."""
    lp.equilibrium(assemble_row(motor=Torque(tau=3.0), rotor=Inertia(J=2.0)))


@wrong(UnitError, "until", "'1 m'", "of the kind s")
def until_in_metres():
    """The end of a run is given in another unit."""
    lp.simulate(lp.assemble(Hoist()), until="1 m")


@wrong(OptionError, "grid", "nan", "finite numbers")
def output_time_that_is_no_number():
    """One of the output times is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, grid=[0.0, float("nan"), 1.0])


@wrong(UnknownNameError, "motor.w", "run[[...]]")
def several_names_at_once():
    """A run is asked for two quantities at once."""
    lp.simulate(lp.assemble(Hoist()), until=0.1)["motor.w", "discs[1].w"]
