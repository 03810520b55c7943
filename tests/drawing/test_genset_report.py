"""The report of a genset and of a geared drive, in numbers and on paper."""

from pathlib import Path

import genset
import numpy as np
import pytest
from browser import opened
from drive_chains import chain_hertz
from html_page import Page
from test_torsional_report import FREQUENCIES, RPM, after

import lumped as lp
from lumped.models.marine_turbine.drive import MarineTurbine
from lumped.vibration import order_response


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """Page of the genset, and the responses that it tells."""
    told = {}
    write = lp.drawing.torsional_report

    def watching(response, path, **options):
        told.update(response=response, **options)
        return write(response, path, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lp.drawing, "torsional_report", watching)
        return genset.report(tmp_path_factory.mktemp("genset") / "page.html"), told


def test_a_genset_takes_a_user_eighty_lines():
    assert len(Path(genset.__file__).read_text(encoding="utf-8").splitlines()) <= 80


def test_the_genset_tells_firing_and_misfire_side_by_side(hall):
    page, told = hall
    cells = Page(page).cells
    fires, fails = told["response"].values()
    head = ("order", "all cylinders fire: kN.m", "at, 1/min", "cylinder 1 misfires: kN.m")
    rows = after(cells, *head, "at, 1/min")
    found = {float(rows[i]): (float(rows[i + 1]), float(rows[i + 3])) for i in range(0, 35, 5)}
    speeds = np.linspace(*fires.speeds[[0, -1]], 4001)
    closely = [response.at_speeds(speeds) for response in (fires, fails)]
    for order, sizes in found.items():
        for response, size in zip(closely, sizes, strict=True):
            wanted = 1e-3 * response.magnitude("coupling.tau", order).max()
            assert size == pytest.approx(wanted, rel=1e-4)
    # six equal cylinders at equal angles leave orders 3, 6, ... of the crank as a rigid body
    assert found[1.0][0] < 0.02 * found[1.0][1]
    assert found[3.0][0] == pytest.approx(found[3.0][1] * 6 / 5, rel=0.15)
    limit = told["limits"]["cylinder 1 misfires"][0]
    verdict = lp.vibration.verdict(fails, [limit]).results[0]
    row = after(cells, "cylinder 1 misfires", "vibratory torque", "coupling.tau", "maximum")
    assert float(row[0]) == pytest.approx(1e-3 * verdict.value, rel=1e-4)
    fired = "; ".join(map(str, genset.ENGINE["firing_order"]))
    assert after(cells, "engine", "firing_order")[0] == fired
    run = told["runs"]["Short circuit of the alternator"]
    row = after(cells, "coupling.tau", "kN.m")
    assert float(row[2]) == pytest.approx(1e-3 * run["coupling.tau"].min(), rel=1e-4)


def test_the_genset_has_the_modes_of_its_constant_inertias(hall):
    """Mean inertias of the cylinders, and the catalogue's stiffness at the mean torque."""
    page, told = hall
    cells = Page(page).cells
    own = genset.ENGINE
    a = 2 * np.pi * np.arange(4096) / 4096
    tilt = np.arcsin(own["r"] / own["L"] * np.sin(a))
    cylinder = own["m"] * np.mean((own["r"] * np.sin(a + tilt) / np.cos(tilt)) ** 2)
    inertias, stiffnesses = [J + cylinder for J in own["J"]], list(own["c"])
    inertias[-1] += 2.075
    first = next(iter(told["response"].values()))
    k = int(np.abs(first.speeds - 1500 * RPM).argmin())
    torque = abs(first.mean("coupling.tau")[k])
    stiffnesses.append(np.interp(torque, *np.transpose(genset.CATALOGUE["stiffness"])))
    stiffnesses.append(np.pi * 8e10 * 0.085**4 / (32 * 0.3))
    half = np.pi * 7850 * 0.085**4 * 0.3 / 64
    inertias += [half, 6.0 + half]
    hertz = chain_hertz(inertias, stiffnesses)
    rows = np.array(after(cells, *FREQUENCIES)[:35], dtype=float).reshape(7, 5)
    assert rows[:, 4] == pytest.approx(hertz, rel=1e-5)
    # dampers take some of the frequency, as the ring that the oil drags along does
    assert (np.abs(rows[:, 1] / hertz - 1) < 0.02).all()
    assert after(cells, "engine.cylinder[0]")[1] == f"{cylinder:.6g}"


def test_the_genset_prints_on_a4(hall, tmp_path: Path):
    page, _ = hall
    with opened(tmp_path) as browser:
        browser.open(page)
        assert browser.errors == []
        assert [url for url in browser.requests if not url.startswith(("file:", "data:"))] == []
        browser.call("Emulation.setEmulatedMedia", media="print")
        width = round(180 / 25.4 * 96)  # between the margins
        browser.size(width, 1000)
        assert browser.value("document.documentElement.scrollWidth") <= width
        # letters of pictures, px
        sizes = browser.value(
            "[...document.querySelectorAll('figure svg')]"
            ".map(s => Math.min(...[...s.querySelectorAll('text')].map(t => parseFloat("
            "getComputedStyle(t).fontSize) * s.getScreenCTM().a)))"
        )
        assert len(sizes) > 10
        points = [size * 72 / 96 for size in sizes]
        assert points[0] > 5  # of the schematic
        assert min(points[1:]) > 6


def test_a_geared_branched_drive_has_its_published_frequencies(tmp_path: Path):
    """Marine turbine of Gunter and Chen (2001): 177.7, 220.2 and 1282.6 1/min."""
    system = lp.assemble(MarineTurbine())
    response = order_response(
        system,
        speeds=np.linspace(20.0, 60.0, 9) * RPM,
        of=["shaft.tau"],
        shaft="propeller.phi",
        orders=[5],
    )
    cells = Page(lp.drawing.torsional_report(response, tmp_path / "page.html")).cells
    rows = np.array(after(cells, *FREQUENCIES)[:25], dtype=float).reshape(5, 5)
    assert np.round(60 * rows[:3, 4], 1).tolist() == [177.7, 220.2, 1282.6]
    # the water damps the first mode by 4 %
    assert rows[:, 1] == pytest.approx(rows[:, 4], rel=1e-3)
    parts = [cells[i + 1] for i, x in enumerate(cells) if x == "low.rotor"]
    assert parts[0] == "40.0424"
    shown = [text for text in cells if text == "torque in shaft, kN.m"]
    assert len(shown) == 2  # modes 1 and 2 are met by order 5
