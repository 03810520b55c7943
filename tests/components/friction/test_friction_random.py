"""Random nets of friction elements against Gauss's principle and against time stepping.

With friction that depends on the side of motion only, accelerations follow from Gauss's principle
of least constraint: reactions minimise ``(Q - G' r)' M^-1 (Q - G' r)`` within their limits (Moreau,
in Nonsmooth Mechanics and Applications, 1988; Pfeiffer and Glocker, 1996, ch. 5). The motion is
unique even where the reactions are not.
"""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import lumped as lp
from lumped.components import BearingFriction, Brake, Clutch, Inertia, OneWayClutch, Torque


class Net:
    """Bodies with torques, joined to each other and to the ground by friction elements."""

    def __init__(self, seed, freewheels):
        rng = self.rng = np.random.default_rng(seed)
        n, m = int(rng.integers(2, 7)), int(rng.integers(1, 9))
        self.J, self.Q = rng.uniform(0.5, 2.0, n), rng.uniform(-10.0, 10.0, n)
        self.pairs = [tuple(rng.choice(n, 2, replace=False).tolist()) for _ in range(m)]
        self.grounded = rng.random(m) < 0.4
        self.one_way = ~self.grounded & (rng.random(m) < freewheels)
        self.limits = np.where(self.one_way, 0.0, rng.uniform(0.5, 8.0, m))
        self.G = np.zeros((m, n))
        for k, (a, b) in enumerate(self.pairs):
            self.G[k, b] = 1.0
            self.G[k, a] = 0.0 if self.grounded[k] else -1.0

    def element(self, k):
        """Friction element with a limit of its own."""
        if self.one_way[k]:
            return OneWayClutch(u=0.0)
        limit, alone = float(self.limits[k]), ((0.0, 1.0),)
        if not self.grounded[k]:
            return Clutch(characteristic=alone, f_max=limit, u=1.0)
        if k % 2:
            return BearingFriction(characteristic=((0.0, limit),))
        return Brake(characteristic=alone, f_max=limit, u=1.0)

    def model(self, w, torque):
        """The net at these speeds, under these torques."""

        def connections(m):
            for body, drive in zip(m.body, m.drive, strict=True):
                yield lp.connect(drive.flange, body.flange_a)
            for k, (a, b) in enumerate(self.pairs):
                if self.grounded[k]:
                    yield lp.connect(m.body[b].flange_b, m.rub[k].flange_a)
                else:
                    yield lp.connect(m.body[a].flange_b, m.rub[k].flange_a)
                    yield lp.connect(m.body[b].flange_b, m.rub[k].flange_b)

        return lp.compose(
            body=[Inertia(J=j, w=v) for j, v in zip(self.J.tolist(), w, strict=True)],
            drive=[Torque(tau=q) for q in torque],
            rub=[self.element(k) for k in range(len(self.pairs))],
            connections=connections,
        )

    def reactions(self, load, low, high):
        """Reactions within limits that leave the least constraint."""
        root = 1 / np.sqrt(self.J)
        fixed = high - low < 1e-12
        load = load - self.G[fixed].T @ high[fixed]
        found = np.where(fixed, high, 0.0)
        if not fixed.all():
            matrix = root[:, None] * self.G[~fixed].T
            bounds = (low[~fixed], high[~fixed])
            found[~fixed] = lsq_linear(matrix, root * load, bounds, method="bvls", tol=1e-14).x
        return found


def speeds_of(run, count):
    return np.array([run[f"body[{i}].w"] for i in range(count)])


@pytest.mark.parametrize("freewheels", [0.0, 0.5])
def test_accelerations_of_random_nets_obey_gauss_principle(freewheels):
    worst = redundant = sticking = 0
    for seed in range(30):
        net = Net(seed, freewheels)
        count = len(net.J)
        w = net.rng.integers(0, 2, count) * 3.0  # several bodies at the same speed, some at rest
        if freewheels:
            w[:] = w[0]
        sliding = net.G @ w
        low = np.where(net.one_way, -np.inf, -net.limits)
        low, high = np.where(sliding > 0, net.limits, low), np.where(sliding < 0, low, net.limits)
        r = net.reactions(net.Q, low, high)
        expected = (net.Q - net.G.T @ r) / net.J
        short = 1e-3
        system = lp.assemble(net.model(w.tolist(), net.Q.tolist()))
        run = lp.simulate(system, until=short, grid=1)
        received = (speeds_of(run, count)[:, -1] - w) / short
        assert np.abs(received - expected).max() <= 1e-6 * np.abs(net.Q / net.J).max(), seed
        worst = max(worst, np.abs(received - expected).max())
        sticking += int(((sliding == 0) & (np.abs(net.G @ expected) < 1e-9)).sum())
        held = net.G[np.abs(net.G @ expected) < 1e-9]
        redundant += len(held) > np.linalg.matrix_rank(held) if len(held) else 0
    assert sticking > 25
    assert redundant > 3


CROWDED = (118, 119, 146, 159)
"""Nets with freewheels in which several elements come to their limits by rounding alone."""


@pytest.mark.parametrize(
    ("seed", "freewheels"), [*((100 + i, 0.0) for i in range(3)), *((i, 0.4) for i in CROWDED)]
)
def test_random_nets_move_as_implicit_time_stepping_does(seed, freewheels):
    """Moreau's scheme finds standstill by itself; a change of direction costs it up to a step."""
    net = Net(seed, freewheels)
    count, until, steps = len(net.J), 2.0, 2000
    w = net.rng.uniform(-3.0, 3.0, count)
    rates = net.rng.uniform(2.0, 9.0, count)
    if freewheels:
        w, rates = np.ones(count), 3.0 + np.arange(count)
    low = np.where(net.one_way, -np.inf, -net.limits)
    drives = [
        q * lp.ops.sin(b * lp.time) for q, b in zip(net.Q.tolist(), rates.tolist(), strict=True)
    ]
    run = lp.simulate(lp.assemble(net.model(w.tolist(), drives)), until=until, grid=20)
    h, speeds, expected = until / steps, w.copy(), [w.copy()]
    for k in range(steps):
        push = h * net.Q * np.sin(rates * (k + 0.5) * h)
        impulse = net.reactions(net.J * speeds + push, h * low, h * net.limits)
        speeds = speeds + (push - net.G.T @ impulse) / net.J
        if (k + 1) % (steps // 20) == 0:
            expected.append(speeds.copy())
    places = np.searchsorted(run.t, np.linspace(0, until, 21) - 1e-9)
    received = speeds_of(run, count)[:, places].T
    error = np.abs(received - expected).max()
    assert error <= h * (np.abs(net.G).T @ net.limits / net.J).max()
