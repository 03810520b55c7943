"""Eccentric shear with free speed: change of the carriage, landing, energy.

The reference run and its numbers were computed with DOP853 on the reduced equation, with the
momentum rule coded by hand.
"""

from collections.abc import Iterator

import numpy as np
import pytest
from shear_by_hand import data

import lumped as lp
from lumped.components import Inertia
from lumped.errors import ParameterError
from lumped.models.eccentric_shear.scenes import (
    CrankTurned,
    FreeShear,
    compare_speeds,
    free_run,
    landing,
    seat_support,
)
from lumped.models.eccentric_shear.stand import (
    IDLE,
    J_MOTOR,
    SPEED,
    GuidedShear,
    Loaded,
    PrintedShear,
    Shear,
)

READINGS = (PrintedShear, GuidedShear)
CROSS = {PrintedShear: 412.5, GuidedShear: 409.9}  # kg.m2, printed to these digits
BEFORE = 2809.4
AFTER = {PrintedShear: 3117.0, GuidedShear: 3138.8}


class Coasting(lp.Component):
    """Shear without loads on a flywheel."""

    J: lp.Param = lp.param("kg.m2", "flywheel", J_MOTOR)
    motor: Inertia = Inertia(J=J)
    loaded: Loaded = Loaded().with_({"idle.tau": 0.0, "cut.tau_max": 0.0})

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.motor.flange_b, self.loaded.flange)


def coast(shear: type[Shear], begin: float = 1.5, until: float = 0.5, **p: float) -> lp.Trajectory:
    system = lp.assemble(Coasting().with_({"loaded.shear": shear()}))
    start = {"motor.w": SPEED, "motor.phi": begin} | seat_support(shear)
    return lp.simulate(system, until=until, parameters=p, start=start, rtol=1e-11)


class Audited(FreeShear):
    """The same, with the work of the motor and of the loads."""

    W_motor: lp.Var = lp.var("W.s", "work of the motor", state="prefer")
    W_load: lp.Var = lp.var("W.s", "work of the loads", state="prefer")

    def equations(self) -> Iterator[lp.Equation]:
        w = self.loaded.shear.shaft.body.w
        yield lp.der(self.W_motor) == self.motor.tau * self.motor.w
        yield lp.der(self.W_load) == (self.loaded.idle.tau + self.loaded.cut.tau) * w


class TestChangeOfCarriage:
    @pytest.mark.parametrize("shear", READINGS)
    @pytest.mark.parametrize("J", [1e-3, 54e3, 1e9])
    def test_speed_jumps_by_the_momentum_in_the_new_direction(self, shear, J):
        received = compare_speeds(coast(shear, J=J))[0]
        expected = (CROSS[shear] + J) / (AFTER[shear] + J)
        assert abs(received - expected) < 2e-5

    @pytest.mark.parametrize("shear", READINGS)
    def test_return_has_the_mirrored_jump(self, shear):
        received = compare_speeds(coast(shear, begin=4.6))[0]
        expected = (CROSS[shear] + J_MOTOR) / (BEFORE + J_MOTOR)
        assert abs(received - expected) < 2e-6

    @pytest.mark.parametrize("shear", READINGS)
    def test_prescribed_speed_takes_the_impulse_and_the_event_tells_its_loss(self, shear):
        """No torque of the drive grows with it: 2812 J at 1.05 rad/s with printed supports."""
        system = lp.assemble(CrankTurned().with_({"loaded.shear": shear()}))
        run = lp.simulate(system, until=3.0, start=seat_support(shear), rtol=1e-10)
        instant = next(v.time for v in run.events if v.component.endswith("shear.switch"))
        received = sum(event.loss for event in run.events if event.time == instant)
        expected = (BEFORE + AFTER[shear] - 2 * CROSS[shear]) * SPEED**2 / 2
        assert abs(received / expected - 1) < 1e-4
        beside = np.abs(run.t - instant) < 1e-3
        assert np.abs(run["drive.flange.tau"][beside]).max() < 1.01 * IDLE + 2e3

    @pytest.mark.parametrize("shear", READINGS)
    def test_rod_as_short_as_the_crank_is_refused(self, shear):
        with pytest.raises(ParameterError) as caught:
            coast(shear, **{"loaded.shear.upper.length": 0.25})
        text = "loaded.shear.upper.length = 0.25 m (joint to foot, longer than the crank) must be"
        assert f"{text} greater than 0.25" in str(caught.value)

    @pytest.mark.parametrize("e", [0.0, 0.3, 0.5])
    def test_ellipses_weigh_the_motor_by_the_square_of_the_ratio(self, e):
        run = coast(PrintedShear, **{"loaded.eps": e}, begin=0.5, until=4.0)
        instant = next(v.time for v in run.events if v.component.endswith("shear.switch"))
        at = np.flatnonzero(run.t == instant)
        u = run["motor.w"][at] / run["loaded.shear.shaft.body.w"][at]
        assert abs(u[0] - u[-1]) < 1e-12
        expected = (CROSS[PrintedShear] + u[0] ** 2 * J_MOTOR) / (3117.0 + u[0] ** 2 * J_MOTOR)
        assert abs(compare_speeds(run)[0] - expected) < 1e-5


