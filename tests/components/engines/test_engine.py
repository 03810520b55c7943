import itertools

import numpy as np
import pytest
import scipy
from checks import refused
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped.components import (
    Cylinder,
    Engine,
    Fixed,
    Inertia,
    Position,
    SpringDamper,
)
from lumped.errors import LumpedError

BORE, R, L, M, W = 0.1, 0.05, 0.18, 2.5, 60.0
SIZE = {"bore": BORE, "r": R, "L": L, "m": M}
AREA = np.pi * BORE**2 / 4
ANGLES = np.radians([0, 180, 300, 355, 370, 400, 480, 560, 720])
PRESSURES = np.array([0.0, 0.5, 6.0, 60.0, 85.0, 40.0, 8.0, 0.5, 0.0]) * 1e5
TABLE = tuple(zip(ANGLES.tolist(), PRESSURES.tolist(), strict=True))


def way(a):
    """Way of the piston from top dead centre."""
    return R * (1 - np.cos(a)) + L * (1 - np.sqrt(1 - (R / L * np.sin(a)) ** 2))


def lever(a):
    """Its derivative, by a complex step."""
    return way(np.asarray(a) + 1e-30j).imag / 1e-30


def slope(a):
    h = 1e-4
    return (8 * (lever(a + h) - lever(a - h)) - (lever(a + 2 * h) - lever(a - 2 * h))) / (12 * h)


def turned(until=4 * np.pi, law=None, **fields):
    """A run of a cylinder at a given angle over the time, W t by default."""
    model = in_a_row(
        cylinder=Cylinder(**SIZE, **fields),
        drive=Position(phi=law if law is not None else W * lp.time),
    )
    return lp.simulate(lp.assemble(model), until=until / W, grid=2880)


def test_gas_acts_with_the_way_of_the_piston():
    run = turned(pressure=TABLE)
    a = run["cylinder.a"]
    pressure = np.interp(a % (4 * np.pi), ANGLES, PRESSURES)
    error = np.abs(run["cylinder.p"] - pressure).max() / PRESSURES.max()
    torque = np.abs(run["cylinder.tau_gas"] - pressure * AREA * lever(a)).max()
    print(f"{error:.1e}, {torque:.1e} N.m")
    assert error < 1e-12
    assert torque < 1e-9


@pytest.mark.parametrize("strokes", [2, 4])
def test_work_of_the_gas_over_a_cycle_is_the_integral_of_p_dv(strokes):
    angles, values = ANGLES * strokes / 4, PRESSURES
    run = turned(
        until=strokes * np.pi, pressure=tuple(zip(angles, values, strict=True)), strokes=strokes
    )
    received = scipy.integrate.simpson(run["cylinder.tau_gas"] * W, x=run.t)
    expected = 0.0
    for left, right in itertools.pairwise(angles):
        x, weights = np.polynomial.legendre.leggauss(40)
        a = 0.5 * (left + right) + 0.5 * (right - left) * x
        p = np.interp(a, angles, values)
        expected += 0.5 * (right - left) * weights @ (p * AREA * lever(a))
    print(f"{received:.6g} of {expected:.6g} J")
    assert received == pytest.approx(expected, rel=2e-5)  # Simpson over kinks of the table


def test_masses_as_an_excitation_have_no_mean_and_the_mean_inertia():
    angle = W * lp.time + 3.0 * lp.time**2
    exact, constant = (turned(law=angle, masses=masses) for masses in ("exact", "excitation"))
    a, w = exact["cylinder.a"], exact["cylinder.w"]
    mean = lever(2 * np.pi * np.arange(4096) / 4096) ** 2
    expected = -M * (lever(a) ** 2 * 6.0 + lever(a) * slope(a) * w**2)
    np.testing.assert_allclose(
        exact["cylinder.tau_mass"], expected, atol=1e-7 * abs(expected).max()
    )
    expected = -M * (mean.mean() * 6.0 + lever(a) * slope(a) * w**2)
    received = constant["cylinder.tau_mass"]
    np.testing.assert_allclose(received, expected, atol=1e-7 * abs(expected).max())
    steady = turned(until=2 * np.pi, masses="excitation")["cylinder.tau_mass"][:-1]
    assert abs(steady.mean()) < 1e-12 * np.abs(steady).max()


