"""Equations of own components."""

import math
from functools import wraps

import numpy as np

import lumped as lp
from lumped.components import Inertia
from lumped.errors import (
    DeclarationError,
    EquationError,
    SingularModelError,
    SolverError,
    StartError,
)
from tests.helpers.rows import assemble_row

from . import Table
from .parts import braked, build

laws = Table("Equations of own components")


def wrong_law(error, *words):
    """Enter the equations of a brake into the table: the mistake is to assemble it."""

    def enter(equations):
        @laws(error, *words)
        @wraps(equations)
        def make():
            braked(equations)

    return enter


@wrong_law(SingularModelError, "brake (Brake) brings 1 equation", "needs 2", "w", "flange")
def equation_missing(self):
    """A component has an equation too few."""
    yield self.flange.tau == self.d * self.w


@wrong_law(
    SingularModelError, "brake (Brake) brings 3 equations but needs 2", "too many", "tau == 5"
)
def equation_surplus(self):
    """A component has an equation too many."""
    yield self.w == lp.der(self.flange.phi)
    yield self.flange.tau == self.d * self.w
    yield self.flange.tau == 5.0


@wrong_law(SingularModelError, "in brake", "equations of brake (Brake)", "twice")
def equation_twice(self):
    """A component states one law twice and forgets another: the count is right."""
    yield self.w == lp.der(self.flange.phi)
    yield 2 * self.w == 2 * lp.der(self.flange.phi)


@wrong_law(SingularModelError, "brake.w = brake.w", "no unknown is left", "cancel")
def equation_of_itself(self):
    """A quantity is said to equal itself."""
    yield self.w == self.w
    yield self.flange.tau == self.d * lp.der(self.flange.phi)


@wrong_law(EquationError, "brake (Brake)", "must be an equation")
def expression_instead_of_equation(self):
    """An equation is written as an expression that should be zero."""
    yield self.w - lp.der(self.flange.phi)
    yield self.flange.tau == self.d * self.w


@wrong_law(EquationError, "brake", "w", "where")
def if_on_a_variable(self):
    """A law is chosen by `if` on a variable."""
    yield self.w == lp.der(self.flange.phi)
    if self.w > 0:
        yield self.flange.tau == self.d
    else:
        yield self.flange.tau == -self.d


@wrong_law(EquationError, "brake", "lumped.ops")
def math_function(self):
    """A function of math is applied to a variable."""
    yield self.w == lp.der(self.flange.phi)
    yield self.flange.tau == self.d * math.sin(self.w)


@wrong_law(EquationError, "brake", "w == der(flange.phi)", "two equations")
def chained_equations(self):
    """Two equations are written in one: a == b == c."""
    yield self.w == lp.der(self.flange.phi) == self.flange.tau / self.d


@laws(SolverError, "changes of mode within", "t = 0.5 s", "in brake", "lumped.hold")
def friction_by_the_sign_of_a_speed():
    """Dry friction is written with a condition on the speed, so that it cannot stick."""

    def law(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == lp.ops.where(self.w >= 0, self.d, -self.d)

    lp.simulate(braked(law), until=5.0)


@laws(StartError, "no values of brake.w meet", "t = 0 s", "start values")
def implicit_equation_without_solution():
    """A quantity is given only implicitly, by an equation that no value of it fulfils."""

    def law(self):
        yield lp.der(self.flange.phi) == self.w**2 + 2.0
        yield self.flange.tau == self.d * self.w

    lp.simulate(braked(law), until=1.0)


@laws(EquationError, "cart (Cart)", "uses w", "Inertia")
def part_of_a_stranger_in_an_equation():
    """An equation uses a quantity of a component that is not below it."""
    wheel = Inertia(J=1.0)

    class Cart(lp.Component):
        """Speed from a foreign wheel."""

        axle: Inertia = Inertia(J=1.0)
        v: lp.Var = lp.var("m/s", "velocity")

        def equations(self):
            yield self.v == 0.3 * wheel.w

    build(cart=Cart())


@laws(EquationError, "gear", "left side")
def lossless_without_an_explicit_angle():
    """The kinematics of a lossless part have no angle alone on the left."""

    class Gear(lp.Component):
        """Gear of ratio 2, the other way round."""

        flange_a = lp.Flange()
        flange_b = lp.Flange()

        def equations(self):
            a, b = self.flange_a, self.flange_b
            yield lp.lossless(2 * b.phi == a.phi, a, b)

    assemble_row(a=Inertia(J=1.0), gear=Gear(), b=Inertia(J=1.0))


@wrong_law(EquationError, "brake (Brake)", "yield a == b")
def equations_return_nothing(self):
    """equations() returns nothing: yield was forgotten."""
    self.w == lp.der(self.flange.phi)  # noqa: B015


@wrong_law(EquationError, "brake (Brake)", "der(d)", "a parameter is constant")
def derivative_of_a_parameter(self):
    """The derivative of a parameter is taken."""
    yield self.w == lp.der(self.flange.phi)
    yield self.flange.tau == self.d * self.w + lp.der(self.d)


@wrong_law(EquationError, "brake (Brake)", "numpy.sin", "lumped.ops")
def numpy_function(self):
    """A function of NumPy is applied to a variable."""
    yield self.w == lp.der(self.flange.phi)
    yield self.flange.tau == self.d * np.sin(self.w)


@laws(DeclarationError, "Beam.x", "in a list or dictionary", "x = [Piece() for _ in range(3)]")
def variables_in_a_list():
    """A component declares its variables in a list."""

    class Beam(lp.Component):
        x = tuple(lp.var("m", "deflection") for _ in range(3))


@laws(
    SingularModelError,
    "der(a.u1), der(a.u2)",
    "derivatives has rank 1, not 2",
    "C * (der(a.u1) - der(a.u2)) = -a.u1",
    "C * (der(a.u2) - der(a.u1)) = 1 - a.u2",
)
def capacitor_between_two_nodes():
    """Both equations of a capacitor between two nodes hold the same difference of derivatives."""

    class Amplifier(lp.Component):
        C: lp.Param = lp.param("F", "capacitance", 1e-6)
        u1: lp.Var = lp.var("V", "voltage of the first node")
        u2: lp.Var = lp.var("V", "voltage of the second node")

        def equations(self):
            yield self.C * (lp.der(self.u1) - lp.der(self.u2)) == -self.u1
            yield self.C * (lp.der(self.u2) - lp.der(self.u1)) == 1 - self.u2

    build(a=Amplifier())
