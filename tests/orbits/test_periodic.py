"""Periodic motions against closed forms, other formulations and published numbers."""

import numpy as np
import pytest
from checks import refused, worst
from differences import slope
from periodic_motions import ROTOR, Ball, G, W, X, driven, one_bounce
from rows import assemble_one
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.errors import OptionError, SolverError, UnknownNameError
from lumped.ops import cos, sin, where

VAN_DER_POL = 6.6632868593231301896996820305  # period for mu = 1 (Amore, arXiv:1611.09411)


def van_der_pol(mu=1.0):
    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == self.mu * (1 - self.x**2) * self.v - self.x

    x = lp.var("m", "position", start=1.0)
    return assemble_one(equations, mu=lp.param("1", "mu", mu), x=x, v=X["v"])


def test_a_driven_linear_oscillator_answers_as_its_frequency_response():
    d, c, F, Omega = 0.3, 2.0, 1.5, 1.1
    T = 2 * np.pi / Omega
    orbit = lp.periodic(driven(d, c, F=F, T=T), period=T, rtol=1e-11)
    H = F / (c - Omega**2 + 1j * Omega * d)
    t, size = orbit.run.t, abs(H)
    assert worst(orbit["x"], np.real(H * np.exp(1j * Omega * t))) < 1e-9
    assert worst(orbit["v"], np.real(1j * Omega * H * np.exp(1j * Omega * t))) < 1e-9
    assert worst(orbit.harmonics("x", 3), np.array([0, H, 0, 0])) < 1e-9
    assert orbit.greatest("x").value == pytest.approx(size, rel=1e-9)
    assert orbit.greatest("x").time == pytest.approx((-np.angle(H) / Omega) % T, rel=1e-7)
    assert orbit.least("x").value == pytest.approx(-size, rel=1e-9)
    loss = np.pi * d * Omega * size**2
    assert orbit.drift["E"] == pytest.approx(loss, rel=1e-9)
    assert orbit.work(("v", "v")) == pytest.approx(loss / d, rel=1e-9)
    exact = np.exp(T * np.roots([1, d, c]))
    assert worst(sorted(orbit.multipliers, key=np.imag), sorted(exact, key=np.imag)) < 1e-8
    assert orbit.shift is None
    assert orbit.stable
    assert orbit.residual < 1e-10
    refused(OptionError, lambda: orbit.fluctuation("x"), "mean of x is zero")


@pytest.mark.parametrize("Omega", [0.9, 1.6])
def test_the_harmonics_of_a_duffing_oscillator_balance(Omega):
    system = driven(d=0.2, c=1.0, cubic=1.0, F=0.8, T=2 * np.pi / Omega)
    orbit = lp.periodic(system, period=2 * np.pi / Omega, warm_up=80)
    t, x, v = orbit.run.t[:-1], orbit["x"][:-1], orbit["v"][:-1]
    assert len(t) == 1000

    def rate(values):
        """By the first 40 harmonics, so that it belongs to a motion that repeats."""
        return np.fft.irfft(1j * Omega * np.arange(41) * np.fft.rfft(values)[:41], len(t))

    assert worst(rate(x), v) < 1e-8
    assert worst(rate(v), 0.8 * np.cos(Omega * t) - 0.2 * v - x - x**3) < 1e-8
    assert abs(orbit.harmonics("x", 3)[3]) > 1e-3  # it is not linear
    # multipliers multiply to exp(integral of the trace), here of a constant (Liouville)
    assert np.prod(orbit.multipliers) == pytest.approx(np.exp(-0.2 * orbit.period), rel=1e-8)


def test_the_van_der_pol_oscillator_has_its_published_period():
    orbit = lp.periodic(van_der_pol(), near=6.5)
    assert orbit.period == pytest.approx(VAN_DER_POL, rel=5e-11)
    assert abs(orbit.shift - 1) < 1e-9
    t, x = orbit.run.t, orbit["x"]
    trace = 1 - x**2
    area = np.trapezoid(trace, t)  # of a periodic function, so it converges at once
    assert orbit.multipliers == pytest.approx([np.exp(area)], rel=1e-6)
    by = orbit.sensitivity(of=["x", "v"], by=["mu"])
    expected = slope(lambda mu: lp.periodic(van_der_pol(mu), near=6.5).period, 1.0, 1e-3, 2)
    assert by.period["mu"] == pytest.approx(expected, rel=1e-5)


