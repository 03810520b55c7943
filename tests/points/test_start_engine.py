"""The torque of a six-cylinder engine is filtered from the start on."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import CrankSlider, Filter, Inertia, QuadraticTorque, TorqueSensor
from lumped.ops import where

RADIUS, ROD, BORE = 0.1, 0.2, 0.1
"""Crank, rod and bore of the cylinder of the reference case engine_fired, m."""

BANKS = np.deg2rad([-30.0, 30.0, -30.0, 30.0, -30.0, 30.0])
PINS = np.deg2rad([-30.0, 90.0, -150.0, -90.0, 30.0, -210.0])


CLOSING = (
    (177.4132, -287.2189, 151.8252, -24.9973, 2.4),
    (2836360.0, -10569296.0, 14761814.0, -9158505.0, 2129670.0),
)
OPENING = (
    (145.930, -131.707, 17.3438, 17.9272, 2.4),
    (-3929704.0, 14748765.0, -20747000.0, 12964477.0, -3036495.0),
)
"""Gas pressure of the reference case, bar, below its peak and about it: polynomials of x."""


def pressure(x, rising):
    """Gas pressure in bar; `rising`: the piston moves to the head."""
    row, peak = CLOSING if rising else OPENING
    return np.polyval(row if (x < 0.986061 if rising else x <= 0.933) else peak, x)


class Gas(lp.Component):
    """Gas force of one cylinder, from place and direction of its piston."""

    flange = lp.LinearFlange()
    v: lp.Var = lp.var("m/s", "speed away from the head")

    def equations(self):
        x = 1.0 - (0.45 - (self.flange.s + 0.1)) / 0.35
        yield self.v == -lp.der(self.flange.s)
        low_closing, high_closing, low_opening, high_opening = (
            sum(a * x**k for a, k in zip(row, (4, 3, 2, 1, 0), strict=True))
            for row in (*CLOSING, *OPENING)
        )
        closing = where(x < 0.986061, low_closing, high_closing)
        opening = where(x <= 0.933, low_opening, high_opening)
        bar = where(self.v < 0, closing, opening)
        yield self.flange.f == 1e5 * bar * np.pi * BORE**2 / 4


def engine():
    """Six cylinders in a V that drive a flywheel against a fan; the torque is filtered."""
    heavy = {"m": 6.04756586, "m_rod": 1.848, "J_rod": 0.0067144}
    return lp.compose(
        cylinder=[
            CrankSlider(r=RADIUS, L=ROD, **heavy, axis=bank, phase=pin)
            for bank, pin in zip(BANKS, PINS, strict=True)
        ],
        gas=[Gas() for _ in range(6)],
        shaft=Inertia(J=6 * 0.0114306736),
        sensor=TorqueSensor(),
        load=Inertia(J=1.0, phi=0.0, w=10.0),
        fan=QuadraticTorque(tau_nominal=-100.0, w_nominal=200.0),
        lags=[Filter(T=0.1 / np.pi), Filter(T=0.1 / np.pi)],
        connections=lambda m: [
            *(lp.connect(c.flange, m.shaft.flange_a) for c in m.cylinder),
            *(lp.connect(c.slider, g.flange) for c, g in zip(m.cylinder, m.gas, strict=True)),
            *lp.chain(m.shaft, m.sensor, m.load, m.fan),
            lp.connect(m.sensor.tau, m.lags[0].u),
            lp.connect(m.lags[0].y, m.lags[1].u),
        ],
        initial_equations=lambda m: [lp.der(lag.x) == 0 for lag in m.lags],
    )


def engine_torque():
    """Torque between engine and flywheel at the start, by virtual work and differences."""
    w, h = 10.0, 1e-4

    def places(phi):
        q = phi + PINS - BANKS
        psi = np.arcsin(-RADIUS * np.sin(q) / ROD)
        s = RADIUS * np.cos(q) + ROD * np.cos(psi)
        pin, rod = (np.array([np.cos(v), np.sin(v)]) for v in (q, psi))
        return s, psi, RADIUS * pin + 0.5 * ROD * rod

    def slopes(phi):
        (a, b, c), (d, e, f) = places(phi - h), places(phi + h)
        return (d - a) / (2 * h), (e - b) / (2 * h), (f - c) / (2 * h)

    def inertia(phi):
        s, psi, middle = slopes(phi)
        moving = 6.04756586 * s**2 + 1.848 * (middle**2).sum(axis=0) + 0.0067144 * psi**2
        return 6 * 0.0114306736 + moving.sum()

    s, by = places(0.0)[0], slopes(0.0)[0]
    x = 1.0 - (0.45 - (s + 0.1)) / 0.35
    force = [1e5 * pressure(a, b * w > 0) * np.pi * BORE**2 / 4 for a, b in zip(x, by, strict=True)]
    gas = -np.dot(force, by)
    bend = (inertia(h) - inertia(-h)) / (2 * h)
    fan = -100.0 * (w / 200.0) ** 2
    a = (gas - 0.5 * bend * w**2 + fan) / (inertia(0.0) + 1.0)
    return 1.0 * a - fan


def test_the_filtered_torque_of_an_engine_starts_at_its_torque():
    expected = engine_torque()
    point = lp.start_point(lp.assemble(engine(), keep=["load.phi"]))
    assert abs(point["sensor.tau"]) == pytest.approx(abs(expected), rel=1e-5)
    assert point["lags[1].y"] == pytest.approx(point["sensor.tau"], rel=1e-9)
