"""A report is one page that loads nothing and says what the model is."""

import itertools
import re
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from browser import Browser, opened
from html_page import Page
from matplotlib.figure import Figure
from rows import assemble_row

import lumped as lp
from lumped.cli import main
from lumped.components import Coupling, Inertia, Spring, Torque
from lumped.errors import OptionError
from lumped.models import MARKS, Row, machine
from lumped.models.reversing_mill import stand


class Rig(lp.Component):
    """Two bodies <driven> & "free"."""

    motor: Torque = Torque(tau=lp.ops.where(lp.time >= 0.1, 5.0, 0.0))
    rotor: Inertia = Inertia(J=1.5)
    shaft: Spring = Spring(c=1e3)
    load: Inertia = Inertia(J=2.0)

    def connections(self):
        yield from lp.chain(self.motor, self.rotor, self.shaft, self.load)


class Number(NamedTuple):
    """A number of a source."""

    value: float
    unit: str
    mark: str
    text: str

    def __float__(self) -> float:
        return self.value


def parabola() -> tuple[Figure, np.ndarray, np.ndarray]:
    """A figure of which every point is known, in a panel that is not the first."""
    x = np.linspace(0.0, 4.0, 9)
    figure = Figure((6, 5), layout="constrained")
    first, second = figure.subplots(2, sharex=True)
    first.semilogy(x, 10**x, label="decades")
    first.set_ylabel("size, 1")
    second.plot(x, x**2, label="square")
    second.set(xlabel="time, s", ylabel="way, m", xscale="linear")
    return figure, x, x**2


@pytest.fixture(scope="module")
def system() -> lp.System:
    return lp.assemble(Rig())


@pytest.fixture(scope="module")
def page(system: lp.System, tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = lp.simulate(system, until=0.3)
    return lp.drawing.report_html(
        system,
        tmp_path_factory.mktemp("page") / "report.html",
        title="Rig <1>",
        figures={"known": parabola()[0], "run & more": run.plot()},
        text={"Source": ["A <book>, page 7.", "Its table 2 is wrong."], "Aim": "What & why."},
        compared=[
            Row("other", "1", None, 2.0, "none [A]", "by hand"),
            Row("frequency", "Hz", 5.0, 5.5, "table 1 [P]", "rounded"),
            Row("share", "%", None, 12.0, "text [P]", "", (5.0, 10.0)),
            Row("solved", "1", 4.0, 4.0, "table 2 [P]", "angle [I]", None, True),
        ],
        given=[Number(1.5, "kg.m2", "P", "rotor"), Number(1e3, "N.m/rad", "A", "shaft")],
        marks=MARKS,
    )


def test_page_is_whole_and_loads_nothing(page: Path):
    Page(page).check_whole()


def test_page_tells_parameters_states_and_what_was_left_out(page: Path, system: lp.System):
    cells = Page(page).cells
    for name, value, unit in (("rotor.J", "1.5", "kg.m2"), ("shaft.c", "1000", "N.m/rad")):
        place = cells.index(name)
        assert cells[place + 1 : place + 3] == [value, unit]
    assert set(system.state_names) <= set(cells)
    assert {item.what for item in system.left_out} <= set(cells)
    place = cells.index("rotor")
    assert cells[place : place + 4] == ["rotor", "1.5", "kg.m2", "printed"]


def test_page_begins_with_its_texts(page: Path):
    text = page.read_text()
    heads = re.findall(r"<h2[^>]*>(.*?)</h2>", text)
    expected = ["Source", "Aim", "Published and computed", "Computed besides", "Schematic"]
    assert heads[:5] == expected
    assert "<li>A &lt;book&gt;, page 7.</li><li>Its table 2 is wrong.</li>" in text
    assert "<p>What &amp; why.</p>" in text


def test_published_numbers_with_their_deviations_stand_apart_from_own_ones(page: Path):
    published, own = page.read_text().split("Computed besides</h2>")
    published = published.split("Published and computed</h2>")[1]
    for name, part in (("frequency", published), ("share", published), ("other", own)):
        assert f"<td>{name}</td>" in part
    assert "<td>other</td>" not in published
    cells = Page(page).cells
    place = cells.index("frequency")
    expected = ["Hz", "5", "5.5", "+10.00", "table 1 [P]", "rounded"]
    assert cells[place + 1 : place + 7] == expected
    place = cells.index("share")
    assert cells[place + 2 : place + 5] == ["5 to 10", "12", "not met"]
    assert cells[cells.index("solved") + 4] == "+0.00, fitted"


def test_page_shows_error_against_run_time(system: lp.System, tmp_path: Path):
    found = lp.simulation.work_precision(system, until=0.2)
    page = Page(lp.drawing.report_html(system, tmp_path / "page.html", accuracy=found))
    place = page.cells.index("outcome") + 1
    for row in found.rows:
        received = page.cells[place : place + 8]
        assert received[:2] == [row.method, f"{row.rtol:g}"]
        assert float(received[3]) == pytest.approx(1e3 * row.seconds, rel=0.01)
        assert received[4:7] == [str(row.steps), str(row.evaluations), str(row.events)]
        place += 8
    assert not re.search(r"https?:", page.text)


@pytest.mark.parametrize("name", ["rig.docx", "rig.txt", "rig"])
def test_a_file_that_is_no_page_is_refused(system: lp.System, tmp_path: Path, name: str):
    with pytest.raises(OptionError, match=rf"^{name}: a report is a page \.html or \.pdf"):
        lp.drawing.report_html(system, tmp_path / name, title="Rig")
    assert not list(tmp_path.iterdir())


def test_texts_are_escaped(page: Path):
    assert "<h1>Rig &lt;1&gt;</h1>" in page.read_text()
    assert "run &amp; more" in page.read_text()
    assert "Two bodies &lt;driven&gt; &amp;" in page.read_text()


def test_figures_are_left_as_they_were(system: lp.System, tmp_path: Path):
    figure, _, _ = parabola()
    lp.drawing.report_html(system, tmp_path / "page.html", figures={"known": figure})
    assert all(line.get_gid() is None for axis in figure.axes for line in axis.lines)


def test_page_tells_events_energies_and_what_motors_must_do(tmp_path: Path):
    """A body pushed by 6 N.m for 1 s until a clutch joins it to a second one: all is known."""
    system = assemble_row(
        push=Torque(tau=lp.ops.where(lp.time < 1.0, 6.0, 0.0)),
        first=Inertia(J=2.0),
        clutch=Coupling(u=lp.ops.where(lp.time >= 2.0, 1.0, 0.0)),
        second=Inertia(J=1.0),
    )
    run = lp.simulate(system, until=3.0, certify=True)
    asked = lp.simulation.sizing(run, of=("push.tau", "first.w"), rated=4.0)
    file = lp.drawing.report_html(
        system, tmp_path / "page.html", runs={"Push and join": run}, sizing={"pusher": asked}
    )
    found = Page(file)
    assert "<p>Push and join</p>" in found.text
    cells = found.cells
    # 3 rad/s from 6 N.m on 2 kg.m2; joined by 1 kg.m2 a third of the energy is lost
    joined = cells.index("2")
    assert "clutch: free \u2192 stuck" in cells[joined + 1]
    assert float(cells[joined + 2]) == pytest.approx(3.0, rel=1e-5)
    energies = {
        "work of push": 9.0,
        "stored at the end, less that at the begin": 6.0,
        "lost by them in impacts": 3.0,
    }
    for name, value in energies.items():
        assert float(cells[cells.index(name) + 1]) == pytest.approx(value, rel=1e-5), name
    motor = {"peak torque": 6.0, "RMS torque": 6.0 / 3**0.5, "peak speed": 3.0, "peak power": 18.0}
    for name, value in motor.items():
        assert float(cells[cells.index(name) + 2]) == pytest.approx(value, rel=1e-5), name
    load = cells[cells.index("RMS torque over rated torque") + 2]
    assert float(load) == pytest.approx(100 * 6.0 / 3**0.5 / 4.0, rel=1e-3)


@pytest.fixture(scope="module")
def mill(tmp_path_factory: pytest.TempPathFactory, machine_rows) -> Path:
    file = tmp_path_factory.mktemp("command") / "mill.html"
    rows = machine_rows("reversing_mill")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machine("reversing_mill"), "rows", lambda: rows)
        assert main(["report", "reversing_mill", "-o", str(file)]) == 0
    return file


