import numpy as np
import pytest
from checks import worst
from rows import assemble_row, assemble_rows, in_a_row
from torsional_cases import FIRST, RPM, Excited, blades, columns, marine, peak_share

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    LossSpring,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import OptionError, SolverError
from lumped.models.diesel_genset.drive import Crankshaft


def test_a_marine_turbine_vibrates_as_published():
    table = columns("01_marine_steam_turbine", "response.csv")
    response = lp.vibration.order_response(
        marine(damped=True),
        speeds=table["n_rpm"] * RPM,
        of=["shaft.tau", "low.intermediate.tau"],
        excitations={"blades.tau": {5: blades}},
        damping_ratio=0.00398,
    )
    wanted = table["propeller_shaft_Nm"], table["lp_intermediate_shaft_Nm"]
    for name, torque in zip(response.of, wanted, strict=True):
        assert response.magnitude(name, 5) == pytest.approx(torque, rel=2e-9)
    # the torque of a spring here counts from the flange that lags
    phase = np.degrees(np.angle(-response["shaft.tau"][:, 0]))
    missed = np.angle(np.exp(1j * np.radians(phase - table["propeller_shaft_phase_deg"])))
    assert np.abs(missed).max() < 2e-9
    top = response.rpm[response.magnitude("shaft.tau", 5).argmax()]
    assert top == pytest.approx(35.46, rel=0.005)  # the published curve


def given_harmonics(rpm):
    """Excitations of the six cylinders from the torque of one, by 14 400 equal samples."""
    table = columns("02_six_cylinder_crankshaft", "pressure_curve.csv")
    a = np.arange(14400) * 4 * np.pi / 14400
    r, share = 0.0685, 0.0685 / 0.207
    tilt = np.arcsin(share * np.sin(a))
    lever = r * np.sin(a + tilt) / np.cos(tilt)
    curve = np.interp(np.degrees(a), table["crank_angle_deg"], table["pressure_digitised_MPa"])
    mass = np.cos(a) + share * np.cos(2 * a) - share**3 / 4 * np.cos(4 * a)
    mass += 9 / 128 * share**5 * np.cos(6 * a)
    rows = []
    for n in rpm:
        gas = 1e6 * curve * peak_share(n) * np.pi * 0.105**2 / 4
        torque = (gas - 2.521 * r * (n * RPM) ** 2 * mass) * lever
        rows.append(np.fft.rfft(torque)[:25] * 2 / 14400)
    harmonics = np.array(rows)
    orders = np.arange(1, 25) / 2
    return {
        f"engine.cylinder[{i}].tau": {
            float(o): harmonics[:, k + 1] * np.exp(-1j * o * FIRST[i] * 2 * np.pi / 3)
            for k, o in enumerate(orders)
        }
        for i in range(6)
    }


def test_a_six_cylinder_engine_vibrates_under_given_harmonics():
    orders = columns("02_six_cylinder_crankshaft", "orders_shaft1.csv")
    response = lp.vibration.order_response(
        lp.assemble(Excited()),
        speeds=orders["rpm"] * RPM,
        of=["shaft_1.tau_c", "shaft_8.tau_c"],
        excitations=given_harmonics(orders["rpm"]),
    )
    for order in response.orders:
        found = response.magnitude("shaft_1.tau_c", float(order))
        assert found == pytest.approx(orders[f"order_{order:g}"], rel=1e-8)
    synthesis = columns("02_six_cylinder_crankshaft", "synthesis_shafts_1_8.csv")
    for number, name in ((1, "shaft_1.tau_c"), (8, "shaft_8.tau_c")):
        both = response.synthesis(name)
        expected = [
            synthesis[f"shaft{number}_{x}"] for x in ("sum_of_amplitudes", "maxabs", "halfrange")
        ]
        assert both.sum == pytest.approx(expected[0], rel=1e-8)
        # the tables look at 7200 points of a cycle, and so find a little less
        assert [both.maximum, both.half_range] == pytest.approx(np.array(expected[1:]), rel=5e-5)


def test_orders_at_many_speeds_are_those_at_each():
    system = lp.assemble(Crankshaft())
    options = {"of": ["shaft_1.tau_c", "shaft_8.tau"], "shaft": "flywheel.phi", "turns": 2}
    speeds = np.linspace(60.0, 300.0, 400)
    many = lp.vibration.order_response(system, speeds=speeds, **options)
    for k in (0, 1, 57, 203, 398):
        single = lp.vibration.order_response(system, speeds=[speeds[k]], **options)
        largest = np.abs(single.values[0]).max(axis=0)
        error = (np.abs(many.values[k] - single.values[0]).max(axis=0) / largest).max()
        assert error < 1e-9


