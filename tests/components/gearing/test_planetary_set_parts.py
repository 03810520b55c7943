"""Compound, Ravigneaux and Simpson sets against pitch-line velocities and published ratios."""

import numpy as np
import pytest

import lumped as lp
from lumped import errors
from lumped.components import (
    CompoundPlanetary,
    Fixed,
    Inertia,
    Planetary,
    Ravigneaux,
    Simpson,
    Speed,
    Torque,
)

# 30, 36 and 72 teeth: Ford AOD, in General Motors' bulletin on gear ratios
AOD = {"z_small": 30, "z_large": 36, "z_short": 17, "z_long": 18, "z_r": 72}
# teeth chosen for the ratios of General Motors' TH350, 2.52 and 1.52
TH350 = {"z_s": 26, "z_p1": 12, "z_r1": 50, "z_p2": 12, "z_r2": 50, "n": 4}
UNEQUAL = {"z_s": 30, "z_p1": 18, "z_r1": 66, "z_p2": 21, "z_r2": 72}
STEPPED = {"z_s": 20, "z_1": 28, "z_2": 16, "z_r": 64}


def meshing(speeds, wheels, meshes):
    """Speeds of all wheels, by pitch-line velocities that are equal where wheels mesh.

    `meshes` are pairs of wheels, their teeth, and the wheel that carries the planet; teeth of a
    ring are negative.
    """
    rows, right = [], []
    for a, z_a, b, z_b, carrier in meshes:
        row = np.zeros(len(wheels))
        row[wheels.index(a)] += z_a
        row[wheels.index(b)] += z_b
        row[wheels.index(carrier)] -= z_a + z_b
        rows.append(row)
        right.append(0.0)
    for wheel, speed in speeds.items():
        row = np.zeros(len(wheels))
        row[wheels.index(wheel)] = 1.0
        rows.append(row)
        right.append(speed)
    found = np.linalg.solve(np.array(rows), right)
    return dict(zip(wheels, found, strict=True))


def teeth_of(gears):
    if isinstance(gears, Ravigneaux):
        wheels = ["small_sun", "large_sun", "carrier", "ring", "short", "long"]
        pairs = [
            ("small_sun", gears.z_small, "short", gears.z_short),
            ("short", gears.z_short, "long", gears.z_long),
            ("large_sun", gears.z_large, "long", gears.z_long),
            ("ring", -gears.z_r, "long", gears.z_long),
        ]
        return wheels, [(*pair, "carrier") for pair in pairs]
    if isinstance(gears, Simpson):
        wheels = ["sun", "ring", "carrier", "output", "first", "second"]
        return wheels, [
            ("sun", gears.z_s, "first", gears.z_p1, "output"),
            ("ring", -gears.z_r1, "first", gears.z_p1, "output"),
            ("sun", gears.z_s, "second", gears.z_p2, "carrier"),
            ("output", -gears.z_r2, "second", gears.z_p2, "carrier"),
        ]
    return ["sun", "carrier", "ring", "planet"], [
        ("sun", gears.z_s, "planet", gears.z_1, "carrier"),
        ("ring", -gears.z_r, "planet", gears.z_2, "carrier"),
    ]


def geared(gears, speeds, load, tau=-7.0):
    """Point of a set two of whose shafts are turned, and one loaded."""
    model = lp.compose(
        set=gears,
        turns={name: Speed(w=speed) if speed else Fixed() for name, speed in speeds.items()},
        body=Inertia(J=1.0),
        load=Torque(tau=tau),
        connections=lambda m: [
            *(lp.connect(getattr(m.set, name), m.turns[name].flange) for name in speeds),
            *lp.chain(getattr(m.set, load), m.body, m.load),
        ],
    )
    return lp.start_point(lp.assemble(model))


def ratio(gears, drive, held, load):
    point = geared(gears, {drive: 1.0, held: 0.0}, load)
    torque = -point[f'turns["{drive}"].flange.tau']
    support = -point[f'turns["{held}"].flange.tau']
    found = 1.0 / point["body.w"]
    assert torque == pytest.approx(7.0 / found, rel=1e-12)  # power in is power out
    assert torque + support == pytest.approx(7.0, rel=1e-12)  # and torques have no sum
    return found


PUBLISHED = [
    (Ravigneaux, AOD, "small_sun", "carrier", "ring", 2.40),
    (Ravigneaux, AOD, "small_sun", "large_sun", "ring", 1.47),
    (Ravigneaux, AOD, "carrier", "large_sun", "ring", 0.67),
    (Ravigneaux, AOD, "large_sun", "carrier", "ring", -2.00),
    (Simpson, TH350, "ring", "carrier", "output", 2.52),
    (Simpson, TH350, "ring", "sun", "output", 1.52),
]


@pytest.mark.parametrize(("kind", "teeth", "drive", "held", "load", "expected"), PUBLISHED)
def test_gears_of_transmissions_have_the_published_ratios(kind, teeth, drive, held, load, expected):
    assert ratio(kind(**teeth), drive, held, load) == pytest.approx(expected, abs=0.0051)


SETS = [Ravigneaux(**AOD), Simpson(**TH350), Simpson(**UNEQUAL), CompoundPlanetary(**STEPPED)]


