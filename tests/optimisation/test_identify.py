"""Identification against linear least squares, known truth and repeated noise."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows, in_a_row
from scipy.stats import norm
from scipy.stats import t as student

import lumped as lp
from lumped.components import Brake, Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnknownNameError

NOISE = 0.02


def pushed():
    """``J w' == tau``: the speed is linear in the torque and in the start value."""
    return assemble_row(motor=Torque(tau=2.0), body=Inertia(J=0.5))


def drive():
    return assemble_row(
        motor=Torque(tau=3.0),
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=400.0, d=1.0),
        b=Inertia(J=0.5),
    )


TRUTH = {"shaft.c": 520.0, "shaft.d": 0.7, "b.J": 0.6}
VARY = {"shaft.c": (1, 1e4), "shaft.d": (0, 10), "b.J": (0.01, 5)}


def fit_line(sigma=None):
    """Instants, noisy speeds of the body, and the torque and start value that fit them."""
    t = np.linspace(0, 2, 41)
    y = 1.0 + 5.0 * t + 0.3 * np.random.default_rng(4).standard_normal(41)
    vary = {"motor.tau": (0, 100), "body.w": (-10, 10)}
    return t, y, lp.identify(pushed(), vary=vary, t=t, measured={"body.w": y}, sigma=sigma)


@pytest.mark.parametrize("given", [True, False])
def test_linear_problem_is_the_closed_form(given):
    """``w = w_0 + tau t / J``: straight line through noisy points, with its covariance."""
    t, y, found = fit_line({"body.w": 0.3} if given else None)
    X = np.column_stack([t / 0.5, np.ones(41)])
    expected = np.linalg.lstsq(X, y, rcond=None)[0]
    rest = y - X @ expected
    variance = 0.3**2 if given else rest @ rest / 39
    covariance = variance * np.linalg.inv(X.T @ X)
    assert list(found.parameters.values()) == pytest.approx(expected, rel=1e-7)
    assert np.abs(found.covariance / covariance - 1).max() < 1e-6
    reach = (norm.ppf(0.975) if given else student.ppf(0.975, 39)) * np.sqrt(covariance[0, 0])
    low, high = found.intervals["motor.tau"]
    assert (high - low) / 2 == pytest.approx(reach, rel=1e-6)
    correlation = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert found.correlation[0, 1] == pytest.approx(correlation, rel=1e-6)
    assert found.residuals["body.w"] == pytest.approx(rest, abs=1e-7)
    scaled = X * np.abs(expected) / (0.3 if given else np.sqrt(np.mean(y**2)))
    assert found.singular_values == pytest.approx(np.linalg.svd(scaled)[1], rel=1e-6)


@pytest.mark.parametrize("uneven", [False, True])
def test_truth_is_found_without_noise(uneven):
    t = np.linspace(0, 1, 201)
    if uneven:
        t = np.sort(np.random.default_rng(6).uniform(0, 1, 60))
    run = lp.simulate(drive(), until=1.0, parameters=TRUTH, grid=t, rtol=1e-10)
    names = ("b.w", "a.w") if uneven else ("b.w",)
    found = lp.identify(drive(), vary=VARY, t=t, measured={name: run[name] for name in names})
    for name, value in TRUTH.items():
        assert found.parameters[name] == pytest.approx(value, rel=1e-5 if uneven else 1e-6)
    assert found.unknown == ()
    assert found.residual < 1e-6


def test_intervals_cover_the_truth_as_often_as_they_say():
    """30 measurements with noise of fixed seed; of 90 intervals of 90 % about 81 hold."""
    system, rng = drive(), np.random.default_rng(11)
    run = lp.simulate(system, until=0.5, parameters=TRUTH, grid=100, rtol=1e-9)
    held, found = 0, []
    for _ in range(30):
        noisy = run["b.w"] + NOISE * rng.standard_normal(len(run.t))
        one = lp.identify(
            system,
            vary=VARY,
            t=run.t,
            measured={"b.w": noisy},
            sigma={"b.w": NOISE},
            parameters={n: 1.02 * v for n, v in TRUTH.items()},
            level=0.9,
            rtol=1e-6,
        )
        found.append(list(one.parameters.values()))
        for name, (low, high) in one.intervals.items():
            held += low <= TRUTH[name] <= high
    assert abs(held - 81) < 3 * np.sqrt(90 * 0.9 * 0.1)
    scatter = np.std(found, axis=0, ddof=1)
    said = np.sqrt(np.diag(one.covariance))
    assert np.abs(scatter / said - 1).max() < 3 / np.sqrt(2 * 29)


