"""Cardan joints against vectors in space, closed forms and an independent integration."""

import numpy as np
import pytest
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import (
    CardanJoint,
    CardanShaft,
    Damper,
    Fixed,
    Inertia,
    NonlinearSpring,
    Position,
    Speed,
    Spring,
    Torque,
)
from lumped.errors import ParameterError

TURNS = np.linspace(-7 * np.pi, 9 * np.pi, 321)
"""Every 9 degrees, so quarter turns too."""


def axes_of_the_forks(x, y, beta):
    """Axis of each fork in space: shaft a along z, shaft b in the plane of x and z."""
    zero = np.zeros_like(x)
    a = np.stack([np.cos(x), np.sin(x), zero], -1)
    b = np.stack([-np.cos(beta) * np.sin(y), np.cos(y), np.sin(beta) * np.sin(y)], -1)
    return a, b


def turned(joint, **more):
    """The joint turned at a over several turns, with a torque on the body behind."""
    return lp.simulate(
        assemble_row(
            turn=Position(phi=TURNS[0] + 10 * lp.time),
            joint=joint,
            body=Inertia(J=2.0),
            load=Torque(tau=-3.0),
            keep=["body.phi", "turn.phi"],
            **more,
        ),
        grid=(TURNS - TURNS[0]) / 10,
        until=(TURNS[-1] - TURNS[0]) / 10,
        rtol=1e-10,
    )


