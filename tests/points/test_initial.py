"""Initial equations, and the search for a start that meets them."""

import numpy as np
import pytest
from drives_at_points import Steady
from rows import assemble_row, assemble_rows, in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, Torque, translation
from lumped.errors import OptionError, StartError


def hanging(**changes):
    """A mass on a spring with its weight; it starts at rest."""
    return in_a_row(
        wall=translation.Fixed(),
        spring=translation.Spring(c=2e3),
        body=translation.Mass(m=4.0),
        weight=translation.Force(f=-4.0 * 9.81),
        **changes,
    )


def test_a_hanging_mass_starts_where_its_weight_and_its_spring_balance():
    model = hanging(initial_equations=lambda m: [lp.der(m.body.v) == 0, lp.der(m.body.s) == 0])
    system = lp.assemble(model)
    point = lp.start_point(system)
    assert point["body.s"] == pytest.approx(-4.0 * 9.81 / 2e3, rel=1e-12)
    run = lp.simulate(system, until=1.0, grid=5)
    assert run["body.s"] == pytest.approx(np.full(6, -4.0 * 9.81 / 2e3), rel=1e-6)
    run = lp.simulate(system, until=1.0, grid=5, parameters={"spring.c": 1e3})
    assert run["body.s"] == pytest.approx(np.full(6, -4.0 * 9.81 / 1e3), rel=1e-6)


def test_an_initial_equation_of_a_class_holds_for_all_its_instances():
    # a chain held on the left, with a torque on each body: spring i carries all torques beyond it
    torques = [3.0, -1.0, 5.0]
    model = lp.compose(
        wall=Fixed(),
        spring=[Spring(c=100.0 * (i + 1)) for i in range(3)],
        body=[Steady(J=1.0 + i) for i in range(3)],
        drive=[Torque(tau=t) for t in torques],
        connections=lambda m: [
            *lp.chain(m.wall, *(p for pair in zip(m.spring, m.body, strict=True) for p in pair)),
            *(lp.connect(d.flange, b.flange_b) for d, b in zip(m.drive, m.body, strict=True)),
        ],
    )
    point = lp.start_point(lp.assemble(model))
    for i in range(3):
        expected = sum(torques[i:]) / (100.0 * (i + 1))
        assert point[f"spring[{i}].phi_rel"] == pytest.approx(expected, rel=1e-12)


def test_an_initial_equation_relates_quantities_of_different_parts():
    model = in_a_row(
        a=Inertia(J=1.0, w=7.0),
        shaft=Spring(c=50.0),
        b=Inertia(J=1.0),
        initial_equations=lambda m: [m.b.w == 2 * m.a.w + 1, m.shaft.tau == m.shaft.c * 0.3],
    )
    point = lp.start_point(lp.assemble(model))
    assert [point["b.w"], point["shaft.phi_rel"]] == pytest.approx([15.0, 0.3], rel=1e-13)
    assert point["a.w"] == 7.0


def test_an_initial_equation_may_ask_for_derivatives_that_the_equations_do_not_have():
    # tau = c phi_rel: der(tau) = c (w_b - w_a); its second derivative is c (a_b - a_a)
    model = in_a_row(
        a=Inertia(J=2.0, w=1.0),
        shaft=Spring(c=50.0),
        b=Inertia(J=0.5),
        initial_equations=lambda m: [
            lp.der(m.shaft.tau) == 20.0,
            lp.der(lp.der(lp.der(m.b.w))) == 600.0,
        ],
    )
    point = lp.start_point(lp.assemble(model))
    # der^3(w_b) = -der^2(tau) / J_b = -c (a_b - a_a) / J_b, with a_b - a_a = -tau (1/J_a + 1/J_b)
    expected = 600.0 * 0.5 / (50.0 * (1 / 2.0 + 1 / 0.5))
    assert point["b.w"] == pytest.approx(1.0 + 20.0 / 50.0, rel=1e-13)
    assert point["shaft.tau"] == pytest.approx(expected, rel=1e-12)


def test_an_initial_equation_determines_a_parameter():
    model = hanging(initial_equations=lambda m: [m.body.s == -0.1, lp.der(m.body.v) == 0])
    point = lp.start_point(lp.assemble(model), free=["spring.c"])
    assert point.parameters["spring.c"] == pytest.approx(4.0 * 9.81 / 0.1, rel=1e-12)


