"""Cold pilger mill LG90 on its motor."""

import numpy as np
import pytest
from checks import apart
from pilger_turns import data

from lumped.models.pilger_mill import drive
from lumped.models.pilger_mill.stand import SETS, SPEED

FORWARD = data("forward")


class TestRunning:
    def test_it_is_that_of_the_reference(self):
        run = drive.running(until=FORWARD["t_s"][-1], grid=FORWARD["t_s"], rtol=1e-11)
        quantities = {
            "phi_rad": run["mill.crank.phi"],
            "wm_rad_s": run["motor.w"],
            "T_Nm": run["motor.tau"],
            "z_rad": run["control.x"] * drive.GAIN / drive.INTEGRAL_GAIN,
            "w_crank_rad_s": run["shaft.w"],
            "X_m": run["mill.stand.s"],
            "V_m_s": run["mill.stand.v"],
            "Y1_m": run["mill.weight.s"],
        }
        for column, received in quantities.items():
            assert apart(received, FORWARD[column]) < 1e-8, column
        assert abs(run["mill.crank.phi"][-1] - 4 * np.pi) < 1e-8
        ends = [run[name][-1] for name in ("motor.w", "motor.tau")]
        assert np.abs(np.subtract(ends, [104.28780861, 2574.75775])).max() < 1e-5
        speed, torque = run["motor.w"], run["motor.tau"]
        assert np.abs(np.subtract((speed.min(), speed.max()), (103.8291, 104.8949))).max() < 1e-4
        assert abs(torque.min() + 830.6) < 0.06
        assert abs(torque.max() - 4776.7) < 0.06

    def test_stiff_control_comes_to_the_prescribed_motion(self):
        """A fast motor at a high gain turns the crank evenly: its torque is M(f)."""
        w = SPEED["P"]
        part = drive.Driven().with_(
            {"motor.T": 1e-5, "motor.tau_k": 13.5e6, "control.k": 50.0, "control.T_i": 1e3}
        )
        until = 2 * np.pi / w
        run = drive.running(part, until=until, grid=361, rtol=1e-6)
        late = run.t > 0.1 * until
        curves = data("curves_P")
        expected = curves["Mg_exact_Nm_after"] + curves["Mroll_Nm"] + SETS["P"]["M0"]
        degrees = np.degrees(run["mill.crank.phi"][late])
        torque = drive.GEAR * run["motor.tau"][late]
        assert np.ptp(run["shaft.w"][late]) < 1e-4 * w
        assert apart(torque, np.interp(degrees, curves["phi_deg"], expected)) < 5e-3

    @pytest.mark.parametrize(
        ("c", "twist", "angle", "speed"),
        [
            (1e7, 1.35e-2, 1.5e-2, 2.2e-1),
            (1e8, 7.7e-4, 8.6e-4, 1.5e-2),
            (1e9, 7.4e-5, 8.0e-5, 1.8e-3),
            (1e10, 7.3e-6, 7.9e-6, 3.8e-4),
        ],
    )
    def test_stiff_shaft_comes_to_the_rigid_one(self, c, twist, angle, speed):
        motor, mill = 15.6**2 * 30.0, 21400.0
        J = motor * mill / (motor + mill)
        options = {"until": FORWARD["t_s"][-1], "grid": 4000, "rtol": 1e-9}
        rigid = drive.running(**options)
        part = drive.ElasticallyDriven(c=c, d=2 * 0.05 * np.sqrt(c * J))
        run = drive.running(part, **options)
        received = [
            np.abs(run["twist.phi_rel"]).max(),
            np.abs(run["mill.crank.phi"] - rigid["mill.crank.phi"]).max(),
            np.abs(run["shaft.w"] - rigid["shaft.w"]).max(),
        ]
        assert np.abs(np.divide(received, [twist, angle, speed]) - 1).max() < 0.03  # two digits

    def test_a_parameter_takes_along_what_depends_on_it(self):
        """Another ratio of the gear: the crank turns as before, the motor by the ratio faster."""
        changed = {"gear.ratio": 20.0, "w": 6.0}
        for part in (drive.Driven(), drive.ElasticallyDriven(c=1e7, d=1e4)):
            run = drive.running(part, until=0.1, parameters=changed)
            assert run["shaft.w"][0] == pytest.approx(6.0, rel=1e-12)
            assert run["motor.w"][0] == pytest.approx(120.0, rel=1e-12)
            assert run["control.wanted"][-1] == pytest.approx(120.0, rel=1e-12)

    def test_a_start_value_given_holds(self):
        run = drive.running(until=0.01, start={"motor.w": 78.0, "shaft.w": 5.0})
        assert run["motor.w"][0] == pytest.approx(78.0, rel=1e-12)


class TestStartUp:
    def test_it_reaches_the_wanted_speed_from_rest(self):
        run = drive.start_up()
        w = drive.GEAR * SPEED["P"]
        assert abs(run["motor.w"][0]) < 1e-12
        steady = run.t > drive.RUN_UP + 1
        assert np.abs(run["motor.w"][steady] / w - 1).max() < 0.01
        assert run["motor.tau"].max() < drive.BREAKDOWN
        assert run["motor.w"].min() > -0.01 * w
