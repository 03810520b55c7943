"""Damage that is counted while a run goes on: closed forms, and the count of what was recorded."""

import numpy as np
import pytest
from ensemble_runs import CURVE, Alone, drive, ran, states
from rows import in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, SpringDamper
from lumped.errors import OptionError
from lumped.kernel import engine
from lumped.kernel.enclosures import turning
from lumped.life import SNCurve, goodman
from lumped.many_runs import watched
from lumped.models.reversing_mill.scenes import RATED, SHAFTS, pull_apart
from lumped.ops import log, sin, sqrt, where
from lumped.timeloop.cycle_count import count_cycles

SLOPE = 5.0
STEEP = SNCurve(1.0, 1e4, SLOPE, unit="1")


def share(range_):
    """Half a cycle of a range."""
    return 0.5e-4 * (0.5 * np.abs(range_)) ** SLOPE


# -- closed forms ----------------------------------------------------------------------------------


class Wave(lp.Component):
    """A sine of the time that no state feels, steps, and a state that makes long steps."""

    rate: lp.Param = lp.param("rad/s", "rate of the sine", 300.0)
    size: lp.Param = lp.param("1", "its amplitude", 1.5)
    high: lp.Param = lp.param("1", "second step", 4.0)
    x: lp.Var = lp.var("1", "slow state", 1.0, state="always")
    y: lp.Var = lp.var("1", "sine")
    z: lp.Var = lp.var("1", "steps")
    still: lp.Var = lp.var("1", "what never changes")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y == self.size * sin(self.rate * lp.time)
        later = where(lp.time >= 1.5, 1.0, where(lp.time >= 1.0, self.high, -3.0))
        yield self.z == where(lp.time >= 0.5, later, 2.0)
        yield self.still == 3 * self.size


@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
def test_sines_that_no_state_feels_and_steps(method):
    rates, sizes = np.array([3.0, 40.0, 300.0, 777.0]), np.array([1.5, 1.0, 0.7, 2.0])
    wave, until = Wave(), 2.0
    over = lp.ensembles.paired({"rate": rates, "size": sizes, "high": sizes + 3})
    of = {name: fun.damage(name, STEEP) for name in ("y", "z", "still")}
    of["three"] = fun.damage(3 * wave.y, STEEP)
    found = lp.ensemble(lp.assemble(wave), over=over, until=until, of=of, method=method)
    turns = np.floor(rates * until / np.pi + 0.5)
    last = sizes * (-1) ** (turns + 1)
    end = sizes * np.sin(rates * until)
    expected = share(sizes) + (turns - 1) * share(2 * sizes) + share(end - last)
    assert found["y"] == pytest.approx(expected, rel=1e-8, abs=0)
    np.testing.assert_allclose(found["three"], 3**SLOPE * expected, rtol=1e-8)
    steps = share(5) + share(sizes + 6) + share(sizes + 2)
    np.testing.assert_allclose(found["z"], steps, rtol=1e-12)
    assert (found["still"] == 0).all()


# -- what was recorded -----------------------------------------------------------------------------


def fed(monkeypatch, action):
    """All values that the count is given in a run of the loop as Python."""
    values, feed = [], turning.feed

    def note(count, k, value):
        values.append(float(value))
        feed(count, k, value)

    monkeypatch.setattr(turning, "feed", note)
    with engine.using("python"):
        action()
    return np.array(values)


@pytest.mark.parametrize(
    ("kind", "seed"), [("hybrid", 705), ("hybrid", 710), ("smooth", 2100), ("smooth", 2105)]
)
def test_the_count_of_a_run_is_that_of_its_turning_points(monkeypatch, kind, seed):
    system, until, varied, points = drive(kind, seed)
    name = states(system)[0]
    of = {"damage": fun.damage(name, CURVE)}
    found = ran(system, varied, points[:1], of, until).values[0, 0]
    recorded = fed(monkeypatch, lambda: ran(system, varied, points[:1], of, until, Alone))
    counted = count_cycles(recorded, CURVE.law())
    assert counted.damage == found > 0
    assert len(counted.turning) > 8


def test_spindles_of_the_reversing_mill(monkeypatch):
    system, start = lp.assemble(pull_apart()), dict.fromkeys(SHAFTS, RATED)
    curve, scale = SNCurve("50 MPa", 1e6, 5.0, "haibach"), 40e6 / float(RATED)
    rule = goodman("700 MPa")
    name, M_s = "upper.spindle.tau", system.parameters["M_s"]
    of = [fun.damage(name, curve, scale=scale, mean_stress=rule)]
    options = {"of": of, "start": start, "until": 0.4}

    def made(values, rtol=1e-6):
        return lp.ensemble(system, over={"M_s": values}, rtol=rtol, **options).values[:, 0]

    law = curve.law(rule, scale)
    recorded = fed(monkeypatch, lambda: made([M_s]))
    assert count_cycles(recorded, law).damage == made([M_s])[0]
    run = lp.simulate(system, until=0.4, start=start, grid=40001, rtol=1e-9)
    error = made([M_s], 1e-9)[0] / count_cycles(run[name], law).damage - 1
    turns = lp.life.turning_points(lp.simulate(system, until=0.4, start=start, rtol=1e-9), name)
    apart = made([M_s], 1e-9)[0] / count_cycles(turns, law).damage - 1
    assert abs(error) < 1e-5
    assert abs(apart) < 1e-7


# -- what goes wrong -------------------------------------------------------------------------------


def test_too_many_open_turning_points_are_told(monkeypatch):
    monkeypatch.setattr(watched, "_DEPTH", 8)
    model = in_a_row(wall=Fixed(), shaft=SpringDamper(c=100.0, d=0.1), body=Inertia(J=1.0, phi=1.0))
    system, of = lp.assemble(model), {"life": fun.damage("body.phi", STEEP)}
    for until, fails in ((2.0, False), (4.0, True)):
        found = lp.ensemble(system, over={"shaft.c": [100.0]}, until=until, of=of)
        assert np.isnan(found.values[0, 0]) == fails
    assert "life: not a number, or more than 8 turning points" in found.failures[0]


def test_a_load_that_is_no_number_somewhere_is_told():
    wave = Wave()
    of = {"root": fun.damage(sqrt(wave.y + 1.4), STEEP), "log": fun.damage(log(wave.x), STEEP)}
    found = lp.ensemble(lp.assemble(wave), over={"size": [1.3, 1.5]}, until=1.0, of=of)
    assert list(found.failures) == [1]
    assert "root: not a number" in found.failures[1]
    np.testing.assert_allclose(found["log"], share(1.0), rtol=1e-8)


def test_wrong_calls():
    with pytest.raises(OptionError, match=r"curve = 3: an S-N curve from lumped\.life"):
        fun.damage("body.phi", 3)
    with pytest.raises(OptionError, match=r"scale = -1 must be positive"):
        fun.damage("body.phi", STEEP, scale=-1.0)


def test_labels_tell_curves_apart():
    steep, flat = fun.damage("a.tau", STEEP), fun.damage("a.tau", SNCurve("60 MPa", 2e6, 5.0))
    assert str(steep) == "damage(a.tau, 10000 cycles at 1, slope 5)"
    scaled = fun.damage("a.tau", SNCurve("60 MPa", 2e6, 5.0), scale=2.0, mean_stress=goodman(7e8))
    rule = "Goodman, ultimate strength 7e+08 Pa"
    assert str(scaled) == f"damage(a.tau * 2, 2e+06 cycles at 6e+07, slope 5, {rule})"
    assert len({steep, flat, scaled, fun.damage("a.tau", STEEP)}) == 3