def test_a_stiffness_is_found_although_its_spring_is_not_twisted_at_the_first_guess():
    model = in_a_row(
        a=Inertia(J=1.0, phi=0.0), shaft=Spring(c=1e5, tau=60.0), b=Inertia(J=1.0, phi=0.3)
    )
    system = lp.assemble(model, keep=["a.phi"])
    point = lp.start_point(system, free=["shaft.c"])
    assert point.parameters["shaft.c"] == pytest.approx(60.0 / 0.3, rel=1e-12)
    assert point["b.phi"] == pytest.approx(0.3, rel=1e-12)
    model = in_a_row(a=Inertia(J=1.0), shaft=Spring(c=1e5, tau=60.0), b=Inertia(J=1.0))
    with pytest.raises(StartError, match=r"shaft\.c is not determined"):  # without a twist
        lp.start_point(lp.assemble(model), free=["shaft.c"])


class Fading(lp.Component):
    """Law that hardly reacts where the search begins: x + 30 tanh(40 (x - 1)) = y."""

    x: lp.Var = lp.var("1", "state")
    y: lp.Var = lp.var("1", "value")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y == self.x + 30 * lp.ops.tanh(40 * (self.x - 1))


def test_a_target_is_approached_step_by_step_where_newtons_method_alone_runs_away():
    from scipy.optimize import brentq

    system = lp.assemble(lp.compose(law=Fading()))
    point = lp.start_point(system, start={"law.y": 3.0})
    expected = brentq(lambda x: x + 30 * np.tanh(40 * (x - 1)) - 3.0, 0.0, 2.0, xtol=1e-14)
    assert point["law.x"] == pytest.approx(expected, rel=1e-9)
    # Newton's method as such: from zero it swings between the flat parts
    x = 0.0
    for _ in range(50):
        slope = 1 + 1200 / np.cosh(np.clip(40 * (x - 1), -300, 300)) ** 2
        x -= (x + 30 * np.tanh(40 * (x - 1)) - 3.0) / slope
    assert abs(x - expected) > 1.0


def test_of_many_initial_equations_only_those_in_conflict_are_named():
    model = lp.compose(
        body=[Inertia(J=1.0 + i) for i in range(5)],
        load=[Torque(tau=1.0) for _ in range(5)],
        connections=lambda m: [
            lp.connect(load.flange, body.flange_a)
            for load, body in zip(m.load, m.body, strict=True)
        ],
        initial_equations=lambda m: [
            *(b.w == 3.0 for b in m.body),
            m.body[1].w + m.body[3].w == 7.0,
        ],
    )
    with pytest.raises(StartError) as caught:
        lp.start_point(lp.assemble(model))
    text = str(caught.value)
    named = [i for i in range(5) if f"body[{i}].w" in text]
    assert named == [1, 3]


def test_an_initial_equation_takes_the_side_that_holds_at_the_start():
    held = lp.ops.where(lp.time >= 1, 1.0, 0.25) + abs(lp.time - 0.5)
    system = lp.assemble(hanging(initial_equations=lambda m: [m.body.s == held]))
    assert lp.start_point(system)["body.s"] == pytest.approx(0.75, abs=1e-14)


def test_a_thousand_initial_equations_of_one_class_are_lowered_once():
    count = 1000
    system = assemble_rows(
        "wall spring/body drive",
        wall=Fixed(),
        spring=[Spring(c=1e3) for _ in range(count)],
        body=[Steady(J=1.0) for _ in range(count)],
        drive=Torque(tau=2.0),
    )
    assert [len(group.nodes) for group in system.structure.flat.initial] == [count]
    point = lp.start_point(system)
    twists = [point[f"spring[{i}].phi_rel"] for i in (0, 500, 999)]
    assert twists == pytest.approx([2e-3] * 3, rel=1e-9)


@pytest.mark.parametrize("start", ["equilibrium", [1.0, 2.0], 3.0])
def test_start_values_without_names_are_refused_with_the_way_to_an_equilibrium(start):
    system = assemble_row(wall=Fixed(), spring=Spring(c=1.0), body=Inertia(J=1.0))
    with pytest.raises(
        OptionError, match=r"start = .*names as keys.*an operating point from lumped\.equilibrium"
    ):
        lp.simulate(system, until=1.0, start=start)
