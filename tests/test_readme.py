"""What the README and the winch of the page on clutches show is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def executed(*blocks):
    names = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    return names


def test_a_new_users_script_has_at_most_25_lines_and_agrees_with_a_matrix_exponential(
    tmp_path, monkeypatch, capsys
):
    (script,) = BLOCKS
    assert len(script.strip().splitlines()) <= 25
    monkeypatch.chdir(tmp_path)
    names = executed(script)
    assert (tmp_path / "start_up.png").stat().st_size > 10_000
    assert "natural frequency, Hz" in capsys.readouterr().out
    # speeds of motor, middle and load, and the two twists; shaft 1 turns with 4 w_middle at b
    J = np.diag([0.05, 0.3, 6.0])
    twist = np.array([[-1.0, 4.0, 0.0], [0.0, -1.0, 3.0]])
    c, d = np.diag([8e3, 5e4]), np.diag([0.5, 5.0])
    inverse = np.linalg.inv(J)
    brake = np.diag([0.0, 0.0, 12.0])
    a = np.zeros((6, 6))
    a[:3, :3] = -inverse @ (twist.T @ d @ twist + brake)
    a[:3, 3:5] = -inverse @ twist.T @ c
    a[3:5, :3] = twist
    a[:3, 5] = inverse @ [40.0, 0.0, 0.0]
    run = names["run"]
    for t in (0.15, 0.5, 1.0):
        i = int(np.abs(run.t - t).argmin())
        state = expm(a * (run.t[i] - 0.1))[:, 5]
        received = [run[n][i] for n in ("motor.w", "middle.w", "load.w")]
        assert np.array(received) == pytest.approx(state[:3], rel=1e-4)
    values = np.linalg.eigvals(a[:5, :5])
    expected = np.sort(np.abs(values[values.imag > 0])) / (2 * np.pi)
    assert names["lp"].modes(names["system"]).hertz == pytest.approx(expected, rel=1e-10)


def test_the_table_of_machines_is_what_they_print_and_compute(machine_rows):
    table = README.partition("| machine |")[2].partition("\n\n")[0]
    shown = re.findall(r"machines/(\w+)\.md\) \| (.*?) \| ([\d.]+).*? \| ([\d.]+).*? \|", table)
    assert len(shown) == 4
    for name, quantity, published, computed in shown:
        digits = len(computed.partition(".")[2])
        found = {
            (row.published, round(row.computed, digits))
            for row in machine_rows(name)
            if row.published
        }
        assert (float(published), float(computed)) in found, quantity


def test_the_rows_on_performance_are_those_of_one_run_of_the_benchmark(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    from benchmarks.report import front_page

    assert front_page.table() in README, "python -m benchmarks writes them"


def test_the_winch_slips_and_locks_as_friction_torques_say():
    page = (ROOT / "docs" / "elements" / "clutch.md").read_text(encoding="utf-8")
    events = executed(*re.findall(r"```python\n(.*?)```", page, re.DOTALL))["hoisting"].events
    changes = [(e.time, e.component, e.after) for e in events if " " not in e.after]
    # the drum falls for 0.2 s, then the clutch takes 200 N.m from motor and drum
    w = -30.0 / 3.0 * 0.2
    locked = 0.5 + (150.0 - w) / (200.0 / 0.2 + 170.0 / 3.0)
    expected = [(0.3, "brake", "free"), (0.5, "clutch", "backward"), (locked, "clutch", "stuck")]
    received = [change for change in changes if change[2]]
    assert [change[1:] for change in received] == [change[1:] for change in expected]
    times = [change[0] for change in expected]
    assert [change[0] for change in received] == pytest.approx(times, rel=1e-9)
