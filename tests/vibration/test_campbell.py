"""Critical speeds against closed forms."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, SpringDamper
from lumped.errors import OptionError


def held(shaft):
    model = lp.compose(
        body=Inertia(J=2.0),
        shaft=shaft,
        wall=Fixed(),
        connections=lambda m: lp.chain(m.body, m.shaft, m.wall),
    )
    return lp.assemble(model)


def test_constant_frequencies_meet_orders_where_the_closed_form_says(two_mass):
    modes = lp.modes(lp.assemble(two_mass))
    w0 = np.sqrt(300.0 * 1.5)
    received = lp.vibration.critical_speeds(modes, [1, 2.5, 12])
    assert [c.order for c in received] == [12.0, 2.5, 1.0]
    assert [c.speed for c in received] == pytest.approx([w0 / 12, w0 / 2.5, w0], rel=1e-13)
    assert received[2].rpm == pytest.approx(w0 * 60 / (2 * np.pi), rel=1e-13)


def test_the_diagram_of_constant_frequencies_lists_those_within_its_speeds(two_mass):
    w0 = np.sqrt(300.0 * 1.5)
    received = lp.campbell(
        lp.assemble(two_mass), speeds=np.linspace(1.0, 15.0, 8), orders=[1, 2, 3]
    )
    assert [c.order for c in received.critical] == [3.0, 2.0]
    assert [c.speed for c in received.critical] == pytest.approx([w0 / 3, w0 / 2], rel=1e-12)
    assert "2 critical speeds" in repr(received)


def test_a_stiffness_that_grows_with_the_speed_moves_the_intersection():
    """Stiffness c0 + k w^2 and inertia J: order n meets at w^2 = c0 / (n^2 J - k)."""
    system = held(Spring(c=800.0))
    received = lp.campbell(
        system,
        speeds=np.linspace(0.0, 40.0, 11),
        orders=[0.5, 1.0, 3.0],
        at=lambda w: lp.start_point(system, parameters={"shaft.c": 800.0 + 0.9 * w**2}),
    )
    # order 1/2 never meets: the frequency runs away from it
    expected = [np.sqrt(800.0 / (n**2 * 2.0 - 0.9)) for n in (3.0, 1.0)]
    assert [c.order for c in received.critical] == [3.0, 1.0]
    assert [c.speed for c in received.critical] == pytest.approx(expected, rel=1e-12)
    for c in received.critical:
        assert c.hertz == pytest.approx(c.order * c.speed / (2 * np.pi), rel=1e-12)


def test_a_mode_that_ceases_to_oscillate_leaves_the_diagram():
    system = held(SpringDamper(c=800.0, d=0.0))
    received = lp.campbell(
        system,
        speeds=[0.0, 9.0, 30.0],
        orders=[1.0],
        at=lambda w: lp.start_point(
            system, parameters={"shaft.d": 8.0 * w}
        ),  # aperiodic from 80 on
    )
    assert np.isnan(received.hertz[2, 0])
    assert received.hertz[:2, 0] == pytest.approx([20.0 / (2 * np.pi)] * 2, rel=1e-12)
    assert received.critical == ()


def test_an_intersection_exactly_at_a_given_speed_is_listed_once():
    w0 = 20.0
    for speeds in ([0.0, w0, 50.0], [0.0, 10.0, w0], [w0, 50.0]):
        hertz = lp.modes(held(Spring(c=800.0))).hertz[0]
        assert hertz == w0 / (2 * np.pi)  # the numbers of this test are exact
        received = lp.campbell(held(Spring(c=800.0)), speeds=speeds, orders=[1.0])
        assert [c.speed for c in received.critical] == [w0]


@pytest.mark.parametrize("speeds", [[], [1.0], [2.0, 1.0], [-1.0, 1.0], [0.0, np.inf]])
def test_speeds_must_ascend(two_mass, speeds):
    with pytest.raises(OptionError, match="speeds"):
        lp.campbell(lp.assemble(two_mass), speeds=speeds, orders=[1.0])


@pytest.mark.parametrize("orders", [[0.0], [-1.0], [np.nan], []])
def test_orders_must_be_positive(two_mass, orders):
    with pytest.raises(OptionError, match="order"):
        lp.vibration.critical_speeds(lp.modes(lp.assemble(two_mass)), orders)


def test_the_picture_shows_frequencies_rays_and_points(two_mass):
    diagram = lp.campbell(lp.assemble(two_mass), speeds=[0.0, 30.0], orders=[1.0, 2.0])
    (axis,) = diagram.plot().axes
    w0 = np.sqrt(300.0 * 1.5)
    points = axis.lines[-1]
    assert points.get_xdata() == pytest.approx(np.array([w0 / 2, w0]) * 30 / np.pi, rel=1e-12)
    assert points.get_ydata() == pytest.approx([w0 / (2 * np.pi)] * 2, rel=1e-12)
    assert len(axis.lines) == 1 + 2 + 1


@pytest.mark.parametrize("given", [None, 3.0])
def test_a_function_that_gives_no_operating_point_is_told(given):
    with pytest.raises(OptionError, match=rf"campbell: at\(1\) gave {given}; an operating point"):
        lp.campbell(held(Spring(c=800.0)), speeds=[1.0, 2.0], orders=[1], at=lambda w: given)
