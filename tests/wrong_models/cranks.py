"""Cranks and their strokes."""

import lumped as lp
from lumped.components import CrankSlider, Position, StrokeLoad, translation
from lumped.errors import EquationError, ParameterError, SolverError

from . import Table
from .parts import assemble_row

wrong = Table("Cranks")


def turned_crank(**given):
    """A crank-slider on a shaft of prescribed angle."""
    return assemble_row(turn=Position(phi=lp.time), crank=CrankSlider(r=0.6, **given))


@wrong(EquationError, "crank (CrankSlider)", "assembly = 2", "the start values choose")
def unknown_assembly():
    """The assembly of a crank-slider is given a number that means none."""
    turned_crank(L=2.0, assembly=2)


@wrong(ParameterError, "crank.L = 0.2 m (length of the rod)", "max(0, abs(e) - r) = 0.4 m")
def rod_that_never_reaches_the_slide():
    """The slide of a crank passes further away than crank and rod reach."""
    turned_crank(L=0.2, e=1.0, assembly=0)


@wrong(
    ParameterError,
    "crank.L = 0.8 m (length of the rod)",
    "r + abs(e) + 1e-08 * (r + abs(e)) = 0.9 m",
)
def rod_too_short_for_a_turn():
    """A rod is shorter than crank radius and offset together."""
    turned_crank(L=0.8, e=-0.3)


@wrong(SolverError, "rod.phi is not a number", "t = 0.986", "prescribed motion")
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


@wrong(ParameterError, "press.s_1 = 0 m", "s_0")
def stroke_backwards():
    """The end of a working stroke lies before its begin."""
    model = assemble_row(
        press=StrokeLoad(forward=1.0, backward=0.0, s_0=0.3, s_1=0.0, p=1.0, q=1.0),
        ram=translation.Mass(m=1.0),
    )
    lp.start_point(model)
