"""Gears with loss against their law written a second time, closed forms and energy."""

import math

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


# -- a screw that holds itself -----------------------------------------------------------------

LEAD, FRICTION_ANGLE, BEARING, HELD = 0.08, 0.15, 0.02, 2.0
"""Angles of the screw's flank and of its friction, and the load, N.m at side a."""
UP, DOWN = (math.tan(LEAD + at) / math.tan(LEAD) for at in (FRICTION_ANGLE, -FRICTION_ANGLE))
"""Torque on the screw over that without friction, raised and lowered; lowered it is negative."""


def screw(drive, load=None, eta_b=DOWN, bearing=0.0):
    """A screw jack: the screw, 0.05 kg.m2, and its load, 2 kg.m2 at side b."""
    table = ((0.0, 1 / UP, eta_b, bearing, bearing),)
    gear = LossyGear(ratio=20.0, losses=table)
    bodies = {"motor": Inertia(J=0.05), "gear": gear, "mass": Inertia(J=2.0)}
    load = -20.0 * HELD if load is None else load
    return in_a_row(drive=Torque(tau=drive), **bodies, load=Torque(tau=load))


@pytest.mark.parametrize("eta_b", [0.0, DOWN, -3.0])
def test_a_screw_holds_its_load_without_torque(eta_b):
    run = lp.simulate(lp.assemble(screw(0.0, eta_b=eta_b)), until=1.0)
    assert not run["motor.w"].any()
    assert run["gear.tau_loss"] == pytest.approx(-HELD, rel=1e-12)


@pytest.mark.parametrize(("way", "expected"), [(1, UP * HELD), (-1, -DOWN * HELD)])
def test_a_screw_breaks_away_up_and_down_as_textbooks_say(way, expected):
    run = lp.simulate(lp.assemble(screw(way * lp.time)), until=1.1 * expected)
    received = [event.time for event in run.events if event.before == "stuck"]
    assert received == pytest.approx([expected], rel=1e-12)


def test_a_lowered_load_stops_without_torque_and_stays():
    tau, end = 3.0, 0.5
    drive = lp.ops.where(lp.time < end, -tau, 0.0)
    run = lp.simulate(lp.assemble(screw(drive)), until=2.0)
    # J_a a = drive - DOWN (J_b a + HELD), as long as the load drives
    J = 0.05 + DOWN * 2.0 / 20**2
    w = (-tau - DOWN * HELD) / J * end
    (stop,) = [event.time for event in run.events if event.after == "stuck"]
    assert stop == pytest.approx(end + w * J / (DOWN * HELD), rel=1e-9)
    assert run["gear.position"][-1] == 0


def test_a_screw_obeys_its_law_and_loses_what_both_torques_give():
    model = screw(sine(9.0, 2.0), sine(60.0, 3.0), bearing=BEARING)
    run = lp.simulate(lp.assemble(model), until=2.0, rtol=1e-10, grid=4000)
    way, tau = run["gear.position"], run["gear.flange_a.tau"]
    load = -run["gear.flange_b.tau"] / 20
    forward = np.maximum(UP * (load + BEARING), DOWN * (load + BEARING))
    backward = np.minimum(UP * (load - BEARING), DOWN * (load - BEARING))
    assert set(way) == {-1.0, 0.0, 1.0}
    assert tau[way > 0] == pytest.approx(forward[way > 0], abs=1e-12)
    assert tau[way < 0] == pytest.approx(backward[way < 0], abs=1e-12)
    assert ((tau <= forward + 1e-9) & (tau >= backward - 1e-9))[way == 0].all()
    assert not run["motor.w"][way == 0].any()
    assert (run["gear.tau_loss"] * run["gear.w"]).min() > -1e-12
