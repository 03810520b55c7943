"""Functionals as expressions: the same number from runs, ensembles, gradients and differences."""

import pickle

import numpy as np
import pytest
from rows import assemble_rows

import lumped as lp
from lumped import functionals as fun
from lumped import ops
from lumped.components import Damper, Fixed, Inertia, Spring
from lumped.errors import EquationError, OptionError, SolverError

W, Z = 3.0, 0.05


@pytest.fixture(scope="module")
def swinging():
    """A damped swing, ``x(t)`` known in closed form."""
    return assemble_rows(
        "wall spring.flange_a damper",
        "a.flange_a spring.flange_b damper.flange_b",
        wall=Fixed(),
        spring=Spring(c=W**2),
        damper=Damper(d=2 * Z * W),
        a=Inertia(J=1.0, phi=1.0),
    )


def x(t, w=W, d=2 * Z * W):
    decay = d / 2
    own = np.sqrt(w**2 - decay**2)
    return np.exp(-decay * t) * (np.cos(own * t) + decay / own * np.sin(own * t))


def trough(c, d):
    """The first trough, half a period after the start."""
    decay = d / 2
    return -np.exp(-decay * np.pi / np.sqrt(c - decay**2))


def expressions():
    high, low = fun.highest("a.phi"), fun.lowest("a.phi")
    return {
        "ratio": (-low / high, lambda c, d: -trough(c, d)),
        "root": (ops.sqrt(high - low), lambda c, d: np.sqrt(1 - trough(c, d))),
        "least": (ops.minimum(high, -low), lambda c, d: -trough(c, d)),
        "power": (2 + low**2 * 3, lambda c, d: 2 + 3 * trough(c, d) ** 2),
        "decrement": (ops.log(high / abs(low)), lambda c, d: -np.log(-trough(c, d))),
    }


@pytest.mark.parametrize("name", expressions())
def test_expressions_are_the_same_wherever_they_are_asked_for(swinging, name):
    functional, expected = expressions()[name]
    c, d = W**2, 2 * Z * W
    names = ["spring.c", "damper.d"]
    scene = {"until": 4.0, "rtol": 1e-9}
    value = expected(c, d)
    slopes = [
        (expected(c * (1 + 1e-6), d) - expected(c * (1 - 1e-6), d)) / (2e-6 * c),
        (expected(c, d * (1 + 1e-6)) - expected(c, d * (1 - 1e-6))) / (2e-6 * d),
    ]
    many = lp.ensemble(swinging, over={"spring.c": [c]}, of={"f": functional}, **scene)
    assert many["f"] == pytest.approx([value], rel=1e-8)
    found = lp.gradient(swinging, of=[functional], by=names, **scene)
    assert found.values == pytest.approx([value], rel=1e-8)
    assert found.derivatives[0] == pytest.approx(slopes, rel=1e-6, abs=1e-9)
    forward = lp.sensitivity(swinging, of=[functional], by=names, **scene)
    assert forward.slopes[0] == pytest.approx(slopes, rel=1e-6, abs=1e-9)


def test_mean_and_rms_are_integrals_over_the_time(swinging):
    y, part = "a.phi", (0.5, 2.0)
    pairs = [
        (fun.mean(y), fun.integral(y) / fun.span()),
        (fun.rms(y, between=part), ops.sqrt(fun.integral(y, y, between=part) / 1.5)),
        (fun.swing(y), fun.highest(y) - fun.lowest(y)),
        (fun.peak(y), ops.maximum(abs(fun.highest(y)), abs(fun.lowest(y)))),
    ]
    of = {f"{k} {side}": pair[side] for k, pair in enumerate(pairs) for side in (0, 1)}
    found = lp.ensemble(swinging, over={"spring.c": [W**2, 2.0]}, of=of, until=4.0)
    for k in range(len(pairs)):
        assert found[f"{k} 0"] == pytest.approx(found[f"{k} 1"], rel=1e-15)


