"""Plane linkages against closed forms and Lagrange's equations written by hand."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Eccentric, GuidedRod, Inertia, Position, Speed, Torque, translation
from lumped.errors import SolverError

RADIUS, LENGTH = 0.25, 3.4


class Slider(lp.Component):
    """Crank turned about a fixed hub, a hanging rod with mass, its foot loaded."""

    w: lp.Param = lp.param("rad/s", "speed", 1.0)
    length: lp.Param = lp.param("m", "rod", LENGTH, above=0)
    drive: lp.Component = Speed(w=w)
    crank: Eccentric = Eccentric(radius=RADIUS)
    hub: translation.Fixed = translation.Fixed()
    rod: GuidedRod = GuidedRod(length=length)
    body: Inertia = Inertia(J=2.0)
    ram: translation.Mass = translation.Mass(m=3.0)

    def connections(self):
        yield lp.connect(self.drive.flange, self.crank.flange)
        yield lp.connect(self.hub.flange, self.crank.hub_x, self.crank.hub_y)
        yield lp.connect(self.crank.pin_x, self.rod.pin_x)
        yield lp.connect(self.crank.pin_y, self.rod.pin_y)
        yield lp.connect(self.rod.flange, self.body.flange_a)
        yield lp.connect(self.rod.foot_y, self.ram.flange_a)


def run(until: float = 4 * np.pi, grid: int = 200, **changes: float) -> lp.Trajectory:
    system = lp.assemble(Slider(), keep=["ram.s", "body.phi"])
    return lp.simulate(system, until=until, parameters=changes, grid=grid, rtol=1e-11)


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
        system = lp.assemble(Slider(drive=Torque(tau=1.0)))
        with pytest.raises(SolverError, match=r"not a finite number .*body.phi = 1\.57"):
            lp.simulate(system, until=10.0, parameters={"length": 0.2})


class TestFloatingArm:
    def test_free_arm_turns_about_its_centre_of_mass(self):
        """Two equal masses on an arm in free flight: the centre goes straight on."""
        model = lp.compose(
            arm=Eccentric(radius=2.0),
            turn=Torque(tau=0.0),
            masses=[translation.Mass(m=1.0) for _ in range(4)],
            connections=lambda m: (
                *lp.chain(m.turn, m.arm.flange),
                lp.connect(m.arm.hub_x, m.masses[0].flange_a),
                lp.connect(m.arm.hub_y, m.masses[1].flange_a),
                lp.connect(m.arm.pin_x, m.masses[2].flange_a),
                lp.connect(m.arm.pin_y, m.masses[3].flange_a),
            ),
        )
        system = lp.assemble(model, keep=["arm.flange.phi", "masses[0].s", "masses[2].s"])
        start = {"masses[0].v": -1.0, "masses[2].v": 3.0, "masses[1].v": 0.5}
        found = lp.simulate(system, until=20.0, start=start, rtol=1e-10, grid=200)
        centre = (found["masses[0].s"] + found["masses[2].s"]) / 2
        # 4 m/s across an arm of 2 m: 2 rad/s for ever
        assert np.abs(centre - centre[0] - found.t).max() < 1e-7
        assert np.abs(found["arm.flange.phi"] - 2.0 * found.t).max() < 1e-7
        assert np.abs(found["masses[1].v"] + found["masses[3].v"] - 1.0).max() < 1e-8

    def test_hub_takes_what_acts_on_the_pin(self):
        arm = Eccentric(radius=0.5)
        model = lp.compose(
            arm=arm,
            hold=Position(phi=0.3),
            hub_x=translation.Fixed(),
            hub_y=translation.Fixed(),
            side=translation.Force(f=3.0),
            down=translation.Force(f=-4.0),
            connections=lambda m: (
                lp.connect(m.hold.flange, m.arm.flange),
                lp.connect(m.hub_x.flange, m.arm.hub_x),
                lp.connect(m.hub_y.flange, m.arm.hub_y),
                lp.connect(m.arm.pin_x, m.side.flange),
                lp.connect(m.arm.pin_y, m.down.flange),
            ),
        )
        at = lp.start_point(lp.assemble(model))
        received = at["hub_x.flange.f"], at["hub_y.flange.f"], at["hold.flange.tau"]
        moment = 0.5 * (3.0 * np.cos(0.3) + 4.0 * np.sin(0.3))
        assert np.abs(np.subtract(received, (3.0, -4.0, moment))).max() < 1e-14
