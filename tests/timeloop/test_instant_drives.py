"""Freewheels, plays, brakes and dogs side by side: each instant of a run obeys its law.

``python tests/instant_drives.py 0 1000`` tries a thousand drives.
"""

import numpy as np
import pytest
from hybrid_reference import BACKWARD, FORWARD, OFF, STICK, Contact, Drive, Line, Load, steady
from instant_checks import Law, Part, check
from instant_drives import in_both_orders
from instant_problems import nearest
from pressed_reference import Pressed, PressedDrive
from scipy.linalg import expm
from scipy.optimize import brentq

SEEDS = range(16)


@pytest.mark.parametrize("seed", SEEDS)
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
