"""Searches end at published optima, and say so only there."""

import pytest
from published_optima import PUBLISHED

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptimisationError
from lumped.ops import exp

SUCCESS = "terminated successfully"


class Number(lp.Component):
    """A parameter, and a state that stays zero."""

    value: lp.Param = lp.param("1", "value")
    y: lp.Var = lp.var("1", "y", start=0.0)

    def equations(self):
        yield lp.der(self.y) == 0 * self.value


def search(goal, start, low=None, high=None, rows=lambda *x: (), **options):
    """What `optimise` finds for functions of parameters alone."""
    names = [f"x{i}" for i in range(len(start))]
    parts = {n: Number(value=float(v)) for n, v in zip(names, start, strict=True)}
    system = lp.assemble(lp.compose(**parts, connections=lambda m: ()))
    x = [getattr(system.model, n).value for n in names]
    open_ = (None,) * len(start)
    bounds = zip(low or open_, high or open_, strict=True)
    return lp.optimise(
        system,
        vary={f"{n}.value": b for n, b in zip(names, bounds, strict=True)},
        minimise=fun.final(goal(*x)),
        subject_to=[fun.final(row) >= 0 for row in rows(*x)],
        until=0.01,
        **options,
    )


@pytest.mark.parametrize("number", PUBLISHED)
def test_a_published_optimum_is_found(number):
    """The least value is that of the book, and is told as an optimum."""
    each = PUBLISHED[number]
    found = search(each.goal, each.start, each.low, each.high, each.rows)
    print(found)
    assert SUCCESS in found.solution.status
    assert found.objective == pytest.approx(each.least, rel=1e-6, abs=1e-6)
    assert found.solution.residual < 1e-4


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "goal",
    [lambda a, b: a + b, lambda a, b: -(a**2) - b**2, lambda a, b: exp(-a) * b**3],
)
def test_a_search_without_bound_is_told_in_words(goal):
    with pytest.raises(OptimisationError, match=r"still fell with .*give bounds in `vary`"):
        search(goal, (0.5, -2.0))


def test_a_fit_begun_far_away_finds_what_made_the_curve():
    """Squares of deviations from a run of known parameters are least at these, and zero."""
    drive = lp.assemble(
        lp.compose(
            t=Torque(tau=lp.ops.where(lp.time < 0.5, 100.0, 0.0)),
            a=Inertia(J=2.0),
            k=SpringDamper(c=2e3, d=5.0),
            b=Inertia(J=1.0),
            br=Damper(d=1.0),
            g=Fixed(),
            connections=lambda m: lp.chain(m.t, m.a, m.k, m.b, m.br, m.g),
        )
    )
    w = drive.model.a.w
    instants = (0.1, 0.2, 0.3, 0.4)
    made = [float(lp.simulate(drive, until=t, rtol=1e-11)["a.w"][-1]) for t in instants]
    found = lp.optimise(
        drive,
        vary={"a.J": (0.02, 50.0), "k.c": (100.0, 5e4), "k.d": (0.1, 100.0)},
        minimise={fun.at_time(t, (w - v) ** 2): 1.0 for t, v in zip(instants, made, strict=True)},
        until=1.0,
        parameters={"a.J": 0.05, "k.c": 300.0, "k.d": 5.0},
    )
    assert SUCCESS in found.solution.status
    assert found.objective < 1e-9
    for name, value, span in (("a.J", 2.0, 50.0), ("k.c", 2e3, 5e4), ("k.d", 5.0, 100.0)):
        assert found.parameters[name] == pytest.approx(value, abs=2e-6 * span)
