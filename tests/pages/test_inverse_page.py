"""What docs/analyses/inverse.md shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Polynomial

PAGE = (Path(__file__).parents[2] / "docs" / "analyses" / "inverse.md").read_text()


def test_the_example_prints_what_stands_there_and_agrees_with_the_closed_form(capsys):
    names = {}
    exec(compile(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0], "page", "exec"), names)
    printed = capsys.readouterr().out.strip()
    assert printed == re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)[0].strip()
    # at the motor: inertia of the table over the square of the ratio, way times the ratio
    h, T, J_a, J_b, d, c = 1.5 * 8, 0.4, 0.002, 0.5 / 64, 0.8 / 64, 400.0
    law = Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
    way = [h / T**k * law.deriv(k) for k in range(1, 5)]
    twist = [(J_b * way[k + 1] + d * way[k]) / c for k in range(3)]
    torque = J_a * (way[1] + twist[2]) + c * twist[0]
    speed = way[0] + twist[1]
    report = names["report"]
    assert report.mean_power == pytest.approx(
        2 * T / 1.4 * d * (way[0] ** 2).integ()(1.0), rel=1e-4
    )
    rms = np.sqrt(2 * T / 1.4 * (torque**2).integ()(1.0))
    x = np.linspace(0, 1, 20_001)
    assert report.rms_torque == pytest.approx(rms, rel=1e-4)
    assert report.peak_torque == pytest.approx(np.abs(torque(x)).max(), rel=1e-4)
    assert report.peak_speed == pytest.approx(np.abs(speed(x)).max(), rel=1e-4)
    assert report.thermal.ratio == pytest.approx(rms / 3, rel=1e-4)
    ratio = np.abs(torque(x)) / (7 - 0.02 * np.abs(speed(x)))
    assert report.peak.ratio == pytest.approx(ratio.max(), rel=1e-4)
