"""Sprags, centrifugal, pressed, heated and dual clutches against closed forms and integrations."""

import numpy as np
import pytest
import scipy
from rows import assemble_row, assemble_rows, in_rows

import lumped as lp
from lumped.components import (
    CentrifugalClutch,
    DualClutch,
    Fixed,
    FixedTemperature,
    HeatedClutch,
    Inertia,
    PressureClutch,
    SpragClutch,
    ThermalConductor,
    Torque,
)
from lumped.errors import SolverError

SPRAG = {"c": 5e3, "d": 0.2}
SHOES = {"m": 0.4, "r_g": 0.06, "r": 0.08, "n": 3.0, "f_spring": 150.0}
PRESSED = {"T_p": 0.05, "A": 0.004, "f_spring": 600.0, "n": 8.0, "r": 0.07}
THERMAL = {"C_lining": 60.0, "C_plate": 900.0, "G": 120.0}
MU = 0.12


def instants(run, name, after):
    return [e.time for e in run.events if e.component == name and e.after == after]


def test_sprags_throw_a_body_back_after_half_a_period_and_then_drag_it():
    J = 0.3
    system = assemble_row(ground=Fixed(), sprag=SpragClutch(**SPRAG), body=Inertia(J=J, w=-4.0))
    run = lp.simulate(system, until=0.2, rtol=1e-11)
    omega = np.sqrt(SPRAG["c"] / J)
    held = run.t <= np.pi / omega - 1e-9
    assert run["sprag.x"][held] == pytest.approx(
        4.0 / omega * np.sin(omega * run.t[held]), abs=1e-10
    )
    (free,) = instants(run, "sprag", "free")
    assert free == pytest.approx(np.pi / omega, rel=1e-9)
    late = run.t > free + 1e-9
    decay = 4.0 * np.exp(-SPRAG["d"] / J * (run.t[late] - free))
    assert run["body.w"][late] == pytest.approx(decay, rel=1e-8)
    assert run["sprag.x"][late] == pytest.approx(0.0, abs=1e-15)


def test_under_load_a_body_vibrates_on_the_sprags_with_their_natural_frequency():
    J, load = 0.3, 50.0
    system = assemble_row(
        ground=Fixed(),
        sprag=SpragClutch(**SPRAG, x=1.2 * load / SPRAG["c"]),
        body=Inertia(J=J, w=0.0),
        pull=Torque(tau=-load),
    )
    omega = np.sqrt(SPRAG["c"] / J)
    (eigenvalue,) = lp.modes(system, at=lp.equilibrium(system)).eigenvalues
    assert eigenvalue == pytest.approx(1j * omega, rel=1e-9)
    run = lp.simulate(system, until=0.3, rtol=1e-11)
    x = load / SPRAG["c"] * (1 + 0.2 * np.cos(omega * run.t))
    assert run["sprag.x"] == pytest.approx(x, rel=1e-8)


def test_sprags_let_go_of_a_body_that_starts_in_overrun_and_catch_it_at_any_angle():
    J, pull = 0.3, 6.0
    system = assemble_row(
        ground=Fixed(),
        sprag=SpragClutch(c=5e3),
        body=Inertia(J=J, w=2.0),
        pull=Torque(tau=-pull),
    )
    run = lp.simulate(system, until=0.2, rtol=1e-11)
    caught = instants(run, "sprag", "engaged")
    assert caught[0] == pytest.approx(2.0 * J / pull, rel=1e-9)
    omega, late = np.sqrt(5e3 / J), run.t > 2.0 * J / pull
    x = pull / 5e3 * (1 - np.cos(omega * (run.t[late] - 2.0 * J / pull)))
    assert run["sprag.x"][late] == pytest.approx(np.maximum(x, 0), abs=2e-8)


def test_sprags_hold_from_the_start_where_b_is_slower():
    """Two bodies swing on the sprags for half a period, and part with exchanged speeds."""
    J = 0.3
    row = {"one": Inertia(J=J, w=10.0), "sprag": SpragClutch(**SPRAG), "two": Inertia(J=J, w=0.0)}
    run = lp.simulate(assemble_row(**row), until=0.1, rtol=1e-11)
    omega = np.sqrt(2 * SPRAG["c"] / J)
    (free,) = instants(run, "sprag", "free")
    assert free == pytest.approx(np.pi / omega, rel=1e-9)
    decay = 5.0 * np.exp(-2 * SPRAG["d"] / J * (0.1 - free))
    speeds = [run["one.w"][-1], run["two.w"][-1]]
    assert speeds == pytest.approx([5.0 - decay, 5.0 + decay], rel=1e-9)


def test_a_run_goes_on_from_any_instant_of_sprags():
    row = {"wall": Fixed(), "sprag": SpragClutch(**SPRAG), "body": Inertia(J=0.3, w=-4.0)}
    system = assemble_row(**row, pull=Torque(tau=-30.0 + 60.0 * lp.ops.sin(40 * lp.time)))
    run = lp.simulate(system, until=0.4, rtol=1e-11)
    assert len(instants(run, "sprag", "engaged")) > 1
    for t in (0.01, 0.05, 0.11, 0.23):
        rest = lp.simulate(system, until=0.4, start=run.point(t), rtol=1e-11)
        assert rest["body.w"][-1] == pytest.approx(run["body.w"][-1], rel=1e-7)


