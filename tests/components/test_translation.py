"""Straight-line motion against closed forms."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, RackAndPinion, Ramp, Step, Torque
from lumped.components.translation import (
    Force,
    Mass,
    Position,
)
from lumped.errors import SolverError

GRID = np.linspace(0.0, 2.0, 81)


def assert_close(received, expected, rtol, what):
    error = np.abs(received - expected).max() / np.abs(expected).max()
    print(f"{what}: largest error {error:.1e} of the largest value")
    assert error <= rtol


def joined(*parts, **options):
    """The parts in a row, assembled."""
    return lp.assemble(lp.compose(row=list(parts), connections=lp.chain(*parts)), **options)


def test_a_force_pushes_its_support_back():
    force, mass, base = Force(f=6.0), Mass(m=2.0), Mass(m=3.0)
    model = lp.compose(
        force=force,
        mass=mass,
        base=base,
        connections=[
            lp.connect(force.flange, mass.flange_a),
            lp.connect(force.support, base.flange_a),
        ],
    )
    found = lp.simulate(lp.assemble(model), until=2.0, grid=4)
    received = [found["mass.v"][-1], found["base.v"][-1]]
    expected = [6.0, -4.0]
    assert received == pytest.approx(expected, rel=1e-13)


def test_a_rack_adds_its_mass_times_radius_squared_to_the_pinion():
    J, m, r, tau = 0.3, 5.0, 0.2, 4.0
    system = joined(
        Torque(tau=tau), Inertia(J=J), RackAndPinion(radius=r), Mass(m=m), keep=["row[3].s"]
    )
    found = lp.simulate(system, until=2.0, grid=4)
    rate = tau / (J + m * r**2)
    received = [found[name][-1] for name in ("row[1].w", "row[3].v", "row[3].s")]
    expected = [2.0 * rate, 2.0 * r * rate, 2.0 * r * rate]
    assert received == pytest.approx(expected, rel=1e-12)


def test_a_prescribed_position_takes_mass_times_acceleration():
    found = lp.simulate(
        joined(Position(s=0.1 * lp.ops.cos(5.0 * lp.time)), Mass(m=3.0)), until=2.0, grid=GRID
    )
    assert_close(found["row[1].v"], -0.5 * np.sin(5.0 * GRID), 1e-14, "velocity")
    assert_close(found["row[1].a"], -2.5 * np.cos(5.0 * GRID), 1e-14, "acceleration")
    assert_close(found["row[0].flange.f"], 7.5 * np.cos(5.0 * GRID), 1e-14, "force")


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