class TestJoint:
    @pytest.mark.parametrize("beta", [0.0, 0.3, 1.2])
    def test_the_axes_of_the_cross_stay_at_right_angles(self, beta):
        run = turned(CardanJoint(beta=beta, phase=0.4))
        a, b = axes_of_the_forks(run["turn.phi"] + 0.4, run["body.phi"] + 0.4, beta)
        assert np.abs((a * b).sum(-1)).max() < 1e-13
        assert np.abs(run["body.phi"] - run["turn.phi"]).max() < np.pi / 2

    def test_quarter_turns_are_passed_exactly(self):
        run = turned(CardanJoint(beta=0.7))
        quarter = slice(None, None, 10)
        assert np.abs(run["body.phi"][quarter] - run["turn.phi"][quarter]).max() < 1e-13

    def test_speed_is_that_of_the_books(self):
        run = turned(CardanJoint(beta=0.7))
        expected = 10 * np.cos(0.7) / (1 - (np.sin(0.7) * np.cos(run["turn.phi"])) ** 2)
        assert np.abs(run["body.w"] / expected - 1).max() < 1e-12
        assert np.isclose(run["body.w"].max() * run["body.w"].min(), 100, rtol=1e-12)

    def test_orders_of_the_excitation_are_powers_of_the_squared_tangent(self):
        beta, n = 0.6, 64
        run = lp.simulate(
            assemble_row(
                turn=Position(phi=lp.time),
                joint=CardanJoint(beta=beta),
                body=Inertia(J=1.0),
                keep=["body.phi"],
            ),
            until=2 * np.pi * (n - 1) / n,
            grid=2 * np.pi * np.arange(n) / n,
        )
        found = np.fft.rfft(run["body.phi"] - run.t) / (n / 2)
        k = np.tan(beta / 2) ** 2
        for order in range(1, 7):
            expected = 0 if order % 2 else k ** (order // 2) / (order // 2)
            assert abs(-found[order].imag - expected) < 1e-14
            assert abs(found[order].real) < 1e-14

    def test_the_moment_of_the_cross_has_the_bending_moments(self):
        """A moment at right angles to both axes; its parts along the shafts are the torques."""
        beta = 0.8
        run = turned(CardanJoint(beta=beta))
        a, b = axes_of_the_forks(run["turn.phi"], run["body.phi"], beta)
        normal = np.cross(a, b)
        shafts = np.array([0.0, 0.0, 1.0]), np.array([np.sin(beta), 0.0, np.cos(beta)])
        moment = normal * (run["joint.flange_a.tau"] / (normal @ shafts[0]))[:, None]
        assert np.abs(moment @ shafts[1] + run["joint.flange_b.tau"]).max() < 1e-9
        for name, shaft in zip("ab", shafts, strict=True):
            bending = np.linalg.norm(np.cross(moment, shaft), axis=-1)
            assert np.abs(bending - np.abs(run[f"joint.M_{name}"])).max() < 1e-9
            assert bending.max() > 1

    def test_it_keeps_the_energy_of_two_flywheels(self):
        run = lp.simulate(
            assemble_row(
                motor=Inertia(J=0.5, w=20.0, phi=0.3),
                joint=CardanJoint(beta=0.9),
                drum=Inertia(J=2.0),
            ),
            until=5.0,
            rtol=1e-10,
        )
        energy = 0.25 * run["motor.w"] ** 2 + run["drum.w"] ** 2
        assert np.ptp(run["motor.w"]) > 5
        assert np.abs(energy / energy[0] - 1).max() < 1e-8

    @pytest.mark.parametrize("beta", [np.pi / 2, -0.1])
    def test_a_bend_of_a_right_angle_is_refused(self, beta):
        with pytest.raises(ParameterError, match=r"joint\.beta = .* rad .bend angle"):
            assemble_row(turn=Speed(w=1.0), joint=CardanJoint(beta=beta), body=Inertia(J=1.0))


class TestShaft:
    def test_with_equal_angles_and_parallel_forks_both_ends_turn_alike(self):
        beta = 0.5
        rigid = assemble_row(
            turn=Speed(w=10.0),
            first=CardanJoint(beta=beta, phase=0.2),
            second=CardanJoint(beta=beta, phase=0.2 + np.pi / 2),
            body=Inertia(J=2.0),
        )
        run = lp.simulate(rigid, until=2.0)
        assert np.abs(run["body.w"] - 10).max() < 1e-11

    @pytest.mark.parametrize("psi", [0.0, 0.3, np.pi / 2])
    def test_twist_is_what_is_left_between_both_joints(self, psi):
        """Flange b is held, so that the end of the shaft at joint b stands."""
        beta_a, beta_b = 0.4, 0.6
        run = lp.simulate(
            assemble_row(
                turn=Position(phi=1.5 * lp.time),
                shaft=CardanShaft(beta_a=beta_a, beta_b=beta_b, psi=psi, c=1e3),
                wall=Fixed(),
                keep=["turn.phi"],
            ),
            until=1.0,
            grid=20,
        )
        first = np.arctan2(np.sin(run["turn.phi"]), np.cos(beta_a) * np.cos(run["turn.phi"]))
        # fork b of the second joint stands at psi + pi/2 from the normal of its plane
        fork = psi + np.pi / 2
        end = np.arctan2(np.sin(fork) * np.cos(beta_b), np.cos(fork)) - fork
        assert np.abs(run["shaft.shaft.phi_rel"] - (end - first)).max() < 1e-12

    def test_excitation_of_a_drive_against_an_independent_integration(self):
        w, beta, c, J, d = 30.0, 0.35, 900.0, 0.4, 1.5
        run = lp.simulate(
            assemble_row(
                turn=Position(phi=w * lp.time),
                shaft=CardanShaft(beta_a=beta, beta_b=0.0, c=c),
                drum=Inertia(J=J, phi=0.0, w=w),
                brake=Damper(d=d),
                wall=Fixed(),
                keep=["drum.phi"],
            ),
            until=2.0,
            grid=200,
            rtol=1e-10,
        )

        def rates(t, x):
            turns = np.round(w * t / (2 * np.pi))
            far = np.arctan2(np.sin(w * t), np.cos(beta) * np.cos(w * t)) + 2 * np.pi * turns
            return x[1], (c * (far - x[0]) - d * x[1]) / J

        found = scipy.integrate.solve_ivp(
            rates, (0, 2.0), (0.0, w), "DOP853", t_eval=run.t, rtol=1e-12, atol=1e-12
        )
        assert np.abs(run["drum.w"] - found.y[1]).max() < 1e-7

    def test_it_keeps_the_energy_of_two_flywheels(self):
        run = lp.simulate(
            assemble_row(
                motor=Inertia(J=0.5, w=20.0),
                shaft=CardanShaft(beta_a=0.5, beta_b=0.2, psi=0.4, c=500.0),
                drum=Inertia(J=2.0, w=18.0),
            ),
            until=3.0,
            rtol=1e-10,
        )
        twist = run["shaft.shaft.phi_rel"]
        energy = 0.25 * run["motor.w"] ** 2 + run["drum.w"] ** 2 + 250 * twist**2
        assert np.ptp(twist) > 0.05
        assert np.abs(energy / energy[0] - 1).max() < 1e-8


class TestBetweenSprings:
    """A joint without inertia, whose angle follows from the balance of torques."""

    @pytest.mark.parametrize("beta", [0.1, 0.3, 1.0])
    @pytest.mark.parametrize("c", [(1e3, 1e3), (1e3, 1e5), (1e6, 1e2), (1.0, 1e-2)])
    def test_torques_reverse_as_in_an_independent_integration(self, beta, c):
        """The torque of the motor and the bend reverse both springs again and again."""
        J, phase, w, load = (0.5, 2.0), 0.2, 40.0, c[1] / 100
        system = assemble_row(
            load=Torque(tau=load * lp.ops.sin(9 * lp.time)),
            motor=Inertia(J=J[0], w=w, phi=0.0),
            a=Spring(c=c[0]),
            joint=CardanJoint(beta=beta, phase=phase),
            b=Spring(c=c[1]),
            drum=Inertia(J=J[1], w=w, phi=end_of(0.0, beta, phase)[0]),
            keep=["motor.phi", "drum.phi"],
        )
        assert not system.structure.implicit
        run = lp.simulate(system, until=1.0, grid=50, rtol=1e-10)

        def rates(t, z):
            """The joint stands where the springs hold the least energy."""
            motor, drum = z[0], z[2]

            def pull(x):
                end, ratio = end_of(x, beta, phase)
                return c[0] * (x - motor) + ratio * c[1] * (end - drum)

            x = scipy.optimize.brentq(pull, motor - 2, motor + 2, xtol=1e-14, rtol=1e-14)
            back = c[1] * (end_of(x, beta, phase)[0] - drum)
            tau = c[0] * (x - motor) + load * np.sin(9 * t)
            return z[1], tau / J[0], z[3], back / J[1]

        begin = (0.0, w, end_of(0.0, beta, phase)[0], w)
        found = scipy.integrate.solve_ivp(
            rates, (0, 1.0), begin, "DOP853", t_eval=run.t, rtol=1e-11, atol=1e-12
        )
        twist = run["b.phi_rel"]
        assert (np.diff(np.sign(twist[1:])) != 0).sum() >= 1
        names = ("motor.phi", "motor.w", "drum.phi", "drum.w")
        for name, expected in zip(names, found.y, strict=True):
            assert np.abs(run[name] - expected).max() < 1e-7

    @pytest.mark.parametrize("springs", ["CC", "CN", "NC", "NN"])
    def test_nonlinear_springs_keep_their_energy(self, springs):
        """Rows of twist and torque below whose first bend the spring is linear."""
        made = {
            "C": lambda: Spring(c=800.0),
            "N": lambda: NonlinearSpring(characteristic=((0, 0), (0.9, 720.0), (1.0, 1000.0))),
        }
        a, b = (made[kind]() for kind in springs)
        run = lp.simulate(
            assemble_row(
                motor=Inertia(J=0.5, w=20.0),
                a=a,
                joint=CardanJoint(beta=0.6),
                b=b,
                drum=Inertia(J=2.0, w=18.0),
            ),
            until=2.0,
            rtol=1e-10,
        )
        twists = run["a.phi_rel"] ** 2 + run["b.phi_rel"] ** 2
        energy = 0.25 * run["motor.w"] ** 2 + run["drum.w"] ** 2 + 400 * twists
        assert 0.9 > np.abs(run["a.phi_rel"]).max() > 0.05
        assert np.abs(energy / energy[0] - 1).max() < 1e-8

    @pytest.mark.parametrize("order", ["torque first", "torque last"])
    def test_a_torque_at_the_joint_itself_twists_the_spring(self, order):
        """``c phi_rel`` is the torque over the ratio of speeds, which a long pull shows."""
        parts = {
            "pull": Torque(tau=5 * lp.ops.sin(lp.time)),
            "joint": CardanJoint(beta=0.5, phase=0.1),
            "spring": Spring(c=2e3),
            "drum": Inertia(J=2.0),
        }
        names = list(parts) if order == "torque first" else list(parts)[::-1]
        run = lp.simulate(
            assemble_row(
                **{name: parts[name] for name in names},
                keep=["joint.flange_a.phi", "joint.flange_b.phi"],
            ),
            until=6.0,
            rtol=1e-10,
        )
        _, ratio = end_of(run["joint.flange_a.phi"], 0.5, 0.1)
        ratio, sign = (1 / ratio, -1) if order == "torque first" else (ratio, 1)
        expected = sign * 5 * np.sin(run.t) * ratio
        assert np.ptp(run["joint.flange_a.phi"]) > 3
        assert np.abs(run["spring.tau"] - expected).max() < 1e-9


def end_of(x, beta, phase):
    """Angle of shaft b, within half a turn of that of shaft a, and the ratio of their speeds."""
    fork = x + phase
    y = np.arctan2(np.sin(fork), np.cos(beta) * np.cos(fork))
    y = y + 2 * np.pi * np.round((fork - y) / (2 * np.pi))
    return y - phase, np.cos(beta) / (1 - (np.sin(beta) * np.cos(fork)) ** 2)
