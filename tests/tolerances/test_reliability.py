"""Probabilities, design points and their derivatives for drives whose answer is a closed form."""

import matplotlib.pyplot as plt
import numpy as np
import plotly.graph_objects as go
import pytest
import scipy
from rows import in_a_row
from scipy.stats import norm

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, SpringDamper, Stop, Torque
from lumped.ensembles import correlated, lognormal
from lumped.errors import OptionError, ParameterError, SolverError, UnknownNameError
from tests.tolerances.drives import MEANS, STDS, TORQUES, normals, pulled


def pulled_to_a_stop():
    """A body at rest reaches a stop after ``sqrt(2 / -tau)`` seconds."""
    return lp.compose(
        a=Inertia(J=1.0),
        pull=Torque(tau=-1.0),
        stop=Stop(phi_min=-1.0),
        connections=lambda m: [lp.connect(m.a.flange_a, m.pull.flange, m.stop.flange_b)],
    )


def spring_mass(d=0.0):
    return in_a_row(wall=Fixed(), spring=SpringDamper(c=400.0, d=d), mass=Inertia(J=1.0))


def two_masses():
    return in_a_row(a=Inertia(J=1.0), spring=SpringDamper(c=400.0, d=0.0), b=Inertia(J=2.0))


@pytest.fixture(scope="module")
def pull():
    return lp.assemble(pulled())


@pytest.fixture(scope="module")
def swing():
    return lp.modes(lp.assemble(spring_mass()))


@pytest.fixture(scope="module")
def torsion():
    return lp.modes(lp.assemble(two_masses()))


def test_a_speed_that_is_linear_in_normal_torques(pull):
    found = lp.reliability(
        pull, fun.final("a.w"), above="12 rad/s", over=normals(), until=1.0, by=["a.J"]
    )
    # the sum of torques over 2 kg.m2, after 1 s
    mean, std = MEANS.sum() / 2, np.linalg.norm(STDS) / 2
    beta = (12 - mean) / std
    print(found)
    assert found.beta == pytest.approx(beta, rel=1e-6)
    assert found.probability == pytest.approx(norm.sf(beta), rel=1e-5)
    at = MEANS + (24 - MEANS.sum()) * STDS**2 / (STDS @ STDS)
    assert [*found.design_point.values()] == pytest.approx(at, rel=1e-6)
    assert found.importance == pytest.approx(STDS**2 / (STDS @ STDS), rel=1e-5)
    for i, name in enumerate(TORQUES):
        by_mean, by_std = found.influence(name), found.influence(name, "deviation")
        assert by_mean.beta == pytest.approx(-0.5 / std, rel=1e-6)
        assert by_std.beta == pytest.approx(-beta * STDS[i] / (STDS @ STDS), rel=1e-5)
        assert by_mean.probability == pytest.approx(norm.pdf(beta) * 0.5 / std, rel=1e-5)
    # at the point a.w is 12, and falls with the inertia
    by = found.influence("a.J", "value")
    assert by.beta == pytest.approx(12 / 2 / std, rel=1e-6)
    assert by.probability == pytest.approx(-norm.pdf(beta) * 12 / 2 / std, rel=1e-5)


def test_torques_that_depend_on_each_other(pull):
    matrix = np.array([[1, 0.6, -0.2], [0.6, 1, 0.1], [-0.2, 0.1, 1]])
    found = lp.reliability(
        pull, fun.final("a.w"), above=12.0, over=correlated(normals(), matrix), until=1.0
    )
    spread = np.sqrt(STDS @ matrix @ STDS)
    beta = (24 - MEANS.sum()) / spread
    assert found.beta == pytest.approx(beta, rel=1e-6)
    at = MEANS + beta * (np.diag(STDS) @ matrix @ STDS) / spread
    assert [*found.design_point.values()] == pytest.approx(at, rel=1e-6)
    assert found.influence("s.tau").beta == pytest.approx(-1 / spread, rel=1e-6)
    assert np.abs(found.importance).sum() == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("search", ["form", "sorm"])
@pytest.mark.parametrize("side", ["above", "below"])
@pytest.mark.parametrize("middle", [9.2, 11.0])
def test_a_speed_in_a_band(pull, search, side, middle):
    """Within 0.3 rad/s of a speed, near to the mean and far from it."""
    off = (fun.final("a.w") - middle) ** 2
    call = {"over": normals(), "until": 1.0, "search": search}
    found = lp.reliability(pull, off, **{side: 0.09}, **call)
    low, high = ((2 * (middle + d) - MEANS.sum()) / np.linalg.norm(STDS) for d in (-0.3, 0.3))
    inside = norm.cdf(high) - norm.cdf(low)
    exact = inside if side == "below" else 1 - inside
    assert found.probability == pytest.approx(exact, rel=1e-4)
    assert len(found.points) == 2
    assert not found.notes


