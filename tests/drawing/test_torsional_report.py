"""The report on a torsional vibration calculation tells what was computed, in trade units."""

import re
from pathlib import Path

import numpy as np
import pytest
from browser import chromium
from html_page import Page
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.cli import main
from lumped.components import ElasticCoupling, Inertia, LossSpring, SpringDamper, Torque
from lumped.drawing.torsional_figures import order_figure, synthesis_figure
from lumped.drawing.torsional_study import study
from lumped.errors import LumpedError, OptionError, UnknownNameError
from lumped.vibration import Limit, order_response

RPM = np.pi / 30
JA, JB, C, D, TORQUE = 2.0, 5.0, 3e4, 15.0, 120.0
SPEEDS = np.linspace(200.0, 1200.0, 101) * RPM
FINE = np.linspace(200.0, 1200.0, 100_001) * RPM
DIAMETER = 0.05
NATURAL = np.sqrt(C * (1 / JA + 1 / JB))
NASTY = "normal <b>&"
FREQUENCIES = ("mode", "natural frequency, Hz", "1/min", "damping ratio", "without damping, Hz")
PARTS = ("part", "ratio", "J, kg.m2", "c, kN.m/rad", "J referred", "c referred")


class Shaft(SpringDamper):
    """A shaft with its stress."""

    d_shaft: lp.Param = lp.param("m", "diameter", DIAMETER, above=0)
    stress: lp.Var = lp.var("Pa", "nominal torsional stress")

    def equations(self):
        yield from super().equations()
        yield self.stress == 16 * self.tau / (np.pi * self.d_shaft**3)


def drive(torque=0.0):
    return assemble_row(
        push=Torque(tau=torque), a=Inertia(J=JA), shaft=Shaft(c=C, d=D), b=Inertia(J=JB)
    )


def respond(share=1.0, of=("shaft.tau", "shaft.stress", "shaft.phi_rel")):
    excitation = {"push.tau": {2: share * TORQUE, 4: 0.001 * TORQUE}}
    return order_response(drive(), speeds=SPEEDS, of=of, excitations=excitation)


def torque(order, amplitude):
    """Amplitude of the torque in the shaft between two inertias, of which one is excited."""
    w = 1j * order * FINE
    stiffness = C + D * w
    return np.abs(stiffness * amplitude / JA / (w**2 + stiffness * (1 / JA + 1 / JB)))


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = lp.simulate(drive(TORQUE), until=0.5, grid=5000)
    responses = {NASTY: respond(), "weak": respond(0.5)}
    return lp.drawing.torsional_report(
        responses,
        tmp_path_factory.mktemp("torsional") / "report.html",
        title="Drive <1>",
        about={"Plant": "mill & co", "Sources": ["drawing 7", "<data>"]},
        limits={
            NASTY: [
                Limit("shaft.tau", "500 N.m", "coupling <i>", source="maker", clause="4 <u>"),
                Limit("shaft.stress", "40 MPa", "shaft", measure="sum"),
            ],
            "step": [Limit("shaft.tau", "300 N.m", "peak")],
        },
        operation=("900 rpm", 1000 * RPM),
        margin=0.1,
        orders=[2],
        heat={NASTY: {"oil <s>": np.linspace(1e3, 3e3, len(SPEEDS))}},
        runs={"step": run},
        assumptions=["The load is <constant>."],
    )


def after(cells, *names):
    """Cells that follow cells of a row."""
    for i in range(len(cells)):
        if cells[i : i + len(names)] == list(names):
            return cells[i + len(names) :]
    raise AssertionError(f"{names} stand in no row")


def test_report_is_whole_and_loads_nothing(page: Path):
    found = Page(page)
    found.check_whole()
    heads = re.findall(r"<h2[^>]*>(.*?)</h2>", found.text)
    assert heads == [
        "Verdict",
        "Schematic",
        "Inertias and stiffnesses",
        "Natural frequencies and mode shapes",
        "Holzer tables",
        "Critical speeds",
        *(f"Order response: shaft.{name}" for name in ("tau", "stress", "phi_rel")),
        "Dissipated power",
        "Transients",
        "Data",
        "Assumptions and accuracy",
    ]


