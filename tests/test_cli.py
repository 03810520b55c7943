"""The command as a user types it."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lumped.cli import main
from lumped.models import MACHINES, MARKS, machine


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


@pytest.mark.parametrize("name", MACHINES)
def test_run_prints_every_number_with_its_deviation_and_place(
    name: str, capsys: pytest.CaptureFixture[str]
):
    assert main(["run", name]) == 0
    received = capsys.readouterr().out
    head = "quantity unit published computed deviation, % note"
    assert head in " ".join(received.split())
    for row in machine(name).rows():
        (line,) = (x for x in received.splitlines() if x.startswith(f"{row.quantity} "))
        cells = line.removeprefix(row.quantity).split()
        deviation = "-"
        if row.published is not None:
            deviation = f"{100 * (row.computed - row.published) / row.published:+.2f}"
        expected = [row.unit, cells[1], f"{row.computed:.6g}", deviation]
        assert cells[:-1] == expected
        assert f"{cells[-1]} {row.place}: {row.remark}" in received


@pytest.mark.parametrize("name", MACHINES)
def test_json_holds_every_number_with_its_mark_and_reason(name: str, tmp_path: Path):
    file = tmp_path / "numbers.json"
    assert main(["run", name, "--json", str(file)]) == 0
    received = json.loads(file.read_text())
    expected = [
        {
            "quantity": row.quantity,
            "unit": row.unit,
            "published": row.published,
            "computed": pytest.approx(row.computed, rel=1e-12),
            "mark": received["rows"][i]["mark"],
            "place": row.place,
            "remark": row.remark,
        }
        for i, row in enumerate(machine(name).rows())
    ]
    assert received == {"machine": name, "marks": MARKS, "rows": expected}
    for row in received["rows"]:
        assert re.findall(r"\[([PRIA])\]", row["place"]) == [row["mark"]]
        if row["published"] is not None:
            assert row["mark"] == "P"
            off = abs(row["computed"] / row["published"] - 1)
            assert off < 5e-4 or row["remark"]


@pytest.mark.parametrize("name", MACHINES)
def test_plot_writes_the_files_it_names(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder = tmp_path / "new" / "figures"
    assert main(["run", name, "--plot", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    received = {Path(x.removeprefix("written: ")) for x in lines if x.startswith("written: ")}
    assert received
    assert received == set(folder.iterdir())
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