def test_a_remark_tells_where_planes_do_not_fit(pull):
    """Both torques, in their deviations, farther than 3 from nearly the mean: chi-square."""
    torque = {n: fun.final(f"{n}.flange.tau") for n in ("t", "s")}
    sign = np.sign(pull_value(pull, torque["t"]))
    square = (torque["t"] - sign * 10.1) ** 2 + 4 * (torque["s"] - sign * 4.0) ** 2
    over = {"t.tau": lp.normal(10.0, 1.0), "s.tau": lp.normal(4.0, 0.5)}
    found = lp.reliability(pull, square, above=9.0, over=over, until=1.0)
    (remark,) = [line for line in repr(found).splitlines() if "directions" in line]
    told = float(remark.partition("probability ")[2].split()[0])
    assert told == pytest.approx(scipy.stats.ncx2.sf(9.0, 2, 0.01), rel=0.3)
    assert found.probability < 0.3 * told


def pull_value(system, functional):
    return lp.simulate(system, until=1.0).value(functional)


def test_torques_that_follow_from_each_other(pull):
    whole = correlated(normals(), np.ones((3, 3)))
    found = lp.reliability(pull, fun.final("a.w"), above=12.0, over=whole, until=1.0, search="sorm")
    assert found.beta == pytest.approx((24 - MEANS.sum()) / STDS.sum(), rel=1e-6)


def test_a_frequency_of_lognormal_parameters(swing):
    limit = 20 / (2 * np.pi) * 1.2
    over = {"spring.c": lognormal(400.0, 0.1), "mass.J": lognormal(1.0, 0.05)}
    beta = np.log(1.2) / np.hypot(0.05, 0.025)
    at = np.array([400, 1]) * np.exp(np.log(1.2) * np.array([0.1**2, -(0.05**2)]) / 2 / 0.003125)
    for method in ("form", "sorm"):
        found = lp.reliability(swing, fun.frequency(0), above=limit, over=over, search=method)
        print(method, found.beta / beta - 1)
        assert found.beta == pytest.approx(beta, rel=1e-7)
        assert [*found.design_point.values()] == pytest.approx(at, rel=1e-5)
        assert found.importance == pytest.approx([0.8, -0.2], rel=1e-6)
    assert found.second_order[0].curvatures == pytest.approx([0.0], abs=1e-6)
    assert found.second_order[0].source == "second derivatives"


def test_derivatives_are_those_of_shifted_and_stretched_distributions(torsion):
    """Of laws that stay in their family: lognormal with a place of its own, and uniform."""

    def beta(shift=0.0, wide=1.0):
        c = scipy.stats.lognorm(0.15, loc=0, scale=400)
        law = scipy.stats.lognorm(0.15, loc=c.mean() * (1 - wide) + shift, scale=400 * wide)
        over = {"spring.c": law, "a.J": lp.uniform(0.8, 1.2)}
        return lp.reliability(torsion, fun.frequency(0), above=4.8, over=over)

    found = beta()
    law = scipy.stats.lognorm(0.15, scale=400)
    print(found)
    assert found.means == pytest.approx([law.mean(), 1.0], rel=1e-9)
    assert found.deviations == pytest.approx([law.std(), 0.4 / np.sqrt(12)], rel=1e-7)
    for of, steps in (
        ("mean", [{"shift": h} for h in (0.05, -0.05)]),
        ("deviation", [{"wide": 1 + h / law.std()} for h in (0.05, -0.05)]),
    ):
        up, down = (beta(**step) for step in steps)
        by = found.influence("spring.c", of)
        off = by.beta / ((up.beta - down.beta) / 0.1) - 1
        print(of, off)
        assert abs(off) < 1e-5
        change = (up.probability - down.probability) / 0.1
        assert by.probability == pytest.approx(change, rel=1e-5)


@pytest.fixture(scope="module")
def monte_carlo():
    """Of the two masses: share of 2 million frequencies above 5 Hz, from the closed form."""
    random = np.random.default_rng(0)
    z = random.standard_normal((3, 2_000_000))
    c, a, b = (
        400 * np.exp(0.15 * z[0]),
        np.maximum(1 + 0.12 * z[1], 0.1),
        np.maximum(2 + 0.4 * z[2], 0.1),
    )
    share = (np.sqrt(c * (1 / a + 1 / b)) > 10 * np.pi).mean()
    return share, np.sqrt((1 - share) / share / z.shape[1])


