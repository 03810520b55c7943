"""Does the cost of assembling grow linearly with the number of components, whatever the topology?

From objects to a callable right-hand side, in processor time, as a shared machine has no other
that repeats. Every size is timed several times in turn and the best time of each is kept; figures
of different runs differ with the machine's load, so read the ratios.
The second table says what comes out: states against the least possible number, and operations of
the right-hand side against those of one written by hand.

    python -m benchmarks.flatten_time
"""

import gc
import time
from collections.abc import Callable

import casadi as ca
import numpy as np

import lumped as lp
from benchmarks.harness import publish
from lumped.components import IdealGear, Inertia, Spring, SpringDamper

SIZES = (10, 30, 100, 300, 600, 1000, 3000, 10_000, 30_000)
REFERENCE, COUNTED = 600, 3000
ROUNDS, LONG = 5, 6.0  # what takes longer than so many seconds is timed once

Made = tuple[lp.Component, int]
"""A model and the least number of states."""


Line = tuple[int, tuple[lp.Component, ...], int]
"""Body, parts from there on, body."""


def join_bodies(bodies: list[Inertia], lines: list[Line]) -> lp.Component:
    """Bodies that are joined by lines of parts, all of one length."""
    kinds = zip(*(parts for _, parts, _ in lines), strict=True)
    parts = {f"part_{k}": list(kind) for k, kind in enumerate(kinds)}

    def connections(m):
        each = [getattr(m, name) for name in parts]
        for k, (i, _, j) in enumerate(lines):
            yield from lp.chain(m.body[i], *(kind[k] for kind in each), m.body[j])

    return lp.compose(body=bodies, **parts, connections=connections)


def equal(n: int) -> list[Inertia]:
    """Equal bodies."""
    return [Inertia(J=1.0) for _ in range(n)]


def gear(i: int) -> IdealGear:
    """Gears of two ratios in turn."""
    return IdealGear(ratio=1.1 if i % 2 else -0.9)


def chain(size: int) -> Made:
    """Free inertias and springs in a row."""
    n = (size + 1) // 2
    lines = [(i, (Spring(c=1e3),), i + 1) for i in range(n - 1)]
    return join_bodies(equal(n), lines), 2 * n - 1


