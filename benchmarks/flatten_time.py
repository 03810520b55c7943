"""Does the cost of assembling grow linearly with the number of components, whatever the topology?

From objects to a callable right-hand side, in processor time, as a shared machine has no other
that repeats. Every size is timed several times in turn and the best time of each is kept; figures
of different runs differ with the machine's load, so read the ratios.
The second table says what comes out: states against the least possible number, operations of the
right-hand side against those of one written by hand, and memory.

    python -m benchmarks.flatten_time [--large | --peers]

`--large` adds a chain of 100 000 components. `--peers` times a free chain in the other packages of
the extra `bench` that are installed instead, beside lumped at the same size.
"""

import csv
import gc
import resource
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from importlib.util import find_spec
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import casadi as ca
import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import IdealGear, Inertia, Spring, SpringDamper, Torque
from lumped.components.translation import Mass
from lumped.language.expression import Equation
from lumped.support.text_table import table

SIZES = (10, 30, 100, 300, 600, 1000, 3000, 10_000, 30_000)
REFERENCE, COUNTED, MEASURED, LARGE = 600, 3000, 10_000, 100_000
ROUNDS, LONG = 5, 6.0  # what takes longer than so many seconds is timed once
INERTIAS, LIMIT = (10, 30, 100), 120.0  # of the chain in other packages; seconds for each size
RESULTS = Path(__file__).parent / "results"

Made = tuple[lp.Component, int]
"""A model and the least number of states."""


def shafts(pairs: list[tuple[int, int]], n: int) -> Made:
    """Free inertias joined by springs, as a tree."""
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1e3) for _ in pairs],
        connections=lambda m: (
            joint
            for (i, j), shaft in zip(pairs, m.shaft, strict=True)
            for joint in lp.chain(m.body[i], shaft, m.body[j])
        ),
    )
    return model, 2 * n - 1


def chain(size: int) -> Made:
    """Inertias and springs in a row."""
    n = (size + 1) // 2
    return shafts([(i, i + 1) for i in range(n - 1)], n)


def tree(size: int) -> Made:
    """Two springs on each inertia."""
    n = (size + 1) // 2
    return shafts([((i - 1) // 2, i) for i in range(1, n)], n)


def star(size: int) -> Made:
    """All springs on one inertia."""
    n = (size + 1) // 2
    return shafts([(0, i) for i in range(1, n)], n)


def gear_ladder(size: int) -> Made:
    """Inertias and rigid gears in a row."""
    n = (size + 1) // 2
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        gear=[IdealGear(ratio=1.1 if i % 2 else -0.9) for i in range(n - 1)],
        connections=lambda m: (
            joint for i in range(n - 1) for joint in lp.chain(m.body[i], m.gear[i], m.body[i + 1])
        ),
    )
    return model, 1


def geared_chain(size: int) -> Made:
    """Inertias in a row, with a spring and a gear between them."""
    n = max((size + 2) // 3, 2)
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1e3) for _ in range(n - 1)],
        gear=[IdealGear(ratio=1.1 if i % 2 else -0.9) for i in range(n - 1)],
        connections=lambda m: (
            joint
            for i in range(n - 1)
            for joint in lp.chain(m.body[i], m.shaft[i], m.gear[i], m.body[i + 1])
        ),
    )
    return model, 2 * n - 1


def rigid(size: int) -> Made:
    """Inertias in a row, joined directly."""
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(size)],
        connections=lambda m: lp.chain(*m.body),
    )
    return model, 1


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
    parts = {"body": [Inertia(J=j) for j in rng.uniform(0.5, 2, n)]}
    parts["shaft"] = [SpringDamper(c=c, d=0.1) for c in rng.uniform(100, 1000, len(elastic))]
    if rigid_pairs:
        parts["gear"] = [IdealGear(ratio=2.0) for _ in rigid_pairs]
    model = lp.compose(
        **parts,
        connections=lambda m: (
            joint
            for (i, j), part in zip(
                elastic + rigid_pairs, [*m.shaft, *(m.gear if rigid_pairs else ())], strict=True
            )
            for joint in lp.chain(m.body[i], part, m.body[j])
        ),
    )
    turns = all(speed[i] == speed[j] for i, j in loops)
    return model, 2 * (n - len(rigid_pairs)) - turns


