"""Start points of trains of which all parts move together."""

import numpy as np
import pytest
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    Backlash,
    BearingFriction,
    Belt,
    Brake,
    Capacitor,
    Clutch,
    Coupling,
    Damper,
    EfficientGear,
    ElasticPlanetary,
    ElastoBacklash,
    Fixed,
    Ground,
    IdealGear,
    Inertia,
    OneWayClutch,
    Planetary,
    Resistor,
    SelectableGear,
    Spring,
    SpringDamper,
    Synchroniser,
    Torque,
    Tyre,
    VoltageSource,
    translation,
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


def clutched(**given):
    """A motor, a pressed clutch, an elastic shaft with bearing, a pressed clutch and a load."""
    return in_rows(
        "motor first hub shaft wheel bearing.flange_a",
        "wheel second load",
        motor=Inertia(J=0.4),
        first=Clutch(f_max=1e4, u=1.0),
        hub=Inertia(J=0.1),
        shaft=SpringDamper(c=1e3, d=1.0),
        wheel=Inertia(J=1.2),
        bearing=BearingFriction(characteristic=((0.0, 1.0),)),
        second=Clutch(f_max=1e4, u=1.0),
        load=Inertia(J=1.0),
    ).with_(given)


@pytest.mark.parametrize("name", ["motor.w", "hub.w", "wheel.w", "load.w"])
def test_one_given_speed_turns_a_train_with_pressed_clutches(name):
    point = lp.start_point(lp.assemble(clutched()), start={name: 50.0}, together=True)
    turning = [point[f"{body}.w"] for body in ("motor", "hub", "wheel", "load")]
    assert turning == pytest.approx([50.0] * 4, rel=1e-12)
    assert [point["first.position"], point["second.position"]] == [0, 0]


def test_a_clutch_slips_where_start_values_or_an_open_one_say_so():
    system = lp.assemble(clutched())
    start = {"motor.w": 50.0, "hub.w": 20.0}
    point = lp.start_point(system, start=start, together=True)
    received = [point[f"{body}.w"] for body in ("motor", "hub", "wheel", "load")]
    assert received == pytest.approx([50.0, 20.0, 20.0, 20.0], rel=1e-12)
    opened = lp.assemble(clutched(**{"second.u": 0.0}))
    point = lp.start_point(opened, start={"motor.w": 50.0, "load.w": 5.0}, together=True)
    received = [point[f"{body}.w"] for body in ("motor", "hub", "wheel", "load")]
    assert received == pytest.approx([50.0, 50.0, 50.0, 5.0], rel=1e-12)


@pytest.mark.parametrize(("name", "value"), [("a.w", 100.0), ("r.w", 100.0), ("o.w", 200.0 / 3.0)])
def test_a_pressed_brake_holds_the_sun_of_a_planetary_set(name, value):
    """Ring over carrier is (1 + ratio) / ratio while the sun stands still."""
    model = in_rows(
        "a c r set.ring",
        "set.sun sun brake.flange_a",
        "set.carrier o",
        a=Inertia(J=0.4),
        c=Clutch(f_max=1e4, u=1.0),
        r=Inertia(J=0.1),
        set=Planetary(ratio=2.0),
        sun=Inertia(J=0.01),
        brake=Brake(f_max=1e4, u=1.0),
        o=Inertia(J=1.2),
    )
    point = lp.start_point(lp.assemble(model), start={name: value}, together=True)
    received = [point[n] for n in ("a.w", "r.w", "sun.w", "o.w")]
    assert received == pytest.approx([100.0, 100.0, 0.0, 200.0 / 3.0], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("name", "value"), [("car.v", 20.0), ("engine.w", 20.0 / 0.3 * 8.0)])
def test_a_tyre_rolls_where_all_parts_move_together(name, value):
    model = in_rows(
        "engine clutch gear wheel tyre.wheel",
        "tyre.hub car",
        engine=Inertia(J=0.3),
        clutch=Clutch(f_max=1e4, u=1.0),
        gear=IdealGear(ratio=8.0),
        wheel=Inertia(J=2.0),
        tyre=Tyre(f_n=4000.0, R=0.3, mu=1.0),
        car=translation.Mass(m=1200.0),
    )
    point = lp.start_point(lp.assemble(model), start={name: value}, together=True)
    received = [point[n] for n in ("car.v", "wheel.w", "engine.w", "tyre.f")]
    expected = [20.0, 20.0 / 0.3, 20.0 / 0.3 * 8.0, 0.0]
    assert received == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert abs(point["tyre.k"]) < 1e-9


IN_GEAR = {
    "dogs": (Coupling(u=1.0), 1.0),
    "freewheel": (OneWayClutch(u=0.0), 1.0),
    "synchroniser": (Synchroniser(f_max=1.0, mu=0.1, R=0.1, alpha=0.1, u=1.0, locked=1.0), 1.0),
    "second gear": (SelectableGear(ratio_1=3.0, ratio_2=2.0, u=2.0), 2.0),
    "play": (Backlash(b=0.1), 1.0),
}


@pytest.mark.parametrize("name", ["motor.w", "hub.w", "load.w"])
@pytest.mark.parametrize("kind", IN_GEAR)
def test_a_train_in_gear_turns_without_an_impact(kind, name):
    """A gear with loss, what is in gear, an elastic shaft: one speed, whichever is given."""
    part, ratio = IN_GEAR[kind]
    model = in_a_row(
        motor=Inertia(J=0.4),
        gear=EfficientGear(ratio=5.0, eta=0.9),
        first=Inertia(J=0.2),
        part=part,
        hub=Inertia(J=0.1),
        shaft=SpringDamper(c=1e3, d=1.0),
        load=Inertia(J=1.0),
        weight=Torque(tau=-1.0),
    )
    expected = {"motor.w": 60.0 * ratio, "first.w": 12.0 * ratio, "hub.w": 12.0, "load.w": 12.0}
    point = lp.start_point(lp.assemble(model), start={name: expected[name]}, together=True)
    assert [point[body] for body in expected] == pytest.approx(list(expected.values()), rel=1e-12)
    assert not point.collisions


def test_a_pressed_clutch_turns_a_shaft_against_its_bearing_in_any_order():
    model = in_rows(
        "motor clutch load bearing.flange_a",
        bearing=BearingFriction(characteristic=((0.0, 5.0),)),
        motor=Inertia(J=1.0),
        clutch=Clutch(f_max=1e3, u=1.0),
        load=Inertia(J=0.2),
    )
    point = lp.start_point(lp.assemble(model), start={"motor.w": 10.0}, together=True)
    assert point["load.w"] == pytest.approx(10.0, rel=1e-12)
