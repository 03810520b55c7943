"""Stiff and extreme smooth drives against closed forms.

Where errors add up over a run, the limit is the tolerance times the number of steps.
"""

import numpy as np
import pytest
from linkages import Crank
from rows import assemble_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.components.translation import Force, Mass
from lumped.errors import LumpedError, ParameterError, SolverError, StartError

EPS = np.finfo(float).eps
TURN = 2 * np.pi


def within(limit, received, expected, what, scale=None):
    """Whether the error is below `limit`, as a part of the largest expected value or `scale`."""
    scale = np.abs(expected).max() if scale is None else scale
    error = np.abs(np.asarray(received) - expected).max() / scale
    print(f"{what}: error {error:.1e}, limit {limit:.1e}")
    return error <= limit


def cost(run):
    s = run.statistics
    return f"{s.method}, {s.steps} steps, {s.rejected} rejected"


def two_masses(J_a, c, J_b):
    return assemble_row(a=Inertia(J=J_a), shaft=Spring(c=c), b=Inertia(J=J_b))


class ThreeMasses:
    """Three inertias, a soft shaft and a stiff one: modes in closed form, without cancellation."""

    J = (1.0, 2.0, 3.0)

    def __init__(self, ratio):
        J_1, J_2, J_3 = self.J
        self.system = assemble_row(
            a=Inertia(J=J_1),
            soft=Spring(c=1.0),
            b=Inertia(J=J_2),
            stiff=Spring(c=ratio),
            c=Inertia(J=J_3),
        )
        one, two = 1 / J_1 + 1 / J_2, ratio * (1 / J_2 + 1 / J_3)
        high = (one + two + np.sqrt((one - two) ** 2 + 4 * ratio / J_2**2)) / 2
        low = ratio * sum(self.J) / (J_1 * J_2 * J_3) / high
        self.w = np.sqrt([low, high])
        b = 1 / J_1 - low
        self.speeds = {"a.w": 1 / J_1, "b.w": b, "c.w": -(1 + J_2 * b) / J_3}


@pytest.mark.parametrize("exponent", range(0, 15, 2))
def test_modes_lose_no_more_digits_than_the_square_root_of_the_stiffness_ratio(exponent):
    chain = ThreeMasses(10.0**exponent)
    low, high = lp.modes(chain.system).hertz * TURN / chain.w
    assert within(10 * EPS * chain.w[1] / chain.w[0], low, 1.0, "low mode")
    assert within(10 * EPS, high, 1.0, "high mode")


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("exponent", range(0, 15, 2))
def test_a_slow_vibration_beside_a_stiff_shaft_takes_few_steps(exponent, rtol):
    chain = ThreeMasses(10.0**exponent)
    w = chain.w[0]
    run = lp.simulate(chain.system, until=3 * TURN / w, start=chain.speeds, rtol=rtol)
    print(cost(run))
    for name, speed in chain.speeds.items():
        assert within(100 * rtol, run[name], speed * np.cos(w * run.t), name, scale=1.0)
    assert run.steps < 2000


@pytest.mark.parametrize("ratio", [1e-8, 1e-4, 1.0, 1e4, 1e8])
def test_bodies_of_any_inertia_ratio_vibrate_against_each_other(ratio):
    system = two_masses(1.0, 1.0, ratio)
    w = np.sqrt(1 + 1 / ratio)
    assert within(4 * EPS, lp.modes(system).hertz[0] * TURN, w, "mode")
    run = lp.simulate(system, until=20 * TURN / w, start={"a.w": 1.0}, rtol=1e-9)
    mean, wave = 1 / (1 + ratio), np.cos(w * run.t)
    assert within(1e-7, run["a.w"], mean * (1 + ratio * wave), "speed of a")
    assert within(1e-7, run["b.w"], mean * (1 - wave), "speed of b")
    assert within(1e-7, run["shaft.phi_rel"], -np.sin(w * run.t) / w, "twist")


def test_ten_thousand_periods_keep_amplitude_phase_and_energy():
    system, rtol = two_masses(2.0, 300.0, 1.0), 1e-10
    w = np.sqrt(450.0)
    run = lp.simulate(system, until=1e4 * TURN / w, start={"a.w": 1.0}, rtol=rtol)
    twist, rate = run["shaft.phi_rel"], run["b.w"] - run["a.w"]
    wave = -(rate + 1j * w * twist) * np.exp(-1j * w * run.t)
    energy = run["a.w"] ** 2 + run["b.w"] ** 2 / 2 + 150 * twist**2
    limit = rtol * run.steps
    assert within(limit, np.abs(wave), 1.0, "amplitude")
    assert within(limit, np.angle(wave), 0.0, "phase, rad", scale=1.0)
    assert within(limit, energy, 1.0, "energy")


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_error_falls_with_the_tolerance_from_3_to_12_digits(method):
    system = two_masses(2.0, 300.0, 1.0)
    w = np.sqrt(450.0)
    errors = []
    for digits in range(3, 13):
        run = lp.simulate(system, until=3.0, start={"a.w": 1.0}, rtol=10.0**-digits, method=method)
        errors.append(np.abs(run["shaft.phi_rel"] * w + np.sin(w * run.t)).max())
        print(f"rtol 1e-{digits}: error {errors[-1]:.1e}, {cost(run)}")
        assert errors[-1] < 100 * 10.0**-digits
    assert max(np.divide(errors[1:], errors[:-1])) < 0.5


