"""Each run of an ensemble beside the single run of its parameters; lanes beside none.

``python tests/drives/ensemble_runs.py hybrid 0 500`` compares drives of `hybrid_drives`, with
``smooth`` those of `random_drives`; a method may follow.
"""

import sys
from collections import Counter

import hybrid_drives
import numpy as np
import pytest
import random_drives

import lumped as lp
from lumped import functionals as fun
from lumped.errors import LumpedError
from lumped.many_runs.native_runs import NativeRuns
from lumped.timeloop.run_options import run_plan

paired = lp.ensembles.paired
RUNS = 7
CURVE = lp.life.SNCurve(0.1, 1e5, 5.0, "haibach")


LIMITED = ("peak", "ratio", "restitution", "e", "static", "kinetic", "fill")
"""Parameters that a change may bring out of their range."""


def to_vary(system, rng, count=3):
    """Names of parameters that are not zero."""
    found = system.parameters.items()
    names = [n for n, v in found if v and np.isfinite(v) and n.split(".")[-1] not in LIMITED]
    return sorted(rng.choice(names, min(count, len(names)), replace=False).tolist())


class Alone(NativeRuns):
    """Runs that do not go side by side."""

    has_lanes = False


def ran(system, varied, points, of, until, kind=NativeRuns, **options):
    """Runs in this thread, with what they cost."""
    theta = system.structure.parameters.defaults.copy()
    plan = run_plan(until, options.pop("rtol", 1e-6), options).by_steps("ensemble")
    made = kind(system, varied, theta, of, plan)
    return made.run(points)


def assert_same_bits(one, other):
    """Values, ends and costs of runs, nan where the other has it."""
    np.testing.assert_array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.status, other.status)
    np.testing.assert_array_equal(one.steps, other.steps)
    np.testing.assert_array_equal(one.rejected, other.rejected)


def single(system, varied, point, until, times=(), **options):
    """A single run that demands values at the same times; None if it fails."""
    given = options.pop("parameters", None) or {}
    try:
        return lp.simulate(
            system,
            until=until,
            grid=[*times, until],
            parameters={**given, **dict(zip(varied, point.tolist(), strict=True))},
            **{"method": "steps", **options},
        )
    except LumpedError:
        return None


def assert_equal_to_single_runs(
    system, varied, points, names, until, times=(), also=None, **options
):
    """Final values, and those at some times, of an ensemble and of single runs; gives both."""
    of = {name: fun.final(name) for name in names}
    of |= {f"{name} at {t}": fun.at_time(t, name) for t in times for name in names}
    count = len(of)
    of |= also or {}
    over = paired(dict(zip(varied, points.T, strict=True)))
    found = lp.ensemble(system, over=over, until=until, of=of, **options)
    runs = [single(system, varied, point, until, times, **options) for point in points]
    for i, run in enumerate(runs):
        is_missing = np.isnan(found.values[i, :count]).any()
        assert (run is None) == is_missing, found.failures.get(i)
        if run is not None:
            table = run.table(names)
            expected = np.concatenate([table[-1], *table[: len(times)]])
            np.testing.assert_array_equal(found.values[i, :count], expected, err_msg=f"run {i}")
    return found, runs


# -- random drives ---------------------------------------------------------------------------------


def drive(kind, seed):
    """A random drive: its system, its end, what varies, and the values of that."""
    if kind == "hybrid":
        made = hybrid_drives.RandomDrive(seed)
        keep, until = made.names()[: made.n], hybrid_drives.END
    else:
        made = random_drives.RandomDrive(seed)
        keep, until = [f"body{i}.phi" for i in range(len(made.shafts))], random_drives.END
    system = lp.assemble(made.model(), keep=keep)
    rng = np.random.default_rng(seed)
    varied = to_vary(system, rng)
    own = np.array([system.parameters[name] for name in varied])
    return system, until, varied, own * rng.uniform(0.9, 1.1, (RUNS, len(own)))


def states(system):
    return [name for name in system.state_names if "(" not in name]