def test_a_centrifugal_clutch_engages_at_its_speed_and_pulls_its_drum_up():
    J_hub, J_drum, push = 0.02, 0.15, 8.0
    system = assemble_row(
        push=Torque(tau=push),
        hub=Inertia(J=J_hub, w=0.0),
        clutch=CentrifugalClutch(**SHOES, characteristic=((0.0, 0.3),)),
        drum=Inertia(J=J_drum, w=0.0),
    )
    run = lp.simulate(system, until=3.0, rtol=1e-11)
    engages = np.sqrt(SHOES["f_spring"] / (SHOES["m"] * SHOES["r_g"]))
    first = instants(run, "clutch", "backward")[0]
    assert first == pytest.approx(J_hub * engages / push, rel=1e-9)

    def rates(t, y):
        force = max(SHOES["m"] * SHOES["r_g"] * y[0] ** 2 - SHOES["f_spring"], 0.0)
        tau = 0.3 * SHOES["r"] * SHOES["n"] * force
        return [(push - tau) / J_hub, tau / J_drum]

    def level(t, y):
        return y[0] - y[1]

    level.terminal = True
    own = scipy.integrate.solve_ivp(
        rates, (first, 3.0), [engages, 0.0], events=level, rtol=1e-12, atol=1e-12, max_step=1e-3
    )
    (stuck,) = instants(run, "clutch", "stuck")
    assert stuck == pytest.approx(own.t[-1], rel=1e-8)
    w = own.y[0, -1] + push / (J_hub + J_drum) * (3.0 - stuck)
    assert [run["hub.w"][-1], run["drum.w"][-1]] == pytest.approx([w, w], rel=1e-8)


def test_the_published_example_of_a_centrifugal_clutch():
    """3.7 kg at 140 mm, drum 165 mm, 4 shoes, mu 0.2, from 500 to 750 1/min: 234.32 N.m."""
    kiss = 500 * np.pi / 30
    shoes = {"m": 3.7, "r_g": 0.14, "r": 0.165, "n": 4.0, "f_spring": 3.7 * 0.14 * kiss**2}
    system = assemble_row(
        hub=Inertia(J=1.0),
        clutch=CentrifugalClutch(**shoes, characteristic=((0.0, 0.2),)),
        drum=Inertia(J=1.0),
    )
    point = lp.start_point(system, start={"hub.w": 78.54, "drum.w": 0.0})
    assert -point["clutch.tau"] == pytest.approx(234.321953712, rel=2e-5)  # 52.36 rad/s there


def brake(clutch, J=0.5, w=180.0, **parts):
    return assemble_row(body=Inertia(J=J, w=w), clutch=clutch, ground=Fixed(), **parts)


def test_pressure_rises_to_the_kiss_point_before_the_clutch_touches():
    p, J, w = 4e5, 0.5, 180.0
    run = lp.simulate(brake(PressureClutch(**PRESSED, p_wanted=p)), until=2.0, rtol=1e-11)
    T_p, A, spring = PRESSED["T_p"], PRESSED["A"], PRESSED["f_spring"]
    touches = -T_p * np.log(1 - spring / A / p)
    assert instants(run, "clutch", "backward")[0] == pytest.approx(touches, rel=1e-9)

    def speed(t):
        """The pressure is ``p (1 - exp(-t / T_p))``."""
        x = t - touches
        pushed = (A * p - spring) * x - A * p * T_p * np.exp(-touches / T_p) * -np.expm1(-x / T_p)
        return w - MU * PRESSED["n"] * PRESSED["r"] * pushed / J

    stops = scipy.optimize.brentq(speed, touches, 2.0, xtol=1e-13)
    assert instants(run, "clutch", "stuck")[0] == pytest.approx(stops, rel=1e-9)
    slips = (run.t > touches) & (run.t < stops)
    assert run["body.w"][slips] == pytest.approx(speed(run.t[slips]), rel=1e-8, abs=1e-7)


def test_slip_warms_linings_and_plates_as_two_masses():
    J, w, p = 0.5, 180.0, 4e5
    heated = HeatedClutch(**PRESSED, **THERMAL, p_wanted=p)
    system = assemble_row(
        keep=["clutch.plate.T"],
        body=Inertia(J=J, w=w),
        clutch=heated,
        ground=Fixed(),
    )
    run = lp.simulate(system, until=6.0, rtol=1e-11, start={"clutch.friction.p": p})
    tau = MU * PRESSED["n"] * PRESSED["r"] * (PRESSED["A"] * p - PRESSED["f_spring"])
    stops = J * w / tau
    assert instants(run, "clutch.friction", "stuck")[0] == pytest.approx(stops, rel=1e-9)
    C_l, C_p, G = THERMAL.values()
    T = C_l * C_p / (C_l + C_p) / G

    def difference(t):
        """Of the temperatures, with the power ``tau w - tau^2 / J t`` into the linings."""
        level, fall = tau * w / C_l, tau**2 / J / C_l
        at = np.minimum(t, stops)
        slips = (level + fall * T) * T * -np.expm1(-at / T) - fall * T * at
        return slips * np.exp(-(t - at) / T)

    at = np.minimum(run.t, stops)
    mean = 293.15 + (tau * w * at - tau**2 / J * at**2 / 2) / (C_l + C_p)
    d = difference(run.t)
    assert run["clutch.lining.T"] == pytest.approx(mean + C_p / (C_l + C_p) * d, rel=1e-8)
    assert run["clutch.plate.T"] == pytest.approx(mean - C_l / (C_l + C_p) * d, rel=1e-8)
    assert mean[-1] - 293.15 == pytest.approx(J * w**2 / 2 / (C_l + C_p), rel=1e-12)


