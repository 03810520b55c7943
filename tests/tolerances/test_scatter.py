"""Scatter of runs and modes, against closed forms."""

import numpy as np
import pytest
import scipy
from checks import worst

import lumped as lp
from lumped import functionals as fun
from lumped.ensembles import correlated, lognormal, truncated
from lumped.tolerances import scene_of
from tests.tolerances.drives import braked, pair, pendulum_on_a_spring, undamped_hertz, wheel

SPEED = "final(body.w)"


@pytest.fixture(scope="module")
def driven():
    return wheel()


def linear(driven, **more):
    over = {"one.tau": lp.normal(20.0, 2.0), "two.tau": lp.normal(12.0, 1.0)}
    return lp.scatter(driven, over=over, of=fun.final("body.w"), until=1.0, **more)


@pytest.mark.parametrize("method", ["samples", "derivatives"])
def test_a_sum_of_normal_torques(driven, method):
    found = linear(driven, search=method, seed=4, **({"runs": 4000} if method == "samples" else {}))
    own = found[SPEED]
    true = scipy.stats.norm(8.0, np.sqrt(5.0) / 4)
    exact = method == "derivatives"
    print(f"{method}: mean {own.mean}, deviation {own.std}, skewness {own.skewness}")
    room = 1e-9 if exact else 4 * true.std() / np.sqrt(4000)
    assert own.mean == pytest.approx(8.0, abs=room)
    assert own.std == pytest.approx(true.std(), rel=1e-9 if exact else 4 / np.sqrt(8000))
    assert own.skewness == pytest.approx(0.0, abs=1e-9 if exact else 0.16)
    for q in (0.01, 0.3, 0.99):
        quantile = own.quantile(q)
        print(f"{q}: {quantile}, true {true.ppf(q):.5f}")
        if exact:
            assert quantile.value == pytest.approx(true.ppf(q), abs=0.01 * true.std())
            assert quantile.low < true.ppf(q) < quantile.high
        else:
            assert quantile.low < true.ppf(q) < quantile.high
    share = own.share(above="9 rad/s")
    assert share.value == pytest.approx(true.sf(9.0), abs=1e-3 if exact else 0.015)
    assert dict(own.ranking) == pytest.approx(
        {"one.tau": 0.8, "two.tau": 0.2}, abs=1e-9 if exact else 0.03
    )
    if exact:
        assert own.order == 2
        assert own.is_trusted
        assert own.error < 1e-6


def test_correlated_torques_add_their_covariance(driven):
    over = correlated(
        {"one.tau": lp.normal(20.0, 2.0), "two.tau": lp.normal(12.0, 1.0)}, [[1, -0.8], [-0.8, 1]]
    )
    true = np.sqrt(4 + 1 - 2 * 0.8 * 2) / 4
    for method, room in (("derivatives", 1e-3), ("samples", 0.09)):
        found = lp.scatter(
            driven, over=over, of=fun.final("body.w"), until=1.0, search=method, seed=1
        )[SPEED]
        print(f"{method}: {found.std / true - 1:.1e}")
        assert found.std == pytest.approx(true, rel=room)
        # squares of the correlations of the speed with each torque
        shares = {"one.tau": (4 - 1.6) ** 2 / 4 / 1.8, "two.tau": (1 - 1.6) ** 2 / 1.8}
        assert dict(found.ranking) == pytest.approx(
            shares, abs=1e-3 if method != "samples" else 0.06
        )


def test_the_frequency_of_a_lognormal_stiffness_is_lognormal():
    modes = lp.modes(pendulum_on_a_spring())
    over = {"spring.c": lognormal(1000.0, 0.1), "body.J": lognormal(2.0, 0.05)}
    true = scipy.stats.lognorm(np.hypot(0.05, 0.025), scale=np.sqrt(500.0) / (2 * np.pi))
    sampled = lp.scatter(modes, over=over, of=fun.frequency(0), runs=20_000, seed=5)
    expanded = lp.scatter(modes, over=over, of=fun.frequency(0), search="derivatives")
    fitted = lp.scatter(modes, over=over, of=fun.frequency(0), search="chaos", runs=64)
    own = sampled["frequency(0)"]
    for q in (0.001, 0.1, 0.5, 0.9, 0.999):
        found, by = own.quantile(q), expanded["frequency(0)"].quantile(q)
        print(f"{q}: {true.ppf(q):.5f} in {found.low:.5f} to {found.high:.5f}; {by}")
        # 1.6 times 95 % are 99.8 %
        assert 1.6 * found.low - 0.6 * found.value < true.ppf(q)
        assert true.ppf(q) < 1.6 * found.high - 0.6 * found.value
        assert by.low < true.ppf(q) < by.high
    assert dict(own.ranking) == pytest.approx({"spring.c": 0.8, "body.J": 0.2}, abs=0.02)
    second = expanded["frequency(0)"]
    errors = second.mean / true.mean() - 1, second.std / true.std() - 1
    assert np.abs(errors[0]) < 1e-4
    assert np.abs(errors[1]) < 0.01
    assert second.skewness == pytest.approx(true.stats("s"), rel=0.15)
    smooth = fitted["frequency(0)"]
    assert (smooth.mean, smooth.std) == pytest.approx((true.mean(), true.std()), rel=1e-5)
    assert smooth.quantile(0.99).value == pytest.approx(true.ppf(0.99), rel=1e-3)
    wide = np.array([0.05, 0.025]) ** 2
    shares = (np.exp(wide) - 1) / (np.exp(wide.sum()) - 1)
    assert dict(smooth.ranking) == pytest.approx(dict(zip(over, shares, strict=True)), abs=1e-5)
    limit = float(true.ppf(0.9))
    share = own.share(above=limit)
    assert share.low < 0.1 < share.high
    told = own.share(below=f"{limit / 1000!r} kHz")
    assert told.value == pytest.approx(1 - share.value, abs=1e-12)


