"""Random impacts of several bodies at once, and the verdicts on them."""

import traceback

import numpy as np
from contact_reference import OpenLawError, impact, lost
from hybrid_verdicts import Verdict
from scipy.optimize import nnls

import lumped as lp
from lumped import components as rotating
from lumped.errors import LumpedError, SolverError


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
