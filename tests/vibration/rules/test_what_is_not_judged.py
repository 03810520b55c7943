"""What a verdict does not cover: orders that nobody named, means without balance."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.errors import OptionError, UnitError
from lumped.vibration import Limit

J, C, D = (2.0, 3.0), 1.2e5, 5.0
HERTZ = np.sqrt(C * (1 / J[0] + 1 / J[1])) / (2 * np.pi)


class Ripple(lp.Component):
    """Torque over the angle of a shaft: a mean, and one part of 15 periods a turn."""

    flange = lp.Flange()
    mean: lp.Param = lp.param("N.m", "mean torque", 0.0)

    def equations(self):
        yield self.flange.tau == -self.mean - lp.ops.cos(15 * self.flange.phi)


def respond(speeds, mean=0.0, **options):
    """Two inertias on a shaft, the first one shaken by the ripple."""

    def connections(m):
        yield from lp.chain(m.ripple, m.a, m.shaft, m.b, m.load)

    model = lp.compose(
        ripple=Ripple(mean=mean),
        a=Inertia(J=J[0]),
        shaft=SpringDamper(c=C, d=D),
        b=Inertia(J=J[1]),
        load=Torque(tau=0.0),
        connections=connections,
    )
    options = {"shaft": "a.phi", "of": ["shaft.tau"]} | options
    return lp.vibration.order_response(lp.assemble(model), speeds=speeds, **options)


def test_orders_that_nobody_named_are_told_where_they_meet_a_natural_frequency():
    speeds = 2 * np.pi * HERTZ / np.array([16.5, 14.5])  # only orders 15 and 16 meet it
    (note,) = lp.vibration.verdict(respond(speeds), [Limit("shaft.tau", 1.0)]).notes
    assert "orders above 12 were not computed" in note
    assert f"from order 15 on they meet natural frequencies ({HERTZ:.4g} Hz)" in note
    named = lp.vibration.verdict(respond(speeds, orders=[15]), [Limit("shaft.tau", 1.0)])
    assert named.notes == ()
    stiffness = C + 1j * D * 2 * np.pi * HERTZ
    moved = (2 * np.pi * HERTZ) ** 2 - stiffness * (1 / J[0] + 1 / J[1])
    assert named.results[0].value == pytest.approx(abs(stiffness / moved / J[0]), rel=1e-4)
    away = 2 * np.pi * HERTZ / np.array([11.8, 11.6])
    assert respond(away).notes == ()


def test_means_are_judged_only_where_mean_torques_balance():
    limit = Limit("shaft.tau", 1e3, measure="with mean")
    speeds = np.array([10.0, 12.0])
    with pytest.raises(OptionError, match=r"mean torques do not balance.*free="):
        lp.vibration.verdict(respond(speeds, mean=100.0, orders=[15]), [limit])
    balanced = respond(speeds, mean=100.0, orders=[15], free="load.tau")
    (result,) = lp.vibration.verdict(balanced, [limit]).results
    assert result.value == pytest.approx(100.0 + balanced.magnitude("shaft.tau", 15).max())
    still = lp.vibration.verdict(respond(speeds, orders=[15]), [limit])
    assert still.results[0].value == pytest.approx(balanced.magnitude("shaft.tau", 15).max())


def test_measures_and_speeds_that_make_no_sense_are_refused():
    with pytest.raises(OptionError, match="measure = 'peak'; one of maximum"):
        Limit("shaft.tau", 1.0, measure="peak")
    with pytest.raises(UnitError, match="speeds = '5 m'"):
        Limit("shaft.tau", 1.0, speeds=("5 m", "6 m"))
    assert Limit("shaft.tau", 1.0, speeds=("30 rpm", 10.0)).ends == pytest.approx((np.pi, 10.0))
    response = respond(np.array([10.0, 12.0]), orders=[15])
    with pytest.raises(OptionError, match=r"a quantity in W, not N\.m"):
        lp.vibration.verdict(response, [Limit("shaft.tau", 1.0, measure="mean power")])
