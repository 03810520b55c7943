"""Many runs against single ones and a closed form, with failures, deaths and interrupts."""

import json
import os
import signal
import threading

import numpy as np
import pytest
from oscillator import C, closed_form, fussy, last
from rows import in_a_row

import lumped as lp
from lumped.components import Fixed, Spring, SwingingMass
from lumped.errors import OptionError, UnknownNameError
from lumped.support.process_lock import process_lock

J = np.array([0.5, 1.0, 4.0])


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_a_grid_agrees_with_the_closed_form_whoever_works(system, workers):
    over = {"shaft.c": C, "body.J": J}
    found = lp.sweep(system, over=over, until=0.7, of={"x": last}, workers=workers, rtol=1e-10)
    expected = closed_form(C[:, None], J[None, :])
    assert found.shape == (7, 3)
    error = np.abs(found["x"].reshape(found.shape) - expected).max()
    assert error < 1e-9
    assert not found.failures
    alone = lp.simulate(system, until=0.7, rtol=1e-10, parameters={"shaft.c": 75.0, "body.J": 4.0})
    assert found["x"][5] == last(alone)
    frame = found.to_pandas()
    assert (frame["body.J"].to_numpy() == found["body.J"]).all()


def test_processes_are_forked_while_no_thread_builds(system):
    """In a process that is forked, the lock of a thread that builds would stay closed."""
    over, ended = threading.Event(), threading.Event()

    def build():
        while not over.is_set():
            with process_lock:
                ended.wait(0.02)

    builder = threading.Thread(target=build, daemon=True)
    builder.start()
    try:
        found = lp.sweep(system, over={"shaft.c": C}, until=0.7, of={"x": last}, workers=2)
    finally:
        over.set()
        builder.join()
    assert not found.failures
    assert found["x"] == pytest.approx(closed_form(C, 1.0), abs=1e-4)


@pytest.mark.parametrize("count", [6, 30])
def test_results_are_the_same_to_the_last_bit_whoever_works(count):
    """Few runs are made without machine code, many with it; never some with and some without."""
    model = in_a_row(ground=Fixed(), shaft=Spring(c=100.0), arm=SwingingMass(m=1.0, R=0.4))
    system = lp.assemble(model.with_({"arm.w": 3.0}))
    over = {"shaft.c": np.linspace(20.0, 90.0, count)}
    found = [
        lp.sweep(system, over=over, until=3.0, of={"x": last}, workers=n)["x"] for n in (2, 1, 3)
    ]
    assert (found[0] == found[1]).all()
    assert (found[0] == found[2]).all()
    run = lp.simulate(system, until=3.0, rtol=1e-10, parameters={"shaft.c": 20.0})
    assert found[0][0] == pytest.approx(last(run), abs=1e-5)


def test_failures_are_set_apart_with_their_reason(system):
    points = [{"shaft.c": c} for c in (100.0, 1e9, 200.0, 50.0)]
    options = {"method": "explicit", "max_steps": 1000, "workers": 2}
    found = lp.sweep(system, over=points, until=0.7, of={"x": fussy}, **options)
    assert set(found.failures) == {1, 2}
    assert "max_steps = 1000" in found.failures[1]
    assert "ValueError: too stiff for me" in found.failures[2]
    assert np.isfinite(found["x"]).tolist() == [True, False, False, True]
    assert "2 failed" in repr(found)


def test_a_process_that_dies_takes_no_other_run_along(system):
    def deadly(run):
        if 120 < run.theta.max() < 130:
            os._exit(7)
        return last(run)

    found = lp.sweep(system, over={"shaft.c": C}, until=0.7, of={"x": deadly}, workers=2)
    assert list(found.failures) == [3]
    assert "died" in found.failures[3]
    good = np.delete(found["x"], 3)
    assert good == pytest.approx(np.delete(closed_form(C, 1.0), 3), rel=1e-4)


def test_an_interrupt_keeps_what_is_done_and_the_file_goes_on(system, tmp_path):
    store, notes = tmp_path / "runs.jsonl", tmp_path / "calls"
    notes.touch()

    def calls():
        return notes.stat().st_size

    def interrupting(run):
        notes.write_text("x" * (calls() + 1))
        if calls() == 4:
            signal.raise_signal(signal.SIGINT)
        return last(run)

    of = {"x": interrupting}
    first = lp.sweep(system, over={"shaft.c": C}, until=0.7, of=of, workers=1, store=store)
    assert [i for i, why in first.failures.items() if "interrupted" in why] == [3, 4, 5, 6]
    with store.open("a") as file:
        file.write('{"point": {"shaft.c": 1')  # as if killed while writing
    second = lp.sweep(system, over={"shaft.c": C}, until=0.7, of=of, workers=1, store=store)
    assert calls() == 4 + 4
    assert not second.failures
    assert second["x"] == pytest.approx(closed_form(C, 1.0), rel=1e-4)
    third = lp.sweep(system, over={"shaft.c": C}, until=0.7, of=of, workers=1, store=store)
    assert calls() == 8
    assert (third["x"] == second["x"]).all()
    assert len(json.loads(store.read_text().splitlines()[0])["parameters"]) > 0
    with pytest.raises(OptionError, match=r"another time \(until = 0\.7 s, now 0\.8 s\)"):
        lp.sweep(system, over={"shaft.c": C}, until=0.8, of=of, store=store)


def test_bad_input_is_refused(system):
    with pytest.raises(OptionError, match="nothing to vary"):
        lp.sweep(system, over={}, until=1.0, of={"x": last})
    with pytest.raises(OptionError, match="what to take"):
        lp.sweep(system, over={"shaft.c": [1.0]}, until=1.0, of={})
    with pytest.raises(UnknownNameError, match=r"shaft\.k"):
        lp.sweep(system, over={"shaft.k": [1.0]}, until=1.0, of={"x": last})
    with pytest.raises(OptionError, match="same parameters"):
        lp.sweep(system, over=[{"shaft.c": 1.0}, {"body.J": 1.0}], until=1.0, of={"x": last})
    with pytest.raises(OptionError, match=r"there is no 'y'.*shaft\.c, x"):
        lp.sweep(system, over={"shaft.c": [1.0]}, until=0.1, of={"x": last}, workers=1)["y"]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"parametrs": {}}, "no option 'parametrs'. Nearest: parameters"),
        ({"parameters": [1.0]}, r"parameters = \[1.0\]: a dictionary"),
        ({"client": 5}, "client = 5: a client from dask.distributed"),
    ],
)
def test_options_are_refused_before_the_first_run(system, options, text):
    with pytest.raises(OptionError, match=text):
        lp.sweep(system, over={"shaft.c": C}, until=0.7, of={"x": last}, **options)


@pytest.mark.parametrize("value", ["fast", None, 1j, [1.0, 2.0], np.zeros(3)])
def test_what_is_no_number_is_told_with_its_name(system, value):
    found = lp.sweep(
        system, over={"shaft.c": C[:1]}, until=0.1, of={"peak": lambda run: value}, workers=1
    )
    assert "of['peak'] gave" in found.failures[0]
    assert "a number is needed" in found.failures[0]
