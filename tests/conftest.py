"""Small drive trains that several tests use."""

import pytest

import lumped as lp
from lumped.components import Inertia, Spring, Torque


class TwoMass(lp.Component):
    """Two inertias and a spring, free."""

    a: Inertia = Inertia(J=2.0)
    shaft: Spring = Spring(c=300.0)
    b: Inertia = Inertia(J=1.0)

    def connections(self):
        yield from lp.chain(self.a, self.shaft, self.b)


class DrivenMass(lp.Component):
    """One inertia and a torque."""

    drive: Torque = Torque(tau=3.0)
    body: Inertia = Inertia(J=2.0)

    def connections(self):
        yield from lp.chain(self.drive, self.body)


@pytest.fixture
def two_mass():
    return TwoMass()


@pytest.fixture
def driven_mass():
    return DrivenMass()
