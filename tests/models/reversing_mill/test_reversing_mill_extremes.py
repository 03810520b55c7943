"""Reversing cold mill 400: stiff and massless parts, shafts with mass, and the printed gap.

Everything written by hand here is in the source's units, kgf, m and s.
"""

import numpy as np
import pytest
from mill_by_hand import C1, C2, CLOSED, J1, J3, JR, data, hertz, relative
from rows import in_a_row
from scipy.optimize import brentq

import lumped as lp
from lumped.components import IdealGear, Inertia, Spring
from lumped.errors import SolverError
from lumped.models.reversing_mill import shaft_mass
from lumped.models.reversing_mill import stand as mill
from lumped.models.reversing_mill.stand import KGF, ClosedGap, OpenGap


def found(model: lp.Component, parameters: dict | None = None) -> lp.Modes:
    return lp.modes(lp.assemble(model), parameters=parameters)


class TestStiffParts:
    # kgf m, and three frequencies in Hz; the last digit printed is rounded
    @pytest.mark.parametrize(
        ("stiffness", "expected", "rounding"),
        [
            (1e6, [6.521414, 38.63609, 137.1456], [5e-7, 5e-6, 5e-5]),
            (1e8, [6.525926, 38.66504, 1369.48], [5e-7, 5e-6, 5e-3]),
            (1e12, [6.525971, 38.66531, 1.36946e5], [5e-7, 5e-6, 0.5]),
        ],
    )
    def test_stiff_long_shaft_keeps_the_digits_of_the_low_modes(
        self, stiffness, expected, rounding
    ):
        received = found(ClosedGap(), {"upper.shaft.c": stiffness * KGF}).hertz
        bodies, (_, *spindles) = CLOSED
        assert relative(received, hertz(bodies, ((0, 1, stiffness), *spindles))) < 1e-9
        assert (np.abs(received - expected) <= rounding).all()

    @pytest.mark.parametrize("row", data("workroll"), ids=lambda row: f"{row[0]:.0e}")
    def test_work_rolls_on_contact_springs_keep_the_low_modes(self, row):
        contact, *expected = row
        received = found(FourHigh(), {f"{s}_contact.c": contact * KGF for s in ("upper", "lower")})
        by_hand = hertz(
            (J1, J3, 0.16, 2 * 0.0001, 0.16, J1 + J3),
            ((0, 1, C1), (1, 2, C2), (2, 3, contact), (4, 3, contact), (5, 4, C2)),
        )
        assert relative(received.hertz[:3], expected[:3]) < 1e-9
        assert relative(received.hertz, by_hand) < 1e-9
        assert relative(received.hertz[3:], expected[3:]) < 1e-9
        assert received.rigid == 1

    def test_work_rolls_without_inertia_leave_an_algebraic_node(self):
        """Two contacts in series; stiff ones leave the modes of the closed gap."""
        for contact in (1e4, 1e6, 1e12):
            springs = {f"{side}_contact.c": contact * KGF for side in ("upper", "lower")}
            received = found(NoWorkRolls(), springs)
            bodies = (J1, J3, 0.16, 0.16, J1 + J3)
            shafts = ((0, 1, C1), (1, 2, C2), (2, 3, contact / 2), (4, 3, C2))
            assert relative(received.hertz, hertz(bodies, shafts)) < 1e-9
        bodies = (J1, J3, 0.32, J1 + J3)
        assert relative(received.hertz[:3], hertz(bodies, CLOSED[1])) < 1e-6


class FourHigh(OpenGap):
    """Work rolls as bodies of their own, joined by the strip, on elastic contacts."""

    upper: mill.UpperBranch = mill.UpperBranch().with_({"rolls.J": mill.J_BACKUP})
    lower: mill.LowerBranch = mill.LowerBranch().with_({"rolls.J": mill.J_BACKUP})
    upper_contact: Spring = Spring(c=1e6)
    lower_contact: Spring = Spring(c=1e6)
    upper_work: lp.Component = Inertia(J=mill.J_WORK)
    lower_work: lp.Component = Inertia(J=mill.J_WORK)

    def connections(self):
        yield from super().connections()
        yield from lp.chain(
            self.upper.barrel,
            self.upper_contact,
            self.upper_work,
            self.lower_work,
            self.lower_contact,
            self.lower.barrel,
        )


class NoWorkRolls(FourHigh):
    """The same without bodies between the contacts."""

    upper_work: IdealGear = IdealGear(ratio=1.0)
    lower_work: IdealGear = IdealGear(ratio=1.0)


class TestMassOfTheShafts:
    """A spindle with mass: the rule of the thirds (45), and the exact equation of a bar."""

    @pytest.mark.parametrize("row", data("shaft_rule"), ids=lambda row: f"{row[0]:g}")
    def test_rule_and_bar_are_those_of_the_reference(self, row):
        J, exact, thirds = row
        branch = shaft_mass.lower_with_spindle(J * KGF)
        assert relative(found(branch).hertz, [thirds]) < 1e-11

        def bar(w):  # tan b = b Js (J1 + J2) / (b^2 J1 J2 - Js^2), b = w sqrt(Js / C)
            b, J2 = w * np.sqrt(J / C2), J1 + J3
            return np.sin(b) * (b**2 * JR * J2 - J**2) - b * J * (JR + J2) * np.cos(b)

        w = 2 * np.pi * exact
        assert relative(brentq(bar, 0.99 * w, 1.01 * w, xtol=1e-13, rtol=1e-15) / w, [1.0]) < 1e-11
        # a chain of n pieces comes to the bar with n^-2
        chains = [found(chain_of(n, J * KGF)).hertz[0] for n in (20, 40)]
        assert abs((4 * chains[1] - chains[0]) / 3 / exact - 1) < 1e-7

    def test_printed_influence_needs_a_spindle_of_one_sixtieth_of_the_roll(self):
        light, heavy = (
            found(shaft_mass.lower_with_spindle(J)).hertz[0] for J in (1e-9, shaft_mass.J_SPINDLE)
        )
        assert abs(light - heavy - 0.1) < 0.005
        assert abs(shaft_mass.J_SPINDLE / KGF / JR - 0.016) < 0.0005


def chain_of(n: int, J: float) -> lp.Component:
    """Lower branch whose spindle is a chain of `n` springs with half a piece at either end of each.

    `J` in kg.m2.
    """
    inside = [Inertia(J=J / n) for _ in range(n - 1)]
    springs = [Spring(c=n * mill.C_SPINDLE) for _ in range(n)]
    ends = (Inertia(J=JR * KGF + J / n / 2), Inertia(J=(J1 + J3) * KGF + J / n / 2))
    links = [part for pair in zip(springs, [*inside, None], strict=True) for part in pair if part]
    return in_a_row(rolls=ends[0], links=links, drive=ends[1])


class TestPrintedGap:
    """Equations (54) and (55), which leave out the difference of the rolls' inertia torques."""

    def test_without_creep_it_is_no_open_gap(self):
        received = found(mill.PrintedGap(), {"K_s": 0.01 * KGF}).hertz
        assert np.abs(received - [21.887, 39.160]).max() < 5.1e-4
        assert np.abs(found(OpenGap()).hertz[:2] - received).min() > 0.2
        with pytest.raises(SolverError, match="not finite"):
            found(mill.PrintedGap(), {"K_s": 0.0})
