"""Every mistake gets an error of lumped that names the place and says what to do."""

import numpy as np
import pytest
from refusals import message
from rows import in_rows

import lumped as lp
from lumped.components import Gain, Inertia
from lumped.errors import (
    OptionError,
    ParameterError,
    SingularModelError,
    SolverError,
    UnitError,
    UnknownNameError,
)


def test_a_bound_parameter_out_of_range_is_named():
    class Rig(lp.Component):
        """Rotor with bound inertia: J = 1 - x."""

        x: lp.Param = lp.param("1", "share", 3.0)
        rotor: Inertia = Inertia(J=1 - x)

    system = lp.assemble(Rig(x=0.5))
    text = message(lambda: lp.simulate(system, until=1, parameters={"x": 2.0}), ParameterError)
    assert "rotor.J = -1" in text


def test_unknown_names_get_the_nearest_ones(two_mass):
    system = lp.assemble(two_mass)
    calls = {
        "shaft.phi_rel": lambda: lp.linearise(system, outputs=["shaft.phirel"]),
        "a.phi": lambda: lp.modes(system).shape("a.ph"),
    }
    for expected, call in calls.items():
        assert expected in message(call, UnknownNameError)


def test_what_was_left_out_is_said_when_asked_for(two_mass):
    system = lp.assemble(two_mass, of=["a.w"])
    text = message(lambda: lp.linearise(system, outputs=["b.phi"]), UnknownNameError)
    assert "left out" in text
    assert "keep=['b.phi']" in text


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        ({"until": 1.0, "atol": -1.0}, "atol"),
        ({"until": 1.0, "method": "rk4"}, "explicit"),
        ({"until": 1.0, "grid": 0}, "interval"),
        ({"until": 1.0, "grid": [0.5, 0.2]}, "decrease"),
        ({"until": 1.0, "grid": [0.5, 2.0]}, "leave 0 to 1 s"),
        ({"until": 1.49813, "grid": [0.0, 1.4981301]}, "from 0 to 1.4981301 s leave 0 to 1.49813"),
        ({"until": 1.0, "grid": [-1e-9, 1.0]}, "times from -1e-09 to 1 s leave 0 to 1 s"),
        ({"until": 1.0, "grid": [0.0, np.nan, 1.0]}, "grid = [0.0, nan, 1.0]"),
        ({"until": 1.0, "grid": [np.nan, np.nan]}, "grid = [nan, nan]"),
        ({"until": 1.0, "grid": [0.0, np.inf]}, "finite numbers"),
        ({"until": 1.0, "grid": 10**13}, "grid = 10000000000000: the number of output intervals"),
        ({"until": 1.0, "grid": True}, "grid = True"),
        ({"until": 1.0, "grid": 10.0}, "grid = 10.0: a whole number"),
        ({"until": 1.0, "grid": [[0.0, 1.0]]}, "grid = [[0.0, 1.0]]"),
        ({"until": 1.0, "grid": [0.0, None]}, "grid = [0.0, None]"),
        ({"until": 1.0, "grid": object()}, "grid = "),
        ({"until": 1.0, "grid": "10"}, "grid = "),
        ({"until": 1.0, "method": 5}, "method"),
        ({"until": 1.0, "max_steps": 0}, "max_steps"),
        ({"until": 1.0, "max_steps": 1.5}, "max_steps"),
        ({"until": 1.0, "certify": "yes"}, "certify"),
        ({"until": 1.0, "parameters": 5}, "parameters"),
        ({"until": 1.0, "parameters": [("a.J", 1.0)]}, "parameters"),
        ({"until": 1.0, "parameters": {3: 1.0}}, "parameters"),
        ({"until": 1.0, "start": "a.w"}, "start"),
        ({"until": [1.0, 2.0]}, "until = [1.0, 2.0]: a finite number or a text"),
        ({"until": None}, "until = None: a finite number or a text"),
    ],
)
def test_options_that_make_no_sense_are_refused(two_mass, options, hint):
    assert hint in message(lambda: lp.simulate(lp.assemble(two_mass), **options), OptionError)


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        ({"until": "500 mm"}, "until = '500 mm': the unit must be of the kind s"),
        ({"until": "500ms"}, "until = '500ms': a number in s, or a number, a space and a unit"),
        ({"until": 1.0, "grid": ["0 s", "1 m"]}, "grid: time = '1 m'"),
    ],
)
def test_texts_that_are_no_times_are_refused(two_mass, options, hint):
    assert hint in message(lambda: lp.simulate(lp.assemble(two_mass), **options), UnitError)