def test_the_check_of_derivatives_tells_when_not_to_trust_them():
    """Wide scatter of a frequency next to an excitation: the clearance has a kink there."""
    modes = lp.modes(pendulum_on_a_spring())
    hertz = float(modes.hertz[0])
    found = lp.scatter(
        modes,
        over={"spring.c": lp.normal(1000.0, 60.0)},
        of={"away": fun.clearance([1.001 * hertz]), "f": fun.frequency(0)},
        search="derivatives",
    )
    print(found)
    assert found["f"].is_trusted
    assert not found["away"].is_trusted
    for share in (found["away"].share(below=0.01), found["away"].share(above=0.01)):
        assert share.low < share.value < share.high
    assert "not to be trusted, take search='samples'" in repr(found)


def test_the_ranking_in_the_small_is_that_of_the_derivatives(driven):
    """Shares are squares of derivative times deviation, from `gradient` and `eigen_sensitivity`."""
    system = pair()
    start = {"a.w": 10.0}
    own = system.parameter_values()
    names = ("a.J", "s.c", "b.J", "s.d")
    over = {name: lp.normal(own[name], 1e-3 * own[name]) for name in names}
    of = fun.at_time(0.8, "s.tau")
    gradient = lp.gradient(system, of=[of], by=names, until=1.0, start=start)
    expected = gradient.relative[0] ** 2 / (gradient.relative[0] ** 2).sum()
    run = lp.scatter(system, over=over, of=of, until=1.0, start=start, runs=3000, sampling="latin")
    expanded = lp.scatter(system, over=over, of=of, until=1.0, start=start, search="derivatives")
    fitted = lp.scatter(system, over=over, of=of, until=1.0, start=start, search="chaos", runs=20)
    totals = dict(fitted[str(of)].total)
    assert [totals[name] for name in names] == pytest.approx(expected, abs=1e-3)
    ranked = [name for name, _ in gradient.ranked(str(of))]
    for found in (run, expanded, fitted):
        shares = dict(found[str(of)].ranking)
        print([(name, round(shares[name], 4)) for name in names], expected.round(4))
        assert [name for name, _ in found[str(of)].ranking][:3] == ranked[:3]
        assert [shares[name] for name in names] == pytest.approx(expected, abs=0.02)


def test_runs_in_which_an_event_does_not_happen_are_counted_and_told():
    system = braked()
    # with half of f_max as torque it stands after 2 w / f_max: in time where f_max > 20 / 2.1
    found = lp.scatter(
        system,
        over={"brake.f_max": lp.uniform(8.0, 12.0)},
        of={"rest": fun.instant("brake", "stuck"), "w": fun.final("body.w")},
        until=2.1,
        runs=2000,
        seed=3,
    )
    print(found)
    own = found["rest"]
    true = (20 / 2.1 - 8.0) / 4.0
    assert own.missing.low < true < own.missing.high
    assert own.missing.value == len(found.failures) / 2000
    assert own.quantile(0.99).value < 2.1
    assert found["w"].missing.value == 0
    assert "rest: no value in" in repr(found)
    assert "this event of brake does not happen in this run" in repr(found)


def test_modes_side_by_side_are_those_of_each_design():
    system = pair()
    over = {
        "s.c": lp.normal(1000.0, 100.0),
        "a.J": lp.uniform(1.5, 2.5),
        "b.J": truncated(lp.normal(3.0, 0.5), 2.0, 4.0),
    }
    found = lp.scatter(
        lp.modes(system),
        over=over,
        of=[fun.frequency(0), fun.damping(0), fun.clearance([4.0, 5.0])],
        runs=500,
    )
    errors = []
    for point, values in zip(found.points[:20], found.values[:20], strict=True):
        alone = lp.modes(system, parameters=dict(zip(found.names, point.tolist(), strict=True)))
        away = np.abs(alone.hertz[0] / np.array([4.0, 5.0]) - 1).min()
        errors.append(np.abs(values / [alone.hertz[0], alone.damping[0], away] - 1).max())
    assert max(errors) < 1e-12
    exact = undamped_hertz(*found.points.T)
    assert np.abs(found.values[:, 0] / exact - 1).max() < 1e-13
    # a distance changes with the frequency, to the side on which this lies of the nearest one
    scene = scene_of(lp.modes(system), over=over, of=[fun.clearance([4.0, 5.0])])
    away = exact[:, None] / [4.0, 5.0] - 1
    nearest = np.abs(away).argmin(axis=1)
    side = np.sign(away[np.arange(500), nearest]) / np.array([4.0, 5.0])[nearest]
    slopes = scene.slopes(found.points)[1][:, 0, 0]
    assert len(set(np.sign(side))) == 2
    assert slopes == pytest.approx(side * 0.5 * exact / found.points[:, 0], rel=1e-9)


