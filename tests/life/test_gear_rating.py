"""Gear geometry and stresses against identities of the involute and calculations by hand."""

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped.components import Damper, Fixed, Inertia
from lumped.errors import OptionError
from lumped.life import (
    GearPair,
    GearStrength,
    contact_stress,
    equivalent_load,
    helix_for_centre,
    least_module,
    rate_gears,
    root_stress,
)

SPUR = GearPair((20, 40), "5 mm", "50 mm")
HELICAL = GearPair((25, 63), "8 mm", "120 mm", helix="15 deg")
DEG = np.pi / 180


def path_of_contact(z, m, alpha):
    """Length of the path of contact of a standard spur pair over the base pitch."""
    radii = [m * k / 2 for k in z]
    arms = [np.sqrt((r + m) ** 2 - (r * np.cos(alpha)) ** 2) for r in radii]
    return (sum(arms) - sum(radii) * np.sin(alpha)) / (np.pi * m * np.cos(alpha))


class TestGeometry:
    def test_contact_ratio_of_a_standard_spur_pair(self):
        assert SPUR.contact_ratio == pytest.approx(1.6352, abs=5e-5)
        assert SPUR.contact_ratio == pytest.approx(path_of_contact((20, 40), 5.0, 20 * DEG))

    def test_a_rack_like_wheel_reaches_the_greatest_contact_ratio(self):
        """Two racks have ``4 / (pi sin 2 alpha)``, 1.981 at 20 degrees."""
        found = GearPair((10**6, 10**6), 1.0, 1.0).contact_ratio
        assert found == pytest.approx(4 / (np.pi * np.sin(40 * DEG)), rel=1e-4)

    def test_helical_gears_are_spur_gears_without_a_helix(self):
        found = GearPair((20, 40), 5e-3, 50e-3, helix=0.0)
        assert found.transverse_pressure == pytest.approx(20 * DEG)
        assert found.base_helix == found.overlap_ratio == 0
        assert found.virtual_teeth == (20, 40)
        assert found.helix_factor == found.root_helix_factor == 1
        assert found.contact_ratio_factor == pytest.approx(np.sqrt((4 - 1.63519) / 3), rel=1e-5)
        assert found.root_ratio_factor == pytest.approx(0.25 + 0.75 / 1.63519, rel=1e-5)
        assert found.zone_factor == pytest.approx(np.sqrt(4 / np.sin(40 * DEG)), rel=1e-12)
        assert found.zone_factor == pytest.approx(2.495, abs=5e-4)

    def test_helical_pair_by_hand(self):
        beta, alpha = 15 * DEG, 20 * DEG
        transverse = np.arctan(np.tan(alpha) / np.cos(beta))
        assert HELICAL.transverse_pressure == pytest.approx(transverse, rel=1e-14)
        # the same base helix by the tangent: tan beta_b = tan beta cos alpha_t
        base = np.arctan(np.tan(beta) * np.cos(transverse))
        assert HELICAL.base_helix == pytest.approx(base, rel=1e-12)
        d = 8e-3 * 25 / np.cos(beta)
        assert HELICAL.diameters == pytest.approx((d, d * 63 / 25))
        assert HELICAL.centre == pytest.approx(8e-3 * 88 / (2 * np.cos(beta)))
        assert HELICAL.virtual_teeth[0] == pytest.approx(25 / np.cos(beta) ** 3)
        assert HELICAL.overlap_ratio == pytest.approx(0.12 * np.sin(beta) / (np.pi * 8e-3))
        radii = np.array(HELICAL.diameters) / 2
        arms = np.sqrt((radii + 8e-3) ** 2 - (radii * np.cos(transverse)) ** 2)
        pitch = np.pi * 8e-3 / np.cos(beta) * np.cos(transverse)
        expected = (arms.sum() - HELICAL.centre * np.sin(transverse)) / pitch
        assert HELICAL.contact_ratio == pytest.approx(expected, rel=1e-12)

    @pytest.mark.parametrize("shift", [(0.3, 0.2), (0.4, -0.4), (-0.1, -0.2)])
    def test_shifted_teeth_touch_without_play_at_their_centre_distance(self, shift):
        """Thickness of both teeth on the working circles is their pitch."""
        pair = GearPair((22, 57), 4e-3, 40e-3, helix=12 * DEG, shift=shift)
        alpha, working = pair.transverse_pressure, pair.working_pressure
        involute = lambda x: np.tan(x) - x  # noqa: E731
        widths = []
        for z, d, x in zip(pair.teeth, pair.diameters, shift, strict=True):
            half = np.pi / (2 * z) + 2 * x * np.tan(20 * DEG) / z
            rolling = d * np.cos(alpha) / np.cos(working)
            widths.append(rolling * (half + involute(alpha) - involute(working)))
        pitch = np.pi * pair.diameters[0] * np.cos(alpha) / np.cos(working) / 22
        assert sum(widths) == pytest.approx(pitch, rel=1e-12)
        rolling = sum(pair.diameters) / 2 * np.cos(alpha) / np.cos(working)
        assert pair.centre == pytest.approx(rolling, rel=1e-14)
        assert (pair.centre == pytest.approx(sum(pair.diameters) / 2)) == (sum(shift) == 0)

    def test_wide_helical_teeth_have_the_bounds_of_their_factors(self):
        wide = GearPair((30, 60), 4e-3, 400e-3, helix=35 * DEG)
        assert wide.overlap_ratio > 1
        assert wide.contact_ratio_factor == pytest.approx(wide.contact_ratio**-0.5, rel=1e-14)
        assert wide.root_helix_factor == 0.75
        narrow = GearPair((30, 60), 4e-3, 20e-3, helix=10 * DEG)
        overlap = 20 * np.sin(10 * DEG) / (np.pi * 4)
        assert narrow.root_helix_factor == pytest.approx(1 - overlap * 10 / 120, rel=1e-12)

    def test_the_helix_follows_from_a_rounded_centre_distance(self):
        plain = 16e-3 * (30 + 41) / (2 * np.cos(12 * DEG))
        assert helix_for_centre((30, 41), module=16e-3, centre=plain) == pytest.approx(12 * DEG)
        beta = helix_for_centre((30, 41), module=16e-3, centre=0.580)
        assert GearPair((30, 41), 16e-3, 0.2, helix=beta).centre == pytest.approx(0.580, rel=1e-14)
        with pytest.raises(OptionError, match=r"spur gears are 0\.568 m apart"):
            helix_for_centre((30, 41), module=16e-3, centre=0.5)


