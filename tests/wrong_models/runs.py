"""Start values, equilibria and runs."""

import math

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Position, Speed, Spring, Torque
from lumped.errors import (
    EquationError,
    OptionError,
    SolverError,
    StartError,
    UnitError,
    UnknownNameError,
)
from tests.helpers.rows import assemble_row, assemble_rows

from . import Table
from .parts import Hoist, braked_drive, build

starts = Table("Start values")


@starts(StartError, "motor.w = 10", "load.w = 10")
def speeds_against_a_gear():
    """The start speeds on both sides of a gear do not fit its ratio."""
    lp.start_point(
        assemble_row(
            motor=Inertia(J=1.0, w=10.0), gear=IdealGear(ratio=2.0), load=Inertia(J=1.0, w=10.0)
        )
    )


@starts(StartError, "motor.w = 10", "load.w = 12")
def speeds_against_a_rigid_coupling():
    """Two rigidly joined rotors start at different speeds."""
    lp.start_point(assemble_row(motor=Inertia(J=1.0, w=10.0), load=Inertia(J=1.0, w=12.0)))


@starts(StartError, "rotor.w = 5", "sources")
def speed_of_a_held_body():
    """A body that a support holds starts with a speed."""
    lp.start_point(assemble_row(wall=Fixed(), rotor=Inertia(J=1.0, w=5.0)))


@starts(StartError, "rotor.phi = 1", "make it 0")
def angle_of_a_held_body():
    """A body starts at another angle than that of its support."""
    lp.start_point(assemble_row(wall=Fixed(), rotor=Inertia(J=1.0, phi=1.0)))


@starts(StartError, "rotor.w = 5", "sources")
def speed_against_a_speed_source():
    """A body on a speed source starts at another speed."""
    lp.start_point(assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0, w=5.0)))


@starts(StartError, "s_1.phi_rel", "s_2.phi_rel", "s_3.phi_rel")
def twists_around_a_loop():
    """The start twists of three springs around a closed loop do not add up to zero."""
    lp.start_point(
        assemble_rows(
            "a s_1 b s_2 c s_3 a",
            a=Inertia(J=1.0),
            b=Inertia(J=1.0),
            c=Inertia(J=1.0),
            s_1=Spring(c=1.0, phi_rel=0.1),
            s_2=Spring(c=1.0, phi_rel=0.1),
            s_3=Spring(c=1.0, phi_rel=0.1),
        )
    )


@starts(StartError, "shaft.tau = 50", "shaft.phi_rel = 0")
def torque_against_twist():
    """A spring starts with a torque and a twist that do not fit."""
    lp.start_point(
        assemble_row(
            a=Inertia(J=1.0), shaft=Spring(c=100.0, tau=50.0, phi_rel=0.0), b=Inertia(J=1.0)
        )
    )


@starts(StartError, "body.a = 3", "make it 1")
def acceleration_given():
    """A body starts with an acceleration other than what the torques give."""
    lp.start_point(assemble_row(drive=Torque(tau=1.0), body=Inertia(J=1.0, a=3.0)))


@starts(StartError, "motor.w = nan", "finite")
def start_value_nan():
    """A start value is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": math.nan})


@starts(UnitError, "motor.w", "'fast'")
def start_value_text():
    """A start value is a text."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": "fast"})


def turning(law, **changes):
    """Motor, shaft and load with initial equations."""
    return build(
        lambda m: lp.chain(m.motor, m.shaft, m.load),
        motor=Inertia(J=1.0, w=10.0),
        shaft=Spring(c=100.0),
        load=Inertia(J=2.0),
        initial_equations=law,
        **changes,
    )


@starts(StartError, "Too much", "der(motor.w) = 0 in Model", "shaft.c * shaft.phi_rel = 5")
def initial_equations_too_many():
    """Two initial equations ask for the same twist."""
    lp.start_point(turning(lambda m: [lp.der(m.motor.w) == 0, m.shaft.c * m.shaft.phi_rel == 5]))


