"""Optima of modes at equilibria that contacts and given speeds hold."""

import pytest
from rows import assemble_rows
from scipy.optimize import brentq
from test_held_positions import geared, hertz, pendulum

import lumped as lp
from lumped.components import Fixed, SpringDamper, SwingingMass
from lumped.vibration.natural.mode_designs import equilibrium_again


def braked_modes():
    """Of a pendulum behind the brake at 0.6 rad."""
    system = pendulum()
    return lp.modes(system, at=lp.equilibrium(system, start={"b.phi": 0.6}))


def settled_modes():
    """Of a pendulum on a spring from a wall, where it has come to rest."""
    system = assemble_rows(
        "wall spring",
        "spring p",
        wall=Fixed(phi0=0.6),
        spring=SpringDamper(c=50.0, d=8.0),
        p=SwingingMass(m=2.0, R=0.5, J=0.1),
    )
    return lp.modes(system, at=lp.simulate(system, until=20.0, rtol=1e-11).point(20.0))


@pytest.mark.parametrize("modes_of", [braked_modes, settled_modes])
def test_an_optimum_of_modes_keeps_the_brake_where_it_was_put_or_moves_with_its_equilibrium(
    modes_of,
):
    """The mass for which the pendulum has a frequency."""
    modes = modes_of()
    assert modes.hertz == pytest.approx([hertz(2.0)], rel=1e-8)
    found = lp.optimise(
        modes,
        vary={"p.m": (0.5, 5.0)},
        minimise={"p.m": 1.0},
        subject_to=lp.functionals.frequency(0) <= 1.2,
    )
    expected = brentq(lambda m: hertz(m) - 1.2, 0.5, 5)
    assert found.parameters["p.m"] == pytest.approx(expected, rel=1e-7)


def test_an_optimum_of_modes_frees_what_the_equilibrium_freed():
    """The decay ``2 k w / ratio^3 / (J_a + J_b / ratio^2)`` is that at the given speed."""
    drive = geared()
    point = lp.equilibrium(drive, start={"a.w": 15.0}, free=["motor.tau"])
    again = equilibrium_again(point, point.parameters | {"gear.ratio": 2.0})
    assert again["a.w"] == pytest.approx(15.0, rel=1e-9)
    assert again["motor.tau"] == pytest.approx(20 * (15 / 20) ** 2 / 2.0, rel=1e-9)