def test_texts_of_users_are_escaped(page: Path):
    text = page.read_text(encoding="utf-8")
    assert "<h1>Drive &lt;1&gt;</h1>" in text
    for tag in ("<b>&", "<i>", "<u>", "<s>", "<data>", "<constant>"):
        assert tag not in text
    assert {"mill & co", "drawing 7; <data>", "coupling <i>", "oil <s>"} <= set(Page(page).cells)


def test_frequency_and_critical_speed_are_those_of_two_inertias(page: Path):
    cells = Page(page).cells
    mode = after(cells, *FREQUENCIES)
    hertz = NATURAL / (2 * np.pi)
    assert [float(x) for x in mode[:3]] == pytest.approx([1, hertz, 60 * hertz], rel=1e-5)
    assert float(mode[4]) == pytest.approx(hertz, rel=1e-5)
    ratio = D * (1 / JA + 1 / JB) / (2 * NATURAL)
    assert float(mode[3]) == pytest.approx(ratio, rel=1e-3)
    head = ("speed, 1/min", "order", "mode", "natural frequency, Hz", "distance from operation, %")
    speed, order, _, _, distance = after(cells, *head)[:5]
    critical = NATURAL / 2 / RPM
    assert (float(speed), order) == (pytest.approx(critical, rel=1e-5), "2")
    assert float(distance) == pytest.approx(100 * (1 - critical / 900), abs=0.051)


def test_amplitudes_are_those_of_the_closed_form_in_kilonewtonmetres_and_degrees(page: Path):
    cells = Page(page).cells
    size = torque(2, TORQUE)
    twist = np.degrees(size / np.abs(C + D * 2j * FINE))
    stress = 1e-6 * 16 * size / (np.pi * DIAMETER**3)
    every = {"kN.m": 1e-3 * size, "MPa": stress, "deg": twist}
    for unit, values in every.items():
        head = ("order", f"{NASTY}: {unit}", "at, 1/min", f"weak: {unit}", "at, 1/min")
        order, first, at, second, _ = after(cells, *head)[:5]
        assert order == "2"
        assert float(first) == pytest.approx(values.max(), rel=1e-4)
        assert float(second) == pytest.approx(values.max() / 2, rel=1e-4)
        assert float(at) == pytest.approx(FINE[values.argmax()] / RPM, rel=1e-4)
    assert "1 more order below 1% of the largest." in page.read_text(encoding="utf-8")


def test_verdict_tells_use_place_and_speeds_to_bar(page: Path):
    cells = Page(page).cells
    total = torque(2, TORQUE) + torque(4, 0.001 * TORQUE)
    row = after(cells, NASTY, "coupling <i>", "shaft.tau", "maximum")[:7]
    assert row[1:3] == ["0.5", "kN.m"]
    assert float(row[3]) == pytest.approx(100 * total.max() / 500, rel=1e-3)
    assert float(row[4]) == pytest.approx(FINE[total.argmax()] / RPM, rel=1e-3)
    assert row[5:] == ["NO" if total.max() > 500 else "yes", "4 <u> maker"]
    stress = 16e-6 * total / (np.pi * DIAMETER**3)
    row = after(cells, NASTY, "shaft", "shaft.stress", "sum")[:3]
    assert float(row[0]) == pytest.approx(stress.max(), rel=1e-4)
    assert row[1:] == ["40", "MPa"]
    above = FINE[total > 500] / RPM
    text = page.read_text(encoding="utf-8")
    begin, end = re.search(r"Speeds to bar, normal[^:]*: (\S+) to (\S+) 1/min", text).groups()
    assert [float(begin), float(end)] == pytest.approx([above[0], above[-1]], rel=1e-4)
    assert re.search(r"FAILED: \d of 4 limits kept", text)
    distance = 1 - NATURAL / 2 / RPM / 900
    row = after(cells, "critical speeds", "separation", "mode 1, order 2", "distance")[:4]
    assert float(row[0]) == pytest.approx(distance, rel=1e-3)
    assert float(row[3]) == pytest.approx(10 / distance, abs=0.051)