def test_times_may_have_units(two_mass):
    """Body a swings as ``w_a = 2 + cos(sqrt(c (1/J_a + 1/J_b)) t)``."""
    system = lp.assemble(two_mass, keep=["a.phi"])
    given = {"start": {"a.w": 3.0}}
    run = lp.simulate(system, until=0.5, grid=[0.0, 0.1, 0.5], **given)
    same = lp.simulate(system, until="500 ms", grid=["0 s", "100 ms", "0.5 s"], **given)
    assert (same["a.w"] == run["a.w"]).all()
    assert same.t == pytest.approx(run.t, rel=1e-15)
    assert same.point("100 ms")["a.w"] == run.point(0.1)["a.w"]
    omega = np.sqrt(300.0 * 1.5)
    slope = -np.sin(0.5 * omega) * 0.5 * omega / (2 * 300.0)
    to, of = ["shaft.c"], lp.functionals.final("a.w")
    moved = lp.sensitivity(system, of=["a.w"], by=to, until="500 ms", rtol=1e-9, **given)
    assert moved["a.w", "shaft.c"][-1] == pytest.approx(slope, rel=1e-6)
    slopes = lp.gradient(system, of=[of], by=to, until="500 ms", **given)
    assert slopes.derivatives[0, 0] == pytest.approx(slope, rel=1e-6)
    tried = lp.simulation.work_precision(
        system, until="500 ms", tolerances=[1e-4], methods=["explicit"], **given
    )
    assert tried.rows[0].outcome == "ok"


def test_output_times_that_miss_the_end_by_a_rounding_are_meant_to_be_it(two_mass):
    system, until = lp.assemble(two_mass), 1.49813
    for off in (np.nextafter(until, 2.0), until * (1 + 5e-15)):
        run = lp.simulate(system, until=until, grid=[-1e-17, 0.5, off])
        assert run.t.tolist() == [0.0, 0.5, until]


class Explodes(lp.Component):
    """Runs to infinity at t = 1: der(x) = x**2, x(0) = 1."""

    x: lp.Var = lp.var("1", "growing", 1.0)

    def equations(self):
        yield lp.der(self.x) == self.x**2


class Roots(lp.Component):
    """Leaves the range of a root at t = 1: der(x) = -1, y = sqrt(x)."""

    x: lp.Var = lp.var("1", "falling", 1.0)
    y: lp.Var = lp.var("1", "root of it integrated")

    def equations(self):
        yield lp.der(self.x) == -1
        yield lp.der(self.y) == lp.ops.sqrt(self.x)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("part", [Explodes(), Roots()])
def test_a_failed_run_keeps_what_it_computed(part, method):
    system = lp.assemble(lp.compose(part=part))
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=2.0, method=method, grid=None)
    print(f"\n{caught.value}")
    partial = caught.value.partial
    early = partial.t < 0.9
    expected = 1 / (1 - partial.t) if isinstance(part, Explodes) else 1 - partial.t
    error = np.abs(partial["part.x"] / expected - 1)[early].max()
    print(f"reached t = {partial.t[-1]:.9f} of 1, relative error up to 0.9 s {error:.2e}")
    assert partial.t[-1] == pytest.approx(1.0, abs=1e-5)
    assert error < 1e-5
    assert "part." in str(caught.value)


def test_a_run_that_takes_too_many_steps_says_so(two_mass):
    system = lp.assemble(two_mass)
    with pytest.raises(SolverError, match="max_steps = 300") as caught:
        lp.simulate(system, until=1e4, start={"a.w": 1.0}, max_steps=300, grid=None)
    assert caught.value.partial.t[-1] > 0


def test_a_loop_of_signals_of_gain_one_is_told_as_such():
    parts = {"first": Gain(k=0.5), "second": Gain(k=2.0)}
    rig = in_rows("first.y second.u", "second.y first.u", **parts)
    text = message(lambda: lp.start_point(lp.assemble(rig))["first.y"], SingularModelError)
    assert "first, second form a loop of signals whose gain is 1" in text
    assert "Filter" in text
    other = lp.assemble(rig.with_({"first.k": 3.0}))
    assert lp.start_point(other)["first.y"] == 0.0
