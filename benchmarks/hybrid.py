"""What does an event cost, and how does the cost grow with the number of friction elements?

First: four inertias and three clutches (1.5 s, 9 changes of mode), against a loop written by hand
around SciPy's DOP853, which tries all sets of modes at an event. Its result at a tight tolerance
is also the reference. Second: chains of bodies on springs, each rubbing on the ground, under one
periodic torque, 10 s at 1e-6; times of a change are those inside the time loop. Set-up is
assembling and compiling, with the machine code of the loop in the cache. Times are the best of
several runs in one process; read the ratios.

    python -m benchmarks.hybrid
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.harness import build, publish, run_timed, time_action
from lumped.components import BearingFriction, Clutch, Fixed, Inertia, Spring, Torque
from lumped.ops import pi, sin, where

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


def changes(run: lp.Trajectory) -> int:
    """Events that change the position of a friction element."""
    return sum(event.after != "" for event in run.events)


def clutches() -> list[tuple[object, ...]]:
    """Errors and times of the clutches, beside the loop by hand."""
    reference, rows = ByHand(1e-12).run(), []
    system, set_up = build(Coupled())
    for rtol in (1e-4, 1e-6, 1e-8):
        hand = time_action(ByHand(rtol).run, 3)
        own, _ = run_timed(system, 40, until=END, rtol=rtol, grid=[END])
        w = np.array([own.result[f"body[{i}].w"][-1] for i in range(4)])
        errors = (f"{np.abs(found - reference).max():.1e}" for found in (w, hand.result))
        times = (f"{set_up:.2f}", f"{own.seconds * 1e3:.2f}", f"{hand.seconds * 1e3:.1f}")
        ratio = f"{hand.seconds / own.seconds:.1f}"
        rows.append((f"{rtol:g}", *errors, *times, ratio, changes(own.result)))
    return rows


def elements() -> list[tuple[object, ...]]:
    """What an event costs among many bodies that rub on the ground."""
    rows = []
    for n in ELEMENTS:
        system, set_up = build(rubbing(n))
        own, inner = run_timed(system, 10, until=10.0, grid=[10.0], method="steps")
        run, count = own.result, changes(own.result)
        times = (f"{set_up:.2f}", f"{own.seconds * 1e3:.2f}", f"{inner * 1e3:.2f}")
        each = (f"{inner / count * 1e6:.1f}", f"{inner / count / n * 1e6:.2f}")
        rows.append((n, count, run.steps, *times, *each))
    return rows


def main() -> None:
    """Print the tables and write them to the results."""
    head = ("rtol", "error", "error by hand", "set-up, s", "ms", "ms by hand", "ratio", "changes")
    publish("hybrid_clutches", head, clutches())
    head = ("elements", "changes", "steps", "set-up, s", "ms", "ms in the loop")
    head = (*head, "us per change", "us per change and element")
    publish("hybrid_elements", head, elements())


if __name__ == "__main__":
    main()
