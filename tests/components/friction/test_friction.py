"""Dry friction against closed forms: sticking, sliding, breaking away, and many at once."""

import numpy as np
import pytest
from drive_chains import in_turn
from rows import assemble_rows, in_a_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import BearingFriction, Brake, Clutch, Inertia, Stribeck, Torque, translation
from lumped.components.translation import FrictionPair, Mass


def modes_of(run):
    """Changes of mode, without those of functions of time and conditions."""
    words = {"stuck", "forward", "backward", "free"}
    return [event for event in run.events if {event.before, event.after} <= words]


# -- one element -------------------------------------------------------------------------------

TAU_C, D, W_0, J = 3.0, 0.5, 40.0, 2.0
COULOMB_AND_VISCOUS = {
    "rows": ((0.0, TAU_C), (10.0, TAU_C + 10 * D)),
    "curve": Stribeck(coulomb=TAU_C, static=TAU_C, decay=1.0, viscous=D),
    "function": lambda w: TAU_C + D * w,
}


def spinning(characteristic, direction, w=40.0):
    return lp.assemble(spin_down(characteristic, direction * w))


def spin_down(characteristic, w=W_0):
    return in_a_row(body=Inertia(J=J, w=w), bearing=BearingFriction(characteristic=characteristic))


@pytest.mark.parametrize("direction", [1, -1])
def test_a_root_of_the_speed_is_taken_of_its_magnitude(direction):
    """Friction a w^p: w^(1-p) = w_0^(1-p) - (1-p) a t / J; with a constant, by SciPy."""
    a, p = 0.5, 0.6
    pure = spinning(lambda w: a * w**p, direction)
    t = 3.0
    expected = (W_0 ** (1 - p) - (1 - p) * a * t / J) ** (1 / (1 - p))
    run = lp.simulate(pure, until=t, rtol=1e-10)
    assert run["body.w"][-1] == pytest.approx(direction * expected, rel=1e-8)
    raised = spinning(lambda w: 1.0 + a * w**p, direction)
    run = lp.simulate(raised, until=40.0, rtol=1e-10)
    stop = quad(lambda w: J / (1.0 + a * w**p), 0, W_0, epsabs=1e-12)[0]
    (event,) = modes_of(run)
    assert event.time == pytest.approx(stop, rel=1e-7)
    assert run["body.w"][-1] == 0.0


def test_a_curve_that_overflows_against_its_way_is_not_evaluated_there():
    steep = Stribeck(coulomb=TAU_C, static=5.0, decay=1.0)  # exp(1000) is no number
    run = lp.simulate(spinning(steep, 1, 1000.0), until=1.0)
    assert run["body.w"][-1] == pytest.approx(1000.0 - TAU_C / J, rel=1e-12)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("form", COULOMB_AND_VISCOUS)
def test_a_shaft_fades_to_rest_at_the_closed_form_instant_without_chatter(form, direction):
    model = spin_down(COULOMB_AND_VISCOUS[form], direction * W_0)
    run = lp.simulate(lp.assemble(model), until=20.0, rtol=1e-10)
    stop = J / D * np.log(1 + D * W_0 / TAU_C)
    (event,) = run.events
    assert event.time == pytest.approx(stop, rel=1e-9)
    assert event.after == "stuck"
    falling = (W_0 + TAU_C / D) * np.exp(-D / J * run.t) - TAU_C / D
    expected = direction * np.where(run.t < stop, falling, 0.0)
    assert np.abs(run["body.w"] - expected).max() <= 1e-8 * W_0
    assert (run["body.w"][run.t > stop] == 0.0).all()