def test_a_local_minimum_is_doubtful():
    """A frequency begun too high ends where another period fits: the truth fits far better."""
    t = np.linspace(0, 1.0, 201)
    rng = np.random.default_rng(3)
    run = lp.simulate(drive(), until=1.0, parameters=TRUTH, grid=200, rtol=1e-9)
    noisy = {"a.w": run["a.w"] + 0.002 * rng.standard_normal(201)}
    for sigma in ({"a.w": 0.002}, None):
        options = {"vary": {"shaft.c": (1, 1e5)}, "t": t, "measured": noisy, "sigma": sigma}
        truth = {n: v for n, v in TRUTH.items() if n != "shaft.c"}
        good = lp.identify(drive(), **options, parameters=truth | {"shaft.c": 500.0})
        bad = lp.identify(drive(), **options, parameters=truth | {"shaft.c": 900.0})
        assert good.parameters["shaft.c"] == pytest.approx(520.0, rel=0.01)
        assert good.doubts == ()
        assert abs(bad.parameters["shaft.c"] - 520.0) > 200
        assert any("follow each other" in doubt for doubt in bad.doubts)
        assert ("times the noise" in " ".join(bad.doubts)) == (sigma is not None)
        assert "doubtful: " in repr(bad)
        assert "doubtful" not in repr(good)


def test_what_the_curves_do_not_tell_is_named():
    """``w = tau / (J_a + J_b) (t - ...)``: slope, frequency and decay, but five parameters."""
    run = lp.simulate(drive(), until=1.0, grid=100)
    names = ("motor.tau", "a.J", "b.J", "shaft.c", "shaft.d")
    found = lp.identify(
        drive(), vary=dict.fromkeys(names, (0.01, 1e4)), t=run.t, measured={"b.w": run["b.w"]}
    )
    assert set(found.unknown) == set(names)
    assert found.singular_values[3] < 1e-6 * found.singular_values[0]
    assert found.singular_values[2] > 1e-6 * found.singular_values[0]
    assert "not told by these curves: motor.tau, a.J" in repr(found)
    assert np.isinf(found.intervals["a.J"]).all()


def test_a_damper_and_a_start_value_across_an_event():
    """A brake stops the body: derivatives jump where it sticks."""

    def model():
        return assemble_rows(
            "body brake oil ground",
            body=Inertia(J=2.0, w=6.0),
            oil=Damper(d=0.5),
            brake=Brake(f_max=8.0, u=1.0),
            ground=Fixed(),
        )

    t = np.linspace(0, 3, 121)
    d, w_0, tau = 0.8, 5.0, 4.0
    stop = 2.0 / d * np.log(1 + d * w_0 / tau)
    y = np.where(t < stop, (w_0 + tau / d) * np.exp(-d * t / 2) - tau / d, 0.0)
    found = lp.identify(
        model(), vary={"oil.d": (0, 9), "body.w": (0, 99)}, t=t, measured={"body.w": y}
    )
    assert found.parameters["oil.d"] == pytest.approx(d, rel=1e-6)
    assert found.parameters["body.w"] == pytest.approx(w_0, rel=1e-6)