SCATTERED = {
    "spring.c": lognormal(400.0, 0.15),
    "a.J": lp.normal(1.0, 0.12),
    "b.J": lp.normal(2.0, 0.4),
}


def test_second_order_meets_the_share_of_many_samples(torsion, monte_carlo):
    share, error = monte_carlo
    over = SCATTERED | {
        n: lp.ensembles.truncated(SCATTERED[n], low, None)
        for n, low in (("a.J", 0.1), ("b.J", 0.1))
    }
    found = {
        method: lp.reliability(torsion, fun.frequency(0), above=5.0, over=over, search=method)
        for method in ("form", "sorm")
    }
    for method, one in found.items():
        print(method, one.probability / share - 1, "+-", error)
    assert "compare with search='sorm'" in repr(found["form"])
    bent = found["sorm"].second_order[0]
    assert bent.source == "second derivatives"
    assert (np.abs(bent.curvatures) > 1e-3).all()
    assert abs(found["sorm"].probability / share - 1) < 0.03
    first, second = (abs(found[m].probability / share - 1) for m in ("form", "sorm"))
    assert second < first
    sampled = lp.reliability(
        torsion, fun.frequency(0), above=5.0, over=over, search="importance", runs=400
    )
    assert sampled.interval[0] < share < sampled.interval[1]
    assert sampled.evaluations > 400 > sampled.gradients


def test_second_order_of_a_run_has_the_curvature_of_its_closed_form(pull):
    """A sum of lognormal torques: ``(t + 8) / 2`` with ``t = m1 exp(a1 u1) + m2 exp(a2 u2)``."""
    middle, wide = np.array([10.0, 4.0]), np.array([0.25, 0.4])
    over = {n: lognormal(m, a) for n, m, a in zip(TORQUES[:2], middle, wide, strict=True)}
    common = {"above": 15.0, "over": over, "until": 1.0, "parameters": {"r.tau": 8.0}}
    found = lp.reliability(pull, fun.final("a.w"), search="sorm", **common)
    (bent,) = found.second_order
    at = np.array([*found.design_point.values()])
    by, bend = wide * at, wide**2 * at
    along = np.array([-by[1], by[0]]) / np.linalg.norm(by)
    kappa = -(along**2 @ bend) / np.linalg.norm(by)
    exact, _ = scipy.integrate.quad(
        lambda u: (
            norm.pdf(u)
            * norm.sf(np.log(max(22 - middle[1] * np.exp(wide[1] * u), 1e-9) / middle[0]) / wide[0])
        ),
        -10,
        10,
        epsabs=1e-14,
        limit=400,
    )
    plain = lp.reliability(pull, fun.final("a.w"), **common)
    off = [one.probability / exact - 1 for one in (plain, found)]
    assert bent.source == "gradients around it"
    assert bent.curvatures == pytest.approx([kappa], rel=1e-4)
    assert found.gradients - plain.gradients == 2
    assert abs(off[1]) < 0.1 * abs(off[0])


def test_a_run_is_made_level_by_level(pull):
    over = normals()
    beta = (24 - MEANS.sum()) / np.linalg.norm(STDS)
    found = lp.reliability(
        pull, fun.final("a.w"), above=12.0, over=over, until=1.0, search="subset", runs=2000, seed=2
    )
    print(found)
    assert found.interval[0] < norm.sf(beta) < found.interval[1]
    assert found.gradients == 0
    assert not found.points
    for action in (lambda: found.design_point, lambda: found.influence("t.tau")):
        with pytest.raises(OptionError, match="there is no design point"):
            action()
    for level in found.levels:  # each level is a quantile of the closed form
        exact = norm.sf((2 * level.value - MEANS.sum()) / np.linalg.norm(STDS))
        assert level.probability == pytest.approx(exact, rel=4 * found.sampled.deviation)


