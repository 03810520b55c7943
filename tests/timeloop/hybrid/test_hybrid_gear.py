"""Conditions on parameters only; systems without states; frictions that share a load."""

import numpy as np
import pytest
from rows import in_a_row
from scipy.optimize import brentq

import lumped as lp
from lumped.components import BearingFriction, Inertia, LossyGear, Position, Speed, Torque


class Chooser(lp.Component):
    """Rates that tell whether conditions on a parameter hold."""

    k: lp.Param = lp.param("1", "what is compared", 1.0)
    above: lp.Var = lp.var("1", "grows while k > 1")
    least: lp.Var = lp.var("1", "grows while k >= 1")

    def equations(self):
        yield lp.der(self.above) == lp.ops.where(self.k > 1, 1, 0)
        yield lp.der(self.least) == lp.ops.where(self.k >= 1, 1, 0)


@pytest.mark.parametrize(("k", "expected"), [(0.5, (0, 0)), (1.0, (0, 1)), (2.0, (1, 1))])
def test_a_strict_condition_on_a_parameter_is_false_at_equality(k, expected):
    run = lp.simulate(lp.assemble(Chooser()), until=1.0, parameters={"k": k})
    received = (run["above"][-1], run["least"][-1])
    assert received == pytest.approx(expected, abs=1e-12)


ETA, BEARING, RATIO, FRICTION = (0.9, 0.8), (0.5, 0.7), 3.0, 5.0
DRIVE, LOAD = (20.0, 2.0), (90.0, 3.0)


def sine(amplitude, frequency):
    return amplitude * lp.ops.sin(2 * lp.ops.pi * frequency * lp.time)


class GearAndBearing(lp.Component):
    """A lossy gear and a bearing friction hold one rigid shaft together."""

    drive: Torque = Torque(tau=sine(*DRIVE))
    motor: Inertia = Inertia(J=0.05)
    gear: LossyGear = LossyGear(ratio=RATIO, losses=[(0.0, *ETA, *BEARING)])
    bearing: BearingFriction = BearingFriction(characteristic=((0.0, FRICTION),))
    mass: Inertia = Inertia(J=2.0)
    load: Torque = Torque(tau=sine(*LOAD))

    def connections(self):
        yield from lp.chain(self.drive, self.motor, self.gear, self.bearing, self.mass, self.load)


def test_two_frictions_on_a_rigid_shaft_break_away_where_their_sum_is_reached():
    system = lp.assemble(GearAndBearing())
    run = lp.simulate(system, until=0.01, rtol=1e-9)

    def excess(t):
        """Torque at b beyond both frictions if the shaft began to turn forward."""
        at_a = DRIVE[0] * np.sin(2 * np.pi * DRIVE[1] * t)
        driving = (1 - ETA[0]) * at_a + BEARING[0], (1 - 1 / ETA[1]) * at_a + BEARING[1]
        at_b = LOAD[0] * np.sin(2 * np.pi * LOAD[1] * t)
        return RATIO * (at_a - max(driving)) + at_b - FRICTION

    expected = brentq(excess, 1e-4, 0.01, xtol=1e-14)
    received = max(event.time for event in run.events if event.before == "stuck")
    # limits of frictions that share a load count to 1e-7 of the load
    assert received == pytest.approx(expected, rel=1e-6)
    assert np.abs(run["mass.w"][run.t < expected]).max() < 1e-9
    assert run["mass.w"][-1] > 0


# -- systems without states --------------------------------------------------------------------


@pytest.mark.parametrize(
    "source",
    [
        Position(phi=lp.ops.sin(lp.time)),
        Speed(w=lp.ops.cos(lp.time)),
        Speed(w=-lp.ops.sin(lp.time)),
    ],
    ids=["position", "speed", "speed from rest"],
)
def test_friction_reverses_with_a_prescribed_motion(source):
    model = in_a_row(source=source, bearing=BearingFriction(characteristic=((0.0, FRICTION),)))
    run = lp.simulate(lp.assemble(model), until=10.0, grid=1000)
    w = run["bearing.w"]
    moving = np.abs(w) > 1e-3
    assert run["bearing.tau"][moving] == pytest.approx(FRICTION * np.sign(w[moving]))
