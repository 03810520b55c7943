"""Sprockets against the polygon of the chain on them, closed forms and energy."""

import numpy as np
import pytest
import scipy
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import Inertia, Position, Sprocket, Torque, translation
from lumped.errors import EquationError

W, PITCH = 4.0, 0.0254


def pulled(z, turns=2.0, phase=0.0, w=W, **options):
    system = assemble_row(
        turn=Position(phi=w * lp.time),
        sprocket=Sprocket(z=z, pitch=PITCH, phase=phase),
        chain=translation.Mass(m=3.0),
        keep=["chain.s"],
    )
    return lp.simulate(system, until=2 * np.pi * turns / abs(w), **options)


@pytest.mark.parametrize("z", [6, 11, 17])
class TestPolygon:
    def test_speed_is_that_of_the_joint_along_the_strand(self, z):
        run = pulled(z, grid=777)
        y = (W * run.t + np.pi / z) % (2 * np.pi / z) - np.pi / z
        r = PITCH / 2 / np.sin(np.pi / z)
        assert np.abs(run["chain.v"] - W * r * np.cos(y)).max() < 1e-13
        ripple = 1 - run["chain.v"].min() / run["chain.v"].max()
        assert np.isclose(ripple, 1 - np.cos(np.pi / z), rtol=1e-3)

    def test_a_turn_takes_as_many_pitches_as_teeth(self, z):
        for phase in (0.0, 0.123):
            run = pulled(z, turns=3.0, phase=phase)
            way = run["chain.s"][-1] - run["chain.s"][0]
            assert np.isclose(way, 3 * z * PITCH, rtol=1e-13)

    def test_joints_take_over_at_the_corners_and_the_force_jumps(self, z):
        run = pulled(z, turns=1.0)
        expected = (np.arange(z) + 0.5) * 2 * np.pi / z / W
        assert np.allclose([event.time for event in run.events], expected, rtol=1e-12)
        at = expected[2]
        near = pulled(z, turns=1.0, grid=[0.0, at * (1 - 1e-9), at * (1 + 1e-9)])
        a = [near["chain.a"][np.argmin(np.abs(near.t - at * (1 + k)))] for k in (-1e-9, 1e-9)]
        assert np.isclose(a[1] - a[0], PITCH * W**2, rtol=1e-6)


def way_of(x, z):
    """Pitches that have passed, and what the joint that pulls has moved from the middle."""
    y = (x + np.pi / z) % (2 * np.pi / z) - np.pi / z
    return PITCH * np.round((x - y) * z / (2 * np.pi)) + PITCH / 2 / np.sin(np.pi / z) * np.sin(y)


@pytest.mark.parametrize("z", [7, 12])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5, -1.9])
@pytest.mark.parametrize("begin", [0.0, 0.02, -0.11])
def test_a_chain_in_prescribed_motion_turns_the_sprocket(z, phase, begin):
    """The angle is a root of the way, which grows with it; no state is left."""
    for v in (0.3, -0.3):
        system = assemble_rows(
            "body sprocket.flange_a",
            "sprocket.flange_b drive",
            body=Inertia(J=1.0),
            sprocket=Sprocket(z=z, pitch=PITCH, phase=phase),
            drive=translation.Position(s=begin + v * lp.time),
            keep=["body.phi"],
        )
        assert not system.state_names
        run = lp.simulate(system, until=1.0, grid=40)
        assert np.abs(way_of(run["body.phi"] + phase, z) - begin - v * run.t).max() < 1e-12
        y = (run["body.phi"] + phase + np.pi / z) % (2 * np.pi / z) - np.pi / z
        expected = v / (PITCH / 2 / np.sin(np.pi / z) * np.cos(y))
        away = np.abs(np.abs(y) - np.pi / z) > 1e-6
        assert np.abs(run["body.w"] / expected - 1)[away].max() < 1e-9
        assert len(run.events) >= 10


