"""Meshes with backlash against closed forms and exponentials, and their curves over the pitch."""

import itertools

import numpy as np
import pytest
import scipy
from checks import refused
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import Damper, Fixed, GearMesh, Inertia, Position, Speed, Torque
from lumped.components.gearing.mesh_series import of_curve
from lumped.errors import LumpedError
from lumped.life.mesh_stiffness import lines_of_contact

J, R, C, D, PLAY, SPEED = 0.05, 0.1, 1e7, 400.0, 1e-4, 0.6
M = J / R**2
FADE = D / (2 * M)
W = np.sqrt(C / M - FADE**2)
DRIVE, BACK = "drive flank", "back flank"


def thrown(way, **options):
    """A gear in the middle of its backlash, moving towards a flank of one that stands."""
    mesh = GearMesh(r_a=0.05, r_b=R, z=20, c=C, b=PLAY, **options)
    turns = -way if mesh.internal else way
    return assemble_row(wall=Fixed(), mesh=mesh, gear=Inertia(J=J, phi=0.0, w=turns * SPEED / R))


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize(("way", "flank"), [(1.0, DRIVE), (-1.0, BACK)])
def test_teeth_fly_touch_and_part_as_in_the_closed_form(way, flank, internal):
    run = lp.simulate(thrown(way, d=D, limited=False, internal=internal), until=2.4e-3, rtol=1e-11)
    free = PLAY / 2 / SPEED
    lasts = (np.pi - np.arctan2(2 * FADE * W, W**2 - FADE**2)) / W  # c g + d v = 0
    leaves = SPEED * np.exp(-FADE * lasts) * (np.cos(W * lasts) - FADE / W * np.sin(W * lasts))
    for after, time in (
        (flank, free),
        (f"{flank} has let go", free + lasts),
        ("parted", free + lasts + D / C),
    ):
        told = [event.time for event in run.events if event.after == after]
        assert told == pytest.approx([time], rel=1e-9)
    assert run["mesh.v"][-1] == pytest.approx(way * leaves, rel=1e-9)
    assert (way * run["mesh.f"] >= -1e-9).all()


def test_without_damping_the_teeth_rattle_for_ever_and_the_energy_stays():
    system = thrown(1.0)
    run = lp.simulate(system, until=0.03, rtol=1e-11)
    times = np.unique([event.time for event in run.events])
    steps = np.where(np.arange(1, len(times)) % 2, np.pi * np.sqrt(M / C), PLAY / SPEED)
    np.testing.assert_allclose(times, PLAY / 2 / SPEED + np.append(0.0, steps.cumsum()), rtol=1e-8)
    assert len(times) > 8
    energy = run[system.model.mesh.stored()] + M * run["mesh.v"] ** 2 / 2
    np.testing.assert_allclose(energy, M * SPEED**2 / 2, rtol=1e-8)


def test_torques_are_the_slopes_of_the_energy():
    """Of an internal pair with harmonics of everything, by a complex step."""
    stiffness, error = ((1.0, 0.3, 0.2), (2.0, -0.1, 1.0)), ((1.0, 2e-5, 0.4),)
    system = assemble_row(
        drive=Position(phi=0.0),
        mesh=GearMesh(
            internal=True, r_a=0.05, r_b=R, z=20, c=C, b=PLAY, stiffness=stiffness, error=error
        ),
        gear=Inertia(J=J),
    )

    def energy(phi_a, phi_b):
        e, share = (
            sum(a * np.cos(k * 20 * phi_a + p) for k, a, p in rows) for rows in (error, stiffness)
        )
        s = 0.05 * phi_a - R * phi_b - e
        g = s - np.sign(s.real) * PLAY / 2 if abs(s.real) > PLAY / 2 else 0.0
        return C * (1 + share) * g**2 / 2

    rng = np.random.default_rng(1)
    pressed = 0
    for _ in range(10):
        phi_a, s = rng.uniform(-1, 1), rng.uniform(-2 * PLAY, 2 * PLAY)
        phi_b = (0.05 * phi_a - s) / R
        point = lp.start_point(
            system, parameters={"drive.phi": phi_a}, start={"gear.phi": phi_b, "gear.w": 0.0}
        )
        tau_a = energy(phi_a + 1e-30j, phi_b).imag / 1e-30 if energy(phi_a, phi_b) else 0.0
        tau_b = energy(phi_a, phi_b + 1e-30j).imag / 1e-30 if energy(phi_a, phi_b) else 0.0
        pressed += tau_b != 0
        found = [point[f"mesh.{port}.tau"] for port in ("flange_a", "flange_b", "support")]
        np.testing.assert_allclose(found, [tau_a, tau_b, -tau_a - tau_b], rtol=1e-9, atol=1e-9)
    assert 0 < pressed < 10


