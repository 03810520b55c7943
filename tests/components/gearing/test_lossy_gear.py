"""Gears with loss against their law written a second time, closed forms and energy."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import (
    EfficientGear,
    HeatCapacitor,
    Heated,
    IdealGear,
    Inertia,
    LossyGear,
    Torque,
)

TABLES = {
    "constant": ((0.0, 0.5, 0.6, 0.0, 0.0),),
    "bearing": ((0.0, 0.8, 0.7, 0.4, 0.9),),
    "bearing only": ((0.0, 1.0, 1.0, 0.5, 0.5),),
    "self-locking": ((0.0, 0.6, 0.15, 0.1, 0.2),),
    "speed": ((0.0, 0.9, 0.8, 0.5, 0.7), (20.0, 0.95, 0.9, 1.0, 1.2), (60.0, 0.93, 0.88, 2.0, 2.2)),
}
J_A, J_B, C = 0.05, 0.4, 500.0


class HotGear(Heated, LossyGear):
    """Gear that warms its housing."""


def sine(amplitude, frequency):
    return amplitude * lp.ops.sin(2 * lp.ops.pi * frequency * lp.time)


class Rig(lp.Component):
    """Two bodies, a gear and two torques of different frequency; losses warm a body."""

    drive: Torque = Torque(tau=sine(9.0, 2.0))
    motor: Inertia = Inertia(J=J_A)
    gear: HotGear = HotGear(ratio=-2.5)
    mass: Inertia = Inertia(J=J_B)
    load: Torque = Torque(tau=sine(15.0, 3.0))
    oil: HeatCapacitor = HeatCapacitor(C=C)
    work: lp.Var = lp.var("J", "work of both torques")

    def equations(self):
        yield lp.der(self.work) == self.drive.tau * self.motor.w + self.load.tau * self.mass.w

    def connections(self):
        yield from lp.chain(self.drive, self.motor, self.gear, self.mass, self.load)
        yield lp.connect(self.gear.heat, self.oil.port)


def column(table, speed, i):
    """Table value at a speed; the last line goes on."""
    rows = np.array(table)
    if len(rows) == 1:
        return np.full_like(speed, rows[0, i])
    k = np.clip(np.searchsorted(rows[:, 0], speed, "right") - 1, 0, len(rows) - 2)
    slope = (rows[k + 1, i] - rows[k, i]) / (rows[k + 1, 0] - rows[k, 0])
    return rows[k, i] + slope * (speed - rows[k, 0])


def law(table, w, tau, way):
    """Loss torque of a gear that turns forward (way = 1) or backward (-1)."""
    eta_a, eta_b, tau_a, tau_b = (column(table, np.abs(w), i) for i in (1, 2, 3, 4))
    gap = eta_a - 1 / eta_b
    border = np.where(gap == 0, tau_a / 2, (tau_a - tau_b) / np.where(gap == 0, 1, gap))
    a_side, b_side = (1 - eta_a) * tau, (1 - 1 / eta_b) * tau
    forward = np.where(tau - border >= 0, a_side + tau_a, b_side + tau_b)
    backward = np.where(tau + border >= 0, b_side - tau_b, a_side - tau_a)
    return np.where(way > 0, forward, backward)


@pytest.fixture(scope="module", params=TABLES)
def audited(request):
    """Table and run of the rig with it."""
    table = TABLES[request.param]
    system = lp.assemble(Rig().with_({"gear.losses": table}), keep=["oil.T"])
    return table, lp.simulate(system, until=2.0, rtol=1e-10, grid=4000)


def test_the_loss_follows_the_table_while_the_gear_turns(audited):
    table, run = audited
    w, tau, mode = run["gear.w"], run["gear.flange_a.tau"], run["gear.position"]
    turns = mode != 0
    received = run["gear.tau_loss"][turns]
    expected = law(table, w, tau, mode)[turns]
    assert set(np.unique(mode)) >= {-1.0, 1.0}
    assert received == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert (mode[np.abs(w) > 1e-6] == np.sign(w[np.abs(w) > 1e-6])).all()


def test_it_stands_still_exactly_and_within_its_limits(audited):
    table, run = audited
    stuck = run["gear.position"] == 0
    w, tau, loss = (run[f"gear.{n}"][stuck] for n in ("w", "flange_a.tau", "tau_loss"))
    assert not w.any()
    assert (loss <= law(table, w, tau, 1) + 1e-8).all()
    assert (loss >= law(table, w, tau, -1) - 1e-8).all()


def pair(gear):
    """Two bodies joined by a gear, with steady torques."""
    bodies = {"motor": Inertia(J=0.1), "gear": gear, "mass": Inertia(J=2.0)}
    return in_a_row(drive=Torque(tau=8.0), **bodies, load=Torque(tau=-11.0))


EFFICIENT = EfficientGear(ratio=5.0, eta=0.9)
RATIO, ETA_A, ETA_B, TAU_A, TAU_B = 4.0, 0.8, 0.7, 0.6, 0.9
BREAKING_AWAY = {
    # tau_loss is tau_a while b is free: tau_a = (1 - eta_a) tau_a + bearing
    "driven at a": ("drive", TAU_A / ETA_A),
    # tau_a is zero: the torque at b is ratio times the greater bearing friction
    "driven at b": ("load", RATIO * max(TAU_A, TAU_B)),
}


@pytest.mark.parametrize("name", BREAKING_AWAY)
def test_it_breaks_away_where_the_torque_overcomes_mesh_and_bearing(name):
    source, expected = BREAKING_AWAY[name]

    gear = LossyGear(ratio=RATIO, losses=[(0.0, ETA_A, ETA_B, TAU_A, TAU_B)])
    model = pair(gear).with_({"drive.tau": 0.0, "load.tau": 0.0, f"{source}.tau": lp.time})
    run = lp.simulate(lp.assemble(model), until=1.5 * expected)
    received = [event.time for event in run.events if event.before == "stuck"]
    assert received == pytest.approx([expected], rel=1e-9)


@pytest.mark.parametrize(
    ("drive", "load"), [(8.0, -11.0), (-2.0, 30.0), (-8.0, 11.0), (2.0, -30.0)]
)
@pytest.mark.parametrize("eta", [0.9, 0.4])
def test_power_out_of_an_efficient_gear_is_its_share_of_the_power_in(drive, load, eta):
    changed = {"drive.tau": drive, "load.tau": load, "gear.eta": eta}
    run = lp.simulate(lp.assemble(pair(EFFICIENT)), until=1.0, parameters=changed)
    into_a = run["gear.flange_a.tau"] * run["motor.w"]
    into_b = run["gear.flange_b.tau"] * run["mass.w"]
    least, most = np.minimum(into_a, into_b), np.maximum(into_a, into_b)
    assert most[-1] > 1.0
    assert -least[1:] == pytest.approx(eta * most[1:], rel=1e-9)


def test_an_efficiency_of_one_makes_an_ideal_gear():
    expected = lp.simulate(lp.assemble(pair(IdealGear(ratio=5.0))), until=1.0)["motor.w"]
    for gear, changed in ((EFFICIENT, {"gear.eta": 1.0}), (LossyGear(ratio=5.0), {})):
        run = lp.simulate(lp.assemble(pair(gear)), until=1.0, parameters=changed)
        assert run["motor.w"] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        assert (run["gear.position"] == 2).all()
        assert not run.events


def test_a_torque_on_the_border_of_both_driving_sides_does_not_chatter():
    gear = LossyGear(ratio=1.0, losses=[(0.0, 0.25, 0.25, 0.625, 2.5)])
    system = lp.assemble(pair(gear))
    # equal bodies: half of the loss of 1 N.m brakes each, and tau_a is 0.5 N.m, the border
    changed = {"drive.tau": 0.0, "load.tau": 0.0, "motor.J": 0.5, "mass.J": 0.5}
    run = lp.simulate(system, until=2.0, parameters=changed, start={"motor.w": 1.0})
    received = [event.time for event in run.events if event.after == "stuck"]
    assert received == pytest.approx([1.0], rel=1e-9)
    assert {event.time for event in run.events} == set(received)
