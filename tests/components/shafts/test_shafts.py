"""Shafts by geometry and material: stiffness, inertia, stress, and how finely they are cut."""

import numpy as np
import pytest
import scipy
from checks import refused
from rows import in_a_row
from shaft_rigs import RHO, G, free, held, metres, rows, section

import lumped as lp
from lumped.components import (
    Disc,
    Fillet,
    Fixed,
    Hollow,
    Keyed,
    Keyway,
    RadialHole,
    Shaft,
    Solid,
    Splined,
    SplineEnd,
    Taper,
    Torque,
)
from lumped.components.shafts.materials import MATERIALS
from lumped.errors import DeclarationError, ParameterError, UnknownNameError

CLOSED = 1e-8  # digits of the tables


def values(model, *names):
    point = lp.start_point(lp.assemble(model))
    return [float(point[name]) for name in names]


@pytest.mark.parametrize("n", [1, 5])
@pytest.mark.parametrize("row", rows("sections"), ids=lambda row: row["row"])
def test_stiffness_and_inertia_follow_from_geometry(row, n):
    system = lp.assemble(held(section(row, n_elements=n)))
    point, found = lp.start_point(system), system.parameter_values()
    elements = [f"shaft.sections[0].elements[{i}]" for i in range(n)]
    soft = sum(1 / found[f"{element}.c"] for element in elements)
    heavy = sum(found[f"{element}.J_{end}"] for element in elements for end in "ab")
    c, J = float(row["stiffness_Nm_per_rad"]), float(row["inertia_kgm2"])
    errors = [point["shaft.c"] / c, 1 / soft / c, point["shaft.J"] / J, heavy / J]
    assert errors == pytest.approx([1.0] * 4, rel=CLOSED)


RULES = {
    "none": ("stiffness_no_penetration", CLOSED),
    "textbook": ("stiffness_textbook_table", CLOSED),
    "computed": ("stiffness_computed_table_linear_interpolation", 1e-4),
}


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("row", rows("stepped_shafts"), ids=lambda row: row["row"])
def test_steps_add_length_to_the_thinner_part(row, rule):
    parts = []
    for text in row["sections_mm"].split(" | "):
        L, d = text.split(" x d")
        parts.append(Solid(d=float(d) / 1e3, L=float(L) / 1e3))
    column, tolerance = RULES[rule]
    received = values(held(*parts, step=rule), "shaft.c", "shaft.J")
    expected = [float(row[column]), float(row["inertia_kgm2"])]
    assert received[0] == pytest.approx(expected[0], rel=tolerance)
    assert received[1] == pytest.approx(expected[1], rel=CLOSED)


def test_the_computed_step_is_that_of_the_table_and_lies_between_the_bounds():
    def share(ratio):
        model = held(Solid(d=0.1, L=1.0), Solid(d=0.1 * ratio, L=10.0 * ratio))
        return lp.assemble(model).parameter_values()["shaft.sections[0].x_b"] / 0.1

    worst = 0.0
    for row in rows("step_penetration_computed"):
        expected = float(row["lambda_over_D1_shift_of_the_step"])
        received = share(float(row["D2_over_D1"]))
        worst = max(worst, abs(received / expected - 1))
    assert worst < 2e-4
    assert 0.14726 < share(1e4) < 0.16977  # rigid disc, and linear stress, on a half space
    assert share(1.0) == 0


def test_a_step_shortens_the_thicker_part_by_what_it_adds_to_the_thinner_one():
    found = lp.assemble(held(Solid(d=0.1, L=1.0), Hollow(d=0.15, bore=0.02, L=1.0)))
    x = found.parameter_values()
    assert x["shaft.sections[1].x_a"] == -x["shaft.sections[0].x_b"] < 0
    assert x["shaft.sections[0].x_a"] == x["shaft.sections[1].x_b"] == 0


def test_a_cone_that_meets_cylinders_without_a_step_adds_no_length():
    model = held(Solid(d=0.1, L=0.2), Taper(d_a=0.1, d_b=0.15, L=0.2), Keyed(d=0.15, t=0.01, L=0.1))
    x = lp.assemble(model).parameter_values()
    received = [x[f"shaft.sections[{i}].x_{end}"] for i in range(3) for end in "ab"]
    expected = [0.0] * 6
    assert received == expected


