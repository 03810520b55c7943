"""Figures show what they were asked for, with units."""

import numpy as np
import pytest
from drive_chains import chain_hertz, in_turn
from matplotlib.figure import Figure
from processes import python
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, SpringDamper, Torque
from lumped.errors import OptionError

PARTS = {
    "motor": Torque(tau=lp.ops.where(lp.time >= 0.1, 5.0, 0.0)),
    "rotor": Inertia(J=1.0),
    "shaft": Spring(c=1e3),
    "load": Inertia(J=2.0),
}
RIG = assemble_row(**PARTS)
DAMPED = assemble_row(
    **(PARTS | {"shaft": SpringDamper(c=1e3, d=10.0)}),
    brake=SpringDamper(c=1e3, d=1.0),
    end=Inertia(J=0.5),
)


@pytest.fixture(scope="module")
def run() -> lp.Trajectory:
    return lp.simulate(RIG, until=0.3)


def panels(figure: Figure) -> list:
    return [axis for axis in figure.axes if axis.get_visible()]


def legend(axis) -> list[str]:
    return [text.get_text() for text in axis.get_legend().get_texts()]


def chain_of(count: int) -> lp.System:
    bodies = [Inertia(J=1.0 + 0.1 * i) for i in range(count)]
    return lp.assemble(in_turn(bodies=bodies, springs=[Spring(c=1e3) for _ in range(count - 1)]))


def test_trajectory_has_one_panel_for_each_unit_of_the_states(run: lp.Trajectory):
    received = {axis.get_ylabel(): legend(axis) for axis in run.plot().axes}
    assert received == {
        "angular velocity, rad/s": ["rotor.w", "load.w"],
        "twist, rad": ["shaft.phi_rel"],
    }
    assert run.plot().axes[-1].get_xlabel() == "time, s"


def test_panel_of_different_quantities_names_only_their_unit(run: lp.Trajectory):
    received = [axis.get_ylabel() for axis in run.plot(["shaft.tau", "motor.tau"]).axes]
    assert received == ["N.m"]


def test_trajectory_marks_events_in_every_panel(run: lp.Trajectory):
    figure = run.plot()
    for axis in figure.axes:
        (marks,) = axis.collections
        assert np.array(marks.get_offsets()) == pytest.approx(np.array([[0.1, 0.0]]))
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["motor.tau: time < 0.1 to time >= 0.1"]


def test_twelve_named_curves_stand_in_two_panels_and_remain_distinct():
    run = lp.simulate(chain_of(12), until=0.1, start={"bodies[0].w": 1.0})
    names = [f"bodies[{i}].w" for i in range(12)]
    drawn = [line for axis in run.plot(names).axes for line in axis.lines]
    assert {line.get_label() for line in drawn} == set(names)
    for axis in run.plot(names).axes:
        looks = {(line.get_color(), line.get_linestyle()) for line in axis.lines}
        assert len(looks) == len(axis.lines) <= 8


def test_system_without_states_is_refused():
    held = assemble_row(motor=Torque(tau=1.0), ground=Fixed())
    run = lp.simulate(held, until=1.0)
    with pytest.raises(ValueError, match="no states to draw"):
        run.plot()


@pytest.mark.parametrize("names", [("rotor.phi", "load.phi"), ("load.phi", "rotor.phi")])
def test_mode_shape_runs_along_the_named_quantities(names):
    (axis,) = panels(lp.modes(RIG).plot(names))
    assert [label.get_text() for label in axis.get_xticklabels()] == [*names]
    shape = {"rotor.phi": 1.0, "load.phi": -0.5}  # the heavier body moves half as much
    assert np.allclose(axis.lines[1].get_ydata(), [shape[name] for name in names], rtol=1e-12)


def test_mode_shape_runs_along_the_drive_in_the_order_of_declaration():
    (axis,) = panels(lp.modes(RIG).plot())
    assert [label.get_text() for label in axis.get_xticklabels()] == ["rotor.phi", "load.phi"]


