"""What is demanded of a start holds in the positions that conditions and holds have there."""

import numpy as np
import pytest
from drives_at_points import Steady
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    BearingFriction,
    Clutch,
    Damper,
    Filter,
    Fixed,
    Inertia,
    Limiter,
    LossyGear,
    Torque,
)
from lumped.ops import where


def filtered(limit=1.0, given=3.0):
    """A signal that fades, a limiter and a lag that shall start steadily."""
    return in_rows(
        "first.y limiter.u",
        "limiter.y lag.u",
        first=Filter(T=1.0, u=0.0, x=given),
        limiter=Limiter(y_min=-limit, y_max=limit),
        lag=Filter(T=0.1),
        initial_equations=lambda m: [lp.der(m.lag.x) == 0],
    )


@pytest.mark.parametrize("given", [-3.0, -0.5, 0.0, 1.0, 3.0])
def test_a_lag_behind_a_limiter_starts_with_what_the_limiter_lets_pass(given):
    point = lp.start_point(lp.assemble(filtered(given=given)))
    assert point["lag.x"] == pytest.approx(np.clip(given, -1.0, 1.0), abs=1e-12)
    assert point.residual <= 1e-9
    assert "what was demanded is met to" in repr(point)


def test_a_run_stays_where_it_starts_steadily():
    run = lp.simulate(lp.assemble(filtered()), until=0.5, grid=10)
    assert run["lag.x"] == pytest.approx(np.ones(11), rel=1e-9)  # 3 exp(-0.5) > 1


def rubbing(torque, characteristic):
    """A body in a bearing with friction, before a damper, that starts steadily."""
    return in_a_row(
        push=Torque(tau=torque),
        body=Steady(J=1.0),
        bearing=BearingFriction(characteristic=characteristic),
        oil=Damper(d=2.0),
        ground=Fixed(),
    )


def test_a_damping_follows_from_a_steady_speed_beside_friction():
    model = rubbing(8.0, ((0.0, 5.0), (100.0, 15.0)))
    point = lp.start_point(lp.assemble(model), start={"body.w": 10.0}, free=["oil.d"])
    assert point.parameters["oil.d"] == pytest.approx((8.0 - 6.0) / 10.0, rel=1e-12)
    assert point["body.a"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("torque", "speed"), [(3.0, 0.0), (-3.0, 0.0), (8.0, 1.5), (-8.0, -1.5)])
