"""A sweep goes on from its own file only, and says what is wrong with another one."""

import functools
import json
import math
import pickle
import subprocess
import sys

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Clutch, ElastoBacklash, Fixed, Inertia, Torque
from lumped.ensembles.sweep import Job
from lumped.errors import OptionError, ParameterError, UnitError
from lumped.ops import table, where
from lumped.timeloop.results.fingerprint import fingerprint


def drum_speed(run):
    return run["drum.w"][-1]


def winch(closes=0.5, rows=((0.0, 0.5),), w=150.0, torque=0.0, **parts):
    """A drum at rest that a clutch of 20 N.m joins to a motor at 150 rad/s."""
    return lp.compose(
        load=Torque(tau=torque),
        motor=Inertia(J=0.2, w=w),
        clutch=Clutch(f_max=40.0, characteristic=rows, u=where(lp.time >= closes, 1.0, 0.0)),
        drum=Inertia(J=3.0, w=0.0),
        connections=lambda m: lp.chain(m.load, m.motor, m.clutch, m.drum),
        **parts,
    )


OVER = {"drum.J": [2.0, 3.0]}


def swept(model, store=None, of=drum_speed, until=1.0, **options):
    system = lp.assemble(model)
    found = lp.sweep(
        *(system,), over=OVER, until=until, of={"w": of}, workers=1, store=store, **options
    )
    return found["w"]


def test_another_switching_instant_does_not_take_the_runs_from_the_file(tmp_path):
    """The clutch slips at 20 N.m from the instant at which it closes: w = 20 (1 - t) / J."""
    store = tmp_path / "runs.jsonl"
    early = swept(winch(0.5), store)
    assert early == pytest.approx([5.0, 10 / 3], rel=1e-5)
    with pytest.raises(OptionError, match=r"runs\.jsonl holds runs of another model"):
        swept(winch(0.9), store)
    late = swept(winch(0.9), tmp_path / "late.jsonl")
    assert late == pytest.approx([1.0, 2 / 3], rel=1e-5)
    assert (swept(winch(0.5), store) == early).all()


@pytest.mark.parametrize(
    "other",
    [
        {"closes": 0.6},
        {"rows": ((0.0, 0.5), (1.0, 0.2))},
        {"rows": ((0.0, 0.5000000001),)},
        {"w": 150.0000001},
        {"torque": table([0.0, 1.0], [0.0, 1.0])},
        {"aside": Inertia(J=1.0)},
    ],
)
def test_whatever_changes_a_number_changes_the_fingerprint(other):
    assert fingerprint(lp.assemble(winch(**other))) != fingerprint(lp.assemble(winch()))


def test_a_table_in_its_tenth_digit_changes_the_fingerprint():
    marks = {
        fingerprint(lp.assemble(winch(torque=table([0.0, 1.0], [0.0, last]))))
        for last in (1.0, 1.0 + 1e-10, 1.0 + 2e-10)
    }
    assert len(marks) == 3


