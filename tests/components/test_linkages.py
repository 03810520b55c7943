"""Plane linkages against closed forms and Lagrange's equations written by hand."""

import numpy as np
import pytest
from rows import assemble_rows, in_rows

import lumped as lp
from lumped.components import (
    Bar,
    CrankSlider,
    Eccentric,
    GuidedRod,
    Inertia,
    PlaneSpring,
    Position,
    RotatingMass,
    Speed,
    SwingingMass,
    Torque,
    translation,
)
from lumped.drawing.film import moving_lines
from lumped.errors import SolverError

RADIUS, LENGTH = 0.25, 3.4


def slider(drive):
    """Crank turned about a fixed hub, a hanging rod with mass, its foot loaded."""
    return assemble_rows(
        *("drive crank", "hub.flange crank.hub_x crank.hub_y", "crank.pin_x rod.pin_x"),
        *("crank.pin_y rod.pin_y", "rod body", "rod.foot_y ram.flange_a"),
        keep=["ram.s", "body.phi"],
        drive=drive,
        crank=Eccentric(radius=RADIUS, phase=np.pi / 2),
        hub=translation.Fixed(),
        rod=GuidedRod(length=LENGTH),
        body=Inertia(J=2.0),
        ram=translation.Mass(m=3.0),
    )


def run(until: float = 4 * np.pi, grid: int = 200, w: float = 1.0, length=LENGTH):
    changes = {"drive.w": w, "rod.length": length}
    options = {"until": until, "parameters": changes, "grid": grid, "rtol": 1e-11}
    return lp.simulate(slider(Speed(w=1.0)), **options)


def foot(phi: np.ndarray, length: float) -> np.ndarray:
    return RADIUS * np.cos(phi) - np.sqrt(length**2 - (RADIUS * np.sin(phi)) ** 2)


class TestSlider:
    @pytest.mark.parametrize("length", [3.4, 1.0, 0.26])
    def test_foot_moves_as_that_of_a_crank_slider(self, length):
        found = run(length=length)
        expected = foot(found.t, length)
        assert np.abs(found["ram.s"] - expected).max() < 1e-8
        psi = np.arcsin(RADIUS / length * np.sin(found.t))
        assert np.abs(found["body.phi"] - psi).max() < 1e-8

    def test_torque_at_constant_speed_is_half_the_slope_of_the_reduced_inertia(self):
        found = run(w=2.0, until=np.pi)
        phi, h = 2 * found.t + 0j, 1e-30
        lam = RADIUS / LENGTH

        def reduced(f: np.ndarray) -> np.ndarray:
            side = np.sqrt(1 - (lam * np.sin(f)) ** 2)
            down = -RADIUS * np.sin(f) + LENGTH * lam**2 * np.sin(f) * np.cos(f) / side
            return 3.0 * down**2 + 2.0 * (lam * np.cos(f) / side) ** 2

        slope = reduced(phi + 1j * h).imag / h
        received, expected = -found["drive.flange.tau"], 2.0**2 * slope / 2
        assert np.abs(received - expected).max() < 1e-9 * np.abs(expected).max()

    def test_rod_as_long_as_the_crank_folds(self):
        """The foot stands still for half a turn; at 90 deg it has no speed to be told by."""
        found = run(length=RADIUS * (1 + 1e-9), until=1.5, grid=50)
        assert np.abs(found["ram.s"]).max() < 1e-6
        assert np.abs(found["body.phi"] - found.t).max() < 1e-6

    def test_rod_shorter_than_the_crank_stops_the_run_where_it_no_longer_reaches(self):
        system = slider(Torque(tau=1.0))
        with pytest.raises(
            SolverError, match=r"(shrank to nothing|not a finite number) .*body.phi = 1\.57"
        ):
            lp.simulate(system, until=10.0, parameters={"rod.length": 0.2})


class TestFloatingArm:
    def test_free_arm_turns_about_its_centre_of_mass(self):
        """Two equal masses on an arm in free flight: the centre goes straight on."""
        ends = ("hub_x", "hub_y", "pin_x", "pin_y")
        system = assemble_rows(
            *("turn arm", *(f"arm.{end} {end}.flange_a" for end in ends)),
            arm=Eccentric(radius=2.0, phase=np.pi / 2),
            turn=Torque(tau=0.0),
            **{end: translation.Mass(m=1.0) for end in ends},
            keep=["arm.flange.phi", "hub_x.s", "pin_x.s"],
        )
        start = {"hub_x.v": 3.0, "pin_x.v": -1.0, "hub_y.v": 0.5}
        found = lp.simulate(system, until=20.0, start=start, rtol=1e-10, grid=200)
        centre = (found["hub_x.s"] + found["pin_x.s"]) / 2
        # 4 m/s across an arm of 2 m: 2 rad/s for ever
        assert np.abs(centre - centre[0] - found.t).max() < 1e-7
        assert np.abs(found["arm.flange.phi"] - 2.0 * found.t).max() < 1e-7
        assert np.abs(found["hub_y.v"] + found["pin_y.v"] - 1.0).max() < 1e-8

    def test_hub_takes_what_acts_on_the_pin(self):
        system = assemble_rows(
            *("hold arm", "hub_x.flange arm.hub_x", "hub_y.flange arm.hub_y"),
            *("arm.pin_x side.flange", "arm.pin_y down.flange"),
            arm=Eccentric(radius=0.5),
            hold=Position(phi=0.3),
            hub_x=translation.Fixed(),
            hub_y=translation.Fixed(),
            side=translation.Force(f=3.0),
            down=translation.Force(f=-4.0),
        )
        at = lp.start_point(system)
        received = at["hub_x.flange.f"], at["hub_y.flange.f"], at["hold.flange.tau"]
        moment = 0.5 * (3.0 * np.sin(0.3) + 4.0 * np.cos(0.3))
        assert np.abs(np.subtract(received, (3.0, -4.0, -moment))).max() < 1e-14


