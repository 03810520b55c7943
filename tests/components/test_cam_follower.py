"""Cams and followers against closed forms of contact, lift-off, flight and landing."""

import numpy as np
import pytest
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import Cam, CamFollower, Inertia, Position, Speed, cam_motion, translation
from lumped.errors import EquationError, StartError

H, M, C, F_0 = 0.02, 0.8, 4e3, 60.0
ECCENTRIC = Cam(profile=lambda x: H / 2 * (1 - lp.ops.cos(x)))
POINTS = ((0.0, 0.0), (1.2, 0.02), (2.0, 0.02), (3.7, 0.005), (4.5, 0.0))
LIMIT = np.sqrt(2 * (F_0 + C * H) / (M * H))
"""At the top the spring just holds the mass: m w^2 h / 2 = F_0 + c h."""


def running(w, until, restitution=0.0, **options):
    system = assemble_row(
        turn=Position(phi=w * lp.time),
        follower=CamFollower(cam=ECCENTRIC, m=M, c=C, F_0=F_0, restitution=restitution),
    )
    return lp.simulate(system, until=until, **options)


class TestFollower:
    def test_on_the_cam_its_force_is_that_of_spring_and_inertia(self):
        w = 0.99 * LIMIT
        run = running(w, 6 * np.pi / w)
        x = w * run.t
        expected = F_0 + C * H / 2 * (1 - np.cos(x)) + M * H / 2 * w**2 * np.cos(x)
        assert run.events == ()
        assert np.abs(-run["follower.contact.f"] - expected).max() < 1e-10 * expected.max()

    @pytest.mark.parametrize(("share", "lifts"), [(0.9999, False), (1.0001, True)])
    def test_it_lifts_off_above_the_speed_at_which_the_spring_just_holds_it(self, share, lifts):
        run = running(share * LIMIT, 4 * np.pi / LIMIT)
        assert any(event.after == "open" for event in run.events) == lifts

    def test_lift_off_flight_and_landing(self):
        """In the air it swings about -F_0 / c; the landing is where this meets the cam again."""
        w = 1.6 * LIMIT
        off = np.arccos(-(F_0 + C * H / 2) / (H / 2 * (M * w**2 - C))) / w
        own = np.sqrt(C / M)
        s_0, v_0 = H / 2 * (1 - np.cos(w * off)), H / 2 * w * np.sin(w * off)

        def flight(t):
            way = (s_0 + F_0 / C) * np.cos(own * (t - off)) + v_0 / own * np.sin(own * (t - off))
            return way - F_0 / C

        def gap(t):
            return flight(t) - H / 2 * (1 - np.cos(w * t))

        tries = off + np.linspace(0.05, 3, 600) * np.pi / w
        after = tries[np.argmax(np.array([gap(t) for t in tries]) < 0)]
        land = scipy.optimize.brentq(gap, off + 0.05 * np.pi / w, after, xtol=1e-15)
        run = running(w, land * 1.01, rtol=1e-11, grid=400)
        first, second = run.events[:2]
        assert np.isclose(first.time, off, rtol=1e-8)
        assert np.isclose(second.time, land, rtol=1e-8)
        inside = (run.t > off) & (run.t < land)
        assert np.abs(run["follower.mass.s"] - flight(run.t))[inside].max() < 1e-9 * H
        v = (flight(land + 1e-7) - flight(land - 1e-7)) / 2e-7
        lost = M * (v - H / 2 * w * np.sin(w * land)) ** 2 / 2
        assert np.isclose(second.loss, lost, rtol=1e-6)

    def test_an_elastic_contact_may_stand_in_and_is_softer(self):
        c_gap, w = 1e9, 0.9 * LIMIT
        gap = translation.ElastoGap(c=c_gap)
        system = assemble_row(
            turn=Position(phi=w * lp.time),
            follower=CamFollower(cam=ECCENTRIC, contact=gap, m=M, c=C, F_0=F_0),
        )
        run = lp.simulate(system, until=2 * np.pi / w, grid=200)
        assert np.abs(run["follower.mass.s"] - H / 2 * (1 - np.cos(w * run.t))).max() < 1e-6

    def test_a_flywheel_and_a_bouncing_follower_keep_their_energy(self):
        """But for the losses of the impacts, told one by one."""
        system = assemble_row(
            wheel=Inertia(J=0.02, w=1.5 * LIMIT),
            follower=CamFollower(cam=ECCENTRIC, m=M, c=C, F_0=F_0, restitution=0.6),
        )
        run = lp.simulate(system, until=0.12, rtol=1e-11)
        s, v = run["follower.mass.s"], run["follower.mass.v"]
        energy = 0.01 * run["wheel.w"] ** 2 + M / 2 * v**2 + (F_0 + C / 2 * s) * s
        losses = [event.loss for event in run.events]
        assert sum(loss > 1e-3 for loss in losses) >= 2
        assert np.isclose(energy[0] - energy[-1], sum(losses), rtol=1e-6)


