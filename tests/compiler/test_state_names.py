"""States have the sign of the quantities after which they are named."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia


class Coil(lp.Component):
    """Resistor and inductor, ``v_a - v_b = R i + L der(i)``, with the current from a to b."""

    a = lp.Pin()
    b = lp.Pin()
    R: lp.Param = lp.param("Ohm", "resistance", 1.0)
    L: lp.Param = lp.param("H", "inductance", 1.0)
    i: lp.Var = lp.var("A", "current")

    def equations(self):
        yield self.a.i == self.i
        yield self.b.i == -self.i
        yield self.a.v - self.b.v == self.R * self.i + self.L * lp.der(self.i)


class Terminal(lp.Component):
    """Given voltage: ``v = V``."""

    pin = lp.Pin()
    V: lp.Param = lp.param("V", "voltage")

    def equations(self):
        yield self.pin.v == self.V


@pytest.mark.parametrize("first", ["source", "ground", "coil"])
@pytest.mark.parametrize("begin", [0.0, 5.0])
def test_a_current_has_its_sign_in_whatever_order_parts_are_named(first, begin):
    parts = {"source": Terminal(V=10.0), "ground": Terminal(V=0.0), "coil": Coil()}
    parts = {first: parts[first]} | parts
    model = lp.compose(
        **parts,
        connections=lambda m: [
            lp.connect(m.source.pin, m.coil.a),
            lp.connect(m.coil.b, m.ground.pin),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=1.0, start={"coil.i": begin}, rtol=1e-10)
    expected = 10 + (begin - 10) * np.exp(-run.t)
    assert run["coil.i"] == pytest.approx(expected, abs=1e-8)
    assert run.point(1.0)["coil.i"] == pytest.approx(expected[-1], abs=1e-8)


class Against(lp.Component):
    """Speed that is told with the other sign: ``w_back = -der(phi)``."""

    flange = lp.Flange()
    w_back: lp.Var = lp.var("rad/s", "speed backwards", state="always")

    def equations(self):
        yield self.w_back == -lp.der(self.flange.phi)
        yield self.flange.tau == 0


def test_a_speed_told_backwards_is_that_of_its_states():
    model = lp.compose(
        told=Against(),
        body=Inertia(J=1.0),
        connections=lambda m: [lp.connect(m.told.flange, m.body.flange_a)],
    )
    system = lp.assemble(model, keep=["body.phi", "told.w_back"])
    run = lp.simulate(system, until=1.0, start={"told.w_back": 2.0})
    assert run["told.w_back"][-1] == pytest.approx(2.0, abs=1e-12)
    assert run["body.w"][-1] == pytest.approx(-2.0, abs=1e-12)
    assert run["body.phi"][-1] == pytest.approx(-2.0, abs=1e-9)
