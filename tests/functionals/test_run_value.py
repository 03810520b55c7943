"""A functional is the same number of a run, an ensemble, a gradient and a scatter."""

import math
import pickle

import numpy as np
import pytest
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, Inertia, Spring, Stop, Torque
from lumped.errors import OptionError
from lumped.many_runs.watched import Place

UNTIL = 3.0


@pytest.fixture(scope="module")
def bouncing():
    """A body is pulled to a stop, with a spring beside it."""
    return assemble_rows(
        "a.flange_a pull.flange stop.flange_b spring.flange_b",
        "a.flange_a damper.flange_b",
        "wall spring.flange_a damper",
        a=Inertia(J=1.0, phi=1.0),
        pull=Torque(tau=-1.0),
        stop=Stop(phi_min=0.0, restitution=0.5),
        wall=Fixed(),
        spring=Spring(c=0.3),
        damper=Damper(d=0.02),
    )


FUNCTIONALS = {
    "final": fun.final("a.w"),
    "peak": fun.peak("a.w"),
    "highest": fun.highest("a.w", between=(0.2, 2.9)),
    "lowest": fun.lowest("a.w"),
    "swing": fun.swing("a.w"),
    "integral": fun.integral("spring.tau", "a.w"),
    "mean": fun.mean("a.phi"),
    "rms": fun.rms("a.w", between=(0.5, 2.5)),
    "at": fun.at_time([0.5, 1.1], "a.phi"),
    "before": fun.at_event("a.w", "stop"),
    "instant": fun.instant("stop", number=1),
    "loss": fun.loss("stop"),
    "impulse": fun.impulse("stop"),
    "ratio": fun.peak("a.w") / fun.rms("a.w") + fun.span(),
}


@pytest.mark.parametrize("name", FUNCTIONALS)
def test_all_analyses_give_the_same_number(bouncing, name):
    functional, scene = FUNCTIONALS[name], {"until": UNTIL, "rtol": 1e-9}
    run = lp.simulate(bouncing, grid=7, **scene)
    value = run.value(functional)
    many = lp.ensemble(bouncing, over={"a.J": [1.0]}, of={"f": functional}, **scene)
    found = lp.gradient(bouncing, of=[functional], by=["a.J"], **scene)
    scatter = lp.scatter(
        bouncing, of=functional, over={"a.J": lp.normal(1.0, 1e-9)}, runs=2, seed=1, **scene
    )
    others = [many["f"][0], found.values[0], scatter.values[0, 0]]
    assert others == pytest.approx([value] * 3, rel=1e-7, abs=1e-9)


def test_a_value_does_not_depend_on_the_output_times(bouncing):
    """The body falls from 1 with ``w = -a t`` nearly: its peak is that of the first impact."""
    values = [
        lp.simulate(bouncing, until=UNTIL, grid=grid, method=method).value(fun.peak("a.w"))
        for grid, method in ((2, "auto"), (500, "auto"), (None, "auto"), (3, "implicit"))
    ]
    # energy: w^2 = 2 tau h - c h^2, less what the damper takes, at most d h w
    top = np.sqrt(2 * 1.0 + 0.3)
    assert values == pytest.approx([values[0]] * 4, rel=1e-5)
    assert top * (1 - 0.02) < values[0] < top


def test_runs_that_go_on_and_runs_from_points_are_read(bouncing):
    whole = lp.simulate(bouncing, until=UNTIL, rtol=1e-9)
    early = lp.simulate(bouncing, until=1.0, rtol=1e-9)
    late = lp.simulate(bouncing, until=UNTIL, start=early.point(1.0), rtol=1e-9)
    work = fun.integral("spring.tau", "a.w")
    assert early.value(work) + late.value(work) == pytest.approx(whole.value(work), rel=1e-7)
    assert late.value(fun.span()) == UNTIL - 1.0
    again = pickle.loads(pickle.dumps(late))
    assert again.value(work) == late.value(work)


@pytest.fixture(scope="module")
def cosine():
    """``phi = cos(3 t)``."""
    return assemble_row(wall=Fixed(), spring=Spring(c=9.0), a=Inertia(J=1.0, phi=1.0))


def test_a_closed_form_is_read_by_steps(cosine):
    run = lp.simulate(cosine, until=2.0, method="exact", rtol=1e-9)
    expected = np.sqrt(0.5 + np.sin(12.0) / 24.0)
    assert run.value(fun.rms("a.phi")) == pytest.approx(expected, rel=1e-7)