@pytest.mark.parametrize("phases", [(0.0, 0.0), (0.1, 0.5)])
def test_two_sprockets_on_a_rigid_strand_keep_their_energy(phases):
    system = assemble_rows(
        "motor first.flange_a",
        "first.flange_b second.flange_b",
        "second.flange_a drum",
        motor=Inertia(J=0.5, w=5.0, phi=0.0),
        first=Sprocket(z=9, pitch=PITCH, phase=phases[0]),
        second=Sprocket(z=14, pitch=PITCH, phase=phases[1]),
        drum=Inertia(J=2.0),
        keep=["drum.phi"],
    )
    run = lp.simulate(system, until=2.0, rtol=1e-10)
    first = way_of(run["motor.phi"] + phases[0], 9)
    assert np.abs(way_of(run["drum.phi"] + phases[1], 14) - first).max() < 1e-13
    energy = 0.25 * run["motor.w"] ** 2 + run["drum.w"] ** 2
    assert np.ptp(run["motor.w"]) > 0.1
    assert np.abs(energy / energy[0] - 1).max() < 1e-9


def test_rotor_and_chain_keep_their_energy_forwards_and_backwards():
    for w in (5.0, -5.0):
        system = assemble_row(
            rotor=Inertia(J=0.02, w=w, phi=0.1),
            sprocket=Sprocket(z=8, pitch=0.05),
            chain=translation.Mass(m=10.0),
        )
        run = lp.simulate(system, until=4.0, rtol=1e-10)
        energy = 0.01 * run["rotor.w"] ** 2 + 5 * run["chain.v"] ** 2
        assert len(run.events) > 20
        assert np.ptp(run["rotor.w"]) > 0.1
        assert np.abs(energy / energy[0] - 1).max() < 1e-8


def test_a_chain_drive_against_an_independent_integration():
    """Two sprockets, the strand between them as a spring; the second is half a pitch off."""
    J, c, tau, teeth, phases = 0.05, 2e5, -20.0, (9, 14), (0.0, np.pi / 14)
    system = assemble_rows(
        "turn first.flange_a",
        "first.flange_b strand second.flange_b",
        "second.flange_a wheel load",
        turn=Position(phi=W * lp.time),
        first=Sprocket(z=teeth[0], pitch=PITCH, phase=phases[0]),
        strand=translation.Spring(c=c),
        second=Sprocket(z=teeth[1], pitch=PITCH, phase=phases[1]),
        wheel=Inertia(J=J, phi=0.0, w=W * 9 / 14),
        load=Torque(tau=tau),
        keep=["wheel.phi"],
    )
    run = lp.simulate(system, until=1.0, grid=100, rtol=1e-10)

    def polygon(x, z):
        """Way and its slope: whole pitches, and the joint's projection on the strand."""
        r = PITCH / 2 / np.sin(np.pi / z)
        whole = np.floor(x * z / (2 * np.pi) + 0.5)
        y = x - whole * 2 * np.pi / z
        return whole * PITCH + r * np.sin(y), r * np.cos(y)

    def rates(t, q):
        near, _ = polygon(W * t + phases[0], teeth[0])
        far, slope = polygon(q[0] + phases[1], teeth[1])
        return q[1], (tau - c * (far - near) * slope) / J

    times, index = np.unique(run.t, return_inverse=True)
    found = scipy.integrate.solve_ivp(
        rates, (0, 1.0), (0.0, W * 9 / 14), "DOP853", times, rtol=1e-11, atol=1e-12, max_step=1e-4
    )
    assert np.ptp(run["wheel.w"]) > 0.1
    assert np.abs(run["wheel.w"] - found.y[1][index]).max() < 1e-6


@pytest.mark.parametrize("z", [2, 17.0])
def test_too_few_teeth_are_refused(z):
    with pytest.raises(EquationError, match=rf"sprocket .*z = {z}: .* at least 3 teeth"):
        pulled(z)