LAWS = {
    "cycloidal": lambda u: u - np.sin(2 * np.pi * u) / 2 / np.pi,
    "harmonic": lambda u: (1 - np.cos(np.pi * u)) / 2,
    "polynomial": lambda u: 10 * u**3 - 15 * u**4 + 6 * u**5,
}


def lifted(profile, w=2.0, turns=2.0, **options):
    system = assemble_row(
        turn=Position(phi=w * lp.time - 3.0),
        cam=Cam(profile=profile),
        mass=translation.Mass(m=1.0),
        keep=["mass.s", "turn.phi"],
    )
    return lp.simulate(system, until=2 * np.pi * turns / abs(w), **options)


class TestMotion:
    @pytest.mark.parametrize("law", LAWS)
    @pytest.mark.parametrize("w", [2.0, -2.0])
    def test_lift_is_that_of_the_law_in_every_turn(self, law, w):
        run = lifted(cam_motion(POINTS, law), w, grid=500)
        angles = np.array([*(a for a, _ in POINTS), 2 * np.pi])
        lifts = np.array([*(s for _, s in POINTS), 0.0])
        x = run["turn.phi"] % (2 * np.pi)
        i = np.clip(np.searchsorted(angles, x, side="right") - 1, 0, len(POINTS) - 1)
        u = (x - angles[i]) / (angles[i + 1] - angles[i])
        expected = lifts[i] + (lifts[i + 1] - lifts[i]) * LAWS[law](u)
        assert np.abs(run["mass.s"] - expected).max() < 1e-14

    def test_greatest_acceleration_of_a_cycloid_is_that_of_the_books(self):
        """2 pi h (w / width)^2 at a quarter of the rise."""
        quarter = (3.0 + 0.3) / 2
        run = lifted(cam_motion(POINTS), turns=quarter / np.pi)
        assert np.isclose(run["mass.a"][-1], 2 * np.pi * 0.02 * (2 / 1.2) ** 2, rtol=1e-12)

    def test_a_run_stops_at_the_points(self):
        run = lifted(cam_motion(POINTS, "harmonic"), turns=1.0)
        times = np.array([event.time for event in run.events])
        for angle, _ in POINTS:
            assert np.abs(times - (angle + 3.0) % (2 * np.pi) / 2).min() < 1e-12

    @pytest.mark.parametrize(
        ("points", "message"),
        [
            (((0.0, 0.0),), "at least two angles"),
            (((0.0, 0.0), (2.0, 0.01), (1.0, 0.0)), "that increase within one turn"),
            (((0.0, 0.0), (180.0, 0.01)), r"below 6\.28319 rad"),
            (((0.0, 0.0), (2.0,)), r"angle \(rad\) and lift \(m\)"),
        ],
    )
    def test_points_that_make_no_turn_are_refused(self, points, message):
        with pytest.raises(EquationError, match=message):
            cam_motion(points)

    def test_an_unknown_law_is_refused(self):
        with pytest.raises(EquationError, match="law = 'straight': 'cycloidal', 'harmonic'"):
            cam_motion(POINTS, "straight")

    def test_a_cam_without_profile_is_refused(self):
        with pytest.raises(EquationError, match=r"cam .*profile = 0\.01: a function"):
            lifted(0.01)


def test_a_profile_without_a_bounded_slope_at_the_start_is_refused():
    cam = Cam(profile=lambda x: lp.ops.sqrt(x))
    model = lp.compose(
        turn=Speed(w=20.0),
        valve=CamFollower(cam=cam, m=1.0, c=1e3, F_0=5.0, restitution=0.3),
        connections=lambda m: lp.chain(m.turn.flange, m.valve.flange),
    )
    with np.errstate(invalid="ignore"), pytest.raises(StartError, match="slope without bound"):
        lp.simulate(lp.assemble(model), until=0.5)
