"""Design points, curvatures and samples where the probability is known: limits of plain numbers."""

import numpy as np
import pytest
from scipy import integrate, optimize
from scipy.stats import chi2, norm

from lumped.errors import LumpedError, SolverError
from lumped.numerics.nearest_points import search_together
from lumped.tolerances.failure.form import form, points_of, search_all
from lumped.tolerances.failure.limit import Limit
from lumped.tolerances.failure.samples import around, centres, subset
from lumped.tolerances.failure.sorm import find_curvature, paraboloid
from lumped.tolerances.failure.unions import join_points
from tests.tolerances.given_scene import numbers


def linear(a, mean=None, std=None):
    a = np.array(a, float)
    d = len(a)
    mean, std = np.zeros(d) if mean is None else mean, np.ones(d) if std is None else std
    return numbers(lambda x: a @ x, lambda x: a, mean, std)


def bowl(k):
    """``x1 + k x0^2 / 2``, whose limit is a parabola."""
    return numbers(
        lambda x: x[1] + 0.5 * k * x[0] ** 2,
        lambda x: np.array([k * x[0], 1.0]),
        [0, 0],
        [1, 1],
        lambda x: [[k, 0], [0, 0]],
    )


def beyond_parabola(level, k):
    """Probability that the value of a bowl exceeds a level, by quadrature."""
    found, _ = integrate.quad(
        lambda v: norm.pdf(v) * norm.sf(level - 0.5 * k * v * v), -12, 12, epsabs=1e-14, limit=200
    )
    return found


def either(x):
    return min(x[0], x[1] + 1)


def either_slope(x):
    return np.array([1.0, 0.0]) if x[0] < x[1] + 1 else np.array([0.0, 1.0])


