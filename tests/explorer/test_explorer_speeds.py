"""Order responses and Campbell diagrams that the page finds by itself, beside closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Spring, SpringDamper
from lumped.explorer.found_analyses import find_analyses
from lumped.explorer.study import Moment, Study
from lumped.explorer.views import views

J_A, J_B, C, D = 2.0, 1.0, 300.0, 2.0
BLADES, TORQUE, SPEED = 3, 5.0, 10.0


class Blades(lp.Component):
    """A torque that changes some times in each turn."""

    flange = lp.Flange(free=True)

    def equations(self):
        yield self.flange.tau == -TORQUE * lp.ops.cos(BLADES * self.flange.phi)


def bladed(**starts):
    """Blades on one of two inertias."""
    return in_a_row(
        blades=Blades(),
        a=Inertia(J=J_A, **starts),
        shaft=SpringDamper(c=C, d=D),
        b=Inertia(J=J_B, **starts),
    )


BLADED = bladed(w=SPEED)


class Stiffened(Spring):
    """A spring whose stiffness grows with the square of the speed."""

    k: lp.Param = lp.param("N.m.s2/rad3", "growth of the stiffness", 0.5)
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        first, _, *others = super().equations()
        yield first
        yield self.tau == (self.c + self.k * self.w**2) * self.phi_rel
        yield from others
        yield self.w == lp.der(self.flange_a.phi)


def found(model: lp.Component, *of: str) -> Study:
    """The study of a model with what is found for it."""
    plain = Study(lp.assemble(model, keep=["a.phi"]), of=of)
    return replace(plain, analyses=find_analyses(plain))


def test_torques_over_the_angle_show_their_order_response():
    """``tau = |j w d + c| T / (J_a |...|)`` of two inertias, twist ``-w^2 + (c + j w d) / J``."""
    study = found(BLADED, "a.w", "shaft.tau", "b.w")
    assert list(study.analyses) == ["Order response over a.phi", "Campbell diagram over a.phi"]
    c, reduced = 500.0, 1 / (1 / J_A + 1 / J_B)
    moment = Moment(study, {"shaft.c": c})
    response = moment.analysis("Order response over a.phi")
    assert response.orders.tolist() == [BLADES]
    assert response.of == ("shaft.tau",)
    assert response.speeds[[0, -1]] == pytest.approx([0.1 * SPEED, 1.1 * SPEED])
    w = BLADES * response.speeds
    expected = TORQUE / J_A * np.abs((c + 1j * w * D) / (-(w**2) + (c + 1j * w * D) / reduced))
    assert response.magnitude("shaft.tau", BLADES) == pytest.approx(expected, rel=1e-9)
    diagram = moment.analysis("Campbell diagram over a.phi")
    free = np.sqrt(c / reduced)  # `hertz` is that without damping: the size of the eigenvalue
    assert diagram.orders == (BLADES,)
    assert [each.speed for each in diagram.critical] == pytest.approx([free / BLADES], rel=1e-9)


def test_modes_that_depend_on_the_speed_show_a_campbell_diagram():
    a, b = (Inertia(J=J, w=SPEED) for J in (J_A, J_B))
    study = found(in_a_row(a=a, spring=Stiffened(c=C), b=b), "spring.tau")
    assert list(study.analyses) == ["Campbell diagram over a.phi"]
    (view,) = (view for view in views(study) if view.title.startswith("Campbell"))
    curves = view.compute(Moment(study, {"spring.k": 2.0}), ())["curves"]
    speeds = np.asarray(curves["x"][0]) * np.pi / 30
    assert speeds[[0, -1]] == pytest.approx([0.1 * SPEED, 1.1 * SPEED])
    expected = np.sqrt((C + 2.0 * speeds**2) * (1 / J_A + 1 / J_B)) / (2 * np.pi)
    assert curves["y"][0] == pytest.approx(expected, rel=1e-9)


def test_nothing_is_shown_where_speeds_matter_not_or_are_unknown(two_mass):
    assert found(two_mass, "a.w").analyses == {}
    assert found(bladed(), "a.w").analyses == {}
    assert found(BLADED).analyses == {}


def test_the_run_tells_the_speeds():
    """The greatest is that of the run: it slows down from another than that of the model."""
    system = lp.assemble(BLADED, keep=["a.phi"])
    start = {"a.w": 40.0, "b.w": 40.0}
    study = Study(system, until=0.01, start=start, of=("shaft.tau",))
    response = find_analyses(study)["Order response over a.phi"]({})
    top = np.abs(lp.simulate(system, until=0.01, start=start)["a.w"]).max()
    assert response.speeds[-1] == pytest.approx(1.1 * top, rel=1e-5)
