"""The rotary arm under position control: reference file, pick-up, stalls, extremes."""

import numpy as np
import pytest
from arm_by_hand import EMPTY, LOADED, ROTOR, data, friction, gravity
from scipy.integrate import solve_ivp, trapezoid

from lumped.models.rotary_arm import jump
from lumped.models.rotary_arm.control import (
    AIM,
    BANDWIDTH,
    BEGIN,
    J_M,
    instants,
    run_controlled,
)
from lumped.models.rotary_arm.cycle import ADOPTED
from lumped.models.rotary_arm.loads import FIRST

FIRST_MOTOR = {"motor.tau_max": 2 * FIRST}
RATIO, ETA = 50.0, 0.85
MOTOR = (ROTOR + LOADED) / RATIO**2  # kg.m2  all that turns, at the motor
LIFT = RATIO * ETA
"""Torque at the arm over that of a motor that drives, the reducer's loss taken off."""
SPEED_GAIN, INTEGRAL_TIME = 30.0, 5 / 30.0  # 1/s, s
LAG = 0.005  # s, of the torque
RAMP, SLOW, SECTOR = 1.38, 0.17, 0.02  # rad/s2, rad/s, rad/s
COLUMNS = ("arm.phi", "arm.trays.w", "ramp.x", "motor.x", "motor.tau")
P, R = ADOPTED.points["P"], ADOPTED.points["R"]


def following(**grid):
    """The run from the second line of the reference file on, and the time of that line.

    The first 22 ms start from rest, where the file's friction acts forward all the time.
    """
    reference = data("closed_loop")[1:]
    t0, phi, w, ramp, integral, torque, _ = reference[0]
    start = {"arm.phi": phi, "arm.trays.w": w, "ramp.x": ramp}
    start |= {"motor.x": integral / (BANDWIDTH * J_M), "motor.tau": torque}
    until = reference[-1, 0] - t0
    return run_controlled(until=until, rtol=1e-11, start=start, **grid), t0


def deviations(run, row, values, ranges):
    """Of the columns of a reference file, over the ranges of the signals."""
    scales = [BANDWIDTH * J_M if name == "motor.x" else 1.0 for name in COLUMNS]
    received = np.array([k * run[name][row] for k, name in zip(scales, COLUMNS, strict=True)])
    return np.abs(received.T - values) / ranges


def test_it_follows_the_reference_file_from_its_second_line_on():
    reference = data("closed_loop")[1:]
    run, t0 = following(grid=reference[:, 0] - reference[0, 0])
    row = [np.abs(run.t - t).argmin() for t in reference[:, 0] - t0]
    values = reference[:, 1:6]
    errors = deviations(run, row, values, np.ptp(values, axis=0)).max(axis=0)
    assert errors.max() < 1e-6
    near, put = run["near.y"][row] == 1, run["arm.put_down.y"][row] == 1
    mode = np.select([near, put, run["arm.carried.y"][row] == 1], [4, 3, 1], 0)
    np.testing.assert_array_equal(mode, reference[:, 6])


def test_it_meets_the_events_of_the_reference_file():
    events, reference = data("closed_loop_events"), data("closed_loop")
    run, t0 = following(grid=500)
    found = np.array(instants(run))
    assert found + t0 == pytest.approx(events[:, 0], abs=3e-9)
    before = [np.flatnonzero(run.t == t)[0] for t in found]
    errors = deviations(run, before, events[:, 2:], np.ptp(reference[:, 1:6], axis=0))
    assert errors.max() < 1e-6


def surplus(y):
    """Torque of the motor at the arm beyond weight and friction without the mandrel."""
    return LIFT * y[4] - gravity(y[0], 0) - friction(0)


def leave(t, y):
    """Rates of angle, speed, ramp, integrator and torque after S; the arm waits for a surplus."""
    _, w, ramp, integral, tau = y
    error = RATIO * (ramp - w)
    wanted = SPEED_GAIN * MOTOR * error + integral
    left = surplus(y)
    return [
        w,
        0.0 if w <= 0 and left <= 0 else left / (EMPTY + ETA * ROTOR),
        RAMP * np.clip((SLOW - ramp) / SECTOR, -1, 1),
        SPEED_GAIN * MOTOR / INTEGRAL_TIME * error,
        (wanted - tau) / LAG,
    ]