@pytest.mark.parametrize("gears", SETS, ids=lambda gears: type(gears).__name__)
def test_any_two_shafts_turn_the_others_as_pitch_line_velocities_say(gears):
    wheels, meshes = teeth_of(gears)
    shafts = wheels[:-2] if len(wheels) == 6 else wheels[:-1]
    for drive in shafts:
        for held in shafts:
            for load in shafts:
                if len({drive, held, load}) < 3:
                    continue
                expected = meshing({drive: 1.0, held: 0.0}, wheels, meshes)[load]
                received = 1.0 / ratio(gears, drive, held, load)
                assert received == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("gears", SETS[:3], ids=lambda gears: type(gears).__name__)
def test_locked_sets_turn_as_one(gears):
    wheels, _ = teeth_of(gears)
    point = geared(gears, {wheels[0]: 3.0, wheels[1]: 3.0}, wheels[3])
    assert point["body.w"] == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize("gears", SETS[:3], ids=lambda gears: type(gears).__name__)
def test_a_free_set_moves_by_its_two_equations(gears):
    """Bodies on all four shafts against Lagrange's equations on the pitch-line velocities."""
    wheels, meshes = teeth_of(gears)
    shafts = wheels[:4]
    J, tau = np.array([1.0, 2.0, 3.0, 4.0]), np.array([5.0, -3.0, 2.0, 1.0])
    model = lp.compose(
        set=gears,
        bodies=[Inertia(J=j) for j in J],
        loads=[Torque(tau=t) for t in tau],
        connections=lambda m: (
            lp.connect(getattr(m.set, shaft), body.flange_a, load.flange)
            for shaft, body, load in zip(shafts, m.bodies, m.loads, strict=True)
        ),
    )
    point = lp.start_point(lp.assemble(model))
    received = [point[f"bodies[{i}].a"] for i in range(4)]
    ways = [{shafts[0]: 1.0, shafts[2]: 0.0}, {shafts[0]: 0.0, shafts[2]: 1.0}]
    basis = np.array([[meshing(way, wheels, meshes)[shaft] for shaft in shafts] for way in ways]).T
    free = np.linalg.solve(basis.T @ np.diag(J) @ basis, basis.T @ tau)
    assert received == pytest.approx(basis @ free, rel=1e-12, abs=1e-12)


def test_a_planet_without_a_step_is_a_simple_planetary_set():
    teeth = {"z_s": 40, "z_1": 20, "z_2": 20, "z_r": 80}
    received = ratio(CompoundPlanetary(**teeth), "sun", "ring", "carrier")
    expected = ratio(Planetary(ratio=2.0), "sun", "ring", "carrier")
    assert received == pytest.approx(expected, rel=1e-14)


WRONG = [
    (CompoundPlanetary, STEPPED | {"z_r": 65}, r"z_r = 65 .* z_2 \+ module_ratio .* = 64 teeth"),
    (CompoundPlanetary, STEPPED | {"n": 5}, r"n = 5 .*gcd\(z_1, z_2\)\) = 105.6 is not whole"),
    (CompoundPlanetary, STEPPED | {"n": 6}, "planets at the sun collide: .* 24 modules .* 30 mod"),
    (Ravigneaux, AOD | {"z_long": 19}, r"z_r = 72 .* z_large \+ 2 z_long = 74 teeth"),
    (Ravigneaux, AOD | {"n": 4}, r"\(z_r - z_small\) / n = 10.5 is not whole.*1, 2, 3, 6"),
    (Ravigneaux, AOD | {"n": 6}, "short planets and the next long ones collide"),
    (Ravigneaux, AOD | {"z_small": 33, "z_short": 10}, "small sun and long planets collide"),
    (Ravigneaux, AOD | {"z_short": 3}, "z_short = 3 and z_long = 18 teeth do not mesh"),
    (Simpson, UNEQUAL | {"z_r2": 70}, r"z_r2 = 70 .* z_s \+ 2 z_p2 = 72 teeth"),
    (Simpson, TH350 | {"n": 3}, r"\(z_s \+ z_r1\) / n = 25.3333 is not whole"),
    (Simpson, UNEQUAL | {"n": 6, "z_p2": 30, "z_r2": 90}, "planets of set 2 collide"),
    (Simpson, {"z_s": 30.0}, "z_s = 30.0 teeth: a whole number, at least 3"),
]


@pytest.mark.parametrize(("kind", "teeth", "text"), WRONG)
def test_wheels_that_do_not_fit_are_refused(kind, teeth, text):
    first = "sun" if kind is not Ravigneaux else "small_sun"
    with pytest.raises(errors.LumpedError, match=rf"^set \({kind.__name__}\): .*{text}"):
        geared(kind(**teeth), {first: 1.0, "carrier": 0.0}, "ring")


def test_shifted_gears_need_not_have_the_teeth_of_unshifted_ones():
    gears = CompoundPlanetary(**STEPPED | {"z_r": 65, "z_2": 16, "n": 1}, profile_shift=True)
    assert ratio(gears, "sun", "ring", "carrier") == pytest.approx(1 + 28 * 65 / (20 * 16))
