"""Many random drives or impacts, or storms, compared with the reference; counts of verdicts."""

import re
import signal
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np
from contact_reference import lost
from hybrid_drives import RandomDrive
from hybrid_impacts import RandomImpact, compare_impact
from hybrid_verdicts import PATIENCE, SlowError, alarm, compare, unit

import lumped as lp
from lumped import components as rotating
from lumped.errors import LumpedError


@dataclass(frozen=True)
class Storm:
    """Impacts that follow each other ever faster.

    Bodies with plays between them that rattle, or stacked with tiny gaps and pressed down.
    """

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
