"""Random drives full of freewheels, plays and brakes, each instant of their runs checked.

``python tests/drives/instant_drives.py 0 1000`` tries a thousand drives (`dense_drives`) in two
orders of declaration and prints those that deviate, are refused or depend on the order; ``... rough
0 1000`` tries drives with friction that a stop presses, ``... units 0 100`` compares events of
exported units with those of runs. What is checked, and how, stands in `instant_motions`; it shares
no code with `lumped`.
"""

import os
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise, zip_longest

import numpy as np
from dense_drives import InstantDrive, RoughDrive
from hybrid_drives import END
from hybrid_verdicts import SlowError, alarm
from instant_laws import Finding, Part
from instant_motions import check

import lumped as lp
from lumped.errors import LumpedError, ModelWarning

RTOL, POINTS, STEPS = 1e-9, 30, 20_000
SAME = 1e-6
"""Difference of times and states of two orders of declaration that is none."""
RESTS = 1e-12
"""Speed of a contact that does not move: any of its positions gives the same motion."""
MOVED = 1e-9
"""Change of start speeds that shows how far a drive is chaotic."""


@dataclass
class Verdict:
    word: str
    text: str = ""
    finding: Finding = field(default_factory=Finding)


def rates(drive):
    return [f"body{i}.a" for i in range(drive.n)]


def parts_of(run, drive):
    """The parts of a run between its events, and what its states are before the first."""
    names = drive.names()
    values = run.table([*names, *rates(drive)])
    q, v, a = np.split(values, [drive.n, 2 * drive.n], axis=1)
    ends = np.flatnonzero(np.diff(run.t) == 0.0) + 1
    cuts = [0, *ends, len(run.t)]
    return [Part(run.t[i:j], q[i:j], v[i:j], a[i:j]) for i, j in pairwise(cuts)]


def checked(run, drive):
    """What is wrong with a run."""
    happened = [(e.time, e.component, e.loss) for e in run.events]
    return check(drive.reference(), parts_of(run, drive), happened)


def simulated(drive, backwards, start=None):
    names = drive.names()
    system = lp.assemble(drive.model(backwards), keep=names[: drive.n])
    options = {"grid": POINTS, "rtol": RTOL, "max_steps": STEPS}
    return lp.simulate(system, until=END, start=start, **options)


def instants(run):
    """Times of events, each with the positions that change; what begins has none before."""
    found = []
    for e in sorted(run.events, key=lambda e: e.time):
        before = e.before or e.after
        if e.kind == "time" or (before == e.after and abs(e.loss) < 1e-9):
            continue
        if not found or e.time - found[-1][0] > SAME:
            found.append((e.time, {}))
        first, _ = found[-1][1].get(e.component, (before, ""))
        found[-1][1][e.component] = first, e.after
    return [
        (t, {(name, *ends) for name, ends in changes.items() if ends[0] != ends[1]})
        for t, changes in found
    ]


def difference(one, two, drive):
    """How two runs differ, in words, and how far their ends lie apart."""
    names = drive.names()
    apart = float(np.abs(one.table(names)[-1] - two.table(names)[-1]).max())
    for (t, a), (s, b) in zip_longest(instants(one), instants(two), fillvalue=(np.inf, set())):
        a, b = a - b, b - a
        idle = {name for name, *_ in a | b if rests(drive, name, min(t, s), one, two)}
        if abs(t - s) > SAME or any(name not in idle for name, *_ in a | b):
            return f"{t:.7f} {sorted(a)}, {s:.7f} {sorted(b)}; ends {apart:.1e} apart", apart
    return f"ends {apart:.1e} apart" if apart > SAME else "", apart


def rests(drive, name, t, *runs):
    """Whether a contact does not move at all from a time to the next that is recorded."""
    rows = np.array([c.row for c in drive.reference().contacts if c.name == name])
    for run in runs:
        near = (run.t > t - SAME) & (run.t < t + 1.5 * END / POINTS)
        v = run.table(drive.names())[near, drive.n :]
        if np.abs(v @ rows.T).max(initial=0.0) > RESTS:
            return False
    return True


