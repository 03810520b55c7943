"""Each kind of picture in both backends: the numbers of its result, units, readable texts."""

import sys

import matplotlib as mpl
import numpy as np
import pytest
from drive_chains import in_turn
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.text import Text

import lumped as lp
from lumped.components import Inertia, SpringDamper
from lumped.errors import OptionError
from lumped.plots.draw import draw
from lumped.plots.numbers import tornado
from lumped.plots.style import COLOURS

RPM = 60 / (2 * np.pi)


KINDS = (
    *("run", "file", "modes", "response", "campbell", "orders", "tracks", "sums", "holzer"),
    *("locus", "eigen", "point", "gradient", "forward", "ensemble", "precision", "sizing"),
    *("verdict", "comparison", "identified"),
)


def plotly_points(figure):
    """Points of all curves that have any, without those that mark instants."""
    found = []
    for trace in figure.data:
        if trace.type == "scatter" and trace.x[0] is not None and trace.text is None:
            found.append((np.array(trace.x, float), np.array(trace.y, float)))
    return found


def bars(figure, backend):
    if backend == "plotly":
        every = [trace for trace in figure.data if trace.type == "bar"]
        sizes = [np.ravel(t.x if t.orientation == "h" else t.y) for t in every]
        return sorted(float(size) for each in sizes for size in each)
    found = []
    for axis in figure.axes:
        for group in axis.containers:
            lying = group.orientation == "horizontal"
            found += [bar.get_width() if lying else bar.get_height() for bar in group.patches]
    return sorted(map(float, found))


# -- numbers -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_both_backends_draw_the_same_numbers(results, kind):
    plain, interactive = results[kind].plot(), results[kind].plot(backend="plotly")
    lines = [line for axis in plain.axes for line in axis.lines]
    received = plotly_points(interactive)
    lasting = [s for s in interactive.layout.shapes if s.type == "line"]
    levels = [s for s in lasting if not (s.xref.endswith("domain") and s.yref.endswith("domain"))]
    assert len(received) + len(levels) == len(lines)
    for x, y in received:
        assert any(
            np.array_equal(x, line.get_xdata(), equal_nan=True)
            and np.array_equal(y, line.get_ydata(), equal_nan=True)
            for line in lines
        )
    assert bars(interactive, "plotly") == pytest.approx(bars(plain, "matplotlib"))
    marks = [np.array(c.get_offsets())[:, 0] for axis in plain.axes for c in axis.collections
             if isinstance(c, PathCollection)]  # fmt: skip
    told = [np.array(trace.x) for trace in interactive.data if trace.text is not None]
    assert len(marks) == len(told)
    assert all(np.array_equal(a, b) for a, b in zip(marks, told, strict=True))


def curves(figure):
    """Points of named curves in plotly."""
    return {t.name: (np.array(t.x), np.array(t.y)) for t in figure.data if t.name}


def test_interactive_figures_hold_the_arrays_of_their_results(results):
    run = results["run"]
    drawn = curves(run.plot(["engine.w", "coupling.tau"], backend="plotly"))
    for name in ("engine.w", "coupling.tau"):
        assert np.array_equal(drawn[name][0], run.t)
        assert np.array_equal(drawn[name][1], run[name])
    response = results["response"]
    x, y = curves(response.plot(backend="plotly"))["pulses.tau"]
    assert np.array_equal(x, response.hertz)
    assert y == pytest.approx(np.abs(response["end.w", "pulses.tau"]))
    orders = results["orders"]
    x, y = curves(orders.plot(["coupling.tau"], backend="plotly"))["order 3"]
    assert x == pytest.approx(orders.speeds * RPM)
    assert y == pytest.approx(orders.magnitude("coupling.tau", 3.0))
    tracks = results["tracks"]
    (plane,) = [t for t in tracks.plot(backend="plotly").data if t.type == "heatmap"]
    assert np.array(plane.z) == pytest.approx(np.abs(tracks.values).T)
    total = sum(bars(results["ensemble"].plot(backend="plotly"), "plotly"))
    assert total == 50


def test_decibels_are_twenty_logarithms(results):
    response = results["response"]
    size, angle = response.plot(decibels=True).axes
    expected = 20 * np.log10(np.abs(response["end.w", "pulses.tau"]))
    assert size.lines[0].get_ydata() == pytest.approx(expected)
    assert size.get_ylabel() == "magnitude, dB of (rad/s)/(N.m)"
    assert (size.get_xscale(), size.get_yscale()) == ("log", "linear")
    assert angle.get_ylabel() == "phase, deg"


