"""Random drive trains of plays, couplings, gears, springs and bodies picked up keep their books."""

import numpy as np
import pytest
from rows import assemble_rows
from test_impact_shafts import at

import lumped as lp
from lumped.components import Backlash, Coupling, IdealGear, Inertia, PickUp, SpringDamper


class Work(lp.Component):
    """Work done on what is joined to the flange by a sine torque: ``der(work) = tau w``."""

    flange = lp.Flange()
    amplitude: lp.Param = lp.param("N.m", "amplitude")
    pulse: lp.Param = lp.param("rad/s", "angular frequency")
    work: lp.Var = lp.var("J", "work done", state="always")

    def equations(self):
        tau = self.amplitude * lp.ops.sin(self.pulse * lp.time)
        yield self.flange.tau == -tau
        yield lp.der(self.work) == tau * lp.der(self.flange.phi)


class Friction(lp.Component):
    """Viscous bearing that counts its heat: ``der(heat) = d w^2``."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "viscous damping")
    heat: lp.Var = lp.var("J", "heat", state="always")

    def equations(self):
        yield self.flange.tau == self.d * lp.der(self.flange.phi)
        yield lp.der(self.heat) == self.d * lp.der(self.flange.phi) ** 2


def link(rng):
    """A random connection of two discs, with its stiffness and play if it has any."""
    kind = rng.integers(4)
    if kind == 0:
        play, restitution = rng.uniform(0.01, 0.05), rng.choice([0.0, 0.3, 0.8])
        return Backlash(b=play, restitution=restitution), 0.0, play
    if kind == 1:
        first, second, third = np.sort(rng.uniform(0, 1, 3))
        return Coupling(u=at(first) - at(second) + at(third)), 0.0, None
    if kind == 2:
        return IdealGear(ratio=rng.uniform(-2, 2)), 0.0, None
    stiffness = rng.uniform(10, 3000)
    return SpringDamper(c=stiffness, phi_rel=0.0), stiffness, None


@pytest.mark.parametrize("seed", range(16))
def test_energy_is_stored_turned_into_heat_or_lost_in_impacts(seed):
    rng = np.random.default_rng(seed)
    J = rng.uniform(0.05, 0.5, rng.integers(3, 7))
    links, stiffness, plays = zip(*(link(rng) for _ in J[1:]), strict=True)
    body, (taken, left) = rng.uniform(0.1, 1), np.sort(rng.uniform(0, 1, 2))
    system = assemble_rows(
        "drive first links/discs bearing load",
        drive=Work(amplitude=rng.uniform(1, 10), pulse=rng.uniform(5, 60)),
        first=Inertia(J=J[0]),
        discs=[Inertia(J=j) for j in J[1:]],
        links=list(links),
        bearing=Friction(d=0.2),
        load=PickUp(J=body, u=at(taken) - at(left)),
    )
    run = lp.simulate(system, until=1.0, rtol=1e-9)
    stored = body / 2 * run["load.w"] ** 2 + J[0] / 2 * run["first.w"] ** 2
    for i, j in enumerate(J[1:]):
        stored = stored + j / 2 * run[f"discs[{i}].w"] ** 2
    for i, c in enumerate(stiffness):
        if c:
            stored = stored + c / 2 * run[f"links[{i}].phi_rel"] ** 2
    times, each = np.unique([e.time for e in run.events], return_inverse=True)
    lost = np.bincount(each, weights=[e.loss for e in run.events])
    so_far = np.array([lost[times < now].sum() for now in run.t])
    heat = run["bearing.heat"]
    error = np.abs(run["drive.work"] - stored - heat - so_far)[~np.isin(run.t, times)].max()
    turned = stored.max() + heat[-1] + lost.sum()
    kinds = ", ".join(type(part).__name__ for part in links)
    print(f"{kinds}: {len(times)} instants, books out by {error / turned:.1e}")
    assert error <= 1e-7 * turned
    assert lost.min() >= -1e-12 * turned
    for i, play in enumerate(plays):
        if play is not None:
            assert np.abs(run[f"links[{i}].phi_rel"]).max() <= play / 2 + 1e-11