def test_from_rest_the_arm_waits_until_the_torque_suffices():
    # a second formulation with stiction
    assert J_M == pytest.approx(MOTOR, rel=1e-12)
    held = gravity(BEGIN, 0) / LIFT
    assert run_controlled(until=0.01, grid=2)["motor.tau"][0] == pytest.approx(held, rel=1e-12)
    times = np.linspace(0.0, 0.4, 21)

    def breaks_away(t, y):
        return surplus(y)

    # first to the breakaway, then on, so that the kink is met
    breaks_away.terminal = True
    tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
    still = solve_ivp(leave, (0, 0.1), [BEGIN, 0.0, 0.0, held, held], events=breaks_away, **tight)
    y = still.y[:, -1] + [0, 1e-15, 0, 0, 0]
    begin = still.t[-1]
    moving = solve_ivp(leave, (begin, 0.4), y, t_eval=times[1:], max_step=1e-3, **tight)
    run = run_controlled(until=0.4, grid=20, rtol=1e-11)
    row = [np.abs(run.t - t).argmin() for t in times[1:]]
    assert begin == pytest.approx(0.0054, abs=1e-4)
    assert next(e.time for e in run.events if e.component == "arm.journal") == pytest.approx(
        begin,
        abs=1e-8,  # shares of what table and journals bear are known to 1e-7
    )
    for name, values in zip(COLUMNS, moving.y, strict=True):
        scale = SPEED_GAIN * MOTOR if name == "motor.x" else 1.0
        assert scale * run[name][row] == pytest.approx(values, rel=1e-6, abs=1e-8)


def test_momentum_is_kept_at_the_pick_up_and_speed_at_the_release():
    run = run_controlled(until=6.0, rtol=1e-10)
    found = {e.after: e.time for e in reversed(run.events) if e.component == "arm.carried"}
    taken, put = found["u >= on"], found["u >= off"]
    ratio = (EMPTY + ROTOR) / (LOADED + ROTOR)
    assert ratio == pytest.approx(0.52448, abs=5e-6)
    assert jump(run, taken) == pytest.approx(ratio, rel=1e-12)
    assert jump(run, put) == pytest.approx(1.0, abs=1e-14)
    k = np.nonzero(run.t == taken)[0]
    assert run["arm.phi"][k] == pytest.approx(P, abs=1e-10)
    assert run["arm.phi"][run.t == put] == pytest.approx(R, abs=1e-10)
    # the energy of the plastic impact, and that of the mandrel which the rollers stop
    before, after = run["arm.trays.w"][k[[0, -1]]]
    losses = {e.time: e.loss for e in run.events if e.loss}
    lost = (EMPTY + ROTOR) * before**2 / 2 - (LOADED + ROTOR) * after**2 / 2
    assert losses[taken] == pytest.approx(lost, rel=1e-9)
    last = run["arm.trays.w"][run.t == put][0]
    assert losses[put] == pytest.approx((LOADED - EMPTY) * last**2 / 2, rel=1e-9)
    assert np.abs(run["arm.mandrel.w"][run.t > put]).max() < 1e-14


# -- stalls and the table ----------------------------------------------------------------------


@pytest.mark.parametrize("eta", [0.60, 0.80, 0.83])
def test_the_first_motor_stalls_past_the_pick_up_and_holds_the_mandrel(eta):
    weak = FIRST_MOTOR | {"reducer.eta": eta}
    run = run_controlled(until=8.0, grid=800, parameters=weak)
    rest = max(e.time for e in run.events if e.component == "arm.journal")
    late = run.t > rest
    assert late.sum() > 100
    assert (run["arm.trays.w"][late] == 0).all()
    assert np.ptp(run["arm.phi"][late]) < 1e-16
    phi = run["arm.phi"][-1]
    assert phi > P
    # weight and friction take the energy that it has after the pick-up and what the motor adds
    taken = next(e.time for e in run.events if e.component == "arm.carried")
    grid = np.linspace(taken, rest, 4001).tolist()
    way = run_controlled(until=rest, grid=grid, rtol=1e-9, parameters=weak)
    t, w, angle, tau = way[["time", "arm.trays.w", "arm.phi", "motor.tau"]][way.t > taken].T
    power = (gravity(angle, 1) + friction(1) - eta * RATIO * tau) * w
    assert trapezoid(power, t) == pytest.approx((LOADED + eta * ROTOR) * w[0] ** 2 / 2, rel=1e-3)
    assert run["arm.carried.y"][-1] == 1
    # its greatest torque is between what moves the arm up and what lets it down
    torque = run["motor.tau"][-1]
    assert torque == pytest.approx(2 * FIRST, rel=1e-9)
    assert (gravity(phi, 1) - friction(1)) * eta < RATIO * torque
    assert RATIO * torque * eta < gravity(phi, 1) + friction(1)


