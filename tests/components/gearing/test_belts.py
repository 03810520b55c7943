"""Belts against closed forms of two springs, geometry of the tangents, and energy."""

import numpy as np
import pytest
from checks import refused
from rows import assemble_rows, in_a_row
from scipy.spatial import ConvexHull

import lumped as lp
from lumped.components import Belt, Fixed, IdealGear, Inertia, Position, Torque
from lumped.errors import ParameterError

R_A, R_B, D, EA, F_0 = 0.1, 0.25, 0.8, 4e5, 300.0
BELT = {"r_a": R_A, "r_b": R_B, "distance": D, "EA": EA, "F_0": F_0}


def stiffness(crossed=False):
    """Of one strand, from its free length."""
    offset = R_A + R_B if crossed else R_B - R_A
    return EA / np.sqrt(D**2 - offset**2)


def drive(belt, torque=0.0, load=0.0):
    """Two bodies joined by a belt."""
    return in_a_row(
        torque=Torque(tau=torque),
        motor=Inertia(J=0.02),
        belt=belt,
        wheel=Inertia(J=0.5),
        load=Torque(tau=load),
    )


def twisted(belt, angle):
    """Pulley b held, pulley a turned to an angle that may depend on the time."""
    rows = ("turn belt wall", "belt.support base.flange")
    return assemble_rows(*rows, turn=Position(phi=angle), belt=belt, wall=Fixed(), base=Fixed())


class TestLinear:
    @pytest.mark.parametrize("crossed", [False, True])
    def test_stiffness_at_the_wheel_is_that_of_both_strands(self, crossed):
        point = lp.start_point(twisted(Belt(**BELT, crossed=crossed), 1e-3))
        received = -point["turn.flange.tau"] / 1e-3
        assert abs(received / (2 * stiffness(crossed) * R_A**2) - 1) < 1e-12

    @pytest.mark.parametrize("crossed", [False, True])
    def test_two_bodies_swing_at_their_natural_frequency(self, crossed):
        modes = lp.modes(lp.assemble(drive(Belt(**BELT, crossed=crossed))))
        received = 2 * np.pi * modes.hertz.max()
        expected = np.sqrt(2 * stiffness(crossed) * (R_A**2 / 0.02 + R_B**2 / 0.5))
        assert abs(received / expected - 1) < 1e-12

    def test_damping_is_that_of_both_strands(self):
        d = 40.0
        found = lp.linearise(lp.assemble(drive(Belt(**BELT, d=d)))).A
        received = np.linalg.eigvals(found)
        inverse = R_A**2 / 0.02 + R_B**2 / 0.5  # of the mass that moves along the belt
        expected = -d * inverse
        assert abs(received.real.min() / expected - 1) < 1e-9

    @pytest.mark.parametrize(("crossed", "ratio"), [(False, R_B / R_A), (True, -R_B / R_A)])
    def test_stiff_belt_is_an_ideal_gear(self, crossed, ratio):
        tight = Belt(**(BELT | {"EA": 1e13, "F_0": 1e6}), d=1e4, crossed=crossed)
        soft, rigid = (
            lp.simulate(lp.assemble(drive(part, torque=2.0, load=-1.0)), until=2.0)
            for part in (tight, IdealGear(ratio=ratio))
        )
        assert abs(soft["motor.w"][-1] / rigid["motor.w"][-1] - 1) < 1e-5
        assert abs(soft["wheel.w"][-1] / rigid["wheel.w"][-1] - 1) < 1e-5


