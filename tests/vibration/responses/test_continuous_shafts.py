"""Shafts with distributed inertia: responses and natural frequencies against the wave equation."""

import numpy as np
import pytest
import scipy
from checks import refused
from differences import slope
from rows import assemble_row

import lumped as lp
from lumped.components import (
    Damper,
    ElasticCoupling,
    Fixed,
    HarmonicTorque,
    Inertia,
    Shaft,
    Solid,
    SpringDamper,
    Taper,
    Torque,
)
from lumped.errors import DeclarationError, OptionError, ParameterError, SolverError
from lumped.numerics.uniform_bar import angles_along

G, RHO = 80e9, 7850.0
D, L = 0.09, 3.0
POLAR = np.pi / 32 * D**4
C, J, TRANSIT = G * POLAR / L, RHO * POLAR * L, L * np.sqrt(RHO / G)
LIMIT = 3000.0  # Hz
BAR = Solid(d=D, L=L)


def shaft(*sections, **given):
    return Shaft(sections=list(sections), continuous=True, **{"f_max": LIMIT, **given})


def natural(system, up_to=LIMIT, **given):
    return lp.vibration.natural_modes(system, up_to=up_to, **given)


def below(phases):
    """Frequencies up to the limit that belong to phases of a wave from end to end, Hz."""
    found = np.array(phases) / TRANSIT / (2 * np.pi)
    return found[found <= LIMIT]


def close(received, expected, limit):
    assert np.array(received) == pytest.approx(np.array(expected), rel=limit, abs=0)


def test_a_free_and_a_clamped_bar_have_all_their_natural_frequencies():
    number = np.arange(1, 30)
    loose = natural(lp.assemble(lp.compose(shaft=shaft(BAR))))
    close(loose.hertz, below(np.pi * number), 1e-12)
    assert loose.rigid == 1
    clamped = natural(assemble_row(wall=Fixed(), shaft=shaft(BAR)))
    close(clamped.hertz, below(np.pi * (number - 0.5)), 1e-12)
    both = natural(assemble_row(wall=Fixed(), shaft=shaft(BAR), end=Fixed()))
    close(both.hertz, below(np.pi * number), 1e-12)


@pytest.mark.parametrize("share", [0.1, 1.0, 10.0])
def test_a_disc_at_the_end_moves_the_frequencies_to_the_roots_of_its_equation(share):
    """``b tan(b) = J_bar / J_disc``."""
    phases = [
        scipy.optimize.brentq(
            lambda b: share * b * np.sin(b) - np.cos(b),
            i * np.pi,
            (i + 0.5) * np.pi,
            xtol=1e-15,
            rtol=1e-15,
        )
        for i in range(20)
    ]
    system = assemble_row(wall=Fixed(), shaft=shaft(BAR), disc=Inertia(J=share * J))
    close(natural(system).hertz, below(phases), 1e-12)


def transfer(c, transit, w):
    """Angle and torque at the end of a bar from those at its begin."""
    x = w * transit
    return np.array([[np.cos(x), np.sin(x) / (c * x)], [-c * x * np.sin(x), np.cos(x)]])


STEPPED = ((0.09, 0.8), (0.14, 0.35), (0.06, 1.1))  # diameter and length, m
DISCS = (0.6, 0.05, 1.5)


def stepped(**given):
    """A disc on the free end, three sections with a disc behind each of the first two, a wall."""
    parts = {}
    for i, ((d, length), disc) in enumerate(zip(STEPPED, DISCS, strict=True)):
        parts[f"disc{i}"] = Inertia(J=disc)
        parts[f"shaft{i}"] = shaft(Solid(d=d, L=length), **given)
    return parts


def at_wall(w, eta=0.0):
    """Angle and torque at the wall for a unit angle, and for a unit torque, at the free end."""
    found = np.eye(2, dtype=complex)
    for (d, length), disc in zip(STEPPED, DISCS, strict=True):
        found = np.array([[1, 0], [-(w**2) * disc, 1]]) @ found
        shear = G * (1 + 1j * eta)
        polar = np.pi / 32 * d**4
        found = transfer(shear * polar / length, length * np.sqrt(RHO / shear), w) @ found
    return found