def test_a_body_with_friction_starts_steadily_at_rest_or_sliding(torque, speed):
    # 5 N.m of friction; what is left turns a damper of 2 N.m.s/rad
    point = lp.start_point(lp.assemble(rubbing(torque, ((0.0, 5.0),))))
    assert point["body.w"] == pytest.approx(speed, abs=1e-12)
    assert point["body.a"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("w", [10.0, -10.0])
def test_behind_a_slipping_clutch_a_body_starts_at_its_steady_speed(w):
    model = in_a_row(
        a=Inertia(J=1.0, w=w),
        slip=Clutch(f_max=20.0, u=1.0, characteristic=((0.0, 0.5),)),
        b=Steady(J=1.0),
        oil=Damper(d=2.0),
        ground=Fixed(),
    )
    point = lp.start_point(lp.assemble(model))
    # it carries mu f_n = 0.5 * 20 N.m, which the damper takes
    assert point["b.w"] == pytest.approx(np.sign(w) * 10.0 / 2.0, rel=1e-12)
    assert point["b.a"] == pytest.approx(0.0, abs=1e-12)
    assert point["slip.position"] == -np.sign(w)


@pytest.mark.parametrize(("w", "torque"), [(10.0, 16.0), (-10.0, 25.0)])
def test_a_lossy_gear_starts_with_the_losses_of_its_direction(w, torque):
    # forward the motor drives: tau_b = 2 * 10 * 0.8; backward the load does: 2 * 10 / 0.8
    model = in_a_row(
        push=Torque(tau=10.0),
        a=Inertia(J=1.0, w=w),
        gear=LossyGear(ratio=2.0, losses=((0.0, 0.8, 0.8, 0.0, 0.0),)),
        b=Steady(J=1.0),
        load=Torque(tau=-1.0),
    )
    point = lp.start_point(lp.assemble(model), free=["load.tau"])
    assert point.parameters["load.tau"] == pytest.approx(-torque, rel=1e-12)


# -- where positions do not settle at once -----------------------------------------------------


class Kinked(lp.Component):
    """State x with a continuous law of three straight pieces: y = f(x)."""

    x: lp.Var = lp.var("1", "state")
    y: lp.Var = lp.var("1", "value")

    def equations(self):
        x = self.x
        yield lp.der(x) == -x
        steep = where(x > 1.0, 0.1 * (x - 1.0) + 5.0, 5.0 * x)
        yield self.y == where(x < -1.0, 0.1 * (x + 1.0) - 5.0, steep)


@pytest.mark.parametrize("wanted", [-5.05, -5.0, -4.0, 0.0, 4.9, 5.0, 5.3])
@pytest.mark.parametrize("begin", [-30.0, 0.0, 30.0])
def test_a_law_of_straight_pieces_is_met_from_everywhere(wanted, begin):
    class Begun(Kinked):
        x: lp.Var = lp.var("1", "state", begin)

    point = lp.start_point(lp.assemble(lp.compose(law=Begun())), start={"law.y": wanted})
    inside = wanted / 5.0
    outside = np.sign(wanted) * (1.0 + 10.0 * (abs(wanted) - 5.0))
    expected = inside if abs(wanted) <= 5.0 else outside
    assert point["law.x"] == pytest.approx(expected, rel=1e-9, abs=1e-12)


class Tooth(Kinked):
    """A law whose pieces send the search to and fro: steep to the left, flat to the right."""

    def equations(self):
        x = self.x
        yield lp.der(x) == -x
        yield self.y == where(x < 0.0, x * 10.0, where(x < 1.0, 0.05 * x, 4.0 * x - 3.95))


def test_a_search_whose_positions_come_again_is_shortened():
    point = lp.start_point(lp.assemble(lp.compose(law=Tooth())), start={"law.y": 1.0})
    assert point["law.x"] == pytest.approx(4.95 / 4.0, rel=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_random_laws_of_straight_pieces_are_met(seed):
    # rising, with a flat piece in some; the expected place by interpolation
    rng = np.random.default_rng(seed)
    places = np.sort(rng.uniform(-3.0, 3.0, 6))
    slopes = rng.choice([0.02, 0.1, 1.0, 5.0, 50.0], 7)
    flat = seed % 3 == 0
    if flat:
        slopes[3] = 0.0
    far = np.concatenate([[places[0] - 10.0], places, [places[-1] + 10.0]])
    heights = np.concatenate([[0.0], np.cumsum(slopes * np.diff(far))])
    x, begin = rng.uniform(far[0], far[-1]), rng.uniform(far[0], far[-1])
    if flat:
        begin = 0.5 * (places[2] + places[3])
        x = places[0] - 1.0 if seed % 2 else places[-1] + 1.0

    class Law(lp.Component):
        x: lp.Var = lp.var("1", "state", float(begin))
        y: lp.Var = lp.var("1", "value")

        def equations(self):
            yield lp.der(self.x) == -self.x
            law = heights[0] + slopes[0] * (self.x - far[0])
            for place, height, slope in zip(places, heights[1:-1], slopes[1:], strict=True):
                law = where(self.x >= place, height + slope * (self.x - place), law)
            yield self.y == law

    wanted = float(np.interp(x, far, heights))
    point = lp.start_point(lp.assemble(lp.compose(law=Law())), start={"law.y": wanted})
    assert point["law.x"] == pytest.approx(x, rel=1e-6, abs=1e-6)


# -- derivatives -------------------------------------------------------------------------------


def test_derivatives_of_a_start_are_those_of_the_positions_that_hold():
    # the lag starts at the limit, not at what is before the limiter
    system = lp.assemble(filtered())
    by = {}
    for name in ("limiter.y_max", "first.x"):
        found = lp.sensitivity(system, of=["lag.x"], by=[name], until=0.5, grid=1)
        by[name] = found.derivatives[:, 0, 0]
    assert by["limiter.y_max"] == pytest.approx([1.0, 1.0], rel=1e-6)
    assert by["first.x"] == pytest.approx([0.0, 0.0], abs=1e-9)
    of = [lp.functionals.final("lag.x")]
    found = lp.gradient(system, of=of, by=["limiter.y_max", "first.x"], until=0.5)
    assert found.derivatives[0] == pytest.approx([1.0, 0.0], abs=1e-6)