class TestStress:
    def test_contact_stress_is_that_of_two_rollers_at_the_pitch_point(self):
        """Hertz, by hand; Z_eps takes the length of contact of several pairs."""
        torque = 500.0
        force = torque / (0.05 * np.cos(20 * DEG))  # normal to the flank, N
        radii = np.array([50e-3, 100e-3]) * np.sin(20 * DEG)
        modulus = 2.06e11 / (2 * (1 - 0.3**2))
        hertz = np.sqrt(force * modulus * (1 / radii).sum() / (np.pi * 50e-3))
        expected = hertz * np.sqrt((4 - path_of_contact((20, 40), 5.0, 20 * DEG)) / 3)
        assert contact_stress(SPUR, torque) == pytest.approx(expected, rel=1e-12)

    def test_elasticity_of_steel_is_that_of_the_books(self):
        """Z_E = 189.8 sqrt(MPa), and 162.0 for steel and cast iron of 118 GPa."""
        plain = SPUR.zone_factor * SPUR.contact_ratio_factor
        size = np.sqrt(2 * 100.0 * 3 / (0.05 * 0.1**2 * 2))
        assert contact_stress(SPUR, 100.0) / plain / size / 1e3 == pytest.approx(189.8, abs=0.05)
        iron = contact_stress(SPUR, 100.0, wheel=(1.18e11, 0.3)) / plain / size / 1e3
        assert iron == pytest.approx(162.0, abs=0.05)

    def test_root_stress_by_hand(self):
        """2 x 1.3 x 800 / (0.05 x 0.1 x 0.005) x 2.8 x 1.55 x Y_eps."""
        ratio = path_of_contact((20, 40), 5.0, 20 * DEG)
        expected = 2 * 1.3 * 800 / (0.05 * 0.1 * 5e-3) * 2.8 * 1.55 * (0.25 + 0.75 / ratio)
        found = root_stress(SPUR, 800.0, form=2.8, correction=1.55, load_factor=1.3)
        assert found == pytest.approx(expected, rel=1e-12)

    def test_the_least_module_just_stands_the_torque(self):
        beta, strength = 12 * DEG, 300e6
        module = 6e-3
        pair = GearPair((24, 60), module, 0.5 * 24 * module / np.cos(beta), helix=beta)
        shape = 2.6 * 1.6 * pair.root_ratio_factor * pair.root_helix_factor
        torque = 1.0 / root_stress(pair, 1.0, form=2.6, correction=1.6, load_factor=1.4) * strength
        found = least_module(
            torque, teeth=24, width=0.5, shape=shape, strength=strength, load_factor=1.4, helix=beta
        )
        assert found == pytest.approx(module, rel=1e-12)
        with pytest.raises(OptionError, match="must be positive"):
            least_module(-1.0, teeth=24, width=0.5, shape=1.0, strength=1.0)

    def test_safety_falls_with_the_root_of_the_torque_and_with_the_torque(self):
        strength = GearStrength(1200e6, (400e6, 380e6), (2.8, 2.4), (1.55, 1.67), 1.25)
        found = rate_gears(SPUR, {"peak": 800.0, "equivalent": -200.0}, strength=strength)
        peak, other = found["peak"], found["equivalent"]
        assert other.contact / peak.contact == pytest.approx(2.0, rel=1e-12)
        assert other.root / peak.root == pytest.approx(4.0, rel=1e-12)
        assert peak.contact == pytest.approx(1200e6 / contact_stress(SPUR, 1000.0), rel=1e-12)
        weaker = root_stress(SPUR, 1000.0, form=2.8, correction=1.55)
        assert peak.root == pytest.approx(400e6 / weaker, rel=1e-12)
        assert "equivalent" in repr(found)
        with pytest.raises(OptionError, match="nothing loads the teeth"):
            rate_gears(SPUR, {"none": 0.0}, strength=strength)

    def test_stress_of_a_run_and_its_slope(self):
        """A body runs down in oil: the teeth carry its torque k w."""
        model = lp.compose(
            body=Inertia(J=2.0, w=50.0),
            drag=Damper(d=0.5),
            wall=Fixed(),
            connections=lambda m: [*lp.chain(m.body, m.drag, m.wall)],
        )
        of = contact_stress(SPUR, equivalent_load(("drag.tau", "body.w"), exponent=3.0))
        found = lp.gradient(lp.assemble(model), of=[of], by=["drag.d"], until=3.0, rtol=1e-10)
        done, turned = (
            scipy.integrate.quad(f, 0, 3)[0]
            for f in (
                lambda t: (25 * np.exp(-t / 4)) ** 3 * np.exp(-t / 4),
                lambda t: np.exp(-t / 4),
            )
        )
        torque = (done / turned) ** (1 / 3)
        assert found.values[0] == pytest.approx(contact_stress(SPUR, torque), rel=1e-8)


class TestRefusals:
    @pytest.mark.parametrize(
        "changed", [{"module": -1.0}, {"width": 0.0}, {"helix": 1.0}, {"pressure": 0.0}]
    )
    def test_geometry(self, changed):
        given = {"teeth": (20, 40), "module": 5e-3, "width": 50e-3} | changed
        with pytest.raises(OptionError, match="out of range"):
            GearPair(**given)

    def test_too_few_teeth(self):
        with pytest.raises(OptionError, match="at least 5"):
            GearPair((4, 40), 5e-3, 50e-3)
