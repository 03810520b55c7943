"""Teeth that mesh, and their stiffness, against reports of KISSsoft and against ROSS.

The gears are those of the NREL 5 MW gearbox, calculated by KISSsoft 03/2017 after ISO 6336:2006
method B, ISO 21771 and DIN 3960: `@NREL_5MW/stage_02.rtf` and `stage_03.rtf` of
gfsReboucas/Drivetrain (2a41bf1c).
"""

import dataclasses

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Fixed, GearMesh, Inertia, Torque
from lumped.errors import LumpedError, OptionError
from lumped.life import GearPair, MeshStiffness

TIPS = ("432.838 mm", "815.663 mm", "1906.081 mm")
SUN = GearPair((18, 36), "21 mm", "550 mm", shift=(0.3890, 0.5039), tips=TIPS[:2])
RING = GearPair((36, -93), "21 mm", "550 mm", shift=(0.5039, 0.1171), tips=TIPS[1:])
HELICAL = GearPair(
    *((24, 95), "14 mm", "360 mm"),
    helix="10 deg",
    shift=(0.4800, 0.6691),
    tips=("380.747 mm", "1395.376 mm"),
)
DEG = np.pi / 180


@pytest.mark.parametrize(
    ("pair", "centre", "pressure", "ratio", "overlap", "bases"),
    [
        (SUN, 0.584, 24.169, 1.370, 0.0, (355.204, 710.408)),
        (RING, 0.584, 15.630, 1.618, 0.0, (710.408, -1835.220)),
        (HELICAL, 0.861, 22.856, 1.463, 1.421, (320.026, 1266.770)),
    ],
    ids=["external", "internal", "helical"],
)
def test_the_geometry_is_that_of_the_report(pair, centre, pressure, ratio, overlap, bases):
    assert pair.centre == pytest.approx(centre, rel=2e-6)  # the shifts have four digits
    assert pair.working_pressure / DEG == pytest.approx(pressure, abs=1e-3)
    assert pair.contact_ratio == pytest.approx(ratio, abs=5e-4)
    assert pair.overlap_ratio == pytest.approx(overlap, abs=5e-4)
    assert pair.base_diameters == pytest.approx(np.array(bases) / 1e3, abs=5e-7)


def test_the_tips_are_as_thick_as_in_the_report():
    assert [1e3 * width for width in SUN.tip_widths] == pytest.approx([12.910, 14.858], abs=1e-3)
    assert 1e3 * RING.tip_widths[1] == pytest.approx(18.937, abs=1e-3)


def test_tips_that_are_not_shortened_are_those_of_the_profile_shift():
    """The reference diameter and twice the addendum and the shift, of both signs."""
    whole = GearPair((36, -93), "21 mm", "550 mm", shift=(0.5039, 0.1171))
    assert whole.tip_diameters[1] == pytest.approx(-1.906081, abs=2e-6)


def test_the_stiffness_is_that_of_the_report():
    """The thickness of the rim is not told for the planetary stage, so its factor cancels."""
    helical = MeshStiffness(HELICAL, web=0.25, rim=5.0)
    assert helical.single / 1e9 == pytest.approx(13.832, abs=5e-4)
    assert helical.mean / (0.36 * 1e9) == pytest.approx(18.632, abs=5e-4)
    sun, ring = MeshStiffness(SUN), MeshStiffness(RING)
    assert ring.single / sun.single == pytest.approx(14.053 / 12.240, rel=8e-5)
    for stiffness, single, mean in ((sun, 12.240, 15.640), (ring, 14.053, 20.563)):
        assert stiffness.mean / (stiffness.single * 0.55) == pytest.approx(mean / single, rel=8e-5)


def test_the_resonance_is_that_of_the_report():
    """Of the helical pair: 2843 1/min with 0.36503 kg/mm along the line of action."""
    mass = 0.36503 * 360
    radii = np.array(HELICAL.base_diameters) / 2
    system = assemble_row(
        a=Inertia(J=2 * mass * radii[0] ** 2),
        mesh=GearMesh(teeth=MeshStiffness(HELICAL, web=0.25, rim=5.0), harmonics=0),
        b=Inertia(J=2 * mass * radii[1] ** 2),
    )
    hertz = lp.modes(system).hertz[-1]
    assert 60 * hertz / 24 == pytest.approx(2843, abs=0.5)


def test_moduli_and_racks_scale_the_stiffness():
    steel = MeshStiffness(SUN).single
    iron = MeshStiffness(SUN, moduli=(2.06e11, 1.03e11)).single
    assert iron / steel == pytest.approx(2 / 3, rel=1e-14)
    assert MeshStiffness(SUN, dedendum=1.2).single / steel == pytest.approx(1 / 0.975, rel=1e-14)


