"""Orders over the speed against torques that are known over the angle, and steady vibration."""

import numpy as np
import pytest
from checks import worst
from rows import assemble_row, in_rows

import lumped as lp
from lumped.components import Fixed, HarmonicTorque, Inertia, SpringDamper, Torque
from lumped.errors import OptionError

SIZES = {0.5: (5.0, 0.0), 1.5: (3.0, 0.3), 4.0: (1.0, -1.0), 9.4094: (2.0, 2.0)}
"""Amplitudes and phases of cosines of the angle, which counts in the sense of rotation."""


def run_up(sense=1.0, grid=60000, until=20.0):
    rows = [(n, a, sense * p + np.pi / 2) for n, (a, p) in SIZES.items()]
    engine = HarmonicTorque(harmonics=rows, mean=20.0 * sense)
    system = assemble_row(
        rotor=Inertia(J=5.0, w=30.0 * sense), engine=engine, keep=["rotor.phi", "engine.tau"]
    )
    return lp.simulate(system, until=until, grid=grid, rtol=1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_amplitudes_and_phases_of_a_run_up_are_those_of_the_torque(sense):
    run = run_up(sense)
    found = lp.vibration.order_tracks(run, "engine.tau", shaft="rotor.phi")
    assert found.speeds[-1] > 3 * found.speeds[0]
    for order, (size, phase) in SIZES.items():
        assert found.track(order) == pytest.approx(size * np.exp(1j * phase), rel=1e-3), order
    # speed of a rotor under a constant mean torque, in the middle of each window
    expected = np.interp(found.times, run.t, sense * run["rotor.w"])
    assert found.speeds == pytest.approx(expected, rel=2e-3)
    assert found.largest() == pytest.approx(tuple(SIZES), rel=1e-5)
    told = repr(found)
    assert "windows of 8 turns of rotor.phi (Hann), overlap 75%" in told


def test_the_map_has_each_order_at_its_place():
    found = lp.vibration.order_tracks(
        run_up(), "engine.tau", shaft="rotor.phi", turns=4, overlap=0.5
    )
    assert np.diff(found.orders) == pytest.approx(0.25)
    for order in (0.5, 1.5, 4.0):
        column = np.abs(found.values[:, np.flatnonzero(found.orders == order)[0]])
        assert column == pytest.approx(SIZES[order][0], rel=5e-3)
    empty = (found.orders > 5) & (found.orders < 7.5)
    assert np.abs(found.values[:, empty]).max() < 3e-3
    plane, curves, _ = found.plot().axes
    assert plane.collections[0].get_array().size == found.values.size
    assert len(curves.lines) == 4


class Twice(lp.Component):
    """Torque ``3 cos(2 phi)`` of the angle of a rotor on a body; the housing takes it."""

    rotor = lp.Flange()
    body = lp.Flange()

    def equations(self):
        yield self.rotor.tau == 0
        yield self.body.tau == -3.0 * lp.ops.cos(2 * self.rotor.phi)


def test_a_slow_passage_through_a_resonance_has_the_steady_amplitudes():
    """An oscillator at 80 rad/s, excited twice a turn by a rotor that runs up slowly."""
    J, c, d = 0.5, 0.5 * 80.0**2, 4.0
    model = in_rows(
        "drive rotor engine.rotor",
        "engine.body body shaft wall",
        rotor=Inertia(J=1e3, w=37.0),
        engine=Twice(),
        body=Inertia(J=J),
        shaft=SpringDamper(c=c, d=d),
        wall=Fixed(),
        drive=Torque(tau=50.0),
    )
    system = lp.assemble(model, keep=["rotor.phi"])
    run = lp.simulate(system, until=120.0, grid=120 * 1000, rtol=1e-9)
    found = lp.vibration.order_tracks(
        run, "shaft.tau", shaft="rotor.phi", most=4.0, turns=6, overlap=0.5
    )
    received = np.abs(found.track(2.0))
    later = found.times > 3.0  # what began at rest has faded
    response = lp.vibration.order_response(
        lp.assemble(model, keep=["rotor.phi"]),
        speeds=found.speeds[later],
        of=["shaft.tau"],
        shaft="rotor.phi",
        orders=[2.0],
        parameters={"drive.tau": 0.0},
    )
    expected = response.magnitude("shaft.tau", 2.0)
    peak = expected.argmax()
    assert 0.1 * len(expected) < peak < 0.9 * len(expected)
    w = 2 * found.speeds[later]
    closed = 3.0 * np.hypot(c, d * w) / np.hypot(c - J * w**2, d * w)
    assert expected == pytest.approx(closed, rel=1e-9)
    assert (
        worst(received[later], expected) < 5e-3
    )  # the vibration lags a quarter of a second behind the speed


def test_what_cannot_be_tracked_is_named():
    run = run_up(until=4.0, grid=8000)
    usual = {"of": "engine.tau", "shaft": "rotor.phi"}
    for options, match in (
        ({"turns": 50}, r"makes 2\d\.\d+ turns; a window has 50"),
        ({"turns": 2}, "at least 3 turns"),
        ({"overlap": 1.0}, "overlap = 1 must"),
        ({"most": 400.0}, r"too few for the order 400; .* at least 4000 points"),
        ({"most": 0.2}, "highest order"),
        ({"shaft": "engine.tau"}, "turns back"),
    ):
        with pytest.raises(OptionError, match=match):
            lp.vibration.order_tracks(run, **usual | options)
    found = lp.vibration.order_tracks(run, **usual)
    for order in (0.1, 13.0):
        with pytest.raises(OptionError, match=r"must lie between 0\.25, two periods"):
            found.track(order)
