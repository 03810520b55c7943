"""Friction with springs alone on one side, against closed forms and a second formulation."""

import itertools
import pickle

import numpy as np
import pytest
from rows import assemble_row, assemble_rows
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    Brake,
    Clutch,
    Damper,
    Fixed,
    Inertia,
    Jenkin,
    OneWayClutch,
    SlipCoupling,
    Speed,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import SingularModelError, SolverError

C, TAU, A = 1000.0, 5.0, 0.02
OMEGA = 2 * np.pi
SWING = A * OMEGA * lp.ops.cos(OMEGA * lp.time)


def pulled(u=1.0, w=SWING, f_max=2 * TAU, c=C):
    """A brake whose shaft has a spring alone, the other end of which is moved."""
    return assemble_row(brake=Brake(f_max=f_max, u=u), spring=Spring(c=c), drive=Speed(w=w))


def told(run):
    return [(e.time, e.after) for e in run.events if e.component == "brake"]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_it_slides_and_sticks_at_exact_instants(scale):
    system = pulled(f_max=2 * TAU * scale, c=C * scale)
    run = lp.simulate(system, until=1.1, rtol=1e-12)
    twist = TAU / C
    turn = np.arcsin(1 - 2 * twist / A) / OMEGA
    expected = [
        (np.arcsin(twist / A) / OMEGA, "forward"),
        (0.25, "stuck"),
        (0.5 - turn, "backward"),
        (0.75, "stuck"),
        (1.0 - turn, "forward"),
    ]
    assert [after for _, after in told(run)] == [after for _, after in expected]
    for (time, _), (exact, _) in zip(told(run), expected, strict=True):
        assert time == pytest.approx(exact, abs=1e-10)
    assert np.abs(run["spring.tau"]).max() == pytest.approx(TAU * scale, rel=1e-12)


def test_a_cycle_loses_the_area_of_its_loop_and_so_do_derivatives():
    """``4 tau (A - tau / c)``, of which the derivative by tau is ``4 A - 8 tau / c``."""
    work = lp.functionals.integral("brake.tau", "brake.w", between=(1.0, 2.0))
    found = lp.gradient(pulled(), of=[work], until=2.0, by=["brake.f_max"], rtol=1e-9)
    assert found.values[0] == pytest.approx(4 * TAU * (A - TAU / C), rel=1e-9)
    slope = 0.5 * (4 * A - 8 * TAU / C)
    assert float(np.ravel(found.derivatives)[0]) == pytest.approx(slope, rel=1e-7)


class Reference:
    """An oscillator with Jenkin's element, piece by piece: stuck, or sliding one way."""

    def __init__(self, J, k, c, tau, push):
        self.J, self.k, self.c, self.tau, self.push = J, k, c, tau, push

    def piece(self, begin, x, way, until):
        """Integrate until it changes; gives the time, the state and the next way."""

        def rates(t, y):
            phi, w, twist = y
            torque = self.push(t) - self.k * phi - self.c * twist
            return [w, torque / self.J, 0.0 if way else w]

        def border(t, y):
            return way * y[1] if way else self.tau / self.c - abs(y[2])

        border.terminal, border.direction = True, -1
        found = solve_ivp(rates, (begin, until), x, "DOP853", rtol=1e-12, atol=1e-14, events=border)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 0:
            return t, y, None
        if way:
            return t, y, 0
        y[2] = np.copysign(self.tau / self.c, y[2])
        return t, y, int(np.sign(y[2]))

    def run(self, x, until):
        t, way, changes = 0.0, 0, []
        while True:
            t, x, way = self.piece(t, x, way, until)
            if way is None:
                return x, changes
            changes.append(t)