class TestSlack:
    @pytest.mark.parametrize("crossed", [False, True])
    @pytest.mark.parametrize("way", [1, -1])
    def test_strand_goes_slack_at_twice_its_pretension_and_half_the_stiffness_is_left(
        self, crossed, way
    ):
        c, rate = stiffness(crossed), 0.05
        until = 3 * F_0 / (c * R_A * rate)
        run = lp.simulate(twisted(Belt(**BELT, crossed=crossed), way * rate * lp.time), until=until)
        e = way * R_A * rate * run.t
        assert [event.time for event in run.events] == pytest.approx([until / 3], rel=1e-9)
        first, second = np.maximum(F_0 + c * e, 0), np.maximum(F_0 - c * e, 0)
        assert np.abs(run["belt.T_1"] - first).max() < 1e-8 * F_0
        assert np.abs(run["belt.T_2"] - second).max() < 1e-8 * F_0
        at_slack = np.interp(until / 3, run.t, -run["turn.flange.tau"])
        assert abs(at_slack - way * 2 * F_0 * R_A) < 1e-6 * F_0
        last = -run["turn.flange.tau"][-1]
        assert abs(last - way * (F_0 + 3 * F_0) * R_A) < 1e-8 * F_0

    def test_chain_without_pretension_pulls_with_one_strand(self):
        chain = Belt(**(BELT | {"F_0": 0.0}))
        model = drive(chain, torque=3.0)
        run = lp.simulate(lp.assemble(model), until=0.05, rtol=1e-9)
        inverse = R_A**2 / 0.02 + R_B**2 / 0.5
        w = np.sqrt(stiffness() * inverse)
        first = run.t < np.pi / w  # from rest: half the amplitude is the static stretch
        static = (3.0 * R_A / 0.02) / w**2
        expected = static * (1 - np.cos(w * run.t))
        assert np.abs(run["belt.e"] - expected)[first].max() < 1e-7 * static
        assert not run["belt.T_2"][first].any()


class TestForces:
    def tangents(self, crossed):
        """Directions from pulley a to b of both strands, and of the points where they touch."""
        if not crossed:
            turn = np.linspace(0, 2 * np.pi, 200_000, endpoint=False)
            circle = np.column_stack([np.cos(turn), np.sin(turn)])
            points = np.vstack([R_A * circle, R_B * circle + [D, 0]])
            edges = points[ConvexHull(points).simplices]
            edges = edges[np.argsort(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1))[-2:]]
            strands = [edge[np.argsort(edge[:, 0])] for edge in edges]
        else:
            # inner tangents cross on the line of the axes where it is divided as the radii are
            middle = np.array([D * R_A / (R_A + R_B), 0.0])
            x, y = R_A**2 / middle[0], R_A * np.sqrt(1 - (R_A / middle[0]) ** 2)
            strands = [[(x, side * y), middle] for side in (1, -1)]
        strands = sorted((np.array(s) for s in strands), key=lambda s: -s[0][1])  # upper first
        return [(s[0], (s[1] - s[0]) / np.linalg.norm(s[1] - s[0])) for s in strands]

    @pytest.mark.parametrize("crossed", [False, True])
    def test_forces_on_the_shafts_are_those_of_the_tangents(self, crossed):
        point = lp.start_point(twisted(Belt(**BELT, crossed=crossed), 3e-3))
        pulls = zip((point["belt.T_1"], point["belt.T_2"]), self.tangents(crossed), strict=True)
        force, torque = np.zeros(2), 0.0
        for tension, (place, direction) in pulls:
            force += tension * direction
            torque += tension * (place[0] * direction[1] - place[1] * direction[0])
        assert np.abs(force - [point["belt.F"], point["belt.Q"]]).max() < 1e-4 * F_0
        assert abs(torque - point["turn.flange.tau"]) < 1e-4 * F_0 * R_A
        # the frame takes the pair of forces across
        assert abs(point["base.flange.tau"] + D * point["belt.Q"]) < 1e-10 * F_0

    def test_pretension_alone_pulls_the_axes_together(self):
        point = lp.start_point(twisted(Belt(**BELT), 0.0))
        assert abs(point["belt.F"] - 2 * F_0 * np.sqrt(1 - ((R_B - R_A) / D) ** 2)) < 1e-10
        assert abs(point["belt.Q"]) < 1e-10


class TestWrong:
    def test_pulleys_that_overlap(self):
        text = "belt.distance = 0.3 m (distance of the axes) must be greater than r_a + r_b = 0.35"
        close = drive(Belt(**(BELT | {"distance": 0.3})))
        refused(ParameterError, lambda: lp.assemble(close), text)

    def test_radius_that_grows_until_pulleys_overlap(self):
        system = lp.assemble(drive(Belt(**BELT)))
        with pytest.raises(ParameterError, match=r"greater than r_a \+ r_b = 0\.85 m"):
            lp.start_point(system, parameters={"belt.r_b": 0.75})
