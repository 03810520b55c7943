"""What does a branch of periodic motions cost?

Gears that rattle, 6 states: pinion, wheel and load on shafts, a mesh with play whose stiffness
varies as the teeth come and go. The branch over the speed of the mesh passes folds, and borders at
which the teeth begin to part and to touch at their backs.

    python -m benchmarks.branches
"""

import time

import numpy as np

import lumped as lp
from benchmarks.hybrid import write
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.ops import cos, where
from lumped.support.text_table import table

LOW, HIGH = 1500.0, 4000.0


class Mesh(lp.Component):
    """Play with elastic teeth, ``c (1 + share cos(W t))`` stiff beyond ``b / 2``."""

    flange_a, flange_b = lp.Flange(), lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "mean stiffness", 4e5)
    d: lp.Param = lp.param("N.m.s/rad", "damping", 4.0)
    b: lp.Param = lp.param("rad", "play", 4e-4)
    share: lp.Param = lp.param("1", "by which the stiffness varies", 0.25)
    W: lp.Param = lp.param("rad/s", "angular frequency of the mesh", LOW)
    twist: lp.Var = lp.var("rad", "relative angle", nominal=1e-4, state="prefer")
    w_rel: lp.Var = lp.var("rad/s", "its rate", nominal=0.1)
    tau: lp.Var = lp.var("N.m", "torque on flange b")

    def equations(self):
        """As a spring and damper, with play."""
        yield self.twist == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == lp.der(self.twist)
        stiffness = self.c * (1 + self.share * cos(self.W * lp.time))
        half = self.b / 2
        over = where(
            self.twist > half,
            self.twist - half,
            where(self.twist < -half, self.twist + half, 0.0),
        )
        yield self.tau == stiffness * over + self.d * self.w_rel
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau


def gears() -> lp.System:
    """The drive, seen from a frame that turns with it."""

    def joints(m):
        yield from lp.chain(m.frame, m.input, m.pinion, m.mesh, m.wheel, m.output, m.load)
        yield from lp.chain(m.load, m.slip, m.rest)
        yield lp.connect(m.torque.flange, m.load.flange_a)

    return lp.assemble(
        lp.compose(
            frame=Fixed(),
            input=SpringDamper(c=2e4, d=4.0),
            pinion=Inertia(J=0.1),
            mesh=Mesh(),
            wheel=Inertia(J=0.4),
            output=SpringDamper(c=3e4, d=8.0),
            load=Inertia(J=2.0),
            slip=Damper(d=20.0),
            rest=Fixed(),
            torque=Torque(tau=60.0),
            connections=joints,
        )
    )


def begun(system: lp.System) -> lp.orbits.PeriodicOrbit:
    """The motion at the lowest speed."""
    period = 2 * np.pi / LOW
    return lp.periodic(system, period=period, warm_up=400 * period)


def main() -> None:
    """Cost over the longest step."""
    system = gears()
    orbit = begun(system)
    rows = []
    for step in (0.05, 0.02, 0.01):
        best, branch = np.inf, None
        for _ in range(3):
            begin = time.perf_counter()
            branch = lp.orbits.branch(orbit, over="mesh.W", between=(LOW, HIGH), turns=1, step=step)
            best = min(best, time.perf_counter() - begin)
        count = len(branch.values)
        passed = ", ".join(f"{p.kind} {p.value:.2f}" for p in branch.points)
        rows.append((f"{step}", f"{count}", f"{best:.2f}", f"{1e3 * best / count:.2f}", passed))
    head = ("step", "motions", "s", "ms each", "passed")
    print(table(head, rows))
    write("branches.csv", head, rows)


if __name__ == "__main__":
    main()