def test_a_warm_lining_rubs_less_and_the_plates_cool_through_the_port():
    J, w, p = 0.5, 180.0, 3e5
    rows = ((293.15, 1.0), (393.15, 0.6))
    system = assemble_rows(
        "body clutch ground",
        "clutch.heat cooling.port_a",
        "cooling.port_b oil.port",
        body=Inertia(J=J, w=w),
        clutch=HeatedClutch(**PRESSED, **THERMAL, over_temperature=rows, p_wanted=p),
        ground=Fixed(),
        cooling=ThermalConductor(G=40.0),
        oil=FixedTemperature(T=293.15),
    )
    run = lp.simulate(system, until=3.0, rtol=1e-11, start={"clutch.friction.p": p})
    C_l, C_p, G = THERMAL.values()
    force = MU * PRESSED["n"] * PRESSED["r"] * (PRESSED["A"] * p - PRESSED["f_spring"])

    def rates(t, y):
        tau = force * np.interp(y[1], *np.transpose(rows)) if y[0] > 0 else 0.0
        through = G * (y[1] - y[2])
        return [-tau / J, (tau * y[0] - through) / C_l, (through - 40 * (y[2] - 293.15)) / C_p]

    def stands(t, y):
        return y[0]

    stands.terminal = True
    accuracy = {"rtol": 1e-12, "atol": 1e-10, "max_step": 1e-2}
    own = scipy.integrate.solve_ivp(rates, (0, 3), [w, 293.15, 293.15], events=stands, **accuracy)
    assert instants(run, "clutch.friction", "stuck")[0] == pytest.approx(own.t[-1], rel=1e-8)
    cold = force * own.t[-1] / J
    assert cold > 1.05 * w
    rest = scipy.integrate.solve_ivp(rates, (own.t[-1], 3), [0.0, *own.y[1:, -1]], **accuracy)
    received = [run["clutch.lining.T"][-1], run["clutch.plate.T"][-1]]
    assert received == pytest.approx(rest.y[1:, -1], rel=1e-8)


def test_each_of_two_clutches_takes_the_heat_of_its_own_slip():
    clutch = HeatedClutch(**PRESSED, **THERMAL)
    model = in_rows(
        "engine pair.flange_a",
        "pair.flange_1 odd",
        "pair.flange_2 even",
        engine=Inertia(J=0.3, w=200.0),
        pair=DualClutch(
            clutch_1=clutch,
            clutch_2=clutch.with_({"C_plate": 700.0}),
            p_1=5e5,
            p_2=lp.ops.where(lp.time >= 1.0, 5e5, 0.0),
        ),
        odd=Inertia(J=0.9, w=0.0),
        even=Inertia(J=0.6, w=0.0),
    )
    system = lp.assemble(model, keep=[f"pair.clutch_{i}.plate.T" for i in (1, 2)])
    first, whole = (lp.simulate(system, until=t, rtol=1e-10) for t in (1.0, 3.0))

    def heat(run, i, C_plate):
        found = (run[f"pair.clutch_{i}.{body}.T"][-1] - 293.15 for body in ("lining", "plate"))
        return np.array([THERMAL["C_lining"], C_plate]) @ list(found)

    common = 0.3 * 200.0 / 1.2
    assert first["odd.w"][-1] == pytest.approx(common, rel=1e-9)
    one = 0.3 * 0.9 / 1.2 * 200.0**2 / 2
    assert heat(first, 1, 900.0) == pytest.approx(one, rel=1e-8)
    assert heat(first, 2, 700.0) == pytest.approx(0.0, abs=1e-9)
    # both closed: all three turn together, and the second clutch takes what is missing
    both = 0.3 * 200.0 / 1.8
    assert whole["even.w"][-1] == pytest.approx(both, rel=1e-9)
    lost = 0.3 * 200.0**2 / 2 - 1.8 * both**2 / 2
    assert heat(whole, 1, 900.0) + heat(whole, 2, 700.0) == pytest.approx(lost, rel=1e-8)


def test_a_pressure_below_zero_is_refused():
    clutch = PressureClutch(**PRESSED, p_wanted=5e5 * lp.ops.cos(9 * lp.time))
    system = assemble_row(engine=Inertia(J=0.3, w=100.0), clutch=clutch, body=Inertia(J=0.9))
    with pytest.raises(SolverError, match="wanted pressure = -"):
        lp.simulate(system, until=1.0)
