"""Carrousel coiler against published numbers, reference files and closed forms."""

from functools import partial

import coiler_by_hand
import numpy as np
import pytest
from checks import apart
from references import columns

from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler import scenes, sizing

reference = partial(columns, "carrousel_coiler")

SPEEDS = ("range of motor speeds, high gear only", "range of motor speeds, both gears")
T, r, R, h, b, rho = 80e3, 0.305, 1.0, 1e-3, 1.25, 7850.0
J_EMPTY = 500 + 600 * 1.354**2  # at the mandrel, high gear


CUT = {"motor power, 20 m/s": 0, **dict.fromkeys(SPEEDS, 2)}  # digits of the print, not rounded
DIGEST = {  # value of an independent calculation, and its last digit
    "power of (3.4)": (1878.26, 0.01),
    "range of motor speeds, high gear only, 20 m/s": (9.836, 1e-3),
    "range of motor speeds, both gears, 20 m/s": (6.659, 1e-3),
    "base speed of the motor, 20 m/s": (323.24, 0.01),
    "greatest speed of the motor, 20 m/s": (847.85, 0.01),
    "base speed of the motor, 1300 m/min": (350.2, 0.1),
    "greatest speed of the motor, 1300 m/min": (918.5, 0.1),
    "rated torque, 20 m/s": (69.3597, 1e-4),
    "tension at full coil, high gear": (80, 1e-9),
    "tension at full coil, low gear": (118.168389956, 1e-8),
    "tension at full coil, 2160 kW, high gear": (73.6, 1e-9),
    "tension at full coil, 2160 kW, low gear": (108.714918759, 1e-8),
    "radius up to which 2160 kW hold 80 kN": (0.92, 1e-9),
    "fastest line, high gear": (1200, 1e-6),
    "fastest line, low gear": (812.4, 1e-6),
    "greatest motor power, whole run": (1892.0, 0.1),
    "greatest motor torque, whole run": (61.9386, 1e-4),
    "RMS motor torque over rated torque": (0.648, 1e-3),
    "greatest use of the motor's limit": (0.893, 1e-3),
    "length of strip in the full coil": (2849.35, 0.01),
    "turns of the full coil": (695, 1e-6),
    "mass of the full coil": (27.96, 0.01),
    "inertia, full over empty": (10.55, 0.01),
    "torque that the text adds, full coil": (3925, 1),
    "deviation of tension, steady, empty": (11.770581678, 1e-8),
    "deviation of tension, steady, full": (93.367e-3 + 0.98125, 1e-6),
    "deviation of tension, steady, empty, as the text": (7.85, 0.01),
    "deviation of tension, steady, full, as the text": (-2.85, 0.01),
    "deviation of tension, 1 m/s2, empty": (-17.1995657081, 1e-8),
    "deviation of tension, 1 m/s2, full": (-16.9, 0.1),
    "deviation of tension, 1 m/s2, least, at 0.555 m": (-9.51, 0.01),
    "deviation of tension, steady, empty, 0.3 mm": (3.5, 0.1),
    "deviation of tension, steady, empty, 5 mm": (58.9, 0.1),
    "elastic strip at 10 s, not compensated": (67_070.5, 0.1),
    "elastic strip at 59.9 s, not compensated": (81_534.7, 0.2),
    "elastic strip at 150.1 s, not compensated": (101_181, 1),
    "elastic strip, compensated, farthest off": (80_000.0, 1.6e-4),
    "torque that bends the strip, 1 mm": (93.75, 1e-9),
    "torque that bends the strip, 5 mm": (2344, 1),
    "energy lost by a gear change at 20 rad/s": (15.649, 1e-3),
    "turret drive, least torque of half a turn": (29, 1),
    "turret drive, greatest torque of half a turn": (174, 1),
}


BY_HAND = coiler_by_hand.numbers()
SAFETIES = [f"{part} safety of the high gear under the peak torque" for part in ("contact", "root")]
OFF = "ratio of whole teeth over that of the {} gear, difference"
RANGES = {  # value by hand, and what becomes of the printed range
    "dynamic factor of the motor power": (1892.0 / 1878.26, "not met"),
    "range of mandrel speeds": (1300 / 400 / 0.305, "met"),
    "rated torque over that of the full coil": (1.08, "met"),
    OFF.format("high"): (100 * (41 / 30 / 1.354 - 1), "met"),
    OFF.format("low"): (100 * (47 / 48 - 1), "met"),
    "teeth of equal wheels in the gear seat, at least": (
        1.305 * np.cos(np.pi / 15) / 0.032,
        "not met",
    ),
    **{name: (BY_HAND[name][0], "met") for name in SAFETIES},
}