def test_peaks_of_a_run_are_those_of_a_step(page: Path):
    z, mean = D * (1 / JA + 1 / JB) / (2 * NATURAL), TORQUE * JB / (JA + JB)
    cells = Page(page).cells
    row = after(cells, "quantity", "unit", "greatest", "at, s", "least", "at, s")
    assert row[:2] == ["shaft.tau", "kN.m"]
    twisted = -float(row[4])  # the torque of a spring is negative while its flange a drives
    # the torque of the damper moves the peak in the second order of the damping
    peak = 1e-3 * mean * (1 + np.exp(-np.pi * z / np.sqrt(1 - z**2)))
    assert twisted == pytest.approx(peak, rel=3 * z**2)
    assert float(row[5]) == pytest.approx(np.pi / NATURAL, rel=3 * z)
    assert float(after(cells, "step", "peak", "shaft.tau", "largest")[0]) == pytest.approx(twisted)


def test_data_stand_with_their_units(page: Path):
    cells = Page(page).cells
    rows = ["a", "1", "2", "2", "shaft", "1", "30", "30", "b", "1", "5", "5"]
    assert after(cells, *PARTS)[:12] == rows
    assert after(cells, "diameter", "shaft", "d_shaft")[:2] == ["0.05", "m"]
    assert after(cells, "viscous damping", "shaft", "d")[:2] == ["15", "N.m.s/rad"]
    assert after(cells, NASTY, "oil <s>")[:2] == ["3", "1200"]


def test_assumptions_name_laws_of_the_amplitude(tmp_path: Path):
    rubber = ElasticCoupling(
        stiffness=((0, C),),
        psi=0.8,
        w_loss=90.0,
        over_amplitude=((0, 1.0, 1.0), (900, 0.7, 1.1)),
        amplitude=50.0,
        extrapolate=True,
    )
    model = in_a_row(push=Torque(tau=0.0), a=Inertia(J=JA), rubber=rubber, b=Inertia(J=JB))
    response = order_response(
        lp.assemble(model),
        speeds=SPEEDS[::20],
        of=["rubber.tau"],
        excitations={"push.tau": {2: TORQUE}},
    )
    text = lp.drawing.torsional_report(response, tmp_path / "page.html").read_text()
    assert "Laws that depend on the amplitude" in text
    assert "runs take the amplitudes of the data: rubber.amplitude of 50 N.m." in text


def test_holzer_table_is_that_of_two_inertias(page: Path):
    text, hertz = page.read_text(encoding="utf-8"), NATURAL / (2 * np.pi)
    assert f"<h3>Mode 1: {hertz:.6g} Hz without damping</h3>" in text
    cells = Page(page).cells
    head = ("angle, rad", "twist, rad", "torque of inertia, kN.m", "torque in shaft, kN.m")
    found = after(cells, *head)[:12]
    torque, share = 1e-3 * JA * NATURAL**2, JA / JB
    wanted = {"a": (JA, 1, torque), "shaft": (30, -1 - share, -torque), "b": (JB, -share, -torque)}
    for i, (name, numbers) in enumerate(wanted.items()):
        assert found[4 * i] == name
        assert [float(x) for x in found[4 * i + 1 : 4 * i + 4]] == pytest.approx(numbers, rel=1e-4)