def test_formulas_with_kinks_are_read_to_the_tolerance(cosine):
    """For how long the angle is above 0.3 in a turn of ``2 pi / 3``."""
    phi = cosine.model.a.phi
    above = fun.integral(lp.ops.where(phi > 0.3, 1, 0))
    run = lp.simulate(cosine, until=2 * np.pi / 3, rtol=1e-9)
    assert run.value(above) == pytest.approx(2 * np.arccos(0.3) / 3, abs=1e-8)
    assert run.value(fun.mean(abs(phi))) == pytest.approx(2 / np.pi, abs=1e-8)


def test_formulas_with_kinks_are_read_in_runs_from_a_point(cosine):
    """The angle ``cos 3t`` from 1 s on, in which nested kinks begin on either side."""
    phi = cosine.model.a.phi
    t = np.linspace(1.0, 2.0, 1_000_001)
    y = np.cos(3 * t)
    nested = abs(abs(phi) - 0.8)
    wanted = np.trapezoid(np.abs(np.abs(y) - 0.8), t)
    point = lp.simulate(cosine, until=2.0, rtol=1e-10).point(1.0)
    late = lp.simulate(cosine, until=2.0, rtol=1e-10, start=point)
    above = fun.integral(lp.ops.where(phi > -0.3, 1, 0))
    assert late.value(fun.integral(nested)) == pytest.approx(wanted, abs=1e-8)
    assert late.value(above) == pytest.approx(2 - (2 * np.pi - np.arccos(-0.3)) / 3, abs=1e-8)
    own = {"phi": fun.integral(abs(phi))}
    ensemble = lp.ensemble(cosine, over={"a.J": [1.0]}, until=2.0, of=own, start=point, rtol=1e-10)
    expected = np.trapezoid(np.abs(y), t)
    assert ensemble["phi"][0] == pytest.approx(expected, abs=1e-8)
    found = lp.gradient(cosine, of=[own["phi"]], by=["a.J"], until=2.0, start=point, rtol=1e-10)
    assert found.values == pytest.approx(expected, abs=1e-8)


def test_what_a_run_does_not_have_is_named(bouncing):
    run = lp.simulate(bouncing, until=0.5)
    with pytest.raises(OptionError, match="this event of stop does not happen in this run"):
        run.value(fun.instant("stop"))
    with pytest.raises(OptionError, match=r"frequency\(0\).* is no functional of a run"):
        run.value(fun.frequency(0))
    with pytest.raises(OptionError, match=r"the runs last from 0 to 0\.5 s"):
        run.value(fun.at_time(0.7, "a.w"))


def test_the_mean_square_of_almost_nothing_is_not_negative():
    """Stages with negative weights may leave an integral of a square a hair below zero."""
    found = np.array([[-1e-18, 0.0], [4.0, 0.0]])
    assert Place(0, is_positive=True).value(found).tolist() == [0.0, 4.0]
    assert fun.rms("a.w").readings[0].is_of_square
    assert not fun.integral("a.w", "spring.tau").readings[0].is_of_square


class Decay(lp.Component):
    """A quantity that decays."""

    a: lp.Param = lp.param("1/s", "rate", 0.5)
    x: lp.Var = lp.var("1", "what decays")

    def equations(self):
        yield lp.der(self.x) == -self.a * self.x


def test_a_parameter_alone_is_a_functional():
    """Its value and derivative are it and 1, and a normal one is above 2 at 1 - Phi(2)."""
    system = lp.assemble(Decay())
    own = fun.final(system.model.a)
    assert lp.simulate(system, until=0.1).value(own) == 0.5
    assert lp.gradient(system, of=[own], by=["a"], until=0.1).derivatives == pytest.approx(1.0)
    assert lp.ensemble(system, over={"a": [1.0, 2.0]}, of=[own], until=0.1).values.ravel() == (
        pytest.approx([1.0, 2.0])
    )
    found = lp.reliability(system, fun.final("a"), over={"a": lp.normal(0, 1)}, until=0.1, above=2)
    assert found.probability == pytest.approx(0.5 * math.erfc(2 / math.sqrt(2)), rel=1e-9)
    found = lp.optimise(system, vary={"a": (-1.0, 3.0)}, minimise=own, until=0.1)
    assert found.parameters["a"] == pytest.approx(-1.0)