def test_damped_mode_shows_what_moves_a_quarter_of_a_period_apart():
    modes = lp.modes(DAMPED)
    figure = modes.plot(["rotor.phi", "load.phi", "end.phi"])
    expected = [modes.shape(name) for name in ("rotor.phi", "load.phi", "end.phi")]
    for axis, shape in zip(panels(figure), np.transpose(expected), strict=True):
        _, real, imaginary = axis.lines
        assert np.array_equal(real.get_ydata(), shape.real)
        assert np.array_equal(imaginary.get_ydata(), shape.imag)
    (text, other) = figure.legends[0].get_texts()
    assert (text.get_text(), other.get_text()) == ("in phase", "a quarter of a period apart")


@pytest.mark.parametrize(
    ("n", "options", "drawn", "title"),
    [
        (12, {}, range(11), "Model"),
        (12, {"modes": [10, 2]}, [10, 2], "Model"),
        (30, {}, range(16), "Model\nthe 16 lowest of 29 modes; modes= chooses others"),
        (30, {"modes": range(20, 29)}, range(20, 29), "Model"),
    ],
)
def test_all_modes_are_drawn_or_it_is_said(n, options, drawn, title):
    figure = lp.modes(chain_of(n)).plot(**options)
    hertz = chain_hertz(1.0 + 0.1 * np.arange(n), np.full(n - 1, 1e3))
    received = {axis.get_title() for axis in panels(figure)}
    assert received == {f"{hertz[i]:.4g} Hz, damping ratio 0" for i in drawn}
    assert figure.get_suptitle() == title


def test_a_mode_that_does_not_exist_is_not_drawn():
    modes = lp.modes(chain_of(4))
    for wrong, text in (([3], "mode 3 of 3"), ([-1], "mode -1 of 3"), ([], "modes = ")):
        with pytest.raises(OptionError, match=text):
            modes.plot(modes=wrong)


def test_system_without_oscillation_is_refused():
    with pytest.raises(ValueError, match="no oscillating mode"):
        lp.modes(lp.assemble(lp.compose(body=Inertia(J=1.0)))).plot()


ROWS = ((0.0, 8.0), (2.0, 8.0), (4.0, 3.0))


def test_torque_speed_plane_shows_run_and_limits_in_all_quadrants(run: lp.Trajectory):
    demand = lp.simulation.sizing(run, of=("motor.tau", "rotor.w"), rated=2.5, maximum=ROWS)
    (axis,) = demand.plot().axes
    received = {line.get_label(): line for line in axis.lines}
    assert np.array_equal(received["run"].get_xdata(), run["rotor.w"])
    assert np.array_equal(received["run"].get_ydata(), run["motor.tau"])
    top = np.column_stack([received["maximum"].get_xdata(), received["maximum"].get_ydata()])
    corners = {(w, t) for speed, t in (*ROWS, (4.0, 0.0)) for w in (speed, -speed)}
    assert {tuple(point) for point in top} == corners
    assert set(received["rated"].get_ydata()) == {2.5}
    lowest = min(np.min(line.get_ydata()) for line in axis.lines)
    assert lowest == -8.0
    x, y = (received["thermal equivalent"].get_data()[i][0] for i in (0, 1))
    assert (x, y) == (demand.mean_speed, demand.rms_torque)
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("angular velocity, rad/s", "torque, N.m")


def test_torque_speed_plane_without_limits_shows_the_run_alone(run: lp.Trajectory):
    demand = lp.simulation.sizing(run, of=("motor.tau", "rotor.w"))
    assert legend(demand.plot().axes[0]) == ["run", "thermal equivalent"]


def test_figures_need_no_display_and_no_pyplot():
    code = (
        "import io, sys, lumped as lp\n"
        "from lumped.components import Inertia\n"
        "model = lp.compose(a=Inertia(J=1.0, w=1.0))\n"
        "lp.simulate(lp.assemble(model), until=1.0).plot().savefig(io.BytesIO())\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    python("-c", code)