TOPOLOGIES: dict[str, Callable[[int], Made]] = {
    "chain": chain,
    "tree": tree,
    "star": star,
    "gear ladder": gear_ladder,
    "geared chain": geared_chain,
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


class Crank(lp.Component):
    """Crank and rod without mass: ``s = r cos(phi) + sqrt(length^2 - r^2 sin(phi)^2)``."""

    flange_a = lp.Flange()
    flange_b = lp.LinearFlange()
    r: lp.Param = lp.param("m", "radius of the crank", above=0)
    length: lp.Param = lp.param("m", "length of the rod", above=0)

    def equations(self) -> Iterator[tuple[Equation, ...]]:
        """Kinematics; the torque follows from virtual work."""
        phi, r = self.flange_a.phi, self.r
        s = r * lp.ops.cos(phi) + lp.ops.sqrt(self.length**2 - (r * lp.ops.sin(phi)) ** 2)
        yield lp.lossless(self.flange_b.s == s, self.flange_a, self.flange_b)


def crank_slider() -> Made:
    """Torque on a crank that drives a mass through a rod."""
    model = lp.compose(
        torque=Torque(tau=2.0),
        crank=Inertia(J=1.0),
        rod=Crank(r=0.1, length=0.3),
        slider=Mass(m=2.0),
        connections=lambda m: lp.chain(m.torque, m.crank, m.rod, m.slider),
    )
    return model, 2


def crank_slider_by_hand() -> ca.Function:
    """Right-hand side of the crank-slider as one would write it, ``s' w = v``."""
    phi, w = ca.SX.sym("phi"), ca.SX.sym("w")
    J, m, r, rod, tau = parameters = [ca.SX.sym(name) for name in ("J", "m", "r", "rod", "tau")]
    x, y = r * ca.cos(phi), r * ca.sin(phi)
    root = ca.sqrt(rod**2 - y**2)
    k = x / root
    lever = 1 + k
    slope = -y * lever  # s'
    bend = -lever * (x + y**2 * (k - 1) / root)  # s''
    torque = tau - m * slope * bend * w**2
    return ca.Function(
        "rhs",
        [ca.vertcat(phi, w), ca.vertcat(*parameters)],
        [ca.vertcat(w, torque / (J + m * slope**2))],
    )


def timed(name: str, size: int) -> tuple[float, float, int]:
    """Processor time to assemble and to build the right-hand side; number of components."""
    gc.collect()
    begin = time.process_time()
    system = lp.assemble(TOPOLOGIES[name](size)[0])
    middle = time.process_time()
    function = system.rhs
    end = time.process_time()
    assert function.size1_out(0) == len(system.state_names)
    return middle - begin, end - middle, system.report()["components"] - 1


def memory(name: str, size: int) -> float:
    """Peak memory of assembling and building the right-hand side in kB for each component.

    To be called in a process of its own.
    """
    assert lp.assemble(TOPOLOGIES[name](10)[0]).rhs
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    system = lp.assemble(TOPOLOGIES[name](size)[0])
    assert system.rhs
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return (peak - before) / (system.report()["components"] - 1)


def times(large: bool) -> dict[str, list[tuple[int, float, float]]]:
    """Components and best times of each topology."""
    best: dict[tuple[str, int], tuple[float, float, int]] = {}
    plan = [(name, size) for name in TOPOLOGIES for size in SIZES]
    if large:
        plan.append(("chain", LARGE))
    for _ in range(ROUNDS):
        for key in plan:
            if key not in best or sum(best[key][:2]) < LONG:
                found = timed(*key)
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
    """The table of states, operations and memory.

    A child's peak begins with the size of its parent, so this comes before all large models.
    """
    rows, kilobytes = [], {}
    for name in TOPOLOGIES:
        with ProcessPoolExecutor(1, get_context("spawn")) as alone:
            kilobytes[name] = alone.submit(memory, name, MEASURED).result()
    made = {name: make(COUNTED) for name, make in TOPOLOGIES.items()}
    made["crank-slider"] = crank_slider()
    hand = {
        "chain": by_hand((made["chain"][1] + 1) // 2, False),
        "geared chain": by_hand((made["geared chain"][1] + 1) // 2, True),
        "crank-slider": crank_slider_by_hand(),
    }
    for name, (model, least) in made.items():
        system = lp.assemble(model)
        operations, best, ratio = system.rhs.n_instructions(), "", ""
        if name in hand:
            best = str(hand[name].n_instructions())
            ratio = f"{operations / hand[name].n_instructions():.2f}"
        count = system.report()["components"] - 1
        cells = (str(count), str(len(system.state_names)), str(least), str(operations), best, ratio)
        rows.append((name, *cells, f"{kilobytes[name]:.1f}" if name in kilobytes else ""))
    return rows


def in_jaxonomy(n: int) -> tuple[float, float]:
    """Seconds to compile a free chain, and to its first derivatives."""
    import jaxonomy
    from jaxonomy.acausal import AcausalCompiler, AcausalDiagram, EqnEnv, rotational

    begin = time.process_time()
    env, diagram = EqnEnv(), AcausalDiagram()
    body = [rotational.Inertia(env, name=f"body_{i}", I=1.0) for i in range(n)]
    shaft = [rotational.Spring(env, name=f"shaft_{i}", K=1e3) for i in range(n - 1)]
    for i in range(n - 1):
        diagram.connect(body[i], "flange", shaft[i], "flange_a")
        diagram.connect(shaft[i], "flange_b", body[i + 1], "flange")
    system = AcausalCompiler(env, diagram)()
    middle = time.process_time()
    builder = jaxonomy.DiagramBuilder()
    builder.add(system)
    whole = builder.build()
    (rates,) = whole.eval_time_derivatives(whole.create_context())
    assert np.isfinite(np.asarray(rates)).all()
    return middle - begin, time.process_time() - middle


MODELICA = """
connector Flange
  Real phi;
  flow Real tau;
end Flange;
model Inertia
  Flange flange_a, flange_b;
  parameter Real J = 1;
  Real phi, w;
equation
  phi = flange_a.phi;
  phi = flange_b.phi;
  w = der(phi);
  J * der(w) = flange_a.tau + flange_b.tau;
end Inertia;
model Spring
  Flange flange_a, flange_b;
  parameter Real c = 1000;
  parameter Real phi_rel0 = 0;
  Real phi_rel, tau;
equation
  phi_rel = flange_b.phi - flange_a.phi;
  tau = c * (phi_rel - phi_rel0);
  flange_b.tau = tau;
  flange_a.tau = -tau;
end Spring;
model Chain
  Inertia body[{n}];
  Spring shaft[{n} - 1];
equation
  for i in 1:{n} - 1 loop
    connect(body[i].flange_b, shaft[i].flange_a);
    connect(shaft[i].flange_b, body[i + 1].flange_a);
  end for;
end Chain;
"""


def in_rumoca(n: int) -> tuple[float, float]:
    """Seconds to compile a free chain, and to simulate the first microsecond.

    The right-hand side itself is out of reach: the exports to CasADi and JAX refuse the chain.
    """
    import rumoca

    begin = time.process_time()
    model = rumoca.Session().loads(MODELICA.replace("{n}", str(n)), model="Chain")
    middle = time.process_time()
    assert len(model.simulate((0.0, 1e-6)))
    return middle - begin, time.process_time() - middle


def in_lumped(n: int) -> tuple[float, float]:
    """Seconds to assemble a free chain, and to build its right-hand side."""
    return timed("chain", 2 * n - 1)[:2]


def best_time(pipe: Connection, chain_in: Callable[[int], tuple[float, float]], n: int) -> None:
    """Send the best time of a few rounds, after a small model that loads what is needed."""
    chain_in(3)
    found: list[tuple[float, float]] = []
    while len(found) < ROUNDS and (not found or sum(found[-1]) < LONG):
        found.append(chain_in(n))
    pipe.send(min(found, key=sum))


def within_limit(
    chain_in: Callable[[int], tuple[float, float]], n: int
) -> tuple[float, float] | None:
    """Best time in a process of its own; None if it takes too long."""
    context = get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=best_time, args=(sender, chain_in, n))
    process.start()
    sender.close()
    found = receiver.recv() if receiver.poll(LIMIT) else None
    process.terminate()
    process.join()
    return found


def peer_rows() -> list[tuple[str, ...]]:
    """The table of times of other packages."""
    peers = {"lumped": in_lumped, "jaxonomy": in_jaxonomy, "rumoca": in_rumoca}
    rows, own = [], {}
    for name, chain_in in peers.items():
        if not find_spec(name):
            continue
        for n in INERTIAS:
            found, count = within_limit(chain_in, n), 2 * n - 1
            cells = (f"chain, {name} {version(name)}", str(count))
            if found is None:
                rows.append((*cells, f"over {LIMIT:.0f}", "", "", ""))
                break
            own.setdefault(n, sum(found))
            each = f"{sum(found) / count * 1e6:.1f}"
            ratio = f"{sum(found) / own[n]:.1f}"
            rows.append((*cells, f"{found[0]:.4f}", f"{found[1]:.4f}", each, ratio))
    return rows


def picture(found: dict[str, list[tuple[int, float, float]]]) -> Figure:
    """Cost per component over the size, one line for each topology."""
    figure = Figure((8, 4.8), layout="constrained")
    axis = figure.subplots()
    for (name, own), marker in zip(found.items(), "osD^v<>", strict=True):
        counts = [count for count, _, _ in own]
        axis.loglog(
            *(counts, [(a + b) / count * 1e6 for count, a, b in own]),
            f"{marker}-",
            markersize=4,
            label=name,
        )
    axis.set_xlabel("components")
    axis.set_ylabel("assemble and build the right-hand side,\nmicroseconds per component")
    axis.grid(which="both", alpha=0.3)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return figure


def write(name: str, rows: list[tuple[str, ...]]) -> None:
    """Print a table and write it as CSV."""
    print(table(rows[0], rows[1:]), end="\n\n")
    with (RESULTS / name).open("w", newline="") as file:
        csv.writer(file).writerows(rows)


def main() -> None:
    """Print the tables, write them as CSV, and draw the times."""
    RESULTS.mkdir(exist_ok=True)
    heads = ("topology", "components", "assemble, s", "build rhs, s", "us/component")
    if "--peers" in sys.argv:
        write("flatten_peers.csv", [(*heads, "ratio to lumped"), *peer_rows()])
        return
    outcome = outcome_rows()
    found = times("--large" in sys.argv)
    write("flatten_time.csv", [(*heads, f"ratio to {REFERENCE}"), *time_rows(found)])
    heads = ("topology", "components", "states", "least", "operations", "by hand", "ratio")
    write("flatten_outcome.csv", [(*heads, "kB/component"), *outcome])
    picture(found).savefig(RESULTS / "flatten_time.png", dpi=150)


if __name__ == "__main__":
    main()
