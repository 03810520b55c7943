"""Random hybrid drives and impacts, for `lumped` and for `hybrid_reference`."""

import os
import re
import signal
import tempfile
import time
import traceback
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np
from contact_reference import OpenLawError, impact, lost
from hybrid_reference import Contact, Drive, Line, Load, LostError, steady
from scipy.optimize import nnls

import lumped as lp
from lumped import components as rotating
from lumped.components import translation as sliding
from lumped.errors import LumpedError, SolverError
from lumped.ops import sin, table, where

END, POINTS, PATIENCE = 1.5, 40, 60
NEAR = 1e-4
"""Distance from events within which states are not compared, s."""


def expression(line):
    """A line as an expression of `lumped`."""
    if len(line.ts) == 1:
        return float(line.ys[0])
    return table([float(t) for t in line.ts], [float(y) for y in line.ys])


def switched(line):
    """A command that is one above and zero below a half."""
    value = float(line.ys[0])
    for t, y in list(zip(line.ts, line.ys, strict=True))[1:]:
        value = where(lp.time >= float(t), float(y), value)
    return value


class RandomDrive:
    """One description, built as a model of `lumped` and as a drive of the reference."""

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.parts, self.joints, self.kinds = {}, [], []
        self.loads, self.springs, self.contacts = [], [], []
        self.turns = rng.random() < 0.75
        self.n = n = int(rng.integers(1, 5))
        self.J, self.v = rng.uniform(0.2, 2.0, n), np.zeros(n)
        speed = float(rng.choice([0.0, 0.0, rng.uniform(-5, 5)]))
        for i in range(n):
            alone = rng.random() < 0.4
            self.v[i] = rng.choice([0.0, rng.uniform(-6, 6)]) if alone else speed
        self.total, self.points = self.J.copy(), [self.point(i) for i in range(n)]
        for i in range(n):
            if self.turns and rng.random() < 0.3:
                self.points.append(self.geared(i))
        for i in range(1, n):
            if rng.random() < 0.5:
                self.spring(self.points[i], self.points[int(rng.integers(0, i))])
        if rng.random() < 0.5:
            self.spring(self.any(), None)
        for i in range(n):
            if rng.random() < 0.7 or i == 0:
                self.torque(self.points[i])
        kinds = ["friction", "redundant", "freewheel", "play", "stop", "dog"]
        odds = [0.2, 0.25, 0.15 if self.turns else 0.0, 0.15, 0.15, 0.1]
        for _ in range(int(rng.integers(1, 4))):
            kind = str(rng.choice(kinds, p=np.divide(odds, sum(odds))))
            if len(self.contacts) < 5:
                getattr(self, kind)()
        if not self.contacts:
            self.redundant()

    # -- points ----------------------------------------------------------------------------------

    def point(self, i):
        """A body: its row, and a name of a port."""
        J, v = float(self.J[i]), float(self.v[i])
        part = rotating.Inertia(J=J, phi=0.0, w=v) if self.turns else sliding.Mass(m=J, s=0.0, v=v)
        self.parts[f"body{i}"] = part
        row = np.zeros(self.n)
        row[i] = 1.0
        return row, f"body{i}.flange_a"

    def geared(self, i):
        """A second body behind a gear."""
        ratio, J = float(self.rng.choice([-1, 1]) * self.rng.uniform(0.5, 3)), 0.3
        self.parts[f"gear{i}"] = rotating.IdealGear(ratio=ratio)
        self.parts[f"second{i}"] = rotating.Inertia(J=J)
        self.joints += [
            (f"body{i}.flange_b", f"gear{i}.flange_a"),
            (f"gear{i}.flange_b", f"second{i}.flange_a"),
        ]
        self.total[i] += J / ratio**2
        return self.points[i][0] / ratio, f"second{i}.flange_b"

    def any(self):
        return self.points[int(self.rng.integers(0, len(self.points)))]

    def pair(self, ground=0.4):
        """Two points of different bodies, or one and the ground (None)."""
        b, a = self.any(), self.any()
        same = bool((np.abs(b[0]) > 0)[np.abs(a[0]) > 0].any())
        return b, None if same or self.rng.random() < ground else a

    def add(self, kind, part, b, a, through=False):
        """A part between points; gives back its name and the row of its relative motion."""
        name = f"{kind}{len(self.parts)}"
        self.parts[name] = part
        self.kinds.append(type(part).__name__)
        self.joints.append((b[1], f"{name}.{'flange_a' if through else 'flange_b'}"))
        if a is not None:
            self.joints.append((a[1], f"{name}.flange_a"))
        return name, b[0] - (0.0 if a is None else a[0])

    # -- smooth parts ----------------------------------------------------------------------------

    def line(self, size, least=-1.0):
        """A number, a ramp, or a table with a jump."""
        kind = self.rng.integers(0, 3)
        if kind == 0:
            return steady(size * float(self.rng.uniform(max(least, -1.0) or 0.1, 1.0)))
        ts = np.sort(self.rng.uniform(0.05, END - 0.05, 3 + kind)).tolist()
        if kind == 2:
            ts[2] = ts[1]
        return Line(ts, (size * self.rng.uniform(least, 1.0, len(ts))).tolist())

    def torque(self, b):
        rng, line = self.rng, self.line(12.0)
        wave = (0.0, 0.0, 0.0)
        if rng.random() < 0.5:
            wave = float(rng.uniform(1, 10)), float(rng.uniform(3, 25)), float(rng.uniform(0, 6))
        self.loads.append(Load(b[0], line, *wave))
        tau = expression(line)
        if wave[0]:
            tau = tau + wave[0] * sin(wave[1] * lp.time + wave[2])
        name = f"load{len(self.parts)}"
        self.parts[name] = rotating.Torque(tau=tau) if self.turns else sliding.Force(f=tau)
        self.joints.append((b[1], f"{name}.flange"))

    def spring(self, b, a):
        family = rotating if self.turns else sliding
        c, d = float(self.rng.uniform(20, 400)), float(self.rng.uniform(0.1, 3))
        if a is None:
            self.parts["wall"] = family.Fixed()
            a = (np.zeros(self.n), "wall.flange")
        _, row = self.add("spring", family.SpringDamper(c=c, d=d), b, a)
        self.springs.append((row, c, d))

    # -- contacts --------------------------------------------------------------------------------

    def friction(self, b=None, a=None):
        rng = self.rng
        if b is None:
            b, a = self.pair()
        peak = float(rng.choice([1.0, 1.0, rng.uniform(1, 2)]))
        limit = float(rng.uniform(1, 8))
        if rng.random() < 0.3:  # constant, and rising with the speed
            rise, line = float(rng.uniform(0, 0.2)), steady(limit)
            rows = ((0.0, limit), (10.0, limit + 10 * rise))
            given = {"characteristic": rows, "peak": peak}
            force = {"f_max": 1.0, "u": 1.0} if a is not None else {}
        else:
            rise, line = 0.0, self.line(limit, least=float(rng.choice([0.0, 0.3])))
            given = {"characteristic": ((0.0, 1.0),), "peak": peak}
            force = {"f_max": 1.0, "u": expression(line)}
        family = rotating if self.turns else sliding
        if a is not None:
            part = (rotating.Clutch if self.turns else sliding.FrictionPair)(**given, **force)
        elif force:
            part = family.Brake(**given, **force)
        else:
            part = (rotating.BearingFriction if self.turns else sliding.SupportFriction)(**given)
        name, row = self.add("rub", part, b, a, through=a is None)
        self.contacts.append(Contact(name, "friction", row, line, rise, peak))

    def redundant(self):
        """Frictions that share a load: side by side, on both sides of a gear, or in a ring."""
        rng, n = self.rng, self.n
        if n > 1 and rng.random() < 0.4:
            i, j = rng.choice(n, 2, replace=False).tolist()
            self.friction(self.points[i], None)
            self.friction(self.points[j], None)
            self.friction(self.points[i], self.points[j])
            return
        b, a = self.pair(0.6)
        beside = [p for p in self.points if np.abs(p[0]) @ np.abs(b[0]) > 0]
        for _ in range(int(rng.integers(2, 4))):
            self.friction(beside[int(rng.integers(0, len(beside)))], a)

    def freewheel(self):
        b, a = self.pair(0.0)
        if a is None or not self.turns:
            return self.friction()
        level, peak = float(self.rng.choice([0.0, 0.0, self.rng.uniform(0.5, 3)])), 1.3
        part = rotating.OneWayClutch(u=level, f_max=1.0, characteristic=((0.0, 1.0),), peak=peak)
        name, row = self.add("wheel", part, b, a)
        self.contacts.append(Contact(name, "freewheel", row, steady(level), 0.0, peak))
        return None

    def restitution(self):
        return float(self.rng.choice([0.0, 0.0, 0.3, 0.6]))

    def play(self):
        b, a = self.pair(0.0)
        if a is None:
            return self.stop()
        gap, e = float(self.rng.uniform(0.01, 0.2)), self.restitution()
        family = rotating if self.turns else sliding
        name, row = self.add("play", family.Backlash(b=gap, restitution=e), b, a)
        for sign in (1.0, -1.0):
            self.contacts.append(Contact(name, "gap", sign * row, gap=gap / 2, e=e))
        return None

    def stop(self):
        (b, a), e = self.pair(), self.restitution()
        gap = float(self.rng.choice([0.0, self.rng.uniform(0.01, 0.3)]))
        least = {"phi_min" if self.turns else "s_min": -gap}
        family = rotating if self.turns else sliding
        name, row = self.add("stop", family.Stop(restitution=e, **least), b, a)
        self.contacts.append(Contact(name, "gap", row, gap=gap, e=e))

    def dog(self):
        b, a = self.pair(0.0)
        if a is None:
            return self.friction()
        on, off = np.sort(self.rng.uniform(0.05, END - 0.05, 2)).tolist()
        first = float(self.rng.integers(0, 2))
        # a jump has two rows for the reference, and one for the command
        line = Line((on, on, off, off), (first, 1 - first, 1 - first, first))
        command = switched(Line((0.0, on, off), (first, 1 - first, first)))
        family = rotating if self.turns else sliding
        name, row = self.add("dog", family.Coupling(u=command), b, a)
        self.contacts.append(Contact(name, "dog", row, line))
        return None

    # -- the two drives --------------------------------------------------------------------------

    def reference(self):
        springs, contacts = self.springs, self.contacts
        return Drive(self.total, np.zeros(self.n), self.v, springs, self.loads, contacts, END)

    def names(self):
        position, speed = ("phi", "w") if self.turns else ("s", "v")
        return [f"body{i}.{x}" for x in (position, speed) for i in range(self.n)]

    def model(self):
        def port(m, name):
            owner, end = name.split(".")
            return getattr(getattr(m, owner), end)

        return lp.compose(
            **self.parts,
            connections=lambda m: [
                lp.connect(*(port(m, end) for end in joint)) for joint in self.joints
            ],
        )


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
            happened = [e for e in run.events if e.before or e.loss]
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