def turn_time(inertia, energy):
    """Time of one turn of a body with an inertia that depends on its angle."""
    half = quad(lambda phi: np.sqrt(inertia(phi) / (2 * energy)), 0, np.pi, epsrel=1e-10, limit=500)
    return 2 * half[0]


CRANK = {"J": 1.0, "m": 3.0, "r": 0.5}


def crank_drive(rod_ratio, force=0.0):
    r = CRANK["r"]
    return assemble_row(
        keep=["crank.phi"],
        crank=Inertia(J=CRANK["J"]),
        rod=Crank(r=r, length=rod_ratio * r),
        piston=Mass(m=CRANK["m"]),
        force=Force(f=force),
    )


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("rod_ratio", [4.0, 1.1, 1.01, 1.0001])
def test_a_hundred_turns_of_a_crank_from_its_dead_centre_keep_energy_and_rod(rod_ratio, method):
    J, m, r = CRANK.values()
    turns, rtol, energy = 100, 1e-9, J / 2

    def slope(phi):
        height = np.sqrt((rod_ratio * r) ** 2 - (r * np.sin(phi)) ** 2)
        return -r * np.sin(phi) * (1 + r * np.cos(phi) / height)

    until = turns * turn_time(lambda phi: J + m * slope(phi) ** 2, energy)
    run = lp.simulate(
        crank_drive(rod_ratio),
        until=until,
        start={"crank.phi": 0.0, "crank.w": 1.0},
        rtol=rtol,
        method=method,
        grid=5000,
    )
    phi, w, s, v = (run[name] for name in ("crank.phi", "crank.w", "piston.s", "piston.v"))
    limit = rtol * run.steps
    print(cost(run))
    assert within(10 * EPS, np.hypot(s - r * np.cos(phi), r * np.sin(phi)), rod_ratio * r, "rod")
    # the sines of NumPy differ in the last digit; the shortest rod magnifies it
    assert within(50 * EPS, v, slope(phi) * w, "speed of the piston")
    found = (J * w**2 + m * v**2) / 2
    # at one step in some thousands DOP853's estimate of the error vanishes by accident, SciPy's too
    changes = np.diff(found, prepend=energy)
    worst = np.abs(changes).argmax()
    jump = changes[worst] * (method == "explicit")
    assert abs(jump) < 1e-4 * energy
    assert within(limit, found - jump * (np.arange(len(found)) >= worst), energy, "energy")
    limit += abs(jump) / energy
    assert within(limit, phi[-1], turns * TURN, "angle after a hundred turns")


def test_a_piston_pressed_at_its_dead_centre_stays_there():
    run = lp.simulate(crank_drive(3.0, force=-10.0), until=5.0)
    assert run["crank.phi"].tolist() == [0.0] * len(run.t)
    assert run["rod.flange_b.f"] == pytest.approx(-10.0, rel=1e-14)


def test_a_piston_pressed_beside_its_dead_centre_falls_and_keeps_its_energy():
    rtol = 1e-10
    system = crank_drive(3.0, force=-10.0)
    run = lp.simulate(system, until=20.0, start={"crank.phi": 1e-9}, rtol=rtol)
    energy = (run["crank.w"] ** 2 + 3 * run["piston.v"] ** 2) / 2 + 10 * run["piston.s"]
    assert run["crank.phi"].max() > 1.0
    assert within(rtol * run.steps * 10, energy, 10 * 2.0, "energy")


def test_a_speed_that_a_dead_centre_forbids_is_refused():
    with pytest.raises(StartError, match="piston"):
        lp.start_point(crank_drive(3.0), start={"crank.phi": 0.0, "piston.v": 1.0})