def test_a_series_gives_the_torque_of_its_acceleration():
    run = turned(masses="series", series=((1, 1.0), (2, R / L)))
    a = run["cylinder.a"]
    expected = -M * R * W**2 * (np.cos(a) + R / L * np.cos(2 * a)) * lever(a)
    np.testing.assert_allclose(run["cylinder.tau_mass"], expected, atol=1e-9)


def test_a_cylinder_that_does_not_fire_compresses_and_expands():
    run = turned(pressure=TABLE, misfire="compression", compression=15.0, n=1.3)
    a, p = run["cylinder.a"], run["cylinder.p"]
    volume = way(a) + 2 * R / 14.0
    inside = (a > np.pi) & (a < 3 * np.pi)
    constant = (p * volume**1.3)[inside]
    np.testing.assert_allclose(constant, 0.5e5 * (2 * R * 15 / 14) ** 1.3, rtol=1e-10)
    outside = (a < 0.99 * np.pi) | (a > 3.01 * np.pi)
    np.testing.assert_allclose(
        p[outside], np.interp(a[outside] % (4 * np.pi), ANGLES, PRESSURES), atol=1e-6
    )
    assert not turned(pressure=TABLE, misfire="no gas")["cylinder.tau_gas"].any()


@pytest.mark.parametrize(
    ("load", "shares"), [(0.5, (1, 0)), (0.8, (0.4, 0.6)), (1.0, (0, 1)), (1.3, (0, 1))]
)
def test_pressure_lies_between_those_of_the_loads(load, shares):
    other = tuple((a, 0.4 * p + 1e5 * np.sin(a / 2) ** 2) for a, p in TABLE)
    run = turned(pressure=(other, TABLE), loads=(0.5, 1.0), load=load)
    a = run["cylinder.a"] % (4 * np.pi)
    first = np.interp(a, ANGLES, [p for _, p in other])
    expected = shares[0] * first + shares[1] * np.interp(a, ANGLES, PRESSURES)
    np.testing.assert_allclose(run["cylinder.p"], expected, atol=1e-6)


def test_pressure_follows_the_speed():
    run = turned(pressure=TABLE, over_speed=((50.0, 0.6), (70.0, 1.0)), load=0.5)
    a = run["cylinder.a"] % (4 * np.pi)
    np.testing.assert_allclose(
        run["cylinder.p"], 0.5 * 0.8 * np.interp(a, ANGLES, PRESSURES), atol=1e-6
    )


def test_tangential_harmonics_act_at_the_crank_pin():
    rows = ((0, 3e5, 0), (0.5, -1e5, 2e5), (3, 5e4, 0))
    run = turned(tangential=rows, load=0.7)
    a = run["cylinder.a"]
    series = sum(c * np.cos(k * a) + s * np.sin(k * a) for k, c, s in rows)
    np.testing.assert_allclose(run["cylinder.tau_gas"], 0.7 * AREA * R * series, atol=1e-9)
    assert not turned(tangential=rows, misfire="no gas")["cylinder.tau_gas"].any()