@pytest.fixture(scope="module")
def rows(machine_rows):
    return {row.quantity: row for row in machine_rows("carrousel_coiler")}


class TestRows:
    def test_every_number_is_checked(self, rows):
        printed = {name for name, row in rows.items() if row.published is not None}
        assert printed == {*CUT, "motor power, drawing"}
        losses = {
            f"bending and friction in the total power, {name} coil" for name in ("empty", "full")
        }
        assert {name for name, row in rows.items() if row.bounds} == losses | set(RANGES)
        own = {name for name, row in rows.items() if not row.printed}
        assert own == set(DIGEST | BY_HAND) - set(RANGES)

    @pytest.mark.parametrize("name", RANGES)
    def test_printed_range(self, rows, name):
        value, verdict = RANGES[name]
        assert rows[name].computed == pytest.approx(value, rel=1e-5)
        assert rows[name].texts[2] == verdict

    @pytest.mark.parametrize(("name", "radius"), [("empty", r), ("full", R)])
    def test_bending_and_friction_are_far_below_the_printed_range(self, rows, name, radius):
        mass = 2500 + np.pi * rho * b * (radius**2 - r**2)
        friction = 0.003 * 0.40 / 2 * np.hypot(T, 9.80665 * mass)
        lost = 300e6 * b * h**2 / 4 + friction
        expected = 100 * lost / (T * radius + lost)
        row = rows[f"bending and friction in the total power, {name} coil"]
        assert row.computed == pytest.approx(expected, rel=1e-9)
        assert row.texts[0] == "5 to 10"
        assert row.texts[2] == "not met"

    def test_the_factor_read_off_the_printed_power_is_told(self, rows):
        fitted = {name for name, row in rows.items() if row.fitted}
        assert fitted == {"motor power, 20 m/s", "motor power, drawing"}

    @pytest.mark.parametrize("name", CUT)
    def test_published_number_is_printed_cut_off(self, rows, name):
        scale = 10 ** CUT[name]
        assert np.floor(rows[name].computed * scale + 1e-9) / scale == rows[name].published

    def test_power_on_the_drawing_has_no_efficiency(self, rows):
        assert rows["motor power, drawing"].computed == pytest.approx(2160.0, rel=1e-12)
        assert pytest.approx(2160e3, rel=1e-12) == 1.25 * 1.08 * T * 20.0

    @pytest.mark.parametrize("name", DIGEST | BY_HAND)
    def test_number_that_was_not_published(self, rows, name):
        value, digit = (DIGEST | BY_HAND)[name]
        assert rows[name].computed == pytest.approx(value, abs=0.51 * digit)


class TestSizing:
    @pytest.mark.parametrize("ratio", [1.354, 2.0])
    @pytest.mark.parametrize("power", [None, 2160e3])
    def test_gear_map(self, ratio, power):
        motor, name = sizing.choose_motor(), "high" if ratio < 2 else "low"
        if power is not None:
            motor = sizing.Motor(power / motor.base, power, motor.speed)
        file = reference("gear_map")
        expected = file[f"Tmax_{name}_N" if power is None else f"Tmax_{name}_2160kW_N"]
        received = sizing.greatest_tension(motor, file["v_m_min"] / 60, ratio)
        assert apart(received, expected) < 1e-9

    @pytest.mark.parametrize(
        ("v", "tension", "gear"),
        [(20, 80e3, "high"), (13, 100e3, "low"), (6.67, 110e3, "low"), (18, 90e3, None)],
    )
    def test_choice_of_the_gear(self, v, tension, gear):
        assert sizing.gear_for(v, tension) == gear


def motor(run):
    """Torque of the motor."""
    return -run["drive.motor.flange.tau"]