def test_a_search_starts_from_a_point_of_a_run():
    system = van_der_pol()
    point = lp.simulate(system, until=30.0).point(25.0)
    orbit = lp.periodic(system, near=6.5, start=point, warm_up=0.1)
    assert orbit.period == pytest.approx(VAN_DER_POL, rel=5e-11)


@pytest.mark.parametrize(("c", "pumped"), [(1.3, 0.4), (0.25, 0.1), (0.3, 0.6)])
def test_multipliers_of_a_mathieu_equation(c, pumped):
    d, T = 0.02, 2 * np.pi
    system = driven(d=d, c=c, pumped=pumped, F=1.0, T=T)

    def rate(t, y):
        S = y.reshape(2, 2)
        return (np.array([[0, 1], [-c - pumped * np.cos(t), -d]]) @ S).ravel()

    end = solve_ivp(rate, (0, T), np.eye(2).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    exact = np.linalg.eigvals(end.y[:, -1].reshape(2, 2))
    orbit = lp.periodic(system, period=T, warm_up=0)
    assert worst(np.sort_complex(orbit.multipliers), np.sort_complex(exact)) < 1e-8
    assert orbit.stable == (np.abs(exact).max() < 1)


def test_derivatives_of_a_driven_orbit_by_its_parameters():
    system = driven()
    T = 2 * np.pi / 1.1
    by = lp.periodic(system, period=T).sensitivity(of=["x"], by=["c", "d", "F"])
    t, wave = by.run.t, np.exp(1.1j * by.run.t)
    H = 1 / (2.0 - 1.1**2 + 1.1j * 0.3)
    assert worst(by["x", "F"], np.real(H * wave)) < 1e-8
    assert worst(by["x", "c"], np.real(-1.5 * H**2 * wave)) < 1e-8
    assert worst(by["x", "d"], np.real(-1.5 * 1.1j * H**2 * wave)) < 1e-8
    assert worst(by.start[1], np.real(1.1j * np.array([-1.5 * H**2, -1.65j * H**2, H]))) < 1e-8
    assert by.period == {"c": 0.0, "d": 0.0, "F": 0.0}
    assert len(t) == len(by["x", "c"])
    refused(UnknownNameError, lambda: by["x", "pumped"], "pumped")


def test_a_system_that_must_repeat_is_named_if_it_does_not():
    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == cos(lp.time) - self.x * 0.0 - self.v + self.c * sin(self.x)

    free = assemble_one(equations, c=lp.param("1", "hold", 0.0), **X)
    with pytest.raises(SolverError, match=r"other x are periodic too.*give its turn") as caught:
        lp.periodic(free, period=2 * np.pi, start={"x": 0.3, "v": 1.0}, warm_up=0)
    assert caught.value.partial.t[-1] == pytest.approx(2 * np.pi)


def test_what_does_not_converge_tells_the_worst_state_and_keeps_the_last_run():
    def equations(self):
        yield lp.der(self.x) == 1.0 + self.x**2 * 1e-3 + 0.1 * sin(lp.time)

    growing = assemble_one(equations, x=X["x"])
    with pytest.raises(SolverError, match=r"iterations.*x misses its value by .* m,") as caught:
        lp.periodic(growing, period=2 * np.pi, warm_up=0)
    assert caught.value.partial.t[-1] == pytest.approx(2 * np.pi)


def test_an_equilibrium_is_no_oscillation():
    with pytest.raises(SolverError, match=r"equilibrium, not a periodic|periodic too"):
        lp.periodic(van_der_pol(-1.0), near=6.5, warm_up=100)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "give period="),
        ({"period": -1.0}, "period = -1.0 s"),
        ({"period": np.nan}, "period = nan"),
        ({"period": 1.0, "near": 1.0}, "not both"),
        ({"turn": {"phi": 6.0}}, "give warm_up="),
        ({"turn": {"phi": 0.0}, "warm_up": 5}, "other than zero"),
        ({"turn": {"phi": 6.0}, "warm_up": 5}, "another after its turn.*rate of w"),
        ({"turn": {"w": 6.0}, "warm_up": 5}, "another after its turn"),
        ({"near": 1.0, "grid": 3}, "at least 10"),
        ({"near": 1.0, "rtol": 0.1}, "rtol"),
    ],
)
def test_options_that_make_no_sense_are_refused(options, text):
    with pytest.raises(OptionError, match=text):
        lp.periodic(ROTOR, **options)