def tree(size: int) -> Made:
    """Two springs on each inertia."""
    n = (size + 1) // 2
    lines = [((i - 1) // 2, (Spring(c=1e3),), i) for i in range(1, n)]
    return join_bodies(equal(n), lines), 2 * n - 1


def star(size: int) -> Made:
    """All springs on one inertia."""
    n = (size + 1) // 2
    lines = [(0, (Spring(c=1e3),), i) for i in range(1, n)]
    return join_bodies(equal(n), lines), 2 * n - 1


def gear_ladder(size: int) -> Made:
    """Inertias and rigid gears in a row."""
    n = (size + 1) // 2
    return join_bodies(equal(n), [(i, (gear(i),), i + 1) for i in range(n - 1)]), 1


def chain_with_gears(size: int) -> Made:
    """Inertias in a row, with a spring and a gear between them."""
    n = max((size + 2) // 3, 2)
    lines = [(i, (Spring(c=1e3), gear(i)), i + 1) for i in range(n - 1)]
    return join_bodies(equal(n), lines), 2 * n - 1


def rigid(size: int) -> Made:
    """Inertias in a row, joined directly."""
    return join_bodies(equal(size), [(i, (), i + 1) for i in range(size - 1)]), 1


def random_drive(size: int) -> Made:
    """Each inertia on one of the eight before it by a spring or gear; a tenth more in loops."""
    rng = np.random.default_rng(size)
    n = max(round(size / 2.1), 2)
    pairs = [(int(rng.integers(max(0, i - 8), i)), i) for i in range(1, n)]
    geared = rng.random(n - 1) < 0.2
    speed = np.ones(n)  # of each inertia in a rigid motion
    for (i, j), gear in zip(pairs, geared, strict=True):
        speed[j] = speed[i] / 2 if gear else speed[i]
    ends = rng.integers(8, n, n // 10) if n > 8 else np.zeros(0, dtype=int)
    loops = [(int(j - rng.integers(1, 9)), int(j)) for j in ends]
    elastic = [p for p, gear in zip(pairs, geared, strict=True) if not gear] + loops
    rigid_pairs = [p for p, gear in zip(pairs, geared, strict=True) if gear]
    bodies = [Inertia(J=float(J)) for J in rng.uniform(0.5, 2, n)]
    parts = [SpringDamper(c=float(c), d=0.1) for c in rng.uniform(100, 1000, len(elastic))]
    lines = [(i, (part,), j) for (i, j), part in zip(elastic, parts, strict=True)]
    lines += [(i, (IdealGear(ratio=2.0),), j) for i, j in rigid_pairs]
    model = join_bodies(bodies, lines)
    turns = all(speed[i] == speed[j] for i, j in loops)
    return model, 2 * (n - len(rigid_pairs)) - turns


TOPOLOGIES: dict[str, Callable[[int], Made]] = {
    "chain": chain,
    "tree": tree,
    "star": star,
    "gear ladder": gear_ladder,
    "geared chain": chain_with_gears,
    "rigid couplings": rigid,
    "random drive": random_drive,
}


def by_hand(n: int, geared: bool) -> ca.Function:
    """Right-hand side of the chains as one would write it, ``tau = c (twist - rest)``."""
    twist, w = ca.SX.sym("twist", n - 1), ca.SX.sym("w", n)
    J, ratio = ca.SX.sym("J", n), ca.SX.sym("ratio", n - 1 if geared else 0)
    c, rest = ca.SX.sym("c", n - 1), ca.SX.sym("rest", n - 1)
    tau = c * (twist - rest)
    reflected = ratio * w[1:] if geared else w[1:]
    passed = ratio * tau if geared else tau
    torque = ca.vertcat(tau, 0) - ca.vertcat(0, passed)
    return ca.Function(
        "rhs",
        [ca.vertcat(twist, w), ca.vertcat(J, c, rest, ratio)],
        [ca.vertcat(reflected - w[:-1], torque / J)],
    )


def time_model(name: str, size: int) -> tuple[float, float, int]:
    """Processor time to assemble and to build the right-hand side; number of components."""
    gc.collect()
    begin = time.process_time()
    system = lp.assemble(TOPOLOGIES[name](size)[0])
    middle = time.process_time()
    function = system.rhs
    end = time.process_time()
    assert function.size1_out(0) == len(system.state_names)
    return middle - begin, end - middle, system.report()["components"] - 1


def times() -> dict[str, list[tuple[int, float, float]]]:
    """Components and best times of each topology."""
    best: dict[tuple[str, int], tuple[float, float, int]] = {}
    plan = [(name, size) for name in TOPOLOGIES for size in SIZES]
    for _ in range(ROUNDS):
        for key in plan:
            if key not in best or sum(best[key][:2]) < LONG:
                found = time_model(*key)
                best[key] = min(best.get(key, found), found, key=lambda f: f[0] + f[1])
    return {
        name: [(c, a, b) for (own, _), (a, b, c) in sorted(best.items()) if own == name]
        for name in TOPOLOGIES
    }


def time_rows(found: dict[str, list[tuple[int, float, float]]]) -> list[tuple[str, ...]]:
    """The table of times."""
    rows = []
    for name, own in found.items():
        each = {count: (a + b) / count for count, a, b in own}
        reference = each[min(each, key=lambda count: abs(count - REFERENCE))]
        for count, a, b in own:
            cells = (f"{a:.4f}", f"{b:.4f}", f"{each[count] * 1e6:.1f}")
            rows.append((name, str(count), *cells, f"{each[count] / reference:.2f}"))
    return rows


def outcome_rows() -> list[tuple[str, ...]]:
    """The table of states and operations."""
    rows = []
    made = {name: make(COUNTED) for name, make in TOPOLOGIES.items()}
    hand = {
        "chain": by_hand((made["chain"][1] + 1) // 2, False),
        "geared chain": by_hand((made["geared chain"][1] + 1) // 2, True),
    }
    for name, (model, least) in made.items():
        system = lp.assemble(model)
        operations, best, ratio = system.rhs.n_instructions(), "", ""
        if name in hand:
            best = str(hand[name].n_instructions())
            ratio = f"{operations / hand[name].n_instructions():.2f}"
        count = system.report()["components"] - 1
        cells = (str(count), str(len(system.state_names)), str(least), str(operations), best, ratio)
        rows.append((name, *cells))
    return rows


def main() -> None:
    """Print the tables and write them to the results."""
    head = ("topology", "components", "states", "least", "operations", "by hand", "ratio")
    publish("flatten_outcome", head, outcome_rows())
    found = times()
    head = ("topology", "components", "assemble, s", "build rhs, s", "us/component")
    publish("flatten_time", (*head, f"ratio to {REFERENCE}"), time_rows(found))


if __name__ == "__main__":
    main()
