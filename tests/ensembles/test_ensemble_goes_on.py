"""Ensembles that are interrupted, kept in files, spread over a cluster, or part of a sweep."""

import contextlib
import json
import operator
import os
import signal
import threading
import time

import numpy as np
import pytest
from interrupts import interrupting
from oscillator import UNTIL, C, closed_form, fussy, last

import lumped as lp
from lumped import functionals as fun
from lumped.ensembles.ensemble import EnsembleFile
from lumped.errors import OptionError, SolverError
from lumped.many_runs.native_runs import NativeRuns

MANY = np.linspace(50.0, 200.0, 600)
OF = {"x": fun.final("shaft.phi_rel"), "peak": fun.peak("shaft.tau")}


def ran(system, c=MANY, **options):
    return lp.ensemble(system, **{"over": {"shaft.c": c}, "until": UNTIL, "of": OF, **options})


@pytest.fixture(scope="module")
def whole(system):
    """An ensemble that nothing disturbs, right to its tolerance."""
    found = ran(system)
    error = np.abs(found["x"] - closed_form(MANY)).max()
    assert error < 1e-6
    return found


@pytest.fixture
def idle(monkeypatch):
    """Nothing may run."""

    def refuse(self, values):
        raise AssertionError(f"{len(values)} runs are made again")

    @contextlib.contextmanager
    def patched():
        with monkeypatch.context() as patch:
            patch.setattr(NativeRuns, "run", refuse)
            yield

    return patched


def assert_equal(one, other):
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.values, other.values)
    assert one.failures == other.failures


# -- interrupts ------------------------------------------------------------------------------------


def test_an_interrupt_keeps_what_is_done_and_the_file_goes_on(system, whole, idle, tmp_path):
    store = tmp_path / "runs.jsonl"
    with pytest.MonkeyPatch.context() as patch:
        chunks = interrupting(patch, 4)
        first = ran(system, workers=1, store=store)
    done = sum(chunks[:3])
    assert set(first.failures) == set(range(done, len(MANY)))
    assert set(first.failures.values()) == {"interrupted before it was run"}
    np.testing.assert_array_equal(first.values[:done], whole.values[:done])
    assert np.isnan(first.values[done:]).all()
    held = store.read_bytes()
    assert held.count(b"\n") == 1 + 3
    store.write_bytes(held + b'{"first": 48, "val')  # as if killed while writing
    with pytest.MonkeyPatch.context() as patch:
        again, run = [], NativeRuns.run
        patch.setattr(NativeRuns, "run", lambda self, v: again.append(len(v)) or run(self, v))
        second = ran(system, workers=2, store=store)
    assert sum(again) == len(MANY) - done
    assert_equal(second, whole)
    with idle():
        assert_equal(ran(system, store=store), whole)


def test_an_interrupt_ends_runs_in_the_middle(system):
    """Each of these runs would take minutes."""
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    begun = time.perf_counter()
    timer.start()
    found = ran(system, C, until=1e7, max_steps=10**12)
    spent = time.perf_counter() - begun
    assert 0.4 < spent < 5
    assert set(found.failures.values()) == {"interrupted before it was run"}
    assert len(found.failures) == len(C)


def test_an_interrupt_while_results_are_written_keeps_what_is_done(system, monkeypatch, tmp_path):
    add, calls = EnsembleFile.add, []

    def interrupted(self, which, batch):
        calls.append(len(which))
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        add(self, which, batch)

    monkeypatch.setattr(EnsembleFile, "add", interrupted)
    try:
        found = ran(system, workers=1, store=tmp_path / "runs.jsonl")
    except KeyboardInterrupt:
        pytest.fail("interrupted")
    assert 0 < len(found.failures) < len(MANY)


# -- files -----------------------------------------------------------------------------------------


