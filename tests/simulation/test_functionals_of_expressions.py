"""Functionals of expressions: values and derivatives against closed forms, wherever they go."""

import pickle

import numpy as np
import pytest
from checks import by_complex_step
from ensemble_runs import Alone, assert_same_bits, ran
from rows import in_rows

import lumped as lp
from lumped import functionals as fun
from lumped import ops
from lumped.components import Brake, Inertia, SpringDamper, Torque
from lumped.errors import EquationError, OptionError, UnitError, UnknownNameError
from lumped.functionals.functional import watching
from lumped.many_runs.native_runs import NativeRuns

A, B, SHARE, UNTIL = 3.0, 20.0, 0.4, 2.0


class Waves(lp.Component):
    """Two oscillators, ``x = sin a t`` and ``y = sin b t``."""

    a: lp.Param = lp.param("rad/s", "rate of the slow one", A)
    b: lp.Param = lp.param("rad/s", "rate of the fast one", B)
    share: lp.Param = lp.param("1", "share of the fast one", SHARE)
    x: lp.Var = lp.var("1", "slow wave", 0.0, state="always")
    v: lp.Var = lp.var("1", "its rate over its angular rate", 1.0, state="always")
    y: lp.Var = lp.var("1", "fast wave", 0.0, state="always")
    u: lp.Var = lp.var("1", "its rate over its angular rate", 1.0, state="always")

    def equations(self):
        yield lp.der(self.x) == self.a * self.v
        yield lp.der(self.v) == -self.a * self.x
        yield lp.der(self.y) == self.b * self.u
        yield lp.der(self.u) == -self.b * self.y


waves = Waves()


@pytest.fixture(scope="module")
def system():
    return lp.assemble(waves)


def size(a, b, s):
    """Integral of |sin a t|, half a wave after the other."""
    halves = np.floor(a.real * UNTIL / np.pi)
    return (2 * halves + 1 - np.cos(a * UNTIL - halves * np.pi)) / a


def above(a, b, s):
    """Mean of sin a t where it is above a half: once in the run, for a = 3 rad/s."""
    return 2 * np.cos(np.pi / 6) / (a * UNTIL)


def lower_crest(a, b, s):
    """Highest of the lower wave, where both meet: ``(a + b) t`` is an odd multiple of pi."""
    odd = np.arange(1, 2 * 7, 2) * np.pi / (a + b)
    met = np.sin(a * odd)
    return met[np.argmax(met.real)]


def speed(a, b, s):
    """Root mean square of ``a cos a t + s b cos b t``."""

    def mean(p, q):
        first = UNTIL if p == q else np.sin((p - q) * UNTIL) / (p - q)
        return (first + np.sin((p + q) * UNTIL) / (p + q)) / (2 * UNTIL)

    return np.sqrt(a**2 * mean(a, a) + 2 * a * b * s * mean(a, b) + (s * b) ** 2 * mean(b, b))


def difference(a, b, s):
    """Largest ``|sin a t| - 0.8 sin b t``: from a sample, and Newton's method."""

    def wave(t, order):
        turn = order * np.pi / 2
        sign = np.sign(np.sin(a.real * t.real))
        return a**order * sign * np.sin(a * t + turn) - 0.8 * b**order * np.sin(b * t + turn)

    t = np.linspace(0, UNTIL, 20001) + 0j
    t = t[np.argmax(np.abs(wave(t, 0)))]
    for _ in range(6):
        t = t - wave(t, 1) / wave(t, 2)
    return wave(t, 0) * np.sign(wave(t, 0).real)


FORMULAS = [
    (fun.integral(abs(waves.x)), size),
    (fun.mean(ops.where(waves.x > 0.5, 1, 0) * waves.x), above),
    (fun.highest(ops.minimum(waves.x, waves.y)), lower_crest),
    (fun.rms(lp.der(waves.x) + waves.share * lp.der(waves.y)), speed),
    (fun.peak(abs(waves.x) - 0.8 * waves.y), difference),
    (
        fun.final(waves.share * waves.x * waves.y),
        lambda a, b, s: s * np.sin(a * UNTIL) * np.sin(b * UNTIL),
    ),
    (
        fun.at_time([0.3, 0.7], ops.exp(waves.x) * ops.cos(lp.time * waves.a)),
        lambda a, b, s: sum(np.exp(np.sin(a * t)) * np.cos(a * t) for t in (0.3, 0.7)),
    ),
    (
        fun.integral(waves.x * waves.u, between=(0.25, 1.5)),
        lambda a, b, s: (
            -sum(0.5 * (np.cos(k * 1.5) - np.cos(k * 0.25)) / k for k in (a + b, a - b))
        ),
    ),
]
OF = [functional for functional, _ in FORMULAS]
EXACT = np.array([exact(A, B, SHARE).real for _, exact in FORMULAS])
POINT = np.array([A, B, SHARE])
SLOPES = by_complex_step(lambda *point: [exact(*point) for _, exact in FORMULAS], POINT)