def beside(drive):
    """Start speeds that differ by little."""
    speeds = drive.v + MOVED * (-1.0) ** np.arange(drive.n)
    return dict(zip(drive.names()[drive.n :], speeds.tolist(), strict=True))


def in_both_orders(seed, family=InstantDrive):
    """The verdict on one drive in two orders of declaration."""
    drive, runs, finding = family(seed), [], Finding()
    for backwards in (False, True):
        runs.append(simulated(drive, backwards))
        found = checked(runs[-1], drive)
        finding.add(found)
        if found.wrong:
            return Verdict("deviates", "; ".join(found.wrong[:2]), finding)
    text, apart = difference(*runs, drive)
    if not text:
        return Verdict("agrees", "", finding)
    also, moved = difference(runs[0], simulated(drive, False, beside(drive)), drive)
    chaotic = moved > 0.1 * apart > 0.1 * MOVED or bool(also)
    return Verdict("chaotic" if chaotic else "depends on the order", text, finding)


def as_unit(seed, family=InstantDrive):
    """The verdict on the events of a drive as an exported unit."""
    import fmpy

    drive = family(seed)
    names = drive.names()
    system = lp.assemble(drive.model(), keep=names[: drive.n])
    run = simulated(drive, False)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "drive.fmu")
        lp.export_fmu(system, path, outputs=names, rtol=RTOL)
        found = fmpy.simulate_fmu(
            path,
            stop_time=END,
            output_interval=END / POINTS,
            output=names,
            fmi_type="CoSimulation",
            record_events=True,
            use_event_mode=True,
            early_return_allowed=True,
        )
    received, expected = doubled(found["time"]), doubled(run.t)
    # loads are shared anew where rounding says so
    happened = near(expected, [t for t, changes in instants(run) if changes])
    lost = min(happened - near(happened, received), default=np.inf)
    more = len(received) - len(expected)
    last = np.array([found[name][-1] for name in names])
    apart = float(np.abs(last - run.table(names)[-1]).max())
    text = f"ends {apart:.1e} apart" if apart > SAME else ""
    if lost < np.inf or more:
        text = f"lost at {lost:.7f}, {more} more than in the run; ends {apart:.1e} apart"
    if not text:
        return Verdict("agrees")
    _, moved = difference(run, simulated(drive, False, beside(drive)), drive)
    return Verdict("chaotic" if moved > 0.1 * apart > 0.1 * SAME else "deviates", text)


def doubled(t):
    """Inner times that stand there twice."""
    return [float(s) for s in t[1:][np.diff(t) < 1e-12] if 1e-9 < s < END - 1e-9]


def near(times, others):
    """Those of some times that are practically one of the others."""
    return {t for t in times if np.abs(np.subtract(others, t)).min(initial=1.0) < SAME}


def verdict_on(seed, judge, family=InstantDrive):
    """What a judge says about a drive, unless it is refused or takes too long."""
    signal.signal(signal.SIGALRM, alarm)
    signal.alarm(300 if judge is as_unit else 20)
    try:
        return judge(seed, family)
    except SlowError:
        return Verdict("slow")
    except LumpedError as error:
        return Verdict("refused", f"{type(error).__name__}: {str(error)[:300]}")
    except Exception:
        return Verdict("RAW", traceback.format_exc(limit=-3))
    finally:
        signal.alarm(0)


def main(arguments):
    """Random drives in both orders, or as units."""
    judge = as_unit if "units" in arguments else in_both_orders
    family = RoughDrive if "rough" in arguments else InstantDrive
    first, last = [int(a) for a in arguments if a.isdigit()]
    count, total, begun = Counter(), Finding(), time.perf_counter()
    warnings.simplefilter("ignore", ModelWarning)
    for seed in range(first, last):
        verdict = verdict_on(seed, judge, family)
        count[verdict.word] += 1
        total.add(verdict.finding)
        if verdict.word != "agrees":
            kinds = ", ".join(family(seed).kinds)
            print(f"{seed}: {verdict.word} {verdict.text} [{kinds}]", flush=True)
    seconds = time.perf_counter() - begun
    print(
        f"{dict(count)}; {total.instants} instants, {total.impacts} impacts, "
        f"{len(total.open)} of them open, {seconds:.0f} s"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
