"""What docs/analyses/inverse.md shows is true."""

import numpy as np
import pytest
from arm_by_hand import EMPTY, LOADED, ROTOR, friction, gravity

from lumped.models.rotary_arm.cycle import ADOPTED
from lumped.models.rotary_arm.loads import MAXIMUM, RATED
from lumped.models.rotary_arm.parts import ETA, RATIO

NAME = "analyses/inverse"


def test_the_page_prints_what_stands_there_and_agrees_with_torques_by_hand(names):
    # angle and speed from the ramps, the arm as one inertia that gains and loses the mandrel
    t, w = (np.array(x) for x in ADOPTED.speed())
    at = np.linspace(0.0, 9.0, 900_001)[:-1] + 5e-6
    speed = np.interp(at, t, w)
    turned = np.concatenate([[0.0], np.cumsum(np.diff(t) * (w[1:] + w[:-1]) / 2)])
    k = np.searchsorted(t, at) - 1
    slope = (np.diff(w) / np.diff(t))[k]
    since = at - t[k]
    phi = ADOPTED.points["S"] + turned[k] + w[k] * since + slope * since**2 / 2
    loaded = (phi > ADOPTED.pick_up) & (phi < ADOPTED.release)
    arm = np.where(loaded, LOADED, EMPTY) * slope + gravity(phi, loaded) + friction(loaded)
    # the reducer loses 1 - eta of the power that enters it
    reducer = arm / RATIO * np.where(arm > 0, 1 / ETA, ETA)
    torque = reducer + ROTOR / RATIO * slope
    report = names["report"]
    rms = np.sqrt((torque**2).mean())
    assert report.rms_torque == pytest.approx(rms, rel=2e-3)
    assert report.peak_torque == pytest.approx(np.abs(torque).max(), rel=1e-3)
    assert report.peak_power == pytest.approx((torque * speed).max() * RATIO, rel=1e-3)
    assert report.mean_power == pytest.approx((torque * speed).mean() * RATIO, rel=2e-2)
    assert report.mean_speed == pytest.approx(2 * np.pi / 9 * RATIO, rel=1e-6)
    assert report.thermal.ratio == pytest.approx(rms / RATED, rel=2e-3)
    assert report.peak.ratio == pytest.approx(np.abs(torque).max() / MAXIMUM, rel=1e-3)
    assert not report.fits
