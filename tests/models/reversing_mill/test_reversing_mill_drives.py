"""Two speed controllers of the reversing mill on rolls of unequal diameter, in closed form."""

import numpy as np
import pytest
from mill_by_hand import changes, relative

import lumped as lp
from lumped.components import Damper
from lumped.models.reversing_mill import drives, scenes
from lumped.models.reversing_mill.scenes import DIFFERENCE, GAIN, INTEGRAL_TIME, SPEED
from lumped.models.reversing_mill.stand import C_SHAFT, C_SPINDLE, KGF, RATED, SHAFTS


def drooping(s):
    """Half the difference of the torques of two drives with droop, and the equalizing torque.

    Torques ``beta ((1 + s) w_0 - w)`` act against the loads, with ``w_n = r w_v``.
    """
    r, beta, top = 1 + DIFFERENCE, RATED / (s * SPEED), (1 + s) * SPEED
    w_v = (beta * top * (1 + r) - RATED * (1 + r)) / (beta * (1 + r**2))
    return beta * (r - 1) * w_v / 2, beta * (top - w_v) - RATED


class TestDroop:
    """Two drives with droop on rolls of unequal diameter."""

    @pytest.mark.parametrize(("s", "printed"), [(0.03, 0.033), (0.01, 0.100)])
    def test_equalizing_torque_is_the_difference_of_diameters_over_twice_the_droop(
        self, s, printed
    ):
        system = lp.assemble(scenes.with_droop(s))
        rolling = lp.equilibrium(system, parameters={"eps": DIFFERENCE})
        half_difference, equalizing = drooping(s)
        received = (rolling["upper.spindle.tau"] - rolling["lower.spindle.tau"]) / 2
        assert relative(received, half_difference) < 1e-8
        assert relative(rolling["gap.tau"], equalizing) < 1e-8
        assert abs(received / RATED - DIFFERENCE / (2 * s)) < 1.01 * DIFFERENCE * printed
        assert abs(received / RATED - printed) < 5.1e-4

    def test_creep_takes_its_part(self):
        s, K_s = 0.01, 300 * KGF
        stand = scenes.with_droop(s).with_({"gap": Damper(d=K_s / 2)})
        rolling = lp.equilibrium(lp.assemble(stand), parameters={"eps": DIFFERENCE})
        beta = RATED / (s * SPEED)
        expected = DIFFERENCE * SPEED / (2 / beta + 2 / K_s)
        assert abs(rolling["gap.tau"] / expected - 1) < 2 * DIFFERENCE

    def test_weak_friction_limits_it_and_the_rolls_slip_by_the_rest(self):
        s, M_k = 0.01, 0.05 * RATED
        system = lp.assemble(scenes.with_droop(s))
        limits = {"eps": DIFFERENCE, "M_s": 0.06 * RATED, "M_k": M_k}
        rolling = lp.equilibrium(system, parameters=limits)
        r, beta, top = 1 + DIFFERENCE, RATED / (s * SPEED), (1 + s) * SPEED
        w_v, w_n = top - (RATED + M_k) / beta, top - (RATED - M_k / r) / beta
        assert relative(rolling["gap.w_rel"], w_v - w_n / r) < 1e-7
        assert relative(rolling["gap.tau"], M_k) < 1e-12


