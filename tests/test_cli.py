"""The command as a user types it."""

import io
import json
import re
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest

from lumped.cli import main
from lumped.models import MACHINES, MARKS, Row, machine


def python(*arguments: str) -> str:
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


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
def ran(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    name = request.param
    folder = tmp_path_factory.mktemp(name) / "new" / "figures"
    file = folder.parent.parent / "numbers.json"
    # machine code, which runs use once it pays, differs by rounding
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
        patch.setenv("LUMPED_NATIVE", "0")
        assert main(["run", name, "--json", str(file), "--plot", str(folder)]) == 0
        rows = machine(name).rows()
    text = file.read_text(encoding="utf-8")
    return Ran(name, printed.getvalue(), json.loads(text), folder, rows)


def test_run_prints_every_number_with_its_deviation_and_place(ran: Ran):
    head = "quantity unit published computed deviation, % note"
    assert head in " ".join(ran.printed.split())
    for row in ran.rows:
        (line,) = (x for x in ran.printed.splitlines() if x.startswith(f"{row.quantity} "))
        cells = line.removeprefix(row.quantity).split()
        deviation = "-"
        if row.published is not None:
            deviation = f"{100 * (row.computed - row.published) / row.published:+.2f}"
        expected = [row.unit, cells[1], f"{row.computed:.6g}", deviation]
        assert cells[:-1] == expected
        assert f"{cells[-1]} {row.place}: {row.remark}" in ran.printed
    for mark, text in MARKS.items():
        assert f"[{mark}] {text}" in ran.printed


def test_json_holds_every_number_with_its_mark_and_reason(ran: Ran):
    expected = [
        {
            "quantity": row.quantity,
            "unit": row.unit,
            "published": row.published,
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


def test_unwritable_file_is_answered_with_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(["run", "reversing_mill", "--json", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err


def test_file_in_place_of_the_plot_folder_is_answered_with_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    file = tmp_path / "taken"
    file.touch()
    assert main(["run", "reversing_mill", "--plot", str(file)]) == 2
    assert str(file) in capsys.readouterr().err


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