def test_command_writes_a_whole_page_with_published_and_computed_numbers(mill: Path):
    found = Page(mill)
    heads = re.findall(r"<h2[^>]*>(.*?)</h2>", found.text)
    assert heads[:4] == ["Introduction", "Source", "Findings", "Assumptions"]
    assert {"Events", "Energy balance", "Sizing of motors"} <= set(heads)
    assert "Filatov" in found.text
    assert "printed frequencies follow" in found.text
    for name in vars(stand):
        if name.isupper() and len(name) > 3:
            assert name not in found.cells
    place = found.cells.index("upper branch, gap open, f1")
    assert found.cells[place + 1 : place + 3] == ["Hz", "39.8"]
    assert float(found.cells[place + 3]) == pytest.approx(39.8, rel=0.006)
    assert not re.search(r"https?:", found.text)


def test_command_reports_on_a_changed_machine(tmp_path: Path):
    file = tmp_path / "changed.html"
    assert main(["report", "reversing_mill", "--set", "upper.motor.J=30", "-o", str(file)]) == 0
    found = Page(file)
    assert "<li>upper.motor.J = 30.0</li>" in found.text
    assert "Published and computed" not in found.text
    place = found.cells.index("upper.motor.J")
    assert found.cells[place + 1] == "30"
    place = found.cells.index("gap open, natural frequency 2")
    assert found.cells[place + 4].endswith("unchanged")


def test_command_refuses_an_unknown_machine(capsys: pytest.CaptureFixture[str]):
    assert main(["report", "reversing_mil"]) == 2
    assert "reversing_mill" in capsys.readouterr().err.partition("Nearest:")[2]


# -- in a browser ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory):
    with opened(tmp_path_factory.mktemp("profile")) as found:
        yield found