@pytest.mark.parametrize("row", rows("fillet_torsion"), ids=lambda row: row["row"])
@pytest.mark.parametrize("fit", ["pilkey", "norton"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_fillet_takes_its_diameters_from_its_neighbours(row, fit, turned):
    parts = [
        Solid(d=metres(row, "D"), L=1.0),
        Fillet(r=metres(row, "r"), fit=fit),
        Solid(d=metres(row, "d"), L=1.0),
    ]
    T = float(row["T_Nm"])
    model = held(*(parts[::-1] if turned else parts), tau=T)
    point = lp.equilibrium(lp.assemble(model))
    at = "shaft.sections[1]"
    expected = float(row["tau_nominal_MPa"])
    factor = float(row["Kts_pilkey_fit" if fit == "pilkey" else "Kts_second_fit"])
    assert point[f"{at}.stress"] == pytest.approx(1e6 * expected, rel=CLOSED)
    assert point[f"{at}.notch_stress"] == pytest.approx(1e6 * expected * factor, rel=CLOSED)
    if fit == "pilkey":
        assert expected * factor == pytest.approx(float(row["tau_max_MPa"]), rel=CLOSED)


def test_a_keyway_has_the_factors_of_its_chart():
    """r/d = 0.0208: 1.953 + 0.1434 y - 0.0021 y^2 with y = 4.8077; sharper than 0.0069 it leads."""
    parts = [Solid(d=0.1, L=0.2), Keyway(), Keyed(d=0.1, t=0.0125, L=0.1)]
    known = lp.assemble(held(*parts)).parameter_values()
    assert known["shaft.sections[1].K_ts"] == 3.4
    sharp = lp.assemble(held(parts[0], Keyway(r=0.0005), parts[2])).parameter_values()
    assert sharp["shaft.sections[1].K_ts"] == pytest.approx(1.953 + 2.868 - 0.84, rel=1e-12)


@pytest.mark.parametrize(
    ("profile", "at_29"),
    [("straight", 1.4052), ("serrated", 1.4052), ("involute", 1.3039)],  # exp(0.3402), 900 MPa
)
def test_a_spline_has_the_notch_factor_of_its_standard(profile, at_29):
    """At a root of 29 mm; at others by K3 = 1 - 0.2 lg(beta) lg(d / 7.5) / lg(20)."""
    b = np.exp(0.42 * 0.9**2)
    beta = 1 + (0.75 if profile == "involute" else 1.0) * (b - 1)
    assert beta == pytest.approx(at_29, abs=1e-4)
    for d in (29.0, 45.0, 150.0, 300.0):
        parts = [
            Solid(d=d / 800, L=0.2),
            SplineEnd(R_m="900 MPa", profile=profile),
            Splined(d=d / 900, d_root=d / 1000, L=0.1),
        ]
        point = lp.equilibrium(lp.assemble(held(*parts, tau=100.0)))
        K3 = [
            1 - 0.2 * np.log10(beta) * np.log10(min(size, 150.0) / 7.5) / np.log10(20)
            for size in (29.0, d)
        ]
        expected = beta * K3[0] / K3[1] * 16 * 100.0 / (np.pi * (d / 1000) ** 3)
        received = point["shaft.sections[1].notch_stress"]
        assert received == pytest.approx(expected, rel=1e-11)


def test_a_small_hole_has_the_factor_of_kirsch():
    d, bore, T = 0.1, 0.04, 500.0
    model = held(
        Hollow(d=d, bore=bore, L=1.0),
        RadialHole(d_hole=0.005, bore=bore),
        Hollow(d=d, bore=bore, L=1.0),
        tau=T,
    )
    point = lp.equilibrium(lp.assemble(model))
    received = point["shaft.sections[1].notch_stress"]
    expected = 4 * 16 * T * d / (np.pi * (d**4 - bore**4))
    assert received == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("n", [1, 4])
def test_each_section_tells_its_nominal_stress(n):
    T = 3000.0
    parts = [
        (Solid(d=0.1, L=0.3, n_elements=n), 0.1, 0.0),
        (Hollow(d=0.1, bore=0.05, L=0.3, n_elements=n), 0.1, 0.05),
        (Taper(d_a=0.1, d_b=0.08, bore=0.02, L=0.3, n_elements=n), 0.08, 0.02),
        (Taper(d_a=0.08, d_b=0.12, L=0.3, n_elements=n), 0.08, 0.0),
        (Keyed(d=0.12, t=0.01, L=0.3, n_elements=n), 0.11, 0.0),
        (Splined(d=0.12, d_root=0.1, bore=0.03, L=0.3, n_elements=n, K_ts=1.7), 0.1, 0.03),
        (Disc(d=0.3, L=0.1, n_elements=n), 0.3, 0.0),
    ]
    point = lp.equilibrium(lp.assemble(held(*(part for part, *_ in parts), tau=-T)))
    for i, (_, d, bore) in enumerate(parts):
        expected = -16 * T * d / (np.pi * (d**4 - bore**4))
        assert point[f"shaft.sections[{i}].stress"] == pytest.approx(expected, rel=1e-12)
    spline = point["shaft.sections[5].notch_stress"] / point["shaft.sections[5].stress"]
    assert spline == pytest.approx(1.7, rel=1e-12)


def test_the_stress_of_a_section_is_the_largest_of_its_elements_with_its_sign():
    model = free(Solid(d=0.1, L=2.0, n_elements=6))
    elements = [f"shaft.sections[0].elements[{i}]" for i in range(6)]
    twists = np.random.default_rng(4).uniform(-1e-3, 1e-3, 6)
    start = {f"{e}.phi_rel": twist for e, twist in zip(elements, twists, strict=True)}
    point = lp.start_point(lp.assemble(model), start=start)
    stresses = np.array([G * twist * 0.05 / (2.0 / 6) for twist in twists])
    received = point["shaft.sections[0].stress"]
    expected = stresses[np.abs(stresses).argmax()]
    assert received == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("n", [1, 3])
def test_a_bored_cone_is_as_stiff_as_the_integral_says(n):
    a, b, bore, L = 0.1, 0.2, 0.08, 0.7
    soft, _ = scipy.integrate.quad(
        lambda x: 32 / np.pi / ((a + (b - a) * x) ** 4 - bore**4), 0, 1, epsabs=0, epsrel=1e-13
    )
    heavy, _ = scipy.integrate.quad(
        lambda x: np.pi / 32 * ((a + (b - a) * x) ** 4 - bore**4), 0, 1, epsabs=0, epsrel=1e-13
    )
    there, back = (
        values(held(Taper(d_a=p, d_b=q, bore=bore, L=L, n_elements=n)), "shaft.c", "shaft.J")
        for p, q in ((a, b), (b, a))
    )
    expected = [G / (soft * L), RHO * heavy * L]
    assert there == pytest.approx(expected, rel=1e-11)
    assert back == pytest.approx(expected, rel=1e-11)


def test_the_elements_of_a_cone_keep_its_inertia_and_its_centre():
    n, a, b, L = 4, 0.05, 0.2, 0.8
    found = lp.assemble(held(Taper(d_a=a, d_b=b, L=L, n_elements=n))).parameter_values()
    at = np.arange(n + 1) / n
    lumps = np.zeros(n + 1)
    for i in range(n):
        for j, end in enumerate("ab"):
            lumps[i + j] += found[f"shaft.sections[0].elements[{i}].J_{end}"]
    density = lambda x: RHO * L * np.pi / 32 * (a + (b - a) * x) ** 4  # noqa: E731
    expected = [scipy.integrate.quad(lambda x, k=k: x**k * density(x), 0, 1)[0] for k in (0, 1)]
    assert [lumps.sum(), lumps @ at] == pytest.approx(expected, rel=1e-12)


L_BAR, D_BAR, F_MAX = 3.0, 0.09, 2500.0
SPEED = np.sqrt(G / RHO)


def test_a_frequency_has_the_exact_derivative_by_a_diameter():
    """Disc J on a bar with half its inertia: ``w^2 = c / (J + J_bar / 2)``, c and J_bar as d^4."""
    d, L, J = 0.06, 0.8, 0.5

    def model(kind):
        return in_a_row(wall=Fixed(), shaft=Shaft(sections=[kind]), disc=lp.components.Inertia(J=J))

    modes = lp.modes(lp.assemble(model(Solid(d=d, L=L))))
    name = "shaft.sections[0].d"
    sensitivity = lp.vibration.eigen_sensitivity(modes, by=[name])
    c, J_bar = np.pi / 32 * G * d**4 / L, np.pi / 32 * RHO * L * d**4
    w = np.sqrt(c / (J + J_bar / 2))
    expected = w / d * 2 * (1 - (J_bar / 2) / (J + J_bar / 2)) / (2 * np.pi)
    received = float(np.ravel(sensitivity.hertz)[0])
    assert modes.hertz[0] == pytest.approx(w / (2 * np.pi), rel=1e-10)
    assert received == pytest.approx(expected, rel=1e-9)


def test_parts_without_a_material_of_their_own_have_that_of_the_shaft():
    parts = [Solid(d=0.1, L=1.0), Solid(d=0.1, L=1.0, material="titanium")]
    model = held(*parts, material="cast iron")
    received = lp.assemble(model).parameter_values()
    iron, titanium = MATERIALS["cast iron"], MATERIALS["titanium"]
    for i, expected in enumerate((iron, titanium)):
        assert received[f"shaft.sections[{i}].G"] == expected.G
        assert received[f"shaft.sections[{i}].rho"] == expected.rho
    system = lp.assemble(model)
    softer = system.parameter_values({"shaft.G": iron.G / 2})
    assert softer["shaft.sections[0].c"] == pytest.approx(received["shaft.sections[0].c"] / 2)
    assert softer["shaft.sections[1].c"] == received["shaft.sections[1].c"]


def test_a_section_stands_alone():
    model = in_a_row(
        wall=Fixed(),
        shaft=Solid(d=0.1, L=0.5, n_elements=3, material="aluminium"),
        load=Torque(tau=100.0),
    )
    point = lp.equilibrium(lp.assemble(model, keep=["shaft.flange_b.phi"]))
    received = point["shaft.flange_b.phi"]
    expected = 100.0 * 32 * 0.5 / (np.pi * MATERIALS["aluminium"].G * 0.1**4)
    assert received == pytest.approx(expected, rel=1e-12)


def test_a_run_keeps_its_energy_and_shows_the_peak_of_the_stress():
    """A torque step on a bar at rest doubles the static torque at the first turning point."""
    T = 1000.0
    system = lp.assemble(held(Solid(d=0.1, L=1.0), tau=T))
    run = lp.simulate(system, until=0.01, rtol=1e-10, certify=True)
    stress, d = "shaft.sections[0].stress", "shaft.sections[0].d"
    found = lp.gradient(system, of=[lp.functionals.peak(stress)], by=[d], until=0.01, rtol=1e-10)
    expected = 2 * 16 * T / (np.pi * 0.1**3)
    assert run[stress].max() == pytest.approx(expected, rel=1e-4)
    assert found.values[0] == pytest.approx(expected, rel=1e-7)
    assert found.derivatives[0, 0] == pytest.approx(-3 * expected / 0.1, rel=1e-6)
    assert run.certificate.energy.error < 1e-8


ONE = Solid(d=0.1, L=0.2)


@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        ({"f_max": "100 Hz"}, DeclarationError, "shaft (Shaft): f_max = '100 Hz'"),
        ({"f_max": 50.0, "accuracy": 0.0}, DeclarationError, "accuracy = 0.0"),
        ({"step": "sharp"}, UnknownNameError, "step = 'sharp' is no rule"),
        ({"sections": [Torque(tau=1.0)]}, DeclarationError, "(Torque) is no section"),
        ({"sections": [Keyway(d=0.1)]}, DeclarationError, "no sections"),
        ({"sections": [Solid(d=0.1, L=1.0, n_elements=2.5)]}, DeclarationError, "n_elements = 2.5"),
        (
            {"sections": [Splined(d=0.1, d_root=0.12, L=0.1)]},
            ParameterError,
            "d = 0.1 m (outside diameter) must be at least shaft.sections[0].d_root = 0.12 m",
        ),
        (
            {"sections": [ONE, RadialHole(d_hole=0.02), Solid(d=0.1, L=0.1)]},
            ParameterError,
            "d = 0.1 m (diameter of the shaft, ten times that of the hole or more)",
        ),
        (
            {"sections": [ONE, Keyway(r=1e-4), Keyed(d=0.1, t=0.01, L=0.1)]},
            ParameterError,
            "r = 0.0001 m (radius at the bottom of the keyway; the fit holds for r/d from 0.005)",
        ),
        (
            {"sections": [ONE, Fillet(r=0.03), Solid(d=0.11, L=0.1)]},
            ParameterError,
            "D = 0.11 m (larger diameter; the fit holds for t/r from 0.25) must be at least",
        ),
        (
            {"sections": [ONE, Fillet(r=0.01, fit="peterson"), Solid(d=0.2, L=0.1)]},
            UnknownNameError,
            "fit = 'peterson' is not known",
        ),
    ],
)
def test_what_makes_no_shaft_is_refused(given, error, text):
    sections = {"sections": [ONE, Solid(d=0.2, L=0.3)], **given}
    refused(error, lambda: lp.assemble(lp.compose(shaft=Shaft(**sections))), text)
