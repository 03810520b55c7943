"""Derivatives of damage: closed forms, differences of streamed counts, and where there is none."""

import numpy as np
import pytest
from checks import by_complex_step, worst
from ensemble_runs import CURVE, drive, states
from rows import assemble_row, in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.errors import SolverError
from lumped.gradients.readings.turning_points import damage_slopes
from lumped.life import SNCurve, fkm, goodman
from lumped.ops import sin, where

SLOPE = 5.0
STEEP = SNCurve(1.0, 1e4, SLOPE, unit="1")


def share(range_):
    """Half a cycle of a range, which may be complex."""
    return 0.5e-4 * (0.5 * range_ * np.sign(np.real(range_))) ** SLOPE


def decaying(c, d, J, phi, until):
    """Damage of the angle of a body on a spring and a damper that is let go."""
    decay = d / (2 * J)
    rate = np.sqrt(c / J - decay**2)
    turns = int(np.real(rate) * np.real(until) / np.pi)
    points = phi * (-np.exp(-decay * np.pi / rate)) ** np.arange(turns + 1)
    wave = np.cos(rate * until) + decay / rate * np.sin(rate * until)
    points = np.append(points, phi * np.exp(-decay * until) * wave)
    return share(np.diff(points)).sum()


def test_a_free_vibration_that_decays():
    model = in_a_row(wall=Fixed(), shaft=SpringDamper(c=100.0, d=0.5), body=Inertia(J=1.0))
    system, damage = lp.assemble(model), fun.damage("body.phi", STEEP)
    values, until = np.array([100.0, 0.5, 1.0, 2.0]), 3.0
    names = ["shaft.c", "shaft.d", "body.J", "body.phi"]
    start = {"body.phi": 2.0, "body.w": 0.0}
    expected = by_complex_step(decaying, [*values, until])
    options = {"of": [damage], "until": until, "start": start, "rtol": 1e-8}
    found = lp.gradient(system, by=[*names, "until"], **options)
    error = np.abs(found.derivatives[0] / expected - 1).max()
    forward = lp.sensitivity(system, by=names, **options)
    apart = max(abs(forward[damage, n] / v - 1) for n, v in zip(names, expected[:4], strict=True))
    assert found.values[0] == pytest.approx(decaying(*values, until), rel=1e-8)
    assert max(error, apart) < 1e-7


@pytest.mark.parametrize(("kind", "seed"), [("hybrid", 707), ("hybrid", 710), ("smooth", 2100)])
@pytest.mark.parametrize("mean_stress", [None, fkm(0.3)])
def test_random_drives_against_differences_of_streamed_counts(kind, seed, mean_stress):
    system, until, varied, _ = drive(kind, seed)
    damage = fun.damage(states(system)[0], CURVE, mean_stress=mean_stress)
    own = np.array([system.parameters[name] for name in varied])
    found = lp.gradient(system, of=[damage], by=varied, until=until)
    away = np.array([1.0, -1.0, 0.5, -0.5]) * 1e-5
    points = (own * (1 + away[:, None, None] * np.identity(len(own)))).reshape(-1, len(own))
    over = lp.ensembles.paired(dict(zip(varied, points.T, strict=True)))
    counted = lp.ensemble(system, over=over, until=until, of=[damage], rtol=1e-11)
    v = counted.values.reshape(4, -1)
    wide, narrow = (v[0] - v[1]) / 2e-5, (v[2] - v[3]) / 1e-5
    expected = (4 * narrow - wide) / 3
    assert worst(found.derivatives[0] * own, expected) < 1e-6


# -- where the count swaps -------------------------------------------------------------------------


class Crests(lp.Component):
    """Two crests between troughs of other depths: ``0, p, -1, q, -3``."""

    p: lp.Param = lp.param("1", "first crest", 2.0)
    q: lp.Param = lp.param("1", "second crest", 2.0)
    x: lp.Var = lp.var("1", "a state", 1.0, state="always")
    y: lp.Var = lp.var("1", "load")

    def equations(self):
        yield lp.der(self.x) == -self.x
        rise = sin(np.pi * lp.time / 2) ** 2
        low = where(lp.time >= 1.0, -1.0, 0.0)
        later = where(lp.time >= 3.0, -3.0, -1.0)
        first = low + (self.p - low) * rise
        second = later + (self.q - later) * rise
        yield self.y == where(lp.time >= 2.0, second, first)


def slope(range_):
    """Derivative of the damage of half a cycle by its range."""
    return SLOPE * share(range_) / range_


def test_at_a_swap_there_are_derivatives_to_both_sides_only():
    system, damage = lp.assemble(Crests()), fun.damage("y", STEEP)
    options = {"of": [damage], "by": ["p", "q"], "until": 4.0}
    for p, q in ((1.9, 2.0), (2.0, 1.9)):
        found = lp.gradient(system, **options, parameters={"p": p, "q": q})
        if p < q:
            expected = slope(p) + slope(p + 1), slope(q + 1) + slope(q + 3)
        else:
            expected = slope(p) + slope(p + 3), 2 * slope(q + 1)
        np.testing.assert_allclose(found.derivatives[0], expected, rtol=1e-6)
    with pytest.raises(SolverError, match=r"by p, q \(cycles of the same range"):
        lp.gradient(system, **options)
    found = lp.sensitivity(system, **options, side="right")
    assert found[damage, "p"] == pytest.approx(slope(2.0) + slope(5.0), rel=1e-6)
    assert found[damage, "q"] == pytest.approx(slope(3.0) + slope(5.0), rel=1e-6)


def test_a_cycle_at_the_end_of_a_law_is_told():
    law = SNCurve(1.0, 1e4, 5.0, "original", unit="1").law()
    for top, ways in ((1.9, 1), (2.0, 2), (2.1, 1)):
        damage, slopes = damage_slopes(np.array([0.0, top, 0.5]), law, 1e-9)
        assert len(slopes) == ways
        assert damage == pytest.approx(share(top) if top >= 2 else 0.0)


def test_equal_cycles_are_no_swap():
    values = np.tile([1.0, -1.0], 20)
    rounded = values * (1 + 1e-13 * np.random.default_rng(1).normal(size=40))
    _, slopes = damage_slopes(rounded, STEEP.law(), 1e-8)
    assert len(slopes) == 1
    inner = 2 * slope(2.0) * np.sign(values)
    np.testing.assert_allclose(slopes[0, 1:-1], inner[1:-1], rtol=1e-9)


# -- in a search -----------------------------------------------------------------------------------


def test_the_largest_torque_that_a_shaft_bears():
    """A body swings about the torque by a step: half cycles ``0, 2 tau, 0, ...`` of the shaft."""
    system = assemble_row(
        wall=Fixed(),
        shaft=SpringDamper(c=400.0, d=0.0),
        body=Inertia(J=1.0, phi=0.0, w=0.0),
        motor=Torque(tau=1.0),
    )
    until, allowed = 2.0, 0.02
    rule = goodman(1e9)
    damage = fun.damage("shaft.tau", STEEP, scale=0.3, mean_stress=rule)
    found = lp.optimise(
        system,
        minimise={"motor.tau": -1.0},
        vary={"motor.tau": (1.0, 50.0)},
        subject_to=damage <= allowed,
        until=until,
    )
    turns = int(20 * until / np.pi)
    last = 1 - (-1) ** turns
    rest = abs(1 - np.cos(20 * until) - last) / 2
    expected = (allowed / (share(2.0) * (turns + rest**SLOPE))) ** (1 / SLOPE) / 0.3
    print(found)
    assert found.parameters["motor.tau"] == pytest.approx(expected, rel=1e-5)