def test_a_stepped_shaft_with_discs_has_the_frequencies_of_transfer_matrices():
    def angle(w):
        return at_wall(w)[0, 0].real

    grid = np.linspace(1.0, 2 * np.pi * LIMIT, 4001)
    values = np.array([angle(w) for w in grid])
    expected = [
        scipy.optimize.brentq(angle, grid[k], grid[k + 1], rtol=1e-15) / (2 * np.pi)
        for k in np.flatnonzero(np.diff(np.sign(values)) != 0)
    ]
    found = natural(assemble_row(**stepped(), wall=Fixed()))
    close(found.hertz, expected, 1e-11)
    assert "none missed" in repr(found)


@pytest.mark.parametrize("eta", [0.0, 0.03])
def test_a_frequency_response_solves_the_wave_equation_however_it_is_cut(eta):
    loss = {"eta": eta, "w_loss": 300.0} if eta else {}
    hertz = np.array([3.0, 95.0, 260.0, 700.0, 1300.0])
    expected = []
    for w in 2 * np.pi * hertz:
        (a, b), _ = at_wall(w, eta)
        expected.append(-b / a)  # no angle at the wall; the load is the torque at the free end
    for f_max in (1400.0, 9000.0):
        parts = stepped(f_max=f_max, **loss)
        system = assemble_row(load=Torque(tau=0.0), **parts, wall=Fixed())
        response = lp.frequency_response(
            system, inputs=["load.tau"], outputs=["disc0.phi"], hertz=hertz
        )
        received = response["disc0.phi", "load.tau"]
        close(received, -np.array(expected), 1e-11)


def test_a_lumped_section_converges_to_the_continuous_one_with_the_square_of_its_pieces():
    def frequency(**given):
        parts = {"wall": Fixed(), "shaft": Shaft(sections=[Solid(d=D, L=L, **given)])}
        return lp.modes(assemble_row(**parts, disc=Inertia(J=J))).hertz[:2]

    exact = natural(assemble_row(wall=Fixed(), shaft=shaft(BAR), disc=Inertia(J=J)), 1000.0).hertz[
        :2
    ]
    errors = np.array([1 - frequency(n_elements=n) / exact for n in (8, 16, 32)])
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4.0, rtol=0.03)


def test_a_cone_converges_with_the_square_of_its_pieces():
    a, b, length = 0.06, 0.12, 1.5

    def torque(w):
        """At the free thick end, for a unit torque at the clamped thin one."""

        def along(s, y):
            polar = np.pi / 32 * (a + (b - a) * s / length) ** 4
            return [y[1] / (G * polar), -(w**2) * RHO * polar * y[0]]

        return scipy.integrate.solve_ivp(
            along, (0, length), [0.0, 1.0], method="DOP853", rtol=1e-11, atol=1e-14
        ).y[1, -1]

    exact = scipy.optimize.brentq(torque, 1000.0, 3000.0) / (2 * np.pi)
    errors = []
    for n in (4, 8):
        cone = Taper(d_a=a, d_b=b, L=length, n_elements=n)
        found = natural(assemble_row(wall=Fixed(), shaft=shaft(cone)), 1.5 * exact).hertz
        errors.append(found[np.abs(found - exact).argmin()] / exact - 1)
    assert abs(errors[0]) < 0.02
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def harmonic_drive(eta=0.02):
    """A disc whose torque varies over its own angle drives a load through a continuous shaft."""
    return assemble_row(
        source=HarmonicTorque(harmonics=((1, 40.0, 0.0), (3, 25.0, 0.7))),
        disc=Inertia(J=0.3),
        shaft=shaft(BAR, f_max=400.0, eta=eta, w_loss=300.0),
        load=Inertia(J=1.1),
    )