def test_second_derivatives_of_a_frequency_are_those_of_its_formula():
    at = np.array([1000.0, 2.0, 3.0])
    over = {name: lp.normal(v, 0.01 * v) for name, v in zip(("s.c", "a.J", "b.J"), at, strict=True)}
    scene = scene_of(lp.modes(pair()), over=over, of=[fun.frequency(0), fun.damping(0)])
    f, (c, Ja, Jb) = undamped_hertz(*at), at
    s = 1 / Ja + 1 / Jb
    g = np.array([0.5 / c, -0.5 / (s * Ja**2), -0.5 / (s * Jb**2)])
    more = np.diag([-0.5 / c**2, 1 / (s * Ja**3), 1 / (s * Jb**3)])
    squares = np.array([0.0, 1 / Ja**2, 1 / Jb**2]) / s
    expected = f * (np.outer(g, g) + more - 0.5 * np.outer(squares, squares))
    found = scene.curvatures(at)
    size = f / np.outer(at, at)
    assert np.abs((found[0] - expected) / size).max() < 1e-11
    # damping ratio pi f d / c
    z, gz = np.pi * f * 0.3 / c, g - np.array([1 / c, 0, 0])
    expected = z * (np.outer(gz, gz) + more - 0.5 * np.outer(squares, squares))
    expected[0, 0] += z / c**2
    size = z / np.outer(at, at)
    assert np.abs((found[1] - expected) / size).max() < 1e-9


class Filled(lp.Component):
    """``x' = u - k x`` from zero: ``x = u m0``, with ``mn`` the integral of ``s^n exp(-k s)``."""

    k: lp.Param = lp.param("1/s", "rate", 0.8)
    u: lp.Param = lp.param("m/s", "inflow", 0.5)
    x: lp.Var = lp.var("m", "level", start=0.0)

    def equations(self):
        yield lp.der(self.x) == self.u - self.k * self.x


FILLED, UNTIL = {"k": lp.normal(0.8, 0.2), "u": lp.normal(0.5, 0.1)}, 2.0


def moments(k):
    n = np.arange(5)
    own = scipy.special.gammainc(n + 1, k * UNTIL) * scipy.special.factorial(n)
    return own / k ** (n + 1)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
def test_second_derivatives_of_a_run_are_as_exact_as_differences_allow(rtol):
    of = [fun.final("x"), fun.peak("x")]  # the level rises to the end
    scene = scene_of(lp.assemble(Filled()), over=FILLED, of=of, until=UNTIL, rtol=rtol)
    at, wide = np.array([0.8, 0.5]), np.array([0.2, 0.1])
    m, u = moments(at[0]), at[1]
    exact = np.array([[u * m[2], -m[1]], [-m[1], 0.0]])
    # by the step along k, third derivatives of the slopes; the step along u leaves out nothing
    left_out = wide[0] ** 2 / 6 * np.array([[u * m[4], -m[3] / 2], [-m[3] / 2, 0.0]])
    left_out *= rtol ** (2 / 3)
    for found in scene.curvatures(at):
        assert worst(found - exact, left_out) < 0.01


def test_a_run_is_expanded_to_second_order():
    found = lp.scatter(
        lp.assemble(Filled()), over=FILLED, of=fun.peak("x"), until=UNTIL, search="derivatives"
    )["peak(x)"]
    m = moments(0.8)
    # x = u m0(k) with u and k normal: variance of the expansion about the means
    bend = 0.5 * m[2] * 0.2**2
    variance = (0.5 * m[1] * 0.2) ** 2 + (m[0] * 0.1) ** 2 + bend**2 / 2 + (m[1] * 0.02) ** 2
    assert found.order == 2
    assert found.mean - 0.5 * m[0] == pytest.approx(bend / 2, rel=1e-4)
    assert found.std**2 == pytest.approx(variance, rel=1e-5)


def test_an_expansion_is_of_first_order_where_derivatives_end_beside_the_mean():
    """The brake stands after ``2 w / f_max``, at the mean just before the run ends."""
    system = braked()
    found = lp.scatter(
        system,
        over={"brake.f_max": lp.normal(20 / 2.1 + 1e-3, 0.4)},
        of=fun.instant("brake", "stuck"),
        until=2.1,
        search="derivatives",
    )
    print(found)
    assert found["instant(brake, stuck, 0)"].order == 1
    assert "first order: scatter: no derivatives beside the point" in repr(found)