def test_a_forced_oscillator_follows_its_pieces():
    J, k, c, tau = 1.0, 500.0, 1000.0, 5.0
    system = assemble_rows(
        "brake spring body push",
        "wall held body",
        wall=Fixed(),
        brake=Brake(f_max=2 * tau, u=1.0),
        spring=Spring(c=c),
        body=Inertia(J=J),
        push=Torque(tau=8 * lp.ops.cos(25 * lp.time)),
        held=Spring(c=k),
    )
    run = lp.simulate(system, until=3.0, rtol=1e-12)
    reference = Reference(J, k, c, tau, lambda t: 8 * np.cos(25 * t))
    x, changes = reference.run([0.0, 0.0, 0.0], 3.0)
    assert len(changes) > 40
    assert [time for time, _ in told(run)] == pytest.approx(changes, abs=1e-8)
    assert run["body.w"][-1] == pytest.approx(x[1], abs=1e-8)
    assert run["spring.phi_rel"][-1] == pytest.approx(x[2], abs=1e-10)


def test_a_limit_that_falls_lets_the_spring_relax_at_once():
    falls = lp.ops.where(lp.time < 0.12, 1.0, 0.2)
    run = lp.simulate(pulled(u=falls), until=1.1, rtol=1e-12)
    just_after = run["spring.tau"][run.t > 0.12][0]
    assert just_after == pytest.approx(0.2 * TAU, rel=1e-12)
    back = 0.5 - np.arcsin(1 - 0.4 * TAU / C / A) / OMEGA
    assert told(run)[1:3] == [(pytest.approx(0.25), "stuck"), (pytest.approx(back), "backward")]


def test_a_limit_that_rises_lets_it_stick():
    rises = lp.ops.where(lp.time < 0.12, 0.2, 1.0)
    run = lp.simulate(pulled(u=rises), until=0.25, rtol=1e-12)
    slides = np.arcsin(np.sin(0.12 * OMEGA) + 0.8 * TAU / C / A) / OMEGA
    times = [(pytest.approx(0.12), "stuck"), (pytest.approx(slides, abs=1e-10), "forward")]
    assert told(run)[1:] == [*times, (pytest.approx(0.25), "stuck")][: len(told(run)) - 1]


def test_without_pressure_the_shaft_is_free_until_it_is_pressed_again():
    off = lp.ops.where(lp.time < 0.12, 1.0, lp.ops.where(lp.time < 0.6, 0.0, 1.0))
    run = lp.simulate(pulled(u=off), until=0.7, rtol=1e-12)
    free = (run.t > 0.12) & (run.t < 0.6)
    assert free.any()
    assert np.abs(run["spring.tau"][free]).max() < 1e-12
    assert (run["brake.position"][free] == 2).all()
    slides = 0.5 + np.arcsin(np.sin(0.1 * OMEGA) + TAU / C / A) / OMEGA
    assert told(run)[-1] == (pytest.approx(slides, abs=1e-10), "backward")


def test_a_ramp_down_follows_its_limit():
    ramp = lp.ops.maximum(0.0, 1.0 - 3 * lp.time)
    run = lp.simulate(pulled(u=ramp, w=1.0), until=0.5, rtol=1e-12)
    begin = TAU / (C + 3 * TAU)
    assert told(run)[0] == (pytest.approx(begin, abs=1e-12), "forward")
    expected = TAU * np.clip(1 - 3 * run.t, 0, C * run.t / TAU)
    assert run["spring.tau"] == pytest.approx(expected, abs=1e-11)


def test_a_limit_that_swings():
    swings = 1 + 0.5 * lp.ops.sin(9 * lp.time)
    run = lp.simulate(pulled(u=swings), until=0.25, rtol=1e-12)
    begin = brentq(
        lambda t: C * A * np.sin(OMEGA * t) - TAU * (1 + 0.5 * np.sin(9 * t)), 0.01, 0.1, xtol=1e-15
    )
    assert told(run)[0] == (pytest.approx(begin, abs=1e-11), "forward")
    late = run.t > begin
    limit = TAU * (1 + 0.5 * np.sin(9 * run.t[late]))
    assert run["spring.tau"][late] == pytest.approx(limit, rel=1e-10)