def event_functionals(system):
    """Of all that has events: how often, when, and what it costs."""
    switching, of = system.switching, {}
    holds = set(switching.names)
    for name in sorted(holds | {c.name for c in (*switching.conditions, *switching.timed)}):
        of |= {
            f"count {name}": fun.count(name),
            f"first {name}": fun.instant(name),
            f"last {name}": fun.instant(name, number=-1),
            f"last but two {name}": fun.instant(name, number=-3),
        }
        for side in ("before", "after"):
            quantity = states(system)[-1]
            of[f"{side} {name}"] = fun.at_event(quantity, name, number=None, side=side)
        if name in holds:
            of[f"loss {name}"] = fun.loss(name)
    return of


def all_functionals(system, until):
    """Every kind, of several states, in the whole run and in parts of it."""
    of, part = {}, (0.2 * until, 0.7 * until)
    names = states(system)[:2]
    for i, name in enumerate(names):
        of |= {
            f"final {name}": fun.final(name),
            f"peak {name}": fun.peak(name),
            f"highest {name}": fun.highest(name, between=part),
            f"swing {name}": fun.swing(name),
            f"damage {name}": fun.damage(name, CURVE),
            f"rms {name}": fun.rms(name),
            f"mean {name}": fun.mean(name, names[i - 1], between=part),
            f"at {name}": fun.at_time([0.1 * until, 0.0, 0.613 * until, until], name),
        }
    return of | event_functionals(system)


def assert_events_are_those(found, runs):
    """Counts, instants and losses of an ensemble against the events of single runs."""
    for i, run in enumerate(runs):
        if run is None:
            continue
        for label in found.labels:
            what, _, name = label.partition(" ")
            if what not in ("count", "first", "last", "loss"):
                continue
            events = [e for e in run.events if name in e.component.split(", ")]
            received = found[label][i]
            if what == "count":
                assert received == len(events), label
            elif what in ("first", "last") and events:
                assert received == events[0 if what == "first" else -1].time, label
            elif what == "loss" and all(e.component == name for e in events):
                assert received == pytest.approx(sum(e.loss for e in events), rel=1e-12), label


def deviation_from_samples(of, values, system, varied, point, until):
    """Largest deviation of extremes and means from those of many samples of a single run."""
    run = lp.simulate(
        system,
        until=until,
        grid=4000,
        method="steps",
        parameters=dict(zip(varied, point.tolist(), strict=True)),
    )
    t, worst = run.t, 0.0
    for label, value in zip(of, values, strict=True):
        what, _, name = label.partition(" ")
        if what not in ("peak", "swing", "rms"):
            continue
        y = run[name]
        expected = {
            "peak": np.abs(y).max(),
            "swing": np.ptp(y),
            "rms": np.sqrt(np.trapezoid(y**2, t) / until),
        }[what]
        worst = max(worst, abs(value - expected) / max(np.abs(y).max(), 1e-3))
    return worst


def compare(kind, seed, method="steps"):
    """One drive: lanes or none, an ensemble and single runs, and samples of a single run.

    Gives how many runs have events and fail, the number of steps, and the deviation from samples.
    """
    system, until, varied, points = drive(kind, seed)
    of = all_functionals(system, until)
    side_by_side = ran(system, varied, points, of, until, method=method)
    assert_same_bits(ran(system, varied, points, of, until, Alone, method=method), side_by_side)
    times, also = (0.31 * until, 0.77 * until), event_functionals(system)
    found, runs = assert_equal_to_single_runs(
        system, varied, points, states(system), until, times, also, method=method
    )
    assert_events_are_those(found, runs)
    away = 0.0
    if runs[0] is not None:
        given = (system, varied, points[0], until)
        away = deviation_from_samples(of, side_by_side.values[0], *given)
    events, failed = sum(bool(run and run.events) for run in runs), runs.count(None)
    return events, failed, int(side_by_side.steps.sum()), away


def main(kind, first, last, method="steps"):
    """Compare many drives and count."""
    count = Counter()
    for seed in range(int(first), int(last)):
        try:
            events, failed, _, away = compare(kind, seed, method)
        except AssertionError as error:
            count["DIFFERS"] += 1
            print(f"{seed}: {str(error)[:300]}")
        except LumpedError as refusal:
            count[type(refusal).__name__] += 1
            print(f"{seed}: {type(refusal).__name__}: {str(refusal)[:200]}")
        else:
            count["agrees"] += 1
            if away > 1e-4:
                print(f"{seed}: {away:.1e} of samples")
            count["runs with events"] += events
            count["runs that fail alone and together"] += failed
    print(dict(count))


if __name__ == "__main__":
    main(*sys.argv[1:])
