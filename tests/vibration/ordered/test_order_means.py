"""Vibrations about a mean that torques and a speed determine, and their derivatives."""

from functools import cache

import numpy as np
import pytest
from differences import slope
from progressive_drive import J_A, J_B, drive, respond
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped.components import (
    Clutch,
    CrankSlider,
    Damper,
    Fixed,
    HarmonicTorque,
    IdealGear,
    Inertia,
    LossSpring,
    NonlinearSpring,
    Torque,
)
from lumped.errors import OptionError, SolverError, UnknownNameError

HARMONICS = ((0.5, 30.0, 0.3), (2, 340.0, 0.0), (4, 120.0, 1.2))


def ship(cubic=3e6, harmonics=HARMONICS):
    """Engine with a crank drive, progressive coupling, gear and propeller."""
    return assemble_rows(
        "crank coupling gear propeller water ground",
        "crank rubber gear",
        "gas crank",
        "drive crank",
        "load propeller.flange_b",
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
    """The drive torque grows with the speed, and the progressive coupling stiffens."""
    speeds = np.linspace(10.0, 150.0, 300)
    coupling = NonlinearSpring(characteristic=lambda x: 2e4 * x + 3e6 * x**3)
    found = respond(drive(coupling), speeds)
    twist = found.rotation.x[:, found.system.state_names.index("coupling.phi_rel")]
    wanted = 900.0 * (speeds / 100) ** 2
    torque = found.rotation.theta[:, found.system.places(["motor.tau"])[0]]
    assert np.abs(torque - wanted).max() < 1e-9 * wanted.max()
    assert np.abs(2e4 * twist + 3e6 * twist**3 + wanted).max() < 1e-8 * wanted.max()
    stiff, viscous = 2e4 + 9e6 * twist**2, 18.0 * speeds / 100
    w, J = 1j * speeds, np.array([J_A, J_B])
    for k in range(0, 300, 23):
        K = stiff[k] * np.array([[1, -1], [-1, 1]])
        matrix = w[k] ** 2 * np.diag(J) + w[k] * np.diag([0.0, viscous[k]]) + K
        phi = np.linalg.solve(matrix, [1.0, 0.0])
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
        return getattr(found.synthesis("coupling.tau"), measure.replace(" ", "_"))[3]

    response = lp.vibration.order_response(system, free=free, **OPTIONS)
    slopes = lp.vibration.order_sensitivity(
        response, "coupling.tau", measure=measure, speed=SPEEDS[3]
    )
    checked = ["crank.J", "drive.r", "drive.L", "drive.m", "gear.ratio", "propeller.J"]
    checked += ["rubber.c", "rubber.eta", "coupling.phi_rel0"]
    checked += ["gas.mean"] if free else []
    for name in checked:
        h = 1e-4 * max(abs(system.parameters[name]), 0.01)
        wanted = slope(lambda change, name=name: value(name, change), 0.0, h, 4)
        least = 1e-7 * abs(slopes.value) / max(abs(system.parameters[name]), 1e-2)
        assert slopes[name] == pytest.approx(wanted, rel=1e-7, abs=least), name


def test_mean_torques_balance_beside_angles_on_which_nothing_depends():
    rotor, oil = Inertia(J=2.0), Damper(d=0.1)
    model = in_a_row(drive=Torque(tau=1.0), rotor=rotor, oil=oil, ground=Fixed())
    system = lp.assemble(model, keep=["rotor.phi"])
    speeds = np.array([20.0, 21.0])
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["rotor.w"],
        shaft="rotor.phi",
        excitations={"drive.tau": {1: 3.0}},
        free="drive.tau",
    )
    assert response.rotation.theta[:, system.places(["drive.tau"])[0]] == pytest.approx(
        0.1 * speeds
    )
    assert response["rotor.w"][:, 0] == pytest.approx(3.0 / (0.1 + 2j * speeds))
    found = lp.vibration.order_sensitivity(response, "rotor.w", measure=1, by=["rotor.J"])
    w = found.speed
    wanted = -3.0 * 2.0 * w**2 / abs(0.1 + 2j * w) ** 3
    assert found["rotor.J"] == pytest.approx(wanted, rel=1e-9)


def test_what_sticks_turns_at_one_speed_in_the_mean():
    """A clutch between two inertias, and a coupling that the mean torque stiffens."""
    system = lp.assemble(
        in_a_row(
            drive=Torque(tau=0.0),
            rotor=Inertia(J=0.1),
            clutch=Clutch(f_max=400.0, u=1.0),
            disc=Inertia(J=0.05),
            coupling=NonlinearSpring(characteristic=lambda x: 1e3 * x + 1e6 * x**3),
            wheel=Inertia(J=0.3),
            load=Damper(d=1.0),
            ground=Fixed(),
        )
    )
    speeds = np.array([10.0, 20.0])
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["coupling.tau", "wheel.w"],
        shaft="rotor.phi",
        excitations={"drive.tau": {2: 1.0}},
        free="drive.tau",
    )

    def torque(speed, d):
        roots = np.roots([1e6, 0.0, 1e3, -d * speed])
        stiff, w = 1e3 + 3e6 * roots[roots.imag == 0].real[0] ** 2, 2 * speed
        matrix = [[stiff - 0.15 * w**2, -stiff], [-stiff, stiff - 0.3 * w**2 + 1j * d * w]]
        a, b = np.linalg.solve(matrix, [1.0, 0.0])
        return stiff * abs(a - b)

    assert response.mean("wheel.w") == pytest.approx(speeds, rel=1e-9)
    assert response.mean("coupling.tau") == pytest.approx(-speeds, rel=1e-9)
    wanted = [torque(speed, 1.0) for speed in speeds]
    assert response.magnitude("coupling.tau", 2) == pytest.approx(wanted, rel=1e-9)
    found = lp.vibration.order_sensitivity(
        response, "coupling.tau", measure=2, by=["load.d"], speed=20.0
    )
    by_d = slope(lambda change: torque(20.0, 1.0 + change), 0.0, 1e-3, 4)
    assert found["load.d"] == pytest.approx(by_d, rel=1e-7)


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