def test_a_bound_that_holds_is_told():
    t = np.linspace(0, 1, 11)
    found = lp.identify(
        pushed(), vary={"motor.tau": (0, 3)}, t=t, measured={"body.w": 10 * t}, sigma={"body.w": 1}
    )
    assert found.bounded == ("motor.tau",)
    assert "at its bound" in repr(found)


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"t": [0, 2, 1]}, OptionError, "increasing instants"),
        ({"measured": {}}, OptionError, "at least one"),
        ({"measured": {"body.w": [1, 2]}}, OptionError, "3 finite values"),
        ({"measured": {"body.w": [1, 2, np.nan]}}, OptionError, "a list of finite numbers"),
        ({"measured": {"body.v": [1, 2, 3]}}, UnknownNameError, r"body\.w"),
        ({"sigma": {"body.w": 0}}, OptionError, "positive standard deviation"),
        ({"vary": {"motor.tau": (3, 9)}}, OptionError, r"motor\.tau = 2, outside"),
        ({"vary": {"motor.x": (3, 9)}}, UnknownNameError, r"motor"),
        ({"vary": {}}, OptionError, "at least one"),
    ],
)
def test_bad_input_is_named(options, error, text):
    given = {"vary": {"motor.tau": (0, 9)}, "t": [0, 1, 2], "measured": {"body.w": [1, 2, 3]}}
    with pytest.raises(error, match=text):
        lp.identify(pushed(), **given | options)


def swinging():
    """A body on a spring: its speed tells the frequency, sampled seldom several of them."""
    model = in_a_row(body=Inertia(J=1.0, w=1.0), spring=SpringDamper(c=100.0, d=0.1), wall=Fixed())
    return lp.assemble(model)


def fit_swing(t, **options):
    """The stiffness by noise-free samples of the speed at some instants."""
    given = {"vary": {"spring.c": (20.0, 400.0)}, "measured": {"body.w": swing(t)}}
    return lp.identify(swinging(), t=t, **given | options)


def swing(t, c=100.0, d=0.1):
    w, z = np.sqrt(c), d / 2 / np.sqrt(c)
    v = w * np.sqrt(1 - z * z)
    return np.exp(-z * w * t) * (np.cos(v * t) - z * w / v * np.sin(v * t))


def test_several_searches_leave_a_local_minimum():
    """From 300 N.m/rad one search ends at a frequency that is out of phase."""
    t = np.linspace(0.0, 5.0, 60)
    options = {"sigma": {"body.w": 0.01}, "parameters": {"spring.c": 300.0}}
    one, several = fit_swing(t, **options), fit_swing(t, **options, searches=4)
    assert abs(one.parameters["spring.c"] - 100) > 10
    assert several.parameters["spring.c"] == pytest.approx(100.0, rel=1e-6)
    assert several.others
    assert several.others[0][0] >= several.deviation
    assert not [text for text in several.doubts if "fit as well" in text]


def test_two_minima_that_fit_as_well_are_named():
    """Ten samples at a multiple of the period cannot tell a frequency from its alias."""
    t = np.arange(10) * np.pi / 10
    found = fit_swing(
        t,
        vary={"spring.c": (20.0, 1500.0)},
        sigma={"body.w": 0.2},
        parameters={"spring.c": 90.0},
        searches=4,
    )
    text = " ".join(found.doubts)
    print(text)
    assert "other values fit as well as noise can tell" in text
    # cos(10 k pi / 10) == cos(30 k pi / 10)
    both = {round(found.parameters["spring.c"], -2), round(found.others[0][1]["spring.c"], -2)}
    assert both == {100.0, 900.0}


def test_searches_between_no_bounds_are_refused():
    t = np.linspace(0.0, 1.0, 20)
    with pytest.raises(OptionError, match=r"both bounds of spring\.c"):
        fit_swing(t, vary={"spring.c": (1.0, np.inf)}, searches=2)
    with pytest.raises(OptionError, match="searches = 0"):
        fit_swing(t, searches=0)


def test_the_picture_shows_measured_fitted_and_residual_values_in_the_wanted_unit():
    t, y, found = fit_line()
    line = np.polyval(np.polyfit(t, y, 1), t)
    axes = found.plot(units={"body.w": "rpm", "time": "ms"}).axes
    points, fitted = axes[0].lines
    rest = axes[1].lines[1]
    rpm = 30 / np.pi
    assert points.get_xdata() == pytest.approx(1e3 * t)
    assert points.get_ydata() == pytest.approx(rpm * y, rel=1e-12)
    assert np.interp(1e3 * t, *fitted.get_data()) == pytest.approx(rpm * line, rel=1e-6)
    assert rest.get_ydata() == pytest.approx(rpm * (y - line), abs=1e-5)
    assert [axis.get_ylabel() for axis in axes] == ["body.w, rpm", "residual, rpm"]