@pytest.mark.parametrize("f_max", [2e-3, 40.0, 2e4])
@pytest.mark.parametrize(
    ("u", "pressed"),
    [
        (lp.ops.cos(lp.time), np.cos),
        (abs(lp.ops.cos(lp.time)), lambda t: abs(np.cos(t))),
        (lp.ops.maximum(lp.ops.cos(lp.time), 0.0), np.cos),
        (lp.ops.exp(-lp.time) - 0.5, lambda t: np.exp(-t) - 0.5),
    ],
)
def test_pressure_that_goes_to_zero_smoothly(u, pressed, f_max):
    c = 22.5 * f_max
    run = lp.simulate(pulled(u=u, w=1.0, f_max=f_max, c=c), until=3.0, grid=600)
    limit = f_max / 2 * np.maximum(pressed(run.t), 0.0)
    slides = run.t > 0.05  # a limit rises slower than the spring is wound
    np.testing.assert_allclose(abs(run["spring.tau"][slides]), limit[slides], atol=1e-6 * f_max)


def test_a_freewheel_behind_a_spring_lets_a_body_bounce_off():
    system = assemble_row(
        left=Inertia(J=1.0, w=3.0),
        wheel=OneWayClutch(u=0.0),
        spring=Spring(c=C),
        right=Inertia(J=2.0),
    )
    run = lp.simulate(system, until=1.0, rtol=1e-12)
    (event,) = run.events
    assert event.time == pytest.approx(np.pi / np.sqrt(C * (1 + 1 / 2)), abs=1e-11)
    assert run["left.w"][-1] == pytest.approx(-1.0, abs=1e-9)
    assert run["right.w"][-1] == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("names", list(itertools.permutations(["first", "clutch", "second"])))
def test_two_bodies_come_to_one_speed_whatever_the_order(names):
    """Between bodies of one speed and another it slides once: energy and momentum."""
    parts = {
        "first": Spring(c=C),
        "clutch": SlipCoupling(kinetic=TAU, static=TAU, u=1.0),
        "second": Spring(c=2 * C),
    }
    own = {name: parts[name] for name in names}
    system = assemble_row(left=Inertia(J=1.0, w=3.0), **own, right=Inertia(J=2.0))
    run = lp.simulate(system, until=3.0, rtol=1e-11, certify=True)
    tied = C * 2 * C / (3 * C)
    slides = TAU / tied  # the twist at which it slides
    wave = np.sqrt(tied * 1.5)
    begin = np.arcsin(slides * wave / 3.0) / wave
    w_begin = 3.0 * np.cos(wave * begin)
    stop = begin + w_begin / (TAU * 1.5)
    sliding = [e.time for e in run.events if e.component == "clutch"][:2]
    assert sliding == pytest.approx([begin, stop], abs=1e-9)
    momentum = run["left.w"] + 2 * run["right.w"]
    assert momentum == pytest.approx(np.full(len(momentum), 3.0), abs=1e-9)


def test_what_differs_at_rest_is_refused():
    system = assemble_row(
        brake=Brake(f_max=2 * TAU, u=1.0, peak=1.2), spring=Spring(c=C), drive=Speed(w=SWING)
    )
    with pytest.raises(
        SolverError, match=r"brake \(Brake\): static over kinetic friction .* = 1.2"
    ):
        lp.simulate(system, until=1.0)


def test_two_brakes_where_there_is_no_inertia_are_refused():
    parts = {"first": Inertia(J=0.1), "spring": Spring(c=10.0), "last": Inertia(J=0.3)}
    brakes = {"a": Brake(f_max=1.0, u=1.0), "b": Brake(f_max=2.0, u=1.0), "other": Spring(c=10.0)}
    rows = "first spring other last", "spring.flange_b a.flange_a", "spring.flange_b b.flange_a"
    with pytest.raises(SingularModelError, match="a, b hold and slide without inertia"):
        assemble_rows(*rows, **parts, **brakes)