def test_a_tie_of_two_extremes_has_a_derivative_to_each_side():
    """``x = a t`` up to ``t = 1``: the peak of ``x - 1/2`` is 1/2 on both ends."""

    class Ramp(lp.Component):
        a: lp.Param = lp.param("1", "rate", 1.0)
        x: lp.Var = lp.var("1", "ramp", -0.5)

        def equations(self):
            yield lp.der(self.x) == self.a

    system = lp.assemble(Ramp())
    of = [fun.peak("x"), ops.maximum(fun.highest("x"), -fun.lowest("x"))]
    for functional, words in zip(
        of, ("all equally high", r"highest\(x\) = 0\.5.*lowest"), strict=True
    ):
        with pytest.raises(SolverError, match=f"by a .*{words}"):
            lp.gradient(system, of=[functional], by=["a"], until=1.0)
    for side, expected in (("right", 1.0), ("left", 0.0)):
        found = lp.sensitivity(system, of=of, by=["a"], until=1.0, side=side)
        assert found.slopes[:, 0] == pytest.approx([expected] * 2, abs=1e-9)


def test_functionals_of_the_same_content_are_equal():
    one, other = (fun.peak("a.tau") + 2 * fun.rms("a.w", "a.tau") for _ in range(2))
    assert one == other
    assert {one: 1.0}[other] == 1.0
    assert pickle.loads(pickle.dumps(one)) == one
    assert one != fun.peak("a.tau") + 3 * fun.rms("a.w", "a.tau")
    assert str(one) == "peak(a.tau) + 2 * rms(a.w, a.tau)"
    assert str(3 * (fun.peak("x") - 1)) == "3 * (peak(x) - 1)"
    assert np.float64(2.0) * one == 2 * one


@pytest.mark.parametrize(
    ("build", "unit"),
    [
        (lambda: fun.peak("a.phi"), "rad"),
        (lambda: fun.integral("spring.tau", "a.w"), "N.m rad/s s"),
        (lambda: fun.mean("spring.tau", "a.w"), "N.m rad/s"),
        (lambda: fun.rms("spring.tau"), "N.m"),
        (lambda: fun.rms("spring.tau", "a.w"), "N.m rad/s"),
        (lambda: fun.peak("a.phi") / fun.swing("a.phi"), "1"),
        (lambda: fun.integral("a.w") / fun.span(), "rad/s"),
    ],
)
def test_units_follow_from_those_of_readings(swinging, build, unit):
    assert build().unit(swinging) == unit


def test_what_is_no_functional_is_refused(swinging):
    with pytest.raises(EquationError, match="phi stands beside a functional"):
        fun.peak("a.phi") + swinging.model.a.phi
    with pytest.raises(EquationError, match="'high' stands beside a functional"):
        fun.peak("a.phi") * "high"
    of = [fun.frequency(0) / fun.peak("a.phi")]
    with pytest.raises(OptionError, match="no functional of a run"):
        lp.gradient(swinging, of=of, by=["a.J"], until=1.0)
    with pytest.raises(OptionError, match=r"frequency\(0\) / peak.* is no functional of a run"):
        lp.ensemble(swinging, over={"spring.c": [1.0]}, of=of, until=1.0)


def test_expressions_of_modes(swinging):
    """A frequency over another, and a damping ratio in per cent."""
    found = lp.scatter(
        lp.modes(swinging),
        of={"share": 100 * fun.damping(0), "period": 1 / fun.frequency(0)},
        over={"spring.c": lp.normal(W**2, 1e-3)},
        search="derivatives",
    )
    expected = 1e-3 * np.array([50 * Z / W**2, np.pi / W**3])
    assert [found[k].std for k in ("share", "period")] == pytest.approx(expected, rel=1e-6)


def test_a_new_number_touches_no_file(swinging):
    """Crest factor, form factor, and an efficiency, as a user writes them."""

    def crest_factor(name):
        return fun.peak(name) / fun.rms(name)

    found = lp.ensemble(
        swinging, over={"damper.d": [1e-9]}, of={"f": crest_factor("a.phi")}, until=np.pi / W
    )
    assert found["f"] == pytest.approx([np.sqrt(2)], rel=1e-6)
