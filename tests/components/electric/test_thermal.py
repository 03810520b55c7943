"""Heat: conduction in closed form, and losses that arrive where they are led."""

import re
from pathlib import Path

import numpy as np
import pytest
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    FixedTemperature,
    HeatCapacitor,
    Heated,
    HeatFlow,
    Inertia,
    ThermalConductor,
)
from lumped.errors import ConnectError, DeclarationError


class HotDamper(Heated, Damper):
    """Damper that warms its oil."""


def test_two_bodies_share_their_heat():
    c, g = (2.0, 3.0), 0.5
    system = assemble_rows(
        *("hot.port wall.port_a", "wall.port_b cold.port"),
        hot=HeatCapacitor(C=c[0], T=400.0),
        wall=ThermalConductor(G=g),
        cold=HeatCapacitor(C=c[1], T=300.0),
    )
    run = lp.simulate(system, until=10.0, rtol=1e-9)
    mean = (c[0] * 400 + c[1] * 300) / sum(c)
    fading = 100 * np.exp(-g * (1 / c[0] + 1 / c[1]) * run.t)
    assert run["hot.T"] == pytest.approx(mean + c[1] / sum(c) * fading, rel=1e-9)
    assert run["cold.T"] == pytest.approx(mean - c[0] / sum(c) * fading, rel=1e-9)


def test_a_heated_body_approaches_the_temperature_at_which_it_loses_as_much():
    system = assemble_rows(
        *("source.port body.port cooling.port_a", "cooling.port_b air.port"),
        source=HeatFlow(Q=20.0),
        body=HeatCapacitor(C=4.0),
        cooling=ThermalConductor(G=0.8),
        air=FixedTemperature(T=280.0),
    )
    run = lp.simulate(system, until=30.0, rtol=1e-9, start={"body.T": 280.0})
    expected = 280.0 + 20.0 / 0.8 * (1 - np.exp(-0.8 / 4.0 * run.t))
    assert run["body.T"] == pytest.approx(expected, rel=1e-9)


def test_a_heated_part_asks_for_a_place_for_its_heat():
    model = in_a_row(body=Inertia(J=1.0), brake=HotDamper(d=1.0), wall=Fixed())
    with pytest.raises(ConnectError, match=r"brake\.heat"):
        lp.assemble(model)


def test_the_page_on_heat_shows_a_model_that_warms_its_oil_by_all_of_its_energy():
    page = Path(__file__).parents[3] / "docs" / "elements" / "heat.md"
    (code,) = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    exec(compile(code, page.name, "exec"), names)
    received = names["run"]["oil.T"][-1]
    expected = 293.15 + 0.5 * 10.0**2 / 2 / 7.0
    assert received == pytest.approx(expected, abs=1e-4)


def test_a_component_that_tells_no_loss_is_not_heated():
    class HotBody(Heated, Inertia):
        """A body, which loses nothing."""

    model = lp.compose(
        body=HotBody(J=1.0),
        air=FixedTemperature(T=280.0),
        connections=lambda m: [lp.connect(m.body.heat, m.air.port)],
    )
    with pytest.raises(DeclarationError, match="HotBody: Heated needs a component with a method"):
        lp.assemble(model)