def test_values_and_derivatives_of_a_single_run(system):
    found = lp.gradient(system, of=OF, by=["a", "b", "share"], until=UNTIL, rtol=1e-8)
    print(np.abs(found.values - EXACT).max(), np.abs(found.derivatives - SLOPES).max())
    np.testing.assert_allclose(found.values, EXACT, rtol=1e-9)
    np.testing.assert_allclose(found.derivatives, SLOPES, rtol=1e-8, atol=1e-8)
    forward = lp.sensitivity(system, of=OF, by=["a", "b", "share"], until=UNTIL, rtol=1e-8)
    np.testing.assert_allclose(forward.values, EXACT, rtol=1e-9)
    np.testing.assert_allclose(forward.slopes, SLOPES, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
def test_values_of_many_runs(system, method):
    rng = np.random.default_rng(4)
    points = {"a": rng.uniform(2.9, 3.1, 20), "b": rng.uniform(18, 22, 20)}
    points["share"] = rng.uniform(0.1, 1.0, 20)
    over = lp.ensembles.paired(points)
    found = lp.ensemble(system, over=over, of=OF, until=UNTIL, rtol=1e-9, method=method)
    rows = zip(*(column + 0j for column in points.values()), strict=True)
    expected = np.array([[exact(*row).real for _, exact in FORMULAS] for row in rows])
    print(method, np.abs(found.values - expected).max())
    np.testing.assert_allclose(found.values, expected, rtol=1e-7, atol=1e-7)


def test_runs_side_by_side_have_the_bits_of_single_ones(system):
    points = np.random.default_rng(5).uniform(2, 4, (17, 1))
    own = watching(system, OF)
    assert own is not system
    smooth = [functional for functional in OF if watching(system, [functional]) is system]
    assert len(smooth) == 4
    for scene, of in ((system, smooth), (own, OF)):
        labelled = {str(functional): functional for functional in of}
        both = [ran(scene, ["a"], points, labelled, UNTIL, kind=k) for k in (NativeRuns, Alone)]
        assert_same_bits(*both)


def test_a_finished_run_gives_expressions(system):
    run = lp.simulate(system, until=UNTIL, rtol=1e-10)
    x, y = np.sin(A * run.t), np.sin(B * run.t)
    for expression, expected in (
        (abs(waves.x) - 0.8 * waves.y, abs(x) - 0.8 * y),
        (ops.maximum(waves.x, waves.y) * lp.time, np.maximum(x, y) * run.t),
        (lp.der(waves.x) / waves.a, np.cos(A * run.t)),
    ):
        np.testing.assert_allclose(run[expression], expected, atol=1e-8)


def test_the_best_level_for_whole_runs_is_the_mean_size(system):
    level = waves.share - abs(waves.x)
    found = lp.optimise(
        system, vary={"share": (0.1, 1.0)}, minimise=fun.integral(level * level), until=UNTIL
    )
    assert found.parameters["share"] == pytest.approx(size(A + 0j, B, 0).real / UNTIL, rel=1e-7)


def test_the_best_level_for_the_equations_of_a_run(system):
    """The mean of x^2; kinks are refused, as they would be followed inexactly."""
    run = lp.simulate(system, until=UNTIL)
    level, vary = waves.share - waves.x**2, {"share": (0.1, 1.0)}
    found = lp.optimise(run, vary=vary, minimise=fun.rms(level))
    mean = 0.5 - np.sin(2 * A * UNTIL) / (4 * A * UNTIL)
    assert found.parameters["share"] == pytest.approx(mean, rel=1e-6)
    with pytest.raises(OptionError, match=r"rms\(share - abs\(x\)\) has kinks.*smooth"):
        lp.optimise(run, vary=vary, minimise=fun.rms(waves.share - abs(waves.x)))


def test_a_measured_product_tells_both_rates(system):
    t = np.linspace(0.05, 1.0, 60)
    measured = {waves.x * waves.u: np.sin(2.8 * t) * np.cos(21.0 * t)}
    found = lp.identify(system, vary={"a": (2.0, 4.0), "b": (19.0, 23.0)}, t=t, measured=measured)
    assert found.parameters["a"] == pytest.approx(2.8, rel=1e-6)
    assert found.parameters["b"] == pytest.approx(21.0, rel=1e-6)


def test_jax_gets_value_and_gradient(system):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    function = lp.to_jax(system, of=OF, by=["a", "b", "share"], until=UNTIL, rtol=1e-8)
    np.testing.assert_allclose(function(POINT), EXACT, rtol=1e-9)
    slopes = jax.jacrev(function)(jax.numpy.array(POINT))
    np.testing.assert_allclose(slopes, SLOPES, rtol=1e-8, atol=1e-8)


def test_copies_are_equal_and_watch_the_same(system):
    for functional in OF:
        copy = pickle.loads(pickle.dumps(functional))
        assert copy == functional
        assert hash(copy) == hash(functional)
    assert fun.peak(waves.x * 2.0) != fun.peak(waves.x * 2.0000000001)
    of = fun.peak(abs(waves.x))
    own = watching(system, [of])
    copy = pickle.loads(pickle.dumps(own))
    assert copy.inputs[3].shape == own.inputs[3].shape == (1, 1)
    assert watching(own, [of]) is own


def braked():
    """A motor turns a body that a brake holds at first."""
    return in_rows(
        "drive motor shaft load brake",
        motor=Inertia(J=0.5),
        drive=Torque(tau=ops.minimum(lp.time * 100, 60.0)),
        shaft=SpringDamper(c=2e3, d=1.0),
        load=Inertia(J=1.5),
        brake=Brake(f_max=20.0, u=1.0, characteristic=((0.0, 1.0),)),
    )


def test_a_drive_with_a_brake_agrees_with_its_dense_output():
    m = braked()
    system = lp.assemble(m)
    tau, brake, w = m.shaft.tau, m.brake.tau, m.shaft.w_rel
    of = [
        fun.peak(abs(tau) - 0.8 * brake),
        fun.integral(ops.maximum(tau * w, 0)),
        fun.rms(ops.maximum(-tau - 15.0, 0)),
        fun.integral(abs(lp.der(tau))),
        fun.count("brake"),
    ]
    found = lp.gradient(system, of=of[:-1], by=["shaft.c", "load.J"], until=1.0)
    run = lp.simulate(system, until=1.0, rtol=1e-10, grid=200_000)
    t, torque = run.t, run["shaft.tau"]
    power = torque * run["shaft.w_rel"]
    expected = [
        np.abs(np.abs(torque) - 0.8 * run["brake.tau"]).max(),
        np.trapezoid(np.maximum(power, 0), t),
        np.sqrt(np.trapezoid(np.maximum(-torque - 15.0, 0) ** 2, t)),
        np.abs(np.diff(torque)).sum(),
    ]
    np.testing.assert_allclose(found.values, expected, rtol=1e-6)
    many = lp.ensemble(system, over={"shaft.c": [2e3] * 3}, of=of, until=1.0)
    np.testing.assert_allclose(many.values[:, :-1], [expected] * 3, rtol=1e-4)
    assert (many["count(brake, all)"] == sum(e.component == "brake" for e in run.events)).all()
    h = np.array([2e3, 1.5]) * 1e-5
    for k, (name, value) in enumerate({"shaft.c": 2e3, "load.J": 1.5}.items()):
        near = {name: [value - h[k], value + h[k]]}
        down, up = lp.ensemble(system, over=near, of=of[:-1], until=1.0, rtol=1e-12).values
        np.testing.assert_allclose(found.derivatives[:, k], (up - down) / (2 * h[k]), rtol=3e-5)
    assert [f.unit(system) for f in of[:4]] == ["N.m", "N.m rad/s s", "N.m", "N.m/s s"]


def test_what_has_no_meaning_is_named():
    m = braked()
    system, other = lp.assemble(m), lp.compose(body=Inertia(J=1.0))

    def run(expression):
        lp.ensemble(system, over={"shaft.c": [1e3]}, of=[fun.peak(expression)], until=1.0)

    with pytest.raises(UnknownNameError, match=r"no quantity or parameter 'body.w'. Nearest"):
        run(other.body.w * 2)
    pytest.importorskip("pint")
    for kind, text, expression in (
        (
            UnitError,
            r"shaft.tau \+ load.w: .* kg m\^2 s\^-2 against s\^-1",
            lambda: m.shaft.tau + m.load.w,
        ),
        (UnitError, r"sin\(shaft.tau\): .* against number", lambda: ops.sin(m.shaft.tau)),
        (
            UnknownNameError,
            r"needs motor.phi. .*keep=\['motor.phi'\]",
            lambda: abs(m.shaft.tau * m.load.phi),
        ),
        (UnknownNameError, r"time \* 2: no quantity stands in it", lambda: lp.time * 2),
        (UnknownNameError, "'J' is of a class", lambda: Inertia.J * 2),
        (EquationError, "relation", lambda: (m.shaft.tau > 3) * m.load.w),
        (OptionError, "a name", lambda: 3.0),
    ):
        with pytest.raises(kind, match=text):
            run(expression())
