"""What notebooks show of models and results."""

import time
from xml.dom import minidom

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.drawing import sparklines
from lumped.drawing.rich_output import html


class Shaft(lp.Component):
    """Two inertias on a shaft, one driven."""

    motor: Torque = Torque(tau=lp.ops.where(lp.time >= 0.3, -2.0, 5.0))
    a: Inertia = Inertia(J=2.0, w=1.0)
    shaft: SpringDamper = SpringDamper(c=300.0, d=0.5)
    b: Inertia = Inertia(J=1.0)

    def connections(self):
        yield from lp.chain(self.motor, self.a, self.shaft, self.b)


def cells(shown):
    """Texts of the cells of the first table, row by row."""
    table = minidom.parseString(shown).getElementsByTagName("table")[0]
    rows = table.getElementsByTagName("tr")
    return [[_text(c) for c in r.childNodes] for r in rows]


def _text(node):
    if node.nodeType == node.TEXT_NODE:
        return node.data
    return "".join(map(_text, node.childNodes))


@pytest.fixture(scope="module")
def system():
    return lp.assemble(Shaft())


def test_a_run_is_shown_with_its_states_courses_and_events(system):
    run = lp.simulate(system, until=0.6)
    shown = html(run)
    told = {row[0]: row for row in cells(shown)}
    assert float(told["a.w"][4]) == pytest.approx(run["a.w"].max(), rel=1e-5)
    assert shown.count("<svg") == len(system.state_names)
    assert "1 events" in shown


def test_modes_are_shown_by_frequency_and_shape(system):
    shown = html(lp.modes(system))
    expected = np.sqrt(300.0 * (1 / 2.0 + 1 / 1.0)) / (2 * np.pi)
    assert float(cells(shown)[1][1]) == pytest.approx(expected, rel=1e-3)  # damping is small
    assert shown.count("<rect") == 2  # two angles


def test_models_are_shown_as_schematics_and_faulty_ones_as_text():
    shown = Shaft()._repr_html_()
    assert "<svg" in shown
    assert len(shown) < 50_000
    faulty = lp.compose(
        a=Inertia(J=1.0), connections=lambda m: [lp.connect(m.a.flange_a, Torque(tau=1.0).flange)]
    )
    assert "<svg" not in faulty._repr_html_()


def test_what_is_shown_is_one_element_without_script_and_quick(system):
    run = lp.simulate(system, until=0.6, certify=True)
    response = lp.frequency_response(
        system, inputs=["shaft.phi_rel0"], outputs=["b.w"], hertz=np.linspace(1.0, 5.0, 7)
    )
    for one in (Shaft(), system, run, run.certificate, run.point(0.2), response):
        begin = time.process_time()
        shown = html(one)
        assert time.process_time() - begin < 1.0
        assert len(shown) < 60_000
        assert minidom.parseString(shown).documentElement.tagName == "div"
        assert "<script" not in shown


def test_a_file_is_shown_as_the_run_that_was_saved(system, tmp_path):
    run = lp.simulate(system, until=0.6)
    saved = lp.load(run.save(tmp_path / "run.nc"))
    shown, expected = saved._repr_html_(), run._repr_html_()
    assert cells(shown)[1:] == cells(expected)[1:]
    assert shown.count("<svg") == expected.count("<svg")
    assert "time &lt; 0.3 \u2192 time &gt;= 0.3" in shown
    with lp.display_units({"a.w": "rpm"}):
        told = {row[0]: row for row in cells(saved._repr_html_())}
    assert float(told["a.w"][1]) == pytest.approx(60 / (2 * np.pi), rel=1e-5)  # 1 rad/s
    assert len(repr(saved)) < 2000


def test_frequencies_are_shown_with_the_parameters_that_matter(system):
    """Of undamped w^2 = c (1/J_a + 1/J_b) the relative derivatives are 1/2, -1/6 and -1/3."""
    model = Shaft(shaft=SpringDamper(c=300.0, d=1e-9))
    found = lp.vibration.eigen_sensitivity(lp.modes(lp.assemble(model)))
    shown = found._repr_html_()
    for told in ("shaft.c +0.5", "b.J -0.333", "a.J -0.167"):
        assert told in shown


def test_names_are_escaped():
    assert "&lt;b&gt;" in sparklines.curves(np.arange(2.0), [np.arange(2.0)], "<b>")
    ones = np.ones((2, 1))
    rows = html(lp.ensembles.Ensemble(("p",), ones, ("<b>",), ones, {}, (2,), 1, 0.1, 0.1))
    assert "&lt;b&gt;" in rows
    assert "<b>" not in rows


def test_a_curve_keeps_its_peaks_however_long_it_is():
    y = np.zeros(100_000)
    y[54_321] = 1.0
    shown = sparklines.curve(np.arange(100_000.0), y)
    line = minidom.parseString(shown).getElementsByTagName("polyline")[0]
    points = [p.split(",") for p in line.getAttribute("points").split()]
    heights = np.array(points, dtype=float)
    assert heights[heights[:, 1].argmin(), 0] == pytest.approx(2 + 156 * 0.54321, abs=0.1)
    assert np.ptp(heights[:, 1]) == pytest.approx(24.0)
    assert len(points) < 1000
