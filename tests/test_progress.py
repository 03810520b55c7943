"""Long work shows itself on a terminal, and what an interrupt leaves is kept."""

import io
import signal
import threading
from types import SimpleNamespace

import numpy as np
import pytest

import lumped as lp
from lumped import progress
from lumped.components import CrankSlider, Inertia, Spring
from lumped.errors import Interrupted


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
    model = lp.compose(
        wheel=Inertia(J=1.0, w=20.0),
        shaft=Spring(c=100.0),
        disc=Inertia(J=0.1),
        crank=CrankSlider(r=0.1, L=0.4, m=2.0),
        connections=lambda m: [
            *lp.chain(m.wheel, m.shaft, m.disc),
            lp.connect(m.disc.flange_b, m.crank.flange),
        ],
    )
    return lp.assemble(model)


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
    assert progress._spoken(seconds) == text


def test_an_interrupted_run_keeps_what_it_computed():
    system = slider()
    lp.simulate(system, until=0.1)
    timer = threading.Timer(0.6, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(Interrupted, match=r"interrupted at t = ") as caught:
        lp.simulate(system, until=1e5, grid=20_000_000, max_steps=10**9)
    part = caught.value.partial
    assert 0 < part.t[-1] < 1e5
    again = lp.simulate(system, until=float(part.t[-1]) + 1.0, grid=part.t[:50])
    assert part["wheel.w"][:50] == pytest.approx(again["wheel.w"], rel=1e-6)
    assert isinstance(caught.value, KeyboardInterrupt)