def loaded_angle(w, d=D, eta=0.02):
    """Angle of the load for a unit torque on the disc."""
    shear, polar = G * (1 + 1j * eta), np.pi / 32 * d**4
    whole = transfer(shear * polar / L, L * np.sqrt(RHO / shear), w)
    whole = np.array([[1, 0], [-(w**2) * 1.1, 1]]) @ whole @ np.array([[1, 0], [-(w**2) * 0.3, 1]])
    # torque at the far end: 0 = whole[1, 0] phi - whole[1, 1]
    return whole[0, 0] * whole[1, 1] / whole[1, 0] - whole[0, 1]


def test_torques_of_the_model_excite_a_continuous_shaft_as_the_wave_equation_says():
    speeds = np.array([150.0, 420.0, 700.0])
    response = lp.vibration.order_response(
        harmonic_drive(), shaft="disc.phi", speeds=speeds, of=["load.w"], orders=[1, 3]
    )
    for order, torque in ((1, 40.0), (3, 25.0)):
        w = order * speeds
        expected = [
            abs(value * torque * at) for value, at in zip(map(loaded_angle, w), w, strict=True)
        ]
        close(response.magnitude("load.w", order), expected, 1e-9)
    found = lp.vibration.order_sensitivity(
        response, "load.w", measure=3.0, speed=420.0, by=["shaft.sections[0].d"]
    )
    w = 3 * 420.0
    expected = slope(lambda d: abs(loaded_angle(w, d)) * 25.0 * w, D, 1e-6, 2)
    assert found.derivatives[0] == pytest.approx(expected, rel=1e-6)


def test_runs_and_operating_points_have_lumps():
    parts = {"wall": Fixed(), "disc": Inertia(J=0.2), "load": Torque(tau=300.0)}

    def drive(**given):
        section = Shaft(sections=[Solid(d=D, L=L, n_elements=3)], **given)
        return assemble_row(wall=parts["wall"], shaft=section, **dict(list(parts.items())[1:]))

    whole, lumps = drive(continuous=True), drive()
    np.testing.assert_allclose(lp.modes(whole).hertz, lp.modes(lumps).hertz, rtol=1e-13)
    runs = [lp.simulate(system, until=0.02, rtol=1e-9)["disc.w"] for system in (whole, lumps)]
    np.testing.assert_allclose(*runs, rtol=1e-6, atol=1e-7)
    point = lp.equilibrium(whole)
    twist = sum(point[f"shaft.sections[0].elements[{i}].phi_rel"] for i in range(3))
    assert twist == pytest.approx(300.0 / C, rel=1e-12)


def test_the_shape_along_a_bar_is_that_of_its_wave():
    places = np.linspace(0, 1, 9)
    found = natural(lp.assemble(lp.compose(shaft=shaft(Solid(d=D, L=L), f_max=1700.0))), 1700.0)
    ends = (found.shape(f"shaft.flange_{end}.phi") for end in "ab")
    for k, (a, b) in enumerate(zip(*ends, strict=True), start=1):
        exact = np.cos(k * np.pi * places)
        scale = exact[0] / a
        inner = [f"shaft.sections[0].elements[{i}].flange_b.phi" for i in range(3)]
        at = scale * np.array([found.shape(name)[k - 1] for name in inner])
        np.testing.assert_allclose(at, np.cos(k * np.pi * np.arange(1, 4) / 4), atol=1e-12)
        for i, (left, right) in enumerate(zip([a * scale, *at], [*at, b * scale], strict=False)):
            s = np.linspace(0, 1, 5)
            along = angles_along(k * np.pi / 4, left, right, s)
            np.testing.assert_allclose(along, np.cos(k * np.pi * (i + s) / 4), atol=1e-12)
    np.testing.assert_allclose(angles_along(0.0, 1.0, 3.0, places), 1 + 2 * places, rtol=1e-15)