@pytest.mark.parametrize("side", ["above", "below"])
def test_the_distance_of_a_plane_is_that_of_geometry(side):
    limit = Limit(linear([3, -1], [10, 5], [1, 2]), **{side: 36.0})
    (point,) = form(limit)
    size = np.hypot(3, 2)
    sign = 1 if side == "above" else -1
    assert point.beta == pytest.approx(sign * 11 / size, rel=1e-12)
    assert point.u == pytest.approx(11 / size * np.array([3, -2]) / size, rel=1e-12)
    assert point.x @ [3, -1] == pytest.approx(36, rel=1e-12)
    beyond = norm.sf(sign * 11 / size)
    assert join_points([point], is_kept=sign > 0) == pytest.approx(beyond, rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_a_design_point_is_the_one_that_another_method_finds(seed):
    random = np.random.default_rng(seed)
    a, b = random.normal(size=4), 0.05 * random.normal(size=(4, 4))
    b = b + b.T
    level = 3.5 * np.linalg.norm(a)
    scene = numbers(lambda x: a @ x + x @ b @ x, lambda x: a + 2 * b @ x, np.zeros(4), np.ones(4))
    points = form(Limit(scene, above=level), searches=6)
    other = optimize.minimize(
        lambda u: u @ u,
        points[0].u + 0.3 * random.normal(size=4),
        constraints={"type": "eq", "fun": lambda u: scene.formula(u[None])[0, 0] - level},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert points[0].beta == pytest.approx(np.sqrt(other.fun), abs=1e-6)
    assert [p.beta for p in points] == sorted(p.beta for p in points)


def test_a_search_that_swings_with_the_plain_method_ends():
    """``x^3 + x^2 y + y^3 = 18``, x ~ N(10, 5), y ~ N(9.9, 5), at which HLRF has a cycle."""

    def slopes(u):
        x, y = 10 + 5 * u[:, 0], 9.9 + 5 * u[:, 1]
        by = 5 * np.column_stack([3 * x**2 + 2 * x * y, x**2 + 3 * y**2])
        return x**3 + x**2 * y + y**3 - 18, by

    (search,) = search_together(slopes, [np.zeros(2)])
    angle = np.linspace(0, 2 * np.pi, 2001)
    ring = 2.2983 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert search.is_found
    assert search.count < 20
    # the ring of the printed distance touches the limit: it is nowhere far inside
    assert slopes(ring)[0].min() == pytest.approx(0, abs=0.002 * np.linalg.norm(search.slope))
    assert np.linalg.norm(search.u) == pytest.approx(2.2983, abs=2e-4)


def test_both_points_of_a_square_are_found_and_joined():
    scene = numbers(lambda x: x[0] ** 2, lambda x: np.array([2 * x[0], 0]), [0.1, 5], [1, 2])
    exact = norm.sf(2.9) + norm.sf(3.1)
    for side, probability in (("above", exact), ("below", 1 - exact)):
        points = form(Limit(scene, **{side: 9.0}))
        sign = 1 if side == "above" else -1
        assert [sign * p.beta for p in points] == pytest.approx([2.9, 3.1], rel=1e-9)
        assert join_points(points, is_kept=side == "above") == pytest.approx(probability, rel=1e-9)


@pytest.mark.parametrize("angle", [0.8, 1.2, 2.5])
def test_two_planes_are_joined_as_quadrature_joins_them(angle):
    a, b = np.array([1.0, 0.0]), np.array([np.cos(angle), np.sin(angle)])
    scene = numbers(
        lambda x: max(a @ x, b @ x - 0.3), lambda x: a if a @ x > b @ x - 0.3 else b, [0, 0], [1, 1]
    )
    points = form(Limit(scene, above=2.0), searches=8)
    assert [p.beta for p in points] == pytest.approx([2.0, 2.3], rel=1e-9)

    def second(x):  # share of y with b @ (x, y) > 2.3
        return norm.pdf(x) * norm.sf((2.3 - b[0] * x) / b[1])

    exact = norm.sf(2.0) + integrate.quad(second, -10, 2.0, epsabs=1e-13)[0]
    assert join_points(points, is_kept=True) == pytest.approx(exact, rel=1e-8)


def test_a_point_between_two_nearer_ones_is_left_out():
    points = form(Limit(bowl(0.6), above=4.0))
    # tangent circle: u1 = 1/k
    far = np.sqrt(2 * (4 - 1 / 0.6) / 0.6 + 1 / 0.36)
    assert [p.beta for p in points] == pytest.approx([far, far], rel=1e-6)
    assert sorted(np.sign(p.u[0]) for p in points) == [-1, 1]


@pytest.mark.parametrize(
    ("scene", "side", "most"),
    [
        (linear([1, 2, 3]), {"above": 9.0}, 10),
        (bowl(0.2), {"above": 3.0}, 12),
        # of Rackwitz: a product of strength and width
        (
            numbers(lambda x: x[0] * x[1], lambda x: x[::-1], [38.0, 54.0], [3.8, 2.7]),
            {"below": 1140.0},
            14,
        ),
    ],
)
def test_further_searches_end_where_a_point_is_known(scene, side, most):
    limit = Limit(scene, **side)
    assert len(form(limit)) == 1
    assert limit.gradients <= most


def test_the_index_of_a_product_is_that_of_minimisation():
    scene = numbers(lambda x: x[0] * x[1], lambda x: x[::-1], [38.0, 54.0], [3.8, 2.7])
    (point,) = form(Limit(scene, below=1140.0))

    def far(u):  # the other variable from the limit
        return u**2 + ((1140 / (38 + 3.8 * u) - 54) / 2.7) ** 2

    assert point.beta**2 == pytest.approx(optimize.minimize_scalar(far, bounds=(-6, 0)).fun)


def test_a_warm_start_takes_fewer_evaluations():
    limit = Limit(bowl(0.2), above=4.0)
    (point,) = form(limit, searches=1)
    cold, limit.evaluations = limit.evaluations, 0
    (again,) = form(limit, begin=point.u, searches=1)
    assert again.beta == pytest.approx(point.beta, rel=1e-9)
    assert limit.evaluations <= cold


@pytest.mark.parametrize(
    ("k", "beta"), [(0.2, 4.0), (-0.4, 3.0), (0.05, 2.0), (-0.3, -1.0), (0.2, -1.5)]
)
def test_second_order_is_exact_for_a_paraboloid(k, beta):
    exact = beyond_parabola(beta, k)
    for second in (bowl(k).second, None):
        scene = bowl(k)
        scene.second = second
        limit = Limit(scene, above=beta)
        found = find_curvature(limit, form(limit)[0])
        print(found.source, found.tvedt / exact - 1, found.breitung / exact - 1)
        assert found.curvatures == pytest.approx([-k], rel=1e-6)
        assert found.tvedt == pytest.approx(exact, rel=1e-6)
        assert found.breitung == pytest.approx(exact, rel=0.3)
        assert abs(found.hohenbichler / exact - 1) < 0.3


def test_a_paraboloid_of_many_equal_curvatures_follows_chi_square():
    k, n, beta = 0.25, 6, 2.5
    exact, _ = integrate.quad(
        lambda q: chi2.pdf(q, n) * norm.sf(beta + 0.5 * k * q), 0, 200, epsabs=1e-15
    )
    assert paraboloid(beta, [k] * n) == pytest.approx(exact, rel=1e-7)


def test_a_limit_that_bends_around_the_median_has_no_second_order():
    scene = numbers(lambda x: x @ x, lambda x: 2 * x, [0.01, 0.0], [1, 1])
    limit = Limit(scene, above=9.0)
    with pytest.raises(SolverError, match="bends around the median") as caught:
        find_curvature(limit, form(limit)[0])
    print(caught.value)


@pytest.mark.parametrize(
    ("scene", "side", "words"),
    [
        (
            numbers(lambda x: np.tanh(x).sum(), lambda x: np.cosh(x) ** -2, [0] * 3, [1] * 3),
            {"above": "3.5 N.m"},
            r"nowhere in \d+ evaluations within a distance of 8: .* is 2.99\d* N.m, with p0 = ",
        ),
        (
            numbers(lambda x: np.tanh(x).sum(), lambda x: np.cosh(x) ** -2, [0] * 3, [1] * 3),
            {"below": 3.5},
            r"everywhere in \d+ evaluations within a distance of 8: the .* is 2.99",
        ),
        (
            numbers(either, either_slope, [0, 0], [1, 1]),
            {"above": 3.0},
            "a kink at its design point, p0 = 3, p1 = 2: .* and ",
        ),
        (
            numbers(min, lambda x: np.eye(2)[x.argmin()], [0, 0], [1, 1]),
            {"above": 2.5},
            r"a kink at its design point, p0 = 2\.[45]\d*, p1 = 2\.[45]\d*: .* and ",
        ),
        (
            numbers(lambda x: 1.0, lambda x: np.zeros(2), [0, 0], [1, 1]),
            {"above": 3.0},
            "does not depend on p0, p1",
        ),
        (
            numbers(lambda x: np.nan, lambda x: np.full(2, np.nan), [0, 0], [1, 1]),
            {"above": 3.0},
            "no derivatives at the median of the parameters: the formula has no value here",
        ),
        (linear([1, 1]), {}, "one of both"),
        (linear([1, 1]), {"above": 1.0, "below": 2.0}, "one of both"),
        (linear([1, 1]), {"above": "1 m"}, "the unit must be of the kind N.m"),
        (linear([1, 1]), {"above": np.inf}, "must be a finite number"),
    ],
)
def test_what_has_no_design_point_is_told(scene, side, words):
    with pytest.raises(LumpedError, match=words) as caught:
        form(Limit(scene, **side))
    print(caught.value)


def known_probabilities():
    exact = norm.sf(2.9) + norm.sf(3.1)
    square = numbers(lambda x: x[0] ** 2, lambda x: np.array([2 * x[0], 0]), [0.1, 5], [1, 2])
    return [
        (linear([3, -1], [10, 5], [1, 2]), {"above": 36.0}, norm.sf(11 / np.hypot(3, 2))),
        (linear([1, 1, 1]), {"below": 2.0}, norm.cdf(2 / np.sqrt(3))),
        (bowl(0.2), {"above": 4.0}, beyond_parabola(4.0, 0.2)),
        (square, {"above": 9.0}, exact),
        (numbers(either, either_slope, [0, 0], [1, 1]), {"above": 3.0}, norm.sf(3) * norm.sf(2)),
    ]


@pytest.mark.parametrize("case", range(5))
def test_intervals_of_samples_hold_the_probability(case):
    scene, side, exact = known_probabilities()[case]
    limit = Limit(scene, **side)
    middle = centres(limit, search_all(limit))
    inside, off = {"importance": 0, "subset": 0}, {"importance": [], "subset": []}
    seeds = 20
    for seed in range(seeds):
        for name, found in (
            ("importance", around(limit, middle, 400, seed)),
            ("subset", subset(limit, 400, seed)),
        ):
            low, high = found.interval
            inside[name] += low <= exact <= high
            off[name].append((found.probability / exact - 1, found.deviation))
    for name, rows in off.items():
        error, told = np.array(rows).T
        print(name, inside[name], error.mean(), error.std(), told.mean())
        assert inside[name] >= 0.75 * seeds
        assert abs(error.mean()) < 4 * told.mean() / np.sqrt(seeds)
        assert 0.5 < error.std() / told.mean() < 2


def test_a_step_of_all_chains_is_one_call():
    limit = Limit(linear([1, 1]), above=5.0)
    found = subset(limit, 1000, 0)
    levels = len(found.levels)
    assert limit.evaluations == 1000 + (levels - 1) * 900
    assert len(limit.scene.asked) == 1 + (levels - 1) * 9
    chances = [level.probability for level in found.levels]
    assert chances[:-1] == pytest.approx([0.1**k for k in range(1, levels)], rel=0.1)
    heights = [level.value for level in found.levels]
    assert heights == sorted(heights)
    assert heights[-1] == 5.0


def test_evaluations_that_fail_are_not_taken_as_safe():
    """Where ``x1 > 1.5`` nothing is known."""

    def value(x):
        return np.nan if x[1] > 1.5 else x[0]

    scene = numbers(value, lambda x: np.array([1.0, 0.0]), [0, 0], [1, 1])
    limit = Limit(scene, above=2.5)
    lost, both = norm.sf(1.5), norm.sf(2.5) * norm.cdf(1.5)
    for found in (
        around(limit, centres(limit, search_all(limit)), 4000, 1),
        subset(limit, 4000, 1),
    ):
        print(found)
        assert found.failed > 0
        # samples around the design point seldom come where most of the failures are
        assert 0.3 * lost < found.unknown < 1.2 * lost
        assert found.probability == pytest.approx(both, rel=0.3)
        assert found.interval[1] > both + found.unknown
    assert found.unknown == pytest.approx(lost, rel=0.15)
    scene.formula = lambda x: np.full((len(x), 1), np.nan)
    with pytest.raises(SolverError, match="all 400 evaluations fail"):
        subset(limit, 400, 0)


def test_levels_that_do_not_rise_are_told():
    steps = numbers(lambda x: np.floor(min(x[0], 0.5)), lambda x: np.zeros(2), [0, 0], [1, 1])
    with pytest.raises(SolverError, match="nowhere in 380 evaluations down to") as caught:
        subset(Limit(steps, above=3.0), 200, 0)
    print(caught.value)
    # steps that do rise are counted right
    counts = numbers(lambda x: np.floor(x[0]), lambda x: np.zeros(2), [0, 0], [1, 1])
    found = [subset(Limit(counts, above=2.5), 500, seed).probability for seed in range(10)]
    assert np.mean(found) == pytest.approx(norm.sf(3.0), rel=0.3)


def test_samples_around_a_point_that_is_not_the_nearest_say_so():
    scene = bowl(0.6)
    limit = Limit(scene, above=4.0)
    with pytest.raises(LumpedError):  # only the saddle between both points
        points_of(limit, search_all(limit, searches=1))
    found = around(limit, centres(limit, search_all(limit, searches=1)), 2000, 0)
    assert "nearer than the design point at 4" in found.notes[0]
