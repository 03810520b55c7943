"""Drives of many parts in a row, and their matrices by numpy alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rows import in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, SpringDamper

BRAKE = 0.7


def in_turn(end=None, aside=None, **lists):
    """A model of lists of parts, joined in turn as ``body[0], shaft[0], body[1], ...``.

    The parts of the mapping `end` follow the last one. Those of `aside`, such as torques, join the
    parts after which they are named: ``{"load": (Torque(tau=0.0), "body", 30)}``.
    """
    end, aside = end or {}, aside or {}
    most = max(len(parts) for parts in lists.values())

    def connections(m):
        held = [getattr(m, kind) for kind in lists]
        row = [parts[i] for i in range(most) for parts in held if i < len(parts)]
        yield from lp.chain(*row, *(getattr(m, name) for name in end))
        for name, (_, kind, i) in aside.items():
            yield lp.connect(getattr(m, name).flange, getattr(m, kind)[i].flange_a)

    others = {name: part for name, (part, *_) in aside.items()}
    return lp.compose(**lists, **end, **others, connections=connections)


def uniform(n, J=0.3, c=2e4):
    """Equal discs on equal springs, free at both ends."""
    bodies, shafts = [Inertia(J=J) for _ in range(n)], [Spring(c=c) for _ in range(n - 1)]
    return in_turn(body=bodies, shaft=shafts)


def uniform_hertz(n, J=0.3, c=2e4):
    """Their natural frequencies, Hz, ascending."""
    k = np.arange(1, n)
    return 2 * np.sqrt(c / J) * np.sin(k * np.pi / (2 * n)) / (2 * np.pi)


def chain_hertz(J, c):
    """Natural frequencies of discs on springs between them, Hz, by their matrices."""
    twists, scale = np.diff(np.eye(len(J)), axis=0), 1 / np.sqrt(J)
    K = scale[:, None] * (twists.T @ np.diag(c) @ twists) * scale
    return np.sqrt(np.linalg.eigvalsh(K)[1:]) / (2 * np.pi)


def star(count):
    """A hub with equal arms, each a spring with a disc at its tip."""
    return lp.compose(
        hub=Inertia(J=1.0),
        arm=[Spring(c=100.0) for _ in range(count)],
        tip=[Inertia(J=1.0) for _ in range(count)],
        connections=lambda m: [
            x for i in range(count) for x in lp.chain(m.hub.flange_b, m.arm[i], m.tip[i])
        ],
    )


def damped_pair(zeta):
    """Inertias of 2 and 1 kg.m2 and a shaft of 300 N.m/rad, with a damping ratio."""
    damper = SpringDamper(c=300.0, d=2 * zeta * np.sqrt(300.0 * 2 / 3))
    return in_a_row(a=Inertia(J=2.0), shaft=damper, b=Inertia(J=1.0))


@dataclass
class Geared:
    """Bodies on damped shafts with a gear behind each, and a brake at the end."""

    J: np.ndarray
    c: np.ndarray
    d: np.ndarray
    ratio: np.ndarray

    @classmethod
    def random(cls, n, seed):
        rng = np.random.default_rng(seed)
        J, c = rng.uniform(0.1, 2, n), rng.uniform(1e3, 1e5, n - 1)
        return cls(J, c, rng.uniform(0.1, 5, n - 1), rng.uniform(0.5, 3.0, n - 1))

    def model(self, aside=None):
        pairs = zip(self.c.tolist(), self.d.tolist(), strict=True)
        return in_turn(
            {"brake": Damper(d=BRAKE), "ground": Fixed()},
            aside,
            body=[Inertia(J=J) for J in self.J.tolist()],
            shaft=[SpringDamper(c=c, d=d) for c, d in pairs],
            gear=[IdealGear(ratio=ratio) for ratio in self.ratio.tolist()],
        )

    @property
    def twist(self):
        """Twists of the shafts by the angles of the bodies."""
        return np.diag(self.ratio, 1)[:-1] - np.eye(len(self.J))[:-1]

    def matrices(self):
        """Of inertia, damping and stiffness, for the angles of the bodies."""
        D, K = (self.twist.T @ np.diag(law) @ self.twist for law in (self.d, self.c))
        D[-1, -1] += BRAKE
        return np.diag(self.J), D, K


class Pendulum(lp.Component):
    """Gravity pendulum under a torque: ``J a = torque - weight sin(phi)``."""

    flange = lp.Flange(free=True)
    J: lp.Param = lp.param("kg.m2", "inertia", 2.0, above=0)
    weight: lp.Param = lp.param("N.m", "weight times arm", 30.0)
    torque: lp.Param = lp.param("N.m", "torque", 0.0)
    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.flange.phi == self.phi
        yield self.w == lp.der(self.phi)
        push = self.torque - self.weight * lp.ops.sin(self.phi)
        yield self.J * lp.der(self.w) == self.flange.tau + push
