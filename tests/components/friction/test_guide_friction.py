"""Friction under a load that depends on the friction itself."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import (
    CrankSlider,
    Inertia,
    Position,
    Torque,
    translation,
)
from lumped.errors import SolverError

R, L, E, M, G, MU = 0.2, 0.6, 0.05, 3.0, 9.81, 0.3


class Rubbing(lp.Component):
    """Flywheel, crank and a slider that rubs in its guide; the heat is integrated."""

    J: lp.Param = lp.param("kg.m2", "flywheel", 2.0)
    g: lp.Param = lp.param("m/s2", "free fall", G)
    drive: lp.Component = Torque(tau=0.0)
    fly: Inertia = Inertia(J=J)
    crank: CrankSlider = CrankSlider(r=R, L=L, e=E, m=M, g=g)
    guide: translation.GuideFriction = translation.GuideFriction(mu=MU)
    heat: lp.Var = lp.var("1", "heat", state="always")

    def connections(self):
        yield lp.connect(self.drive.flange, self.fly.flange_a, self.crank.flange)
        yield lp.connect(self.crank.slider, self.guide.flange_a)
        yield lp.connect(self.crank.guide, self.guide.load)

    def equations(self):
        yield lp.der(self.heat) == self.guide.loss()


def geometry(q):
    """Position of the slider over the crank angle with two derivatives, and tan of the rod."""
    s, c = np.sin(q), np.cos(q)
    psi = np.arcsin((E - R * s) / L)
    p1 = -R * c / (L * np.cos(psi))
    p2 = (R * s + L * np.sin(psi) * p1**2) / (L * np.cos(psi))
    slope = -R * s - L * np.sin(psi) * p1
    bend = -R * c - L * np.cos(psi) * p1**2 - L * np.sin(psi) * p2
    return slope, bend, np.tan(psi)


def normal(acceleration, way, tan, g):
    """Guide force from the slider's own balance, with the friction that it makes itself.

    The rod pushes with S along its direction: m a = S cos - f, 0 = N - m g + S sin, f = mu |N| way.
    """
    free = M * g - tan * M * acceleration
    found = [free / (1 + MU * way * side * tan) for side in (1, -1)]
    fits = [n for n, side in zip(found, (1, -1), strict=True) if n * side >= 0]
    assert len(fits) == 1
    return fits[0]


@pytest.mark.parametrize("g", [0.0, G])
def test_torque_at_constant_speed_is_that_of_the_sliders_balance(g):
    w, begin = 6.0, 0.1
    system = lp.assemble(Rubbing(drive=Position(phi=begin + w * lp.time)))
    run = lp.simulate(system, until=2 * np.pi / w, grid=720, parameters={"g": g})
    slope, bend, tan = geometry(begin + w * run.t)
    a, way = bend * w**2, np.sign(slope)
    N = np.array([normal(*each, g) for each in zip(a, way, tan, strict=True)])
    friction = MU * np.abs(N) * way
    # weight of the slider does no work along a level slide
    tau = (M * a + friction) * slope
    away = np.abs(slope) > 1e-6
    assert np.abs(run["crank.guide"] - N)[away].max() < 1e-10 * np.abs(N).max()
    assert np.abs(run["guide.f"] - friction)[away].max() < 1e-10 * np.abs(N).max()
    assert np.abs(-run["drive.flange.tau"] - tau)[away].max() < 1e-10 * np.abs(tau).max()
    # the guide force changes its sign four times in a turn without weight
    signs = [event for event in run.events if "load" in str(event)]
    assert len(signs) == (0 if g else 4)


def coasting(J, q, w, g):
    """Angle and speed over the time by scipy, piece by piece between dead centres."""

    def rate(t, y, way):
        slope, bend, tan = geometry(y[0])
        # (J + m s'^2) w' = -(m s'' w^2 + mu |N| way) s', N linear in the acceleration of the slider
        for side in (1, -1):
            k = MU * way * side
            lever = slope * (1 - k * tan / (1 + k * tan))
            push = k * M * g / (1 + k * tan) * slope
            turn = -(lever * M * bend * y[1] ** 2 + push) / (J + lever * M * slope)
            N = (M * g - tan * M * (slope * turn + bend * y[1] ** 2)) / (1 + k * tan)
            if N * side >= 0:
                return [y[1], turn]
        raise AssertionError("no side of the guide bears")

    def dead_centre(t, y, way):
        return geometry(y[0])[0] if t > now + 1e-6 else way

    dead_centre.terminal = True
    now, y, pieces = 0.0, np.array([q, w]), []
    while now < 3.0:
        way = np.sign(geometry(y[0] + 1e-9)[0])
        piece = solve_ivp(
            rate, (now, 3.0), y, "DOP853", args=(way,), events=dead_centre, rtol=1e-11, atol=1e-12
        )
        now, y = piece.t[-1], piece.y[:, -1]
        pieces.append(piece)
    return y, len(pieces)


@pytest.mark.parametrize("g", [0.0, G])
def test_flywheel_coasts_as_by_an_independent_integration(g):
    system = lp.assemble(Rubbing(), keep=["fly.phi", "heat"])
    start = {"fly.phi": 0.3, "fly.w": 10.0}
    run = lp.simulate(system, until=3.0, start=start, parameters={"g": g}, rtol=1e-10)
    (q, w), pieces = coasting(2.0, 0.3, 10.0, g)
    assert abs(run["fly.phi"][-1] - q) < 1e-6
    assert abs(run["fly.w"][-1] - w) < 1e-6
    assert pieces > 8
    energy = run["fly.w"] ** 2 + M / 2 * run["crank.v"] ** 2
    assert np.abs(energy + run["heat"] - energy[0]).max() < 1e-7 * energy[0]
    assert run["heat"][-1] > 1.0


def test_it_comes_to_rest_and_stays():
    system = lp.assemble(Rubbing(), keep=["fly.phi", "heat"])
    start = {"fly.phi": 0.3, "fly.w": 5.0}
    run = lp.simulate(system, until=40.0, start=start, rtol=1e-9)
    energy = start["fly.w"] ** 2 + M / 2 * run["crank.v"][0] ** 2
    assert run.events[-1].after == "stuck"
    assert run["fly.w"][-1] == pytest.approx(0.0, abs=1e-12)
    assert abs(run["heat"][-1] / energy - 1) < 1e-6
    assert np.abs(run["guide.f"][-1]) <= MU * abs(run["crank.guide"][-1])


def test_it_holds_a_body_on_a_slope_up_to_the_friction_angle():
    def moved(slope):
        system = assemble_row(
            weight=translation.Force(f=2.0 * G * np.sin(slope)),
            body=translation.Mass(m=2.0),
            guide=translation.GuideFriction(mu=MU, load=2.0 * G * np.cos(slope)),
        )
        return lp.simulate(system, until=1.0)["body.v"][-1]

    angle = np.arctan(MU)
    assert moved(angle - 1e-6) == 0
    expected = G * (np.sin(angle + 0.1) - MU * np.cos(angle + 0.1))
    assert abs(moved(angle + 0.1) - expected) < 1e-9


@pytest.mark.parametrize("mu", [0.6, 1.0, 2.0])
def test_it_jams_beyond_the_cone_of_friction(mu):
    """Braking grows without limit where ``J (mu |tan(psi)| - 1) = m s'^2`` for a flywheel J."""
    system = assemble_rows(
        *("fly crank", "crank.slider guide.flange_a", "crank.guide guide.load"),
        fly=Inertia(J=2.0, w=5.0),
        crank=CrankSlider(r=R, L=1.1 * R, m=M),
        guide=translation.GuideFriction(mu=mu),
    )
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=1.0, rtol=1e-9, grid=100_000)
    run = caught.value.partial
    slope, tan = (run["crank.v"] / run["fly.w"])[-1], np.tan(run["crank.psi"][-1])
    assert abs(mu * abs(tan) - (1 + M * slope**2 / 2.0)) < 2e-4


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("peak", [1.0, 1.4])
def test_it_breaks_away_where_the_load_has_fallen_enough(side, peak):
    force, m = 3.0, 2.0
    system = assemble_row(
        push=translation.Force(f=force),
        body=translation.Mass(m=m),
        guide=translation.GuideFriction(mu=0.5, peak=peak, load=side * (10.0 - lp.time)),
    )
    run = lp.simulate(system, until=9.0, rtol=1e-10)
    begin = 10 - force / (0.5 * peak)
    assert [event.time for event in run.events] == pytest.approx([begin], rel=1e-9)
    since = np.maximum(run.t - begin, 0)
    expected = ((force - 0.5 * (10 - begin)) * since + 0.25 * since**2) / m
    assert np.abs(run["body.v"] - expected).max() < 1e-8
