"""Friction elements that share loads, stand in rings and in long rows."""

import time

import numpy as np
import pytest
from drive_chains import in_turn
from rows import in_a_row

import lumped as lp
from lumped.components import BearingFriction, Brake, Clutch, Fixed, Inertia, OneWayClutch, Torque
from lumped.components.translation import Force, Mass, MassWithStopAndFriction, SupportFriction
from lumped.components.translation import Spring as Coil

YIELDING = 1e-7
"""By how much constraints give way, relatively, where more of them hold than are needed."""


def momentum(run, count, inertias):
    return sum(j * run[f"body[{i}].w"] for i, j in zip(range(count), inertias, strict=True))


# -- more supports than needed -----------------------------------------------------------------

RATE = 2.0


def braked(limits):
    """Shaft under a torque that grows steadily, held by brakes of these capacities."""
    brakes = [Brake(characteristic=((0, 1),), f_max=limit, u=1.0) for limit in limits]
    return in_a_row(drive=Torque(tau=RATE * lp.time), body=Inertia(J=1.5), brake=brakes)


def clutched(limits):
    """The same for clutches between the driven shaft and the ground."""
    clutches = [Clutch(characteristic=((0, 1),), f_max=limit, u=1.0) for limit in limits]
    return lp.compose(
        drive=Torque(tau=RATE * lp.time),
        body=Inertia(J=1.5),
        brake=clutches,
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(m.drive, m.body),
            *(c for clutch in m.brake for c in lp.chain(m.ground, clutch, m.body.flange_b)),
        ],
    )


@pytest.mark.parametrize("limits", [(5.0, 15.0), (1.0, 1.0, 1.0), (0.1, 2.0, 30.0, 7.0)])
@pytest.mark.parametrize("make", [braked, clutched])
def test_parallel_friction_shares_by_its_limits_and_gives_way_at_their_sum(make, limits):
    total = sum(limits)
    free = total / RATE
    model = make(limits)
    run = lp.simulate(lp.assemble(model), until=2 * free)
    times = np.array([event.time for event in run.events])
    assert len(times) == len(limits)
    assert times == pytest.approx(free, rel=1e-6)
    assert np.ptp(times) <= 1e-6 * free
    before, after = run.t < free * (1 - 1e-5), run.t > free * (1 + 1e-5)
    for i, limit in enumerate(limits):
        torque = run[f"brake[{i}].tau"]
        share = RATE * run.t[before] * limit / total
        assert np.abs(torque[before] - share).max() <= 1e-6 * limit
        assert np.abs(torque[after] - limit).max() <= 1e-12 * limit
    expected = RATE * (2 * free - free) ** 2 / 2 / 1.5
    assert run["body.w"][-1] == pytest.approx(expected, rel=1e-5)


def test_parallel_brakes_of_different_peaks_give_way_at_the_sum_of_their_peak_torques():
    brakes = [
        Brake(characteristic=((0, 1),), f_max=f, u=1.0, peak=p) for f, p in ((2, 1.5), (5, 1.1))
    ]
    model = in_a_row(drive=Torque(tau=lp.time), body=Inertia(J=1.5), brake=brakes)
    run = lp.simulate(lp.assemble(model), until=10.0)
    assert [event.time for event in run.events] == pytest.approx([3.0 + 5.5] * 2, rel=1e-6)
    expected = ((10.0 - 7.0) ** 2 - (8.5 - 7.0) ** 2) / 2 / 1.5
    assert run["body.w"][-1] == pytest.approx(expected, rel=1e-5)