def test_assumptions_name_the_linearisation_and_frequency_laws(tmp_path: Path):
    system = assemble_row(
        push=Torque(tau=0.0),
        a=Inertia(J=JA),
        shaft=LossSpring(c=C, eta=0.1, w_loss=20 * np.pi),
        b=Inertia(J=JB),
    )
    response = order_response(
        system,
        speeds=[50.0],
        of=["shaft.tau"],
        excitations={"push.tau": {2: 1.0}},
        damping_ratio=0.01,
    )
    page = lp.drawing.torsional_report(response, tmp_path / "page.html", assumptions=["Mine."])
    text = page.read_text(encoding="utf-8")
    items = re.findall(r"<li>(.*?)</li>", text.split("Assumptions and accuracy</h2>")[1])
    assert items[0] == "Mine."
    assert any("shaft.w_loss of 62.8319 rad/s" in item for item in items)
    assert any("damping ratio of 0.01 was added" in item for item in items)
    assert any("1 order, 2, at 1 speed from" in item for item in items)
    assert any("Bending and axial vibration" in item for item in items)
    assert "<p>No limit was given.</p>" in text
    heads = set(re.findall(r"<h2[^>]*>(.*?)</h2>", text))
    assert heads.isdisjoint({"Verdict", "Dissipated power", "Transients"})
    assert "<h1>Model</h1>" in text


WRONG = {
    "no response": ({"response": {}}, OptionError, "at least one order response"),
    "no orders": ({"orders": []}, OptionError, "at least one order"),
    "another order": ({"orders": [3]}, OptionError, "order 3 was not computed"),
    "another quantity": ({"limits": [Limit("a.w", 1.0)]}, UnknownNameError, "is not observed"),
    "another unit": ({"limits": [Limit("shaft.tau", "4 MPa")]}, LumpedError, "MPa"),
    "caption": ({"limits": {"wek": []}}, UnknownNameError, "'wek' is the caption of no response"),
    "backwards": ({"operation": (50.0, 40.0)}, OptionError, "first and last speed of operation"),
    "in Hz": ({"operation": ("9 Hz", "10 Hz")}, LumpedError, "Hz"),
    "beyond": ({"operation": (50.0, 900.0)}, OptionError, "computed from 200 to 1200 1/min only"),
    "margin": ({"margin": 0.1}, OptionError, "speeds of operation, operation="),
    "heat": ({"heat": {"weak": {"oil": [1.0]}}}, OptionError, "heat of oil in 'weak'"),
    "no heat": ({"heat": {"weak": {"oil": "much"}}}, OptionError, "heat of oil in 'weak'"),
    "no run": ({"runs": {"step": 5}}, OptionError, "runs['step'] = 5: a run from lumped.simulate"),
    "a number": ({"response": {"weak": 5}}, OptionError, "response['weak'] = 5: a response from"),
    "heat of none": ({"heat": {"wek": {"oil": [1.0]}}}, UnknownNameError, "weak"),
}


@pytest.mark.parametrize("case", WRONG)
def test_slips_are_named(case, tmp_path: Path):
    options, error, text = WRONG[case]
    options = {"response": {"weak": respond()}} | options
    with pytest.raises(error, match=re.escape(text)):
        lp.drawing.torsional_report(options.pop("response"), tmp_path / "page.html", **options)
    assert not list(tmp_path.iterdir())


def test_a_run_of_another_drive_is_named(tmp_path: Path):
    other = lp.assemble(lp.compose(wheel=Inertia(J=1.0, w=1.0)))
    runs = {"coast": lp.simulate(other, until=0.1)}
    with pytest.raises(LumpedError, match="'coast' has none of the quantities"):
        lp.drawing.torsional_report(respond(), tmp_path / "page.html", runs=runs)


def grey(colour):
    """Brightness of a colour in a copy without colours."""
    from matplotlib.colors import to_rgb

    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))


def test_lines_differ_in_grey():
    rows = {float(order): 1.0 for order in range(1, 8)}
    response = order_response(
        drive(), speeds=SPEEDS, of=["shaft.tau"], excitations={"push.tau": rows}
    )
    limit = [Limit("shaft.tau", 300.0, measure=kind) for kind in ("half range", "with mean")]
    found = study(response, limits=limit, heat={}, runs={})
    for figure in (order_figure(found, "shaft.tau"), synthesis_figure(found, "shaft.tau")):
        lines = figure.axes[0].lines
        assert len(lines) == 6
        for i, one in enumerate(lines):
            for other in lines[:i]:
                alike = one._dash_pattern == other._dash_pattern
                assert not alike or abs(grey(one.get_color()) - grey(other.get_color())) > 0.3