@starts(StartError, "load.w = 2 * motor.w in Model", "motor.w = 10", "load.w = 5")
def initial_equation_against_start_values():
    """An initial equation does not fit the start values."""
    lp.start_point(turning(lambda m: [m.load.w == 2 * m.motor.w]), start={"load.w": 5.0})


@starts(StartError, "der(rotor.w) = 0 in rotor (Steady)", "no state", "differ by 3")
def initial_equation_that_nothing_meets():
    """A body shall start without acceleration, but a torque acts on it and nothing else."""

    class Steady(Inertia):
        """Inertia that starts steadily."""

        def initial_equations(self):
            yield lp.der(self.w) == 0

    lp.start_point(assemble_row(drive=Torque(tau=6.0), rotor=Steady(J=2.0)))


@starts(StartError, "No start state", "load.w**2 = -1 in Model")
def initial_equation_without_solution():
    """An initial equation has no solution."""
    lp.start_point(turning(lambda m: [m.load.w**2 == -1]))


@starts(StartError, "shaft.c", "not determined", "initial equation")
def free_parameter_undetermined():
    """A free parameter has no start value that depends on it."""
    lp.start_point(turning(lambda m: [m.load.w == 5]), free=["shaft.c"])


@starts(EquationError, "Steady", "initial_equations() gave nothing back")
def initial_equations_returned_nothing():
    """Initial equations are written without yield."""

    class Steady(Inertia):
        """Inertia without a word."""

        def initial_equations(self):
            lp.der(self.w) == 0  # noqa: B015

    assemble_row(drive=Torque(tau=6.0), rotor=Steady(J=2.0))


@starts(EquationError, "w of a component Inertia", "not one of its parts")
def initial_equation_of_a_stranger():
    """An initial equation names a part of no model."""
    stranger = Inertia(J=1.0)
    turning(lambda m: [m.load.w == stranger.w])


@starts(StartError, "wheel.w = 5 rad/s", "at rest (together=True)", "fewer start values")
def together_with_two_speeds():
    """Parts shall move together, and two of them are given different speeds."""
    lp.start_point(
        assemble_row(
            motor=Inertia(J=1.0, w=10.0), shaft=Spring(c=1e3), wheel=Inertia(J=2.0, w=5.0)
        ),
        together=True,
    )


class Contrary(lp.Component):
    """A signal above zero for a state below it, and the other way round."""

    x: lp.Var = lp.var("1", "state")
    y: lp.Var = lp.var("1", "signal")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y == self.x - lp.ops.where(self.x < 0.0, 1.0, -1.0)


@starts(StartError, "part.y = 0", "positions of conditions", "demand less")
def start_in_no_position():
    """A start value holds on neither side of a condition."""
    lp.start_point(build(part=Contrary()), start={"part.y": 0.0})


@starts(OptionError, "parameters that start values determine", "free=...")
def derivatives_through_a_free_parameter():
    """Derivatives of a run whose start values determine a parameter."""
    system = braked_drive()
    of = [lp.functionals.final("rotor.w")]
    lp.gradient(system, of=of, until=3.0, free=["rotor.J"])


@starts(UnknownNameError, "'drive.tau' is no parameter", "3 * sin(time)", "give a number")
def a_free_expression():
    """A torque that is given as an expression shall be found by the start values."""
    system = assemble_row(drive=Torque(tau=3 * lp.ops.sin(lp.time)), rotor=Inertia(J=1.0, a=2.0))
    lp.simulate(system, until=1.0, free=["drive.tau"])


equilibria = Table("Equilibria")


@equilibria(SolverError, "no rest", "der(rotor.w) stays at 3", "springs or supports")
def rest_of_a_driven_shaft():
    """A driven shaft that only a damper holds shall rest."""
    lp.equilibrium(braked_drive(), rest=True)


