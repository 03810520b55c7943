"""Mass-elastic and Holzer tables against published drives, closed forms and balance of torques."""

import numpy as np
import pytest
from checks import refused
from rows import assemble_row, assemble_rows, in_a_row, in_rows
from torsional_cases import BODIES, INERTIAS, LBF_IN, STIFFNESSES, Excited, columns, marine

import lumped as lp
from lumped.components import (
    Cylinder,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    Planetary,
    Propeller,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.components.shafts.element import ShaftElement
from lumped.errors import OptionError, UnknownNameError
from lumped.models.diesel_genset.drive import SHAFTS
from tests.vibration.speeds.test_mean_modes import ANGLES, PRESSURE, SIZE, chain, lever, two_masses

GIVEN = {
    "propeller": (1.0, 2.454e6),
    "bull": (1.0, 0.826e6),
    "low.wheel": (9.4094, 1.283e4),
    "low.rotor": (40.0424, 1.509e4),
    "high.wheel": (9.4094, 2.723e4),
    "high.rotor": (78.2365, 2.612e2),
    "shaft": (1.0, 826e6),
    "low.intermediate": (9.4094, 203.94e6),
    "low.shaft": (40.0424, 30.51e6),
    "high.intermediate": (9.4094, 24.17e6),
    "high.shaft": (78.2365, 14.26e6),
}
TABLE = {
    "bull": "bull_gear",
    "low.wheel": "lp_wheel",
    "low.rotor": "lp_turbine",
    "high.wheel": "hp_wheel",
    "high.rotor": "hp_turbine",
}


def referred(system, shaft="propeller.phi"):
    return lp.vibration.mass_elastic(lp.modes(system), shaft=shaft)


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize(("over", "turns"), [("propeller.phi", 1.0), ("low.rotor.phi", 40.0424)])
def test_parts_are_those_of_the_drive_on_their_shafts_and_on_one(damped, over, turns):
    found = referred(marine(damped=damped), over)
    assert {part.name for part in found.parts} == set(GIVEN)
    assert found.left_out == ()
    for part in found.parts:
        ratio, size = GIVEN[part.name]
        own = getattr(part, "J", None) or part.c
        expected = [ratio / turns, size * LBF_IN, size * LBF_IN * (ratio / turns) ** 2]
        assert [part.ratio, own, part.referred] == pytest.approx(expected, rel=1e-9), part.name


@pytest.mark.parametrize("damped", [False, True])
def test_modes_of_the_marine_turbine_are_those_of_the_reference(damped):
    found = referred(marine(damped=damped))
    table = columns("01_marine_steam_turbine", "modes.csv")
    assert found.hertz[:3] * 60 == pytest.approx(table["per_minute"][1:], rel=1e-9)
    for mode in range(3):
        holzer = found.holzer(mode)
        for name, column in TABLE.items():
            share = holzer.angle(name) / holzer.angle("propeller")
            assert share == pytest.approx(table[column][mode + 1], rel=1e-7), name
        assert holzer.residual < 1e-12


def test_the_order_leads_from_the_free_ends_to_the_last_inertia():
    names = [part.name for part in referred(marine(damped=True)).parts]
    assert names[:2] == ["propeller", "shaft"]
    assert names[2:7] == ["low.rotor", "low.shaft", "low.wheel", "low.intermediate", "bull"]
    assert names[7:] == ["high.intermediate", "high.wheel", "high.shaft", "high.rotor"]


def test_torques_follow_from_holzers_recursion_along_a_crankshaft():
    """From one end to the other by hand: the torque left at the end vanishes."""
    found = referred(lp.assemble(Excited()), "pulley.phi")
    known = columns("02_six_cylinder_crankshaft", "natural_frequencies.csv")
    assert found.hertz[:5] == pytest.approx(known["Hz"], rel=1e-9)
    shafts = [name.removesuffix(".tau_c") for name in SHAFTS]
    for mode in range(5):
        holzer = found.holzer(mode)
        square = (2 * np.pi * found.hertz[mode]) ** 2
        angle, torque, largest = holzer.angle("pulley"), 0.0, 0.0
        for i, J in enumerate(INERTIAS):
            assert holzer.angle(BODIES[i]) == pytest.approx(angle, rel=1e-9, abs=1e-10)
            assert holzer.torque(BODIES[i]) == pytest.approx(
                J * square * angle, rel=1e-9, abs=1e-10 * square
            )
            torque += J * square * angle
            largest = max(largest, abs(torque))
            if i < len(STIFFNESSES):
                assert holzer.torque(shafts[i]) == pytest.approx(-torque, abs=1e-10 * largest)
                angle -= torque / STIFFNESSES[i]
        assert abs(torque) < 1e-9 * largest  # rounding grows from shaft to shaft
        assert abs(holzer.end) < 1e-12 * largest


def test_amplitudes_without_damping_are_those_of_the_modes():
    system = marine(damped=False)
    modes = lp.modes(system)
    found = lp.vibration.mass_elastic(modes, shaft="propeller.phi")
    assert found.hertz == pytest.approx(modes.hertz, rel=1e-12)
    for mode in range(len(modes.hertz)):
        holzer = found.holzer(mode)
        for name in ("bull", *TABLE):
            expected = modes.shape(f"{name}.phi")[mode] / modes.shape("high.rotor.phi")[mode]
            received = holzer.angle(name) / holzer.angle("high.rotor")
            assert received == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_power_is_the_same_on_all_shafts():
    holzer = referred(marine(damped=True)).holzer(1)
    same = holzer.referred
    assert same.angles * same.torques == pytest.approx(holzer.angles * holzer.torques, rel=1e-12)
    assert np.abs(same.angles).max() == pytest.approx(1.0)
    assert same.referred is same


def test_a_drive_against_the_ground_with_a_spring_that_joins_springs():
    """Two springs in series without an inertia between them, one end held, a reversing gear."""
    model = in_a_row(
        wall=Fixed(),
        first=SpringDamper(c=300.0, d=0.4),
        second=Spring(c=600.0),
        gear=IdealGear(ratio=-2.0),
        body=Inertia(J=0.5),
    )
    found = referred(lp.assemble(model), "body.phi")
    w = np.sqrt(200.0 * 4 / 0.5)
    assert found.hertz == pytest.approx([w / (2 * np.pi)], rel=1e-10)
    ratios = {part.name: part.ratio for part in found.parts}
    assert ratios == pytest.approx({"first": -2.0, "second": -2.0, "body": 1.0})
    holzer = found.holzer(0)
    torque = 0.5 * w**2 * holzer.angle("body")
    assert holzer.torque("first") == pytest.approx(holzer.torque("second"), rel=1e-10)
    assert abs(holzer.torque("second")) == pytest.approx(torque / 2, rel=1e-10)
    assert abs(holzer.angle("first")) == pytest.approx(torque / 2 / 300.0, rel=1e-10)
    assert holzer.residual < 1e-12


def test_a_loop_of_two_parallel_shafts_adds_their_stiffnesses():
    model = lp.compose(
        a=Inertia(J=2.0),
        b=Inertia(J=3.0),
        one=Spring(c=100.0),
        other=Spring(c=50.0),
        connections=lambda m: [*lp.chain(m.a, m.one, m.b), *lp.chain(m.a, m.other, m.b)],
    )
    found = referred(lp.assemble(model), "a.phi")
    assert found.hertz == pytest.approx([np.sqrt(150 * (1 / 2 + 1 / 3)) / (2 * np.pi)], rel=1e-12)
    holzer = found.holzer(0)
    assert holzer.torque("one") == pytest.approx(2 * holzer.torque("other"), rel=1e-12)
    assert holzer.residual < 1e-12


def test_what_is_no_shaft_is_told():
    model = in_a_row(
        a=Inertia(J=2.0),
        shaft=Spring(c=100.0),
        b=Inertia(J=3.0),
        slip=Damper(d=1.0),
        c=Inertia(J=1.0),
        more=Spring(c=10.0),
        end=Inertia(J=1.0),
    )
    found = referred(lp.assemble(model), "a.phi")
    assert [part.name for part in found.parts] == ["a", "shaft", "b"]
    assert set(found.left_out) == {"c", "more", "end"}
    assert "left out: c, end, more" in repr(found)


def test_a_differential_has_no_ratio():
    model = in_rows(
        "a shaft gear.sun",
        "gear.ring more c",
        "gear.carrier b",
        a=Inertia(J=2.0),
        shaft=Spring(c=100.0),
        gear=Planetary(ratio=2.0),
        b=Inertia(J=3.0),
        more=Spring(c=10.0),
        c=Inertia(J=1.0),
    )
    found = referred(lp.assemble(model), "a.phi")
    assert [part.name for part in found.parts] == ["shaft", "a"]
    assert found.left_out == ("gear", "b", "c", "more")


def test_tables_tell_ratios_sizes_and_the_residual():
    found = referred(marine(damped=True))
    assert "6 inertias and 5 stiffnesses, referred to propeller.phi" in repr(found)
    told = repr(found.holzer(0))
    assert "mode 1, 2.9618" in told
    assert "residual torques below 1e-12 of the largest" in told


def test_the_picture_shows_every_inertia_and_shaft():
    holzer = referred(marine(damped=True)).holzer(0)
    angles, torques = holzer.plot().axes
    points = angles.lines[-1].get_ydata()
    heavy = [i for i, part in enumerate(holzer.parts) if hasattr(part, "J")]
    assert points == pytest.approx(holzer.referred.angles[heavy])
    bars = [bar.get_height() for bar in torques.patches]
    shafts = [i for i in range(len(holzer.parts)) if i not in heavy]
    assert bars == pytest.approx(holzer.referred.torques[shafts])


def test_slips_are_named(two_mass):
    system = marine(damped=False)
    found = referred(system)
    refused(OptionError, lambda: found.holzer(5), "there is no mode 5; 5 modes count from 0")
    refused(UnknownNameError, lambda: found.holzer(0).torque("shaff"), "shaft")
    refused(UnknownNameError, lambda: referred(system, "propeler.phi"))
    gears = IdealGear(ratio=2.0), IdealGear(ratio=-3.0)
    loop = in_rows(
        "a shaft one b",
        "a soft other b",
        a=Inertia(J=1.0),
        shaft=Spring(c=9.0),
        one=gears[0],
        other=gears[1],
        b=Inertia(J=2.0),
        soft=Spring(c=1.0),
    )
    with pytest.raises(OptionError, match="closes a loop of shafts whose ratios do not agree"):
        referred(lp.assemble(loop), "a.phi")
    lone = Inertia(J=1.0)
    for model in (
        lp.compose(lone=lone),
        lp.compose(lone=lone, drive=two_mass, connections=lambda m: []),
    ):
        with pytest.raises(OptionError, match=r"vibrate together with lone\.phi"):
            referred(lp.assemble(model), "lone.phi")


def test_a_shaft_with_inertia_counts_with_its_ends():
    """Rigidly joined discs: their accelerations alone do not tell the ends from the discs."""
    shaft = ShaftElement(c=4e5, J_a=0.02, J_b=0.05, W=1e-4)
    system = assemble_row(a=Inertia(J=1.0), shaft=shaft, b=Inertia(J=2.5))
    found = referred(system, "a.phi")
    own = {part.name: part for part in found.parts}
    assert [own[name].J for name in ("shaft.flange_a", "shaft.flange_b")] == pytest.approx(
        [0.02, 0.05], rel=1e-9
    )
    assert own["shaft"].c == pytest.approx(4e5, rel=1e-12)
    assert [own[name].J for name in ("a", "b")] == pytest.approx([1.0, 2.5], rel=1e-9)
    w = np.sqrt(4e5 * (1 / 1.02 + 1 / 2.55))
    assert found.hertz == pytest.approx([w / (2 * np.pi)], rel=1e-12)
    assert found.left_out == ()


@pytest.mark.parametrize("masses", ["exact", "excitation", "series"])
def test_cylinders_count_with_the_mean_of_their_inertia(masses):
    series = ((1, 1.0), (2, SIZE["r"] / SIZE["L"])) if masses == "series" else ()
    cylinder = Cylinder(**SIZE, pressure=PRESSURE, masses=masses, series=series, phase=0.3)
    modes = lp.vibration.mean_modes(chain(cylinder), shaft="wheel.phi", speed=150.0, turns=2)
    found = lp.vibration.mass_elastic(modes, shaft="wheel.phi")
    if masses == "series":
        assert found.left_out == ("part",)
        return
    mean = SIZE["m"] * np.mean(lever(ANGLES) ** 2)
    assert {part.name: part.J for part in found.inertias}["part"] == pytest.approx(mean, rel=1e-9)
    assert found.hertz == pytest.approx([two_masses(0.05 + mean)[0] / (2 * np.pi)], rel=1e-9)


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.4, 0.7])
def test_blades_of_a_propeller_are_no_spring_to_the_ground(phase):
    """Their torque is the same after a turn, so that its mean slope over the angle is zero."""
    system = assemble_rows(
        "governor engine shaft hub water.flange",
        governor=Torque(tau=0.0),
        engine=Inertia(J=9e4),
        shaft=SpringDamper(c=3e6, d=2e4),
        hub=Inertia(J=5e4),
        water=Propeller(tau_nominal=1e6, w_nominal=11.0, blades=((4, 0.15, 0.0),), phase=phase),
    )
    where = {"shaft": "engine.phi", "speed": 8.0, "free": "governor.tau"}
    found = lp.vibration.mass_elastic(lp.vibration.mean_modes(system, **where), shaft="engine.phi")
    assert [part.name for part in found.shafts] == ["shaft"]
    assert found.left_out == ()
    free = np.sqrt(3e6 * (1 / 9e4 + 1 / 5e4)) / (2 * np.pi)
    assert found.hertz == pytest.approx([free], rel=1e-12)
