"""Start points of trains of which all parts move together."""

import numpy as np
import pytest
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    Belt,
    Capacitor,
    Damper,
    ElasticPlanetary,
    ElastoBacklash,
    Fixed,
    Ground,
    IdealGear,
    Inertia,
    Resistor,
    Spring,
    SpringDamper,
    VoltageSource,
)
from lumped.errors import StartError


def train(**given):
    """Motor, six elastic shafts with wheels, a gear that reverses, a play and a load."""
    return in_rows(
        "motor shaft/wheel gear play load",
        motor=Inertia(J=0.5),
        shaft=[SpringDamper(c=1e3 * (i + 1), d=1.0) for i in range(6)],
        wheel=[Inertia(J=1.0 + i) for i in range(6)],
        gear=IdealGear(ratio=-4.0),
        play=ElastoBacklash(c=1e4, d=2.0, b=0.01),
        load=Inertia(J=3.0),
    ).with_(given)


@pytest.mark.parametrize(("name", "value"), [("motor.w", 100.0), ("load.w", -25.0)])
def test_one_given_speed_turns_a_whole_train(name, value):
    system = lp.assemble(train())
    point = lp.start_point(system, start={name: value}, together=True)
    run = lp.simulate(system, until=0.5, start=point, grid=5)
    for wheel in ("motor", *(f"wheel[{i}]" for i in range(6))):
        assert run[f"{wheel}.w"] == pytest.approx(np.full(6, 100.0), rel=1e-9)
    assert run["load.w"] == pytest.approx(np.full(6, -25.0), rel=1e-9)
    assert np.abs(run["shaft[3].tau"]).max() < 1e-6
    assert run.events == ()
    alone = lp.start_point(system, start={name: value})  # else the rest stands still
    assert alone["wheel[2].w"] == 0.0


def test_a_train_that_moves_together_keeps_a_given_twist_and_refuses_two_speeds():
    system = lp.assemble(train(**{"shaft[1].phi_rel": 0.02}))
    point = lp.start_point(system, start={"motor.w": 100.0}, together=True)
    assert [point["shaft[1].phi_rel"], point["wheel[5].w"]] == pytest.approx([0.02, 100.0])
    both = {"motor.w": 100.0, "wheel[2].w": 5.0}
    with pytest.raises(StartError, match=r"at rest \(together=True\).*motor\.w = 100"):
        lp.start_point(system, start=both, together=True)
    alike = lp.start_point(system, start={"motor.w": 8.0, "load.w": -2.0}, together=True)
    assert alike["wheel[4].w"] == pytest.approx(8.0, rel=1e-12)


def test_what_only_a_damper_joins_moves_as_it_is_told():
    model = in_a_row(
        motor=Inertia(J=0.5),
        fluid=Damper(d=2.0),
        fan=Inertia(J=1.0),
        shaft=Spring(c=10.0),
        rotor=Inertia(J=1.0),
    )
    start = {"motor.w": 100.0, "rotor.w": 60.0}
    point = lp.start_point(lp.assemble(model), start=start, together=True)
    received = [point[n] for n in ("motor.w", "fan.w", "rotor.w")]
    assert received == pytest.approx([100.0, 60.0, 60.0], rel=1e-12)


def test_one_given_speed_turns_what_stretches_in_metres_too():
    """A belt turns its pulleys as the radii say, a planetary set its carrier as the teeth."""
    belt = {"r_a": 0.1, "r_b": 0.25, "EA": 1e5, "distance": 1.0, "F_0": 1e3}
    mesh = {"ratio": 2.0, "n": 3, "r_s": 0.05, "c_s": 1e8, "c_r": 1e8, "J_p": 1e-3}
    model = in_rows(
        "motor belt pulley set.sun",
        "set.carrier load",
        "set.ring housing",
        motor=Inertia(J=0.1),
        belt=Belt(**belt),
        pulley=Inertia(J=0.5),
        set=ElasticPlanetary(**mesh),
        load=Inertia(J=3.0),
        housing=Fixed(),
    )
    point = lp.start_point(lp.assemble(model), start={"motor.w": 30.0}, together=True)
    received = [point[n] for n in ("pulley.w", "load.w")]
    pulley = 30.0 * belt["r_a"] / belt["r_b"]
    assert received == pytest.approx([pulley, pulley / (1 + mesh["ratio"])], rel=1e-9)


def test_a_train_that_moves_together_charges_no_capacitor():
    model = in_rows(
        "source.p before.p",
        "before.n store.p",
        "store.n after.p",
        "after.n source.n ground.pin",
        source=VoltageSource(v=6.0),
        before=Resistor(R=1.0),
        store=Capacitor(C=1.0),
        after=Resistor(R=2.0),
        ground=Ground(),
    )
    point = lp.start_point(lp.assemble(model), together=True)
    assert [point["store.v"], point["store.i"]] == pytest.approx([0.0, 6.0 / 3.0], abs=1e-12)
