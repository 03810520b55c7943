"""Periodic motions whose period is given, a parameter, or found while a design changes."""

import numpy as np
import pytest
from differences import slope
from periodic_motions import ROTOR, TURN, driven, orbit_of, swing_of, torque_for
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptionError, SolverError
from lumped.ops import sin


def test_a_torque_is_found_that_keeps_a_given_mean_speed():
    speed = 12.0
    period = 2 * np.pi / speed
    orbit = lp.periodic(ROTOR, turn=TURN, period=period, free=["tau"])
    assert orbit.period == pytest.approx(period, rel=1e-9)
    assert orbit.mean("w") == pytest.approx(speed, rel=1e-9)
    assert orbit.free["tau"] == pytest.approx(torque_for(period), rel=1e-9)
    assert orbit.run.theta[ROTOR.places(["tau"])[0]] == orbit.free["tau"]
    assert f"for this period: tau = {orbit.free['tau']:.9g}" in repr(orbit)


def test_derivatives_at_a_given_mean_speed_follow_the_torque():
    """Central differences of the turns that take the same time."""
    period = 0.5
    orbit = lp.periodic(ROTOR, turn=TURN, period=period, free=["tau"])
    found = orbit.sensitivity(of=["w"], by=["d", "G"])
    assert found.by == ("d", "G")
    assert found.period == {"d": 0.0, "G": 0.0}
    assert found.mean == pytest.approx(np.zeros((1, 2)), abs=1e-7)
    for column, (name, value, h) in enumerate((("d", 0.5, 2e-2), ("G", 2.0, 2e-2))):

        def top(x, name=name):
            turned = orbit_of(tau=torque_for(period, **{name: x}), **{name: x})
            return turned.sol(np.linspace(0, 2 * np.pi, 20_001))[0].max()

        assert found.greatest[0, column] == pytest.approx(slope(top, value, h, 2), rel=2e-3)
    with pytest.raises(OptionError, match="tau is free, and this motion determines it"):
        orbit.sensitivity(of=["w"], by=["tau"])


def amplitude(T, d=0.3, c=2.0):
    w = 2 * np.pi / T
    return 1.5 / abs(c - w**2 + 1j * w * d)


def test_derivatives_by_the_period():
    """The amplitude is that of the frequency response."""
    system = driven(T=5.0)
    orbit = lp.periodic(system, period="T")
    assert orbit.greatest("x").value == pytest.approx(amplitude(5.0), rel=1e-8)
    found = orbit.sensitivity(of=["x"], by=["T", "c"])
    assert found.period == {"T": 1.0, "c": 0.0}
    assert found.greatest[0, 0] == pytest.approx(slope(amplitude, 5, 1e-4), rel=1e-6)
    # held as a number, the end of the period would be another place of the wave
    stiffer = slope(lambda c: amplitude(5, c=c), 2, 1e-4)
    assert found.greatest[0, 1] == pytest.approx(stiffer, rel=1e-6)
    assert lp.periodic(system, period="T", parameters={"T": 4.0}).period == 4.0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"free": ["tau"], "warm_up": 5.0}, "one parameter is determined by one period"),
        ({"free": ["tau", "d"], "period": 0.5}, "one parameter is determined by one period"),
        ({"free": ["tau"], "period": "J"}, "one parameter is determined by one period"),
        ({"period": 0.5}, "or a parameter in free= for which this is the period"),
        ({"free": ["ratio"], "period": 0.5}, "the period does not depend on ratio"),
    ],
)
def test_what_a_period_does_not_determine_is_refused(options, text):
    with pytest.raises(OptionError, match=text):
        lp.periodic(ROTOR, turn=TURN, **options)


def test_a_driven_motion_has_no_parameter_to_free():
    with pytest.raises(OptionError, match=r"functions of time act .* c is not determined"):
        lp.periodic(driven(T=5.0), period=5.0, free=["c"])


def test_a_period_out_of_reach_is_told():
    """With any inertia the mean speed stays near tau / d."""
    with pytest.raises((SolverError, OptionError)):
        lp.periodic(ROTOR, turn=TURN, period=3.0, free=["J"])


