"""Start values and initial equations."""

import math

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Speed, Spring, Torque
from lumped.errors import EquationError, OptionError, StartError, UnitError, UnknownNameError

from . import Table
from .parts import Hoist, assemble_row, braked_drive, build, build_rows

wrong = Table("Start values")


@wrong(StartError, "motor.w = 10", "load.w = 10")
def speeds_against_a_gear():
    """The start speeds on both sides of a gear do not fit its ratio."""
    lp.start_point(
        assemble_row(
            motor=Inertia(J=1.0, w=10.0), gear=IdealGear(ratio=2.0), load=Inertia(J=1.0, w=10.0)
        )
    )


@wrong(StartError, "motor.w = 10", "load.w = 12")
def speeds_against_a_rigid_coupling():
    """Two rigidly joined rotors start at different speeds."""
    lp.start_point(assemble_row(motor=Inertia(J=1.0, w=10.0), load=Inertia(J=1.0, w=12.0)))


@wrong(StartError, "rotor.w = 5", "sources")
def speed_of_a_held_body():
    """A body that a support holds starts with a speed."""
    lp.start_point(assemble_row(wall=Fixed(), rotor=Inertia(J=1.0, w=5.0)))


@wrong(StartError, "rotor.phi = 1", "make it 0")
def angle_of_a_held_body():
    """A body starts at another angle than that of its support."""
    lp.start_point(assemble_row(wall=Fixed(), rotor=Inertia(J=1.0, phi=1.0)))


@wrong(StartError, "rotor.w = 5", "sources")
def speed_against_a_speed_source():
    """A body on a speed source starts at another speed."""
    lp.start_point(assemble_row(motor=Speed(w=10.0), rotor=Inertia(J=1.0, w=5.0)))


@wrong(StartError, "s_1.phi_rel", "s_2.phi_rel", "s_3.phi_rel")
def twists_around_a_loop():
    """The start twists of three springs around a closed loop do not add up to zero."""
    lp.start_point(
        build_rows(
            "a s_1 b s_2 c s_3 a",
            a=Inertia(J=1.0),
            b=Inertia(J=1.0),
            c=Inertia(J=1.0),
            s_1=Spring(c=1.0, phi_rel=0.1),
            s_2=Spring(c=1.0, phi_rel=0.1),
            s_3=Spring(c=1.0, phi_rel=0.1),
        )
    )


@wrong(StartError, "shaft.tau = 50", "shaft.phi_rel = 0")
def torque_against_twist():
    """A spring starts with a torque and a twist that do not fit."""
    lp.start_point(
        assemble_row(
            a=Inertia(J=1.0), shaft=Spring(c=100.0, tau=50.0, phi_rel=0.0), b=Inertia(J=1.0)
        )
    )


@wrong(StartError, "body.a = 3", "make it 1")
def acceleration_given():
    """A body starts with an acceleration other than what the torques give."""
    lp.start_point(assemble_row(drive=Torque(tau=1.0), body=Inertia(J=1.0, a=3.0)))


@wrong(StartError, "motor.w = nan", "finite")
def start_value_nan():
    """A start value is not a number."""
    lp.simulate(lp.assemble(Hoist()), until=1.0, start={"motor.w": math.nan})


@wrong(UnitError, "motor.w", "'fast'")
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


@wrong(StartError, "Too much", "der(motor.w) = 0 in Model", "shaft.c * shaft.phi_rel = 5")
def initial_equations_too_many():
    """Two initial equations ask for the same twist."""
    lp.start_point(turning(lambda m: [lp.der(m.motor.w) == 0, m.shaft.c * m.shaft.phi_rel == 5]))


@wrong(StartError, "load.w = 2 * motor.w in Model", "motor.w = 10", "load.w = 5")
def initial_equation_against_start_values():
    """An initial equation does not fit the start values."""
    lp.start_point(turning(lambda m: [m.load.w == 2 * m.motor.w]), start={"load.w": 5.0})


@wrong(StartError, "der(rotor.w) = 0 in rotor (Steady)", "no state", "differ by 3")
def initial_equation_that_nothing_meets():
    """A body shall start without acceleration, but a torque acts on it and nothing else."""

    class Steady(Inertia):
        """Inertia that starts steadily."""

        def initial_equations(self):
            yield lp.der(self.w) == 0

    lp.start_point(assemble_row(drive=Torque(tau=6.0), rotor=Steady(J=2.0)))


@wrong(StartError, "No start state", "load.w**2 = -1 in Model")
def initial_equation_without_solution():
    """An initial equation has no solution."""
    lp.start_point(turning(lambda m: [m.load.w**2 == -1]))


@wrong(StartError, "shaft.c", "not determined", "initial equation")
def free_parameter_undetermined():
    """A free parameter has no start value that depends on it."""
    lp.start_point(turning(lambda m: [m.load.w == 5]), free=["shaft.c"])


@wrong(EquationError, "Steady", "initial_equations() gave nothing back")
def initial_equations_returned_nothing():
    """Initial equations are written without yield."""

    class Steady(Inertia):
        """Inertia without a word."""

        def initial_equations(self):
            lp.der(self.w) == 0  # noqa: B015

    assemble_row(drive=Torque(tau=6.0), rotor=Steady(J=2.0))


@wrong(EquationError, "w of a component Inertia", "not one of its parts")
def initial_equation_of_a_stranger():
    """An initial equation names a part of no model."""
    stranger = Inertia(J=1.0)
    turning(lambda m: [m.load.w == stranger.w])


@wrong(StartError, "wheel.w = 5 rad/s", "at rest (together=True)", "fewer start values")
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


@wrong(StartError, "part.y = 0", "positions of conditions", "demand less")
def start_in_no_position():
    """A start value holds on neither side of a condition."""
    lp.start_point(build(part=Contrary()), start={"part.y": 0.0})


@wrong(OptionError, "parameters that start values determine", "free=...")
def derivatives_through_a_free_parameter():
    """Derivatives of a run whose start values determine a parameter."""
    system = braked_drive()
    of = [lp.functionals.final("rotor.w")]
    lp.gradient(system, of=of, until=3.0, free=["rotor.J"])


@wrong(UnknownNameError, "'drive.tau' is no parameter", "3 * sin(time)", "give a number")
def a_free_expression():
    """A torque that is given as an expression shall be found by the start values."""
    system = assemble_row(drive=Torque(tau=3 * lp.ops.sin(lp.time)), rotor=Inertia(J=1.0, a=2.0))
    lp.simulate(system, until=1.0, free=["drive.tau"])
