"""Straight-line motion against closed forms."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, RackAndPinion, Ramp, Step, Torque
from lumped.components.translation import (
    Damper,
    Fixed,
    Force,
    Mass,
    Position,
    Speed,
    Spring,
    SpringDamper,
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


def test_a_mass_on_a_spring_and_damper_swings_down_as_the_closed_form_says():
    m, c, d, s0, v0, length = 1.5, 240.0, 4.0, 0.3, -2.0, 0.2
    wall = Fixed(s0=0.1)
    system = joined(wall, SpringDamper(c=c, d=d, s_rel0=length), Mass(m=m, s=s0, v=v0))
    found = lp.simulate(system, until=2.0, rtol=1e-11, grid=GRID)
    rest = 0.1 + length
    decay = d / (2 * m)
    w = np.sqrt(c / m - decay**2)
    x0 = s0 - rest
    b = (v0 + decay * x0) / w
    fade = np.exp(-decay * GRID)
    x = fade * (x0 * np.cos(w * GRID) + b * np.sin(w * GRID))
    v = -decay * x + fade * w * (b * np.cos(w * GRID) - x0 * np.sin(w * GRID))
    assert_close(found["row[2].s"], rest + x, 1e-9, "position")
    assert_close(found["row[2].v"], v, 1e-9, "velocity")
    assert_close(found["row[1].f"], c * x + d * v, 1e-9, "force")
    assert_close(found["row[0].flange.f"], c * x + d * v, 1e-9, "pull on the wall")


def test_spring_and_damper_side_by_side_are_a_spring_damper():
    wall, spring, damper, mass = Fixed(), Spring(c=50.0, s_rel0=0.1), Damper(d=3.0), Mass(m=2.0)
    apart = lp.compose(
        wall=wall,
        spring=spring,
        damper=damper,
        mass=mass,
        connections=[*lp.chain(wall, spring, mass), *lp.chain(wall, damper, mass)],
    )
    m, s, v = 2.0, 0.4, -0.7
    point = lp.start_point(lp.assemble(apart), start={"mass.s": s, "mass.v": v})
    received = [point["spring.f"], point["damper.f"], point["mass.flange_a.f"] / m]
    expected = [50.0 * (s - 0.1), 3.0 * v, -(50.0 * (s - 0.1) + 3.0 * v) / m]
    assert received == pytest.approx(expected, rel=1e-14)


def test_a_damper_slows_a_mass_exponentially():
    system = joined(Fixed(), Damper(d=3.0), Mass(m=2.0, s=0.0, v=5.0), keep=["row[2].s"])
    found = lp.simulate(system, until=2.0, rtol=1e-11, grid=GRID)
    assert_close(found["row[2].v"], 5.0 * np.exp(-1.5 * GRID), 1e-9, "velocity")
    assert_close(found["row[2].s"], 5.0 / 1.5 * (1 - np.exp(-1.5 * GRID)), 1e-9, "position")


def test_two_masses_swing_against_each_other_at_the_frequency_of_their_reduced_mass():
    a, b, c = 2.0, 3.0, 700.0
    system = joined(Mass(m=a), Spring(c=c), Mass(m=b))
    received = lp.modes(system).hertz
    expected = np.sqrt(c * (a + b) / (a * b)) / (2 * np.pi)
    assert received == pytest.approx([expected], rel=1e-13)


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


def test_a_shaken_spring_moves_its_mass_as_the_closed_form_says():
    m, c, size, w = 2.0, 162.0, 0.05, 4.0
    shaker = Position(s=size * lp.ops.sin(w * lp.time))
    found = lp.simulate(
        joined(shaker, Spring(c=c), Mass(m=m, s=0.0, v=0.0)), until=2.0, rtol=1e-11, grid=GRID
    )
    own = np.sqrt(c / m)
    gain = size * own**2 / (own**2 - w**2)
    expected = gain * (np.sin(w * GRID) - w / own * np.sin(own * GRID))
    assert_close(found["row[2].s"], expected, 1e-9, "position")
    pull = c * (expected - size * np.sin(w * GRID))
    assert_close(found["row[0].flange.f"], pull, 1e-9, "pull on the shaker")


def test_a_prescribed_position_takes_mass_times_acceleration():
    found = lp.simulate(
        joined(Position(s=0.1 * lp.ops.cos(5.0 * lp.time)), Mass(m=3.0)), until=2.0, grid=GRID
    )
    assert_close(found["row[1].v"], -0.5 * np.sin(5.0 * GRID), 1e-14, "velocity")
    assert_close(found["row[1].a"], -2.5 * np.cos(5.0 * GRID), 1e-14, "acceleration")
    assert_close(found["row[0].flange.f"], 7.5 * np.cos(5.0 * GRID), 1e-14, "force")


def test_a_prescribed_speed_stretches_a_spring_by_its_integral():
    m, c, speed = 2.0, 128.0, 0.75
    row = (Speed(v=speed), Spring(c=c, s_rel=0.0), Mass(m=m, s=0.0, v=0.0))
    system = joined(*row, keep=["row[2].s"])
    found = lp.simulate(system, until=2.0, rtol=1e-11, grid=GRID)
    w = np.sqrt(c / m)
    assert_close(found["row[2].s"], speed * (GRID - np.sin(w * GRID) / w), 1e-9, "position")
    assert_close(found["row[1].f"], -c * speed * np.sin(w * GRID) / w, 1e-9, "force")


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