def test_the_pair_of_ross_is_plausible():
    """Means of a run of a test of ROSS (test_multi_rotor.py, 631a249a) with half its backlash."""
    pair = GearPair((20, 20), "10 mm", "30 mm", distance=0.20004375431223567)
    assert pair.contact_ratio == pytest.approx(1.5525088765723407, rel=1e-6)
    assert pair.working_pressure == pytest.approx(0.34966621486324245, rel=1e-6)
    assert pair.backlash / 2 == pytest.approx(6.497875817066328e-05 - 5e-5, rel=2e-4)
    assert MeshStiffness(pair).mean == pytest.approx(517925405.2396409, rel=0.07)
    system = assemble_row(
        wall=Fixed(),
        mesh=GearMesh(
            teeth=MeshStiffness(pair), c=517925405.2396409, b=2 * 6.497875817066328e-05, harmonics=0
        ),
        gear=Inertia(J=0.03),
        load=Torque(tau=300.0),
    )
    rest = lp.equilibrium(system)
    assert rest["mesh.f"] == pytest.approx(3191.99620748778, rel=2e-4)
    assert rest["mesh.dte"] == pytest.approx(7.152756140961932e-05, rel=1e-2)


def test_more_distance_is_more_backlash():
    """Thicknesses of both teeth on the working circles leave it of the pitch."""
    tight = GearPair((22, 57), "4 mm", "40 mm", shift=(0.3, 0.2))
    wide = dataclasses.replace(tight, distance=tight.centre + 2e-4)
    inv = lambda x: np.tan(x) - x  # noqa: E731
    widths = 0.0
    for z, base, x in zip(wide.teeth, wide.base_diameters, wide.shift, strict=True):
        half = (np.pi / 2 + 2 * x * np.tan(20 * DEG)) / z + inv(20 * DEG)
        widths += base * (half - inv(wide.working_pressure))
    pitch = np.pi * wide.base_diameters[0] / 22
    assert wide.backlash == pytest.approx(pitch - widths, rel=1e-10)
    assert tight.backlash == 0
    ring = dataclasses.replace(RING, distance=RING.centre - 2e-4)
    assert ring.backlash > 0


@pytest.mark.parametrize(("internal", "sense"), [(False, -1), (True, 1)])
def test_a_mesh_takes_all_from_the_teeth(internal, sense):
    pair = RING if internal else SUN
    teeth = MeshStiffness(pair)
    system = assemble_row(
        drive=Torque(tau=100.0), a=Inertia(J=1.0), mesh=GearMesh(teeth=teeth), b=Inertia(J=1e6)
    )
    first, second = (abs(d) / 2 for d in pair.base_diameters)
    found = [system.parameters[f"mesh.{name}"] for name in ("r_a", "r_b", "z", "c", "b")]
    assert found == pytest.approx([first, second, pair.teeth[0], teeth.mean, 0.0], rel=1e-14)
    point = lp.start_point(system, start={"mesh.s": 1e-5})
    assert point["mesh.flange_b.tau"] == pytest.approx(-sense * second * point["mesh.f"])
    assert point["mesh.f"] > 0


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"distance": 0.149}, r"jam by .* Without backlash it is 0\.15 m"),
        ({"distance": 0.1}, "the base circles need more"),
        ({"distance": 0.154}, "contact ratio is 0"),
        ({"teeth": (12, 40), "shift": (1.0, 0.0)}, "teeth of the pinion end in a point"),
        ({"teeth": (10, 60)}, "undercut"),
        ({"teeth": (20, -20)}, "has more than its pinion"),
        ({"teeth": (20, -25)}, "tip circle of the wheel, .* lies within its base"),
        ({"teeth": (30, -38)}, "too few teeth"),
        ({"tips": ("110 mm", "180 mm")}, "lies within its base"),
        ({"distance": "3 kg"}, "kg"),
    ],
)
def test_teeth_that_do_not_mesh_are_refused(changed, match):
    given = {"teeth": (20, 40), "module": 5e-3, "width": 50e-3} | changed
    with pytest.raises(LumpedError, match=match):
        GearPair(**given)


def test_ten_teeth_more_are_enough_for_an_internal_wheel():
    """As the source of the interference says of standard teeth."""
    assert GearPair((30, -40), 5e-3, 50e-3).internal


@pytest.mark.parametrize(
    ("changed", "match"),
    [({"web": 0.0}, "web = 0 is out"), ({"moduli": (2e11, -1.0)}, "moduli = -1 is out")],
)
def test_wrong_factors_are_refused(changed, match):
    with pytest.raises(OptionError, match=match):
        MeshStiffness(SUN, **changed)


def test_shifts_that_the_fit_does_not_cover_are_refused():
    with pytest.raises(OptionError, match=r"sum of the profile shifts is -0\.6"):
        MeshStiffness(dataclasses.replace(GearPair((40, 60), 5e-3, 50e-3), shift=(-0.3, -0.3)))


def test_a_pair_is_no_stiffness():
    with pytest.raises(LumpedError, match=r"mesh.*MeshStiffness\(pair\) of a GearPair is needed"):
        assemble_row(a=Inertia(J=1.0), mesh=GearMesh(teeth=SUN), b=Inertia(J=1.0))
