"""Eccentric shear: idle and working time, start and stop, the inertia as a Fourier series."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from shear_by_hand import data

from lumped.models.eccentric_shear import duty, series
from lumped.models.eccentric_shear.scenes import MotorTurned, turn
from lumped.models.eccentric_shear.stand import CENTRE_SINE, CUT, IDLE, MEETS, SPEED

FLUX, RESISTANCE, INDUCTANCE, GAIN, RAMP, J_MOTOR = 571.0, 0.06, 0.3e-3, 1500.0, 0.5, 54e3


def ratio(phi, e):
    """Speed of the motor over that of the crank, and its slope over the crank angle."""
    y = phi - CENTRE_SINE
    below = 1 + e**2 - 2 * e * np.cos(y)
    return (1 - e**2) / below, -2 * e * (1 - e**2) * np.sin(y) / below**2


class TestShares:
    @pytest.mark.parametrize(("e", "printed"), [(0.0, 16.2), (0.4, 34.8), (0.5, 42.2)])
    def test_cut_takes_the_share_of_the_closed_form(self, e, printed):
        """Cut of 58 deg 25 min; the crank's angle over the motor's is that of two ellipses."""
        cut = np.radians(58 + 25 / 60)
        expected = 2 / np.pi * np.arctan((1 + e) / (1 - e) * np.tan(cut / 4))
        received = duty.working_share(e)
        assert received == pytest.approx(expected, rel=1e-9)
        assert abs(100 * received - printed) < 0.05

    @pytest.mark.parametrize("e", [0.4, 0.5])
    def test_both_times_change_in_proportion_to_the_mean_ratio(self, e):
        cut = (CENTRE_SINE - CUT / 2, CENTRE_SINE + CUT / 2)
        work = quad(lambda phi: ratio(phi, e)[0], *cut, epsabs=1e-12)[0] / CUT
        idle = quad(lambda phi: ratio(phi, e)[0], cut[1], cut[0] + 2 * np.pi, epsabs=1e-12)[0]
        share, even = duty.working_share(e), CUT / (2 * np.pi)
        assert share / even == pytest.approx(work, rel=1e-9)
        assert (1 - share) / (1 - even) == pytest.approx(idle / (2 * np.pi - CUT), rel=1e-9)
        assert work < (1 + e) / (1 - e)

    def test_ellipses_turn_once_in_the_time_of_circles(self):
        demand = turn(MotorTurned, 0.5, grid=200)
        assert demand.phi[-1] == pytest.approx(2 * np.pi, abs=1e-9)

    @pytest.mark.parametrize("e", [0.0, 0.4, 0.5])
    def test_torque_while_idle_is_that_of_the_reference(self, e):
        degrees, tau = np.arange(361.0), data("torque")[f"M_sine_varJ_e{e:.1f}"]
        expected = tau[np.abs(np.radians(degrees) - CENTRE_SINE) > CUT / 2].max()
        assert duty.idle_peak(e) == pytest.approx(expected, rel=2e-3)  # between its degrees


def integrate(e, idle, begin, until, start):
    """Motor and crank by (19) while the upper support moves, from crank angle, speed and current.

    Gives times, torque, speed and current of the motor.
    """
    table, angles = data("inertia"), np.radians(np.arange(361.0))
    lead = 2 * np.arctan2((1 + e) * np.sin(-CENTRE_SINE / 2), (1 - e) * np.cos(CENTRE_SINE / 2))

    def rates(t, x):
        phi, w, i = x
        u, du = ratio(phi, e)
        J, dJ = (np.interp(phi % (2 * np.pi), angles, table[name]) for name in ("J1", "dJ1"))
        y = phi - CENTRE_SINE
        q = 2 * np.arctan2((1 + e) * np.sin(y / 2), (1 - e) * np.cos(y / 2)) - lead
        rise, fall = (np.clip((t - at) / RAMP, 0, None) for at in (0.0, duty.TURN))
        speed = SPEED * (min(rise, 1.0) - min(fall, 1.0))
        way = SPEED * RAMP * (way_of(rise) - way_of(fall))
        voltage = FLUX * speed + GAIN * (way - q)
        pull = u * FLUX * i - idle * np.tanh(w / 0.002) - (dJ / 2 + u * du * J_MOTOR) * w**2
        alpha = pull / (J + u**2 * J_MOTOR)
        return w, alpha, (voltage - RESISTANCE * i - FLUX * u * w) / INDUCTANCE

    grid = np.linspace(begin, until, 4001)
    run = solve_ivp(
        rates, (begin, until), start, "LSODA", grid, rtol=1e-9, atol=1e-12, max_step=2e-3
    )
    phi, w, i = run.y
    return grid, FLUX * i, w * ratio(phi, e)[0], i


def way_of(x):
    """Integral of a ramp from 0 to 1 over its relative time."""
    return min(x, 1.0) ** 2 / 2 + max(x - 1.0, 0.0)


@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("idle", [IDLE, 0.0])
def test_start_and_stop_are_those_of_an_integration_by_hand(e, idle):
    run = duty.start_stop(e, idle, rtol=1e-8)
    phi, w = run["loaded.shear.crank.phi"], run["loaded.shear.shaft.body.w"]
    at = np.searchsorted(run.t, duty.TURN)
    begins = ((0.0, 1e-9, 0.0), tuple(y[at] for y in (phi, w, run["motor.i"])))
    spans = ((0.0, RAMP), (run.t[at], duty.TURN + RAMP))
    for received, start, span in zip(duty.split_turn(run), begins, spans, strict=True):
        t, tau, speed, i = integrate(e, idle, *span, start)
        assert received.peak == pytest.approx(np.abs(tau).max(), rel=1e-3)
        assert received.work == pytest.approx(np.trapezoid(tau * speed, t), rel=1e-3)
        assert received.heat == pytest.approx(np.trapezoid(RESISTANCE * i**2, t), rel=2e-3)


def test_start_and_stop_last_as_long_with_ellipses():
    (up, down), (slow_up, slow_down) = (duty.split_turn(duty.start_stop(e)) for e in (0.0, 0.5))
    for received, expected in ((slow_up, up), (slow_down, down)):
        assert received.time == pytest.approx(expected.time, rel=6e-3)
        assert received.time == pytest.approx(RAMP, rel=1e-2)
    assert slow_up.peak > 1.9 * up.peak


class TestSeries:
    """Numbers of the reference: rectangle rule at four points for each harmonic."""

    @pytest.mark.parametrize(
        ("order", "most", "rms", "steepest"),
        [(5, 227, 48, 1612), (10, 208, 34, 1706), (20, 158, 22, 1982), (40, 226, 19, 3883)],
    )
    def test_errors_are_those_of_the_reference(self, order, most, rms, steepest):
        phi = np.arange(0.05, 360, 0.1) * np.pi / 180
        inertia, slope = series.sum_series(series.fit_series(order), phi)
        error = inertia - reduced(phi)
        assert np.abs(error).max() == pytest.approx(most, rel=5e-3)
        assert np.sqrt((error**2).mean()) == pytest.approx(rms, abs=0.51)
        assert np.abs(slope).max() == pytest.approx(steepest, rel=1e-3)

    def test_twenty_harmonics_do_not_explain_the_claimed_reductions(self):
        """Reference: 2.321 and 2.845 with the series, 2.321 and 2.846 with the exact inertia."""
        received = series.reduce_peaks((0.4, 0.5))
        assert np.abs(np.subtract(received, (2.321, 2.845))).max() < 6e-4
        exact = 1 / 0.4308700207, 1 / 0.3514210649
        assert np.abs(np.subtract(received, exact)).max() < 6e-4

    def test_mean_of_the_series_is_that_of_the_inertia(self):
        phi = np.arange(0.05, 360, 0.1) * np.pi / 180
        received = series.fit_series()[0].real
        assert received == pytest.approx(reduced(phi).mean(), rel=1e-3)
        assert received == pytest.approx(2247.4, abs=0.5)


def reduced(phi):
    """Inertia of the reference, jumps included."""
    table, degrees = data("inertia"), np.radians(np.arange(361.0))
    first, second = (np.interp(phi, degrees, table[column]) for column in ("J1", "J2_paper"))
    return np.where(np.cos(phi) > np.cos(MEETS), first, second)