LOAD, SWING, ZETA = 0.1, 0.05, 0.05
"""Of Kahraman and Singh's pair, ``x'' + 2 zeta x' + g(x) = LOAD + SWING cos(n t)``."""


def pair(n):
    """Their pair, in units of half the backlash and of the natural frequency."""
    return assemble_rows(
        "wall mesh gear push",
        "gear film floor",
        wall=Fixed(),
        mesh=GearMesh(r_a=1.0, r_b=1.0, z=1, c=1.0, b=2.0),
        gear=Inertia(J=1.0),
        film=Damper(d=2 * ZETA),
        floor=Fixed(),
        push=Push(n=n),
    )


class Push(lp.Component):
    """``tau = -LOAD - SWING cos(n t)``."""

    flange = lp.Flange()
    n: lp.Param = lp.param("rad/s", "frequency")

    def equations(self):
        yield self.flange.tau == -LOAD - SWING * lp.ops.cos(self.n * lp.time)


def flown(state, n):
    """One period of the piecewise linear pair by matrix exponentials: end, and contacts begun."""
    period = 2 * np.pi / n
    # place, speed, one, cos and sin of the phase
    pieces = {}
    for side, stiffness in ((1, 1.0), (0, 0.0), (-1, 1.0)):
        a = np.zeros((5, 5))
        a[0, 1] = 1.0
        a[1] = [-stiffness, -2 * ZETA, LOAD + side * stiffness, SWING, 0.0]
        a[3, 4], a[4, 3] = -n, n
        pieces[side] = a

    def ahead(side, y, t):
        return scipy.linalg.expm(pieces[side] * t) @ y

    y, t, count = np.array([*state, 1.0, 1.0, 0.0]), 0.0, 0
    side = int(np.sign(y[0])) * (abs(y[0]) > 1)
    while True:
        left = period - t
        for border in (side,) if side else (1, -1):
            times = np.linspace(1e-9, left, 100)
            path = (scipy.linalg.expm(pieces[side] * times[:, None, None]) @ y)[:, 0] - border
            changes = np.flatnonzero(np.diff(np.sign(path)))
            if len(changes):
                at = changes[0]
                found = scipy.optimize.brentq(
                    lambda step: ahead(side, y, step)[0] - border,  # noqa: B023
                    *times[at : at + 2],
                    xtol=1e-15,
                )
                y, t = ahead(side, y, found), t + found
                side = 0 if side else border
                count += side != 0
                break
        else:
            return ahead(side, y, left)[:2], count


def test_an_orbit_with_impacts_is_that_of_the_exponentials():
    n = 0.65
    orbit = lp.periodic(
        pair(n),
        period=2 * np.pi / n,
        start={"mesh.s": 2.5, "gear.w": 0.0},
        warm_up=200 * 2 * np.pi / n,
        rtol=1e-11,
    )
    begin = np.array([orbit["mesh.s"][0], orbit["gear.w"][0]])
    end, contacts = flown(begin, n)
    fixed = scipy.optimize.fsolve(lambda y: flown(y, n)[0] - y, begin, xtol=1e-13)
    print(begin, fixed - begin, end - begin, contacts)
    assert contacts == 1
    assert orbit["mesh.s"].min() < 1  # the teeth part
    np.testing.assert_allclose(begin, fixed, rtol=1e-8)
    expected = np.linalg.eigvals(slopes(fixed, n))
    found = np.sort_complex(orbit.multipliers)
    np.testing.assert_allclose(found, np.sort_complex(expected), rtol=1e-6)


