from functools import cache

import numpy as np
import pytest
from torsional_cases import (
    FIRST,
    RPM,
    Excited,
    blades,
    columns,
    marine,
    peak_share,
)

import lumped as lp
from lumped.components import (
    CrankSlider,
    Damper,
    Fixed,
    HarmonicTorque,
    IdealGear,
    Inertia,
    LossSpring,
    NonlinearSpring,
    QuadraticTorque,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import OptionError, SolverError, UnknownNameError
from lumped.models.diesel_genset.drive import Crankshaft


def worst(found, wanted):
    return float(np.abs(np.asarray(found) / np.asarray(wanted) - 1).max())


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
        error = worst(response.magnitude(name, 5), torque)
        print(f"{name}: {error:.1e}")
        assert error < 2e-9
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
        assert worst(found, orders[f"order_{order:g}"]) < 1e-8
    synthesis = columns("02_six_cylinder_crankshaft", "synthesis_shafts_1_8.csv")
    for number, name in ((1, "shaft_1.tau_c"), (8, "shaft_8.tau_c")):
        both = response.synthesis(name)
        errors = (
            worst(both.sum, synthesis[f"shaft{number}_sum_of_amplitudes"]),
            worst(both.maximum, synthesis[f"shaft{number}_maxabs"]),
            worst(both.half_range, synthesis[f"shaft{number}_halfrange"]),
        )
        print(f"shaft {number}: sum {errors[0]:.1e}, maximum {errors[1]:.1e}, {errors[2]:.1e}")
        # the tables look at 7200 points of a cycle, and so find a little less
        assert errors[0] < 1e-8
        assert max(errors[1:]) < 5e-5


def test_orders_at_many_speeds_are_those_at_each():
    system = lp.assemble(Crankshaft())
    options = {"of": ["shaft_1.tau_c", "shaft_8.tau"], "shaft": "flywheel.phi", "turns": 2}
    speeds = np.linspace(60.0, 300.0, 400)
    many = lp.vibration.order_response(system, speeds=speeds, **options)
    for k in (0, 1, 57, 203, 398):
        single = lp.vibration.order_response(system, speeds=[speeds[k]], **options)
        largest = np.abs(single.values[0]).max(axis=0)
        error = (np.abs(many.values[k] - single.values[0]).max(axis=0) / largest).max()
        print(f"{speeds[k]:.1f} rad/s: {error:.1e}")
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
    return lp.assemble(
        lp.compose(
            main=Inertia(J=1.0),
            ring=Inertia(J=mu),
            fluid=Damper(d=2 * mu * z),
            spring=Spring(c=1.0),
            ground=Fixed(),
            torque=Torque(tau=0.0),
            connections=lambda m: [
                *lp.chain(m.ground, m.spring, m.main, m.fluid, m.ring),
                lp.connect(m.torque.flange, m.main.flange_b),
            ],
        )
    )


def test_a_viscous_damper_has_den_hartogs_amplification():
    g = np.linspace(0.2, 2.0, 91)
    for mu in (0.05, 0.25, 1.0):
        z = 1 / np.sqrt(2 * (1 + mu) * (2 + mu))
        response = lp.vibration.order_response(
            damper(mu, z), speeds=g, of=["main.phi"], excitations={"torque.tau": {1: 1.0}}
        )
        shape = (g**2 * (1 + mu) - 1) ** 2 * 4 * z**2 + g**2 * (g**2 - 1) ** 2
        wanted = np.sqrt((4 * z**2 + g**2) / shape)
        error = worst(response.magnitude("main.phi", 1), wanted)
        print(f"mu = {mu}: {error:.1e}")
        assert error < 1e-12
        top = lp.vibration.order_response(
            damper(mu, z),
            speeds=[np.sqrt(2 / (2 + mu))],
            of=["main.phi"],
            excitations={"torque.tau": {1: 1.0}},
        )
        assert top.magnitude("main.phi", 1)[0] == pytest.approx(1 + 2 / mu, rel=1e-12)


def test_a_linear_drive_vibrates_as_its_periodic_motion():
    speed = 40.0
    model = lp.compose(
        motor=Inertia(J=2.0),
        shaft=SpringDamper(c=3e4, d=15.0),
        load=Inertia(J=5.0),
        ground=Fixed(),
        bearing=Damper(d=3.0),
        torque=Torque(tau=120.0 * lp.ops.cos(3 * speed * lp.time)),
        connections=lambda m: [
            *lp.chain(m.motor, m.shaft, m.load, m.bearing, m.ground),
            lp.connect(m.torque.flange, m.motor.flange_a),
        ],
    )
    orbit = lp.periodic(lp.assemble(model), period=2 * np.pi / speed, rtol=1e-11)
    still = lp.assemble(model.with_({"torque": Torque(tau=0.0)}))
    response = lp.vibration.order_response(
        still, speeds=[speed], of=["shaft.tau"], excitations={"torque.tau": {3: 120.0}}
    )
    angle = speed * orbit.run.t
    wanted = response.synthesis("shaft.tau").at(angle)[0]
    error = np.abs(orbit["shaft.tau"] - wanted).max() / np.abs(wanted).max()
    print(f"{error:.1e}")
    assert error < 1e-8


def test_a_loss_factor_is_a_complex_stiffness_at_every_frequency():
    J1, J2, c, eta = 2.0, 5.0, 3e4, 0.3
    system = lp.assemble(
        lp.compose(
            motor=Inertia(J=J1),
            shaft=LossSpring(c=c, eta=eta, w_loss=17.0),
            load=Inertia(J=J2),
            torque=Torque(tau=0.0),
            connections=lambda m: [
                *lp.chain(m.motor, m.shaft, m.load),
                lp.connect(m.torque.flange, m.motor.flange_a),
            ],
        )
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
        assert np.abs(orders["shaft.phi_rel"][:, k] / wanted - 1).max() < 1e-12
    single = lp.frequency_response(
        system,
        inputs=["torque.tau"],
        outputs=["shaft.phi_rel"],
        hertz=2 * speeds / (2 * np.pi),
    )
    found = single["shaft.phi_rel", "torque.tau"] * (4.0 - 3.0j)
    assert np.abs(found / orders["shaft.phi_rel"][:, 1] - 1).max() < 1e-12


HARMONICS = ((0.5, 30.0, 0.3), (2, 340.0, 0.0), (4, 120.0, 1.2))


def ship(cubic=3e6, harmonics=HARMONICS):
    """Engine with a crank drive, progressive coupling, gear and propeller."""
    return lp.assemble(
        lp.compose(
            crank=Inertia(J=2.0),
            drive=CrankSlider(r=0.07, L=0.2, m=2.0),
            gas=HarmonicTorque(harmonics=harmonics, mean=500.0),
            coupling=NonlinearSpring(characteristic=lambda x: 2e4 * x + cubic * x**3),
            rubber=LossSpring(c=1e3, eta=0.2, w_loss=300.0),
            gear=IdealGear(ratio=3.0),
            propeller=Inertia(J=40.0),
            water=Damper(d=2.0),
            load=Torque(tau=-1500.0),
            ground=Fixed(),
            connections=lambda m: [
                *lp.chain(m.crank, m.coupling, m.gear, m.propeller, m.water, m.ground),
                *lp.chain(m.crank, m.rubber, m.gear),
                lp.connect(m.gas.flange, m.crank.flange_a),
                lp.connect(m.drive.flange, m.crank.flange_a),
                lp.connect(m.load.flange, m.propeller.flange_b),
            ],
        )
    )


SPEEDS = np.linspace(20.0, 150.0, 6)
OPTIONS = {
    "speeds": SPEEDS,
    "of": ["coupling.tau"],
    "shaft": "crank.phi",
    "turns": 2,
    "orders": [0.5, 2, 3, 4],
}


@pytest.mark.parametrize("count", [6, 150])
def test_mean_torques_balance_with_a_free_parameter(count):
    speeds = np.linspace(20.0, 150.0, count)
    response = lp.vibration.order_response(
        ship(),
        free="load.tau",
        parameters={"drive.m": 0.0, "water.d": 6.0},
        **{**OPTIONS, "speeds": speeds, "orders": [0.5, 2, 4]},
    )
    x = response.rotation.x
    twist = x[:, response.system.state_names.index("coupling.phi_rel")]
    # engine 500 N.m; propeller turns at a third of the speed, against 6 N.m.s/rad
    load = response.rotation.theta[:, response.system.places(["load.tau"])[0]]
    assert load == pytest.approx(-1500.0 + 6.0 * speeds / 3, rel=1e-9)
    assert 2e4 * twist + 3e6 * twist**3 + 1e3 * twist == pytest.approx(-500.0, rel=1e-10)


def test_a_mean_that_bends_with_the_speed_is_that_at_each_speed():
    # the drive torque grows with the speed, and the progressive coupling stiffens
    def response(speeds):
        model = lp.compose(
            motor=Inertia(J=2.0),
            coupling=NonlinearSpring(characteristic=lambda x: 2e4 * x + 3e6 * x**3),
            bearing=Damper(d=1.0),
            load=Inertia(J=5.0),
            water=QuadraticTorque(tau_nominal=-900.0, w_nominal=100.0),
            torque=Torque(tau=0.0),
            ground=Fixed(),
            connections=lambda m: [
                *lp.chain(m.motor, m.coupling, m.load, m.bearing, m.ground),
                lp.connect(m.torque.flange, m.motor.flange_a),
                lp.connect(m.water.flange, m.load.flange_b),
            ],
        )
        return lp.vibration.order_response(
            lp.assemble(model),
            speeds=speeds,
            of=["coupling.tau"],
            shaft="motor.phi",
            free="torque.tau",
            orders=[1],
            excitations={"torque.tau": {1: 10.0}},
        )

    speeds = np.linspace(10.0, 150.0, 300)
    found = response(speeds)
    twist = found.rotation.x[:, found.system.state_names.index("coupling.phi_rel")]
    wanted = 900.0 * (speeds / 100) ** 2 + speeds
    torque = found.rotation.theta[:, found.system.places(["torque.tau"])[0]]
    assert np.abs(torque - wanted).max() < 1e-9 * wanted.max()
    assert np.abs(2e4 * twist + 3e6 * twist**3 + wanted).max() < 1e-8 * wanted.max()
    stiff, viscous = 2e4 + 9e6 * twist**2, 18.0 * speeds / 100 + 1
    w = 1j * speeds
    J = np.array([2.0, 5.0])
    for k in range(0, 300, 23):
        K = stiff[k] * np.array([[1, -1], [-1, 1]])
        matrix = w[k] ** 2 * np.diag(J) + w[k] * np.diag([0.0, viscous[k]]) + K
        phi = np.linalg.solve(matrix, [10.0, 0.0])
        expected = stiff[k] * (phi[1] - phi[0])
        assert found["coupling.tau"][k, 0] == pytest.approx(expected, rel=1e-7)


@pytest.fixture(scope="module")
def changed_ship():
    """A ship, and its response when a parameter is changed."""
    system = ship()

    @cache
    def response(free, name, change):
        parameters = {name: system.parameters[name] + change}
        return lp.vibration.order_response(system, free=free, parameters=parameters, **OPTIONS)

    return system, response


@pytest.mark.parametrize("free", ["load.tau", None])
@pytest.mark.parametrize("measure", ["maximum", "half range", "sum", 2.0])
def test_derivatives_by_all_parameters_equal_differences(free, measure, changed_ship):
    system, changed = changed_ship

    def value(name, change):
        found = changed(free, name, change)
        if measure == 2.0:
            return found.magnitude("coupling.tau", 2)[3]
        both = found.synthesis("coupling.tau")
        sizes = {"maximum": both.maximum, "half range": both.half_range, "sum": both.sum}
        return sizes[measure][3]

    response = lp.vibration.order_response(system, free=free, **OPTIONS)
    slopes = lp.vibration.order_sensitivity(
        response, "coupling.tau", measure=measure, speed=SPEEDS[3]
    )
    checked = ["crank.J", "drive.r", "drive.L", "drive.m", "gear.ratio", "propeller.J"]
    checked += ["rubber.c", "rubber.eta", "coupling.phi_rel0"]
    checked += ["gas.mean"] if free else []
    for name in checked:
        h = 1e-4 * max(abs(system.parameters[name]), 0.01)
        near, far = value(name, h) - value(name, -h), value(name, 2 * h) - value(name, -2 * h)
        wanted = (8 * near - far) / (12 * h)
        least = 1e-7 * abs(slopes.value) / max(abs(system.parameters[name]), 1e-2)
        assert slopes[name] == pytest.approx(wanted, rel=1e-7, abs=least), name


def test_orders_follow_the_motion_that_repeats_where_the_drive_is_nearly_linear():
    # the loss of a material acts at one frequency in a run, so look at one order
    system = ship(cubic=0.0, harmonics=((2, 3.4, 0.0),))
    small = {"drive.m": 0.002, "rubber.eta": 0.5, "rubber.c": 1e4, "water.d": 3.0}
    options = {**OPTIONS, "turns": 1, "orders": [2]}
    alone = lp.vibration.order_response(system, free="load.tau", parameters=small, **options)
    k, w = 4, SPEEDS[4]
    load = float(alone.rotation.theta[k, system.places(["load.tau"])[0]])
    orbit = lp.periodic(
        system,
        turn={"crank.phi": 2 * np.pi},
        free=["load.tau"],
        period=2 * np.pi / w,
        parameters={**small, "load.tau": load, "rubber.w_loss": 2 * w},
        start={"crank.w": w, "propeller.w": w / 3, "coupling.phi_rel": -500.0 / 3e4},
        warm_up=100 * 2 * np.pi / w,
    )
    angle = w * orbit.run.t
    twist = orbit["coupling.tau"] * np.exp(-2j * angle)
    found = abs(np.trapezoid(twist, angle) / np.pi)
    error = abs(alone.magnitude("coupling.tau", 2)[k] / found - 1)
    print(f"{error:.1e}")
    assert error < 1e-3


def test_synthesis_finds_extremes_between_points():
    amplitudes = np.array([[1.0 + 0.5j, -0.3j, 0.7 - 0.2j]])
    both = lp.vibration.Synthesis(
        "tau", "N.m", np.array([1.0]), np.array([0.5, 2.0, 3.0]), amplitudes
    )
    assert both.turns == 2
    values = both.at(np.linspace(0, 4 * np.pi, 2_000_001))[0]
    assert both.maximum[0] == pytest.approx(np.abs(values).max(), rel=1e-10)
    assert both.half_range[0] == pytest.approx(np.ptp(values) / 2, rel=1e-10)
    assert both.sum[0] == pytest.approx(np.abs(amplitudes).sum())


def test_orders_without_a_common_cycle_have_a_sum_only():
    both = lp.vibration.Synthesis(
        "tau", "N.m", np.array([1.0]), np.array([1.0, np.sqrt(2)]), np.array([[1.0, 2.0j]])
    )
    assert both.sum[0] == pytest.approx(3.0)
    with pytest.raises(OptionError, match="does not repeat"):
        _ = both.maximum


@pytest.mark.parametrize(
    ("change", "error", "match"),
    [
        ({"speeds": [0.0, 10.0]}, OptionError, "above zero"),
        ({"speeds": [-10.0, 10.0]}, OptionError, "above zero"),
        ({"orders": [0.0, 1.0]}, OptionError, "orders must be positive"),
        ({"orders": [0.25]}, OptionError, "order 0.25 is no whole number of periods in 2 turns"),
        ({"turns": 1, "orders": [2]}, OptionError, "Give turns="),
        ({"of": []}, OptionError, "at least one quantity"),
        ({"of": ["coupling.taw"]}, UnknownNameError, "coupling.tau"),
        ({"shaft": None}, OptionError, "nothing excites"),
        ({"shaft": "coupling.phi_rel"}, OptionError, "coupling.phi_rel"),
        ({"free": "coupling.phi_rel0"}, SolverError, "do not balance"),
        ({"free": "drive.g"}, OptionError, "changes no rate"),
        ({"excitations": {"load.tau": {}}}, OptionError, "amplitudes by orders"),
        ({"excitations": {"load.tau": {1: [1.0, 2.0]}}}, OptionError, "one for each of the 6"),
        ({"excitations": {"load.tau": {-1: 1.0}}}, OptionError, "must be positive"),
        ({"excitations": {"load.tau": {1: np.nan}}}, OptionError, "not finite"),
        ({"damping_ratio": -0.1}, OptionError, "damping_ratio"),
    ],
)
def test_slips_are_named(change, error, match):
    with pytest.raises(error, match=match):
        lp.vibration.order_response(ship(), **{**OPTIONS, **change})


def test_an_order_that_excites_nothing_is_named():
    with pytest.raises(OptionError, match="order 3 excites nothing"):
        lp.vibration.order_response(
            damper(0.5, 0.2),
            speeds=[1.0],
            of=["main.phi"],
            orders=[1, 3],
            excitations={"torque.tau": {1: 1.0}},
        )


def test_a_resonance_without_damping_is_named():
    system = damper(0.5, 0.0)
    with pytest.raises(SolverError, match=r"order 2 at 0\.5 rad/s"):
        lp.vibration.order_response(
            system, speeds=[0.25, 0.5], of=["main.phi"], excitations={"torque.tau": {2: 1.0}}
        )


def test_mean_torques_balance_beside_angles_on_which_nothing_depends():
    model = lp.compose(
        rotor=Inertia(J=2.0),
        drive=Torque(tau=1.0),
        shake=Torque(tau=0.0),
        oil=Damper(d=0.1),
        ground=Fixed(),
        connections=lambda m: [
            *lp.chain(m.ground, m.oil, m.rotor),
            lp.connect(m.drive.flange, m.shake.flange, m.rotor.flange_a),
        ],
    )
    system = lp.assemble(model, keep=["rotor.phi"])
    speeds = np.array([20.0, 21.0])
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["rotor.w"],
        shaft="rotor.phi",
        excitations={"shake.tau": {1: 3.0}},
        free="drive.tau",
    )
    assert response.rotation.theta[:, system.places(["drive.tau"])[0]] == pytest.approx(
        0.1 * speeds
    )
    assert response["rotor.w"][:, 0] == pytest.approx(3.0 / (0.1 + 2j * speeds))
    slope = lp.vibration.order_sensitivity(response, "rotor.w", measure=1, by=["rotor.J"])
    w = slope.speed
    wanted = -3.0 * 2.0 * w**2 / abs(0.1 + 2j * w) ** 3
    assert slope["rotor.J"] == pytest.approx(wanted, rel=1e-9)


def test_a_shaft_whose_angle_acts_on_nothing_is_named():
    model = lp.compose(
        motor=Inertia(J=2.0),
        shaft=SpringDamper(c=3e4, d=15.0),
        load=Inertia(J=5.0),
        connections=lambda m: lp.chain(m.motor, m.shaft, m.load),
    )
    with pytest.raises(OptionError, match=r"no torque depends on motor\.phi"):
        lp.vibration.order_response(
            lp.assemble(model), speeds=[9.0], of=["shaft.tau"], shaft="motor.phi"
        )


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