class TestFreeRun:
    def test_run_is_that_of_the_reference(self):
        table = data("forward_e0")
        t = table["t_s"]
        run = free_run(until=t[-1], grid=t, rtol=1e-10)
        rows = np.abs(run.t[:, None] - t).argmin(axis=0)
        received = {
            "phi_rad": run["loaded.shear.crank.phi"],
            "w_crank_rad_s": run["loaded.shear.shaft.body.w"],
            "w_motor_rad_s": run["motor.w"],
            "i_A": run["motor.i"],
            "T_motor_Nm": run["motor.tau"],
            "z_rad": SPEED * run.t - run["motor.phi"],
        }
        for name, values in received.items():
            assert np.abs(values[rows] - table[name]).max() < 1e-8 * np.ptp(table[name]), name
        ratio = (run["motor.w"] / run["loaded.shear.shaft.body.w"])[rows]
        assert np.abs(ratio - table["u"]).max() < 1e-14

    def test_impacts_are_those_of_the_reference(self):
        run = free_run(rtol=1e-10)
        expected = (
            (1.54876139, 1.0494349947, 0.9997440084, 2738.6),
            (4.46419478, 1.0522781663, 1.0078798640, 2768.4),
        )
        instants = sorted({v.time for v in run.events if v.component.endswith("shear.switch")})
        w = run["loaded.shear.shaft.body.w"]
        for instant, (t, before, after, loss) in zip(instants, expected, strict=False):
            at = np.flatnonzero(run.t == instant)
            assert abs(instant - t) < 1e-8
            assert abs(w[at[0]] - before) < 1e-8
            assert abs(w[at[-1]] - after) < 1e-8
            assert abs(sum(v.loss for v in run.events if v.time == instant) - loss) < 0.05

    @pytest.mark.parametrize("shear", READINGS)
    @pytest.mark.parametrize("e", [0.0, 0.5])
    def test_energy_supplied_is_stored_or_lost_in_impacts(self, shear, e):
        system = lp.assemble(Audited().with_({"loaded.shear": shear()}))
        start = {"motor.w": SPEED, "motor.phi": 0.0, "motor.i": 0.0} | seat_support(shear)
        start |= {"W_motor": 0.0, "W_load": 0.0}
        table = data("forward_e0")
        t = table["t_s"]
        run = lp.simulate(
            system, until=t[-1], parameters={"eps": e}, start=start, grid=t, rtol=1e-10
        )
        rows = np.abs(run.t[:, None] - t).argmin(axis=0)
        lost = np.array([sum(v.loss for v in run.events if v.time <= now) for now in t])
        received = (run["W_motor"] + run["W_load"])[rows] - lost
        energy = stored(run, shear)[rows]
        assert np.abs(received - (energy - energy[0])).max() < 1e-8 * run["W_motor"][-1]
        if e == 0 and shear is PrintedShear:
            found = {
                "W_motor_J": run["W_motor"][rows],
                "W_load_J": run["W_load"][rows],
                "E_lost_J": lost,
            }
            for name, values in found.items():
                assert np.abs(values - table[name]).max() < 1e-7 * np.ptp(table[name]), name

    @pytest.mark.parametrize("shear", READINGS)
    def test_landing_on_the_return_moves_the_motor_more_than_the_cut(self, shear):
        """Only with the right jump is the greatest torque of a turn outside of the cut."""
        assert landing(free_run(0.5, shear=shear, rtol=1e-8, grid=4000)) > 1.5
        assert landing(free_run(0.0, shear=shear, rtol=1e-8, grid=4000)) < 0.5


def stored(run: lp.Trajectory, shear: type[Shear]) -> np.ndarray:
    """Energy of the bodies, from their speeds."""
    path = "loaded.shear"
    total = J_MOTOR * run["motor.w"] ** 2
    bodies = [("shaft", 17.2e3, 1100.0 - 17.2e3 * shaft_centre() ** 2), ("upper", 27.3e3, 21e3)]
    if shear is PrintedShear:
        bodies.append(("lower", 37.2e3, 50e3))
    else:
        total = total + 37.2e3 * run[f"{path}.lower.v"] ** 2
    for name, m, J in bodies:
        across, up = run[f"{path}.{name}.mass_x.v"], run[f"{path}.{name}.mass_y.v"]
        total = total + m * (across**2 + up**2) + J * run[f"{path}.{name}.body.w"] ** 2
    return total / 2


def shaft_centre() -> float:
    """Distance from the journal, from the inertias about journal and pin, m."""
    return 0.125 + 300 / (17.2e3 * 0.5)
