"""Heat: conduction in closed form, and losses that arrive where they are led."""

import re
from pathlib import Path

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import (
    Clutch,
    Damper,
    EfficientGear,
    Fixed,
    FixedTemperature,
    HeatCapacitor,
    Heated,
    HeatFlow,
    Inertia,
    SlipCoupling,
    SpringDamper,
    ThermalConductor,
)
from lumped.errors import ConnectError


class HotDamper(Heated, Damper):
    """Damper that warms its oil."""


class HotShaft(Heated, SpringDamper):
    """Shaft that warms up."""


class HotGear(Heated, EfficientGear):
    """Gear that warms its oil."""


class HotClutch(Heated, Clutch):
    """Clutch that warms its faces."""


class HotCoupling(Heated, SlipCoupling):
    """Coupling that warms up while it slips."""


def test_two_bodies_share_their_heat():
    c, g = (2.0, 3.0), 0.5
    model = lp.compose(
        hot=HeatCapacitor(C=c[0], T=400.0),
        wall=ThermalConductor(G=g),
        cold=HeatCapacitor(C=c[1], T=300.0),
        connections=lambda m: [
            lp.connect(m.hot.port, m.wall.port_a),
            lp.connect(m.wall.port_b, m.cold.port),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=10.0, rtol=1e-9)
    mean = (c[0] * 400 + c[1] * 300) / sum(c)
    fading = 100 * np.exp(-g * (1 / c[0] + 1 / c[1]) * run.t)
    assert run["hot.T"] == pytest.approx(mean + c[1] / sum(c) * fading, rel=1e-9)
    assert run["cold.T"] == pytest.approx(mean - c[0] / sum(c) * fading, rel=1e-9)


def test_a_heated_body_approaches_the_temperature_at_which_it_loses_as_much():
    model = lp.compose(
        source=HeatFlow(Q=20.0),
        body=HeatCapacitor(C=4.0),
        cooling=ThermalConductor(G=0.8),
        air=FixedTemperature(T=280.0),
        connections=lambda m: [
            lp.connect(m.source.port, m.body.port, m.cooling.port_a),
            lp.connect(m.cooling.port_b, m.air.port),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=30.0, rtol=1e-9, start={"body.T": 280.0})
    expected = 280.0 + 20.0 / 0.8 * (1 - np.exp(-0.8 / 4.0 * run.t))
    assert run["body.T"] == pytest.approx(expected, rel=1e-9)


ROTATING = [
    HotDamper(d=2.0),
    HotShaft(c=30.0, d=0.4),
    HotClutch(f_max=6.0, u=1.0),
    HotCoupling(kinetic=3.0, static=4.0, u=1.0),
]


@pytest.mark.parametrize("part", ROTATING, ids=lambda part: type(part).__name__)
def test_energy_that_motion_loses_arrives_as_heat(part):
    model = lp.compose(
        body=Inertia(J=0.5, w=10.0),
        part=part,
        wall=Fixed(),
        oil=HeatCapacitor(C=7.0),
        connections=lambda m: [
            *lp.chain(m.body, m.part, m.wall),
            lp.connect(m.part.heat, m.oil.port),
        ],
    )
    run = lp.simulate(lp.assemble(model, keep=["oil.T"]), until=3.0, rtol=1e-10)
    heat = 7.0 * (run["oil.T"] - 293.15)
    stored = 0.5 * run["body.w"] ** 2 / 2
    if isinstance(part, HotShaft):
        stored = stored + 30.0 * run["part.phi_rel"] ** 2 / 2
    assert heat[-1] > 10.0
    assert heat + stored == pytest.approx(25.0, abs=1e-6 * 25.0)


def test_a_gear_that_is_hot_warms_what_its_heat_is_led_to():
    model = lp.compose(
        a=Inertia(J=1.0, w=20.0),
        gear=HotGear(ratio=2.0, eta=0.8),
        b=Inertia(J=3.0),
        brake=Damper(d=4.0),
        wall=Fixed(),
        oil=HeatCapacitor(C=2.0),
        connections=lambda m: [
            *lp.chain(m.a, m.gear, m.b, m.brake, m.wall),
            lp.connect(m.gear.heat, m.oil.port),
        ],
    )
    run = lp.simulate(lp.assemble(model, keep=["oil.T"]), until=8.0, rtol=1e-10)
    # side a drives throughout: J_a a_a = -tau, J_b a_b = 0.8 * 2 tau - 4 w_b, a_a = 2 a_b
    rate = 4.0 / (3.0 + 2 * 0.8 * 2 * 1.0)
    assert run["b.w"] == pytest.approx(10.0 * np.exp(-rate * run.t), rel=1e-8)
    # tau = 2 rate w_b, of which a fifth is lost at the speed 2 w_b
    expected = 0.2 * 2 * rate * 2 * 10.0**2 / (2 * rate) * (1 - np.exp(-2 * rate * run.t))
    assert 2.0 * (run["oil.T"] - 293.15) == pytest.approx(expected, abs=1e-6 * expected[-1])


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