@pytest.mark.parametrize(
    "fields",
    [
        {"pressure": TABLE},
        {"pressure": TABLE, "masses": "excitation"},
        {"pressure": TABLE, "masses": "series", "series": ((1, 1.0), (2, 0.28))},
        {"tangential": ((0, 1e5, 0.0), (2, 1e5, 2e5))},
    ],
)
def test_energy_of_a_run_closes(fields):
    model = in_a_row(cylinder=Cylinder(**SIZE, **fields), wheel=Inertia(J=0.5, w=W))
    run = lp.simulate(lp.assemble(model), until=0.4, rtol=1e-10, certify=True)
    energy = run.certificate.energy
    print(energy)
    assert np.ptp(run["wheel.w"]) > 0.5
    assert len(energy.components) == 2
    assert energy.error < 1e-8


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"pressure": ((0, 1e5), (2, 3e5), (1, 2e5))}, "the angles must increase"),
        ({"pressure": ((0, 1e5), (360, 3e5), (720, 1e5))}, "more than the cycle"),
        ({"pressure": ((0, 1e5), (6, 3e6), (4 * np.pi, 3e5))}, "does not close"),
        ({"pressure": ((0, 1e5), (1, np.nan))}, "finite numbers"),
        ({"pressure": ((0, 1e5, 2), (1, 2e5, 2))}, "rows of crank angle"),
        ({"pressure": TABLE, "strokes": 3}, "2 or 4"),
        ({"pressure": TABLE, "shape": "curves"}, "'lines' or 'smooth'"),
        ({"pressure": TABLE, "misfire": "often"}, "'no gas' or 'compression'"),
        ({"pressure": TABLE, "loads": (0.5, 1.0)}, "2 loads and 9 tables"),
        ({"masses": "some"}, "'exact', 'excitation' or 'series'"),
        ({"masses": "series"}, "rows of order and coefficient"),
        ({"pressure": TABLE, "tangential": ((1, 1.0, 0.0),)}, "give one of them"),
        ({"tangential": ((1, 1.0),)}, "amplitudes of cosine and sine"),
        ({"tangential": ((1, 1.0, 0.0),), "misfire": "compression"}, "needs the pressure"),
    ],
)
def test_slips_of_a_cylinder_are_named(fields, match):
    model = in_a_row(pot=Cylinder(**SIZE, **fields), wheel=Inertia(J=1.0))
    refused(LumpedError, lambda: lp.assemble(model), match, "pot")


DATA = {
    "cylinders": 4,
    "firing_order": (1, 3, 4, 2),
    "pressure": TABLE,
    "J": (0.03, 0.031, 0.032, 0.033),
    "c": 1.1e6,
    "d": 1.5,
    "d_shaft": (8.0, 9.0, 10.0),
    **SIZE,
}


def by_hand():
    """The same engine of single parts, whose third cylinder does not fire."""
    return {
        "mass": [Inertia(J=J) for J in DATA["J"]],
        "shaft": [SpringDamper(c=1.1e6, d=d) for d in DATA["d_shaft"]],
        "oil": [lp.components.Damper(d=1.5) for _ in range(4)],
        "gas": [
            Cylinder(**SIZE, pressure=TABLE, misfire=miss, phase=i * np.pi)
            for i, miss in ((0, "none"), (3, "none"), (1, "no gas"), (2, "none"))
        ],
        "ground": Fixed(),
    }


def test_an_engine_is_its_parts():
    after = {"shaft_2": SpringDamper(c=5e5, d=3.0), "wheel": Inertia(J=1.5, w=W)}

    def run(system):
        w = {name: W for name in system.state_names if name.endswith(".w")}
        return lp.simulate(system, until=0.1, grid=100, rtol=1e-10, start=w)

    engine = assemble_rows(
        *("engine.rear shaft_2.flange_a", "shaft_2 wheel"),
        engine=Engine(**DATA, misfire={3: "no gas"}),
        **after,
    )
    parts = lp.compose(
        **by_hand(),
        **after,
        connections=lambda m: [
            *lp.chain(*(p for both in zip(m.mass, m.shaft, strict=False) for p in both), m.mass[3]),
            *lp.chain(m.mass[3], m.shaft_2, m.wheel),
            *(c for i in range(4) for c in lp.chain(m.ground, m.oil[i], m.mass[i], m.gas[i])),
        ],
    )
    received, expected = run(engine), run(lp.assemble(parts))
    assert np.ptp(expected["shaft[2].tau"]) > 100
    for name in ("throw[0].w", "shaft[2].tau"):
        own = expected[name.replace("throw", "mass")]
        tolerance = 1e-8 * np.abs(own).max()
        np.testing.assert_allclose(received[f"engine.{name}"], own, atol=tolerance)


