"""Single shooting over whole runs: optima in closed form, objectives without effect."""

import numpy as np
import pytest
import scipy
from rows import in_a_row, in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, Damper, Fixed, Inertia, Spring, SpringDamper, Torque
from lumped.errors import OptimisationError, OptionError, UnknownNameError

J, W = 2.0, 5.0
STOPS = fun.instant("brake", "stuck")


def braked(f_max=20.0):
    """A body that dry friction stops after J W / f_max."""
    model = in_a_row(
        body=Inertia(J=J, w=W), brake=Brake(f_max=f_max, u=1.0, characteristic=((0.0, 1.0),))
    )
    return lp.assemble(model, keep=["body.phi"])


def best_brake(minimise, **options):
    """The best friction of the braked body."""
    given = {"vary": {"brake.f_max": (8.0, 300.0)}, "until": 2.0} | options
    return lp.optimise(braked(), minimise=minimise, **given)


def test_a_body_that_stops_turns_as_little_as_the_friction_allows():
    """It turns J W^2 / (2 f); a price of friction p makes f = W sqrt(J / 2 p) best."""
    price = 0.002
    found = best_brake({fun.final("body.phi"): 1.0, "brake.f_max": price}, rtol=1e-10)
    expected = W * np.sqrt(J / (2 * price))
    assert found.parameters["brake.f_max"] == pytest.approx(expected, rel=1e-4)
    assert found.objective == pytest.approx(W * np.sqrt(2 * J * price), rel=1e-9)
    assert len([e for e in found.run.events if e.component == "brake"]) == 1
    assert found.solution.residual < 1e-4
    text = repr(found)
    print(text)
    assert "evaluations" in text
    assert "condition" in text


def test_the_instant_of_an_event_is_bounded():
    """It stops at J W / f, not before 0.4 s."""
    found = best_brake(fun.final("body.phi"), subject_to=STOPS >= 0.4)
    assert found.parameters["brake.f_max"] == pytest.approx(J * W / 0.4, rel=1e-7)
    assert found.active == ("instant(brake, stuck, 0)",)


def test_a_stiff_run_finds_the_best_damping_of_a_chain():
    """Root mean squares of a linear drive: against a search with Lyapunov's equation."""
    model = in_a_row(
        wall=Fixed(),
        stiff=SpringDamper(c=1e7, d=200.0),
        a=Inertia(J=0.01),
        soft=Spring(c=50.0),
        b=Inertia(J=1.0, w=3.0),
        oil=Damper(d=0.5),
        ground=Fixed(),
    )
    found = lp.optimise(
        lp.assemble(model),
        vary={"oil.d": (0.1, 20.0)},
        minimise={fun.rms("b.w"): 1.0, fun.rms("oil.tau"): 0.4},
        until=2.0,
        rtol=1e-10,
    )
    assert "implicit" in found.run.statistics.method

    def cost(d):
        # states: angle of a, twist of the soft shaft, speeds; with the integral of w_b^2 beside
        A = np.zeros((4, 4))
        A[0, 2], A[1, 3], A[1, 2] = 1.0, 1.0, -1.0
        A[2] = np.array([-1e7, 50.0, -200.0, 0.0]) / 0.01
        A[3] = np.array([0.0, -50.0, 0.0, -d])
        x = np.array([0.0, 0.0, 0.0, 3.0])
        # Lyapunov: integral of x x' from 0 to T
        last = scipy.linalg.expm(2.0 * A) @ x
        P = scipy.linalg.solve_continuous_lyapunov(A, np.outer(last, last) - np.outer(x, x))
        rms = np.sqrt(P[3, 3] / 2.0)
        return rms * (1 + 0.4 * d)

    best = scipy.optimize.minimize_scalar(
        cost, bounds=(0.1, 20.0), method="bounded", options={"xatol": 1e-9}
    )
    print(found, best.x)
    assert 0.2 < best.x < 19
    assert found.parameters["oil.d"] == pytest.approx(best.x, rel=1e-4)
    assert found.objective == pytest.approx(best.fun, rel=1e-8)


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"until": None}, OptionError, "give until="),
        ({"minimise": fun.frequency(0)}, OptionError, "no functional of a run"),
        ({"minimise": fun.final("body.v")}, UnknownNameError, r"body\.w"),
        ({"vary": {"brake.f_max": (300.0, 8.0)}}, OptionError, "bounds of"),
        ({"subject_to": [STOPS >= 0.4, STOPS <= 0.3]}, OptionError, "low at most high"),
        (
            {"subject_to": fun.final("body.phi") <= 0.01},
            OptimisationError,
            r"Worst violated: final\(body.phi\)",
        ),
    ],
)
def test_bad_input_is_named(options, error, text):
    with pytest.raises(error, match=text):
        best_brake(**{"minimise": fun.final("body.phi")} | options)


def two_bodies():
    return in_rows(
        "push a shaft wall",
        "b oil ground",
        a=Inertia(J=1.0),
        push=Torque(tau=1.0),
        shaft=Spring(c=100.0),
        wall=Fixed(),
        b=Inertia(J=3.0, w=1.0),
        oil=Damper(d=0.5),
        ground=Fixed(),
    )


@pytest.mark.parametrize("way", ["run", "modes", "system"])
def test_an_objective_that_does_not_depend_on_what_varies_is_named(way):
    """Body b does not feel a, though bounds do."""
    system = lp.assemble(two_bodies())
    options = {"vary": {"shaft.c": (50.0, 200.0)}, "minimise": fun.rms("b.w")}
    subject = system
    if way == "run":
        subject = lp.simulate(system, until=1.0)
        options |= {"subject_to": fun.peak("shaft.tau") <= 3.0}
    elif way == "modes":
        subject = lp.modes(system)
        options |= {"minimise": "oil.d", "subject_to": fun.frequency(0) >= 1.2}
    else:
        options |= {"until": 1.0}
    with pytest.raises(OptionError, match=r"does not depend on shaft\.c"):
        lp.optimise(subject, **options)


def test_the_units_of_instants_and_products_are_printed():
    loss = fun.integral("brake.tau", "body.w")
    found = best_brake(STOPS, subject_to=[loss >= -1e3, loss <= 1e3])
    rows = [line.split() for line in repr(found).splitlines()]
    assert ["instant(brake,", "stuck,", "0)", "0.0333333333", "s"] in rows
    assert found.active == ("brake.f_max at its upper bound",)