def test_friction_that_depends_on_the_speed_is_refused():
    with pytest.raises(SingularModelError, match="depend on the sliding speed, or if"):
        assemble_row(
            left=Inertia(J=1.0),
            clutch=Clutch(f_max=1.0, u=1.0, characteristic=((0, 0.5), (10, 0.4))),
            spring=Spring(c=C),
            right=Inertia(J=1.0),
        )


def test_a_system_in_another_process_is_the_same():
    copy = pickle.loads(pickle.dumps(pulled()))
    mine, other = (lp.simulate(s, until=1.1) for s in (pulled(), copy))
    assert np.array_equal(mine["spring.tau"], other["spring.tau"])


def test_orbit_of_a_massless_brake():
    orbit = lp.periodic(pulled(), period=1.0, warm_up=2)
    work = orbit.run.value(lp.functionals.integral("brake.tau", "brake.w"))
    assert work == pytest.approx(4 * TAU * (A - TAU / C), rel=1e-6)


# -- damped springs ----------------------------------------------------------------------------

D = 20.0
EXACT = {"rtol": 1e-11, "atol": 1e-14, "max_step": 1e-4}


def damped(u=1.0, peak=1.0):
    return assemble_row(
        brake=Brake(f_max=2 * TAU, u=u, peak=peak),
        spring=SpringDamper(c=C, d=D),
        drive=Speed(w=SWING),
    )


def twisted(tau, pieces):
    """Twist of a damped spring behind friction: it follows, or relaxes to ``tau / c``."""

    def rate(t, phi, limit):
        follows = A * OMEGA * np.cos(OMEGA * t)
        return (np.clip(C * phi + D * follows, -limit, limit) - C * phi) / D

    phi, t = np.zeros(1), 0.0
    for until, share in pieces:
        found = solve_ivp(
            rate,
            (t, until),
            phi,
            "LSODA",
            rtol=1e-11,
            atol=1e-14,
            max_step=1e-4,
            args=(tau * share,),
        )
        t, phi = until, found.y[:, -1]
    return phi[0]


@pytest.mark.parametrize(
    "pieces",
    [[(1.3, 1.0)], [(0.12, 1.0), (0.6, 0.2), (1.3, 1.0)], [(0.12, 1.0), (0.6, 0), (1.3, 1)]],
)
def test_a_damped_spring_follows_or_relaxes(pieces):
    u = 0.0
    for end, share in reversed(pieces):
        u = lp.ops.where(lp.time < end, share, u)
    run = lp.simulate(damped(u), until=1.3, rtol=1e-11)
    assert run["spring.phi_rel"][-1] == pytest.approx(twisted(TAU, pieces), abs=1e-9)
    assert np.abs(run["spring.tau"]).max() <= TAU * (1 + 1e-9)


def test_derivatives_beside_a_damped_spring():
    last = lp.functionals.final("spring.phi_rel")
    found = lp.gradient(damped(), of=[last], until=1.3, by=["brake.f_max"], rtol=1e-8)
    h = 1e-4
    slope = (twisted(TAU + h / 2, [(1.3, 1)]) - twisted(TAU - h / 2, [(1.3, 1)])) / (2 * h)
    assert float(np.ravel(found.derivatives)[0]) == pytest.approx(slope, rel=1e-5)


def test_beside_a_damped_spring_friction_may_be_greater_at_rest():
    run = lp.simulate(damped(peak=1.2), until=0.2, rtol=1e-12)

    def beyond(t):
        return C * A * np.sin(OMEGA * t) + D * A * OMEGA * np.cos(OMEGA * t) - 1.2 * TAU

    (begin, _), *_ = told(run)
    assert begin == pytest.approx(brentq(beyond, 0.001, 0.1, xtol=1e-15), abs=1e-9)
    assert run["spring.tau"][run.t > begin] == pytest.approx(TAU, rel=1e-9)


