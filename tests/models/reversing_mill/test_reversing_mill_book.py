"""What the book asks of the reversing mill beside its frequencies, by hand in kgf, m and s.

Reduction to the motor shaft, mass of the shafts, both approaches to the equalizing torque, and the
incoming strip of varying thickness.
"""

import numpy as np
import pytest
from mill_by_hand import (
    BODIES,
    C1,
    C2,
    J1,
    J3,
    JR,
    SLIP,
    STIFFNESS,
    bar_hertz,
    chain,
    creep_as_printed,
    creeping,
    greatest,
    harmonic_torques,
    relative,
)
from scipy.linalg import expm

import lumped as lp
from lumped.components import IdealGear
from lumped.models.reversing_mill import equalizing, incoming, scenes, shaft_mass
from lumped.models.reversing_mill import stand as mill
from lumped.models.reversing_mill.stand import KGF, RATED, SHAFTS

MR = RATED / KGF
BAR_1, BAR_2 = 0.023, 0.0026  # kgf m s2  shaft B1 and the spindles


def found(model: lp.Component) -> lp.Modes:
    return lp.modes(lp.assemble(model))


class TestReduction:
    """Everything referred to the motor shaft: J' = J i^2 (43), C' = C i^2 (44)."""

    def test_a_slow_spindle_and_rolls_behind_a_gear_have_the_frequencies_of_the_referred_ones(self):
        n = 2.5  # speed of the motor over that of the rolls, i = 1 / n

        class Geared(mill.UpperBranch):
            gear: IdealGear = IdealGear(ratio=n)

            def connections(self):
                yield from lp.chain(self.drive, self.motor, self.shaft, self.gearbox, self.gear)
                yield from lp.chain(self.gear, self.spindle, self.rolls, self.barrel)

        own = {"rolls.J": JR * KGF * n**2, "spindle.c": C2 * KGF * n**2}
        assert relative(found(Geared().with_(own)).hertz, found(mill.UpperBranch()).hertz) < 1e-12


class TestFrequencyEquation:
    """Cubic equation (56) in K^2 with the abbreviations a1, a2, a3 before it."""

    def test_its_roots_are_the_frequencies_of_the_closed_gap(self):
        rolls, J2 = 2 * JR, J1 + J3
        a1, a2, a3 = C1 / J1 + C1 / J3, C2 / J3 + C2 / rolls, C2 / J2 + C2 / rolls
        gear, gap = C1 * C2 / J3**2, (C2 / rolls) ** 2
        squares = a1 * a2 + a1 * a3 + a2 * a3 - gear - gap
        last = a1 * a2 * a3 - a3 * gear - a1 * gap
        roots = np.sort(np.roots([1, -(a1 + a2 + a3), squares, -last]))
        assert relative(found(mill.ClosedGap()).hertz, np.sqrt(roots) / (2 * np.pi)) < 1e-12


class TestMassOfTheShafts:
    """Thirds by the nodes, beside continuous shafts in their exact equation."""

    shapes = chain((J1, J3, JR), ((0, 1, C1), (1, 2, C2)))

    def amplitudes(self, mode: int) -> np.ndarray:
        root_J, _, (U, omega, _) = self.shapes
        return U[:, np.argsort(omega)[mode]] / root_J

    def test_two_masses_divide_the_shaft_inversely_to_their_inertias(self):
        near, far = shaft_mass.thirds(0.3, J1 + J3, -JR)
        assert near + far == pytest.approx(0.1, rel=1e-15)
        assert near / far == pytest.approx((J1 + J3) / JR, rel=1e-12)

    @pytest.mark.parametrize("mode", [0, 1])
    def test_nodes_divide_the_shafts_as_the_amplitudes_of_their_ends(self, mode):
        motor, gearbox, rolls = self.amplitudes(mode)
        by_hand = motor / (motor - gearbox), gearbox / (gearbox - rolls)
        assert relative(shaft_mass.nodes(mode), by_hand) < 1e-11
        assert (0 < by_hand[1] < 1) == (mode == 1)  # in the lower mode B2 has no node

    @pytest.mark.parametrize("mode", [0, 1])
    @pytest.mark.parametrize("bars", [(BAR_1, BAR_2), (0.0, BAR_2), (BAR_1, 0.0)])
    def test_thirds_have_the_energy_of_shafts_that_twist_evenly(self, mode, bars):
        a, b, c = self.amplitudes(mode)
        even = bars[0] * (a**2 + a * b + b**2) / 3 + bars[1] * (b**2 + b * c + c**2) / 3
        branch = shaft_mass.upper_with_shafts(mode, *(KGF * J for J in bars))
        J = lp.assemble(branch).parameter_values()
        added = np.array([J[f"{x}.J"] for x in ("motor", "gearbox", "rolls")]) / KGF
        assert (added - [J1, J3, JR]) @ [a**2, b**2, c**2] == pytest.approx(even, rel=1e-9)

    @pytest.mark.parametrize(("mode", "near"), [(0, (15, 30)), (1, (30, 50))])
    def test_upper_frequencies_are_those_of_continuous_shafts(self, mode, near):
        exact = bar_hertz(*near, (J1,), (C1, BAR_1), (J3,), (C2, BAR_2), (JR,))
        received = found(shaft_mass.upper_with_shafts(mode)).hertz[mode]
        assert relative(received, exact) < 4e-6  # (w l / c)^4 / 90 of energy, l / c = 0.53 ms
        assert 0.01 < found(mill.UpperBranch()).hertz[mode] - exact < 0.1

    def test_the_lower_frequency_is_that_of_a_continuous_spindle(self):
        exact = bar_hertz(30, 50, (J1 + J3,), (C2, BAR_2), (JR,))
        assert relative(found(shaft_mass.lower_with_spindle()).hertz, [exact]) < 4e-6

    def test_the_error_of_the_thirds_falls_with_the_square_of_the_mass(self):
        errors = []
        for part in (1.0, 0.5):
            bars = part * BAR_1, part * BAR_2
            exact = bar_hertz(30, 50, (J1,), (C1, bars[0]), (J3,), (C2, bars[1]), (JR,))
            branch = shaft_mass.upper_with_shafts(1, *(KGF * J for J in bars))
            errors.append(found(branch).hertz[1] / exact - 1)
        assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


