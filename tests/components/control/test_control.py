"""Controllers, filters and limiters against closed forms and other integrators."""

import numpy as np
import pytest
from checks import assert_close
from rows import in_rows
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import (
    AngleSensor,
    Filter,
    Gain,
    Inertia,
    LimitedPI,
    Limiter,
    PController,
    PIController,
    PointToPoint,
    RateLimiter,
    SampledPI,
    Speed,
    SpeedSensor,
    SquareRootController,
    Sum,
    Torque,
)
from lumped.errors import ParameterError


def loop(controller, load=0.0, J=2.0, w=0.0):
    """A body whose speed is controlled, with a load torque: ``J der(w) = y + load``."""
    return in_rows(
        *("drive load body sensor", "sensor.w controller.measured", "controller.y drive.tau"),
        controller=controller,
        drive=Torque(),
        load=Torque(tau=load),
        body=Inertia(J=J, w=w),
        sensor=SpeedSensor(),
    )


def run(model, until, grid, **options):
    return lp.simulate(lp.assemble(model), until=until, grid=grid, rtol=1e-10, **options)


def test_a_p_controller_leaves_the_error_that_the_load_asks_for():
    t = np.linspace(0.0, 3.0, 61)
    model = loop(PController(k=10.0, wanted=2.0), load=-4.0)
    expected = (2.0 - 4.0 / 10.0) * (1 - np.exp(-10.0 / 2.0 * t))
    assert_close(run(model, 3.0, t)["body.w"], expected, 1e-9, "speed")


def test_a_pi_controller_oscillates_as_a_second_order_system():
    t = np.linspace(0.0, 3.0, 61)
    # J s^2 + k s + k / T_i: poles -2.5 +- j sqrt(10 - 6.25); y = k (e + x) from w = x = 0
    model = loop(PIController(k=10.0, T_i=0.5, wanted=2.0))
    a, b = 2.5, np.sqrt(10 - 6.25)
    e = np.exp(-a * t) * (np.cos(b * t) + (a - 5.0) / b * np.sin(b * t)) * 2.0
    found = run(model, 3.0, t)
    assert_close(found["body.w"], 2.0 - e, 1e-9, "speed")


def test_a_limited_pi_controller_follows_another_integrator():
    """Into its upper and its lower limit and out of them, against SciPy on min and max."""
    t = np.linspace(0.0, 6.0, 121)
    k, T_i, N_i, J, low, high = 40.0, 0.2, 0.3, 2.0, -3.0, 5.0

    def output(w, x, wanted):
        u = k * (wanted - w + x)
        return u, min(max(u, low), high)

    def rates(wanted):
        def f(_, state):
            w, x = state
            u, y = output(w, x, wanted)
            return [(y - 1.0) / J, (wanted - w + (y - u) / (k * N_i)) / T_i]

        return f

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "max_step": 1e-3}
    up = solve_ivp(rates(2.0), (0, 3), [0, 0], t_eval=t[:60], **options)
    at_three = solve_ivp(rates(2.0), (0, 3), [0, 0], **options).y[:, -1]
    down = solve_ivp(rates(-1.0), (3, 6), at_three, t_eval=t[60:], **options)
    w, x = np.hstack([up.y, down.y])
    wanted = lp.ops.where(lp.time >= 3.0, -1.0, 2.0)
    limited = LimitedPI(k=k, T_i=T_i, N_i=N_i, y_min=low, y_max=high, wanted=wanted)
    model = loop(limited, load=-1.0)
    found = run(model, 6.0, t)
    assert_close(found["body.w"], w, 1e-8, "speed")
    assert_close(found["controller.x"], x, 1e-7, "integral part")
    after = {event.after for event in found.events if event.component == "controller"}
    assert {"u <= y_max", "y_min > u", "y_min <= u"} <= after


@pytest.mark.parametrize("T_s", [0.02, 0.07])
def test_a_sampled_pi_controller_follows_its_difference_equations(T_s):
    """Zero-order hold on a pure inertia: between samples the speed is a straight line."""
    k, T_i, J, load, wanted, count = 10.0, 0.5, 2.0, -3.0, 2.0, 40
    x, w, expected = 0.0, 0.0, []
    for _ in range(count):
        e = wanted - w
        x += T_s / T_i * e
        y = k * (x + e)
        expected.append((w, x, y))
        w += T_s * (y + load) / J
    model = loop(SampledPI(k=k, T_i=T_i, T_s=T_s, wanted=wanted), load)
    after = T_s * (np.arange(count) + 1e-6)
    found = run(model, count * T_s, after)
    w, x, y = np.array(expected).T
    drift = 1e-6 * T_s * (y + load) / J
    assert_close(found["body.w"], w + drift, 1e-11, "speed")
    assert_close(found["controller.x"], x, 1e-11, "integral part")
    assert_close(found["controller.y"], y, 1e-11, "torque")
    samples = [event.time for event in found.events]
    assert samples == pytest.approx(T_s * np.arange(count), abs=1e-11)


