"""The command as a user types it."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from matplotlib.figure import Figure
from processes import python

from lumped.cli import main
from lumped.models import MACHINES, MARKS, Row, machine


def test_list_shows_every_machine_on_one_line(capsys: pytest.CaptureFixture[str]):
    assert main(["list"]) == 0
    received = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    assert received == [[name, text] for name, text in MACHINES.items()]


def test_module_runs_like_the_command(capsys: pytest.CaptureFixture[str]):
    main(["list"])
    assert python("-m", "lumped", "list") == capsys.readouterr().out


class Ran(NamedTuple):
    """A machine as the command runs it, and its rows computed besides."""

    name: str
    printed: str
    json: dict
    folder: Path
    rows: list[Row]


@pytest.fixture(scope="module", params=MACHINES)
def ran(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    machine_rows: Callable[[str], list[Row]],
) -> Ran:
    name = request.param
    folder = tmp_path_factory.mktemp(name) / "new" / "figures"
    file = folder.parent.parent / "numbers.json"
    rows = machine_rows(name)
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
        patch.setattr(machine(name), "rows", lambda: rows)
        save = Figure.savefig  # small pictures without a layout are painted sooner

        def save_small(figure: Figure, file: Path, **_: object) -> None:
            figure.set_layout_engine("none")
            save(figure, file, dpi=30)

        patch.setattr(Figure, "savefig", save_small)
        assert main(["run", name, "--json", str(file), "--plot", str(folder)]) == 0
    text = file.read_text(encoding="utf-8")
    return Ran(name, printed.getvalue(), json.loads(text), folder, rows)


def test_run_prints_published_numbers_apart_with_deviation_and_place(ran: Ran):
    printed, own = ran.printed.split("Not published:")
    assert "quantity unit published computed deviation, % note" in " ".join(printed.split())
    assert "quantity unit computed note" in " ".join(own.split())
    for row in ran.rows:
        part = printed if row.published is not None or row.bounds else own
        (line,) = (x for x in part.splitlines() if x.startswith(f"{row.quantity} "))
        cells = line.removeprefix(row.quantity).split()
        assert cells[0] == row.unit
        assert f"{cells[-1]} {row.place}: {row.remark}" in ran.printed
        if part is own:
            assert float(cells[1]) == pytest.approx(row.computed, rel=1e-5)
            continue
        assert (", fitted" in line) == row.fitted
        if row.bounds:
            low, high = (x if x is not None else s for x, s in zip(row.bounds, (-1e99, 1e99)))  # noqa: B905
            assert ("not met" in line) == (not low <= row.computed <= high)
            assert "met" in line
        else:
            assert float(cells[1]) == row.published
            off = 100 * (row.computed - row.published) / row.published
            assert float(cells[3].rstrip(",")) == pytest.approx(off, abs=0.0051)
    for mark, text in MARKS.items():
        assert f"[{mark}] {text}" in ran.printed


def test_run_tells_the_error_against_the_run_time(ran: Ran):
    (line,) = [line for line in ran.printed.splitlines() if line.startswith("run time of")]
    found = re.findall(r"([\d.]+) ms, (\d+e-\d+) \(rtol (1e-\d+)\)", line)
    errors, tolerances = (np.array([float(row[k]) for row in found]) for k in (1, 2))
    assert len(found) == 3
    assert (np.diff(errors) < 0).all()
    assert (errors < 300 * tolerances).all()


def test_json_holds_every_number_with_its_mark_and_reason(ran: Ran):
    expected = [
        {
            "quantity": row.quantity,
            "unit": row.unit,
            "published": row.published,
            "bounds": None if row.bounds is None else list(row.bounds),
            "fitted": row.fitted,
            "computed": pytest.approx(row.computed, rel=1e-12),
            "mark": ran.json["rows"][i]["mark"],
            "place": row.place,
            "remark": row.remark,
        }
        for i, row in enumerate(ran.rows)
    ]
    assert ran.json == {"machine": ran.name, "marks": MARKS, "rows": expected}
    for row in ran.json["rows"]:
        assert re.findall(r"\[([PRIA])\]", row["place"]) == [row["mark"]]
        if row["bounds"]:
            assert row["mark"] == "P"
        if row["published"] is not None:
            assert row["mark"] == "P"
            off = abs(row["computed"] / row["published"] - 1)
            assert off < 5e-4 or row["remark"]


def test_plot_writes_the_files_it_names(ran: Ran):
    lines = ran.printed.splitlines()
    received = {Path(x.removeprefix("written: ")) for x in lines if x.startswith("written: ")}
    assert received
    assert received == set(ran.folder.iterdir())
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in received)


def test_unknown_machine_is_answered_with_the_nearest_name(capsys: pytest.CaptureFixture[str]):
    assert main(["run", "reversing_mil"]) == 2
    received = capsys.readouterr()
    assert received.out == ""
    assert "reversing_mil'" in received.err
    assert "reversing_mill" in received.err.partition("Nearest:")[2]


def test_a_folder_or_a_file_in_place_of_the_other_is_answered_with_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "taken"
    file.touch()
    for option, path in (("--json", tmp_path), ("--plot", file)):
        assert main(["run", "reversing_mill", option, str(path)]) == 2
        assert str(path) in capsys.readouterr().err


def test_a_parameter_is_changed_from_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "numbers.json"
    given = ["--set", "upper.motor.J=30", "--set", "lower.spindle.c = 100000 N.m/rad"]
    assert main(["run", "reversing_mill", *given, "--json", str(file)]) == 0
    printed = capsys.readouterr().out
    assert "upper.motor.J = 30.0, lower.spindle.c = 100000 N.m/rad" in printed
    found = json.loads(file.read_text(encoding="utf-8"))
    assert found["set"] == {"upper.motor.J": 30.0, "lower.spindle.c": "100000 N.m/rad"}
    measures = {row["quantity"]: row for row in found["measures"]}
    # the lower branch alone: two bodies and a spring
    rolls, drive = (0.16 + 0.0001) * 9.80665, (3.01 + 2.45) * 9.80665
    for key, c in (("unchanged", 0.918e4 * 9.80665), ("changed", 1e5)):
        expected = np.sqrt(c * (1 / rolls + 1 / drive)) / (2 * np.pi)
        received = [row[key] for name, row in measures.items() if name.startswith("gap open")]
        assert min(np.abs(np.array(received) / expected - 1)) < 1e-12


def test_a_changed_machine_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = tmp_path / "new"
    given = ["--set", "M_s=2000", "--plot", str(folder)]
    assert main(["run", "reversing_mill", *given]) == 0
    (file,) = folder.iterdir()
    assert f"written: {file}" in capsys.readouterr().out
    assert file.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("command", ["run", "report"])
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("upper.moto.J=30", "no parameter 'upper.moto.J'. Nearest: upper.motor.J"),
        ("upper.motor.J=-3", "upper.motor.J = -3 kg.m2 (moment of inertia)"),
        ("upper.motor.J=3 kg", "upper.motor.J = '3 kg': the unit must be of the kind kg.m2"),
        ("upper.motor.J=many", "upper.motor.J = 'many': a number in kg.m2"),
        ("gap.static=3", "'gap.static' is bound to an expression of other parameters"),
    ],
)
def test_a_change_that_is_not_understood_is_answered_with_path_and_value(
    command: str, given: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = ["-o", str(tmp_path / "page.html")] if command == "report" else []
    assert main([command, "reversing_mill", "--set", given, *file]) == 2
    received = capsys.readouterr()
    assert received.out == ""
    assert words in received.err


@pytest.mark.parametrize("given", ["upper.motor.J", "=3", "upper.motor.J="])
def test_a_change_without_path_or_value_is_answered_with_the_form(
    given: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as stopped:
        main(["run", "reversing_mill", "--set", given])
    assert stopped.value.code == 2
    assert "write PATH=VALUE, for example upper.motor.J=30" in capsys.readouterr().err


def test_missing_command_is_answered_with_the_usage(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        main([])
    assert stopped.value.code == 2
    assert "usage: lumped" in capsys.readouterr().err


def test_matplotlib_stays_unloaded_without_plots():
    code = (
        "import sys; from lumped.cli import main; main(['run', 'reversing_mill']); "
        "assert 'matplotlib' not in sys.modules"
    )
    python("-c", code)


OWN_PAGE = """
import lumped as lp
from lumped.components import Inertia, Torque