@pytest.mark.parametrize("peak", [1.0, 1.5])
def test_a_shaft_breaks_away_where_a_ramp_reaches_the_peak_torque(peak):
    rate, kinetic = 0.7, 2.0
    model = in_a_row(
        drive=Torque(tau=rate * lp.time),
        body=Inertia(J=J),
        bearing=BearingFriction(characteristic=((0.0, kinetic),), peak=peak),
    )
    run = lp.simulate(lp.assemble(model), until=8.0)
    (event,) = run.events
    free = peak * kinetic / rate
    assert event.time == pytest.approx(free, rel=1e-9)
    sliding = (rate * (run.t**2 - free**2) / 2 - kinetic * (run.t - free)) / J
    expected = np.where(run.t > free, sliding, 0.0)
    assert np.abs(run["body.w"] - expected).max() <= 1e-8 * expected.max()


def test_beyond_its_rows_a_falling_characteristic_ends_at_zero_and_never_drives():
    model = spin_down(((0.0, 2.0), (10.0, 1.0)))  # the line is zero at 20 rad/s
    run = lp.simulate(lp.assemble(model), until=5.0)
    assert run["bearing.tau"].min() >= 0
    assert run["body.w"][-1] == W_0


def test_a_stribeck_curve_is_its_formula():
    model = spin_down(Stribeck(coulomb=2.0, static=3.5, decay=0.8, viscous=0.1))
    run = lp.simulate(lp.assemble(model), until=10.0)
    w = run["body.w"]
    expected = 2.0 + 1.5 * np.exp(-0.8 * w) + 0.1 * w
    assert np.abs(run["bearing.tau"] - expected).max() <= 1e-14 * expected.max()


def test_a_brake_lets_go_where_its_fading_force_no_longer_holds_the_load():
    load, grip, peak, fade = 4.0, 8.0, 1.25, 4.0
    model = in_a_row(
        drive=Torque(tau=load),
        body=Inertia(J=1.0),
        brake=Brake(
            characteristic=((0, 1), (10, 0.5)), peak=peak, f_max=grip, u=1 - lp.time / fade
        ),
    )
    run = lp.simulate(lp.assemble(model), until=5.0)
    received = [(event.time, event.after) for event in modes_of(run)]
    slips = fade * (1 - load / (peak * grip))
    assert received == [(pytest.approx(slips, rel=1e-9), "forward"), (pytest.approx(fade), "free")]


def test_friction_that_is_zero_at_standstill_turns_round_without_chatter():
    d, w = 0.3, 5.0
    model = in_a_row(
        drive=Torque(tau=lp.ops.sin(w * lp.time)),
        body=Inertia(J=1.0),
        bearing=BearingFriction(characteristic=((0, 0), (1, d))),
    )
    run = lp.simulate(lp.assemble(model), until=6.0, rtol=1e-9, grid=5000)

    def speed(t):
        wave = d * np.sin(w * t) - w * np.cos(w * t)
        return (wave + w * np.exp(-d * t)) / (d**2 + w**2)

    assert np.abs(run["body.w"] - speed(run.t)).max() <= 1e-8
    turns = np.count_nonzero(np.diff(np.sign(speed(np.linspace(1e-3, 6.0, 100001)))))
    assert len([event for event in run.events if event.time > 0]) == turns


def test_a_brake_between_two_free_bodies_keeps_their_momentum():
    J_1, J_2, w_1, w_2, grip = 0.5, 2.0, 30.0, -4.0, 6.0
    system = assemble_rows(
        *("shaft brake", "brake.support housing.flange_a"),
        shaft=Inertia(J=J_1, w=w_1),
        brake=Brake(f_max=12.0, u=1.0),
        housing=Inertia(J=J_2, w=w_2),
    )
    run = lp.simulate(system, until=5.0)
    (event,) = run.events
    assert event.time == pytest.approx((w_1 - w_2) / (grip / J_1 + grip / J_2), rel=1e-9)
    momentum = J_1 * run["shaft.w"] + J_2 * run["housing.w"]
    assert np.abs(momentum - (J_1 * w_1 + J_2 * w_2)).max() <= 1e-12 * J_1 * w_1
    assert run["shaft.w"][-1] == pytest.approx(run["housing.w"][-1], rel=1e-14)