class TestPlaneSpring:
    def test_a_circle_needs_the_stretch_that_bears_it(self):
        """At constant speed on a circle the tension is ``m v^2 / r``, damped or not."""
        m, c, length0, r = 2.0, 300.0, 0.8, 1.1
        v = np.sqrt(c * (r - length0) * r / m)
        system = assemble_rows(
            "centre.flange spring.a_x spring.a_y",
            *("spring.b_x x.flange_a", "spring.b_y y.flange_a"),
            centre=translation.Fixed(),
            spring=PlaneSpring(c=c, d=5.0, length0=length0),
            x=translation.Mass(m=m, s=r, v=0.0),
            y=translation.Mass(m=m, s=0.0, v=v),
            keep=["x.s", "y.s"],
        )
        found = lp.simulate(system, until=3.0, rtol=1e-11)
        turned = v / r * found.t
        assert found["x.s"] == pytest.approx(r * np.cos(turned), abs=1e-7)
        assert found["y.s"] == pytest.approx(r * np.sin(turned), abs=1e-7)


class TestBar:
    M, J, L, K = 3.0, 0.5, 1.4, 0.35

    def bar(self, **given):
        return Bar(m=self.M, J=self.J, length=self.L, k=self.K, **given)

    def test_it_swings_as_a_physical_pendulum(self):
        """Small swings about one held end: ``2 pi sqrt((J + m a^2) / (m g a))``."""
        g, a = 9.81, self.K * self.L
        turn = np.sqrt(self.M * g * a / (self.J + self.M * a**2))
        bar, nail = self.bar(g=g, phi=-np.pi / 2 + 1e-4, w=0.0), translation.Fixed()
        system = assemble_rows("nail.flange bar.a_x bar.a_y", keep=["bar.phi"], bar=bar, nail=nail)
        found = lp.simulate(system, until=20 * np.pi / turn, rtol=1e-11, atol=1e-14)
        swing = found["bar.phi"] + np.pi / 2
        assert np.abs(swing - 1e-4 * np.cos(turn * found.t)).max() < 1e-9

    def test_thrown_it_turns_evenly_and_its_centre_falls_freely(self):
        g = 9.81
        given = {"x": 0.0, "y": 2.0, "v_x": 1.5, "v_y": 4.0, "w": -3.0, "phi": 0.4}
        system = lp.assemble(lp.compose(bar=self.bar(g=g, **given)), keep=["bar.x", "bar.y"])
        found = lp.simulate(system, until=1.0, rtol=1e-10)
        t = found.t
        assert found["bar.x"] == pytest.approx(1.5 * t, abs=1e-9)
        assert found["bar.y"] == pytest.approx(2 + 4 * t - g * t**2 / 2, abs=1e-9)
        assert found["bar.w"] == pytest.approx(-3.0, rel=1e-12)


def test_all_angles_count_counter_clockwise_from_the_horizontal():
    """A crank, an arm, a bar and a mass on an arm at 0.3 rad point the same way."""
    model = in_rows(
        *("turn arm crank swing mass", "base.flange arm.hub_x arm.hub_y"),
        turn=Position(phi=0.3 + 0.0 * lp.time),
        base=translation.Fixed(),
        arm=Eccentric(radius=2.0),
        crank=CrankSlider(r=2.0, L=5.0),
        swing=SwingingMass(m=1.0, R=2.0),
        mass=RotatingMass(m=1.0, r=2.0),
    )
    names = ["arm.pin_x.s", "arm.pin_y.s"]
    point = lp.start_point(lp.assemble(model, keep=names))
    expected = [2 * np.cos(0.3), 2 * np.sin(0.3)]
    assert [point[name] for name in names] == pytest.approx(expected, rel=1e-12)
    run = lp.simulate(lp.assemble(model), until=1.0)
    lines = moving_lines(run, np.array([0.5]))
    for name in ("arm.arm", "crank.crank", "swing.arm", "mass.arm"):
        assert lines[name][0, 1] == pytest.approx(expected, rel=1e-12), name