def test_the_stress_at_the_ends_and_in_the_middle_is_that_of_the_wave():
    hertz = 200.0
    system = assemble_row(wall=Fixed(), shaft=shaft(BAR, f_max=250.0), load=Torque(tau=0.0))
    names = [f"shaft.sections[0].elements[0].stress{end}" for end in ("_a", "", "_b")]
    response = lp.frequency_response(system, inputs=["load.tau"], outputs=names, hertz=[hertz])
    x = 2 * np.pi * hertz * TRANSIT
    # clamped at a: the angle is a sine, the torque a cosine of the way from a
    torques = np.cos(x * np.array([0, 0.5, 1])) / np.cos(x)
    received = [response[name, "load.tau"][0].real for name in names]
    np.testing.assert_allclose(received, torques * 16 / (np.pi * D**3), rtol=1e-12)


@pytest.mark.parametrize("eta", [4e-3, 2e-3])
def test_a_loss_factor_damps_all_modes_by_half_of_it(eta):
    system = assemble_row(wall=Fixed(), shaft=shaft(BAR, eta=eta, w_loss=100.0), disc=Inertia(J=J))
    found = natural(system)
    assert found.damping == pytest.approx(eta / 2, rel=30 * eta**2)


def test_a_damper_at_the_end_damps_as_its_share_of_the_energy_says():
    """Clamped bar, ``phi = sin(w T s)``: ``d phi^2`` over twice ``w J / 2`` at the free end."""
    d = 1.0
    system = assemble_row(wall=Fixed(), shaft=shaft(BAR), damper=Damper(d=d), ground=Fixed())
    found = natural(system)
    w = 2 * np.pi * found.hertz
    close(found.hertz, below(np.pi * (np.arange(1, 30) - 0.5)), 1e-12)
    close(found.damping, d / (w * J), 1e-8)


def test_a_stiffness_that_rises_with_the_frequency_is_met_at_the_natural_one():
    c, factors = 2e4, ((0.0, 1.0, 1.0), (100.0, 1.3, 1.0), (1000.0, 1.9, 1.0))
    coupling = ElasticCoupling(
        twist=((0.0, 0.0), (1.0, c)), over_frequency=factors, psi=0.5, w_loss=50.0
    )
    found = natural(assemble_row(a=Inertia(J=0.4), coupling=coupling, b=Inertia(J=1.2)), 150.0)
    rows = np.array(factors)

    def missing(w):
        return c * np.interp(w, rows[:, 0], rows[:, 1]) * (1 / 0.4 + 1 / 1.2) - w**2

    close(found.hertz, [scipy.optimize.brentq(missing, 10.0, 900.0) / (2 * np.pi)], 1e-12)


def test_slips_are_named():
    one = assemble_row(
        wall=Fixed(), shaft=Shaft(sections=[BAR], continuous=True), load=Torque(tau=0.0)
    )
    with pytest.raises(SolverError, match=r"elements\[0\].*at 600 Hz.*Cut the section into more"):
        natural(one, 600.0)
    with pytest.raises(SolverError, match=r"at 600 Hz lies outside 0 to 3 rad"):
        lp.frequency_response(
            one, inputs=["load.tau"], outputs=["shaft.flange_b.phi"], hertz=[1.0, 600.0]
        )
    plain = assemble_row(a=Inertia(J=1.0), spring=SpringDamper(c=1.0), b=Inertia(J=1.0))
    refused(OptionError, lambda: natural(plain), "no law of the drive depends on the frequency")
    refused(OptionError, lambda: natural(one, 0.0), "up_to = 0 Hz must be above zero")
    point = lp.start_point(one)
    with pytest.raises(OptionError, match="when making the operating point"):
        natural(one, 10.0, at=point, parameters={"shaft.G": 7e10})
    with pytest.raises(DeclarationError, match="eta is given, but lumped elements have no loss"):
        assemble_row(shaft=Shaft(sections=[BAR], eta=0.1, w_loss=1.0))
    refused(ParameterError, lambda: lp.assemble(lp.compose(shaft=shaft(BAR, eta=0.1))), "w_loss")
    refused(ParameterError, lambda: assemble_row(shaft=shaft(Solid(d=D, L=L, eta=0.1))), "w_loss")