def test_a_prescribed_speed_that_turns_at_once():
    turns = lp.ops.where(lp.time < 0.1, 1.0, -1.0)
    system = assemble_row(
        brake=Brake(f_max=2 * TAU, u=1.0), spring=SpringDamper(c=C, d=D), drive=Speed(w=turns)
    )
    run = lp.simulate(system, until=0.2, rtol=1e-12)
    relaxed = TAU / C * (1 - np.exp(-C * 0.1 / D))
    back = -TAU / C + (relaxed + TAU / C) * np.exp(-C * 0.1 / D)
    assert run["spring.phi_rel"][-1] == pytest.approx(back, rel=1e-9)
    assert [after for _, after in told(run)] == ["backward"]


def test_damped_and_undamped_springs_in_one_drive():
    system = assemble_row(
        left=Inertia(J=1.0, w=3.0),
        clutch=SlipCoupling(kinetic=TAU, static=TAU, u=1.0),
        shaft=SpringDamper(c=C, d=1.0),
        middle=Inertia(J=1.0),
        joint=Jenkin(c=C, tau_max=TAU),
        right=Inertia(J=2.0),
    )
    run = lp.simulate(system, until=3.0, rtol=1e-10, certify=True)
    assert {"clutch", "joint"} <= {event.component for event in run.events}
    assert run.certificate.energy.error < 1e-8
    momentum = run["left.w"] + run["middle.w"] + 2 * run["right.w"]
    assert momentum == pytest.approx(np.full(len(momentum), 3.0), abs=1e-8)


@pytest.mark.parametrize("slope", [2.0, -2.0])
def test_beside_a_damped_spring_friction_may_depend_on_the_speed(slope):
    """Sliding, ``c phi + d (w_end - w) = tau + slope w`` gives w, here by SciPy."""
    rows = ((0.0, TAU), (1.0, TAU + slope))
    system = assemble_row(
        brake=Brake(f_max=1.0, u=1.0, characteristic=rows),
        spring=SpringDamper(c=C, d=D),
        drive=Speed(w=SWING),
    )

    def rate(t, phi):
        follows = A * OMEGA * np.cos(OMEGA * t)
        tau = C * phi + D * follows
        return follows - np.sign(tau) * np.maximum(np.abs(tau) - TAU, 0.0) / (D + slope)

    found = solve_ivp(rate, (0, 0.3), [0.0], "LSODA", **EXACT)
    run = lp.simulate(system, until=0.3, rtol=1e-11)
    assert run["spring.phi_rel"][-1] == pytest.approx(found.y[0, -1], abs=1e-9)


@pytest.mark.parametrize(
    "made",
    [
        lambda c: {"joint": Jenkin(c=c, tau_max=300.0)},
        lambda c: {"clutch": Clutch(f_max=600.0, u=1.0), "joint": Spring(c=c)},
    ],
)
def test_orders_pass_what_sticks_as_a_spring(made):
    J, d, speeds = (0.1, 0.3), 1.0, np.array([10.0, 20.0])
    system = assemble_row(
        f=Torque(tau=0.0),
        J1=Inertia(J=J[0]),
        **made(C),
        J2=Inertia(J=J[1]),
        load=Damper(d=d),
        ground=Fixed(),
    )
    found = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["joint.tau"],
        shaft="J1.phi",
        free="f.tau",
        excitations={"f.tau": {2: 1.0}},
    )
    expected = []
    for w in 2 * speeds:
        stiffness = [[C - J[0] * w**2, -C], [-C, C - J[1] * w**2 + 1j * d * w]]
        a, b = np.linalg.solve(stiffness, [1.0, 0.0])
        expected.append(C * abs(a - b))
    np.testing.assert_allclose(found.magnitude("joint.tau", 2), expected, rtol=1e-9)
    np.testing.assert_allclose(found.mean("joint.tau"), -d * speeds, rtol=1e-9)
