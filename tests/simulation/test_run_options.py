"""Each analysis that makes runs takes all their options, which change what they should."""

import inspect

import numpy as np
import pytest
from public_names import FUNCTIONS
from rows import assemble_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, Spring, Torque
from lumped.errors import LumpedError, OptionError

W = fun.final("body.w")
J = {"body.J": [1.0]}
NEAR = {"body.J": (1 - 1e-12, 1 + 1e-12)}
SCATTERED = {"body.J": lp.normal(1.0, 1e-12)}


class Pushed(lp.Component):
    """``w(t) - w(begin) = k (t^2 - begin^2) / (2 J)``."""

    k: lp.Param = lp.param("N.m/s", "rise of the torque", default=2.0)
    push: Torque = Torque(tau=k * lp.time)
    body: Inertia = Inertia(J=1.0, w=3.0)

    def connections(self):
        yield lp.connect(self.push.flange, self.body.flange_a)


def swinging():
    """``w = cos(10 t)``."""
    return assemble_row(wall=Fixed(), shaft=Spring(c=100.0), body=Inertia(J=1.0, w=1.0))


def sampled(system, function, **options):
    """Instants of a fit to the closed form of `Pushed`; the inertia may hardly differ from it."""
    until = options.pop("until")
    t = np.linspace(until - 0.5, until, 6)
    return function(system, vary=NEAR, t=t, measured={"body.w": t**2}, **options)


def swept(system, **options):
    """A sweep, with an error in place of a run that is set apart."""
    of = {"w": lambda run: run["body.w"][-1]}
    found = lp.sweep(system, over=J, of=of, workers=1, **options)
    if found.failures:
        raise LumpedError(found.failures[0])
    return found.values[0, 0]


def in_scene(system, **options):
    """A scene at one point, in the same way."""
    scene = lp.tolerances.scene_of(system, over=SCATTERED, of=[W], **options)
    found = scene.values(np.array([[1.0]]))[0, 0]
    if scene.failures:
        raise LumpedError(scene.failures[0])
    return found


# speed at the end, as each finds it
MADE = {
    "simulate": lambda s, **o: lp.simulate(s, **o)["body.w"][-1],
    "ensemble": lambda s, **o: lp.ensemble(s, over=J, of=[W], **o).values[0, 0],
    "sweep": swept,
    "scene_of": in_scene,
    "scatter": lambda s, **o: lp.scatter(s, over=SCATTERED, of=W, runs=20, **o)[str(W)].mean,
}
FOLLOWED = {
    "gradient": lambda s, **o: lp.gradient(s, of=[W], by=["body.J"], **o).values[0],
    "sensitivity": lambda s, **o: lp.sensitivity(s, of=[W], by=["body.J"], **o).values[0],
    "gradient_ensemble": lambda s, **o: lp.gradients.gradient_ensemble(
        s, over=J, of=[W], **o
    ).values[0, 0],
    "value_and_gradient": lambda s, **o: lp.gradients.value_and_gradient(
        s, of=W, by=["body.J"], **o
    )(np.ones(1))[0],
    "optimise": lambda s, **o: lp.optimise(s, vary=NEAR, minimise=W, **o).values[W],
    "identify": lambda s, **o: sampled(s, lp.identify, **o).run["body.w"][-1],
}
OTHERS = {
    "inverse": "hands them to `simulate`",
    "pareto": "to the searches of `optimise`",
    "reliability": "to `scene_of`",
    "sobol_indices": "to `scene_of`",
    "to_jax": "to the function of `value_and_gradient`",
    "work_precision": "finds errors only",
}
EACH = [*MADE.items(), *FOLLOWED.items()]


@pytest.fixture(scope="module")
def pushed():
    return lp.assemble(Pushed())


@pytest.fixture(scope="module")
def point(pushed):
    """At 1 s the speed is 4 rad/s."""
    return lp.simulate(pushed, until=1.0, grid=1).point(1.0)


def each(analyses=EACH):
    return pytest.mark.parametrize("made", [f for _, f in analyses], ids=[n for n, _ in analyses])


def test_the_tables_have_all_that_make_runs():
    found = {n for n, f in FUNCTIONS.items() if "max_steps" in inspect.signature(f).parameters}
    assert found == {*MADE, *FOLLOWED, *OTHERS}


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, 3.0 + 4.0),
        ({"begin": 1.0}, 3.0 + 3.0),
        ({"parameters": {"k": 4.0}}, 3.0 + 8.0),
        ({"start": {"body.w": 5.0}}, 5.0 + 4.0),
        ({"start": {"body.w": 4.0}, "begin": "1000 ms", "parameters": {"k": 4.0}}, 4.0 + 6.0),
        ({"method": "implicit"}, 3.0 + 4.0),
    ],
)
@each()
def test_an_option_changes_what_it_should(made, pushed, options, expected):
    assert made(pushed, until=2.0, **options) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "expected"),
    [({}, 4.0 + 3.0), ({"parameters": {"k": 4.0}}, 4.0 + 6.0), ({"begin": 0.5}, 4.0 + 3.75)],
)
@each()
def test_a_run_goes_on_from_a_point(made, pushed, point, options, expected):
    assert made(pushed, until=2.0, start=point, **options) == pytest.approx(expected, rel=1e-9)


@each([*MADE.items()])
def test_start_values_determine_a_free_parameter(made, pushed):
    """``k t / J == 6`` at 1 s."""
    given = {"begin": 1.0, "until": 2.0, "start": {"body.a": 6.0}, "free": ["k"]}
    assert made(pushed, **given) == pytest.approx(3.0 + 9.0, rel=1e-9)


@pytest.mark.parametrize("options", [{"free": ["k"]}, {"method": "taylor"}, {"method": "exact"}])
@each([*FOLLOWED.items()])
def test_derivatives_refuse_what_they_do_not_follow(made, pushed, options):
    with pytest.raises(OptionError, match=r"derivatives|the closed form is for single runs"):
        made(pushed, until=2.0, **options)


@each()
def test_the_absolute_tolerance_counts(made):
    system, expected = swinging(), np.cos(20.0)
    loose, tight = (
        abs(made(system, until=2.0, atol=atol, method="explicit") - expected)
        for atol in (1.0, 1e-12)
    )
    assert tight < 1e-5
    assert loose > 10 * tight


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"max_steps": 1}, "max_steps = 1"),
        ({"max_steps": 0}, "at least one step"),
        ({"atol": -1.0}, "absolute tolerance must be positive"),
        ({"begin": 3.0}, "after the begin, 3 s"),
        ({"method": "fast"}, "method = 'fast'"),
    ],
)
@each()
def test_a_limit_that_is_passed_or_makes_no_sense_is_named(made, options, text):
    system = swinging()
    with pytest.raises(LumpedError, match=text):
        made(system, **({"until": 2.0, "method": "explicit"} | options))


@each()
def test_a_point_of_another_system_is_refused(made, pushed):
    other = lp.start_point(swinging())
    with pytest.raises(OptionError, match="belongs to another system"):
        made(pushed, until=2.0, start=other)
