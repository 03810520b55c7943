"""Gradients of many runs, and runs as functions for SciPy and JAX."""

import sys

import numpy as np
import pytest
import scipy
from checks import refused
from rows import assemble_row

import lumped as lp
from lumped import functionals
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError, SolverError, UnknownNameError

PEAK, LAST = functionals.peak("shaft.tau"), functionals.final("a.w")
VARIED = ["a.J", "shaft.c"]


@pytest.fixture(scope="module")
def system():
    return assemble_row(
        load=Torque(tau=3.0),
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=100.0, d=0.1),
        b=Inertia(J=2.0),
        rest=SpringDamper(c=50.0, d=0.2),
        wall=Fixed(),
    )


def test_gradients_of_many_runs_are_those_of_each(system):
    over = {"a.J": lp.uniform(0.5, 2.0), "shaft.c": lp.uniform(50.0, 200.0)}
    found = lp.gradients.gradient_ensemble(system, over=over, runs=12, of=[PEAK, LAST], until=2.0)
    assert found.derivatives.shape == (12, 2, 2)
    assert not found.failures
    for i, point in enumerate(found.points):
        values = dict(zip(found.names, point.tolist(), strict=True))
        one = lp.gradient(system, of=[PEAK, LAST], by=VARIED, until=2.0, parameters=values)
        assert (found.derivatives[i] == one.derivatives).all()
        assert (found.values[i] == one.values).all()
    assert (found[str(PEAK), "a.J"] == found.derivatives[:, 0, 0]).all()
    refused(UnknownNameError, lambda: found[str(PEAK), "shaft.d"], "shaft.d")


def test_runs_without_a_derivative_are_set_apart(system):
    growing = lp.assemble(_growing())
    of = [functionals.final("g.x")]
    found = lp.gradients.gradient_ensemble(growing, over={"g.a": [0.5, 2.0]}, of=of, until=1.0)
    assert set(found.failures) == {1}
    assert np.isnan(found.values[1]).all()
    # x = 1 / (1 - a t), dx/da = t x^2
    assert found.derivatives[0, 0, 0] == pytest.approx(4.0, rel=1e-6)
    with pytest.raises(SolverError, match="all 2 runs fail"):
        lp.gradients.gradient_ensemble(growing, over={"g.a": [2.0, 3.0]}, of=of, until=1.0)


def test_processes_give_the_bits_of_single_gradients(system, monkeypatch):
    monkeypatch.setattr(sys.modules["lumped.gradients.gradient_ensemble"], "_ALONE", 0.0)
    given = {"over": {"a.J": np.linspace(0.5, 2.0, 9)}, "of": [PEAK, LAST], "until": 2.0}
    alone, shared = (
        lp.gradients.gradient_ensemble(system, **given, workers=workers) for workers in (1, 2)
    )
    assert not shared.failures
    for field in ("values", "errors", "derivatives"):
        assert (getattr(alone, field) == getattr(shared, field)).all()
    growing = lp.assemble(_growing())
    over, of = {"g.a": [0.5, 0.6, 2.0]}, [functionals.final("g.x")]
    found = lp.gradients.gradient_ensemble(growing, over=over, of=of, until=1.0, workers=2)
    assert set(found.failures) == {2}
    # x = 1 / (1 - a t), dx/da = t x^2
    assert found.derivatives[:2, 0, 0] == pytest.approx([4.0, 6.25], rel=1e-6)


def test_scipy_finds_the_optimum_of_a_run(system):
    """Least root mean square of the torque by the stiffness, against a scan by single runs."""
    rms = functionals.rms("shaft.tau")
    fun = lp.gradients.value_and_gradient(system, of=rms, by=["rest.c"], until=2.0)

    def scaled(u):
        value, slope = fun(u * 100)
        return value, slope * 100

    found = scipy.optimize.minimize(scaled, [0.5], jac=True, bounds=[(0.05, 3.0)])
    grid = np.linspace(5.0, 300.0, 591)
    scan = lp.ensemble(system, over={"rest.c": grid}, of=[rms], until=2.0, rtol=1e-9)
    best = grid[scan.values[:, 0].argmin()]
    assert found.fun <= scan.values.min() * (1 + 1e-6)
    assert abs(100 * found.x[0] - best) <= 0.5


def test_weighted_sums_have_the_gradients_of_their_parts(system):
    fun = lp.gradients.value_and_gradient(system, of={PEAK: 2.0, LAST: -1.0}, by=VARIED, until=2.0)
    value, slope = fun(np.array([1.0, 100.0]))
    one = lp.gradient(system, of=[PEAK, LAST], by=VARIED, until=2.0)
    assert value == pytest.approx(2 * one.values[0] - one.values[1], rel=1e-12)
    assert slope == pytest.approx(2 * one.derivatives[0] - one.derivatives[1], rel=1e-12)
    refused(OptionError, lambda: fun(np.ones(3)), "shape (3,); 2 are needed")


def test_jax_differentiates_compiles_and_batches_runs(system):
    jax = pytest.importorskip("jax")
    was = jax.config.jax_enable_x64
    try:
        jax.config.update("jax_enable_x64", False)
        with pytest.raises(OptionError, match="jax_enable_x64"):
            lp.to_jax(system, of=[PEAK], by=VARIED, until=2.0)
        jax.config.update("jax_enable_x64", True)
        function = lp.to_jax(system, of=[PEAK, LAST], by=VARIED, until=2.0)
        one = lp.gradient(system, of=[PEAK, LAST], by=VARIED, until=2.0)
        point = jax.numpy.array([1.0, 100.0])
        assert (np.asarray(function(point)) == one.values).all()
        assert (np.asarray(jax.jacrev(function)(point)) == one.derivatives).all()
        squared = jax.jit(jax.grad(lambda v: function(v)[0] ** 2))(point)
        expected = 2 * one.values[0] * one.derivatives[0]
        assert np.asarray(squared) == pytest.approx(expected, rel=1e-12)
        points = jax.numpy.array([[1.0, 100.0], [1.5, 80.0], [0.7, 130.0]])
        batch = np.asarray(jax.vmap(jax.jacrev(function))(points))
        assert batch.shape == (3, 2, 2)
        assert (batch[0] == one.derivatives).all()
        refused(OptionError, lambda: function(jax.numpy.ones(3)), "2 are needed")
    finally:
        jax.config.update("jax_enable_x64", was)


def test_bad_input_is_refused_by_name(system):
    with pytest.raises(UnknownNameError, match=r"shaft\.cc"):
        lp.gradients.value_and_gradient(system, of=PEAK, by=["shaft.cc"], until=2.0)
    with pytest.raises(OptionError, match="workers = 0"):
        lp.gradients.gradient_ensemble(system, over={"a.J": [1.0]}, of=[PEAK], until=1.0, workers=0)
    with pytest.raises(UnknownNameError, match=r"shaft\.torque"):
        lp.gradients.value_and_gradient(
            system, of=functionals.peak("shaft.torque"), by=VARIED, until=2.0
        )


def _growing():
    class Growing(lp.Component):
        """``x' == a x^2``: infinite at ``1 / a``."""

        a: lp.Param = lp.param("1/s", "growth of one", 1.0)
        x: lp.Var = lp.var("1", "what grows", start=1.0, state="always")

        def equations(self):
            yield lp.der(self.x) == self.a * self.x**2

    return lp.compose(g=Growing(), connections=lambda m: ())