def slopes(begin, n):
    """Derivatives of the end of a period by its beginning."""
    h = 1e-5
    steps = [flown(begin + h * y, n)[0] - flown(begin - h * y, n)[0] for y in np.eye(2)]
    return np.array(steps).T / (2 * h)


def test_jumps_of_the_pair_are_where_the_exponentials_have_a_multiplier_of_one():
    orbit = lp.periodic(
        pair(1.4),
        period=2 * np.pi / 1.4,
        start={"mesh.s": 1.1, "gear.w": 0.0},
        warm_up=100 * 2 * np.pi / 1.4,
    )
    branch = lp.orbits.branch(orbit, along={"push.n": (0.3, 1.4)}, turns=1)
    folds = branch.named("fold")
    assert len(folds) == 2
    for fold in folds:
        near = branch.orbit(fold.number)

        def closes(unknown):
            begin, n = unknown[:2], unknown[2]
            return [*flown(begin, n)[0] - begin, np.linalg.det(slopes(begin, n) - np.eye(2))]

        guess = [near["mesh.s"][0], near["gear.w"][0], fold.value]
        found = scipy.optimize.fsolve(closes, guess, xtol=1e-12)
        print(found[2], fold.value / found[2] - 1)
        assert fold.value == pytest.approx(found[2], rel=1e-7)
        assert flown(found[:2], found[2])[1] == 1  # once a period the teeth part and meet
    low, high = sorted(fold.value for fold in folds)
    assert [orbit.stable for orbit in branch.at((low + high) / 2)].count(True) == 2


@pytest.mark.parametrize(("ratio", "overlap"), [(1.6, 0.0), (1.3, 0.4), (2.2, 1.45)])
def test_the_lines_of_contact_are_those_of_the_field_lines_of_contact(ratio, overlap):
    """Cut by lines one pitch apart, inclined by the overlap, through the middle of the width."""

    def length(x):
        pairs = np.arange(-8, 9)
        # a line reaches over the overlap around its middle; the field over the contact ratio
        middle = x + pairs + (np.floor(ratio) % 2 == 0) / 2 + 0.5
        low = np.maximum(middle - overlap / 2, -ratio / 2)
        high = np.minimum(middle + overlap / 2, ratio / 2)
        return np.maximum(high - low, 0).sum() / overlap

    for k, amplitude, phase in lines_of_contact(ratio, overlap, 5):
        assert phase == 0
        if not overlap:
            # a rectangle of the remainder of the contact ratio around zero
            kinks, value = [0.0, (ratio % 1) / 2], lambda x: 1 + (x < (ratio % 1) / 2)
        else:
            kinks, value = np.linspace(0, 0.5, 21), length
        points = np.unique([*kinks, 0.5])
        integral = sum(
            scipy.integrate.quad(
                lambda x: value(x) * np.cos(2 * np.pi * k * x),  # noqa: B023
                *ends,
                epsabs=1e-12,
            )[0]
            for ends in itertools.pairwise(points)
        )
        assert amplitude == pytest.approx(4 * integral / ratio, abs=1e-9)


def test_a_whole_overlap_keeps_the_stiffness_constant():
    assert np.abs([row[1] for row in lines_of_contact(1.63, 1.0, 12)]).max() < 1e-15


