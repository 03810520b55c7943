"""Motors under control, motors by maps, and quasi-static motors against independent figures."""

import numpy as np
import pytest
from rows import assemble_rows, in_a_row
from scipy.interpolate import RegularGridInterpolator

import lumped as lp
from lumped.components import (
    FieldOrientedMotor,
    Ground,
    MappedMotor,
    QuasiStaticExcitedDCMotor,
    QuasiStaticSeriesDCMotor,
    Speed,
    SquirrelCageMotor,
    VoltageSource,
)
from lumped.errors import EquationError, ParameterError

WINDINGS = {"pairs": 2.0, "R_s": 0.05, "R_r": 0.04, "L_m": 0.03, "L_ls": 1.2e-3, "L_lr": 1.0e-3}
CONTROL = {"psi_n": 0.9, "V_max": 310.0, "I_max": 150.0, "T": 1e-3}
J = 0.4


def turned(motor, w):
    """The motor at a speed."""
    return in_a_row(motor=motor, turn=Speed(w=w))


def settled(motor, w, until):
    """Quantities at the end of a run at constant speed."""
    run = lp.simulate(lp.assemble(turned(motor, w)), until=until, rtol=1e-11)
    return lambda name: float(run[f"motor.{name}"][-1])


def greatest_torque(w):
    """By trying all currents along the flux: the highest product with the current across it."""
    q = WINDINGS
    L_s, L_r = q["L_m"] + q["L_ls"], q["L_m"] + q["L_lr"]
    leakage = 1 - q["L_m"] ** 2 / (L_s * L_r)
    i_d = np.linspace(0, CONTROL["psi_n"] / q["L_m"], 400001)
    flux = CONTROL["V_max"] / max(abs(q["pairs"] * w), 1e-9)
    by_voltage = np.maximum(flux**2 - (L_s * i_d) ** 2, 0) / (leakage * L_s) ** 2
    i_q = np.sqrt(np.minimum(CONTROL["I_max"] ** 2 - i_d**2, by_voltage))
    # below the weakening the flux is full, though less of it would leave more current across
    best = (
        len(i_d) - 1
        if i_q[-1] ** 2 + i_d[-1] ** 2 >= CONTROL["I_max"] ** 2 * (1 - 1e-9)
        else (np.argmax(i_d * i_q))
    )
    return 1.5 * q["pairs"] * q["L_m"] ** 2 / L_r * i_d[best] * i_q[best]


class TestFieldOrientedMotor:
    @pytest.mark.parametrize("w", [0.0, 60.0, -100.0, 150.0, 200.0, 300.0, 500.0, -900.0, 2000.0])
    def test_gives_the_greatest_torque_that_voltage_and_current_allow(self, w):
        motor = FieldOrientedMotor(**WINDINGS, **CONTROL, J=J, wanted=1e6)
        received, expected = settled(motor, w, 30.0)("tau"), greatest_torque(w)
        print(f"{w:g} rad/s: {received:.4f} N.m, by search {expected:.4f} N.m")
        assert received == pytest.approx(expected, rel=1e-5)

    @pytest.mark.parametrize(("w", "wanted"), [(100.0, 150.0), (-60.0, 80.0), (300.0, -60.0)])
    def test_agrees_with_the_motor_with_all_its_currents_in_steady_state(self, w, wanted):
        """The cage motor on the mains with the frequency and voltage that the control sets."""
        at = settled(FieldOrientedMotor(**WINDINGS, **CONTROL, J=J, wanted=wanted), w, 30.0)
        assert at("tau") == pytest.approx(wanted, rel=1e-9)
        mains = {"V": at("V"), "f": at("w_1") / (2 * np.pi)}
        cage = lp.assemble(turned(SquirrelCageMotor(**WINDINGS, **mains, J=J), w))
        run = lp.simulate(cage, until=30.0, rtol=1e-9, grid=[30.0])
        for name in ("tau", "i", "P"):
            received = float(run[f"motor.{name}"][-1])
            print(f"{name}: {received:.6g}, oriented {at(name):.6g}")
            assert received == pytest.approx(at(name), rel=1e-5)
        heat = at("P") - wanted * w
        q = WINDINGS
        slip = at("w_1") - q["pairs"] * w
        rotor = wanted * slip / q["pairs"]
        assert heat == pytest.approx(1.5 * q["R_s"] * at("i") ** 2 + rotor, rel=1e-9)

    def test_torque_follows_a_command_with_the_lag_of_the_currents(self):
        wanted = lp.ops.where(lp.time >= 0.01, 100.0, -40.0)
        motor = FieldOrientedMotor(**WINDINGS, **CONTROL, J=J, wanted=wanted)
        run = lp.simulate(lp.assemble(turned(motor, 50.0)), until=0.02, rtol=1e-10)
        before = -40.0 * (1 - np.exp(-np.minimum(run.t, 0.01) / 1e-3))
        fade = np.exp(-np.maximum(run.t - 0.01, 0) / 1e-3)
        expected = 100.0 + (before - 100.0) * fade
        expected[run.t < 0.01] = before[run.t < 0.01]
        assert np.abs(run["motor.tau"] - expected)[1:].max() < 1e-5

    def test_a_current_that_does_not_even_excite_it_is_refused(self):
        motor = FieldOrientedMotor(**WINDINGS, **{**CONTROL, "I_max": 29.0}, J=J, wanted=0.0)
        with pytest.raises(ParameterError, match=r"motor\.I_max = 29 A .* must be greater than"):
            lp.assemble(turned(motor, 0.0))


