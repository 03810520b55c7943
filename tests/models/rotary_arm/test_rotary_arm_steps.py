"""The rotary arm by steps and interlocks: kinematics and a second formulation by hand."""

import numpy as np
import pytest
from arm_by_hand import LOADED, ROTOR, data, friction, gravity
from scipy.integrate import solve_ivp

from lumped.models.rotary_arm import control, steps
from lumped.models.rotary_arm.steps import AT, arrivals, run_steps, standing

RATIO, ETA, RAMP, SECTOR, LAG, FAST, SLOW = 50.0, 0.85, 1.38, 0.02, 0.005, 1.0, 0.17
MOTOR = (ROTOR + LOADED) / RATIO**2
SPEED_GAIN, INTEGRAL_TIME = 30.0, 5 / 30.0


@pytest.fixture(scope="module")
def free_run():
    return run_steps(grid=2000, rtol=1e-8)


@pytest.fixture(scope="module")
def waiting_run():
    return run_steps(6.0, until=14.5, grid=3000, rtol=1e-8)


def test_each_of_the_twelve_positions_is_a_step_and_begins_where_it_lies(free_run):
    assert [angle for angle, _ in steps.STEPS] == pytest.approx(data("points")[:, 1], abs=1e-11)
    slow = [name for name, (_, v) in zip(AT, steps.STEPS, strict=True) if v == SLOW]
    assert slow == ["S", "P", "E", "R"]  # 0.17 rad/s at P and R, from S to A and from E to F
    found = arrivals(free_run)
    assert list(found) == list("PABCDERFGHI")
    for name, t in found.items():
        assert np.interp(t, free_run.t, free_run["arm.phi"]) == pytest.approx(AT[name], abs=1e-6)


@pytest.mark.parametrize(("zone", "ends"), [("line", "PB"), ("rack", "DG"), ("kick_out", "DH")])
def test_the_arm_tells_whose_way_it_occupies(free_run, waiting_run, zone, ends):
    first, last = (AT[name] for name in ends)
    for run in (free_run, waiting_run):
        phi = run["arm.phi"]
        inside, outside = (phi > first + 1e-9) & (phi < last - 1e-9), (phi < first) | (phi > last)
        assert (run[f"{zone}.y"][inside] == 1).all()
        assert (run[f"{zone}.y"][outside & (np.abs(phi - last) > 1e-9)] == 0).all()


@pytest.mark.parametrize("free", [0.0, 3.0, 3.7, 4.1, 6.0, 9.0])
def test_it_never_enters_the_way_of_the_rack_before_that_is_free(free):
    run = run_steps(free, until=10.0, grid=1000)
    assert run["arm.phi"][run.t < free].max(initial=0.0) < AT["D"]
    assert run["arm.phi"][-1] > AT["D"]


def test_a_released_arm_is_as_fast_as_one_that_was_never_asked(free_run):
    run = run_steps(3.0, grid=2000, rtol=1e-8)
    assert arrivals(run)["I"] == pytest.approx(arrivals(free_run)["I"], abs=1e-6)


def test_waiting_costs_what_the_ramps_by_hand_say(free_run, waiting_run):
    stop = AT["C"] + FAST**2 / (2 * RAMP)
    phi, held = standing(waiting_run)
    assert stop < phi < stop + SECTOR / RAMP + np.radians(0.5)  # by the lags of ramp and control
    assert held == pytest.approx(6.0 - 3.3992 - FAST / RAMP, abs=0.25)
    # from rest up to E, down to the slow speed, slowly to R
    rise = np.sqrt(2 * (AT["E"] - phi) / RAMP)
    change = (RAMP * rise - SLOW) / RAMP
    rest = AT["R"] - AT["E"] - (RAMP * rise + SLOW) / 2 * change
    assert arrivals(waiting_run)["R"] - 6.0 == pytest.approx(rise + change + rest / SLOW, abs=0.1)
    assert arrivals(waiting_run)["R"] > arrivals(free_run)["R"] + 3.0


def test_where_it_stands_is_what_a_second_formulation_says():
    """Loaded at 1 rad/s before C; motor and reducer brake it until it stands."""
    begin = np.radians(100.0)
    load = (gravity(begin, 1) + friction(1)) * ETA / RATIO  # the mandrel drives the motor

    def rates(t, y, wanted):
        phi, w, ramp, integral, tau = y
        error = RATIO * (ramp - w)
        against = gravity(phi, 1) + friction(1)
        a = (RATIO * ETA * tau - against) / (LOADED + ETA * ROTOR)
        if tau < ROTOR / RATIO * a:
            a = (RATIO / ETA * tau - against) / (LOADED + ROTOR / ETA)
        u = SPEED_GAIN * MOTOR * error + integral
        rise = RAMP * np.clip((wanted - ramp) / SECTOR, -1, 1)
        return [w, a, rise, SPEED_GAIN * MOTOR / INTEGRAL_TIME * error, (u - tau) / LAG]

    def checks(t, y, wanted):
        return y[0] - AT["C"]

    def stands(t, y, wanted):
        return y[1]

    checks.terminal = stands.terminal = True
    tight = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10, "max_step": 2e-3}
    y = [begin, FAST, FAST, load, load]
    first = solve_ivp(rates, (0, 2), y, events=checks, args=(FAST,), **tight)
    last = solve_ivp(rates, (0, 3), first.y[:, -1], events=stands, args=(0.0,), **tight)
    start = {"arm.phi": begin, "arm.mandrel.phi": begin, "arm.carried.x": 1.0}
    start |= {"arm.table.gap": begin - AT["P"], "arm.trays_hold.w_rel": 0.0}
    start |= {"arm.trays.w": FAST, "ramp.x": FAST, "profile.step": 3.0}
    start |= {"motor.x": load / (SPEED_GAIN * MOTOR), "motor.tau": load, "line.x": 0.0}
    run = run_steps(9.0, until=3.0, grid=1000, rtol=1e-9, start=start)
    phi, _ = standing(run)
    assert arrivals(run)["C"] == pytest.approx(first.t[-1], abs=1e-5)
    assert phi == pytest.approx(last.y[0, -1], abs=1e-5)


def test_the_square_root_needs_its_shift_to_brake_alike_in_the_linear_zone(free_run):
    """V dv/de is the deceleration: without the shift it jumps from a to 2 a where v meets K e."""
    a, K = float(control.BRAKING), float(control.GAIN)
    edge, way = a / K**2, control.AIM - free_run["arm.phi"]
    ahead = (way > 0) & (way < 3)

    def shifted(x):
        return np.where(x > edge, np.sqrt(2 * a * np.maximum(x - edge / 2, 0)), K * x)

    assert free_run["aim.y"][ahead] == pytest.approx(shifted(way[ahead]), abs=1e-12)
    for meeting, root in ((edge, lambda x: np.sqrt(2 * a * (x - edge / 2))), (2 * edge, plain)):
        assert root(meeting) == pytest.approx(K * meeting, rel=1e-12)
        d = 1e-6 * edge
        outside = root(meeting) * (root(meeting + d) - root(meeting)) / d
        assert outside == pytest.approx(a, rel=1e-5)
        inside = K**2 * meeting
        assert inside == pytest.approx(a * meeting / edge, rel=1e-12)


def plain(x):
    return np.sqrt(2 * control.BRAKING * x)