def test_a_motion_of_unknown_period_stays_periodic_while_its_design_changes():
    """The least torque for a swing of at most 0.2 rad/s: the inertia is at its bound then."""
    orbit = lp.periodic(ROTOR, turn=TURN, warm_up=20.0)
    found = lp.optimise(
        orbit,
        vary={"J": (0.5, 4.0)},
        minimise={"J": 1.0},
        subject_to=fun.swing("w") <= 0.2,
        intervals=60,
    )
    expected = brentq(lambda J: swing_of(orbit_of(J=J)) - 0.2, 1.0, 4.0, xtol=1e-9)
    assert found.parameters["J"] == pytest.approx(expected, rel=1e-3)
    # the run is the motion of this design, with its own period
    exact = orbit_of(J=found.parameters["J"])
    assert found.run.t[-1] == pytest.approx(exact.y[1, -1], rel=1e-6)
    assert found.values[fun.swing("w")] == pytest.approx(swing_of(exact), rel=1e-5)
    assert found.run["phi"][-1] - found.run["phi"][0] == pytest.approx(2 * np.pi, rel=1e-8)


def test_a_free_torque_is_found_with_the_design():
    period = 0.5
    orbit = lp.periodic(ROTOR, turn=TURN, period=period, free=["tau"])
    found = lp.optimise(
        orbit, vary={"J": (0.5, 3.0), "tau": (1.0, 10.0)}, minimise=fun.swing("w"), intervals=40
    )
    assert found.parameters["J"] == pytest.approx(3.0, rel=1e-6)
    assert found.parameters["tau"] == pytest.approx(torque_for(period, J=3.0), rel=1e-6)
    with pytest.raises(OptionError, match=r"tau is free at this motion.*name it in `vary`"):
        lp.optimise(orbit, vary={"J": (0.5, 3.0)}, minimise=fun.swing("w"))


class Synchronous(lp.Component):
    """Rotor that a turning field pulls along: ``J w' = K sin(W t - phi) - d w - G sin(phi)``."""

    phi: lp.Var = lp.var("rad", "angle", start=-0.3)
    w: lp.Var = lp.var("rad/s", "speed", start=6.0)
    J: lp.Param = lp.param("kg.m2", "inertia", 1.0)
    K: lp.Param = lp.param("N.m", "pull", 30.0)
    d: lp.Param = lp.param("N.m.s/rad", "damping", 2.0)
    G: lp.Param = lp.param("N.m", "weight times eccentricity", 2.0)

    def equations(self):
        yield lp.der(self.phi) == self.w
        pull = self.K * sin(6.0 * lp.time - self.phi)
        yield self.J * lp.der(self.w) == pull - self.d * self.w - self.G * sin(self.phi)


@pytest.mark.parametrize("given", ["motion", "run"])
def test_an_angle_that_turns_repeats_after_its_turn(given):
    T = 2 * np.pi / 6.0
    system = lp.assemble(Synchronous())
    orbit = lp.periodic(system, period=T, turn=TURN)
    options = {"periodic": True} if given == "run" else {}
    found = lp.optimise(
        orbit.run if given == "run" else orbit,
        vary={"J": (0.8, 3.0)},
        minimise=fun.swing("w"),
        intervals=60,
        **options,
    )
    J = found.parameters["J"]

    def rates(t, y):
        return [y[1], (30 * np.sin(6 * t - y[0]) - 2 * y[1] - 2 * np.sin(y[0])) / J]

    begin = [found.run["phi"][0], found.run["w"][0]]
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12, "dense_output": True}
    exact = solve_ivp(rates, (0, T), begin, **options)
    # the nodes are met by collocation of order five
    assert exact.y[:, -1] - begin == pytest.approx([2 * np.pi, 0.0], abs=1e-6)
    swing = np.ptp(exact.sol(np.linspace(0, T, 20_001))[1])
    assert found.objective == pytest.approx(swing, rel=1e-6)
    assert found.objective < np.ptp(orbit["w"])


def test_a_run_whose_period_nothing_prescribes_is_refused():
    orbit = lp.periodic(ROTOR, turn=TURN, warm_up=20.0)
    with pytest.raises(OptionError, match=r"Give the motion that lumped\.periodic returns"):
        lp.optimise(orbit.run, periodic=True, vary={"J": (0.5, 3.0)}, minimise=fun.swing("w"))


def test_what_cannot_be_optimised_is_named():
    with pytest.raises(OptionError, match=r"a run from lumped\.simulate or an orbit"):
        lp.optimise(lp.start_point(ROTOR), vary={"J": (0.5, 3.0)}, minimise=fun.swing("w"))
