"""Events whose instants are known in closed form, by all methods, in lanes and in exported FMUs.

``python tests/drives/known_events.py 30000`` draws cases (`known_cases`) until so many events were
checked by each method and prints how many were missed and invented, and the largest error of an
instant over its tolerance; with words behind the number only by these methods. Cases are narrow
cams and pulses of fast shafts, sines that pass a threshold by a thousandth beside an oscillator
that allows long steps, powers of a uniform motion, motions that almost touch or almost miss, and
pulses of time that are short against the run on stuck brakes and free inertias.
"""

import sys
import time
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from known_cases import END, RTOL, Known, families

import lumped as lp
from lumped import functionals as fun
from lumped.errors import LumpedError

METHODS = ("auto", "explicit", "implicit", "taylor", "steps")


@dataclass
class Count:
    """What was checked, and how it went."""

    cases: int = 0
    events: int = 0
    missed: int = 0
    invented: int = 0
    refused: int = 0
    worst: float = 0.0

    def compare(self, known, received):
        """Compare instants in their order.

        An event within 1e5 tolerances is late, beyond that missed.
        """
        self.cases += 1
        self.events += len(known.times)
        received, i, j = np.sort(received), 0, 0
        gaps = np.diff(known.times, prepend=-1.0, append=END + 1.0)
        nearest = np.minimum(gaps[:-1], gaps[1:])
        window = np.maximum(10 * known.allowed, np.minimum(1e5 * known.allowed, nearest / 2))
        while i < len(known.times) or j < len(received):
            found = np.inf if j == len(received) else received[j]
            due, room = (known.times[i], window[i]) if i < len(known.times) else (np.inf, 0.0)
            if abs(found - due) <= room:
                self.worst = max(self.worst, abs(found - due) / known.allowed[i])
                i, j = i + 1, j + 1
            elif due < found:
                self.missed, i = self.missed + 1, i + 1
            else:
                self.invented, j = self.invented + 1, j + 1

    def compare_last_speed(self, known, speed):
        """Compare the last speed: a pulse that was not noticed leaves none."""
        self.cases, self.events = self.cases + 1, self.events + 1
        due, allowed = known.speed
        if not abs(speed - due) <= 1e-3 * abs(due):  # not >: also for nan
            self.missed += 1
        else:
            self.worst = max(self.worst, abs(speed - due) / allowed)


def run_alone(family, cases, method, count):
    for known in cases:
        options = {"until": END, "parameters": known.parameters, "rtol": RTOL, "grid": [END]}
        try:
            run = lp.simulate(family.system, method=method, **options)
        except LumpedError:
            count.refused += 1
            continue
        if known.speed:
            count.compare_last_speed(known, run["body.w"][-1])
        else:
            mine = [
                e.time
                for e in run.events
                if e.component == family.component or not family.component
            ]
            count.compare(known, mine)


def run_in_lanes(family, cases, count):
    """Counts and instants by functionals: the first and last eight."""
    over = lp.ensembles.paired({n: [k.parameters[n] for k in cases] for n in cases[0].parameters})
    if cases[0].speed:
        found = lp.ensemble(
            family.system, over=over, until=END, rtol=RTOL, of={"w": fun.final("body.w")}
        )
        for known, speed in zip(cases, found["w"], strict=True):
            count.compare_last_speed(known, speed)
        return
    name = family.component or family.system.name
    numbers = [*range(8), *range(-8, 0)]
    of = {f"{k}": fun.instant(name, number=k) for k in numbers} | {"n": fun.count(name)}
    found = lp.ensemble(family.system, over=over, until=END, rtol=RTOL, of=of)
    for i, known in enumerate(cases):
        n = int(np.nan_to_num(found["n"][i]))
        places = sorted({k % n for k in numbers if -n <= k < n}) if n else []
        seen = {k % n: found[f"{k}"][i] for k in numbers if n and -n <= k < n}
        count.missed += max(len(known.times) - n, 0)
        count.invented += max(n - len(known.times), 0)
        count.cases, count.events = count.cases + 1, count.events + len(known.times)
        if n == len(known.times):
            inner, some = Known({}, known.times[places], known.allowed[places]), Count()
            some.compare(inner, np.array([seen[k] for k in places]))
            count.missed, count.invented = (
                count.missed + some.missed,
                count.invented + some.invented,
            )
            count.worst = max(count.worst, some.worst)


def run_fmus(family, cases, count):
    """Changes of the output of an exported FMU, in FMPy's event mode."""
    import fmpy

    for known in cases:
        found = fmpy.simulate_fmu(
            family.fmu,
            start_values=known.parameters,
            stop_time=END,
            output_interval=END,
            output=[family.output],
            fmi_type="CoSimulation",
            record_events=True,
            use_event_mode=True,
            early_return_allowed=True,
        )
        t, y = found["time"], found[family.output]
        if known.speed:
            count.compare_last_speed(known, y[-1])
        else:
            jumps = (np.diff(t) < 1e-12) & (np.diff(y) != 0)
            count.compare(known, t[1:][jumps])


def main(arguments):
    number = next((int(a) for a in arguments if a.isdigit()), 30_000)
    words = [a for a in arguments if not a.isdigit()] or [*METHODS, "lanes", "units"]
    if unknown := set(words) - {*METHODS, "lanes", "units"}:
        raise SystemExit(f"no such method: {', '.join(unknown)}")
    all_of_them, wrong = families(), 0
    for method in words:
        rng, counts = np.random.default_rng(5), defaultdict(Count)
        begun = time.perf_counter()
        while sum(c.events for c in counts.values()) < number:
            for family in all_of_them:
                cases = [family.case(rng) for _ in range(16)]
                count = counts[family.name]
                if method == "lanes":
                    run_in_lanes(family, cases, count)
                elif method == "units":
                    run_fmus(family, cases, count)
                else:
                    run_alone(family, cases, method, count)
        print(f"{method}, {time.perf_counter() - begun:.0f} s")
        for name, c in counts.items():
            wrong += c.missed + c.invented
            print(
                f"    {name:24s} {c.cases:5d} cases {c.events:7d} events: {c.missed} missed, "
                f"{c.invented} invented, {c.refused} refused, error {c.worst:.1e} tolerances",
                flush=True,
            )
    raise SystemExit(wrong > 0)


if __name__ == "__main__":
    main(sys.argv[1:])
