"""Freewheels, plays, brakes and dogs side by side: each instant of a run obeys its law.

``python tests/drives/instant_drives.py 0 1000`` tries a thousand drives.
"""

import numpy as np
import pytest
from dense_drives import InstantDrive
from hybrid_parts import Contact, Line, Load, steady
from hybrid_reference import BACKWARD, FORWARD, OFF, STICK, Drive
from instant_drives import in_both_orders, simulated
from instant_laws import Law, Part, least_accelerations, nearest
from instant_motions import check
from pressed_reference import Pressed, PressedDrive
from scipy.linalg import expm
from scipy.optimize import brentq

SEEDS = range(16)
BY_A_HAIR = {
    200690: "friction that an impact moves would reverse, but others keep it",
    204690: "the same beside a freewheel",
    200980: "a slow bounce that two others forbid",
    203451: "a freewheel and friction that let go together of a load that turns",
    208420: "a speed across a gear of 1.005 beside two freewheels that share a load",
    206867: "a freewheel is told to have let go, and others keep it at rest",
    207919: "accelerations that are rounding",
    305046: "freewheels that can bear only zero against each other",
    302140: "two stops at one place, with different restitutions",
    603241: "a brake of 3 mN.m beside a stop that carries a thousand times as much",
}


@pytest.mark.parametrize("seed", [*SEEDS, *BY_A_HAIR])
def test_random_drives_obey_their_laws_whatever_the_order_of_declaration(seed):
    verdict = in_both_orders(seed)
    assert verdict.word == "agrees", verdict.text
    assert verdict.finding.instants > 0


# -- runs that are right, and wrong ones that must be found ----------------------------------------

LET_GO = 1.5
HIT = brentq(lambda t: t**3 / 6 - t**2 / 2 + 0.375 * t - 0.5, LET_GO, 10.0, xtol=1e-15)
"""``der(w) == t - 1`` from 1.5 s on, and half a radian to go."""


def pushed():
    """A body whose torque grows with the time, with a brake, and a stop half a radian ahead."""
    row = np.array([1.0])
    brake = Contact("brake", "friction", row, steady(1.0), peak=1.5)
    stop = Contact("stop", "gap", -row, gap=0.5, e=0.5)
    load = Load(row, Line((0.0, 10.0), (0.0, 10.0)))
    return Drive(np.ones(1), np.zeros(1), np.zeros(1), [], [load], [brake, stop], 10.0)


def run(let_go=LET_GO, hit=HIT, bounce=0.5, after=BACKWARD, told=("brake", "stop")):
    """Parts of a run of it that sticks, slides forward, hits the stop and slides back."""
    drive = pushed()
    law, parts, z, loss = Law(drive), [], np.zeros(2), 0.0
    law.enter(0.0)
    ways = ((0.0, let_go, STICK), (let_go, hit, FORWARD), (hit, hit + 0.1, after))
    for begin, end, mode in ways:
        if begin == hit:
            loss = (1 - bounce**2) * z[1] ** 2 / 2
            z[1] *= -bounce
        motion, t = drive.motion((mode, OFF)), np.linspace(begin, end, 5)
        all_of_it = law.state(begin, z[:1], z[1:])
        states = np.array([expm(motion.A * (s - begin)) @ all_of_it for s in t])
        rates = states @ motion.A.T
        parts.append(Part(t, states[:, :1], states[:, 1:2], rates[:, 1:2]))
        z = states[-1, :2].copy()
    events = [(let_go, "brake", 0.0), (hit, "brake", 0.0), (hit, "stop", loss)]
    return check(pushed(), parts, [e for e in events if e[1] in told])


def test_a_right_run_has_no_findings():
    found = run()
    assert found.wrong == []
    assert (found.instants, found.impacts, found.open) == (3, 1, [])


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"let_go": 1.6}, "margin of ['brake']"),
        ({"let_go": 1.4}, "accelerations"),
        ({"hit": HIT + 1e-4}, "margin of ['stop']"),
        ({"hit": HIT - 1e-4}, "speeds"),
        ({"bounce": 0.4}, "speeds"),
        ({"bounce": 1.1}, "speeds"),
        ({"after": OFF}, "accelerations"),
        ({"told": ("stop",)}, "without event"),
        ({"told": ("brake",)}, "J lost"),
    ],
)
def test_what_is_wrong_with_a_run_is_found(changed, text):
    found = run(**changed)
    assert any(text in wrong for wrong in found.wrong), found.wrong


def test_a_freewheel_that_turns_backwards_is_found():
    wheel = Contact("wheel", "freewheel", np.array([1.0, -1.0]))
    loads = [Load(np.array([-1.0, 0.0]), steady(1.0))]
    drive = Drive(np.ones(2), np.zeros(2), np.array([1.0, 0.0]), [], loads, [wheel], 3.0)
    t = np.linspace(0.0, 3.0, 7)
    zero = np.zeros_like(t)
    free = Part(t, np.c_[t - t**2 / 2, zero], np.c_[1 - t, zero], np.c_[zero - 1, zero])
    assert any("margin of ['wheel'] falls to -2" in text for text in check(drive, [free], []).wrong)


