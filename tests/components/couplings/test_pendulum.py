import numpy as np
import pytest
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import CentrifugalPendulum, Fixed, Inertia, Speed, Spring, Torque
from lumped.errors import ParameterError

M, R, r = 0.8, 0.09, 0.01  # order sqrt(R / r) = 3
ORDER = 3.0
J = 0.5


def carried(speed, swing=0.0, **pendulum):
    """A pendulum on a carrier whose speed is given."""
    part = CentrifugalPendulum(**{"m": M, "R": R, "r": r, **pendulum}, phi_rel=swing)
    return assemble_row(drive=Speed(w=speed), pendulum=part)


def drive(torque=0.0, damping=0.0):
    """A carrier with a pendulum that a shaft drives."""
    return assemble_row(
        motor=Inertia(J=3.0),
        shaft=Spring(c=4e3),
        carrier=Inertia(J=J),
        pendulum=CentrifugalPendulum(m=M, R=R, r=r, d=damping),
        torque=Torque(tau=torque),
    )


@pytest.mark.parametrize("speed", [20.0, 100.0, 400.0])
def test_small_swings_have_the_same_order_at_every_speed(speed):
    system = carried(speed)
    found = lp.modes(system).hertz * 2 * np.pi
    assert found.max() == pytest.approx(ORDER * speed, rel=1e-10)


@pytest.mark.parametrize("swing", [0.1, 1.0, 2.5])
def test_large_swings_are_those_of_a_pendulum_in_gravity(swing):
    # with the acceleration R w^2 and the length r
    speed = 50.0
    period = 4 * scipy.special.ellipk(np.sin(swing / 2) ** 2) / (ORDER * speed)
    run = lp.simulate(carried(speed, swing), until=period, rtol=1e-11)
    end = run.point(period)
    assert end["pendulum.phi_rel"] == pytest.approx(swing, rel=1e-8)
    assert abs(end["pendulum.w_rel"]) < 1e-6 * ORDER * speed
    half = run.point(period / 2)
    assert half["pendulum.phi_rel"] == pytest.approx(-swing, rel=1e-8)


def test_the_torque_of_its_order_does_not_shake_the_carrier():
    speeds = np.linspace(20.0, 150.0, 9)
    system = drive()
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["carrier.a", "shaft.tau", "pendulum.phi_rel", "pendulum.tau"],
        excitations={"torque.tau": {ORDER: 10.0, 2: 10.0}},
        at=lambda w: lp.start_point(
            system, start={"carrier.w": float(w), "motor.w": float(w), "shaft.phi_rel": 0.0}
        ),
    )
    assert response.magnitude("shaft.tau", ORDER).max() < 1e-11 * 10
    assert response.magnitude("carrier.a", ORDER).max() < 1e-11 * 10 / J
    # the swing that takes the whole torque, m r (R + r) (order w)^2 of it
    swing = 10.0 / (M * r * (R + r) * (ORDER * speeds) ** 2)
    assert response.magnitude("pendulum.phi_rel", ORDER) == pytest.approx(swing, rel=1e-9)
    # at other orders it is an inertia m (R + r)^2 / (1 - n^2 r / R) (Den Hartog)
    own = J + M * (R + r) ** 2 / (1 - 4 * r / R)
    for k, w in enumerate(2 * speeds):
        matrix = [[4e3 - 3.0 * w**2, -4e3], [-4e3, 4e3 - own * w**2]]
        motor, carrier = np.linalg.solve(matrix, [0.0, 10.0])
        assert response.magnitude("shaft.tau", 2)[k] == pytest.approx(
            4e3 * abs(motor - carrier), rel=1e-8
        )


def test_a_run_follows_lagranges_equations():
    # in the angles of carrier and swing, with their full matrix
    push, damping = 30.0, 2e-3
    system = drive(push * lp.ops.cos(90.0 * lp.time), damping)
    start = {"motor.w": 30.0, "carrier.w": 30.0, "shaft.phi_rel": 0.001, "pendulum.phi_rel": 0.8}
    run = lp.simulate(system, until=0.5, start=start, rtol=1e-10, atol=1e-12)

    def rates(t, y):
        twist, w0, w, a, wr = y
        cos, sin = np.cos(a), np.sin(a)
        matrix = np.array(
            [
                [J + M * (R**2 + r**2 + 2 * R * r * cos), M * (r**2 + R * r * cos)],
                [M * (r**2 + R * r * cos), M * r**2],
            ]
        )
        torque = push * np.cos(90.0 * t) - 4e3 * twist
        right = [
            torque + M * R * r * sin * (2 * w * wr + wr**2),
            -M * R * r * sin * w**2 - damping * wr,
        ]
        dw, dwr = np.linalg.solve(matrix, right)
        return [w - w0, 4e3 * twist / 3.0, dw, wr, dwr]

    wanted = scipy.integrate.solve_ivp(
        rates, (0, 0.5), [0.001, 30.0, 30.0, 0.8, 0.0], rtol=1e-11, atol=1e-13
    ).y[:, -1]
    end = run.point(0.5)
    names = ["shaft.phi_rel", "motor.w", "carrier.w", "pendulum.phi_rel", "pendulum.w_rel"]
    errors = [abs(end[name] - value) for name, value in zip(names, wanted, strict=True)]
    print([f"{e:.1e}" for e in errors])
    assert np.array(errors) == pytest.approx(0, abs=1e-7)
    assert np.abs(run["pendulum.phi_rel"]).max() > 0.5


@pytest.mark.parametrize("name", ["r", "R", "m"])
def test_a_pendulum_without_length_is_refused(name):
    with pytest.raises(ParameterError, match=f"pendulum.{name} = 0"):
        carried(10.0, **{name: 0.0})


def test_a_fixed_carrier_leaves_it_without_force():
    pendulum = CentrifugalPendulum(m=M, R=R, r=r, w_rel=2.0, phi_rel=0.3)
    run = lp.simulate(assemble_row(ground=Fixed(), pendulum=pendulum), until=1.0)
    assert run["pendulum.phi_rel"][-1] == pytest.approx(2.3, rel=1e-9)