@equilibria(SolverError, "no rest", "rotor.w = 10 rad/s", "sources of motion")
def rest_on_a_speed_source():
    """A body on a speed source shall rest."""
    lp.equilibrium(assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0)), rest=True)


@equilibria(StartError, "rotor.w = 4 rad/s", "rest")
def rest_with_a_speed():
    """Rest is asked for, and a speed."""
    lp.equilibrium(braked_drive(), rest=True, start={"rotor.w": 4.0})


@equilibria(StartError, "drive.tau, brake.d", "speed")
def equilibrium_with_too_many_free_parameters():
    """The torque and the load are both free."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["drive.tau", "brake.d"])


@equilibria(SolverError, "no equilibrium", "der(rotor.w)", "free")
def equilibrium_with_a_useless_free_parameter():
    """The free parameter does not change the balance of torques."""
    lp.equilibrium(braked_drive(), start={"rotor.w": 4.0}, free=["rotor.J"])


runs = Table("Runs")


@runs(OptionError, "until = -1")
def until_negative():
    """A run ends before it starts."""
    lp.simulate(lp.assemble(Hoist()), until=-1.0)


@runs(OptionError, "simulate: system = Model()", "assemble it first")
def simulate_a_model():
    """A model is simulated before it is assembled."""
    lp.simulate(lp.compose(rotor=Inertia(J=1.0)), until=1.0)


@runs(OptionError, "linearise: inputs = 'drive.tau'", "Write ['drive.tau']")
def a_text_for_a_list():
    """One input is named without the brackets of a list."""
    system = assemble_row(drive=Torque(tau=1.0), rotor=Inertia(J=1.0))
    lp.linearise(system, inputs="drive.tau")


@runs(OptionError, "simulate: no option 'untill'", "Nearest: until")
def an_option_that_does_not_exist():
    """An option is misspelt."""
    lp.simulate(build(rotor=Inertia(J=1.0)), untill=1.0)


@runs(OptionError, "modes: at belongs to another system")
def a_point_of_another_system():
    """An operating point of one system is given to another."""
    first, second = build(rotor=Inertia(J=1.0)), build(rotor=Inertia(J=1.0))
    lp.modes(first, at=lp.start_point(second))


@runs(OptionError, "Inertia", "parentheses")
def assemble_a_class():
    """The class is assembled, not an instance."""
    lp.assemble(Inertia)


@runs(SolverError, "drum.phi would have to jump", "0.5 s")
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


@runs(SolverError, "part.x", "not a finite number", "t = 0 s")
def division_by_zero_at_the_start():
    """A law divides by a state that starts at zero."""

    def law(self):
        yield lp.der(self.x) == 1 / self.x
        yield lp.der(self.y) == 1

    lp.simulate(moved(law), until=1.0)


@runs(SolverError, "part.y", "t = 1 s", "outside its range")
def root_of_a_negative_number():
    """The argument of a square root becomes negative during the run."""

    def law(self):
        yield lp.der(self.x) == -1
        yield lp.der(self.y) == lp.ops.sqrt(self.x)

    lp.simulate(moved(law, x=1.0), until=2.0)


@runs(SolverError, "rotor.w", "accelerates for ever")
def no_equilibrium():
    """A free drive with a net torque is asked for its equilibrium."""
    lp.equilibrium(assemble_row(motor=Torque(tau=3.0), rotor=Inertia(J=2.0)))


@runs(UnitError, "until", "'1 m'", "of the kind s")
def until_in_metres():
    """The end of a run is given in another unit."""
    lp.simulate(lp.assemble(Hoist()), until="1 m")


@runs(OptionError, "grid", "nan", "finite numbers")
def output_time_that_is_no_number():
    """One of the output times is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, grid=[0.0, float("nan"), 1.0])


@runs(UnknownNameError, "motor.w", "run[[...]]")
def several_names_at_once():
    """A run is asked for two quantities at once."""
    lp.simulate(lp.assemble(Hoist()), until=0.1)["motor.w", "discs[1].w"]