def test_bars_that_differ_much_are_logarithmic_and_tell_their_signs():
    ranked = [("a", 2.0), ("b", -0.5), ("c", 0.001), ("d", 1e-17), ("e", 0.0)]
    figure = draw(tornado(ranked, "drive", "the peak"))
    (axis,) = figure.axes
    assert axis.get_xscale() == "log"
    ends = axis.transData.transform([(size, 0) for size in (2.0, 0.5, 0.001)])[:, 0]
    box = axis.get_window_extent()
    assert ((ends - box.x0) / box.width > 0.05).all()
    colours = {bar.get_y() + bar.get_height() / 2: bar.get_facecolor() for bar in axis.patches}
    rises, falls = (mpl.colors.to_rgba(COLOURS[name]) for name in ("blue", "vermilion"))
    assert {round(k): v for k, v in colours.items()} == {0: rises, 1: falls, 2: rises}
    assert [text.get_text() for text in axis.texts] == ["+2", "-0.5", "+0.001"]
    assert figure.get_suptitle() == "drive\n2 without effect"


def test_verdict_shows_how_far_each_limit_is_used(results):
    verdict = results["verdict"]
    shares = sorted(100 * result.value / result.permitted for result in verdict.results)
    assert bars(verdict.plot(), "matplotlib") == pytest.approx(shares)


# -- units ---------------------------------------------------------------------------------------

UNITS = {"rad/s": "rpm", "N.m": "kN.m", "Hz": "1/min", "rad": "deg"}


@pytest.mark.parametrize("backend", ["matplotlib", "plotly"])
@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("run", {"angular velocity, rpm", "time, s"}),
        ("file", {"angular velocity, rpm", "time, s"}),
        ("response", {"magnitude, rpm/(kN.m)", "phase, deg", "frequency, 1/min"}),
        ("campbell", {"speed, rpm", "frequency, 1/min"}),
        ("orders", {"amplitude, kN.m", "amplitude, rpm", "speed, rpm"}),
        ("tracks", {"amplitude, kN.m", "order", "speed, rpm"}),
        ("holzer", {"relative angle", "torque in the shafts, kN.m"}),
        ("locus", {"real part / (2 pi), 1/min", "imaginary part / (2 pi), 1/min"}),
        ("ensemble", {"peak, kN.m", "runs"}),
        ("sizing", {"angular velocity, rpm", "torque, kN.m"}),
        ("comparison", {"magnitude, rpm/(kN.m)", "phase, deg", "frequency, 1/min"}),
        ("identified", {"body.w, rpm", "time, s"}),
    ],
)
def test_axes_have_the_units_that_are_chosen(results, kind, backend, expected):
    figure = results[kind].plot(units=UNITS, backend=backend)
    if backend == "plotly":
        layout = figure.layout
        axes = [layout[key] for key in layout if key[1:].startswith("axis")]
        received = {axis.title.text.replace("<br>", " ") for axis in axes if axis.title.text}
    else:
        labels = [text for axis in figure.axes for text in (axis.get_xlabel(), axis.get_ylabel())]
        received = {label.replace("\n", " ") for label in labels if label}
    assert expected <= received


def test_values_follow_the_units(results):
    run = results["run"]
    _, y = curves(run.plot(["engine.w"], units=UNITS, backend="plotly"))["engine.w"]
    assert y == pytest.approx(run["engine.w"] * RPM)
    (axis,) = results["campbell"].plot(units=UNITS).axes
    named = {line.get_label(): line for line in axis.lines}
    assert named["3: firing"].get_ydata() == pytest.approx(3 * named["3: firing"].get_xdata())
    response = results["response"]
    size = response.plot(units=UNITS).axes[0].lines[0].get_ydata()
    expected = np.abs(response["end.w", "pulses.tau"]) * RPM * 1e3
    assert size == pytest.approx(expected)


# -- what can be read ----------------------------------------------------------------------------


def drawn_texts(figure, monkeypatch):
    """All texts that are drawn, and their boxes in pixels."""
    found = {}
    draw_text = Text.draw

    def noted(self, renderer, *args, **kwargs):
        if self.get_text().strip() and self.get_visible():
            found[id(self)] = self
        return draw_text(self, renderer, *args, **kwargs)

    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # lays out
    with monkeypatch.context() as patch:
        patch.setattr(Text, "draw", noted)
        canvas.draw()
    renderer = canvas.get_renderer()
    return [(text.get_text(), Text.get_window_extent(text, renderer)) for text in found.values()]