def test_an_angle_that_turns_vibrates_as_its_speed():
    response = lp.vibration.order_response(
        lp.assemble(Crankshaft()),
        speeds=[150.0],
        of=["pulley.phi", "pulley.w"],
        shaft="flywheel.phi",
        turns=2,
    )
    angle, speed = response["pulley.phi"][0], response["pulley.w"][0]
    wanted = speed / (1j * response.orders * 150.0)
    assert np.abs(angle - wanted).max() < 1e-9 * np.abs(wanted).max()


def damper(mu, z):
    """Untuned viscous damper on a spring to ground, J = K = 1."""
    return assemble_rows(
        "torque main spring ground",
        "main fluid ring",
        torque=Torque(tau=0.0),
        main=Inertia(J=1.0),
        spring=Spring(c=1.0),
        ground=Fixed(),
        fluid=Damper(d=2 * mu * z),
        ring=Inertia(J=mu),
    )


def test_a_viscous_damper_has_den_hartogs_amplification():
    for mu in (0.05, 0.25, 1.0):
        z, top = 1 / np.sqrt(2 * (1 + mu) * (2 + mu)), np.sqrt(2 / (2 + mu))
        g = np.union1d(np.linspace(0.2, 2.0, 91), top)
        response = lp.vibration.order_response(
            damper(mu, z), speeds=g, of=["main.phi"], excitations={"torque.tau": {1: 1.0}}
        )
        shape = (g**2 * (1 + mu) - 1) ** 2 * 4 * z**2 + g**2 * (g**2 - 1) ** 2
        wanted = np.sqrt((4 * z**2 + g**2) / shape)
        assert response.magnitude("main.phi", 1) == pytest.approx(wanted, rel=1e-12)
        highest = response.magnitude("main.phi", 1)[g == top]
        assert highest == pytest.approx([1 + 2 / mu], rel=1e-12)


def test_a_linear_drive_vibrates_as_its_periodic_motion():
    speed = 40.0
    model = in_a_row(
        torque=Torque(tau=120.0 * lp.ops.cos(3 * speed * lp.time)),
        motor=Inertia(J=2.0),
        shaft=SpringDamper(c=3e4, d=15.0),
        load=Inertia(J=5.0),
        bearing=Damper(d=3.0),
        ground=Fixed(),
    )
    orbit = lp.periodic(lp.assemble(model), period=2 * np.pi / speed, rtol=1e-11)
    still = lp.assemble(model.with_({"torque": Torque(tau=0.0)}))
    response = lp.vibration.order_response(
        still, speeds=[speed], of=["shaft.tau"], excitations={"torque.tau": {3: 120.0}}
    )
    angle = speed * orbit.run.t
    wanted = response.synthesis("shaft.tau").at(angle)[0]
    assert worst(orbit["shaft.tau"], wanted) < 1e-8


def test_a_loss_factor_is_a_complex_stiffness_at_every_frequency():
    J1, J2, c, eta = 2.0, 5.0, 3e4, 0.3
    system = assemble_row(
        torque=Torque(tau=0.0),
        motor=Inertia(J=J1),
        shaft=LossSpring(c=c, eta=eta, w_loss=17.0),
        load=Inertia(J=J2),
    )
    speeds = np.linspace(5.0, 200.0, 50)
    orders = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["shaft.phi_rel"],
        excitations={"torque.tau": {0.5: 10.0, 2: 4.0 - 3.0j}},
    )
    for k, (order, amplitude) in enumerate(((0.5, 10.0), (2, 4.0 - 3.0j))):
        w = order * speeds
        stiff = c * (1 + 1j * eta) - J1 * J2 / (J1 + J2) * w**2
        wanted = -amplitude * J2 / (J1 + J2) / stiff
        assert orders["shaft.phi_rel"][:, k] == pytest.approx(wanted, rel=1e-12, abs=0)
    single = lp.frequency_response(
        system, inputs=["torque.tau"], outputs=["shaft.phi_rel"], hertz=2 * speeds / (2 * np.pi)
    )
    found = single["shaft.phi_rel", "torque.tau"] * (4.0 - 3.0j)
    assert np.abs(found / orders["shaft.phi_rel"][:, 1] - 1).max() < 1e-12


def test_orders_without_a_common_cycle_have_a_sum_only():
    both = lp.vibration.Synthesis(
        "tau", "N.m", np.array([1.0]), np.array([1.0, np.sqrt(2)]), np.array([[1.0, 2.0j]])
    )
    assert not both.has_cycle
    assert both.measure("sum")[0] == pytest.approx(3.0)
    with pytest.raises(OptionError, match="does not repeat"):
        _ = both.maximum