def test_a_curve_is_taken_by_its_harmonics():
    rows = ((0.1, 4.0), (0.4, 4.0), (0.4, 2.0), (0.8, 3.0))
    mean = 0.3 * 4 + 0.4 * 2.5 + 0.3 * 3.5
    pieces = [((0.1, 0.4), (4.0, 4.0)), ((0.4, 0.8), (2.0, 3.0)), ((0.8, 1.1), (3.0, 4.0))]
    x, weights = np.polynomial.legendre.leggauss(40)
    for k, amplitude, phase in of_curve("curve", rows, 6):
        expected = 0.0
        for (a, b), ends in pieces:
            at = a + (b - a) * (x + 1) / 2
            wave = np.interp(at, (a, b), ends) * np.exp(-2j * np.pi * k * at)
            expected += (b - a) * weights @ wave
        assert amplitude * np.exp(1j * phase) == pytest.approx(expected, abs=1e-12)
    stiff = GearMesh(r_a=0.05, r_b=R, z=20, stiffness_curve=rows)
    system = assemble_row(wall=Fixed(), mesh=stiff, gear=Inertia(J=J))
    assert system.parameters["mesh.c"] == pytest.approx(mean, rel=1e-14)


def test_loaded_gears_that_turn_slowly_have_the_static_error():
    """At rest under a constant torque, at several angles."""
    load, curve = 2000.0, ((0.0, 0.0), (0.3, -8e-6), (0.7, 4e-6))
    mesh = GearMesh(
        r_a=0.05, r_b=R, z=20, c=4e8, b=PLAY, contact_ratio=1.6, harmonics=3, error_curve=curve
    )
    system = assemble_row(
        drive=Position(phi=0.0), mesh=mesh, gear=Inertia(J=J), load=Torque(tau=load * R)
    )
    shares = [(k, 2 * np.sin(np.pi * k * 0.6) / (np.pi * k * 1.6)) for k in (1, 2, 3)]
    error = of_curve("error_curve", curve, 3)
    for phi in np.linspace(0.02, 0.3, 5):
        x = 20 * phi
        rest = lp.equilibrium(system, parameters={"drive.phi": phi})
        stiffness = 4e8 * (1 + sum(a * np.cos(k * x) for k, a in shares))
        e = sum(a * np.cos(k * x + p) for k, a, p in error)
        expected = PLAY / 2 + load / stiffness + e
        assert rest["mesh.dte"] == pytest.approx(expected, rel=1e-9)
        told = system.function([system.model.mesh.static_error(load)])
        received = told(rest.x, rest.theta, rest.time, rest.settings)
        assert float(received) == pytest.approx(expected, rel=1e-9)


def gears(**fields):
    mesh = GearMesh(**({"r_a": 0.05, "r_b": R, "z": 20, "c": C} | fields))
    return assemble_row(drive=Speed(w=1.0), mesh=mesh, gear=Inertia(J=J))


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"b": -1e-5}, "b = -1e-05"),
        ({"stiffness_curve": ((0.0, 4e8), (0.0, 3e8), (1.2, 4e8))}, "over one pitch at most"),
        ({"stiffness_curve": ((0.0, 4e8),), "contact_ratio": 1.5}, "one of them"),
        ({"error_curve": ((0.0, 1e-6),), "error": ((1, 1e-6, 0.0),)}, "one of them"),
        ({"contact_ratio": 1.5, "overlap_ratio": -0.1}, "at least 0"),
        ({"stiffness": ((1, 1.2, 0.0),)}, "stiffness is not positive"),
        ({"stiffness": ((-1, 0.2, 0.0),)}, "harmonic -1 must be above 0"),
        ({"overlap_ratio": 1.5}, "contact_ratio is needed"),
        ({"contact_ratio": 1.5, "harmonics": -3}, "harmonics = -3"),
        ({"contact_ratio": 1.5, "harmonics": 2.5}, "harmonics = 2.5"),
    ],
)
def test_slips_are_named(fields, match):
    refused(LumpedError, lambda: gears(**fields), match, "mesh")