def test_a_file_cut_anywhere_goes_on(system, whole, tmp_path):
    store = tmp_path / "runs.jsonl"
    assert_equal(ran(system, store=store), whole)
    held = store.read_bytes()
    lines = held.split(b"\n")
    for size in (0, 5, len(lines[0]), len(lines[0]) + 1, len(held) // 2, len(held) - 1):
        store.write_bytes(held[:size])
        assert_equal(ran(system, store=store), whole)
    with_gaps = [lines[0], *lines[1:-1][::-2], b""]
    store.write_bytes(b"\n".join(with_gaps))
    assert_equal(ran(system, store=store), whole)


def test_failures_are_kept_in_a_file_and_told_again(system, idle, tmp_path):
    store, c = tmp_path / "runs.jsonl", [1.0, 1e7, 4.0, 1e6]
    options = {"max_steps": 60, "store": store}
    first = ran(system, c, **options)
    assert sorted(first.failures) == [1, 3]
    with idle():
        assert_equal(ran(system, c, **options), first)


OTHERS = [
    ({"until": 0.8}, r"another time \(until = 0\.7 s, now 0\.8 s\)"),
    ({"c": MANY + 1}, "another choice of parameters"),
    ({"c": MANY[:-1]}, "another choice of parameters"),
    ({"rtol": 1e-5}, "another value of rtol"),
    ({"max_steps": 1000}, "another value of max_steps"),
    ({"begin": 0.1}, "another value of begin"),
    ({"start": {"body.w": 2.0}}, "another value of start"),
    ({"parameters": {"body.J": 2.0}}, "another value of parameters"),
    ({"method": "explicit"}, "another value of method"),
    ({"of": {**OF, "peak": fun.peak("body.w")}}, "another result 'peak'"),
    ({"of": {"x": OF["x"]}}, "another result 'peak'"),
]


@pytest.fixture(scope="module")
def kept(system, tmp_path_factory):
    """A file of an ensemble."""
    store = tmp_path_factory.mktemp("kept") / "runs.jsonl"
    ran(system, store=store)
    return store


@pytest.mark.parametrize(("options", "text"), OTHERS)
def test_a_file_of_other_runs_is_refused(system, kept, idle, options, text):
    held = kept.read_bytes()
    with idle(), pytest.raises(OptionError, match=r"runs\.jsonl holds runs of .*" + text):
        ran(system, store=kept, **options)
    assert kept.read_bytes() == held


def test_a_file_of_another_model_or_of_something_else_is_refused(system, kept, tmp_path):
    other = lp.assemble(system.model.with_({"body.w": 2.0}))
    with pytest.raises(OptionError, match="holds runs of another model"):
        ran(other, store=kept)
    swept, text = tmp_path / "swept.jsonl", tmp_path / "notes.txt"
    lp.sweep(system, over={"shaft.c": C}, until=UNTIL, of={"x": last}, store=swept, workers=1)
    text.write_text("measured\n1 2 3\n")
    for path in (swept, text):
        held = path.read_bytes()
        with pytest.raises(OptionError, match="holds something else than runs of ensemble"):
            ran(system, store=path)
        assert path.read_bytes() == held


def damaged(path, store, change):
    """A copy of a file whose third line is changed."""
    lines = store.read_text().split("\n")
    entry = json.loads(lines[2])
    lines[2] = change(lines[2], entry) or json.dumps(entry)
    path.write_text("\n".join(lines))
    return path


DAMAGES = {
    "half a line": lambda line, entry: line[: len(line) // 2],
    "a list": lambda line, entry: "[1, 2]",
    "no values": lambda line, entry: entry.pop("values") and None,
    "a number": lambda line, entry: entry.update(values=3.0),
    "few values": lambda line, entry: entry.update(values=entry["values"][:-8]),
    "no status": lambda line, entry: entry.update(status=""),
    "a word": lambda line, entry: entry.update(first="third"),
    "beyond all runs": lambda line, entry: entry.update(first=10**6),
    "before all runs": lambda line, entry: entry.update(first=-3),
}


@pytest.mark.parametrize("what", DAMAGES)
def test_a_damaged_line_is_refused_and_can_be_removed(system, whole, kept, tmp_path, what):
    store = damaged(tmp_path / "runs.jsonl", kept, DAMAGES[what])
    with pytest.raises(OptionError, match=r"line 3 of .*runs\.jsonl is damaged .*Remove this"):
        ran(system, store=store)
    lines = store.read_text().split("\n")
    store.write_text("\n".join(lines[:2] + lines[3:]))
    assert_equal(ran(system, store=store), whole)


def test_a_file_of_values_at_other_instants_is_refused(system, tmp_path):
    store = tmp_path / "runs.jsonl"
    one, other = ({"w": fun.at_time([0.1, 0.2, 0.3, t], "body.w")} for t in (0.4, 0.6))
    ran(system, of=one, store=store)
    with pytest.raises(OptionError, match="another result 'w'"):
        ran(system, of=other, store=store)


# -- a cluster -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def client():
    """That of a cluster of two processes."""
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def chunks(store):
    return store.read_bytes().count(b"\n") - 1


def test_a_cluster_of_two_processes_gives_the_same_bits_even_if_one_dies(
    system, whole, client, tmp_path
):
    assert_equal(ran(system, client=client, store=tmp_path / "runs.jsonl"), whole)
    assert_equal(ran(system, store=tmp_path / "runs.jsonl"), whole)
    shaft = system.model.shaft
    slack = {"of": {"slack": fun.integral(abs(shaft.tau) - shaft.c * 0.01)}}
    assert_equal(ran(system, client=client, **slack), ran(system, **slack))
    over = {"c": np.linspace(50.0, 200.0, 800), "until": 150.0}
    here = ran(system, **over)
    (victim, *_), store = client.run(os.getpid).values(), tmp_path / "long.jsonl"
    killed = []

    def kill():
        """As soon as there are results, and others to come."""
        while not store.exists() or chunks(store) < 3:
            time.sleep(0.005)
        os.kill(victim, signal.SIGKILL)
        killed.append(chunks(store))

    killer = threading.Thread(target=kill)
    killer.start()
    there = ran(system, client=client, store=store, **over)
    killer.join()
    assert killed[0] < chunks(store)
    assert_equal(there, here)


class Packed:
    """What is unpacked by a function."""

    def __init__(self, function, *arguments):
        self.parts = function, arguments

    def __reduce__(self):
        return self.parts


def fatal_once(flag):
    """What kills the first process of a worker in which it is unpacked."""
    lines = [
        "import os, signal",
        f"if os.getpid() != {os.getpid()} and not os.path.exists({str(flag)!r}):",
        f"    open({str(flag)!r}, 'w').close()",
        "    os.kill(os.getpid(), signal.SIGKILL)",
    ]
    return Packed(exec, "\n".join(lines))


def test_a_worker_of_a_cluster_may_die_while_it_is_given_the_model(
    system, whole, client, tmp_path, monkeypatch
):
    reduced = NativeRuns.__reduce__

    def first_fatal(runs):
        pair = fatal_once(tmp_path / "runs"), Packed(reduced(runs)[0], *reduced(runs)[1])
        return operator.itemgetter(1), (pair,)

    def measure(run):
        return run["shaft.phi_rel"][-1] + 0 * len(str(fatal))

    fatal = fatal_once(tmp_path / "sweep")
    monkeypatch.setattr(NativeRuns, "__reduce__", first_fatal)
    assert_equal(ran(system, client=client), whole)
    assert (tmp_path / "runs").exists()
    scene = {"over": {"shaft.c": C}, "until": UNTIL}
    there = lp.sweep(system, of={"x": measure}, client=client, **scene)
    assert (tmp_path / "sweep").exists()
    assert (there["x"] == lp.sweep(system, of={"x": last}, workers=1, **scene)["x"]).all()
    monkeypatch.setattr(NativeRuns, "__reduce__", lambda runs: (__import__, ("no_such_package",)))
    with pytest.raises(SolverError, match=r"cannot make the runs: .*no_such_package"):
        ran(system, client=client)


# -- sweeps ----------------------------------------------------------------------------------------


def test_a_sweep_takes_functionals_functions_and_both(system):
    given = {"over": {"shaft.c": C, "body.J": [1.0, 2.0]}, "until": UNTIL, "workers": 2}
    functional = fun.final("shaft.phi_rel")
    alone = lp.ensemble(system, of={"b": functional}, **given)
    only = lp.sweep(system, of={"b": functional}, **given)
    assert_equal(only, alone)
    function = lp.sweep(system, of={"a": last}, method="steps", **given)
    of = {"a": last, "b": functional, "c": lambda run: run["body.w"][-1], "d": OF["peak"]}
    both = lp.sweep(system, of=of, method="steps", **given)
    assert both.labels == ("a", "b", "c", "d")
    assert both.shape == (7, 2)
    peaks = lp.ensemble(system, of={"b": functional, "d": OF["peak"]}, **given)
    assert (both["b"] == peaks["b"]).all()  # where peaks are looked for, steps must be good inside
    assert (both["a"] == function["a"]).all()
    w = np.sqrt(both["shaft.c"] / both["body.J"])
    assert both["a"] == pytest.approx(np.sin(w * UNTIL) / w, abs=1e-5)
    assert both["c"] == pytest.approx(np.cos(w * UNTIL), abs=1e-5)
    assert both["d"] == pytest.approx(both["shaft.c"] / w, rel=1e-5)
    assert not both.failures


def test_a_sweep_of_both_tells_the_failures_of_each(system):
    of = {"a": fussy, "b": fun.final("body.w"), "c": fun.at_time(0.1, "body.a")}
    given = {"until": UNTIL, "method": "explicit", "max_steps": 1000, "workers": 1}
    found = lp.sweep(system, over={"shaft.c": [1.0, 160.0, 1e9]}, of=of, **given)
    assert set(found.failures) == {1, 2}
    assert found.failures[1] == "ValueError: too stiff for me"
    assert "max_steps = 1000" in found.failures[2]
    assert np.isnan(found.values).tolist() == [[False] * 3, [True, False, False], [True] * 3]


def test_what_a_sweep_of_functionals_cannot_do_is_refused(system, tmp_path):
    given = {"over": {"shaft.c": C}, "until": UNTIL}
    both = {**OF, "a": last}
    with pytest.raises(OptionError, match="functions or of functionals"):
        lp.sweep(system, of=both, store=tmp_path / "runs.jsonl", **given)


def test_a_sweep_of_functionals_has_the_file_of_their_ensemble(system, idle, tmp_path):
    given = {"over": {"shaft.c": C}, "until": UNTIL, "of": OF, "store": tmp_path / "runs.jsonl"}
    swept = lp.sweep(system, **given)
    with idle():
        assert_equal(lp.ensemble(system, **given), swept)