def test_a_clutch_without_normal_force_is_free_and_one_pressed_negatively_too():
    model = in_a_row(
        drive=Torque(tau=1.0),
        a=Inertia(J=1.0),
        clutch=Clutch(f_max=10.0, u=lp.ops.where(lp.time >= 1.0, 1.0, -1.0)),
        b=Inertia(J=1.0),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    before = run.t < 1.0
    assert (run["b.w"][before] == 0.0).all()
    assert run["clutch.position"][before].tolist() == [2.0] * before.sum()
    # 5 N.m from a to b, until 1 - 4 (t - 1) = 5 (t - 1); then both under 1 N.m
    locked = [event.time for event in modes_of(run) if event.after == "stuck"]
    assert locked == pytest.approx([1 + 1 / 9], rel=1e-9)
    assert run["b.w"][-1] == pytest.approx(5 / 9 + 0.5 * (1 - 1 / 9), rel=1e-9)


# -- stick-slip --------------------------------------------------------------------------------


def test_a_mass_on_a_belt_sticks_and_slips_a_thousand_times_with_the_closed_form_period():
    m, c, speed, kinetic, peak, cycles = 1.5, 60.0, 0.4, 3.0, 1.8, 1000
    model = in_a_row(
        belt=translation.Speed(v=speed),
        pair=FrictionPair(characteristic=((0.0, 1.0),), peak=peak, f_max=kinetic, u=1.0),
        body=Mass(m=m, v=speed, s=0.0),
        spring=translation.Spring(c=c),
        wall=translation.Fixed(),
    )
    omega, reach = np.sqrt(c / m), (peak - 1) * kinetic / c
    slip = (np.pi + 2 * np.arctan2(speed, omega * reach)) / omega
    period = slip + 2 * reach / speed
    first = peak * kinetic / c / speed
    run = lp.simulate(
        lp.assemble(model), until=first + cycles * period - 0.5 * reach / speed, rtol=1e-10, grid=10
    )
    number = np.arange(cycles)
    expected = np.column_stack([first + number * period, first + number * period + slip]).ravel()
    received = [event.time for event in run.events]
    assert len(received) == 2 * cycles
    worst = np.abs(received - expected).max()
    print(f"{2 * cycles} events, worst instant {worst:.1e} s of a period of {period:.3f} s")
    assert worst <= 1e-7 * period
    words = [(event.before, event.after) for event in run.events]
    assert words == [("stuck", "backward"), ("backward", "stuck")] * cycles


# -- many at once ------------------------------------------------------------------------------


def test_ten_clutches_in_series_lock_in_one_instant():
    rng = np.random.default_rng(7)
    J_i, w_i = rng.uniform(0.5, 2.0, 11), np.sort(rng.uniform(-50.0, 50.0, 11))[::-1]
    lock = 1.25
    common = J_i @ w_i / J_i.sum()
    # each body reaches the common speed steadily; a clutch carries what the bodies before it lose
    carried = np.cumsum(J_i * (w_i - common) / lock)[:-1]
    model = in_turn(
        bodies=[Inertia(J=j, w=w) for j, w in zip(J_i.tolist(), w_i.tolist(), strict=True)],
        clutches=[Clutch(characteristic=((0, 1),), f_max=f, u=1.0) for f in carried.tolist()],
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    times = np.array([event.time for event in run.events])
    assert len(times) == 10
    assert np.abs(times - lock).max() <= 1e-10
    after = run.t > lock + 1e-6
    w = np.array([run[f"bodies[{i}].w"][after] for i in range(11)])
    assert np.abs(w - common).max() <= 1e-12 * np.abs(w_i).max()
    momentum = sum(j * run[f"bodies[{i}].w"] for i, j in enumerate(J_i))
    assert np.ptp(momentum) <= 1e-12 * np.abs(J_i * w_i).sum()
