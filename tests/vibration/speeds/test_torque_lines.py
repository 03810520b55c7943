"""Torque lines of inverters and their crossings with natural frequencies.

`tests/data/torsional/08_inverter_interharmonics`: closed form ``f = (m f_0 +- hertz) / n``.
"""

import numpy as np
import pytest
from checks import refused
from torsional_cases import rows

import lumped as lp
from lumped.components import Inertia, Spring
from lumped.errors import OptionError
from lumped.vibration import TorqueLine, line_crossings, sine_triangle_lines, six_pulse_lines

CASE = "08_inverter_interharmonics"
SPEEDS = np.array([300.0, 1800.0]) * np.pi / 30


def natural():
    """Motor, coupling and compressor; the frequencies above zero."""
    parts = [Inertia(J=85.0), Spring(c=9.5e5), Inertia(J=22.0), Spring(c=3.1e6), Inertia(J=640.0)]
    train = lp.compose(parts=parts, connections=list(lp.chain(*parts)))
    return lp.modes(lp.assemble(train)).hertz[-2:]


def test_natural_frequencies_are_those_of_the_table():
    assert natural() == pytest.approx(
        [float(row["Hz"]) for row in rows(CASE, "modes.csv")], rel=1e-9
    )


@pytest.mark.parametrize(
    ("lines", "name", "step", "columns"),
    [
        (sine_triangle_lines(450.0), "crossings_pwm", 1, ("m", "n")),
        (six_pulse_lines(50.0), "crossings_current_source", 6, ("i", "j")),
    ],
)
def test_crossings_are_those_of_the_table(lines, name, step, columns):
    expected = rows(CASE, f"{name}.csv")
    found = line_crossings(lines, natural(), speeds=SPEEDS, pairs=2)
    received = [c for c in found if c.mode == 0]
    assert len(received) == len(expected)
    for crossing, row in zip(received, expected, strict=True):
        assert (crossing.line.m, crossing.line.n // step) == tuple(int(row[x]) for x in columns)
        assert crossing.sign == row["sign"]
        assert crossing.hertz == pytest.approx(float(row["natural_Hz"]), rel=1e-8)
        assert crossing.f == pytest.approx(float(row["inverter_Hz"]), rel=1e-8)
        assert crossing.rpm == pytest.approx(float(row["rpm"]), rel=1e-8)


@pytest.mark.parametrize("lines", [sine_triangle_lines(450.0), six_pulse_lines(50.0)])
def test_all_crossings_are_where_frequencies_change_sides(lines):
    """Searched on a fine grid of speeds, for both modes."""
    speeds = np.linspace(*SPEEDS, 600_001)
    found = line_crossings(lines, natural(), speeds=SPEEDS, pairs=2)
    for mode, hertz in enumerate(natural()):
        expected = []
        for line in lines:
            beyond = line.frequencies(2 * speeds / (2 * np.pi)) > hertz
            _, places = np.nonzero(beyond[:, 1:] != beyond[:, :-1])
            # sum and difference of m = 0 are one line
            expected += [*speeds[places[: len(places) // (1 if line.m else 2)]]]
        received = [c.speed for c in found if c.mode == mode]
        assert received == sorted(received)
        assert received == pytest.approx(sorted(expected), abs=2 * (speeds[1] - speeds[0]))
        assert expected


def test_lines_of_the_modulation_are_odd_threes_and_even_sixes():
    received = {m: [x.n for x in sine_triangle_lines(450.0) if x.m == m] for m in range(3)}
    assert received == {0: [6, 12, 18], 1: [3, 9, 15], 2: [0, 6, 12, 18]}
    assert {(x.m, x.n) for x in six_pulse_lines(50.0)} == {
        (i, 6 * j) for i in range(3) for j in (1, 2)
    }


def test_lines_are_those_of_switched_voltages():
    """Switched voltages of sine-triangle modulation, on windings with inductance alone.

    The torque is the power of the currents against sinusoidal voltages. Nearly all of the energy
    of its pulsation up to 2.4 times the switching frequency lies on the lines.
    """
    f, f_s, ratio = 29.0, 450.0, 0.8
    count = 1_200_000
    t = np.arange(count) / count  # one second: whole periods of all
    carrier = 4 * np.abs((f_s * t) % 1 - 0.5) - 1
    phases = 2 * np.pi * f * t[None] - 2 * np.pi / 3 * np.arange(3)[:, None]
    legs = np.where(ratio * np.cos(phases) > carrier, 1.0, -1.0)
    voltage = np.fft.rfft(legs - legs.mean(axis=0))
    frequencies = np.arange(voltage.shape[1])
    current = np.fft.irfft(voltage / (1j * np.maximum(frequencies, 1) + 2.0), count)
    torque = (current * np.cos(phases)).sum(axis=0)
    energy = np.abs(np.fft.rfft(torque)[1 : int(2.4 * f_s)]) ** 2
    lines = {round(x) for line in sine_triangle_lines(f_s, n=24) for x in line.frequencies(f)[:, 0]}
    places = [x - 1 for x in lines if 0 < x <= len(energy)]
    share = energy[places].sum() / energy.sum()
    assert share > 0.998


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: sine_triangle_lines(0.0), "f_s = 0 Hz must be positive"),
        (lambda: six_pulse_lines(50.0, j=-1), "j = -1 must be at least 0"),
        (lambda: line_crossings([TorqueLine(1, 3, 450.0)], [-1.0], speeds=[1, 2]), "at least 0"),
        (lambda: line_crossings([TorqueLine(1, 3, 450.0)], [9.0], speeds=[2, 1]), "least and the"),
        (
            lambda: line_crossings([TorqueLine(1, 3, 450.0)], [9.0], speeds=[1, 2], pairs=0),
            "pairs = 0",
        ),
    ],
)
def test_values_out_of_range_are_refused(call, text):
    refused(OptionError, call, text)