def test_what_remains_takes_the_whole_load_when_one_of_two_brakes_is_released():
    model = in_a_row(
        drive=Torque(tau=6.0),
        body=Inertia(J=2.0),
        strong=Brake(characteristic=((0, 1),), f_max=8.0, u=1.0),
        weak=Brake(characteristic=((0, 1),), f_max=4.0, u=lp.ops.where(lp.time >= 1.0, 0.0, 1.0)),
        bearing=BearingFriction(characteristic=((0, 0.5),)),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    early, late = run.t < 1.0, run.t > 1.0
    for name, limit, rest in (("strong", 8.0, 8.0), ("weak", 4.0, 0.0), ("bearing", 0.5, 0.5)):
        torque = run[f"{name}.tau"]
        assert np.abs(torque[early] - 6 * limit / 12.5).max() <= 1e-6
        assert np.abs(torque[late] - 6 * rest / 8.5).max() <= 1e-6
    assert (run["body.w"] == 0.0).all()


# -- rings -------------------------------------------------------------------------------------


def ring(elements, speeds=(0.0, 0.0, 0.0), torque=0.0):
    """Three bodies in a ring of friction elements, of which one is redundant; the first is driven.

    Freewheels let none be slower than the one before.
    """

    def connections(m):
        yield from lp.chain(m.drive, m.body[0])
        for i, element in enumerate(m.element):
            yield lp.connect(m.body[i].flange_b, element.flange_a)
            yield lp.connect(m.body[(i + 1) % 3].flange_b, element.flange_b)

    bodies = [Inertia(J=j, w=w) for j, w in zip((1.0, 2.0, 3.0), speeds, strict=True)]
    return lp.compose(
        drive=Torque(tau=torque), body=bodies, element=elements, connections=connections
    )


@pytest.mark.parametrize("torque", [4.0, -4.0, 0.0])
@pytest.mark.parametrize("make", [lambda: Clutch(f_max=50.0, u=1.0), lambda: OneWayClutch(u=0.0)])
def test_a_ring_turns_as_one_body_and_shares_its_load(make, torque):
    elements = [make() for _ in range(3)]
    run = lp.simulate(lp.assemble(ring(elements, (2.0, 2.0, 2.0), torque)), until=2.0)
    assert not run.events
    expected = 2.0 + torque / 6.0 * run.t
    for i in range(3):
        assert run[f"body[{i}].w"] == pytest.approx(expected, rel=YIELDING)
    assert momentum(run, 3, (1, 2, 3)) == pytest.approx(6 * expected, rel=YIELDING)
    tau = np.array([run[f"element[{i}].tau"] for i in range(3)])
    needed = np.array([-torque + torque / 6, 2 * torque / 6, 3 * torque / 6])
    assert np.abs(tau - np.roll(tau, 1, axis=0) - needed[:, None]).max() <= 1e-6
    if isinstance(elements[0], OneWayClutch):
        assert tau.max() <= 1e-6  # no freewheel pulls
        assert np.abs(tau).max() <= 2 * abs(torque)
    else:
        assert np.abs(tau.sum(axis=0)).max() <= 1e-6  # equal clutches yield alike


@pytest.mark.parametrize("speeds", [(3.0, 1.0, 2.0), (0.0, 1.0, 2.0), (5.0, 5.0, -1.0)])
def test_bodies_of_different_speeds_in_a_ring_of_freewheels_become_one_by_an_impact(speeds):
    J_i = np.array([1.0, 2.0, 3.0])
    run = lp.simulate(lp.assemble(ring([OneWayClutch(u=0.0) for _ in range(3)], speeds)), until=1.0)
    for i in range(3):
        assert np.abs(run[f"body[{i}].w"] - J_i @ speeds / 6).max() <= YIELDING
    assert np.abs(momentum(run, 3, J_i) - J_i @ speeds).max() <= 6 * YIELDING


def test_a_freewheel_overruns_and_takes_over_again():
    """A body is driven through a freewheel by a torque that changes its sign."""
    J_1, J_2, torque, turn = 1.0, 2.0, 3.0, 1.0
    model = in_a_row(
        drive=Torque(tau=torque * lp.ops.where(lp.time >= turn, -1.0, 1.0)),
        a=Inertia(J=J_1),
        wheel=OneWayClutch(u=0.0),
        b=Inertia(J=J_2),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    together = torque / (J_1 + J_2)
    early, late = run.t <= turn, run.t > turn
    assert run["b.w"][early] == pytest.approx(together * run.t[early], rel=1e-9)
    assert run["b.w"][late] == pytest.approx(together * turn, rel=1e-9)
    fall = together * turn - torque / J_1 * (run.t[late] - turn)
    assert np.abs(run["a.w"][late] - fall).max() <= 1e-9


# -- stops -------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1, -1])
def test_a_mass_with_friction_comes_to_rest_at_its_stop_and_leaves_it_by_more_than_friction(way):
    m, friction, peak, gap, rate = 2.0, 3.0, 1.4, 0.25, 1.5
    stops = {-1: gap + 0.05, 1: 1.0}  # the near one and the far one
    push = lp.ops.where(lp.time >= 1.0, 10.0 - rate * (lp.time - 1.0), 10.0)
    limits = {"s_min": -stops[way], "s_max": stops[-way]}
    slide = MassWithStopAndFriction(
        m=m, length=0.1, **limits, characteristic=((0, friction),), peak=peak
    )
    model = in_a_row(push=Force(f=way * push), slide=slide)
    until = 1 + (10 + peak * friction) / rate + 0.3
    run = lp.simulate(lp.assemble(model), until=until, grid=1000)
    hit = np.sqrt(2 * gap * m / (10 - friction))
    speed = (10 - friction) / m * hit
    impact = next(event for event in run.events if event.loss)
    assert impact.time == pytest.approx(hit, rel=1e-9)
    assert impact.loss == pytest.approx(m * speed**2 / 2, rel=1e-9)
    leaves = 1 + (10 + peak * friction) / rate
    resting = (run.t > hit + 1e-6) & (run.t < leaves)
    assert (run["slide.v"][resting] == 0.0).all()
    assert np.abs(way * run["slide.s"][resting] - gap).max() <= 1e-12
    assert (run["slide.position"][resting] == 0.0).all()
    assert np.abs(run["slide.f_stop"] - run["push.f"])[resting].max() <= 1e-6
    assert run.events[-1].time == pytest.approx(leaves, rel=YIELDING)


# -- long rows ---------------------------------------------------------------------------------


def test_of_a_hundred_clutches_in_a_row_the_first_slips_at_the_closed_form_instant():
    J_i, limit, rate = np.random.default_rng(11).uniform(0.5, 2.0, 101), 6.0, 5.0
    model = in_turn(
        aside={"drive": (Torque(tau=rate * lp.time), "body", 0)},
        body=[Inertia(J=j) for j in J_i.tolist()],
        clutch=[Clutch(characteristic=((0, 1),), f_max=limit, u=1.0) for _ in range(100)],
    )
    slips = limit * J_i.sum() / J_i[1:].sum() / rate
    run = lp.simulate(lp.assemble(model), until=2 * slips)
    (event,) = run.events
    assert event.component == "clutch[0]"
    assert event.time == pytest.approx(slips, rel=1e-9)
    last = rate * slips**2 / 2 / J_i.sum() + limit / J_i[1:].sum() * slips
    assert run["body[100].w"][-1] == pytest.approx(last, rel=1e-9)


class WarmGround(SupportFriction):
    """Rough ground that counts its heat: ``der(heat) = f v``."""

    heat: lp.Var = lp.var("J", "heat", state="always")

    def equations(self):
        yield from super().equations()
        yield lp.der(self.heat) == self.f * self.v


def test_a_hundred_blocks_on_rough_ground_come_to_rest_in_balance():
    """Blocks in a row, joined by springs; the first is pushed and released."""
    rng = np.random.default_rng(5)
    limits, count, force, c = rng.uniform(0.5, 1.5, 100), 100, 25.0, 400.0

    def connections(m):
        yield lp.connect(m.push.flange, m.block[0].flange_a)
        for block, ground in zip(m.block, m.ground, strict=True):
            yield lp.connect(block.flange_b, ground.flange_a)
        for left, spring, right in zip(m.block, m.spring, m.block[1:], strict=False):
            yield from lp.chain(left, spring, right)

    model = lp.compose(
        push=Force(f=lp.ops.where(lp.time >= 1.0, 0.0, force)),
        block=[Mass(m=1.0) for _ in range(count)],
        ground=[WarmGround(characteristic=((0, f),), peak=1.2) for f in limits.tolist()],
        spring=[Coil(c=c) for _ in range(count - 1)],
        connections=connections,
    )
    heats = [f"ground[{i}].heat" for i in range(count)]
    started = time.perf_counter()
    system = lp.assemble(model, keep=["block[0].s", *heats])
    run = lp.simulate(system, until=6.0, grid=[0.0, 1.0, 6.0], rtol=1e-9)
    seconds = time.perf_counter() - started
    print(f"{count} blocks: {len(run.events)} events in {seconds:.1f} s")

    assert all(run[f"block[{i}].v"][-1] == 0.0 for i in range(count))
    pull = np.array([0.0, *(run[f"spring[{i}].f"][-1] for i in range(count - 1)), 0.0])
    held = np.array([run[f"ground[{i}].f"][-1] for i in range(count)])
    assert np.abs(np.diff(pull) - held).max() <= 1e-9
    assert (np.abs(held) <= 1.2 * limits * (1 + 1e-9)).all()
    supplied = force * run["block[0].s"][1]
    heat = sum(run[name][-1] for name in heats)
    error = supplied - heat - (pull**2).sum() / (2 * c)
    print(f"{error:.1e} J of {supplied:.3g} J unaccounted")
    assert abs(error) <= 1e-6 * supplied