def view(browser: Browser, k: int) -> list[float]:
    text = browser.value(f"document.querySelectorAll('figure svg')[{k}].getAttribute('viewBox')")
    return [float(v) for v in text.split()]


def on_screen(browser: Browser, k: int, x: float, y: float) -> tuple[float, float]:
    """Where a point of a picture is seen, after scrolling there."""
    code = f"""(() => {{
        const svg = document.querySelectorAll('figure svg')[{k}];
        svg.scrollIntoView({{block: 'center'}});
        const p = new DOMPoint({x}, {y}).matrixTransform(svg.getScreenCTM());
        return [p.x, p.y];
    }})()"""
    return tuple(browser.value(code))


def test_page_renders_without_errors_and_without_requests(browser: Browser, page: Path):
    browser.open(page)
    assert browser.errors == []
    assert all(url.startswith(("file:", "data:")) for url in browser.requests)
    assert browser.value("document.title") == "Rig <1>"
    sizes = browser.value(
        "[...document.querySelectorAll('figure svg')].map(s => s.getBoundingClientRect().height)"
    )
    assert len(sizes) == 3
    assert min(sizes) > 100


def test_value_under_the_pointer_is_that_of_the_nearest_point(browser: Browser, page: Path):
    browser.open(page)
    figure, x, y = parabola()
    figure.draw_without_rendering()
    axis = figure.axes[1]
    curves = {"square": (axis, "way, m", y), "decades": (figure.axes[0], "size, 1", 10**x)}
    for i, name in itertools.product((1, 4, 7), curves):
        axis, unit, y = curves[name]
        px, py = axis.transData.transform((x[i], y[i])) * 72 / figure.dpi
        place = on_screen(browser, 1, px + 1.5, 72 * 5 - py - 1.5)
        browser.mouse("mouseMoved", *place)
        received = browser.value("document.querySelectorAll('figure output')[1].textContent")
        found = re.fullmatch(rf"{name}: time, s (\S+); {unit} (\S+)", received)
        assert found, received
        assert [float(v) for v in found.groups()] == pytest.approx([x[i], y[i]], rel=3e-3)


def test_wheel_zooms_about_the_pointer(browser: Browser, page: Path):
    browser.open(page)
    x, y, width, height = view(browser, 1)
    px, py = x + 0.25 * width, y + 0.6 * height
    place = on_screen(browser, 1, px, py)
    browser.mouse("mouseWheel", *place, deltaX=0, deltaY=-120)
    expected = [px - 0.8 * (px - x), py - 0.8 * (py - y), 0.8 * width, 0.8 * height]
    deadline = time.monotonic() + 5
    while view(browser, 1) == [x, y, width, height] and time.monotonic() < deadline:
        time.sleep(0.02)
    assert view(browser, 1) == pytest.approx(expected, abs=0.3)  # half a pixel


def test_drag_moves_the_picture_and_reset_shows_all_again(browser: Browser, page: Path):
    browser.open(page)
    home = view(browser, 1)
    buttons = "document.querySelectorAll('figure')[1].querySelectorAll('button')"
    assert browser.value(f"[...{buttons}].map(b => b.textContent)") == ["+", "\u2212", "reset"]
    browser.value(f"{buttons}[0].click()")
    inner = view(browser, 1)
    assert inner[2:] == pytest.approx([0.7 * home[2], 0.7 * home[3]])
    a = on_screen(browser, 1, home[0] + 0.5 * home[2], home[1] + 0.5 * home[3])
    browser.mouse("mousePressed", *a, button="left", clickCount=1)
    browser.mouse("mouseMoved", a[0] + 40, a[1] - 25, button="left")
    browser.mouse("mouseReleased", a[0] + 40, a[1] - 25, button="left", clickCount=1)
    scale = browser.value("document.querySelectorAll('figure svg')[1].getScreenCTM().a")
    moved = [inner[0] - 40 / scale, inner[1] + 25 / scale, *inner[2:]]
    assert view(browser, 1) == pytest.approx(moved, abs=0.5)
    code = f"(() => {{ const r = {buttons}[2].getBoundingClientRect();"
    x, y = browser.value(f"{code} return [r.x + r.width / 2, r.y + r.height / 2]; }})()")
    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    browser.mouse("mouseReleased", x, y, button="left", clickCount=1)
    assert view(browser, 1) == home
    assert browser.errors == []


def test_page_shows_all_without_scripts(browser: Browser, page: Path):
    browser.open(page, scripts=False)
    document = browser.call("DOM.getDocument", depth=-1)["root"]
    found = Counter()
    stack = [document]
    while stack:
        node = stack.pop()
        found[node["nodeName"].lower()] += 1
        stack += node.get("children", [])
    assert found["svg"] == 3
    assert found["table"] >= 5
    assert found["button"] == 0


def test_report_of_a_machine_renders_without_errors(browser: Browser, mill: Path):
    browser.open(mill)
    assert browser.errors == []
    figures = browser.value("document.querySelectorAll('figure').length")
    assert figures > 3
    assert browser.value("document.querySelectorAll('figure button').length") == 3 * figures