def overlapping(figure, monkeypatch):
    boxes = drawn_texts(figure, monkeypatch)
    assert len(boxes) > 4
    pairs = [
        (name, other)
        for i, (name, box) in enumerate(boxes)
        for other, box_of_other in boxes[:i]
        if box.padded(-1.0).overlaps(box_of_other.padded(-1.0))
    ]
    outside = [name for name, box in boxes if not np.all(figure.bbox.padded(1.0).contains(*p)
               for p in (box.p0, box.p1))]  # fmt: skip
    return pairs + outside


@pytest.mark.parametrize("kind", KINDS)
def test_no_text_covers_another(results, kind, monkeypatch):
    assert overlapping(results[kind].plot(), monkeypatch) == []


def test_no_text_covers_another_in_pictures_of_a_long_drive(monkeypatch):
    bodies = [Inertia(J=1.0 + 0.1 * i) for i in range(40)]
    system = lp.assemble(
        in_turn(bodies=bodies, springs=[SpringDamper(c=1e3, d=0.1) for _ in range(39)])
    )
    run = lp.simulate(system, until=0.5, grid=100, start={"bodies[0].w": 1.0})
    course = run.plot()
    for figure in (course, lp.modes(system).plot(modes=range(5))):
        assert overlapping(figure, monkeypatch) == []
    told = course.get_suptitle()
    assert told.startswith("Model\n")
    assert told.endswith(" more: choose with names")


def test_legends_stand_beside_the_curves(results):
    figure = results["run"].plot()
    FigureCanvasAgg(figure).draw()
    for axis in figure.axes:
        assert axis.get_legend().get_window_extent().x0 >= axis.bbox.x1


# -- where and with what -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_pictures_are_drawn_into_given_axes(results, kind):
    own = results[kind].plot()
    count = len([axis for axis in own.axes if axis.get_label() != "<colorbar>"])
    figure = Figure((8.0, 3.0 * count))
    axes = figure.subplots(count, squeeze=False)
    assert results[kind].plot(ax=axes) is figure
    lines = [[len(axis.lines) for axis in each.axes if axis.lines] for each in (own, figure)]
    assert lines[0] == lines[1]


def test_axes_that_do_not_fit_are_refused(results):
    (axis,) = Figure().subplots(1, squeeze=False).ravel()
    response = results["response"]
    with pytest.raises(OptionError, match=r"2 matplotlib Axes are needed, for 'end\.w'; 'phase"):
        response.plot(ax=axis)
    with pytest.raises(OptionError, match="ax = 3 of them: 2 matplotlib Axes"):
        response.plot(ax=[axis] * 3)
    with pytest.raises(OptionError, match="one matplotlib Axes is needed"):
        results["campbell"].plot(ax="left")
    with pytest.raises(OptionError, match="ax = belongs to matplotlib"):
        results["run"].plot(ax=axis, backend="plotly")
    with pytest.raises(OptionError, match="backend = 'gnuplot': one of 'matplotlib', 'plotly'"):
        results["run"].plot(backend="gnuplot")


def test_without_plotly_the_error_says_what_to_install(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly", None)
    with pytest.raises(OptionError, match=r"plotly.*pip install lumped\[interactive\]"):
        results["run"].plot(backend="plotly")


def test_settings_of_matplotlib_stay(results):
    before = dict(mpl.rcParams)
    results["run"].plot()
    assert dict(mpl.rcParams) == before


def test_a_report_refuses_interactive_figures(results, tmp_path):
    run = results["run"]
    figures = {"Run": run.plot(backend="plotly")}
    with pytest.raises(OptionError, match=r"figures\['Run'\].*matplotlib"):
        lp.drawing.report_html(run.system, tmp_path / "page.html", title="Rig", figures=figures)


def test_colours_are_those_of_okabe_and_ito():
    """Color Universal Design, figure 16: red, green, blue from 0 to 255."""
    published = {
        "orange": (230, 159, 0),
        "sky": (86, 180, 233),
        "green": (0, 158, 115),
        "blue": (0, 114, 178),
        "vermilion": (213, 94, 0),
        "purple": (204, 121, 167),
    }
    assert {k: tuple(bytes.fromhex(v[1:])) for k, v in COLOURS.items()} == published