def load(run):
    """Torque of tension, bending and bearings."""
    tension = run["drive.coil.T"] * run["drive.coil.R"]
    return tension + run["drive.coil.M_b"] + run["drive.bearing.tau"]


def at_mandrel(run):
    """Torque of the motor at the mandrel, without the loss of the gears."""
    return motor(run) * 1.354 - run["drive.mesh.tau_loss"]


def line_acceleration(run):
    radius, w = run["drive.coil.R"], run["drive.coil.w"]
    return radius * run["drive.rotor.a"] / 1.354 + h / (2 * np.pi) * w**2


@pytest.fixture(scope="module")
def run():
    return coiler.winding(grid=reference("run")["t_s"], rtol=1e-12)


class TestWindingRun:
    file = reference("run")

    @pytest.mark.parametrize(
        ("column", "signal"),
        [
            ("R_m", lambda run: run["drive.coil.R"]),
            ("L_m", lambda run: run["drive.coil.L"]),
            ("omega_rad_s", lambda run: run["drive.coil.w"]),
            ("wmotor_rad_s", lambda run: run["drive.rotor.w"]),
            ("J_kgm2", lambda run: run["drive.coil.J"] + J_EMPTY),
            ("Mmotor_Nm", motor),
            ("Pmotor_W", lambda run: motor(run) * run["drive.rotor.w"]),
            ("Mstatic_Nm", load),
            ("v_m_s", lambda run: run["drive.coil.R"] * run["drive.coil.w"]),
            ("a_m_s2", line_acceleration),
            ("domega_rad_s2", lambda run: run["drive.rotor.a"] / 1.354),
            ("Mmandrel_Nm", at_mandrel),
            ("Mdyn_Nm", lambda run: at_mandrel(run) - load(run)),
            (
                "Ptextbook_W",
                lambda run: sizing.tension_power(v=run["drive.coil.R"] * run["drive.coil.w"]),
            ),
            (
                "momentum_influx_Nm",
                lambda run: (
                    rho
                    * b
                    * h
                    * (run["drive.coil.w"] * run["drive.coil.R"]) ** 2
                    * run["drive.coil.R"]
                ),
            ),
        ],
    )
    def test_reference_file(self, run, column, signal):
        # both sides of this jump are 1e-9 s apart in the file; they have a test of their own
        smooth = np.abs(self.file["t_s"] - 144.467299849) > 1e-6
        found = apart(signal(run)[smooth], self.file[column][smooth])
        assert found < 1e-9

    def test_both_sides_of_the_jump_when_slowing_down(self):
        begin = 20.0 + (np.pi * (R**2 - r**2) / h - 360.0) / 20.0
        pair = np.flatnonzero(np.abs(self.file["t_s"] - begin) < 1e-6)
        assert len(pair) == 2
        run = coiler.winding(rtol=1e-12)
        sides = np.flatnonzero(np.abs(run.t - begin) < 1e-9)[[0, -1]]
        for column, signal in (("Mmotor_Nm", motor), ("Mmandrel_Nm", at_mandrel)):
            error = np.abs(signal(run)[sides] - self.file[column][pair])
            assert error.max() < 1e-9 * np.ptp(self.file[column])

    def test_low_gear_turns_the_motor_faster_with_less_torque(self):
        run = coiler.winding(gear=coiler.LOW, v=13.0, grid=50)
        assert run["drive.rotor.w"] == pytest.approx(2 * run["drive.coil.w"], rel=1e-9, abs=1e-9)
        steady = run["drive.motor.flange.tau"][25]
        assert np.abs(steady) < T * run["drive.coil.R"][25] / 1.354


class TestTensionDeviation:
    file = reference("tension_error")

    @pytest.mark.parametrize(
        ("column", "options"), [("dT_correct_N", {}), ("accel_1mps2_N", {"v": 0.0, "a": 1.0})]
    )
    def test_reference_file(self, column, options):
        received = scenes.tension_deviation(self.file["R_m"], **options)
        found = apart(received, self.file[column])
        assert found < 1e-9

    def test_the_text_counts_the_momentum_of_the_strip_twice(self):
        radii = self.file["R_m"]
        twice = scenes.tension_deviation(radii) - rho * b * h * 20.0**2
        assert apart(twice, self.file["dT_text_wdJdt_N"]) < 1e-9