@pytest.mark.parametrize("eta", [0.835, 0.85])
def test_above_the_critical_efficiency_it_lifts(eta):
    assert (gravity(0.0, 1) + friction(1)) / (2 * FIRST * RATIO) == pytest.approx(0.832, abs=5e-4)
    run = run_controlled(until=8.0, parameters=FIRST_MOTOR | {"reducer.eta": eta})
    assert run["arm.phi"].max() > np.pi / 2


def test_a_slow_speed_control_rests_the_mandrel_on_the_table_until_the_torque_suffices():
    run = run_controlled(until=2.0, grid=4000, rtol=1e-9, parameters={"bandwidth": 10.0})
    taken = next(e.time for e in run.events if e.component == "arm.carried")
    closed = next(e.time for e in run.events if e.component == "arm.table" and e.after == "closed")
    # what the journals bear, and what the table, is not determined before both let go
    leaves = [event.time for event in run.events if event.after in ("forward", "open")][-1]
    assert taken < closed < leaves < 2.0
    rests = (run.t > closed) & (run.t < leaves)
    # table and journals hold the same motion: redundant, so that they yield by a part in 1e9
    assert np.abs(run["arm.trays.w"][rests]).max() < 1e-8
    assert run["arm.phi"][rests] == pytest.approx(P, abs=1e-9)
    assert run["arm.table.tau"][rests].max() < 1e-5  # of 127 kN.m
    assert run["arm.phi"].min() >= BEGIN - 1e-12
    torque = run["motor.tau"][np.abs(run.t - leaves).argmin()]
    assert torque == pytest.approx((gravity(P, 1) + friction(1)) / LIFT, rel=1e-6)


def test_time_never_runs_backward_while_rounding_alone_moves_what_rests():
    run = run_controlled(until=0.8, grid=None, rtol=1e-5, parameters={"bandwidth": 10.0})
    assert (np.diff(run.t) >= 0).all()
    # while it rests, the integral of the error grows
    assert (np.diff(run["motor.x"][run.t > 0.7]) > -1e-12).all()


def test_an_arm_that_begins_to_lift_slowly_takes_few_implicit_steps():
    """At lift-off the acceleration is 3e-7 rad/s2, less than the polynomial of a step can tell."""
    options = {"until": 2.0, "grid": 20, "parameters": {"bandwidth": 10.0}}
    coarse, fine = (run_controlled(rtol=rtol, **options) for rtol in (1e-5, 1e-9))
    assert coarse.statistics.steps < 1000
    size = np.abs(fine["motor.tau"]).max()
    assert coarse["motor.tau"][-1] == pytest.approx(fine["motor.tau"][-1], abs=1e-4 * size)


# -- extremes and energy -----------------------------------------------------------------------


def test_without_a_linear_zone_it_chatters_at_the_aim():
    def last_two_seconds(K):
        free = {"arm.mu": 0.0, "reducer.eta": 1.0}
        changed = free | {"aim.K": K}
        run = run_controlled(until=12.0, grid=6000, rtol=1e-8, parameters=changed)
        zone = AIM - run["arm.phi"][np.abs(run.t - instants(run)[2]).argmin()]
        assert zone == pytest.approx(1 / K**2, rel=1e-6)  # a / K^2, where the law becomes linear
        seconds = [(run.t > t) & (run.t < t + 1) for t in (10, 11)]
        error = [np.abs(run["arm.phi"][k] - AIM).max() for k in seconds]
        turns = [(np.diff(np.sign(run["arm.trays.w"][k])) != 0).sum() for k in seconds]
        return error, turns

    error, turns = last_two_seconds(6.0)
    assert turns == [0, 0]
    assert error[1] < 0.02 * error[0]
    error, turns = last_two_seconds(1000.0)
    assert min(turns) > 40
    assert error[1] > 0.9 * error[0]