@pytest.mark.parametrize("number", [1, 3, 5, 8, 10, 23])  # 3 * 0.1 > 0.3, 0.8 - 0.1 * 8 > 0
def test_a_jump_at_the_instant_of_a_sample_counts_already(number):
    """Whichever way the sum of the sampling times is rounded."""
    instant = number / 10
    wanted = lp.ops.where(lp.time >= instant, 1.0, 0.0)
    controller = SampledPI(k=1.0, T_i=1e9, T_s=0.1, wanted=wanted)
    model = loop(controller, J=1e9)
    received = run(model, 3.0, [instant - 0.01, instant + 0.01])["controller.y"]
    assert received == pytest.approx([0.0, 1.0], abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_axis_brakes_evenly_and_then_settles_exponentially(side):
    K, a, e_far = 8.0, 3.0, 2.0
    e_0 = a / K**2
    v_far = np.sqrt(2 * a * (e_far - e_0 / 2))
    near = (v_far - a / K) / a  # until e = e_0
    t = np.linspace(0.0, 2.0, 81)
    braking = e_far - v_far * t + a * t**2 / 2
    settling = e_0 * np.exp(-K * (t - near))
    expected = -side * np.where(t < near, braking, settling)
    begin = {"drive.flange.phi": -side * e_far}
    axis = in_rows(
        *("drive sensor", "controller.y drive.w", "sensor.phi controller.measured"),
        controller=SquareRootController(K=K, a=a, wanted=0.0),
        drive=Speed(),
        sensor=AngleSensor(),
    )
    received = run(axis, 2.0, t, start=begin)["sensor.phi"]
    assert_close(received, expected, 1e-8, "position")


class Driven(lp.Component):
    """A block on a signal, and the time integral of its output."""

    block: lp.Component = Filter(u=1.0, T=0.3)
    area: lp.Var = lp.var("1", "integral of the output")

    def equations(self):
        yield lp.der(self.area) == self.block.y


T = np.linspace(0.0, 2.0, 81)


def test_a_filter_follows_a_step_with_its_time_constant():
    found = run(Driven(block=Filter(u=4.0, T=0.3, x=1.0)), 2.0, T)
    assert_close(found["block.y"], 4.0 - 3.0 * np.exp(-T / 0.3), 1e-9, "output")


def test_gain_and_sum_are_linear():
    found = run(Driven(block=Gain(u=lp.time, k=-3.0)), 2.0, T)
    assert_close(found["block.y"], -3.0 * T, 1e-15, "gain")
    found = run(Driven(block=Sum(a=lp.time, b=2.0, k_a=5.0, k_b=-1.0)), 2.0, T)
    assert_close(found["block.y"], 5.0 * T - 2.0, 1e-15, "sum")


def test_a_limiter_cuts_and_stops_the_run_where_it_begins_to_cut():
    found = run(Driven(block=Limiter(u=3 * lp.time - 2, y_min=-1.0, y_max=2.5)), 2.0, T)
    assert_close(found["block.y"], np.clip(3 * T - 2, -1.0, 2.5), 1e-14, "output")
    assert_close(found["area"][-1], -1 / 3 + (2.5**2 - 1) / 6 + 2.5 * 0.5, 1e-9, "area")
    received = [event.time for event in found.events]
    assert received == pytest.approx([1 / 3, 1.5], abs=1e-9)


@pytest.mark.parametrize("height", [3.0, -3.0])
def test_a_rate_limiter_turns_a_step_into_a_ramp_and_an_exponential_end(height):
    rate, lag = 2.0, 0.05
    found = run(Driven(block=RateLimiter(u=height, rate=rate, T=lag)), 2.0, T)
    ramp_end = (abs(height) - rate * lag) / rate
    end = abs(height) - rate * lag * np.exp(-(T - ramp_end) / lag)
    expected = np.sign(height) * np.where(ramp_end > T, rate * T, end)
    assert_close(found["block.y"], expected, 1e-8, "output")


class Moving(lp.Component):
    """A point-to-point move, integrated twice."""

    profile: PointToPoint = PointToPoint(distance=1.0, v_max=1.0, a_max=1.0)
    v: lp.Var = lp.var("1/s", "speed")
    s: lp.Var = lp.var("1", "way")

    def equations(self):
        yield lp.der(self.v) == self.profile.a
        yield lp.der(self.s) == self.v


@pytest.mark.parametrize(
    ("distance", "moving"),
    [(6.0, 3.0 + 0.5), (-6.0, 3.0 + 0.5), (0.5, 2 * np.sqrt(0.5 / 4.0)), (-1.0, 1.0)],
    ids=["trapezoid", "backward", "triangle", "just a triangle"],
)
def test_a_move_covers_its_distance_within_its_limits(distance, moving):
    """In ``d / v + v / a`` where it reaches `v`, else in ``2 sqrt(d / a)``."""
    t = np.linspace(0.0, 5.0, 501)
    profile = PointToPoint(distance=distance, v_max=2.0, a_max=4.0, start_time=0.3)
    found = run(Moving(profile=profile), 5.0, t)
    assert_close(found["profile.v"], found["v"], 1e-12, "speed against integral")
    assert_close(found["profile.s"], found["s"], 1e-11, "way against integral")
    assert found["profile.s"][-1] == pytest.approx(distance, rel=1e-14)
    turns = [event.time for event in found.events]
    assert min(turns) == 0.3
    assert max(turns) == pytest.approx(0.3 + moving, rel=1e-12)
    assert np.abs(found["profile.v"]).max() <= 2.0 + 1e-14
    assert np.abs(found["profile.a"]).max() == 4.0


def test_a_drive_that_rests_exactly_at_its_limit_does_not_chatter():
    """The wanted torque tends to the limit, where rounding decides on which side it lies."""
    controller = LimitedPI(k=100.0, T_i=1e9, y_min=-12.0, y_max=12.0, wanted=0.12)
    model = loop(controller, load=-12.0, J=1.0, w=0.01)
    for method in ("explicit", "implicit"):
        found = run(model, 50.0, 100, method=method)
        assert len(found.events) <= 5


def test_crossed_limits_are_refused_with_their_paths():
    with pytest.raises(ParameterError, match=r"block\.y_max = -1 .*block\.y_min = 2"):
        lp.assemble(Driven(block=Limiter(u=1.0, y_min=2.0, y_max=-1.0)))
