"""Eccentric shear at constant speed, against closed forms, reference files and published numbers.

The files of tests/data/eccentric_shear were computed independently with numpy and scipy.
"""

from pathlib import Path

import numpy as np
import pytest

import lumped as lp
from lumped.models import eccentric_shear
from lumped.models.eccentric_shear_scenes import (
    SLOW,
    CrankTurned,
    Demand,
    MotorTurned,
    seated,
    turn,
)
from lumped.models.eccentric_shear_stand import (
    CENTRE_RECTANGLE,
    CENTRE_SHAFT,
    CENTRE_SINE,
    HALF_SINE,
    J_SHAFT,
    M_LOWER,
    M_SHAFT,
    M_UPPER,
    MEETS,
    PULSE,
    RECTANGLE,
    SPEED,
    GuidedShear,
    PrintedShear,
    Shear,
)

ELLIPSES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
PULSES = ("half-sine", "rectangle")
DEGREES = np.radians(np.arange(361.0))
ALWAYS, NEVER = 2 * np.pi - 1e-9, 1e-9  # rad, widths of the switch


def data(name: str) -> np.ndarray:
    path = Path(__file__).parents[1] / "data" / "eccentric_shear" / f"{name}.csv"
    return np.genfromtxt(path, delimiter=",", names=True, deletechars="")


