"""What the README shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

README = (Path(__file__).parents[1] / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
TEXTS = re.findall(r"```text\n(.*?)```", README, re.DOTALL)


def executed(*blocks):
    names = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    return names


def test_the_first_rig_prints_what_stands_there_and_the_textbook_frequency(capsys):
    names = executed(BLOCKS[0])
    assert capsys.readouterr().out.strip() == TEXTS[0].strip()
    expected = np.sqrt(2000 * (1 / 0.02 + 9 / 1.5)) / (2 * np.pi)
    assert names["lp"].modes(names["system"]).hertz == pytest.approx([expected], rel=1e-12)
    assert f"{expected:.7f}" in README


def test_a_new_users_script_has_at_most_25_lines_and_agrees_with_a_matrix_exponential(
    tmp_path, monkeypatch, capsys
):
    script = BLOCKS[1]
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
        error = np.abs(np.array(received) / state[:3] - 1).max()
        print(f"t = {t} s: relative error of the speeds {error:.1e}")
        assert error < 1e-4
    values = np.linalg.eigvals(a[:5, :5])
    expected = np.sort(np.abs(values[values.imag > 0])) / (2 * np.pi)
    assert names["lp"].modes(names["system"]).hertz == pytest.approx(expected, rel=1e-10)


def test_the_further_examples_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = executed(*BLOCKS[1:])
    # steady: 40 N.m through 12:1 against 12 N.m.s/rad
    assert names["steady"]["load.w"] == pytest.approx(40.0 * 12 / 12, rel=1e-9)
    # 60 rad/s are 5 at the load
    assert names["rated"].parameters["brake.d"] == pytest.approx(40.0 * 12 / 5, rel=1e-9)
    assert names["quicker"]["load.w"][-1] > names["run"]["load.w"][-1]
    lp = names["lp"]
    from lumped.components import Inertia

    model = lp.compose(
        a=Inertia(J=1.0, w=2.0),
        gear=names["EllipticalGear"](e=0.3),
        b=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.a, m.gear, m.b),
    )
    # at phi = 0 the ratio is -(1 + e)/(1 - e)
    assert lp.start_point(lp.assemble(model))["b.w"] == pytest.approx(-2.0 * 1.3 / 0.7, rel=1e-12)


def test_the_error_shown_is_the_error_raised():
    import lumped as lp
    from lumped.components import Fixed, Inertia, Spring
    from lumped.errors import SingularModelError

    class Bench(lp.Component):
        """Two supports on one shaft: phi = 0."""

        wall: Fixed = Fixed()
        wall2: Fixed = Fixed()
        shaft: Spring = Spring(c=1.0)
        body: Inertia = Inertia(J=1.0)

        def connections(self):
            yield lp.connect(self.wall.flange, self.wall2.flange, self.shaft.flange_a)
            yield from lp.chain(self.shaft, self.body)

    with pytest.raises(SingularModelError) as caught:
        lp.assemble(Bench())
    received = f"SingularModelError: {caught.value}"
    assert received.strip() == TEXTS[1].strip()


def test_the_winch_slips_and_locks_as_friction_torques_say():
    block = next(block for block in BLOCKS if "Winch" in block)
    events = executed("import lumped as lp", block)["hoisting"].events
    changes = [(e.time, e.component, e.after) for e in events if " " not in e.after]
    # the drum falls for 0.2 s, then the clutch takes 200 N.m from motor and drum
    w = -30.0 / 3.0 * 0.2
    locked = 0.5 + (150.0 - w) / (200.0 / 0.2 + 170.0 / 3.0)
    expected = [(0.3, "brake", "free"), (0.5, "clutch", "backward"), (locked, "clutch", "stuck")]
    received = [change for change in changes if change[2]]
    assert [change[1:] for change in received] == [change[1:] for change in expected]
    times = [change[0] for change in expected]
    assert [change[0] for change in received] == pytest.approx(times, rel=1e-9)
