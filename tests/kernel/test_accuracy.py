"""Accuracy between steps and of events, where stability holds explicit steps up."""

import numpy as np
import pytest
from checks import worst
from rows import assemble_row
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, Latch, SpeedSensor, SpringDamper, Torque
from lumped.ops import minimum, sin

J, D, W0, END = 0.2, 6.0, 20.0, 3.0
"""A rotor on a damper with a time constant of 1/30 s, under a torque that swings slowly."""


def torque(t):
    return 120.0 + 30.0 * np.sin(0.8 * t) + 6.0 * t


def speed(t):
    """By the closed form of ``J w' + D w == torque``."""
    k, b = D / J, 0.8
    steady = 120.0 / D + (6.0 * t - 6.0 / k) / D
    swing = 30.0 / J * (k * np.sin(b * t) - b * np.cos(b * t)) / (k**2 + b**2)
    begin = 120.0 / D - 6.0 / k / D - 30.0 / J * b / (k**2 + b**2)
    return steady + swing + (W0 - begin) * np.exp(-k * t)


def rotor(levels=()):
    latches = {"latch": [Latch(on=level) for level in levels]} if levels else {}
    return lp.assemble(
        lp.compose(
            motor=Torque(tau=120 + 30 * sin(0.8 * lp.time) + 6 * lp.time),
            rotor=Inertia(J=J, w=W0),
            slip=Damper(d=D),
            ground=Fixed(),
            speed=SpeedSensor(),
            **latches,
            connections=lambda m: [
                *lp.chain(m.motor, m.rotor, m.slip, m.ground),
                lp.connect(m.rotor.flange_b, m.speed.flange),
                *(lp.connect(m.speed.w, part.u) for part in getattr(m, "latch", [])),
            ],
        )
    )


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("method", ["steps", "explicit", "implicit", "taylor"])
def test_values_between_steps_are_as_accurate_as_the_steps(method, rtol):
    run = lp.simulate(rotor(), until=END, grid=700, rtol=rtol, method=method)
    error = np.abs(run["rotor.w"] - speed(run.t)).max() / np.abs(run["rotor.w"]).max() / rtol
    print(f"{method}, {rtol:g}: {run.statistics.steps} steps, {error:.2g} rtol between them")
    assert error < 10


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("method", ["steps", "explicit", "implicit", "taylor"])
def test_events_between_steps_come_once_and_in_time(method, rtol):
    levels = [21.0, 22.5, 24.0]
    run = lp.simulate(rotor(levels), until=END, rtol=rtol, method=method)
    events = [e.time for e in run.events if e.component.startswith("latch")]
    expected = [brentq(lambda t, w=w: speed(t) - w, 0.0, 2.0, xtol=1e-14) for w in levels]
    slope = [(torque(t) - D * w) / J for t, w in zip(expected, levels, strict=True)]
    assert len(events) == len(levels)
    error = np.abs((np.array(events) - expected) * slope).max() / max(levels) / rtol
    assert error < 10


def test_stiffness_is_noticed_before_it_costs_a_hundredfold():
    """The damper alone asks for steps of 0.2 s; a spring of a millisecond holds explicit ones."""
    system = assemble_row(
        motor=Torque(tau=10 * sin(2 * lp.time)),
        rotor=Inertia(J=1.0),
        shaft=SpringDamper(c=1e6, d=2e3),
        load=Inertia(J=1.0),
        slip=Damper(d=1.0),
        ground=Fixed(),
    )
    runs = {
        method: lp.simulate(system, until=20.0, method=method, rtol=1e-6)
        for method in ("steps", "explicit", "implicit")
    }
    steps = {method: run.statistics.steps for method, run in runs.items()}
    assert runs["steps"].statistics.method == "explicit then implicit"
    assert steps["steps"] < 1.5 * steps["implicit"] < 0.2 * steps["explicit"]
    np.testing.assert_allclose(runs["steps"]["load.w"], runs["explicit"]["load.w"], atol=2e-4)


def chain(bodies):
    """A stiff chain with a torque at one end."""
    return lp.compose(
        motor=Torque(tau=100 * minimum(1.0, 50 * lp.time)),
        body=[Inertia(J=0.01) for _ in range(bodies)],
        shaft=[SpringDamper(c=1e5, d=50.0) for _ in range(bodies - 1)],
        connections=lambda m: [
            lp.connect(m.motor.flange, m.body[0].flange_a),
            *(
                part
                for i, shaft in enumerate(m.shaft)
                for part in lp.chain(m.body[i], shaft, m.body[i + 1])
            ),
        ],
    )


def test_a_stiff_chain_of_any_length_follows_scipy():
    """Sparse factors, far more states than dense ones would allow."""
    n, until = 150, 0.1
    run = lp.simulate(
        lp.assemble(chain(n)), until=until, method="implicit", rtol=1e-7, grid=[until]
    )

    def rate(t, x):
        twist, w = x[: n - 1], x[n - 1 :]
        force = 1e5 * twist + 50.0 * np.diff(w)
        load = np.zeros(n)
        load[0] = 100.0 * min(1.0, 50.0 * t)
        load[:-1] += force
        load[1:] -= force
        return np.concatenate([np.diff(w), load / 0.01])

    x = np.zeros(2 * n - 1)
    options = {"method": "Radau", "rtol": 1e-8, "atol": 1e-10}
    options["jac"] = np.array([rate(0.0, unit) for unit in np.eye(len(x))]).T
    for begin, end in ((0.0, 0.02), (0.02, until)):
        x = solve_ivp(rate, (begin, end), x, **options).y[:, -1]
    received = run.table([f"body[{i}].w" for i in range(n)])[-1]
    assert worst(received, x[n - 1 :]) < 1e-6
