"""Long work shows itself on a terminal, and what an interrupt leaves is kept."""

import functools
import gc
import io
import signal
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from interrupts import interrupt_before
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import BearingFriction, CrankSlider, Inertia, Spring, SwingingMass, Torque
from lumped.errors import Interrupted, OptionError
from lumped.ops import where
from lumped.support import progress
from lumped.timeloop.plants.executable import Executable
from lumped.timeloop.results.recorder import Recorder


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    screen = Terminal()
    monkeypatch.setattr(progress, "sys", SimpleNamespace(stderr=screen))
    monkeypatch.setattr(progress, "_FIRST", 0.0)
    monkeypatch.setattr(progress, "_EVERY", 0.0)
    return screen


def slider():
    return assemble_row(
        wheel=Inertia(J=1.0, w=20.0),
        shaft=Spring(c=100.0),
        disc=Inertia(J=0.1),
        crank=CrankSlider(r=0.1, L=0.4, m=2.0),
    )


def test_a_run_says_how_far_it_is_and_takes_the_line_away(terminal):
    run = lp.simulate(slider(), until=20.0)
    written = terminal.getvalue()
    assert "Model: " in written
    assert " left" in written
    assert written.endswith("\r")
    assert run.t[-1] == 20.0


def test_a_sweep_shows_itself_and_not_its_runs(terminal):
    lp.sweep(
        slider(),
        over={"shaft.c": np.linspace(50, 90, 4)},
        until=2.0,
        of={"x": lambda run: run["wheel.w"][-1]},
        workers=1,
    )
    written = terminal.getvalue()
    assert "Model: runs: 100 %" in written
    assert "Model: 100 %" not in written


def test_it_is_quiet_where_nobody_looks(capsys, monkeypatch):
    monkeypatch.setattr(progress, "_FIRST", 0.0)
    lp.simulate(slider(), until=5.0)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("seconds", "text"), [(3.2, "3 s"), (600.0, "10 min"), (7200.0 * 2, "4.0 h")]
)
def test_time_is_spoken(seconds, text):
    assert progress._format_time(seconds) == text


def test_an_interrupted_run_keeps_what_it_computed(monkeypatch):
    system, add = slider(), Recorder.add
    lp.simulate(system, until=0.1)
    # steps between two looks at what was computed
    monkeypatch.setattr(Executable, "attempts", 20)

    def interrupting(self, t, *rest):
        add(self, t, *rest)
        if len(t) and t[-1] > 1.0:
            signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(Recorder, "add", interrupting)
        with pytest.raises(Interrupted, match=r"interrupted at t = ") as caught:
            lp.simulate(system, until=100.0, grid=20_000)
    part = caught.value.partial
    assert 1.0 < part.t[-1] < 100.0
    again = lp.simulate(system, until=float(part.t[-1]) + 1.0, grid=part.t[:50])
    assert part["wheel.w"][:50] == pytest.approx(again["wheel.w"], rel=1e-6)
    assert isinstance(caught.value, KeyboardInterrupt)


def braked():
    return assemble_rows(
        "drive body",
        "drive rub",
        "drive arm",
        drive=Torque(tau=where(lp.time >= 0.3, 1.0, 2.0)),
        body=Inertia(J=1.0, w=1.0),
        rub=BearingFriction(characteristic=((0.0, 0.5),)),
        arm=SwingingMass(m=1.0, R=0.4),
    )


def interrupted_at(line, system, **options):
    """What a run gives that is interrupted before the line of this number, and how many it has."""

    def is_ours(code):
        file = code.co_filename
        return "lumped" in file and not (code.co_name == "run" and file.endswith("simulate.py"))

    return interrupt_before(line, is_ours, functools.partial(lp.simulate, system, **options))


@pytest.mark.parametrize("certify", [False, True])
def test_an_interrupt_is_told_wherever_it_comes(certify):
    """Before any line of ours, from the first one on; what is left of the run can be read."""
    options = {"until": 0.5, "method": "steps", "grid": 10, "certify": certify}
    system, lines, empty, some = braked(), 0, 0, 0
    for _ in range(4):  # what is made once is made
        run, lines = interrupted_at(-1, system, **options)
    assert isinstance(run, lp.Trajectory)
    places = np.unique(np.geomspace(1, lines - 1, 60).astype(int)).tolist()
    for line in places:
        error, _ = interrupted_at(line, system, **options)
        assert isinstance(error, Interrupted), line
        part = error.partial
        assert repr(part)
        empty += not len(part.t)
        some += len(part.t) > 0
        assert (part["body.w"] == run["body.w"][: len(part.t)]).all()
        assert part.statistics.why
    del error
    gc.collect()
    assert not progress._open
    print(f"{len(places)} places of {lines}: {empty} before, {some} with a part of the run")
    assert empty
    assert some


def test_an_empty_run_says_that_it_is_empty(monkeypatch, tmp_path):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    system = braked()
    monkeypatch.setattr(import_module("lumped.simulation.simulate"), "run_start", interrupted)
    with pytest.raises(Interrupted, match="Model: interrupted before the run began") as caught:
        lp.simulate(system, until=1.0)
    part = caught.value.partial
    assert repr(part) == "Model: nothing was computed"
    assert part.t.shape == part["body.w"].shape == (0,)
    for asked in (lambda: part.point(0.0), part.plot):
        with pytest.raises(OptionError, match="nothing was computed"):
            asked()
    for ending in ("nc", "npz", "csv"):
        assert lp.load(part.save(tmp_path / f"part.{ending}"))["body.w"].shape == (0,)