def test_a_rod_as_short_as_its_crank_ends_in_an_error_with_the_run_so_far():
    start = {"crank.w": 1.0}
    with pytest.raises(SolverError, match=r"crank\.w") as caught:
        # at 1e-9 about half of such runs step over the kink
        lp.simulate(crank_drive(1.0), until=10.0, start=start, rtol=1e-11, method="explicit")
    run = caught.value.partial
    before = run.t < run.t[-1] - 1e-3
    energy = (run["crank.w"] ** 2 + 3 * run["piston.v"] ** 2) / 2
    assert len(run.t) > 10
    assert within(1e-6, energy[before], 0.5, "energy before")


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("period", [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_a_driven_vibration_is_the_same_on_any_scale_of_time(period, method):
    w_0 = TURN / period
    w = 0.8 * w_0
    system = assemble_row(
        drive=Torque(tau=lp.ops.sin(w * lp.time)),
        body=Inertia(J=1.0),
        shaft=Spring(c=w_0**2),
        wall=Fixed(),
    )
    # Angles are of the size 1 / w_0^2, so that the absolute tolerance must be smaller.
    run = lp.simulate(
        system, until=20 * period, rtol=1e-9, atol=min(1e-12, 1e-15 / w_0**2), method=method
    )
    expected = (np.sin(w * run.t) - 0.8 * np.sin(w_0 * run.t)) / (w_0**2 - w**2)
    assert within(1e-7, run["body.phi"], expected, "angle")


@pytest.mark.parametrize("J", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("d", [1e-6, 1.0, 1e6, 1e9])
@pytest.mark.parametrize("times", [5.0, 1e6])
def test_a_braked_body_of_any_size_runs_out(J, d, times):
    system = assemble_row(body=Inertia(J=J, w=1.0), brake=Damper(d=d), wall=Fixed())
    decay = J / d
    run = lp.simulate(system, until=times * decay, rtol=1e-9)
    assert within(1e-7, run["body.w"], np.exp(-run.t / decay), "speed")
    assert run.steps < 1000


@pytest.mark.parametrize("J_a", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("J_b", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("c", [1e-9, 1.0, 1e9])
def test_free_vibrations_are_exact_for_parameters_over_eighteen_decades(J_a, J_b, c):
    system = two_masses(J_a, c, J_b)
    w = np.sqrt(c / J_a + c / J_b)
    assert within(4 * EPS, lp.modes(system).hertz[0] * TURN, w, "mode")
    run = lp.simulate(system, until=3 * TURN / w, start={"a.w": 1.0}, rtol=1e-9)
    assert within(1e-7, run["shaft.phi_rel"] * w, -np.sin(w * run.t), "twist")


def test_damped_modes_are_exact_for_parameters_over_eighteen_decades():
    system = assemble_row(
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=1.0, d=1.0),
        gear=IdealGear(ratio=1.0),
        b=Inertia(J=1.0),
    )
    random = np.random.default_rng(5)
    worst = {"vibration": 0.0, "damping": 0.0, "decay": 0.0}
    for _ in range(300):
        J_a, J_b, c, zeta, ratio = 10 ** (random.uniform(-1, 1, 5) * [9, 9, 9, 4, 9])
        mobility = 1 / J_a + ratio**2 / J_b
        w = np.sqrt(c * mobility)
        changes = {"a.J": J_a, "b.J": J_b, "gear.ratio": ratio}
        changes |= {"shaft.c": c, "shaft.d": 2 * zeta * w / mobility}
        found = lp.modes(system, parameters=changes)
        assert found.rigid == 1
        if zeta < 1:
            worst["vibration"] = max(worst["vibration"], abs(found.hertz[0] * TURN / w - 1))
            worst["damping"] = max(worst["damping"], abs(found.damping[0] - zeta))
        else:
            fast = -w * (zeta + np.sqrt(zeta**2 - 1))
            errors = np.abs(found.decays / [fast, w**2 / fast] - 1)
            # The slow one is the difference of numbers as large as the fast one.
            assert errors[1] <= 100 * EPS * (fast / w) ** 2
            worst["decay"] = max(worst["decay"], errors[0])
    assert max(worst.values()) < 1e-13


@pytest.mark.parametrize(("J", "c"), [(1e100, 1e-100)])
def test_numbers_at_the_end_of_the_range_give_a_finite_run_or_an_error(J, c):
    system = two_masses(J, c, 1.0)
    for action in (
        lambda: lp.modes(system).hertz,
        lambda: lp.simulate(system, until=1.0, start={"a.w": 1.0}, max_steps=10_000).x,
    ):
        try:
            received = action()
        except LumpedError as error:
            print(f"{type(error).__name__}: {str(error).splitlines()[0]}")
        else:
            assert np.isfinite(received).all()


@pytest.mark.parametrize(("J", "c"), [(1e300, 1e-300), (1e150, 1e150), (5e-324, 1.0)])
def test_numbers_beyond_the_range_are_refused(J, c):
    with pytest.raises(ParameterError, match=r"so that its powers are finite|so that one over it"):
        two_masses(J, c, 1.0)


@pytest.mark.parametrize("speed", [1e101, 1e155, 1e300, -1e300])
def test_start_values_beyond_the_range_are_refused(speed):
    system = two_masses(1.0, 1.0, 1.0)
    with pytest.raises(StartError, match=r"a\.w = .*must be smaller than 1e\+100"):
        lp.simulate(system, until=1.0, start={"a.w": speed}, method="steps")