@pytest.mark.parametrize(
    ("load", "told", "is_found"), [(0, True, 0), (0, False, 0), (-1, True, 1), (-1, False, 1)]
)
def test_only_a_contact_without_load_may_be_told_open_before_it_moves(load, told, is_found):
    """A body on a stop is lifted from 1 s on; without load the stop may be open from the begin."""
    row = np.ones(1)
    lift = Load(row, Line((1.0, 1.0), (load, 1.0)))
    stop = Contact("stop", "gap", row)
    drive = Drive(np.ones(1), np.zeros(1), np.zeros(1), [], [lift], [stop], 2.0)
    parts = []
    for begin, a in ((0.0, 0.0), (0.5, 0.0), (1.0, 1.0)):
        t = np.linspace(begin, begin + 0.5, 5)
        s = t - begin
        parts.append(Part(t, *((x + 0 * s)[:, None] for x in (a * s**2 / 2, a * s, a))))
    wrong = check(drive, parts, [(0.5, "stop", 0.0)] * told).wrong
    assert ["without event" in text for text in wrong] == [True] * is_found


@pytest.mark.parametrize(("end", "is_its_end"), [(1.02, True), (1.04, False), (0.99, False)])
def test_a_series_of_bounces_ends_when_its_flights_add_up_to_it(end, is_its_end):
    """A flight of 0.02 s, after which each lasts half as long: 0.01 s, 0.005 s, and so on."""
    law = Law(pushed())
    assert law.ends_series("stop", 1.0, np.array([-1.0]), end, [(0.98, "stop", 1.0)]) == is_its_end


def test_any_gap_in_doubt_may_be_the_last_that_is_none():
    law = Law(pushed())
    law.kinds = np.array(["gap"] * 4)
    gap = np.array([0.0, 1.3e-13, 7e-13, 1e-9])
    closed = {tuple(gap < near) for near in law.nears(gap)}
    assert closed == {(True,) * k + (False,) * (4 - k) for k in (1, 2, 3)}


def test_accelerations_that_are_rounding_are_no_reason_to_refuse():
    free = np.array([7e-8, -4e-16, 0.0])
    rows = np.array([[0.0, -1.0, 1.0], [0.0, 1.0, -1.0], [1.0, -1.0, 0.0]])
    received, _ = least_accelerations(np.ones(3), free, rows, np.zeros(3), np.full(3, np.inf))
    assert received == pytest.approx(free, abs=1e-12)


def test_impacts_are_the_nearest_speeds():
    """Three balls in a row, of which the first two touch: by hand for equal inertias."""
    J, v = np.ones(3), np.array([2.0, 0.0, 0.0])
    W = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    received = nearest(J, v, W, np.zeros(2), np.zeros((0, 3)))
    assert received == pytest.approx(np.full(3, 2 / 3), abs=1e-13)
    received = nearest(J, v, W[:1], np.array([1.0]), np.zeros((0, 3)))
    assert received == pytest.approx([0.5, 1.5, 0.0], abs=1e-13)
    received = nearest(J, v, W[:1], np.array([1.0]), W[1:])  # one against two of half the speed
    assert received == pytest.approx([0.0, 1.0, 1.0], abs=1e-13)


@pytest.mark.parametrize(("mu", "expected"), [(0.3, 3 - 0.3 * 1.5 * 2), (1.5, 0.0)])
def test_friction_takes_its_share_of_an_impact_that_presses_it(mu, expected):
    """A body that slides at 3 m/s meets the floor at 2 m/s, with restitution 0.5."""
    along, up = np.eye(2)
    floor = Contact("floor", "gap", up, e=0.5)
    rub = Contact("floor", "friction", along, Pressed(mu, 0, 1))
    weight = Load(up, steady(-9.81))
    law = Law(PressedDrive(np.ones(2), np.zeros(2), np.zeros(2), [], [weight], [floor, rub], 1.0))
    law.enter(0.0)
    before = np.array([3.0, -2.0])
    wrong, is_open, is_impact = law.judged(0.0, np.ones(2, bool), before, [expected, 1.0])
    assert (wrong, is_open, is_impact) == ([], False, True)
    wrong, _, _ = law.judged(0.0, np.ones(2, bool), before, np.array([3.0, 1.0]))
    assert "speeds" in wrong[0]
    rates = law.rates(0.0, np.zeros(2), np.array([1.0, 0.0]))
    assert rates == pytest.approx([-mu * 9.81, 0.0], abs=1e-10)


@pytest.mark.parametrize("backwards", [False, True])
def test_contacts_of_one_row_share_an_impact_in_either_order(backwards):
    run = simulated(InstantDrive(505015), backwards)
    loss = {e.component: e.loss for e in run.events if e.time == 0.0}
    assert loss["wheel11"] == pytest.approx(loss["wheel12"], rel=1e-7)
    assert loss["wheel11"] > 1.0