def test_parameters_of_an_engine_are_those_of_its_parts():
    joint = "engine.rear wheel.flange_a"
    system = assemble_rows(joint, engine=Engine(**DATA), wheel=Inertia(J=1.0))
    assert system.parameters["engine.throw[2].J"] == 0.032
    assert system.parameters["engine.shaft[1].d"] == 9.0
    assert "engine.bore" in system.parameters
    assert "engine.cylinder[0].bore" not in system.parameters  # follows engine.bore


@pytest.mark.parametrize(
    ("fields", "degrees"),
    [
        ({"cylinders": 6, "firing_order": (1, 5, 3, 6, 2, 4)}, (0, 480, 240, 600, 120, 360)),
        ({"cylinders": 3, "firing_order": (1, 3, 2), "strokes": 2}, (0, 240, 120)),
        # a V8 at 90 deg with its throws at 0, 270, 90 and 180 deg fires at equal angles
        (
            {"cylinders": 8, "firing_order": (1, 5, 4, 8, 6, 3, 7, 2), "bank_angle": np.pi / 2},
            (0, 630, 450, 180, 90, 360, 540, 270),
        ),
        # a V6 at 90 deg on three common pins fires after 90 and 150 deg in turn
        (
            {"cylinders": 6, "firing_order": (1, 4, 2, 5, 3, 6), "bank_angle": np.pi / 2},
            (0, 240, 480, 90, 330, 570),
        ),
        ({"cylinders": 2, "firing_order": (1, 2), "bank_angle": np.pi / 4}, (0, 405)),
    ],
)
def test_phases_follow_from_the_firing_order(fields, degrees):
    received = np.degrees(Engine(**fields).phases)
    np.testing.assert_allclose(received, degrees, atol=1e-9)


def test_two_cylinders_of_a_vee_engine_stand_on_a_throw():
    fields = {"cylinders": 8, "firing_order": (1, 5, 4, 8, 6, 3, 7, 2), "bank_angle": np.pi / 2}
    engine = Engine(**fields, **SIZE, J=0.1, c=2e6)
    system = lp.assemble(engine)
    assert (len(engine.throw), len(engine.cylinder)) == (4, 8)
    angle = system.expressions(["cylinder[5].flange.phi", "throw[1].phi"])
    assert str(angle[0]) == str(angle[1])


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"firing_order": (1, 3, 4, 4)}, "twice: 4; missing: 2"),
        ({"firing_order": (1, 3, 4)}, "missing: 2"),
        ({"firing_order": (1, 3, 4, 5)}, "missing: 2; unknown: 5"),
        ({"cylinders": 0}, "at least 1"),
        ({"cylinders": 3, "firing_order": (1, 2, 3), "bank_angle": 1.0}, "an even number"),
        (
            {
                "cylinders": 6,
                "firing_order": (1, 5, 3, 6, 2, 4),
                "bank_angle": 0.3,
                "J": 1.0,
                "d_shaft": 0.0,
            },
            "does not fit bank_angle",
        ),
        ({"J": (1.0, 2.0)}, "4 of them are needed, 2 were given"),
        ({"misfire": {7: "no gas"}}, "cylinders count from 1 to 4"),
        ({"throw": [Inertia(J=1.0)]}, "1 parts in throw, but 4 cylinders need 4"),
    ],
)
def test_slips_of_an_engine_are_named(changes, match):
    with pytest.raises(LumpedError, match=match):
        lp.assemble(Engine(**{**DATA, **changes}))
