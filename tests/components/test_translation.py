"""Straight-line motion against closed forms."""

import pytest

import lumped as lp
from lumped.components import Ramp, Step
from lumped.components.translation import (
    Mass,
    Position,
)
from lumped.errors import SolverError


class Guided(lp.Component):
    """A signal that prescribes the position of a mass: s = y."""

    signal: lp.Component = Step(height=0.1, start_time=0.3)
    guide: Position = Position()
    slide: Mass = Mass(m=2.0)

    def connections(self):
        yield lp.connect(self.signal.y, self.guide.s)
        yield from lp.chain(self.guide, self.slide)


def test_a_jump_of_a_prescribed_position_names_the_rigid_mass():
    with pytest.raises(SolverError, match=r"slide\.s .*jump from 0 to 0\.1 at t = 0\.3"):
        lp.simulate(lp.assemble(Guided()), until=1.0)


def test_a_corner_of_a_prescribed_position_names_the_rigid_mass():
    model = Guided(signal=Ramp(height=0.1, duration=0.5, start_time=0.3))
    with pytest.raises(SolverError, match=r"slide\.v .*jump from -?0 to 0\.2 at t = 0\.3"):
        lp.simulate(lp.assemble(model), until=1.0)