def test_what_is_printed_and_drawn(pull, swing):
    common = {"over": normals(), "above": 12.0, "until": 1.0}
    first = lp.reliability(pull, fun.final("a.w"), by=["a.J"], **common)
    text = repr(first)
    share = 100 * STDS**2 / (STDS @ STDS)
    for name, part in zip(TORQUES, share, strict=True):
        line = next(line for line in text.splitlines() if line.startswith(name))
        assert f" {part:.1f} " in line
        assert " N.m " in line
    assert "final(a.w) above 12 rad/s" in text
    assert "1 % more of" in text
    assert "<table" in first._repr_html_()
    with lp.display_units({"N.m": "kN.m"}):
        assert " kN.m " in repr(first)
    levels = lp.reliability(pull, fun.final("a.w"), search="subset", runs=100, **common)
    assert "moves accepted" in repr(levels)
    assert "<table" in levels._repr_html_()
    for found, label in ((first, "importance factor, %"), (levels, "final(a.w), 1/min")):
        figure = found.plot(units={"rad/s": "1/min"})
        assert figure.axes[0].get_xlabel() == label
        plt.close(figure)
        assert isinstance(found.plot(backend="plotly"), go.Figure)
    bars = first.plot().axes[0].patches
    assert sorted(bar.get_width() for bar in bars) == pytest.approx(sorted(share), rel=1e-5)
    plt.close("all")


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({"runs": 500}, OptionError, "runs = 500 is for samples"),
        ({"search": "importance", "runs": 5}, OptionError, "at least 100"),
        ({"search": "subset", "searches": 3}, OptionError, "search='subset' has none"),
        ({"search": "subset", "by": ["a.J"]}, OptionError, "by = is for derivatives"),
        ({"searches": 0}, OptionError, "searches = 0"),
        ({"seed": -1}, OptionError, "seed = -1"),
        ({"by": ["t.tau"]}, OptionError, "t.tau scatters"),
        ({"by": ["nothing"]}, UnknownNameError, "nothing"),
        ({"until": None}, OptionError, "give until="),
        ({"above": None}, OptionError, "above= or as below="),
        ({"over": {"t.tau": [1.0, 2.0]}}, OptionError, "a distribution of each parameter"),
        ({"over": {"t.tau": lp.normal(1.0, -1.0)}}, OptionError, "t.tau: std = -1 N.m must be"),
        ({"over": {"a.J": lp.normal(1.0, 1.0)}}, ParameterError, "a.J .* greater than 0 kg.m2"),
        ({"above": 1e3}, SolverError, "is met nowhere .* at beta = 8"),
        ({"below": 1e3, "above": None}, SolverError, "is met everywhere"),
        ({"search": "importance", "above": 1e3}, SolverError, "is met nowhere"),
        ({"over": {"t.tau": lp.normal(1.0, 0.1)}, "until": 1e-9}, SolverError, "nowhere"),
    ],
)
def test_wrong_calls(pull, changes, kind, words):
    call = {"over": normals(), "above": 12.0, "until": 1.0} | changes
    with pytest.raises(kind, match=words) as caught:
        lp.reliability(pull, fun.final("a.w"), **call)
    print(caught.value)


def test_runs_without_the_event_are_told():
    """A body hits a stop after ``sqrt(2 / tau)`` seconds, or later than the run lasts."""
    system = lp.assemble(pulled_to_a_stop())
    found = lp.reliability(
        system,
        fun.instant("stop", "closed"),
        above=1.45,
        over={"pull.tau": lp.normal(-1.0, 0.12)},
        until=1.55,
        start={"a.phi": 0.0, "a.w": 0.0},
        search="subset",
        runs=1000,
    )
    print(found)
    late, never = (norm.cdf((2 / t**2 - 1) / 0.12) for t in (1.45, 1.55))
    assert found.sampled.unknown == pytest.approx(never, rel=0.3)
    assert found.probability == pytest.approx((late - never), rel=0.3)
    assert found.interval[1] > late
    assert "why one failed: instant(stop" in repr(found)


def test_a_swing_is_a_difference_of_extremes(pull):
    found = lp.reliability(pull, fun.swing("a.w"), above=12.0, over=normals(), until=1.0)
    assert found.beta == pytest.approx((24 - MEANS.sum()) / np.linalg.norm(STDS), rel=1e-5)


def test_what_has_no_derivative_names_the_method_that_needs_none():
    system = lp.assemble(pulled_to_a_stop())
    call = {"above": 0.5, "over": {"pull.tau": lp.normal(-1.0, 0.12)}, "until": 1.5}
    call["start"] = {"a.phi": 0.0, "a.w": 0.0}
    with pytest.raises(OptionError, match="search='subset' needs no derivatives") as caught:
        lp.reliability(system, fun.count("stop", "closed"), **call)
    print(caught.value)
    found = lp.reliability(system, fun.count("stop", "closed"), search="subset", runs=1000, **call)
    assert found.probability == pytest.approx(norm.sf((2 / 1.5**2 - 1) / 0.12), rel=0.1)


def test_a_damping_that_depends_on_nothing(torsion):
    with pytest.raises(OptionError, match="does not depend on a"):
        lp.reliability(torsion, fun.damping(0), above=0.1, over={"a.J": lp.normal(1.0, 0.1)})
