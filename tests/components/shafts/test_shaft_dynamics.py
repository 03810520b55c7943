"""Elements, runs and responses of shafts against bars and their wave equation."""

import numpy as np
import pytest
import scipy
from rows import in_a_row
from shaft_rigs import RHO, G, free, held
from test_shafts import D_BAR, F_MAX, L_BAR, SPEED

import lumped as lp
from lumped.components import Fixed, Shaft, Solid, Torque
from lumped.components.shafts.fineness import elements_needed
from lumped.components.shafts.materials import MATERIALS
from lumped.errors import OptionError
from lumped.numerics.uniform_bar import dynamic_stiffness


def bar_frequencies(fixed):
    """Natural frequencies of the continuous bar up to the limit, Hz."""
    number = np.arange(1, 40)
    shares = (2 * number - 1) / 4 if fixed else number / 2
    found = shares * SPEED / L_BAR
    return found[found <= F_MAX]


@pytest.mark.parametrize("accuracy", [0.02, 0.002])
@pytest.mark.parametrize("fixed", [False, True])
def test_as_many_elements_as_a_frequency_limit_needs(fixed, accuracy):
    bar = Solid(d=D_BAR, L=L_BAR)
    limit = {"f_max": F_MAX, "accuracy": accuracy}
    model = held(bar, **limit) if fixed else free(bar, **limit)
    found = lp.modes(lp.assemble(model)).hertz
    found = found[found > 1.0]
    continuous = bar_frequencies(fixed)
    errors = 1 - found[: len(continuous)] / continuous
    n = len(found)
    x = np.pi * continuous * L_BAR / SPEED / n
    assert errors == pytest.approx(1 - np.sin(x) / x, rel=1e-6, abs=1e-9)
    assert 0 < errors.max() <= accuracy / 2


@pytest.mark.parametrize("share", [0.1, 1.0, 10.0, 100.0])
def test_the_limit_holds_with_a_body_at_the_end(share):
    """The wave equation: ``cot(q L) = share q L``; for heavy bodies the limit is just met."""
    limits = (1e-5, 1e-3)
    found = [
        scipy.optimize.brentq(
            lambda x: np.cos(x) - share * x * np.sin(x), i * np.pi, (i + 0.5) * np.pi, xtol=1e-14
        )
        for i in range(len(limits))
    ]
    errors = []
    hertz = np.array(found) * SPEED / (2 * np.pi * L_BAR)
    for exact, accuracy in zip(hertz, limits, strict=True):
        shaft = Shaft(sections=[Solid(d=D_BAR, L=L_BAR)], f_max=1.0001 * exact, accuracy=accuracy)
        model = in_a_row(
            wall=Fixed(),
            shaft=shaft,
            body=lp.components.Inertia(J=share * np.pi / 32 * RHO * L_BAR * D_BAR**4),
        )
        received = lp.modes(lp.assemble(model)).hertz
        errors.append((1 - received[np.abs(received - exact).argmin()] / exact) / accuracy)
    assert 0 < min(errors) < max(errors) < 1
    if share >= 10:
        assert errors[0] > 0.7


def test_the_number_of_elements_is_found_from_lengths_and_materials_as_written():
    class Drive(lp.Component):
        """One section twice as long as the other."""

        half: lp.Param = lp.param("m", "half the length", above=0)
        shaft: Shaft = Shaft(
            sections=[Solid(d=0.1, L=2 * half), Solid(d=0.1, L=half, material="aluminium")],
            f_max=4000.0,
            G=70e9,
        )

    system = lp.assemble(Drive(half=0.5))
    received = [
        sum(f"sections[{i}]" in name and name.endswith("phi_rel") for name in system.state_names)
        for i in range(2)
    ]
    other = MATERIALS["aluminium"]
    expected = [
        elements_needed(1.0 * np.sqrt(RHO / 70e9), 4000.0, 0.01),
        elements_needed(0.5 * np.sqrt(other.rho / other.G), 4000.0, 0.01),
    ]
    assert received == expected
    assert min(expected) > 1


def test_the_response_of_a_stress_is_that_of_the_torque_over_the_modulus():
    J, hertz = 0.2, np.array([10.0, 60.0])
    model = in_a_row(
        wall=Fixed(),
        shaft=Shaft(sections=[Solid(d=0.05, L=1.0)]),
        disc=lp.components.Inertia(J=J),
        load=Torque(tau=0.0),
    )
    response = lp.frequency_response(
        lp.assemble(model), inputs=["load.tau"], outputs=["shaft.sections[0].stress"], hertz=hertz
    )
    received = np.abs(response["shaft.sections[0].stress", "load.tau"])
    c, half = np.pi / 32 * G * 0.05**4, np.pi / 64 * RHO * 0.05**4
    w = 2 * np.pi * hertz
    expected = np.abs(c / (c - w**2 * (J + half))) * 16 / (np.pi * 0.05**3)
    assert received == pytest.approx(expected, rel=1e-9)


def test_the_dynamic_stiffness_solves_the_wave_equation():
    """Against the ordinary differential equation of a turning, twisting bar."""
    c, transit = 7e5, 2e-4
    for w in (0.0, 3000.0, 2.1e4, 8e4):

        def along(x, y, w=w):
            return [y[1] / c, -c * (w * transit) ** 2 * y[0]]

        solved = [
            scipy.integrate.solve_ivp(along, (0, 1), start, rtol=1e-12, atol=1e-14).y[:, -1]
            for start in ([1.0, 0.0], [0.0, 1.0])
        ]
        (p, r), (q, s) = solved  # angle and torque at b for an angle, and a torque, at a
        expected = np.array([[p / q, -1 / q], [r - s * p / q, s / q]])
        received = dynamic_stiffness(c, transit, np.array([w]))[0]
        assert received == pytest.approx(expected, rel=1e-8)


def test_the_dynamic_stiffness_has_the_poles_and_zeros_of_the_bar():
    c, transit = 7e5, 2e-4
    clamped_free = np.array([0.5, 1.5]) * np.pi / transit
    received = dynamic_stiffness(c, transit, clamped_free)[:, 1, 1] / c
    assert np.abs(received).max() < 1e-12
    lossy = dynamic_stiffness(c * 1.02j, transit / np.sqrt(1.02j), clamped_free)
    assert np.isfinite(lossy).all()


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ((-1.0, 100.0, 0.01), "transit = -1 s must not be negative"),
        ((1.0, -100.0, 0.01), "f_max = -100 Hz must not be negative"),
        ((1.0, 100.0, 1.5), "accuracy = 1.5"),
    ],
)
def test_a_limit_that_makes_no_sense_is_refused(given, text):
    with pytest.raises(OptionError, match=text):
        elements_needed(*given)
