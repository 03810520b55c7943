"""Storms: impacts that follow each other ever faster."""

from dataclasses import dataclass

import numpy as np
from contact_reference import lost

import lumped as lp
from lumped import components as rotating


@dataclass(frozen=True)
class Storm:
    """Bodies with plays between them that rattle, or stacked with tiny gaps and pressed down."""

    kind: str
    e: float
    count: int
    gap: float = 1e-6

    def model(self):
        load = [5.0] + [0.0] * (self.count - 1) if self.kind == "plays" else [-10.0] * self.count
        bodies = [rotating.Inertia(J=1.0 + 0.5 * i, phi=0.0) for i in range(self.count)]
        if self.kind == "plays":
            parts = [rotating.Backlash(b=self.gap, restitution=self.e) for _ in bodies[1:]]
        else:
            parts = [rotating.Stop(phi_min=-self.gap, restitution=self.e) for _ in bodies]

        def connections(m):
            for body, drive in zip(m.bodies, m.drives, strict=True):
                yield lp.connect(drive.flange, body.flange_a)
            above = m.bodies[1:] if self.kind == "plays" else m.bodies
            for i, (part, body) in enumerate(zip(m.parts, above, strict=True)):
                yield lp.connect(part.flange_b, body.flange_a)
                below = i if self.kind == "plays" else i - 1
                if below >= 0:
                    yield lp.connect(part.flange_a, m.bodies[below].flange_b)

        drives = [rotating.Torque(tau=tau) for tau in load]
        return load, lp.compose(bodies=bodies, drives=drives, parts=parts, connections=connections)

    def run(self, until=1.0, **options):
        """The run; what its instants lost, and the energy that disappeared; greatest speed left."""
        load, model = self.model()
        names = [f"bodies[{i}].{x}" for x in ("w", "phi") for i in range(self.count)]
        system = lp.assemble(model, keep=names[self.count :])
        start = {"bodies[0].w": 10.0} if self.kind == "plays" else {}
        start |= {name: 0.0 for name in names[: self.count] if name not in start}
        run = lp.simulate(system, until=until, grid=10, rtol=1e-9, start=start, **options)
        first, last = run.table(names)[[0, -1]]
        J, n = 1.0 + 0.5 * np.arange(self.count), self.count
        gone = lost(J, np.array(list(start.values())), last[:n]) + load @ (last[n:] - first[n:])
        left = np.ptp(last[:n]) if self.kind == "plays" else np.abs(last[:n]).max()
        _, each = np.unique([e.time for e in run.events], return_inverse=True)
        losses = np.bincount(each, weights=[e.loss for e in run.events])
        return run, losses.tolist(), float(gone), float(left)
