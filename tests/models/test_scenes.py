"""Scenes take other hardware, parameters and start values; what depends on them follows."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import ElastoBacklash, Inertia, Spring
from lumped.errors import OptionError, SolverError, UnknownNameError
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler import scenes as strip
from lumped.models.carrousel_coiler import shafts, turret
from lumped.models.eccentric_shear import scenes as shear
from lumped.models.reversing_mill import drives as motors
from lumped.models.reversing_mill import scenes as mill
from lumped.models.reversing_mill import stand
from lumped.models.rotary_arm.control import AIM, Controlled, instants, run_controlled
from lumped.models.rotary_arm.cycle import run_cycle
from lumped.models.rotary_arm.parts import Driven

T, r, R = 80e3, 0.305, 1.0


class LongBranch(stand.UpperBranch):
    """Upper branch with one more body in its spindle, as another machine may have."""

    middle: Inertia = Inertia(J=0.05)
    inner: Spring = Spring(c=2 * stand.C_SPINDLE)
    spindle: Spring = Spring(c=2 * stand.C_SPINDLE)

    def connections(self):
        yield from lp.chain(self.rolls, self.spindle, self.middle, self.inner, self.gearbox)
        yield from lp.chain(self.gearbox, self.shaft, self.motor, self.drive)
        yield lp.connect(self.barrel, self.rolls.flange_a)


class TestReversingMill:
    def test_a_stand_of_other_hardware_skids_with_the_torque_of_its_gap(self):
        run = mill.skidding(mill.StripGap(upper=LongBranch()), until=0.1)
        sliding = run["gap.w_rel"] > 0.1
        assert sliding.any()
        assert run["gap.tau"][sliding] == pytest.approx(0.3 * stand.RATED, rel=1e-12)

    def test_a_stand_of_other_hardware_keeps_the_momentum_of_a_strip_break(self):
        given = {"upper.motor.J": 35.0}
        run = mill.strip_break(stand=mill.StripGap(upper=LongBranch()), parameters=given)
        J = {"motor": 35.0, "gearbox": stand.J_GEARBOX, "middle": 0.05}
        J["rolls"] = stand.J_BACKUP + stand.J_WORK
        momentum = sum(x * run[f"upper.{name}.w"] for name, x in J.items())
        expected = stand.RATED * np.maximum(run.t - 0.02, 0)
        assert momentum - momentum[0] == pytest.approx(expected, abs=1e-5 * expected[-1])

    def test_parameters_and_start_values_are_taken_once(self):
        run = mill.skidding(until=0.01, start={"upper.motor.w": 3.0}, parameters={"M_s": 1e9})
        assert run["upper.motor.w"][0] == 3.0
        gap = stand.ClosedGap()
        run = stand.strip_entry(gap, until=0.01, parameters={"upper.motor.J": 1e9})
        assert np.abs(run["upper.motor.w"]).max() < 1e-5
        begin = {"upper.motor.w": 2.0}
        run = mill.entry_at_speed(mill.JoinedGap(), 0.0, until=0.01, start=begin)
        assert run["upper.motor.w"][0] == 2.0
        run = motors.motors_at_entry(motors.MotorStand(s=0.03), until=0.01, start=begin)
        assert run["upper.motor.w"][0] == 2.0

    def test_unequal_rolls_begin_with_the_difference_given(self):
        changed = {"eps": 0.004, "lower.drive.control.k": 2000.0}
        run = mill.unequal_rolls(mill.ControlledStand(), 0.01, parameters=changed)
        assert run["lower.motor.w"][0] == pytest.approx(1.004 * mill.SPEED, rel=1e-12)
        assert run["gap.w_rel"][0] == pytest.approx(0, abs=1e-9)
        torque = 2000.0 * run["lower.drive.control.x"][0]
        assert torque == pytest.approx(stand.RATED, rel=1e-12)


class TestCoiler:
    def test_a_strip_of_another_thickness_turns_the_motor_by_its_own_radius(self):
        """Seen from the closed form: R^2 = r^2 + h L / pi, and the line keeps its speed."""
        run = coiler.winding(parameters={"drive.h": 2e-3}, grid=400, rtol=1e-9)
        length = np.pi * (R**2 - r**2) / 2e-3
        assert run["drive.coil.L"][-1] == pytest.approx(length, rel=1e-9)
        assert run["drive.coil.R"][-1] == pytest.approx(R, rel=1e-9)
        steady = (run.t > 20.5) & (run.t < run.t[-1] - 16.5)
        speed = (run["drive.coil.R"] * run["drive.coil.w"])[steady]
        grown = 2e-3 * run["drive.coil.w"][steady] / (2 * np.pi)
        assert speed == pytest.approx(20.0, rel=1e-9), grown.max()

    def test_other_ratios_and_mandrels_are_followed(self):
        changed = {"drive.gear.ratio_1": 1.6, "drive.r": 0.4, "drive.R": 0.9}
        run = coiler.winding(parameters=changed, grid=100, rtol=1e-9)
        assert run["drive.coil.R"][[0, -1]] == pytest.approx([0.4, 0.9], rel=1e-9)
        assert run["drive.rotor.w"] == pytest.approx(1.6 * run["drive.coil.w"], rel=1e-9, abs=1e-8)

    def test_another_drive_is_wound_without_rewriting_the_scene(self):
        model = coiler.UnderTension(drive=shafts.ShaftedDrive())
        own = {"drive.shaft.c": 1e9, "drive.shaft.b": 1e-6}
        begin = {"drive.shaft.phi_rel": -5e-7 - T * r / 1e9}
        run = coiler.winding(length=500.0, model=model, parameters=own, start=begin, grid=100)
        plain = coiler.winding(length=500.0, grid=100, rtol=1e-9)
        assert run["drive.coil.R"][-1] == pytest.approx(plain["drive.coil.R"][-1], rel=1e-6)

    def test_strip_without_thickness_needs_a_length(self):
        with pytest.raises(OptionError, match=r"drive\.h = 0 m, fills no coil: give its length"):
            coiler.winding(parameters={"drive.h": 0.0})

    def test_the_controller_knows_the_drive_that_it_controls(self):
        """Compensation of a drive with other inertias and strip still holds the tension."""
        changed = {"drive.mandrel.J": 900.0, "drive.rotor.J": 300.0, "drive.coil.rho": 2700.0}
        changed |= {"drive.control.T": 40e3, "drive.h": 2e-3, "drive.eta": 1.0, "drive.mu": 0.0}
        run = strip.elastic_winding(until=40.0, grid=400, rtol=1e-10, parameters=changed)
        assert np.abs(run["strip.T"] - 40e3).max() < 5.0

    def test_a_lost_tension_names_the_wanted_one(self):
        with pytest.raises(SolverError, match="instead of 60000 N"):
            strip.elastic_winding(0.0, a=6.0, until=3.0, parameters={"drive.control.T": 60e3})

    def test_a_run_beyond_the_end_of_the_strip_is_refused(self):
        with pytest.raises(OptionError, match=r"until = 160 s, but the strip ends at 89\.23"):
            strip.elastic_winding(until=160.0, parameters={"drive.h": 2e-3})

    def test_half_a_turn_with_thick_strip_keeps_its_geometry(self):
        changed = {"h": 5e-3, "R_0": 0.5, "v": 4.0, "r_t": 1.4}
        run = turret.half_turn(grid=121, parameters=changed)
        assert run["coil.R"][0] == pytest.approx(0.5, rel=1e-12)
        theta = run["turn.phi"]
        axis = 1.4 * np.array([np.cos(np.pi - theta), np.sin(np.pi - theta)])
        D = np.hypot(*(np.array([[-4.0], [1.8]]) - axis))
        free = np.sqrt(D**2 - run["coil.R"] ** 2)
        assert run["path.length"] == pytest.approx(free, rel=1e-9)
        area = np.pi * (run["coil.R"] ** 2 - r**2) / 5e-3
        assert np.ptp(area + free - 4.0 * run.t) < 1e-9 * area[-1]

    def test_half_a_turn_takes_another_turret(self):
        run = turret.half_turn(turret=turret.Turret(T=40e3), grid=10)
        assert np.abs(run["held.motor.tau"]) == pytest.approx(40e3 * run["coil.R"], rel=1e-12)

    def test_a_jam_begins_in_the_balance_of_the_drive_that_jams(self):
        changed = {"T": 50e3, "drive.shaft.c": 1e7, "drive.h": 2e-3, "drive.gear.ratio_1": 1.5}
        run = shafts.jam(until=0.09, parameters=changed, rtol=1e-9)
        assert run["drive.shaft.tau"][0] == pytest.approx(-50e3 * 0.4, rel=1e-12)
        assert run["drive.shaft.tau"] == pytest.approx(-50e3 * run["drive.coil.R"], rel=3e-3)
        assert run["drive.rotor.w"][0] == pytest.approx(75.0, rel=1e-12)
        assert run["drive.coil.R"][0] == pytest.approx(0.4, rel=1e-12)

    def test_a_gear_change_keeps_the_momentum_of_other_ratios(self):
        run = strip.gear_change(parameters={"drive.gear.ratio_2": 3.0})
        low, high = 500 + 600 * 3.0**2, 500 + 600 * 1.354**2
        after = (500 + 600 * 1.354 * 3.0) * 20.0 / high
        assert run["drive.mandrel.w"][-1] == pytest.approx(after, rel=1e-11)
        lost = (low * 20.0**2 - high * after**2) / 2
        assert sum(event.loss for event in run.events) == pytest.approx(lost, rel=1e-10)


class TestShear:
    def test_another_motor_runs_at_its_own_flux(self):
        """Without load the speed is U / k, so that the angle stays what is wanted."""
        idle = {"loaded.idle.tau": 0.0, "loaded.cut.tau_max": 0.0, "motor.k": 400.0, "w": 0.8}
        run = shear.free_run(parameters=idle, turns=1, rtol=1e-9)
        assert run["motor.w"][0] == pytest.approx(0.8, rel=1e-12)
        assert run.t[-1] == pytest.approx(2 * np.pi / 0.8, rel=1e-12)
        assert run["voltage.y"][0] == pytest.approx(400.0 * 0.8, rel=1e-12)

    def test_eccentricity_is_the_one_given_last(self):
        run = shear.free_run(parameters={"eps": 0.3}, until=0.1)
        assert run["motor.w"][0] / run["loaded.shear.shaft.body.w"][0] < 0.9
        run = shear.free_run(0.3, until=0.1, start={"motor.i": 5.0})
        assert run["motor.i"][0] == 5.0

    def test_a_model_of_its_own_runs_in_the_scene(self):
        model = shear.FreeShear().with_({"loaded.shear": shear.GuidedShear(), "motor.J": 20e3})
        received = shear.free_run(model=model, until=2.0, rtol=1e-9)
        expected = shear.free_run(
            shear=shear.GuidedShear, parameters={"motor.J": 20e3}, until=2.0, rtol=1e-9
        )
        assert received["motor.w"] == pytest.approx(expected["motor.w"], rel=1e-9)


class TestArm:
    def test_the_linear_zone_begins_where_the_law_becomes_linear(self):
        run = run_controlled(until=11.0, grid=2000, parameters={"aim.K": 3.0})
        place = run["arm.phi"][np.flatnonzero(run.t == instants(run)[2])[0]]
        assert place == pytest.approx(AIM - 1.0 / 3.0**2, abs=1e-9)

    def test_the_arm_is_held_by_the_torque_that_it_takes(self):
        changed = {"arm.m_w": 4000.0, "arm.g": 9.0, "reducer.ratio": 60.0, "reducer.eta": 0.9}
        run = run_controlled(until=0.01, grid=2, parameters=changed)
        begin = run["arm.phi"][0]
        moment = 9.0 * np.cos(begin) * (325 * 1.008 + 7315 * 0.504 - 4000 * 0.35)
        assert run["motor.tau"][0] == pytest.approx(moment / (60 * 0.9), rel=1e-12)
        assert run["at_motor.y"][0] == pytest.approx(60 * run["at_motor.u"][0], rel=1e-12)

    def test_scenes_take_models(self):
        run = run_controlled(until=0.02, model=Controlled().with_({"motor.J": 20.0}))
        assert run.system.parameters["motor.J"] == 20.0
        fast = run_cycle(model=Driven().with_({"rotor.J": 0.1}), grid=200)
        slow = run_cycle(grid=200)
        off = slow["drive.tau"] - fast["drive.tau"]
        assert off == pytest.approx(12.7 * slow["rotor.a"], abs=1e-6 * np.abs(off).max())

    def test_another_ratio_turns_the_arm_alike(self):
        run = run_cycle(grid=100, parameters={"reducer.ratio": 40.0})
        assert run["rotor.w"] == pytest.approx(40.0 * run["arm.trays.w"], rel=1e-12)
        assert run["arm.trays.w"].max() == pytest.approx(1.0, rel=1e-12)


def test_a_scene_says_what_a_model_lacks():
    with pytest.raises(UnknownNameError, match="has no part 'drive'"):
        mill.skidding(motors.MotorStand(s=0.03))


def test_play_in_spindles_of_another_stand():
    other = mill.StripGap().with_({"upper.spindle": ElastoBacklash(c=stand.C_SPINDLE, b=0.01)})
    run = mill.strip_break(stand=other, until=0.1)
    assert any(event.component == "upper.spindle" for event in run.events)


class Base(lp.Component):
    """Two bodies; the shaft is bound to the first one."""

    first: Inertia = Inertia(J=2.0)
    shaft: Spring = Spring(c=3 * first.J)
    second: Inertia = Inertia(J=1.0, w=2 * first.J)

    def connections(self):
        yield from lp.chain(self.first, self.shaft, self.second)


class Derived(Base):
    """The same with another first body."""

    first: Inertia = Inertia(J=9.0)


def test_a_part_declared_anew_keeps_what_is_bound_to_it():
    system = lp.assemble(Derived())
    assert system.parameter_values()["shaft.c"] == 27.0
    assert system.parameter_values({"first.J": "4 kg.m2"})["shaft.c"] == 12.0
    assert lp.start_point(system)["second.w"] == 18.0
