"""Critical speeds against closed forms."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, SpringDamper
from lumped.errors import OptionError
from lumped.plots.draw import draw
from lumped.support.display_units import frequency_unit, speed_unit
from lumped.vibration.speeds import campbell_picture


def held(shaft):
    return assemble_row(body=Inertia(J=2.0), shaft=shaft, wall=Fixed())


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


@pytest.mark.parametrize(
    ("speeds", "orders"),
    [
        *((speeds, [1.0]) for speeds in ([], [1.0], [2.0, 1.0], [-1.0, 1.0], [0.0, np.inf])),
        *(([1.0, 2.0], orders) for orders in ([0.0], [-1.0], [np.nan], [])),
    ],
)
def test_speeds_must_ascend_and_orders_be_positive(two_mass, speeds, orders):
    with pytest.raises(OptionError, match="speeds" if orders == [1.0] else "order"):
        lp.campbell(lp.assemble(two_mass), speeds=speeds, orders=orders)


def test_the_picture_shows_frequencies_rays_and_points(two_mass):
    diagram = lp.campbell(lp.assemble(two_mass), speeds=[0.0, 30.0], orders=[1.0, 2.0])
    (axis,) = diagram.plot().axes
    w0 = np.sqrt(300.0 * 1.5)
    points = axis.lines[-1]
    assert points.get_xdata() == pytest.approx(np.array([w0 / 2, w0]) * 30 / np.pi, rel=1e-12)
    assert points.get_ydata() == pytest.approx([w0 / (2 * np.pi)] * 2, rel=1e-12)
    assert len(axis.lines) == 1 + 2 + 1


def test_a_mode_beyond_the_rays_does_not_set_the_axis():
    """Crossings at 10 and 40 Hz below a mode of 3 kHz; without a crossing the lowest mode shows."""
    speeds = np.array([0.0, 2 * np.pi * 15])
    for hertz, top in (([10.0, 40.0, 3e3], 46.0), ([100.0, 3e3], 115.0), ([], 1.15 * 45)):
        picture = campbell_picture.campbell_picture(
            "drive",
            speeds,
            np.tile(np.array(hertz), (2, 1)),
            [("", 1.0), ("", 3.0)],
            [],
            None,
            [],
            (speed_unit(), frequency_unit()),
        )
        assert draw(picture).axes[0].get_ylim() == pytest.approx((0.0, top))


def text_boxes(figure):
    """Boxes of the labels of rays, of the axes, and of the whole picture, in pixels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    (axis,) = figure.axes
    labels = [Text.get_window_extent(label, renderer) for label in axis.texts]
    return labels, axis.get_window_extent(renderer), figure.bbox


@pytest.mark.parametrize(
    ("orders", "hertz", "speeds"),
    [
        (range(1, 25), [20, 45, 110], (0, 314)),
        (np.arange(0.5, 24.5, 0.5), [216, 592, 985], (63, 272)),
        ([1, 1.001, 1.002, 2, 2.0005, 5, 5.001], [20, 50], (0, 105)),
        ([3763.8, 4798.8, 5.0, 7527.5, 2042.0], [3, 120, 900], (0, 10.5)),
        ([11.4, 11.5, 11.6, 11.45, 11.55], [100], (0, 62.8)),
        ([1], [], (0, 62.8)),
        ([0.5, 1, 2, 5, 10, 11, 12, 13, 14, 20, 40], [10, 200], (104.7, 115.2)),
        (np.linspace(1, 8, 60), [300], (0, 314)),
        ([0.01, 0.02, 0.03, 100, 150, 200, 900, 1e5], [1, 1e4], (0, 314)),
        ({f"stage {i}, {17 + i} teeth": 17.0 + i for i in range(6)}, [1, 900], (0, 314)),
    ],
)
def test_labels_of_rays_touch_neither_each_other_nor_the_curves(orders, hertz, speeds):
    labels = list(orders) if isinstance(orders, dict) else [""] * len(orders)
    values = list(orders.values()) if isinstance(orders, dict) else list(orders)
    grid = np.linspace(*speeds, 20)
    picture = campbell_picture.campbell_picture(
        "drive",
        grid,
        np.tile(np.array(hertz, dtype=float), (20, 1)),
        list(zip(labels, values, strict=True)),
        [],
        (100.0, 150.0),
        [(70.0, 80.0), (200.0, 210.0)],
        (speed_unit(), frequency_unit()),
    )
    figure = draw(picture)
    boxes, axes, whole = text_boxes(figure)
    top = figure.axes[0].get_ylim()[1]
    seen = {f"{order:g}" for order in values if order * grid[0] / (2 * np.pi) < top}
    assert {label.get_text() for label in figure.axes[0].texts} == seen
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:i])
        assert not box.overlaps(axes)
        assert whole.x0 <= box.x0 < box.x1 <= whole.x1
        assert whole.y0 <= box.y0 < box.y1 <= whole.y1


def test_places_that_are_moved_apart_are_the_nearest():
    """Three wishes for one place share the way; free ones keep theirs."""
    received = campbell_picture._apart([0.1, 0.5, 0.5, 0.5, 0.9], [0.1] * 5)
    assert received == pytest.approx([0.1, 0.4, 0.5, 0.6, 0.9])
    assert campbell_picture._apart([0.99, 1.0], [0.1] * 2) == pytest.approx([0.85, 0.95])


def test_the_picture_shades_operation_and_barred_ranges(two_mass):
    system = lp.assemble(two_mass)
    diagram = lp.campbell(system, speeds=[1.0, 30.0], orders=[1.0, 2.0])
    verdict = lp.vibration.separation(diagram, between=(10.0, 20.0))
    figure = diagram.plot(between=(10.0, 20.0), barred=verdict.barred)
    spans = [patch.get_extents() for patch in figure.axes[0].patches]
    transform = figure.axes[0].transData
    received = [transform.inverted().transform(s.get_points())[:, 0] for s in spans]
    expected = [(10.0, 20.0), *((b.begin, b.end) for b in verdict.barred)]
    assert np.array(received) == pytest.approx(np.array(expected) * 30 / np.pi)
    assert len(verdict.barred) == 2
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["range of operation", "barred", "natural frequencies", "critical speeds"]


def test_orders_may_have_labels(two_mass):
    system = lp.assemble(two_mass)
    orders = {"unbalance": 1.0, "mesh, 12 teeth": 12.0}
    diagram = lp.campbell(system, speeds=[1.0, 30.0], orders=orders)
    plain = lp.campbell(system, speeds=[1.0, 30.0], orders=[1.0, 12.0])
    assert [c.speed for c in diagram.critical] == [c.speed for c in plain.critical]
    assert [c.label for c in diagram.critical] == ["mesh, 12 teeth", "unbalance"]
    assert "12 (mesh, 12 teeth)" in repr(diagram)
    found = lp.vibration.separation(diagram, between=(10.0, 20.0))
    assert {r.quantity for r in found.results} == {"mode 1, unbalance", "mode 1, mesh, 12 teeth"}


@pytest.mark.parametrize("given", [None, 3.0])
def test_a_function_that_gives_no_operating_point_is_told(given):
    with pytest.raises(OptionError, match=rf"campbell: at\(1\) gave {given}; an operating point"):
        lp.campbell(held(Spring(c=800.0)), speeds=[1.0, 2.0], orders=[1], at=lambda w: given)