@pytest.mark.parametrize(
    ("z", "excited", "orders", "error", "match"),
    [
        (0.2, 1, [1, 3], OptionError, "order 3 excites nothing"),
        (0.0, 2, None, SolverError, r"order 2 at 0\.5 rad/s"),
    ],
)
def test_an_order_that_excites_nothing_and_a_resonance_are_named(z, excited, orders, error, match):
    given = {"orders": orders, "excitations": {"torque.tau": {excited: 1.0}}}
    with pytest.raises(error, match=match):
        lp.vibration.order_response(damper(0.5, z), speeds=[0.25, 0.5], of=["main.phi"], **given)


class Lobes(lp.Component):
    """A torque with three periods for each turn."""

    flange = lp.Flange()

    def equations(self):
        yield self.flange.tau == -7.0 * lp.ops.cos(3.0 * self.flange.phi)


def test_orders_that_nobody_named_may_excite_nothing():
    """Three lobes excite order 3 alone: ``tau = J2 T / (J1 + J2 - J1 J2 w**2 / c)``."""
    system = assemble_row(lobes=Lobes(), a=Inertia(J=2.0), k=Spring(c=3e4), b=Inertia(J=5.0))
    options = {"speeds": [20.0, 30.0], "of": ["k.tau"], "shaft": "a.phi"}
    response = lp.vibration.order_response(system, **options)
    assert response.orders.tolist() == list(range(1, 13))
    w = 3 * response.speeds
    size = np.abs(5.0 * 7.0 / (2.0 + 5.0 - 2.0 * 5.0 * w**2 / 3e4))
    assert response.magnitude("k.tau", 3) == pytest.approx(size, rel=1e-12)
    assert not np.delete(response["k.tau"], 2, axis=1).any()
    assert response.synthesis("k.tau").maximum == pytest.approx(size, rel=1e-12)
    with pytest.raises(OptionError, match="order 2 excites nothing"):
        lp.vibration.order_response(system, orders=[2, 3], **options)


def test_a_shaft_whose_angle_acts_on_nothing_is_named():
    system = assemble_row(
        motor=Inertia(J=2.0), shaft=SpringDamper(c=3e4, d=15.0), load=Inertia(J=5.0)
    )
    with pytest.raises(OptionError, match=r"no torque depends on motor\.phi"):
        lp.vibration.order_response(system, speeds=[9.0], of=["shaft.tau"], shaft="motor.phi")


def test_synthesis_finds_the_highest_of_lobes_that_are_nearly_alike():
    """Phases at which the highest sample is not beside the highest value."""
    phase = np.radians(np.arange(360.0))
    amplitudes = np.column_stack([np.full(360, 0.3), 100 * np.exp(1j * phase)])
    both = lp.vibration.Synthesis("tau", "N.m", np.ones(360), np.array([1.0, 7.0]), amplitudes)
    values = both.at(np.linspace(0, 2 * np.pi, 7 * 4000 + 1))
    below = (7 * np.pi / 28000) ** 2 / 2 * 101  # what may lie between these angles
    for found, sampled in (
        (both.maximum, np.abs(values).max(axis=1)),
        (both.half_range, np.ptp(values, axis=1) / 2),
    ):
        assert (found > sampled - 1e-12).all()
        assert (found < sampled + below).all()


class Stepped(lp.Component):
    """A rotor with a damper that doubles above a speed, shaken by a torque."""

    J: lp.Param = lp.param("kg.m2", "inertia", 2.0)
    d: lp.Param = lp.param("N.m.s/rad", "damping at low speed", 3.0)
    tau: lp.Param = lp.param("N.m", "what shakes", 0.0)
    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        damping = lp.ops.where(self.w > 30.0, 2.0 * self.d, self.d)
        yield self.w == lp.der(self.phi)
        yield self.J * lp.der(self.w) == self.tau - damping * (self.w - 40.0)


@pytest.mark.parametrize("speeds", [[10.0, 20.0, 100.0], [10.0, 20.0, 28.0, 50.0, 100.0]])
def test_each_of_uneven_speeds_has_the_conditions_that_hold_there(speeds):
    response = lp.vibration.order_response(
        lp.assemble(Stepped(), keep=["phi"]),
        speeds=speeds,
        of=["w"],
        shaft="phi",
        excitations={"tau": {1: 5.0}},
    )
    w = np.array(speeds)
    expected = 5.0 / np.hypot(np.where(w > 30.0, 6.0, 3.0), 2.0 * w)
    np.testing.assert_allclose(np.abs(response.values[:, 0, 0]), expected, rtol=1e-12)