class TestEqualizingTorque:
    """K_s of (55) from curves, and rolls that do not slip."""

    K_s = 80 * MR / 140

    def test_the_coefficient_is_the_slope_times_torque_over_speed(self):
        assert equalizing.creep_coefficient() == pytest.approx(self.K_s * KGF, rel=1e-12)
        assert equalizing.creep_coefficient(70.0) == pytest.approx(2 * self.K_s * KGF, rel=1e-12)

    def test_peak_at_entry_by_the_complete_equations(self):
        A = np.zeros((9, 9))
        A[:8, :8] = creeping(self.K_s)
        A[3:8, 8] = np.array([MR, 0, -MR, MR, -MR]) / BODIES
        row = np.concatenate([np.zeros(3), self.K_s / 2 * SLIP, [0.0]])
        by_hand = greatest(A, row, 2.0, 20_000) / MR
        gap = mill.CreepingGap(K_s=self.K_s * KGF)
        assert relative(equalizing.peak_at_entry(gap), by_hand) < 1e-6

    def test_peak_at_entry_by_the_printed_equations(self):
        by_hand = greatest(*creep_as_printed(self.K_s, MR), 2.0, 20_000) / MR
        gap = mill.PrintedGap(K_s=self.K_s * KGF)
        assert relative(equalizing.peak_at_entry(gap), by_hand) < 1e-6

    def test_stiff_curves_come_to_rolls_that_do_not_slip(self):
        steep = [
            equalizing.peak_at_entry(mill.CreepingGap(K_s=k * KGF), until=0.5) for k in (1e4, 1e6)
        ]
        stuck = equalizing.peak_at_entry(mill.ClosedGap(), until=0.5)
        assert abs(steep[1] - stuck) < 1e-3 * stuck < abs(steep[0] - stuck)

    @pytest.mark.parametrize("s", [0.03, 0.01])
    def test_steady_rolling_of_unequal_rolls(self, s):
        beta, top, r, K_s = MR / (s * 140), (1 + s) * 140, 1 + scenes.DIFFERENCE, self.K_s
        # both drives, and the creep: unknown w_v, w_n, M_u
        A = [[beta, 0, 1], [0, beta, -1 / r], [K_s / 2, -K_s / 2 / r, -1]]
        M_u = np.linalg.solve(A, [beta * top - MR, beta * top - MR, 0])[2]
        assert relative(equalizing.creeping_with_droop(s, K_s * KGF), M_u / MR) < 1e-8
        # K_s w / M is the slope of the curve, 80, as 1 / s is that of a drive
        assert M_u / MR == pytest.approx(scenes.DIFFERENCE / (2 * s + 2 / 80), rel=0.02)


class TestIncomingStrip:
    """Waves of thickness of the incoming strip."""

    f = 15 * 0.7 / (np.pi * 0.5)

    def test_frequency_is_the_entering_speed_over_the_wave(self):
        assert incoming.thickness_hertz(15.0) == pytest.approx(self.f, rel=1e-15)
        assert incoming.thickness_hertz(10.0, 0.2, 4.0) == pytest.approx(2.0, rel=1e-15)

    @pytest.mark.parametrize(("gap", "K_s"), [(mill.ClosedGap(), 0.0), (mill.CreepingGap(), 300)])
    def test_gains_are_complex_amplitudes(self, gap, K_s):
        received = incoming.thickness_gains(gap, np.array([15.0]), 1.0)[0]
        by_hand = harmonic_torques(self.f, K_s, stuck=not K_s)
        assert np.abs(np.abs(received) - np.abs(by_hand)).max() < 1e-10

    def test_torques_are_those_of_matrix_exponentials(self):
        run = incoming.rolling_waves(15.0, until=1.5, grid=300, rtol=1e-10)
        A, w, swing = np.zeros((10, 10)), 2 * np.pi * self.f, MR * 0.01 / 0.3
        A[:8, :8] = creeping(300.0)
        A[5, 8] = A[7, 8] = -swing / JR  # sine, then cosine
        A[8, 9], A[9, 8] = w, -w
        begin = np.eye(10)[9]
        expected = MR + np.array([STIFFNESS * (expm(A * t) @ begin)[:3] for t in run.t])
        assert np.abs(run.table(SHAFTS) / KGF - expected).max() < 1e-6 * MR

    def test_waves_of_no_height_leave_the_rolling_steady(self):
        run = incoming.rolling_waves(until=0.5, parameters={"h": 0.0})
        assert np.abs(run.table(SHAFTS) / RATED - 1).max() < 1e-12