# -- impacts ---------------------------------------------------------------------------------------


class RandomImpact:
    """Bodies in a chain whose stops and plays are closed, with freewheels and dogs between them.

    Ten starts in a row have the same bodies.
    """

    def __init__(self, seed):
        rng = np.random.default_rng((7, seed // 10))
        n = self.n = int(rng.integers(2, 6))
        self.J, self.links, W, D, bounces = rng.uniform(0.3, 2.0, n), [], [], [], []
        for b in range(n):
            for a in range(-1, b):
                if rng.random() > (0.85 if a == b - 1 and a >= 0 else 0.25) or len(W) > 6:
                    continue
                odds = [0.3, 0.3, 0.3, 0.1] if a >= 0 else [1, 0, 0, 0]
                kind = str(rng.choice(["stop", "play", "freewheel", "dog"], p=odds))
                e = float(rng.choice([0.0, rng.uniform(0, 0.95)]))
                # the plays are closed where the bodies would come closer
                front, back = (
                    (a, b) if a >= 0 and (kind == "play" or rng.random() < 0.5) else (b, a)
                )
                row = np.eye(n)[front] - (np.eye(n)[back] if back >= 0 else 0.0)
                (D if kind == "dog" else W).append(-row if kind == "play" and front > back else row)
                if kind != "dog":
                    bounces.append(e if kind != "freewheel" else 0.0)
                self.links.append((kind, e, front, back))
        if not self.links:
            self.links, W, bounces = [("stop", 0.5, 1, 0)], [np.eye(n)[1] - np.eye(n)[0]], [0.5]
        self.W, self.D, self.e = np.reshape(W, (-1, n)), np.reshape(D, (-1, n)), np.array(bounces)
        rng = np.random.default_rng((8, seed))
        self.v = rng.normal(size=n) * 4 * (rng.random(n) < 0.8)
        for row in self.D:  # at one speed before
            a, b = np.flatnonzero(row)
            self.v[np.isclose(self.v, self.v[b])] = self.v[a]

    def model(self):
        angle = 0.25 * np.arange(self.n)
        bodies = [
            rotating.Inertia(J=float(j), phi=float(q)) for j, q in zip(self.J, angle, strict=True)
        ]
        parts = []
        for kind, e, front, back in self.links:
            apart = float(angle[front] - (angle[back] if back >= 0 else 0.0))
            made = {
                "stop": lambda e=e, apart=apart: rotating.Stop(phi_min=apart, restitution=e),
                "play": lambda e=e, apart=apart: rotating.Backlash(b=2 * abs(apart), restitution=e),
                "freewheel": lambda: rotating.OneWayClutch(u=0.0),
                "dog": lambda: rotating.Coupling(u=1.0),
            }
            parts.append(made[kind]())

        def connections(m):
            for part, (_, _, front, back) in zip(m.parts, self.links, strict=True):
                yield lp.connect(part.flange_b, m.bodies[front].flange_a)
                if back >= 0:
                    yield lp.connect(part.flange_a, m.bodies[back].flange_a)

        return lp.compose(bodies=bodies, parts=parts, connections=connections)


_systems = {}


def strike(case, seed):
    """Speeds after the impact in `lumped`, and the losses of its events."""
    if seed // 10 not in _systems:
        _systems.clear()
        _systems[seed // 10] = lp.assemble(case.model())
    names = [f"bodies[{i}].w" for i in range(case.n)]
    start = dict(zip(names, case.v.tolist(), strict=True))
    run = lp.simulate(_systems[seed // 10], until=1e-6, grid=[1e-9, 1e-6], start=start)
    return run.table(names)[0], [e.loss for e in run.events if e.time == 0.0]


def compare_impact(seed):
    """The verdict on one impact."""
    case = RandomImpact(seed)
    u = case.W @ case.v
    try:
        least = np.where(u < 0, -case.e * u, 0.0)
        expected, _ = impact(case.J, case.v, case.W, least, case.D)
        gain = -lost(case.J, case.v, expected)
        open_ = f"Newton's law adds {gain:.2g} J" if gain > 1e-9 else ""
    except OpenLawError as forbidden:
        open_ = str(forbidden)
    try:
        after, losses = strike(case, seed)
    except LumpedError as failure:
        lost_ = isinstance(failure, SolverError) or "no set of modes" in str(failure)
        return Verdict("FAILS" if lost_ else "refused", str(failure)[:90])
    except Exception:
        return Verdict("RAW", traceback.format_exc(limit=-3))
    size = 1 + np.abs(case.v).max()
    taken = lost(case.J, case.v, after)
    wrong = []
    allowed = 1e-7 * size  # redundant contacts yield a little
    if (case.W @ after).min(initial=0.0) < -allowed:
        wrong.append(f"approaches at {(case.W @ after).min():.2g}")
    if np.abs(case.D @ after).max(initial=0.0) > allowed:
        wrong.append("a dog slips")
    rows = np.concatenate([case.W, case.D, -case.D])
    if nnls(rows.T, case.J * (after - case.v))[1] > 10 * allowed:
        wrong.append("impulses pull, or momentum is lost")
    if taken < -allowed * size:
        wrong.append(f"adds {-taken:.2g} J")
    if abs(sum(losses) - taken) > 10 * allowed * size:
        wrong.append(f"events say {sum(losses):.4g} J of {taken:.4g} J lost")
    if not open_ and np.abs(after - expected).max() > allowed:
        wrong.append(f"speeds differ by {np.abs(after - expected).max():.2g}")
    if wrong:
        return Verdict("DEVIATES", "; ".join(wrong) + (f" ({open_})" if open_ else ""))
    return Verdict("law open, sound" if open_ else "agrees", open_)


def impacts(first, last):
    """Compare impacts and count verdicts."""
    count, why = Counter(), Counter()
    for seed in range(first, last):
        verdict = compare_impact(seed)
        count[verdict.word] += 1
        if verdict.word not in ("agrees", "law open, sound"):
            case = RandomImpact(seed)
            kinds = ", ".join(f"{k} {e:.2g}" for k, e, _, _ in case.links)
            words = re.sub(r"-?\d[-+.\de]*", "#", verdict.text.split("Last tried")[0])
            why[verdict.word + " " + words] += 1
            print(f"{seed}: {verdict.word} {verdict.text} [{kinds}]", flush=True)
    print(dict(count))
    for text, times in why.most_common():
        print(f"{times:5d} {text}")


# -- storms ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Storm:
    """Bodies with plays between them that rattle, or stacked with tiny gaps and pressed down."""

    kind: str
    e: float
    count: int
    gap: float = 1e-6

    def model(self):
        load = [5.0] + [0.0] * (self.count - 1) if self.kind == "plays" else [-10.0] * self.count
        bodies = [rotating.Inertia(J=1.0 + 0.5 * i, phi=0.0) for i in range(self.count)]
        if self.kind == "plays":
            parts = [rotating.Backlash(b=self.gap, restitution=self.e) for _ in bodies[1:]]
        else:
            parts = [rotating.Stop(phi_min=-self.gap, restitution=self.e) for _ in bodies]

        def connections(m):
            for body, drive in zip(m.bodies, m.drives, strict=True):
                yield lp.connect(drive.flange, body.flange_a)
            above = m.bodies[1:] if self.kind == "plays" else m.bodies
            for i, (part, body) in enumerate(zip(m.parts, above, strict=True)):
                yield lp.connect(part.flange_b, body.flange_a)
                below = i if self.kind == "plays" else i - 1
                if below >= 0:
                    yield lp.connect(part.flange_a, m.bodies[below].flange_b)

        drives = [rotating.Torque(tau=tau) for tau in load]
        return load, lp.compose(bodies=bodies, drives=drives, parts=parts, connections=connections)

    def run(self, until=1.0, **options):
        """The run; what its instants lost, and the energy that disappeared; greatest speed left."""
        load, model = self.model()
        names = [f"bodies[{i}].{x}" for x in ("w", "phi") for i in range(self.count)]
        system = lp.assemble(model, keep=names[self.count :])
        start = {"bodies[0].w": 10.0} if self.kind == "plays" else {}
        start |= {name: 0.0 for name in names[: self.count] if name not in start}
        run = lp.simulate(system, until=until, grid=10, rtol=1e-9, start=start, **options)
        first, last = run.table(names)[[0, -1]]
        J, n = 1.0 + 0.5 * np.arange(self.count), self.count
        gone = lost(J, np.array(list(start.values())), last[:n]) + load @ (last[n:] - first[n:])
        left = np.ptp(last[:n]) if self.kind == "plays" else np.abs(last[:n]).max()
        _, each = np.unique([e.time for e in run.events], return_inverse=True)
        losses = np.bincount(each, weights=[e.loss for e in run.events])
        return run, losses.tolist(), float(gone), float(left)


def storms():
    """Storms of growing length, each with the time that it takes."""
    signal.signal(signal.SIGALRM, alarm)
    for e in (0.9, 0.99, 0.999):
        for kind in ("plays", "stops"):
            for count, given in ((2, {}), (3, {}), (2, {"max_steps": 1000})):
                begun, storm = time.perf_counter(), Storm(kind, e, count)
                signal.alarm(PATIENCE)
                try:
                    _, losses, gone, left = storm.run(**given)
                    text = f"{len(losses)} instants, {sum(losses):.9g} of {gone:.9g} J"
                    text += f", {left:.1e} rad/s left, least loss {min(losses):.1e} J"
                except SlowError:
                    text = "SLOW"
                except LumpedError as failure:
                    text = str(failure)[:150]
                signal.alarm(0)
                print(f"{storm} {given}: {text}, {time.perf_counter() - begun:.1f} s", flush=True)


def drives(first, last, step=1, through=None):
    """Compare drives and count verdicts."""
    count, worst = Counter(), 0.0
    for seed in range(first, last, step):
        begun = time.perf_counter()
        verdict = compare(seed, through=through)
        count[verdict.word] += 1
        worst = max(worst, verdict.accuracy if verdict.word == "agrees" else 0.0)
        if verdict.word != "agrees":
            kinds = ", ".join(RandomDrive(seed).kinds)
            print(
                f"{seed}: {verdict.word} {verdict.text} [{kinds}] reference to "
                f"{verdict.accuracy:.0e}, {time.perf_counter() - begun:.0f} s",
                flush=True,
            )
    print(f"{dict(count)}; the reference is worth {worst:.0e} of each scale or better")


def main(arguments):
    """Random drives; with a word before the numbers: impacts, units, or storms."""
    words = [a for a in arguments if not a.isdigit()]
    numbers = [int(a) for a in arguments if a.isdigit()]
    first, last = [0, *numbers][-2:] if numbers else (0, 100)
    if words == ["units"]:
        drives(first, last, 20, unit)
    elif words == ["impacts"]:
        impacts(first, last)
    elif words == ["storms"]:
        storms()
    else:
        drives(first, last)
