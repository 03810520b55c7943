"""Orders of a slider-crank at constant speed against the series of Bessel's quadrature."""

import numpy as np
import pytest
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import CrankSlider, HarmonicTorque, IdealGear, Inertia, Speed, Spring
from lumped.errors import OptionError


def crank(speed=-7.0):
    model = in_a_row(drive=Speed(w=speed), crank=CrankSlider(r=0.1, L=0.4, m=2.0))
    return lp.assemble(model, keep=["crank.flange.phi"])


@pytest.mark.parametrize("speed", [7.0, -7.0])
def test_orders_of_a_slider_crank_are_those_of_its_exact_torque(speed):
    system = crank(speed)
    run = lp.simulate(system, until=1.7 * 2 * np.pi / 7.0, grid=6000, rtol=1e-10)
    found = lp.vibration.orders(
        run, "crank.flange.tau", shaft="crank.flange.phi", least=1e-4, most=8
    )
    # torque of the mass at constant speed from closed forms, harmonics by the discrete transform
    q = np.arange(4096) * 2 * np.pi / 4096
    root = np.sqrt(0.4**2 - (0.1 * np.sin(q)) ** 2)
    slope = -0.1 * np.sin(q) - 0.1**2 * np.sin(q) * np.cos(q) / root
    bend = -0.1 * np.cos(q) - 0.1**2 * (
        np.cos(2 * q) / root + (0.1 * np.sin(q) * np.cos(q)) ** 2 / root**3
    )
    expected = 2 * np.fft.rfft(2.0 * 49.0 * slope * bend)[:9] / 4096
    sizes = {order.order: order.amplitude for order in found}
    error = max(abs(sizes[k] - abs(expected[k])) for k in (1, 2, 3, 4))
    assert error < 1e-5 * abs(expected).max()
    assert sizes[2] == max(sizes.values())
    for order in found[:5]:
        # the angle counts in the sense of rotation
        turn = order.phase - np.angle(expected[order.order]) * np.sign(speed)
        turn -= order.order * (run["crank.flange.phi"][0] * np.sign(speed))
        assert abs(np.exp(1j * turn) - 1) < 1e-4


HALVES = HarmonicTorque(harmonics=((0.5, 5.0, 0.0), (1.5, 3.0, 0.0)))
"""Torque ``5 sin(phi / 2) + 3 sin(3 phi / 2)``, as of an engine."""


@pytest.mark.parametrize("w", [50.0, -50.0])
@pytest.mark.parametrize("turns", [2, 4])
def test_half_orders_count_over_two_turns(w, turns):
    """Their sines are cosines a quarter of a period later; backwards they are negative."""
    system = assemble_row(a=Inertia(J=5.0, w=w), h=HALVES, keep=["a.phi", "h.tau"])
    for until in (0.6, 5.0):
        run = lp.simulate(system, until=until, grid=int(6000 * until), rtol=1e-9)
        found = lp.vibration.orders(run, "h.tau", shaft="a.phi", turns=turns)
        assert [order.order for order in found] == [0.5, 1.5]
        sizes = [order.amplitude for order in found]
        assert sizes == pytest.approx([5.0, 3.0], rel=1e-3)
        phases = [order.phase for order in found]
        assert phases == pytest.approx([-np.pi / 2 * np.sign(w)] * 2, abs=2e-3)
        with pytest.raises(OptionError, match=r"tau does not repeat after 1 turn .*turns=2"):
            lp.vibration.orders(run, "h.tau", shaft="a.phi")


def test_bad_input_is_refused():
    short, run = (lp.simulate(crank(), until=t, grid=n) for t, n in ((0.5, 2000), (1.0, 100)))
    rows = [(short, "flange.phi", 1, "full turn"), (run, "flange.phi", 1, "too few")]
    rows += [(run, "flange.phi", turns, "whole number") for turns in (0, 1.5, True)]
    rows += [(run, "flange.phi", 2, "2 full turns are needed"), (run, "s", 1, "turns back")]
    for given, angle, turns, match in rows:
        with pytest.raises(OptionError, match=match):
            lp.vibration.orders(given, "crank.flange.tau", shaft=f"crank.{angle}", turns=turns)


def test_turns_are_the_product_of_the_ratios():
    model = lp.compose(
        motor=Inertia(J=0.1),
        shaft=Spring(c=1e3),
        first=IdealGear(ratio=-2.5),
        second=IdealGear(ratio=4.0),
        belt=Spring(c=50.0),
        drum=Inertia(J=20.0),
        lone=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.motor, m.shaft, m.first, m.second, m.belt, m.drum),
    )
    modes = lp.modes(lp.assemble(model))
    for of, shaft, expected in (
        ("drum.phi", "motor.phi", 0.1),
        ("motor.phi", "drum.phi", 10.0),
        ("first.flange_b.phi", "motor.phi", 0.4),
    ):
        assert lp.vibration.turns(modes, of, shaft=shaft) == pytest.approx(expected, rel=1e-12)
    # 21 teeth on the motor: 210 for each turn of the drum
    order = 21 * lp.vibration.turns(modes, "motor.phi", shaft="drum.phi")
    (critical,) = lp.vibration.critical_speeds(modes, [order])[:1]
    assert critical.speed * order == pytest.approx(2 * np.pi * modes.hertz[0])
    with pytest.raises(OptionError, match=r"lone\.phi does not turn with motor\.phi"):
        lp.vibration.turns(modes, "lone.phi", shaft="motor.phi")


def test_mesh_orders_are_teeth_times_turns():
    """17 teeth drive 68, whose shaft carries 21 that drive 63; two speeds up."""
    model = in_a_row(
        motor=Inertia(J=0.1),
        first=IdealGear(ratio=-68 / 17),
        middle=Inertia(J=0.4),
        shaft=Spring(c=1e3),
        second=IdealGear(ratio=-63 / 21),
        drum=Inertia(J=20.0),
    )
    modes = lp.modes(lp.assemble(model))
    teeth = {"motor.phi": 17, "middle.phi": 21, "drum.phi": 63}
    received = lp.vibration.mesh_orders(modes, teeth, shaft="motor.phi", harmonics=2)
    assert list(received)[:2] == ["motor.phi, 17 teeth", "2 x motor.phi, 17 teeth"]
    assert list(received.values()) == pytest.approx([17, 34, 21 / 4, 21 / 2, 63 / 12, 63 / 6])
    critical = lp.vibration.critical_speeds(modes, received)
    assert critical[0].label == "2 x motor.phi, 17 teeth"
    assert critical[0].speed * 34 == pytest.approx(2 * np.pi * modes.hertz[0])
    for wrong in (0, 2.5, True):
        with pytest.raises(OptionError, match="whole number is needed"):
            lp.vibration.mesh_orders(modes, {"motor.phi": wrong}, shaft="motor.phi")
    with pytest.raises(OptionError, match="harmonics = 0"):
        lp.vibration.mesh_orders(modes, teeth, shaft="motor.phi", harmonics=0)
