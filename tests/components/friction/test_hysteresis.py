"""Jenkin's element, joints of many, discs of clutches: loops and motions in closed form."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import ClutchDisc, Fixed, Inertia, Iwan, Jenkin, Speed, Spring, Torque
from lumped.errors import EquationError

C, TAU, A, OMEGA = 1000.0, 5.0, 0.02, 2 * np.pi


def driven(part, amplitude=A):
    """A part whose one flange moves as ``amplitude sin(2 pi t)``."""
    w = amplitude * OMEGA * lp.ops.cos(OMEGA * lp.time)
    return assemble_row(wall=Fixed(), part=part, drive=Speed(w=w))


def work(system, rtol=1e-11):
    """Work of the second period."""
    run = lp.simulate(system, until=2.0, rtol=rtol)
    return run.value(lp.functionals.integral("part.tau", "part.w_rel", between=(1.0, 2.0)))


def test_a_jenkin_element_slides_at_exact_instants():
    run = lp.simulate(driven(Jenkin(c=C, tau_max=TAU)), until=0.8, rtol=1e-12)
    twist = TAU / C
    expected = [
        (np.arcsin(twist / A) / OMEGA, "forward"),
        (0.25, "stuck"),
        (0.5 - np.arcsin(1 - 2 * twist / A) / OMEGA, "backward"),
        (0.75, "stuck"),
    ]
    assert [e.after for e in run.events] == [after for _, after in expected]
    times = [e.time for e in run.events]
    assert times == pytest.approx([t for t, _ in expected], abs=1e-10)


@pytest.mark.parametrize("amplitude", [0.004, 0.02, 0.3])
def test_a_loop_of_a_jenkin_element_has_its_area(amplitude):
    area = 4 * TAU * max(amplitude - TAU / C, 0.0)
    assert work(driven(Jenkin(c=C, tau_max=TAU), amplitude)) == pytest.approx(
        area, rel=1e-9, abs=1e-12
    )


def pieces(J, k, c, tau, w):
    """Times at which a free oscillator with Jenkin's element slides and sticks, by its formulas.

    Each piece is a harmonic about its own rest: stuck with ``k + c``, sliding with ``k``. After a
    slide it turns at rest and can only come to the opposite limit.
    """
    stuck, slides, limit = np.sqrt((k + c) / J), np.sqrt(k / J), tau / c
    t = np.arcsin(limit * stuck / w) / stuck
    phi, w, way, times = limit, w * np.cos(stuck * t), 1, [t]
    while True:
        rest = -way * tau / k
        a, b = phi - rest, w / slides
        t += np.arctan2(way * b, way * a) / slides  # the crest of this harmonic
        times.append(t)
        phi = rest + way * np.hypot(a, b)
        rest = c * (phi - way * limit) / (k + c)  # where the torques of both springs cancel
        a, reach = phi - rest, phi - 2 * way * limit - rest
        if abs(reach) >= abs(a):
            return times
        t += np.arccos(reach / a) / stuck
        times.append(t)
        phi, w, way = reach + rest, -way * stuck * np.sqrt(a**2 - reach**2), -way


def test_an_oscillator_comes_to_rest_piece_by_piece():
    J, k, c, tau = 1.0, 500.0, 1000.0, 5.0
    system = assemble_rows(
        "wall joint body",
        "wall held body",
        wall=Fixed(),
        joint=Jenkin(c=c, tau_max=tau),
        held=Spring(c=k),
        body=Inertia(J=J, w=3.0),
    )
    run = lp.simulate(system, until=3.0, rtol=1e-12, certify=True)
    expected = pieces(J, k, c, tau, 3.0)
    assert len(expected) > 8
    times = np.array([e.time for e in run.events])
    assert times[: len(expected)] == pytest.approx(expected, abs=1e-12)
    # from then on each swing ends where the last one did, at the limit but for rounding
    assert np.diff(times[len(expected) :])[::2].max() < 1e-7


BACKBONE = ((0.0, 0.0), (0.002, 3.0), (0.005, 6.0), (0.01, 8.0), (0.03, 9.0))


def on_backbone(phi):
    """The backbone, its last line continued, for both directions."""
    places, torques = np.transpose(BACKBONE)
    beyond = torques[-1] + (np.abs(phi) - places[-1]) * 1.0 / 0.02
    within = np.interp(np.abs(phi), places, torques)
    return np.sign(phi) * np.where(np.abs(phi) > places[-1], beyond, within)


@pytest.mark.parametrize("amplitude", [0.0015, 0.004, 0.02, 0.05])
def test_a_joint_follows_its_backbone_and_masings_rules(amplitude):
    run = lp.simulate(driven(Iwan(backbone=BACKBONE), amplitude), until=1.25, rtol=1e-12)
    phi, tau, t = run["part.phi_rel"], run["part.tau"], run.t
    first, down, up = t <= 0.25, (t >= 0.25) & (t <= 0.75), t >= 0.75
    top = on_backbone(np.array(amplitude))
    assert tau[first] == pytest.approx(on_backbone(phi[first]), abs=1e-9)
    unloading = top - 2 * on_backbone((amplitude - phi[down]) / 2)
    assert tau[down] == pytest.approx(unloading, abs=1e-9)
    loading = -top + 2 * on_backbone((amplitude + phi[up]) / 2)
    assert tau[up] == pytest.approx(loading, abs=1e-9)


def test_the_loss_of_a_joint_is_the_integral_of_its_backbone():
    """By Masing's rules a loop has ``8 int(backbone) - 4 A backbone(A)``."""
    amplitude = 0.02
    phi = np.unique([*np.linspace(0, amplitude, 11), *(x for x, _ in BACKBONE if x < amplitude)])
    area = 8 * np.trapezoid(on_backbone(phi), phi) - 4 * amplitude * on_backbone(amplitude)
    assert work(driven(Iwan(backbone=BACKBONE), amplitude)) == pytest.approx(area, rel=1e-9)