def test_the_command_writes_the_page_of_a_users_module(tmp_path: Path, capsys):
    own, page = tmp_path / "own.py", tmp_path / "page.html"
    own.write_text(
        "def report(path, parameters):\n    path.write_text(repr(parameters))\n    return path\n"
    )
    assert main(["report", str(own), "--set", "shaft.c=5", "-o", str(page)]) == 0
    assert page.read_text() == "{'shaft.c': 5.0}"
    assert capsys.readouterr().out == f"written: {page}\n"
    own.write_text("x = 1\n")
    assert main(["report", str(own)]) == 2
    assert "no function report(path, parameters)" in capsys.readouterr().err
    assert main(["report", str(tmp_path / "none.py")]) == 2
    assert "there is no file" in capsys.readouterr().err


def test_every_critical_speed_is_listed_or_its_order_is_named(tmp_path: Path):
    """Twelve orders of a drive of two inertias, the sixth of which is the weakest."""
    sizes = {float(order): 1e-9 if order == 6 else TORQUE for order in range(1, 13)}
    response = order_response(
        drive(), speeds=SPEEDS, of=["shaft.tau"], excitations={"push.tau": sizes}
    )
    options = {"operation": ("900 rpm", "1000 rpm")}
    page = lp.drawing.torsional_report(response, tmp_path / "all.html", **options)
    cells = Page(page).cells
    head = ("speed, 1/min", "order", "mode", "natural frequency, Hz", "distance from operation, %")
    rows = np.reshape(after(cells, *head)[:25], (5, 5)).astype(float)
    assert rows[:, 1].tolist() == [6, 5, 4, 3, 2]  # below 1200 and above 200 1/min
    assert rows[:, 0] == pytest.approx(NATURAL / rows[:, 1] / RPM, rel=1e-5)
    assert "of the responses are left out" not in page.read_text()
    text = lp.drawing.torsional_report(
        response, tmp_path / "few.html", orders=[1, 2, 6, 11, 12], **options
    ).read_text()
    assert (
        "of 5 orders: 1, 2, 6, 11, 12. Left out of those of the responses: 3, 4, 5, 7, 8, 9, 10."
        in text
    )


def test_a_pdf_is_the_printed_page(tmp_path: Path, monkeypatch):
    if (program := chromium()) is None:
        pytest.skip("no Chromium: set LUMPED_CHROMIUM to its path")
    monkeypatch.setenv("LUMPED_CHROMIUM", program)
    made = lp.drawing.torsional_report(respond(), tmp_path / "page.PDF").read_bytes()
    assert made.startswith(b"%PDF-")
    assert b"%%EOF" in made[-16:]
    widths = [float(width) for width in re.findall(rb"/MediaBox \[0 0 (\S+) ", made)]
    assert widths == pytest.approx([210 / 25.4 * 72] * len(widths), abs=0.5)  # A4
    assert len(widths) > 3
    assert [each.name for each in tmp_path.iterdir()] == ["page.PDF"]


@pytest.mark.parametrize(
    ("program", "told"),
    [("/none", "'/none' is no program"), ("false", "printed no PDF"), ("", "none is on the PATH")],
)
def test_a_pdf_that_nothing_prints_is_refused(program, told, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("LUMPED_CHROMIUM", program)
    if not program:
        monkeypatch.setenv("PATH", str(tmp_path))
    for write, of in ((lp.drawing.torsional_report, respond()), (lp.drawing.report_html, drive())):
        with pytest.raises(OptionError, match=rf"x\.pdf: .*{told}.* Write x\.html instead"):
            write(of, tmp_path / "x.pdf")
    assert not list(tmp_path.iterdir())