SPEEDS, TORQUES = (0.0, 100.0, 300.0, 500.0), (0.0, 40.0, 120.0)
ETA = ((0.50, 0.70, 0.62), (0.70, 0.91, 0.88), (0.75, 0.94, 0.95), (0.72, 0.90, 0.93))
MAP = ((0.0, *TORQUES), *((w, *row) for w, row in zip(SPEEDS, ETA, strict=True)))
LIMITS = ((0.0, 150.0), (300.0, 120.0), (600.0, 60.0))


class TestMappedMotor:
    def mapped(self, **given):
        return MappedMotor(limits=LIMITS, efficiency=MAP, T=0.01, J=J, **given)

    @pytest.mark.parametrize("seed", range(6))
    def test_power_and_heat_are_those_of_the_map_in_all_quadrants(self, seed):
        rng = np.random.default_rng(seed)
        w, wanted = rng.uniform(-600, 600), rng.uniform(-110, 110)
        at = settled(self.mapped(wanted=wanted), w, 1.0)
        tau = np.sign(wanted) * min(abs(wanted), np.interp(abs(w), *zip(*LIMITS, strict=True)))
        grid = RegularGridInterpolator((SPEEDS, TORQUES), ETA)
        eta = float(grid((min(abs(w), 500.0), min(abs(tau), 120.0))))
        shaft = tau * w
        electric = shaft / eta if shaft > 0 else shaft * eta
        received = [at("tau"), at("eta"), at("P"), at("lost")]
        assert received == pytest.approx([tau, eta, electric, electric - shaft], rel=1e-9)

    @pytest.mark.parametrize(
        ("field", "rows", "text"),
        [
            ("limits", (), "no rows of two numbers"),
            ("limits", ((0, 10), (5, -1)), "-1 N.m at 5 rad/s"),
            ("limits", ((3, 10), (2, 1)), "3 -> 2"),
            ("efficiency", ((0, 0, 1), (0, 0.5)), "rows of the same length"),
            ("efficiency", ((0, 0, 1), (0, 0.5, 1.2)), "1.2 at 0 rad/s and 1 N.m"),
            ("efficiency", ((0, 1, 0), (0, 0.5, 0.9)), "torques must increase"),
        ],
    )
    def test_maps_without_sense_are_refused(self, field, rows, text):
        motor = self.mapped(wanted=1.0).with_({field: rows})
        with pytest.raises(EquationError, match=f"motor.*{text}"):
            lp.assemble(turned(motor, 1.0))


@pytest.mark.parametrize(("v", "w"), [(100.0, 120.0), (-100.0, 120.0), (80.0, -5.0), (60.0, 0.0)])
def test_a_quasi_static_series_motor_has_the_current_of_ohms_law(v, w):
    k, R = 0.00637, 0.06
    system = assemble_rows(
        *("source.p motor.p", "source.n motor.n ground.pin", "motor turn"),
        source=VoltageSource(v=v),
        ground=Ground(),
        motor=QuasiStaticSeriesDCMotor(k=k, R=R, J=J),
        turn=Speed(w=w),
    )
    at = lp.start_point(system)
    i = v / (R + k * w)
    assert [at["motor.i"], at["motor.tau"]] == pytest.approx([i, k * i**2], rel=1e-12)


def test_a_quasi_static_shunt_motor_runs_up_exponentially():
    """With a constant field its speed has the mechanical time constant ``J R / (k i_f)^2``."""
    v, k, R, R_f = 100.0, 0.382, 0.4, 60.0
    system = assemble_rows(
        "source.p motor.p motor.field_p",
        "source.n motor.n motor.field_n ground.pin",
        source=VoltageSource(v=v),
        ground=Ground(),
        motor=QuasiStaticExcitedDCMotor(k=k, R=R, R_f=R_f, J=J, w=0.0),
    )
    run = lp.simulate(system, until=2.0, rtol=1e-10)
    flux = k * v / R_f
    expected = v / flux * (1 - np.exp(-run.t * flux**2 / (J * R)))
    assert run["motor.w"] == pytest.approx(expected, rel=1e-8, abs=1e-8)
    assert run["motor.i_f"] == pytest.approx(v / R_f, rel=1e-12)
    assert set(system.state_names) <= {"motor.phi", "motor.w"}
