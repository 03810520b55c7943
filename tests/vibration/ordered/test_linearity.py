"""Vibrations that leave the range in which their linearisation holds, against closed forms."""

import numpy as np
import pytest
from matplotlib.text import Text
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import Clutch, Damper, Fixed, Inertia, NonlinearSpring, Spring, Torque

J, C, D, K3, P = 2.0, 8e3, 12.0, 4e6, 60.0


def swing(cubic=K3):
    """Disc on a progressive spring."""
    return assemble_rows(
        "torque disc spring ground",
        "disc air ground",
        torque=Torque(tau=0.0),
        disc=Inertia(J=J),
        spring=NonlinearSpring(characteristic=lambda x: C * x + cubic * x**3),
        air=Damper(d=D),
        ground=Fixed(),
    )


def test_what_a_cubic_spring_leaves_out_is_its_first_harmonic():
    """``cos^3 a = 3/4 cos a + ...``: torque ``3/4 k3 A^3`` more, over the dynamic stiffness."""
    speeds = np.linspace(20.0, 40.0, 8)
    response = lp.vibration.order_response(
        swing(), speeds=speeds, of=["disc.phi"], excitations={"torque.tau": {1: P}}
    )
    stiff = C - J * speeds**2 + 1j * D * speeds
    amplitude = P / np.abs(stiff)
    wanted = 0.75 * K3 * amplitude**2 / np.abs(stiff)
    found = response.linearity
    k = int(wanted.argmax())
    assert found.speed == speeds[k]
    assert found.share == pytest.approx(wanted[k], rel=1e-9)
    assert (found.of, found.order) == ("disc.phi", 1.0)
    assert f"wrong by about {wanted[k]:.0%}" in repr(response)
    assert found.states == ("spring.phi_rel",)
    told = f"order 1 of disc.phi is wrong by about {wanted[k]:.0%}"
    verdict = lp.vibration.verdict(response, [lp.vibration.Limit("disc.phi", 1.0)])
    assert told in repr(verdict)
    for made in (verdict, response):
        figure = made.plot(backend="matplotlib")
        assert told in " ".join(each.get_text() for each in figure.findobj(Text)).replace("\n", " ")


def test_what_is_left_out_between_speeds_is_told():
    middle = np.sqrt(C / J - D**2 / (2 * J**2))
    stiff = C - J * middle**2 + 1j * D * middle
    share = 0.75 * K3 * (5.0 / abs(stiff)) ** 2 / abs(stiff)
    told = f"order 1 of disc.phi is wrong by about {share:.0%}"
    response = lp.vibration.order_response(
        swing(), speeds=[30.0, 90.0], of=["disc.phi"], excitations={"torque.tau": {1: 5.0}}
    )
    peak, over = lp.functionals.order_peak("disc.phi"), {"disc.J": lp.normal(J, 0.01)}
    assert response.notes == ()
    verdict = lp.vibration.verdict(response, [lp.vibration.Limit("disc.phi", 1.0)])
    scatter = lp.scatter(response, over=over, of=[peak], runs=4)
    failure = lp.reliability(response, peak, above=1.001 * 5.0 / abs(stiff), over=over)
    for found in (verdict, scatter, failure):
        assert told in repr(found)


def test_what_is_small_or_linear_is_not_told():
    speeds = [10.0, 20.0]
    for system, torque in ((swing(0.0), 1e6), (swing(), 1.0)):
        response = lp.vibration.order_response(
            system, speeds=speeds, of=["disc.phi"], excitations={"torque.tau": {1: torque}}
        )
        assert "not linear" not in repr(response)


@pytest.mark.parametrize(("amplitude", "slips"), [(29.5, False), (30.5, True)])
def test_a_clutch_that_slips_along_the_vibration_is_named(amplitude, slips):
    """It sticks up to 20 N.m; far below the elastic mode two thirds of the torque pass it."""
    system = assemble_row(
        torque=Torque(tau=0.0),
        engine=Inertia(J=1.0),
        clutch=Clutch(f_max=40.0, u=1.0),
        drum=Inertia(J=1.0),
        shaft=Spring(c=1e5),
        load=Inertia(J=1.0),
    )
    response = lp.vibration.order_response(
        system, speeds=[5.0, 10.0], of=["clutch.tau"], excitations={"torque.tau": {1: amplitude}}
    )
    assert response.magnitude("clutch.tau", 1) == pytest.approx(2 / 3 * amplitude, rel=1e-3)
    found = response.linearity
    assert (found is not None and "clutch" in found.released) == slips
    assert ("clutch (from 47.746 1/min)" in repr(response)) == slips


def test_added_damping_counts_in_what_is_left_out():
    speeds, zeta = np.linspace(55.0, 70.0, 16), 0.1
    response = lp.vibration.order_response(
        swing(),
        speeds=speeds,
        of=["disc.phi"],
        excitations={"torque.tau": {1: P}},
        damping_ratio=zeta,
    )
    stiff = C - J * speeds**2 + 1j * (D + 2 * zeta * np.sqrt(C * J)) * speeds
    amplitude = P / np.abs(stiff)
    wanted = 0.75 * K3 * amplitude**2 / np.abs(stiff)
    assert np.abs(response["disc.phi"][:, 0]) == pytest.approx(amplitude)
    assert response.linearity.share == pytest.approx(wanted.max(), rel=1e-9)


@pytest.mark.parametrize(("d", "slips"), [(1.8, False), (2.2, True)])
def test_a_clutch_that_the_mean_torque_overloads_is_named(d, slips):
    system = assemble_row(
        torque=Torque(tau=0.0),
        engine=Inertia(J=1.0),
        clutch=Clutch(f_max=40.0, u=1.0),
        shaft=Spring(c=1e5),
        load=Inertia(J=1.0),
        water=Damper(d=d),
        ground=Fixed(),
    )
    response = lp.vibration.order_response(
        system,
        speeds=[5.0, 10.0],
        of=["clutch.tau"],
        shaft="engine.phi",
        free="torque.tau",
        excitations={"torque.tau": {1: 0.1}},
    )
    found = response.linearity
    assert (found is not None and "clutch" in found.released) == slips