def test_wrong_names_directions_and_kinds_of_system_are_refused():
    refused(UnknownNameError, lambda: lp.periodic(ROTOR, turn={"psi": 6.0}, warm_up=5.0), "psi")
    with pytest.raises(SolverError, match="after warm_up = 5 s phi has turned"):
        lp.periodic(ROTOR, turn={"phi": -2 * np.pi}, warm_up=5.0)
    refused(OptionError, lambda: lp.periodic(driven(), near=6.0), "functions of time act")
    with pytest.raises(OptionError, match=r"no function of time acts on One.*near="):
        lp.periodic(van_der_pol(), period=VAN_DER_POL)


@pytest.mark.parametrize("on", [0.2, 0.7])
def test_a_torque_that_is_switched_on_and_off_in_each_period(on):
    class Switched(lp.Component):
        """``w' = tau - w`` with a torque for a part of each second."""

        w: lp.Var = lp.var("rad/s", "speed")
        phi: lp.Var = lp.var("rad", "angle")
        tau: lp.Var = lp.var("N.m", "torque")
        on: lp.Param = lp.param("s", "end of the torque", 0.5)

        def equations(self):
            yield lp.der(self.phi) == self.w
            yield self.tau == where(lp.time < self.on, 1.0, 0.0)
            yield lp.der(self.w) == self.tau - self.w

    system = lp.assemble(Switched(on=on), keep=["phi"])
    orbit = lp.periodic(system, period=1.0, warm_up=0)
    begin = (np.exp(on) - 1) / (np.e - 1)  # exp(-1) w_begin + the answer to the pulse
    top = 1 - (1 - begin) * np.exp(-on)
    assert orbit["w"][[0, -1]] == pytest.approx(begin, rel=1e-9)
    assert orbit.greatest("w") == pytest.approx((top, on), rel=1e-9)
    assert orbit.drift["phi"] == pytest.approx(on, rel=1e-9)  # mean speed is mean torque
    assert orbit.fluctuation("w") == pytest.approx((top - begin) / on, rel=1e-9)
    assert orbit.multipliers == pytest.approx([np.exp(-1)], rel=1e-9)
    by = orbit.sensitivity(of=["w", "tau"], by=["on"])
    assert by.mean[:, 0] == pytest.approx(1.0, rel=1e-8)
    # the top is where the torque ends, and moves with it
    slope = (1 - begin) * np.exp(-on) + 1 / (np.e - 1)
    assert by.greatest[:, 0] == pytest.approx([slope, 0.0], rel=1e-7)
    assert by.start[system.state_names.index("w"), 0] == pytest.approx(
        np.exp(on) / (np.e - 1), rel=1e-8
    )


@pytest.mark.parametrize("cosine", [1, -1])
def test_a_ball_that_bounces_once_in_each_period_of_a_shaken_plate(cosine):
    """Period, place and multipliers by hand (Guckenheimer and Holmes, 1983, section 2.4)."""
    e, A = 0.6, 0.3
    phase, begin = one_bounce(cosine)
    beside = {"h": begin["h"] + 1e-3, "v": begin["v"] - 1e-3}
    orbit = lp.periodic(lp.assemble(Ball()), period=1.0, start=beside, warm_up=0)
    assert orbit.run.x[0] == pytest.approx(list(begin.values()), rel=1e-9)
    assert orbit.run.events[0].time == pytest.approx((phase / W) % 1.0, rel=1e-9)
    # map of instant and speed from one impact to the next, linearised
    a = -A * W**2 * np.cos(phase)  # acceleration of the plate
    exact = np.roots([1, -(1 + e**2 + (1 + e) ** 2 * a / G), e**2])
    assert worst(np.sort_complex(orbit.multipliers), np.sort_complex(exact)) < 1e-8
    assert orbit.stable == (cosine > 0)
    assert ("unstable orbit: largest multiplier" in repr(orbit)) == (cosine < 0)