def test_equal_models_have_equal_fingerprints_in_every_process():
    code = (
        "import lumped as lp\n"
        "from lumped.timeloop.results.fingerprint import fingerprint\n"
        "from lumped.models.reversing_mill import *\n"
        "from lumped.components import *\n"
        "m = lp.compose(a=Inertia(J=1.0), s=Spring(c=2.0), b=Inertia(J=1.0),\n"
        "    connections=lambda m: lp.chain(m.a, m.s, m.b))\n"
        "print(fingerprint(lp.assemble(m)), fingerprint({'x': lambda run: {1, 'b', run}}))\n"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(found) == 1


def measures():
    """Functions that give different numbers, though some look alike."""

    def of(factor, kind=abs):
        return lambda run: kind(run["drum.w"][-1]) * factor

    def calling(inner):
        def outer(run):
            return inner(run) + 1

        return outer

    rows = np.arange(3.0)
    return {
        "number": of(2.0),
        "another number": of(2.5),
        "another kind": of(2.0, np.sign),
        "calls": calling(of(2.0)),
        "calls another": calling(of(2.5)),
        "array": lambda run: run["drum.w"][-1] @ rows,
        "another array": functools.partial(lambda rows, run: run["drum.w"][-1] @ rows, rows + 1),
        "default": lambda run, at=-1: run["drum.w"][at],
        "another default": lambda run, at=-2: run["drum.w"][at],
        "global": lambda run: drum_speed(run),
        "object": Scaled(2.0),
        "another object": Scaled(2.5),
        "method": Scaled(2.0).twice,
        "library": np.max,
        "another of the library": np.min,
    }


class Scaled:
    def __init__(self, factor):
        self.factor = factor

    def __call__(self, run):
        return self.factor * run["drum.w"][-1]

    def twice(self, run):
        return 2 * self(run)


def test_functions_are_told_apart_by_what_they_compute():
    one, two = measures(), measures()
    marks = {name: fingerprint(function) for name, function in one.items()}
    assert len(set(marks.values())) == len(marks)
    assert marks == {name: fingerprint(function) for name, function in two.items()}


def test_a_function_that_calls_itself_has_a_fingerprint():
    def factorial(n, last=1):
        return last if n < 1 else n * factorial(n - 1, last)

    def other(n, last=2):
        return last if n < 1 else n * other(n - 1, last)

    assert fingerprint(factorial) == fingerprint(factorial) != fingerprint(other)


def test_what_cannot_be_compared_is_refused(tmp_path):
    with (tmp_path / "log").open("w") as log:

        def noting(run):
            print(run, file=log)
            return 1.0

        with pytest.raises(OptionError, match=r"TextIOWrapper has no content that can be compared"):
            swept(winch(), tmp_path / "runs.jsonl", noting)


def test_another_function_option_or_parameter_is_named(tmp_path):
    store = tmp_path / "runs.jsonl"
    swept(winch(), store, rtol=1e-5)
    for change, what in (
        ({"of": lambda run: run["motor.w"].max()}, r"another result 'w' \(the function"),
        ({"rtol": 1e-6}, r"another value of rtol"),
        ({"rtol": 1e-5, "atol": 1e-9}, r"another value of atol"),
        ({"rtol": 1e-5, "grid": np.linspace(0, 1.0, 1201)}, r"another value of grid"),
    ):
        with pytest.raises(OptionError, match=rf"holds runs of {what}"):
            swept(winch(), store, **{"rtol": 1e-5} | change)
    dearer = winch().with_({"motor.J": 0.3})
    with pytest.raises(OptionError, match=r"another value of motor\.J"):
        swept(dearer, store, rtol=1e-5)


def test_long_output_times_that_print_alike_are_told_apart():
    times = np.linspace(0.0, 1.0, 5000)
    moved = times.copy()
    moved[2500] += 1e-9
    assert repr(times) == repr(moved)
    assert fingerprint(times) != fingerprint(moved)


@pytest.mark.parametrize("text", ["no json", '{"a": 1}\n', "[1]\n", "\x00\x01", '{"lumped": 1}\n'])
def test_a_foreign_file_is_refused_and_left_alone(tmp_path, text):
    store = tmp_path / "runs.jsonl"
    store.write_text(text)
    with pytest.raises(OptionError, match=r"runs\.jsonl holds something else than runs"):
        swept(winch(), store)
    assert store.read_text() == text


@pytest.mark.parametrize(
    "line",
    [
        '{"point": {"drum.J": 2.0}, "values": null}',
        '{"point": {"drum.J": 2.0}, "values": [1.0, 2.0]}',
        '{"point": {"drum.J": 2.0}, "values": ["x"]}',
        '{"point": {"drum.J": 2.0}}',
        '{"point": {"drum.J": 2.0}, "val',
        '{"point": [2.0], "values": [1.0]}',
        "7",
    ],
)
def test_a_damaged_line_is_named(tmp_path, line):
    store = tmp_path / "runs.jsonl"
    swept(winch(), store)
    head, _, second = store.read_text().splitlines()
    store.write_text("\n".join([head, line, second]) + "\n")
    with pytest.raises(OptionError, match=r"line 2 of .*runs\.jsonl is damaged"):
        swept(winch(), store)


@pytest.mark.parametrize("kept", [0, 5, 17, 60])
def test_a_file_cut_off_in_its_first_line_begins_anew(tmp_path, kept):
    store = tmp_path / "runs.jsonl"
    whole = swept(winch(), store)
    store.write_bytes(store.read_bytes()[:kept])
    assert (swept(winch(), store) == whole).all()
    assert len(store.read_text().splitlines()) == 3


def test_results_that_are_no_numbers_say_so_and_come_back_from_the_file(tmp_path):
    store = tmp_path / "runs.jsonl"
    of = {"w": drum_speed, "log": lambda run: math.nan if run["drum.w"][-1] > 4 else math.inf}
    for _ in range(2):
        found = lp.sweep(
            *(lp.assemble(winch()),), over=OVER, until=1.0, of=of, workers=1, store=store
        )
        assert found["w"] == pytest.approx([5.0, 10 / 3], rel=1e-5)
        assert math.isnan(found["log"][0])
        assert math.isinf(found["log"][1])
        assert found.failures == {0: "log: not a number"}
    lines = store.read_text().splitlines()
    assert all(json.loads(line, parse_constant=pytest.fail) for line in lines)


def test_a_job_travels_with_its_start_point():
    system = lp.assemble(winch())
    point = lp.start_point(system, start={"motor.w": 90.0})
    options = {"start": point, "rtol": 1e-7}
    job = Job(system, 0.3, {"w": lambda run: run["motor.w"][-1]}, options)
    twin = pickle.loads(pickle.dumps(job))
    assert twin({}) == job({}) == [90.0]


def test_values_and_times_with_units():
    system = assemble_row(
        ground=Fixed(), lash=ElastoBacklash(c=100.0, d=1.0, b="10 deg"), body=Inertia(J=1.0, w=1.0)
    )
    of = {"b": lambda run: dict(zip(run.system.parameters, run.theta, strict=True))["lash.b"]}
    for over in (
        {"lash.b": ["0 deg", "18 deg", 0.2]},
        [{"lash.b": v} for v in ("0 deg", "18 deg", 0.2)],
    ):
        found = lp.sweep(system, over=over, until="2 ms", of=of, workers=1)
        assert found["b"] == pytest.approx([0.0, np.pi / 10, 0.2], rel=1e-15)
        assert found["lash.b"] == pytest.approx([0.0, np.pi / 10, 0.2], rel=1e-15)
    with pytest.raises(UnitError, match=r"lash\.b = '3 kg': the unit must be of the kind rad"):
        lp.sweep(system, over={"lash.b": ["3 kg"]}, until=1.0, of=of)
    with pytest.raises(ParameterError, match=r"lash\.b = None: a number in rad is needed"):
        lp.sweep(system, over={"lash.b": [None]}, until=1.0, of=of)
    with pytest.raises(UnitError, match=r"until = '2 m': the unit must be of the kind s"):
        lp.sweep(system, over={"lash.b": [0.1]}, until="2 m", of=of)
