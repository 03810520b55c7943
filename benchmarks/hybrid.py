"""What does an event cost, and how does the cost grow with the number of friction elements?

First: four inertias and three clutches (1.5 s, 9 changes of mode), against a loop written by hand
around SciPy's DOP853, which tries all sets of modes at an event. Its result at a tight tolerance
is also the reference. Second: chains of bodies on springs, each rubbing on the ground, under one
periodic torque. Times are the best of several runs in one process; read the ratios.

    python -m benchmarks.hybrid
"""

import csv
import itertools
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import BearingFriction, Clutch, Fixed, Inertia, Spring, Torque
from lumped.ops import pi, sin, where
from lumped.support.text_table import table

END, GRIP, PEAK = 1.5, 10.0, 1.1
STARTS = np.array([10.0, 0.0, 0.0, 0.0])
ELEMENTS = (1, 3, 10, 30, 100)


class Coupled(lp.Component):
    """Four inertias and three clutches that engage one after the other."""

    drive: Torque = Torque(tau=10 * sin(10 * pi * lp.time))
    body = [Inertia(J=1, w=w) for w in STARTS]  # noqa: RUF012
    clutch = [  # noqa: RUF012
        Clutch(f_max=20, peak=PEAK, u=u)
        for u in (
            sin(0.4 * pi * lp.time + pi / 2),
            where(lp.time >= 0.4, 1, 0),
            where(lp.time >= 0.9, 1, 0),
        )
    ]

    def connections(self):
        """Join them in a row."""
        yield lp.connect(self.drive.flange, self.body[0].flange_a)
        for i, clutch in enumerate(self.clutch):
            yield lp.connect(self.body[i].flange_b, clutch.flange_a)
            yield lp.connect(clutch.flange_b, self.body[i + 1].flange_a)


