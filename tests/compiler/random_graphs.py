"""Random drive graphs, and their mass, damping and stiffness matrices on the free motions."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    RackAndPinion,
    Spring,
    SpringDamper,
    Torque,
    translation,
)


class Graph:
    """A random drive: parts for the model, matrices for the second formulation.

    A node is a body, or a place without mass where parts meet. Each has one coordinate.
    """

    def __init__(self, rng):
        self.rng = rng
        self.n = n = int(rng.integers(2, 15))
        self.turns = rng.random(n) < rng.choice([0.0, 0.6, 0.9, 1.0])
        self.mass = np.where(rng.random(n) < 0.2, 0.0, rng.uniform(0.2, 3, n))
        self.parts, self.ends, self.couplings = [], [], []
        self.rigid, self.level = np.zeros((0, n)), np.zeros(0)
        self.links = []  # part, elongation by coordinate, stiffness, damping, rest
        self.force = np.zeros(n)
        self.body = {}
        for i in np.flatnonzero(self.mass).tolist():
            self.body[i] = len(self.parts)
            self.part(
                Inertia(J=self.mass[i]) if self.turns[i] else translation.Mass(m=self.mass[i])
            )
        for i in range(1, n):
            if rng.random() < 0.93:
                self.join(i, int(rng.integers(0, i)))
        for _ in range(int(rng.integers(0, 8))):
            self.extra()

    def part(self, part, **ends):
        self.parts.append(part)
        self.ends.append(ends)

    def restrict(self, terms, value=0.0):
        """Add the constraint ``sum(factor * coordinate) == value``, unless it is redundant."""
        row = np.zeros(self.n)
        row[list(terms)] = list(terms.values())
        rows = np.vstack([self.rigid, row])
        if len(rows) > self.n or np.linalg.svd(rows, compute_uv=False).min() < 0.05:
            return False
        self.rigid, self.level = rows, np.append(self.level, value)
        return True

    def ratio(self):
        """A few round values, so that loops of gears and springs close, and any others."""
        size = self.rng.choice([0.5, 1.5, 3.0, self.rng.uniform(0.4, 3)])
        return float(self.rng.choice([-1, 1]) * size)

    def join(self, i, j):
        """Join two nodes by something that fits their kinds."""
        if self.turns[i] != self.turns[j]:
            pinion, rack = (i, j) if self.turns[i] else (j, i)
            radius = self.ratio()
            if self.restrict({rack: 1.0, pinion: -radius}):
                self.part(RackAndPinion(radius=radius), flange_a=pinion, flange_b=rack)
            return
        kind = self.rng.random()
        if kind < 0.2 and self.turns[i]:
            ratio = self.ratio()
            if self.restrict({i: 1.0, j: -ratio}):
                self.part(IdealGear(ratio=ratio), flange_a=i, flange_b=j)
                return
        elif kind < 0.3 and self.restrict({i: 1.0, j: -1.0}):
            self.couplings.append((i, j))
            return
        self.link(i, j)

    def link(self, i, j):
        """An elastic or viscous part from node i to node j."""
        kind = self.rng.choice(["Spring", "Damper", "SpringDamper"], p=[0.4, 0.2, 0.4])
        c, d, rest = self.rng.uniform(50, 500), self.rng.uniform(0.2, 4), self.rng.normal() / 10
        family = {"Spring": Spring, "Damper": Damper, "SpringDamper": SpringDamper}
        cls = family[kind] if self.turns[i] else getattr(translation, kind)
        if kind == "SpringDamper" and self.mass[i] and self.mass[j] and self.rng.random() < 0.3:
            d = 0.0
        given = {"c": c, "phi_rel0" if self.turns[i] else "s_rel0": rest} if kind[0] == "S" else {}
        given |= {"d": d} if "Damper" in kind else {}
        row = np.eye(self.n)[j] - np.eye(self.n)[i]
        self.links.append((len(self.parts), row, given.get("c", 0.0), given.get("d", 0.0), rest))
        self.part(cls(**given), flange_a=i, flange_b=j)

    def extra(self):
        """One more part: a loop, a support, a set of three shafts, or a source."""
        rng, n = self.rng, self.n
        kind = rng.choice(["join", "fixed", "three", "source"], p=[0.3, 0.15, 0.25, 0.3])
        i = int(rng.integers(0, n))
        alike = np.setdiff1d(np.flatnonzero(self.turns == self.turns[i]), [i])
        if kind == "join" and n > 1:
            self.join(i, int(rng.choice(np.setdiff1d(np.arange(n), [i]))))
        elif kind == "fixed":
            place = rng.normal()
            if self.restrict({i: 1.0}, place):
                wall = Fixed(phi0=place) if self.turns[i] else translation.Fixed(s0=place)
                self.part(wall, flange=i)
        elif kind == "three" and self.turns[i] and len(alike) > 1:
            j, k = rng.choice(alike, 2, replace=False).tolist()
            ratio = float(rng.uniform(0.4, 3))
            if rng.random() < 0.5:
                if self.restrict({i: 1 + ratio, j: -1.0, k: -ratio}):
                    self.part(Planetary(ratio=ratio), carrier=i, sun=j, ring=k)
            elif self.restrict({i: 1.0, j: ratio, k: -1 - ratio}):
                self.part(IdealGear(ratio=-ratio), flange_a=i, flange_b=j, support=k)
        elif kind == "source":
            value = 20 * rng.normal()
            source = Torque(tau=value) if self.turns[i] else translation.Force(f=value)
            self.force[i] += value
            if len(alike) and rng.random() < 0.4:
                base = int(rng.choice(alike))
                self.force[base] -= value
                self.part(source, flange=i, support=base)
            else:
                self.part(source, flange=i)

    # -- the model ---------------------------------------------------------------------------

    def ports(self):
        """Ports of other parts at each node, as (part, name)."""
        found = [[] for _ in range(self.n)]
        for k, ends in enumerate(self.ends):
            for port, node in ends.items():
                found[node].append((k, port))
        return found

    def model(self):
        ports, rng = self.ports(), np.random.default_rng(self.n)

        def port(m, node):
            if node in self.body:
                return getattr(m.part[self.body[node]], str(rng.choice(["flange_a", "flange_b"])))
            k, name = ports[node][0]
            return getattr(m.part[k], name)

        def connections(m):
            for node, own in enumerate(ports):
                for k, name in own if node in self.body else own[1:]:
                    yield lp.connect(port(m, node), getattr(m.part[k], name))
            for i, j in self.couplings:
                yield lp.connect(port(m, i), port(m, j))

        return lp.compose(part=self.parts, connections=connections)

    def coordinate(self, i, order=0):
        """Name of the coordinate of a node, or of its derivative in a body."""
        turning, sliding = ("phi", "w", "a"), ("s", "v", "a")
        name = (turning if self.turns[i] else sliding)[order]
        if i in self.body:
            return f"part[{self.body[i]}].{name}"
        k, port = self.ports()[i][0]
        return f"part[{k}].{port}.{name}"

    def torques(self):
        """Names of the torques (forces) of the elastic and viscous parts."""
        turns = [self.turns[np.flatnonzero(row)[0]] for _, row, *_ in self.links]
        pairs = zip(self.links, turns, strict=True)
        return [f"part[{k}].{'tau' if turning else 'f'}" for (k, *_), turning in pairs]

    def meanings(self):
        """Coordinates or speeds that names stand for: (row, order of derivative)."""
        found = {}
        for i, row in enumerate(np.eye(self.n)):
            found[self.coordinate(i)] = (row, 0)
            if i in self.body:
                found[self.coordinate(i, 1)] = (row, 1)
        for k, row, *_ in self.links:
            turns = self.turns[np.flatnonzero(row)[0]]
            found[f"part[{k}]." + ("phi_rel" if turns else "s_rel")] = (row, 0)
            found[f"part[{k}]." + ("w_rel" if turns else "v_rel")] = (row, 1)
        return found


@dataclass
class Reduced:
    """Free motions ``q = q0 + heavy a + viscous b + elastic c`` and their equations.

    `heavy` motions have mass; `viscous` ones none, but damping; `elastic` ones only stiffness.
    The state is (a, b, der(a)): ``der(x) == A x + g``.
    """

    q0: np.ndarray
    heavy: np.ndarray
    viscous: np.ndarray
    follow: np.ndarray  # elastic motion by (a, b), and a constant
    A: np.ndarray
    g: np.ndarray
    stiffness: np.ndarray
    rigid: int

    @classmethod
    def of(cls, graph):
        """None if the drive is not well posed."""
        n = graph.n
        rows = np.array([row for _, row, *_ in graph.links]).reshape(-1, n)
        c, d, rest = (np.array([link[k] for link in graph.links]) for k in (2, 3, 4))
        M, K, D = np.diag(graph.mass), rows.T * c @ rows, rows.T * d @ rows
        q0 = np.linalg.pinv(graph.rigid) @ graph.level
        f = graph.force + rows.T @ (c * rest) - K @ q0
        free = null_space(graph.rigid)
        light = free @ null_space(free.T @ M @ free)
        heavy = free @ rest_space(free.T @ M @ free)
        elastic = light @ null_space(light.T @ D @ light)
        viscous = light @ rest_space(light.T @ D @ light)
        K_elastic = elastic.T @ K @ elastic
        if np.linalg.svd(K_elastic, compute_uv=False).min(initial=np.inf) < 1:
            return None
        positions = np.hstack([heavy, viscous])
        follow = -np.linalg.solve(K_elastic, elastic.T @ K @ positions)
        constant = np.linalg.solve(K_elastic, elastic.T @ f)
        p, q = heavy.shape[1], viscous.shape[1]
        force = f - K @ elastic @ constant
        stiffness = K @ (positions + elastic @ follow)
        flow = np.hstack([-stiffness, -D @ heavy])  # forces by (a, b, der(a))
        drag = viscous.T @ D @ viscous
        b_rate = np.linalg.solve(drag, viscous.T @ flow)
        b_const = np.linalg.solve(drag, viscous.T @ force)
        mass = heavy.T @ M @ heavy
        a_rate = np.linalg.solve(mass, heavy.T @ (flow - D @ viscous @ b_rate))
        a_const = np.linalg.solve(mass, heavy.T @ (force - D @ viscous @ b_const))
        speed = np.hstack([np.zeros((p, p + q)), np.eye(p)])
        return cls(
            q0,
            heavy,
            viscous,
            np.column_stack([elastic @ follow, elastic @ constant]),
            np.vstack([speed, b_rate, a_rate]),
            np.concatenate([np.zeros(p), b_const, a_const]),
            positions.T @ stiffness,
            free.shape[1] - rank(np.vstack([free.T @ K @ free, free.T @ D @ free])),
        )

    def motion(self, x):
        """Coordinates and speeds of all nodes, and accelerations of those with mass."""
        p = self.heavy.shape[1]
        positions = np.hstack([self.heavy, self.viscous]) + self.follow[:, :-1]
        rate = self.A @ x + self.g
        m = positions.shape[1]
        q = self.q0 + positions @ x[:m] + self.follow[:, -1]
        return q, positions @ rate[:m], self.heavy @ rate[m:] if p else np.zeros(len(q))

    def later(self, x, time):
        """The state after some time."""
        n = len(x)
        A = np.zeros((n + 1, n + 1))
        A[:n, :n], A[:n, n] = self.A, self.g
        return (expm(A * time) @ np.append(x, 1.0))[:n]

    def eigenvalues(self):
        """Those of the motions apart from positions on which no force depends."""
        used = rest_space(self.stiffness)
        m = len(self.stiffness)
        keep = np.zeros((len(self.A), used.shape[1] + len(self.A) - m))
        keep[:m, : used.shape[1]] = used
        keep[m:, used.shape[1] :] = np.eye(len(self.A) - m)
        return np.linalg.eigvals(keep.T @ self.A @ keep)


def rank(matrix):
    values = np.linalg.svd(matrix, compute_uv=False)
    return int((values > 1e-9 * values.max(initial=1.0)).sum())


def null_space(matrix):
    return np.linalg.svd(matrix)[2][rank(matrix) :].T


def rest_space(matrix):
    """Orthogonal complement of the null space."""
    return np.linalg.svd(matrix)[2][: rank(matrix)].T


def usable(graph):
    """Whether no part is loose and every elastic part can be strained.

    Ends of an elastic part may stand still, but not move and only together.
    """
    ports, coupled = graph.ports(), np.ravel(graph.couplings).tolist()
    light = np.flatnonzero(graph.mass == 0)
    loose = any(not ports[i] or len(ports[i]) + coupled.count(i) < 2 for i in light)
    free = null_space(graph.rigid)
    rows = np.array([row for _, row, *_ in graph.links]).reshape(-1, graph.n)
    moving = np.any(abs(rows) @ abs(free) > 1e-9, axis=1)
    strained = np.any(abs(rows @ free) > 1e-9, axis=1)
    return graph.body and not loose and not (moving & ~strained).any()


def locked(gears):
    """Nodes that stand still because of the constraints of gears alone."""
    return np.all(abs(null_space(gears)) < 1e-9, axis=1)


def random_drive(rng, lock=False):
    """A random drive that is well posed; one in which a loop of gears locks itself, or none."""
    while True:
        graph = Graph(rng)
        gears = graph.rigid[(graph.rigid != 0).sum(axis=1) > 1]
        fits = locked(gears).any() == lock and usable(graph)
        reduced = Reduced.of(graph) if fits else None
        if reduced is not None:
            return graph, reduced