def apart(received: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the range of what is expected."""
    return float(np.abs(received - expected).max() / (np.ptp(expected) or np.abs(expected).max()))


def nearest(phi: np.ndarray) -> np.ndarray:
    """Rows of a run that stand at the degrees of a turn."""
    rows = np.abs(phi[:, None] - DEGREES).argmin(axis=0)
    assert np.abs(phi[rows] - DEGREES).max() < 1e-9
    return rows


def at_degrees(demand: Demand) -> np.ndarray:
    return demand.tau[nearest(demand.phi)]


def crank_turned(
    shear: type[Shear], until: float = 2 * np.pi, cut: lp.Component = HALF_SINE, **changes: float
) -> lp.Trajectory:
    """A turn, results at each degree."""
    model = CrankTurned().with_({"loaded.shear": shear(), "loaded.cut": cut})
    return lp.simulate(
        lp.assemble(model, keep=["motor.phi", "loaded.cut.flange.phi"]),
        until=until / SPEED,
        parameters=changes,
        start=seated(shear),
        grid=DEGREES[until >= DEGREES] / SPEED,
        rtol=1e-10,
    )


UNLOADED = {"loaded.idle.tau": 0.0, "loaded.cut.tau_max": 0.0, "motor.J": 1e-9}


def inertia(run: lp.Trajectory) -> np.ndarray:
    """Reduced inertia: twice the energy of all bodies over the square of the crank speed."""
    path = "loaded.shear"
    energy = M_SHAFT * (run[f"{path}.shaft.mass_x.v"] ** 2 + run[f"{path}.shaft.mass_y.v"] ** 2)
    energy += J_SHAFT * run[f"{path}.shaft.body.w"] ** 2
    energy += M_UPPER * (run[f"{path}.upper.mass_x.v"] ** 2 + run[f"{path}.upper.mass_y.v"] ** 2)
    energy += 21e3 * run[f"{path}.upper.body.w"] ** 2
    try:
        across, up = run[f"{path}.lower.mass_x.v"], run[f"{path}.lower.mass_y.v"]
        energy += M_LOWER * (across**2 + up**2) + 50e3 * run[f"{path}.lower.body.w"] ** 2
    except lp.errors.UnknownNameError:
        energy += M_LOWER * run[f"{path}.lower.v"] ** 2
    return energy / SPEED**2


class TestParameters:
    def test_centre_of_the_shaft_follows_from_its_printed_inertias(self):
        expected = 1.1e3, 0.8e3
        received = (
            J_SHAFT + M_SHAFT * CENTRE_SHAFT**2,
            J_SHAFT + M_SHAFT * (0.25 - CENTRE_SHAFT) ** 2,
        )
        assert np.abs(np.subtract(received, expected)).max() < 1e-9
        assert abs(CENTRE_SHAFT - 0.1599) < 5e-5
        assert abs(J_SHAFT - 660.3) < 0.05

    def test_printed_angles_add_up(self):
        expected = np.radians([129.75, 163.75])
        received = CENTRE_RECTANGLE, CENTRE_RECTANGLE + PULSE / 2
        assert np.abs(received - expected).max() < 1e-14


class TestInertia:
    @pytest.mark.parametrize(
        ("shear", "width", "column", "slope"),
        [
            (PrintedShear, 2 * MEETS, "J_kgm2", "dJ_dphi(without_jumps)"),
            (PrintedShear, ALWAYS, "J1", "dJ1"),
            (PrintedShear, NEVER, "J2_paper", "dJ2_paper"),
            (GuidedShear, ALWAYS, "J1", "dJ1"),
            (GuidedShear, NEVER, "J2_consistent", None),
        ],
    )
    def test_inertia_and_its_slope_are_those_of_the_reference(self, shear, width, column, slope):
        centre = 0.0 if width == 2 * MEETS else 1e-3
        switch = {"loaded.shear.switch.width": width, "loaded.shear.switch.centre": centre}
        run = crank_turned(shear, **(UNLOADED | switch))
        rows, reference = nearest(SPEED * run.t), data("inertia")
        if width == NEVER:  # before the switch lets go
            rows = rows[1:]
        count = len(rows)
        assert apart(inertia(run)[rows], reference[column][-count:]) < 1e-9
        if slope:
            received = -run["drive.flange.tau"][rows] * 2 / SPEED**2
            assert apart(received, reference[slope][-count:]) < 1e-8

    @pytest.mark.parametrize("degrees", [30, 60, 93, 120, 150])
    def test_cross_inertia_of_the_phases_is_that_lost_in_the_impact(self, degrees):
        angle = np.radians(degrees)
        switch = {"loaded.shear.switch.width": 2 * angle}
        run = crank_turned(GuidedShear, until=angle + 0.1, **(UNLOADED | switch))
        lost = sum(event.loss for event in run.events)
        row = data("inertia")[degrees]
        received = (row["J1"] + row["J2_consistent"]) / 2 - lost / SPEED**2
        assert abs(received / row["J12_consistent"] - 1) < 1e-7

    @pytest.mark.parametrize(("pulse", "column"), [(HALF_SINE, "sine"), (RECTANGLE, "rect")])
    def test_cutting_torque_is_that_of_the_reference(self, pulse, column):
        run = crank_turned(PrintedShear, cut=pulse)
        received = -run["loaded.cut.tau"][nearest(SPEED * run.t)]
        assert apart(received, data("inertia")[f"Mcut_{column}_Nm"]) < 1e-9


class TestFourier:
    """A series of the inertia that jumps has no slope: 1982, 3883, 7964 kg m2/rad, unbounded."""

    @pytest.mark.parametrize(("terms", "expected"), [(20, 1982), (40, 3883), (80, 7964)])
    def test_slope_of_the_series_grows_with_the_number_of_terms(self, terms, expected):
        samples = 4 * terms
        shear = PrintedShear
        grid = np.arange(samples) * 2 * np.pi / samples / SPEED
        model = CrankTurned().with_({"loaded.shear": shear()})
        run = lp.simulate(
            lp.assemble(model),
            until=2 * np.pi / SPEED,
            parameters=UNLOADED,
            start=seated(shear),
            grid=grid,
            rtol=1e-10,
        )
        rows = np.abs(run.t[:, None] - grid).argmin(axis=0)
        series = np.fft.rfft(inertia(run)[rows])[: terms + 1] / samples
        k = np.arange(terms + 1)
        phi = np.linspace(0, 2 * np.pi, 20_001)
        slope = 2 * np.real((1j * k * series) @ np.exp(1j * np.outer(k, phi)))
        assert abs(np.abs(slope).max() / expected - 1) < 1e-3
        true = np.abs(run["drive.flange.tau"]).max() * 2 / SPEED**2
        assert true < 1541


class TestEllipses:
    @pytest.mark.parametrize("e", ELLIPSES)
    def test_ratio_slope_and_angle_are_those_of_the_reference(self, e):
        run = crank_turned(PrintedShear, eps=e)
        rows, reference = nearest(SPEED * run.t), data("gear")
        received = run["motor.w"] / SPEED, run["motor.a"] / SPEED**2, run["motor.phi"]
        for values, column in zip(received, ("u", "dudphi", "q_rad"), strict=True):
            expected = reference[f"{column}_e{e:.1f}"]
            assert np.abs(values[rows] - expected).max() < 1e-9 * max(1.0, np.ptp(expected))

    def test_crank_is_slowest_in_the_middle_of_the_cut(self):
        model = MotorTurned()
        system = lp.assemble(model)
        run = lp.simulate(
            system,
            until=2 * np.pi / SPEED,
            parameters={"eps": 0.5},
            start=seated(PrintedShear),
            grid=20_000,
        )
        w = run["loaded.shear.shaft.body.w"]
        phi = run["loaded.shear.crank.phi"][w.argmin()]
        assert abs(phi - CENTRE_SINE) < 1e-3
        assert abs(w.min() / SPEED - 1 / 3) < 1e-6
        assert abs(w.max() / SPEED - 3) < 1e-6


class TestTorque:
    @pytest.mark.parametrize("e", ELLIPSES)
    @pytest.mark.parametrize("pulse", PULSES)
    def test_torque_at_constant_crank_speed_is_that_of_the_reference(self, pulse, e):
        kind = "sine" if pulse == "half-sine" else "rect"
        for law, speed in (("var", SPEED), ("const", SLOW * SPEED)):
            demand = turn(CrankTurned, e, pulse, speed=speed, grid=DEGREES / speed)
            expected = data("torque")[f"M_{kind}_{law}J_e{e:.1f}"]
            assert apart(at_degrees(demand), expected) < 1e-9

    @pytest.mark.parametrize("e", ELLIPSES)
    def test_torque_at_constant_motor_speed_is_that_of_the_reference(self, e):
        instants = data("gear")[f"q_rad_e{e:.1f}"] / SPEED
        instants[-1] = 2 * np.pi / SPEED
        demand = turn(MotorTurned, e, grid=instants)
        expected = data("torque")[f"M_sine_constmotorspeed_e{e:.1f}"]
        rows = np.abs(demand.phi[:, None] - DEGREES).argmin(axis=0)
        assert apart(demand.tau[rows], expected) < 1e-9

    @pytest.mark.parametrize("row", range(28))
    def test_peaks_and_rms_are_those_of_the_reference(self, row):
        """The tops are sampled, here and in the reference."""
        load, mode, e, peak, peak_slow, _, _, rms, rms_slow, *_, least = data("h")[row]
        model = MotorTurned if mode else CrankTurned
        fast = turn(model, e, PULSES[int(load)], grid=8000)
        slow = turn(model, e, PULSES[int(load)], speed=SLOW * SPEED, grid=8000)
        received = fast.peak, slow.peak, fast.rms, slow.rms
        expected = peak, peak_slow, rms, rms_slow
        assert np.abs(np.divide(received, expected) - 1).max() < 1e-6
        # the reference misses the tips at the end of the cut
        assert least - 1e-4 * peak < fast.tau.min() < least + 1e-6 * peak

    @pytest.mark.parametrize(
        ("pulse", "e", "degrees", "expected"),
        [
            ("half-sine", 0.4, -6.5, 2.37),
            ("half-sine", 0.5, -8.5, 3.20),
            ("rectangle", 0.4, -6.0, 1.67),
            ("rectangle", 0.5, -6.5, 1.72),
        ],
    )
    def test_ratio_that_is_greatest_before_the_middle_does_better(
        self, pulse, e, degrees, expected
    ):
        centre = CENTRE_SINE if pulse == "half-sine" else CENTRE_RECTANGLE
        even = turn(CrankTurned, 0.0, pulse, grid=4000)
        shifted = turn(CrankTurned, e, pulse, slowest=centre + np.radians(degrees), grid=4000)
        assert abs(even.peak / shifted.peak - expected) < 0.005

    @pytest.mark.parametrize(("e", "peak", "rms"), [(0.4, 2.33, 1.70), (0.5, 2.995, 1.64)])
    def test_speed_of_four_cuts_a_minute_gives_the_other_reductions(self, e, peak, rms):
        even, found = (turn(CrankTurned, each, speed=0.419, grid=4000) for each in (0.0, e))
        assert abs(even.peak / found.peak - peak) < 0.005
        assert abs(even.rms / found.rms - rms) < 0.005

    @pytest.mark.parametrize("e", [0.0, 0.5])
    def test_reading_of_the_supports_does_not_matter_at_constant_speed(self, e):
        """The supports are a few per cent of the inertia."""
        printed, guided = (
            turn(CrankTurned, e, shear=shear, grid=4000) for shear in (PrintedShear, GuidedShear)
        )
        assert 0 < abs(guided.peak / printed.peak - 1) < 1e-3
        assert abs(guided.rms / printed.rms - 1) < 1e-3

    @pytest.mark.parametrize("e", ELLIPSES)
    def test_rectangle_is_never_reduced_beyond_its_width(self, e):
        even = turn(CrankTurned, 0.0, "rectangle", speed=SLOW * SPEED, grid=2000)
        found = turn(CrankTurned, e, "rectangle", speed=SLOW * SPEED, grid=2000)
        assert even.peak / found.peak <= 1 / np.sin(PULSE / 2)

    def test_best_ellipse_for_a_rectangle_reaches_the_bound(self):
        even = turn(CrankTurned, 0.0, "rectangle", speed=SLOW * SPEED, grid=2000)
        best = turn(
            *(CrankTurned, float(np.tan(np.pi / 4 - PULSE / 4)), "rectangle"),
            speed=SLOW * SPEED,
            grid=2000,
        )
        assert abs(even.peak / best.peak * np.sin(PULSE / 2) - 1) < 1e-9

    @pytest.mark.parametrize(("e", "expected"), [(0.4, 2.33), (0.5, 2.86)])
    def test_printed_phase_raises_the_peak(self, e, expected):
        phase = eccentric_shear.printed_phase(e)
        even = turn(CrankTurned, 0.0, "rectangle", grid=4000)
        found = turn(CrankTurned, e, "rectangle", slowest=phase, grid=4000)
        assert abs(found.peak / even.peak - expected) < 0.005

    def test_phase_of_circles_does_not_matter(self):
        received = turn(CrankTurned, 0.0, slowest=0.3, grid=400)
        expected = turn(CrankTurned, 0.0, slowest=2.0, grid=400)
        assert np.array_equal(received.tau, expected.tau)


class TestRows:
    def test_published_numbers_stand_beside_those_of_the_model(self):
        """Deviations of the claims are those of the independent reference: 7, 5, 6 and 4 %."""
        rows = {row.quantity: row for row in eccentric_shear.rows()}
        expected = {
            "travel while cutting": 199.97,
            "approach of the upper support": 260.18,
            "overlap of the knives": 14.996,
            "equivalent rectangular torque": 1.3673,
            "greatest torque, reduction, e = 0.4": 1 / 0.4308700207,
            "greatest torque, reduction, e = 0.5": 1 / 0.3514210649,
            "RMS torque, reduction, e = 0.4": 1.690105286,
            "RMS torque, reduction, e = 0.5": 1.626450578,
            "greatest torque, rectangle, reduction, e = 0.4": 1 / 0.6487874283,
            "greatest torque, rectangle, reduction, e = 0.5": 1 / 0.6504878424,
            "free run, time of two turns": 11.9821494221,
            "free run, greatest motor torque": 2739.2,
            "free run, speed kept where the pin lands": 0.9997440084 / 1.0494349947,
        }
        for quantity, value in expected.items():
            assert abs(rows[quantity].computed / value - 1) < 5e-5, quantity
        assert all(row.remark for row in rows.values())

    def test_figures_are_drawn(self):
        received = set(eccentric_shear.plots())
        assert received == {"torque", "reduction", "free_run"}