class ByHand:
    """The same by hand: speeds, and modes 1, 0, -1 (sliding, stuck, back) or 2 (free)."""

    def __init__(self, rtol: float) -> None:
        self.rtol, self.count = rtol, 0

    @staticmethod
    def grips(t: float) -> np.ndarray:
        """Kinetic friction of the clutches."""
        return GRIP * np.array([np.cos(0.4 * np.pi * t), t >= 0.4, t >= 0.9])

    def solve(self, t: float, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations and friction torques: row ``w_rel' == 0`` or ``tau == law``."""
        a = np.zeros((7, 7))
        b = np.zeros(7)
        for i in range(4):
            a[i, i] = 1.0
        b[0] = 10 * np.sin(10 * np.pi * t)
        grip = self.grips(t)
        for k in range(3):
            a[k, 4 + k], a[k + 1, 4 + k] = -1.0, 1.0
            if modes[k] == 0:
                a[4 + k, k], a[4 + k, k + 1] = -1.0, 1.0
            else:
                a[4 + k, 4 + k] = 1.0
                b[4 + k] = 0.0 if modes[k] == 2 else modes[k] * grip[k]
        found = np.linalg.solve(a, b)
        return found[:4], found[4:]

    def choose(
        self, t: float, w: np.ndarray, modes: np.ndarray, broken: set[int]
    ) -> tuple[np.ndarray, np.ndarray]:
        """First set of modes that fits, among all of those at standstill."""
        rel = np.diff(w)
        grip = self.grips(t)
        options = []
        for k in range(3):
            if grip[k] <= 0:
                options.append((2,))
            elif abs(rel[k]) > 1e-9:
                options.append((int(np.sign(rel[k])),))
            else:
                options.append((1, -1) if k in broken else (0, 1, -1))
        for trial in itertools.product(*options):
            a, tau = self.solve(t, np.array(trial))
            pull = np.diff(a)
            fits = True
            for k, mode in enumerate(trial):
                if abs(rel[k]) > 1e-9 or mode == 2:
                    continue
                if mode == 0:
                    fits &= abs(tau[k]) <= PEAK * grip[k] * (1 + 1e-9)
                else:
                    fits &= mode * pull[k] >= -1e-9
            if fits:
                self.count += list(trial) != list(modes)
                return np.array(trial), w
        raise RuntimeError("no modes fit")

    def run(self) -> np.ndarray:
        """Speeds at the end."""
        t, w = 0.0, STARTS.copy()
        modes = np.array([2, 2, 2])
        broken: set[int] = set()
        for edge in (0.4, 0.9, 1.25, END):
            while t < edge:
                modes, w = self.choose(t + 1e-12, w, modes, broken)
                fixed = modes.copy()

                def rate(s: float, x: np.ndarray, fixed=fixed) -> np.ndarray:
                    return self.solve(s, fixed)[0]

                watches = []
                for k in range(3):
                    if fixed[k] in (1, -1):
                        watch = lambda s, x, k=k: (x[k + 1] - x[k]) * fixed[k] + 1e-13  # noqa: B023, E731
                    elif fixed[k] == 0:
                        watch = lambda s, x, k=k: (  # noqa: E731
                            PEAK * self.grips(s)[k] - abs(self.solve(s, fixed)[1][k])  # noqa: B023
                        )
                    else:
                        continue
                    watch.terminal, watch.direction, watch.clutch = True, -1, k
                    watches.append(watch)
                found = solve_ivp(
                    rate, (t, edge - 1e-12), w, "DOP853", events=watches, rtol=self.rtol, atol=1e-10
                )
                w, t = found.y[:, -1], found.t[-1]
                broken = set()
                for watch, times in zip(watches, found.t_events or [], strict=True):
                    k = watch.clutch
                    if len(times) and fixed[k] == 0:
                        broken.add(k)
                    elif len(times):
                        w[k] = w[k + 1] = 0.5 * (w[k] + w[k + 1])
                for k in range(3):
                    if fixed[k] == 0 and k not in broken:
                        w[k + 1] = w[k]
                if found.status == 0:
                    t = edge
        return w


def rubbing(n: int) -> lp.Component:
    """Bodies in a row on springs, each rubbing on the ground, the first one driven."""
    body = [Inertia(J=1.0) for _ in range(n)]
    rub = [BearingFriction(characteristic=((0.0, 0.3),), peak=1.2) for _ in range(n)]
    spring = [Spring(c=20.0) for _ in range(n)]
    wall, drive = Fixed(), Torque(tau=4 * sin(3 * lp.time))

    def connections(_):
        yield lp.connect(drive.flange, body[0].flange_a)
        for i in range(n):
            yield lp.connect(body[i].flange_b, rub[i].flange_a, spring[i].flange_a)
            yield lp.connect(
                spring[i].flange_b, (body[i + 1].flange_a if i + 1 < n else wall.flange)
            )

    return lp.compose(
        drive=drive, body=body, spring=spring, rub=rub, wall=wall, connections=connections
    )


def timed(action, rounds: int) -> tuple[float, object]:
    """Best time of several runs, and the last result."""
    best = np.inf
    for _ in range(rounds):
        begin = time.perf_counter()
        result = action()
        best = min(best, time.perf_counter() - begin)
    return best, result


def main() -> None:
    """Print the tables and write them beside this script."""
    reference = ByHand(1e-12).run()
    system = lp.assemble(Coupled())
    rows = []
    for rtol in (1e-4, 1e-6, 1e-8):
        hand, w = timed(ByHand(rtol).run, 3)
        lp.simulate(system, until=END, rtol=rtol, grid=[END])
        own, run = timed(lambda r=rtol: lp.simulate(system, until=END, rtol=r, grid=[END]), 40)
        received = np.array([run[f"body[{i}].w"][-1] for i in range(4)])
        changes = sum(event.after != "" for event in run.events)
        rows.append(
            (
                f"{rtol:g}",
                f"{np.abs(received - reference).max():.1e}",
                f"{np.abs(w - reference).max():.1e}",
                f"{own * 1e3:.2f}",
                f"{hand * 1e3:.1f}",
                f"{hand / own:.1f}",
                changes,
            )
        )
    head = ("rtol", "error", "error by hand", "ms", "ms by hand", "ratio", "changes")
    print("Coupled clutches, 1.5 s\n" + table(head, rows))
    write("hybrid_clutches.csv", head, rows)
    rows = []
    for n in ELEMENTS:
        system = lp.assemble(rubbing(n))
        until = 10.0
        lp.simulate(system, until=until, grid=[until])
        seconds, run = timed(lambda s=system: lp.simulate(s, until=10.0, grid=[10.0]), 5)
        changes = max(1, sum(event.after != "" for event in run.events))
        rows.append(
            (
                n,
                changes,
                run.steps,
                f"{seconds * 1e3:.1f}",
                f"{seconds / until * 1e3:.2f}",
                f"{seconds / changes * 1e6:.0f}",
                f"{seconds / (run.steps * n) * 1e6:.2f}",
            )
        )
    head = (
        "elements",
        "changes",
        "steps",
        "ms",
        "ms per s",
        "us per change",
        "us per step, element",
    )
    print("\nBodies that rub on the ground, 10 s, rtol 1e-6\n" + table(head, rows))
    write("hybrid_elements.csv", head, rows)


def write(name: str, head, rows) -> None:
    """Write a table as CSV beside this script."""
    path = Path(__file__).parent / "results" / name
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


if __name__ == "__main__":
    main()
