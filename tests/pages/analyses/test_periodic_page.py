"""What docs/analyses/periodic.md shows is true."""

import numpy as np
import pytest

import lumped as lp

NAME = "analyses/periodic"


@pytest.mark.parametrize("which", ["round_", "elliptical"])
def test_the_orbit_is_where_fifty_simulated_turns_end(names, which):
    orbit, T = names[which], names["T"]
    assert orbit.residual < 1e-10
    run = lp.simulate(
        names["system"],
        until=50.001 * T,
        start=names["start"],
        parameters={"eps": 0.5 if which == "elliptical" else 0.0},
        grid=49 * T + np.append(orbit.run.t[1:-1:100], T),
        rtol=1e-8,
    )
    for name, turned in (("motor.phi", 98 * np.pi), ("motor.w", 0.0), ("motor.i", 0.0)):
        miss = np.abs(run[name] - turned - np.append(orbit[name][1:-1:100], orbit[name][-1]))
        assert miss.max() < 1e-6 * np.abs(orbit[name]).max()


def test_multipliers_are_those_of_disturbed_runs(names):
    """The slope of the states after a turn, by differences: no derivative is followed there."""
    orbit = names["orbits"][1]
    ends = []
    for sign in (1, -1):
        begin = {name: orbit[name][0] for name in ("motor.phi", "motor.w", "motor.i")}
        begin["motor.phi"] += sign * 1e-4
        run = lp.simulate(
            names["system"],
            until=names["T"],
            start=names["start"] | begin,
            parameters={"control.k": float(names["gains"][1])},
            rtol=1e-11,
        )
        ends.append(run["motor.phi"][-1])
    # what is left after a turn is the slow mode of the angle
    assert (ends[0] - ends[1]) / 2e-4 == pytest.approx(orbit.largest, rel=0.02)
    assert orbit.largest == pytest.approx(
        np.exp(-names["gains"][1] * names["T"] / names["FLUX"]), rel=0.05
    )


def test_the_flywheel_does_what_it_should_in_a_simulation(names):
    wheel = names["wheel"]
    run = lp.simulate(
        names["system"],
        until=20 * names["T"],
        start=names["start"],
        parameters={"motor.J": wheel.after},
        grid=np.linspace(19, 20, 20_001) * names["T"],
        rtol=1e-9,
    )
    w = run["motor.w"]
    assert np.ptp(w) / (2 * np.pi / names["T"]) == pytest.approx(0.4, rel=1e-5)
    assert wheel.classical / 1e3 == pytest.approx(11.8, abs=0.1)
    assert wheel.added / 1e3 == pytest.approx(2615, abs=1)
    assert "irregularity" in repr(wheel)


def test_derivatives_along_the_orbit_agree_with_differences(names):
    by, orbit = names["by"], names["round_"]
    beside = []
    for R in (0.0606, 0.0594):
        found = lp.periodic(
            names["system"],
            period=names["T"],
            turn={"motor.phi": 2 * np.pi},
            start=names["start"],
            parameters={"motor.R": R},
        )
        beside.append(found["motor.w"])
    quotient = (beside[0] - beside[1]) / 0.0012
    exact = by["motor.w", "motor.R"]
    instants = np.array([event.time for event in orbit.run.events])
    smooth = np.abs(orbit.run.t[:, None] - instants).min(axis=1) > 0.02
    error = np.abs(quotient - exact)[smooth[: len(quotient)]].max() / np.abs(exact[smooth]).max()
    assert error < 1e-3