class TestPIControllers:
    """Two PI speed controllers on rolls of unequal diameter."""

    k_i, r = GAIN / INTEGRAL_TIME, 1 + DIFFERENCE
    c_u = 1 + k_i * (1 / C_SHAFT + 1 / C_SPINDLE)
    c_l = 1 + k_i / C_SPINDLE
    w_v = SPEED * (1 / c_u + r / c_l) / (1 / c_u + r**2 / c_l)
    upper = k_i * (SPEED - w_v) / c_u  # rates of the torques in the shafts
    lower = k_i * (SPEED - r * w_v) / c_l

    def ramp(self) -> dict[str, float]:
        """Start values of the steady rise, from rated torques on."""
        gearbox = self.w_v + self.upper / C_SPINDLE
        motor, low = gearbox + self.upper / C_SHAFT, self.r * self.w_v + self.lower / C_SPINDLE
        speeds = {"rolls": self.w_v, "gearbox": gearbox, "motor": motor}
        start = dict.fromkeys(SHAFTS, RATED)
        start |= {f"upper.{name}.w": w for name, w in speeds.items()} | {"lower.motor.w": low}
        for side, w in (("upper", motor), ("lower", low)):
            start[f"{side}.drive.control.x"] = RATED / GAIN - (SPEED - w)
        return start

    def test_equalizing_torque_rises_steadily_until_the_gap_skids(self):
        system = lp.assemble(scenes.ControlledStand(eps=DIFFERENCE))
        run = lp.simulate(system, until=2.5, start=self.ramp(), rtol=1e-10)
        t_skid, mode = changes(run)[0]
        before = run.t < t_skid
        received = run.table(SHAFTS)[before]
        rates = np.array([self.upper, self.upper, self.lower])
        expected = RATED + run.t[before][:, None] * rates
        assert np.abs(received - expected).max() < 1e-6 * RATED
        half_difference = (received[:, 1] - received[:, 2]) / 2
        slope = np.polyfit(run.t[before], half_difference, 1)[0]
        assert relative(slope, (self.upper - self.lower) / 2) < 1e-7
        assert relative(slope, self.k_i * DIFFERENCE * SPEED / 2) < 0.1
        assert mode == "forward"
        assert relative(t_skid, scenes.STATIC / self.upper) < 1e-7

    def test_load_share_trim_removes_the_static_part(self):
        system = lp.assemble(scenes.TrimmedStand(eps=DIFFERENCE))
        rolling = lp.equilibrium(system)
        assert relative(rolling["upper.drive.tau"], RATED) < 1e-8
        assert relative(rolling["lower.drive.tau"], RATED) < 1e-8
        assert relative(rolling["trim.y"], DIFFERENCE * SPEED) < 1e-8
        run = scenes.unequal_rolls(scenes.TrimmedStand(), until=12.0)
        assert changes(run) == []
        assert abs(run["gap.tau"][-1]) < 1e-4 * RATED
        assert np.abs(run["gap.tau"]).max() > 0.05 * RATED


class TestConverters:
    """The same drives with the motors of the library: torque loop, limits, PI control."""

    @pytest.mark.parametrize("s", [0.03, 0.01])
    def test_droop_bounds_the_equalizing_torque(self, s):
        received = drives.sharing(s)
        assert relative(received, drooping(s)[1] / RATED) < 1e-8
        assert abs(received - DIFFERENCE / (2 * s)) < 1e-3 * received

    def test_equal_rolls_share_the_load_evenly(self):
        assert abs(drives.sharing(0.02, eps=0.0)) < 1e-12

    def test_entry_of_the_strip_ends_at_the_steady_shares(self):
        """Means over the last second; the closed gap swings on, as nothing damps it."""
        cases = (
            (drives.MotorStand(s=0.03), 1.03 * SPEED, drives.sharing(0.03)),
            (drives.SharingStand(), SPEED, 0.0),
        )
        for stand, idle, expected in cases:
            run = drives.motors_at_entry(stand, idle, until=12.0, grid=12_000, rtol=1e-8)
            late = run.t > 11
            torques = [run[f"{side}.motor.tau"][late].mean() / RATED for side in ("upper", "lower")]
            assert np.abs(np.subtract(torques, [1 + expected, 1 - expected])).max() < 2e-3
            assert abs(run["gap.tau"][late].mean() / RATED - expected) < 2e-3
            assert max(run[f"{side}.motor.tau"].max() for side in ("upper", "lower")) < 2.5 * RATED

    def test_without_droop_the_gap_skids_at_last(self):
        run = drives.motors_at_entry(drives.MotorStand(), rtol=1e-8)
        skids = [t for t, mode in changes(run) if mode == "forward"]
        t = (run.t > 1.2) & (run.t < 2.2)
        slope = np.polyfit(run.t[t], run["gap.tau"][t], 1)[0]
        assert relative(slope, TestPIControllers.k_i * DIFFERENCE * SPEED / 2) < 0.1
        assert len(skids) > 3
        assert 2 < skids[1] < 3  # the first slide is the entry