class Turned(lp.Component):
    drive: Torque = Torque(tau=3.0)
    body: Inertia = Inertia(J=2.0)

    def connections(self):
        yield from lp.chain(self.drive, self.body)

def explore(parameters):
    return {}
"""


def test_explore_opens_the_page_of_a_machine_and_ends_with_an_interrupt(tmp_path: Path):
    """Opened is what $BROWSER names: here a program that asks for the page."""
    asking = tmp_path / "asking.py"
    asking.write_text(
        "import pathlib, sys, urllib.request\n"
        "text = urllib.request.urlopen(sys.argv[1]).read().decode()\n"
        f"pathlib.Path({str(tmp_path / 'page.txt')!r}).write_text(text)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-m", "lumped", "explore", "pilger_mill", "--set", "shaft.J=3000"],
        env=os.environ | {"BROWSER": f"{sys.executable} {asking} %s"},
        stdout=subprocess.PIPE,
        text=True,
    ) as running:
        assert running.stdout is not None
        told = running.stdout.readline()
        assert re.fullmatch(
            r"Driven: open http://127\.0\.0\.1:\d+/ in a browser; Ctrl-C ends it\n", told
        )
        end = time.monotonic() + 60
        while not (tmp_path / "page.txt").exists() and time.monotonic() < end:
            time.sleep(0.05)
        running.send_signal(signal.SIGINT)
        assert running.wait(30) == 0
    assert "Driven - lumped" in (tmp_path / "page.txt").read_text()


@pytest.mark.parametrize(
    ("returned", "text"),
    [
        ("3.0", "returns a float; return what lumped.explore does"),
        ("lp.explore(Turned(), sliders=['body.q'])", "body.q"),
        ("lp.explore(Turned(), parameters=parameters)", "must be greater than 0"),
    ],
)
def test_explore_tells_what_is_wrong_with_a_page_of_ones_own(tmp_path, capsys, returned, text):
    file = tmp_path / "own.py"
    file.write_text(OWN_PAGE.format(returned))
    assert main(["explore", str(file), "--set", "body.J=-1"]) == 2
    assert text in capsys.readouterr().err


def test_explore_tells_what_is_missing(tmp_path, capsys):
    (tmp_path / "empty.py").write_text("")
    for name, text in (
        ("no_mill", "There is no machine 'no_mill'"),
        (str(tmp_path / "none.py"), "there is no file"),
        (str(tmp_path / "empty.py"), "has no function explore(parameters)"),
    ):
        assert main(["explore", name]) == 2
        assert text in capsys.readouterr().err


WRITTEN = """
from pathlib import Path

def report(path, parameters):
    {}

live = report
"""


@pytest.mark.parametrize(
    ("line", "code", "text"),
    [
        ("path.write_text('page')", 0, "written: {}"),
        ("Path(path).write_text('page'); return path", 0, "written: {}"),
        ("return str(path) + '.gone'", 2, "writes no page to '{}.gone'"),
        ("pass", 2, "writes no page to '{}'"),
        ("return 3.0", 2, "returns a float; return the path of the page"),
    ],
)
@pytest.mark.parametrize("live", [[], ["--live"]])
def test_a_function_of_ones_own_writes_its_page(tmp_path, capsys, line, code, text, live):
    file, page = tmp_path / "own.py", tmp_path / "page.html"
    file.write_text(WRITTEN.format(line))
    assert main(["report", str(file), "-o", str(page), *live]) == code
    printed = capsys.readouterr()
    assert text.format(page) in printed.out + printed.err
