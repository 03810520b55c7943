"""Verdicts on random hybrid drives: what `lumped` computes, beside the reference."""

import os
import signal
import tempfile
import traceback
from dataclasses import dataclass, replace

import numpy as np
from contact_reference import OpenLawError
from hybrid_drives import END, RandomDrive
from hybrid_parts import Line, LostError

import lumped as lp
from lumped.errors import LumpedError, SolverError

POINTS, PATIENCE = 40, 60
NEAR = 1e-4
"""Distance from events within which states are not compared, s."""


@dataclass
class Verdict:
    word: str
    text: str = ""
    accuracy: float = 0.0


class SlowError(Exception):
    """It takes longer than `PATIENCE`."""


def alarm(*_):
    raise SlowError


def beside(drive, by):
    """A drive with inertias and limits that differ a little."""
    sign = (-1.0) ** np.arange(max(drive.n, len(drive.contacts)))
    contacts = [
        replace(c, level=Line(c.level.ts, np.multiply(c.level.ys, 1 + by * s)))
        for c, s in zip(drive.contacts, sign, strict=False)
    ]
    return replace(drive, J=drive.J * (1 + by * sign[: drive.n]), contacts=contacts)


def expected_of(drive, grid):
    """What the reference says and what it is worth, or a verdict that there is nothing to compare.

    Compared are halves of its steps, and inertias and limits that differ by 1e-7.
    """
    reference = drive.reference()
    try:
        expected = reference.run(grid)
        events = reference.events
        halved = drive.reference().run(grid, 1e-3)
        changed = beside(reference, 1e-7)
        other = changed.run(grid)
    except OpenLawError as open_:
        return Verdict("law open", str(open_))
    except LostError as lost:
        return Verdict("reference lost", str(lost))
    scale = np.maximum(np.abs(expected).max(axis=0), [0.3] * drive.n + [3.0] * drive.n)
    times = np.array([-1.0, *(t for t, _ in events), *(t for p in reference.pieces for t in p)])
    quiet = np.abs(grid[:, None] - times).min(axis=1) > NEAR
    accuracy = (np.abs(halved - expected) / scale)[quiet].max(initial=0.0)
    worth = (np.abs(other - expected) / scale)[quiet].max(initial=0.0)
    if accuracy > 1e-8 or worth > 1e-4:
        return Verdict("knife's edge", f"halving {accuracy:.0e}, beside {worth:.0e}", accuracy)
    robust = [n for _, n in events] == [n for _, n in changed.events]
    shift = (
        [abs(a[0] - b[0]) for a, b in zip(events, changed.events, strict=False)] if robust else []
    )
    return expected, scale, quiet, accuracy, worth, events, shift, reference


def compare(seed, rtol=1e-8, through=None):
    """The verdict on one drive."""
    drive, grid = RandomDrive(seed), np.linspace(0, END, POINTS + 1)
    known = expected_of(drive, grid)
    if isinstance(known, Verdict):
        return known
    expected, scale, quiet, accuracy, worth, events, shift, reference = known
    signal.signal(signal.SIGALRM, alarm)
    signal.alarm(PATIENCE)
    try:
        names = drive.names()
        system = lp.assemble(drive.model(), keep=names[: drive.n])
        if through is not None:
            received, happened = through(system, names, grid), None
        else:
            run = lp.simulate(system, until=END, grid=grid, rtol=rtol)
            received = run.table(names)
            happened = [e for e in run.events if e.kind != "time"]
    except SlowError:
        return Verdict("SLOW", "", accuracy)
    except SolverError as failure:
        return Verdict("FAILS", str(failure)[:400], accuracy)
    except LumpedError as refusal:
        return Verdict("refused", f"{type(refusal).__name__}: {str(refusal)[:300]}", accuracy)
    except Exception:
        return Verdict("RAW", traceback.format_exc(limit=-3), accuracy)
    finally:
        signal.alarm(0)
    error = (np.abs(received - expected) / scale).max(axis=1)
    bad = quiet & ~(error <= 1e-5 + 30 * worth)
    if bad.any():
        at = int(bad.argmax())
        text = f"from t = {grid[at]:.3f} s by {error[at]:.1e}, reference to {worth:.0e}"
        return Verdict("DEVIATES", text + near_events(events, happened, grid[at]), accuracy)
    wrong = wrong_events(reference, events, shift, happened) if shift and happened else ""
    return Verdict("EVENTS" if wrong else "agrees", wrong, accuracy)


def near_events(events, happened, t):
    """The last events before a time."""
    ours = [(round(float(s), 6), sorted(n)) for s, n in events if s <= t][-4:]
    found = [
        (round(e.time, 6), e.component, e.before, e.after, round(e.loss, 4))
        for e in happened or []
        if e.time <= t
    ][-5:]
    return f"\n    reference {ours}\n    lumped {found}"


def wrong_events(reference, events, shift, happened):
    """Events of one side that the other lacks, apart from crowds and the kinks of time.

    Which of several contacts at rest bears nothing is not determined, and no event.
    """
    kinks = np.array([t for p in reference.pieces for t in p])
    ours, theirs = np.array([t for t, _ in events]), np.array([e.time for e in happened])
    allowed = 1e-5 + 30 * np.array(shift)
    for k, t in enumerate(ours):
        lonely = np.sort(np.abs(ours - t))[1:2].min(initial=1.0) > 1e-3
        if lonely and np.abs(kinks - t).min() > NEAR:
            away = np.abs(theirs - t).min(initial=1.0)
            if away > allowed[k]:
                return f"event {sorted(events[k][1])} at {t:.7f} misses by {away:.1e}"
    for e in happened:
        away = min(np.abs(ours - e.time).min(initial=1.0), np.abs(kinks - e.time).min())
        if away > 1e-3 and (e.component.startswith("rub") or e.loss > 1e-9):
            return f"{e} is no event of the reference"
    return ""


def unit(system, names, grid):
    """States on a grid by an exported unit."""
    import fmpy

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "drive.fmu")
        lp.export_fmu(system, path, outputs=names, rtol=1e-8)
        found = fmpy.simulate_fmu(
            path, stop_time=END, output_interval=END / POINTS, output=names, fmi_type="CoSimulation"
        )
    places = np.searchsorted(found["time"], grid - 1e-9)
    return np.array([found[name][places] for name in names]).T