DRIVE = ((0.0, 60.0, 1.0), (0.1, 1500.0, 12.0), (0.3, 1e5, 12.0))
COAST = ((0.0, 60.0, 1.0), (0.05, 1200.0, 8.0))


def test_a_disc_has_its_torque_over_angle():
    amplitude = 0.301
    run = lp.simulate(driven(ClutchDisc(drive=DRIVE, coast=COAST), amplitude), until=1.25)
    phi, tau, w = (run[n] for n in ("part.phi_rel", "part.tau", "part.w_rel"))
    places = [-0.4, -0.05, 0.0, 0.1, 0.3, 0.4]
    torques = np.interp(phi, places, [-3 - 420.0, -3.0, 0.0, 6.0, 306.0, 306.0 + 1e4])
    friction = np.where(phi > 0.1, 12.0, np.where(phi < -0.05, 8.0, 1.0))
    clear = np.min(np.abs(phi[:, None] - np.array([0.1, -0.05])), axis=1) > 1e-9
    clear &= np.abs(w) > 1e-6
    assert clear.sum() > 20
    expected = torques + np.sign(w) * friction
    assert tau[clear] == pytest.approx(expected[clear], rel=1e-9)
    area = 2 * (12 * (0.301 - 0.1) + 1 * 0.15 + 8 * (0.301 - 0.05))
    assert work(driven(ClutchDisc(drive=DRIVE, coast=COAST), amplitude)) == pytest.approx(
        area, rel=1e-9
    )


def test_a_disc_sticks_in_its_friction():
    system = assemble_row(
        wall=Fixed(), part=ClutchDisc(drive=DRIVE), body=Inertia(J=0.1), push=Torque(tau=0.9)
    )
    run = lp.simulate(system, until=1.0)
    assert not run.events
    assert np.abs(run["part.phi_rel"]).max() == 0.0


def test_microslip_damps_as_much_as_its_loop():
    """At resonance a weak push gives what the joint loses: ``pi M A = 4 tau (A - tau / c)``.

    The push is in phase with the speed where the period has the stiffness of the loop.
    """
    J, k, c, tau = 1.0, 5000.0, 50.0, 0.2
    for amplitude in (0.01, 0.04):
        alpha = np.arccos(1 - 2 * tau / (c * amplitude))
        stiffness = c / np.pi * (alpha - np.sin(2 * alpha) / 2)
        omega = np.sqrt((k + stiffness) / J)
        push = 4 * tau * (amplitude - tau / c) / (np.pi * amplitude)
        system = assemble_rows(
            "wall joint body push",
            "wall held body",
            wall=Fixed(),
            joint=Jenkin(c=c, tau_max=tau),
            held=Spring(c=k),
            body=Inertia(J=J),
            push=Torque(tau=push * lp.ops.cos(omega * lp.time)),
        )
        start = {"body.w": amplitude * omega, "joint.phi": 0.0}
        orbit = lp.periodic(system, period=2 * np.pi / omega, start=start, warm_up=30)
        reached = orbit.run.value(lp.functionals.peak("held.phi_rel"))
        assert reached == pytest.approx(amplitude, rel=1e-3)
        lost = orbit.run.value(lp.functionals.integral("joint.tau", "joint.w_slip"))
        assert lost == pytest.approx(4 * tau * (reached - tau / c), rel=1e-6)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (Iwan(backbone=((0.0, 1.0), (1.0, 2.0))), "the first row must be"),
        (Iwan(backbone=((0, 0), (0.01, 0))), "begin with a stiffness above 0"),
        (Iwan(backbone=((0, 0), (1.0, 1.0), (2.0, 3.0))), "must not rise"),
        (Iwan(backbone=((0, 0), (1.0, 1.0), (1.0, 3.0))), "twists must increase"),
        (ClutchDisc(drive=((0.1, 1.0, 1.0),)), "begins at 0.1 rad, not at 0"),
        (ClutchDisc(drive=((0.0, 1.0, -1.0),)), "friction -1 N.m"),
        (ClutchDisc(drive=((0.0, 1.0, 1.0), (0.0, 1.0, 1.0))), "twists must increase"),
    ],
)
def test_rows_without_meaning_are_refused(part, words):
    with pytest.raises(EquationError, match=words):
        driven(part)
