import numpy as np
import pytest
import scipy
from checks import refused
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import (
    AirGap,
    GearMesh,
    Inertia,
    LinearTorque,
    Propeller,
    Speed,
    SpringDamper,
    Torque,
)
from lumped.errors import LumpedError

J_A, J_B, C, D, R_A, R_B, Z = 0.01, 0.05, 1e7, 300.0, 0.05, 0.1, 20
MASS = 1 / (R_A**2 / J_A + R_B**2 / J_B)


def gears(**fields):
    """Two gears with torques at both."""
    return assemble_row(
        drive=Torque(tau=0.0),
        a=Inertia(J=J_A),
        mesh=GearMesh(r_a=R_A, r_b=R_B, z=Z, c=C, **fields),
        b=Inertia(J=J_B),
        load=Torque(tau=0.0),
    )


def test_a_mesh_answers_its_error_as_a_mass_on_a_spring():
    amplitude = 2e-8
    speeds = np.sqrt(C / MASS) / Z * np.linspace(0.3, 2.0, 40)
    response = lp.vibration.order_response(
        gears(d=D, error=((1, amplitude, 0.3),)),
        speeds=speeds,
        of=["mesh.s"],
        shaft="a.phi",
        orders=[Z],
        free="load.tau",
    )
    w = Z * speeds
    expected = MASS * w**2 * amplitude * np.exp(0.3j) / (C - MASS * w**2 + 1j * D * w)
    error = np.abs(response["mesh.s"][:, 0] / expected - 1).max()
    print(f"{error:.1e}")
    assert error < 1e-8  # terms of the second order in the error are left out on one side


def driven(share, damping):
    """Gear b at a gear that turns at a constant speed, twice its natural frequency."""
    w_0 = np.sqrt(C * R_B**2 / J_B)
    speed = 2 * w_0 / Z
    mesh = {"d": 2 * damping * C / w_0, "stiffness": ((1, share, 0.4),)}
    system = assemble_row(
        drive=Speed(w=speed),
        mesh=GearMesh(r_a=R_A, r_b=R_B, z=Z, c=C, **mesh),
        b=Inertia(J=J_B),
    )
    period = 2 * np.pi / (Z * speed)
    orbit = lp.periodic(
        system, turn={"mesh.x": 2 * np.pi}, start={"b.w": -speed * R_A / R_B}, warm_up=period
    )

    def rates(t, y):
        c = C * (1 + share * np.cos(Z * speed * t + 0.4))
        return [y[1], -(c * y[0] + 2 * damping * C / w_0 * y[1]) * R_B**2 / J_B]

    columns = [
        scipy.integrate.solve_ivp(rates, (0, period), y, rtol=1e-12, atol=1e-13, method="DOP853")
        for y in ([1.0, 0.0], [0.0, w_0])
    ]
    matrix = np.array([run.y[:, -1] for run in columns]).T @ np.diag([1.0, 1 / w_0])
    return orbit, np.linalg.eigvals(matrix)


@pytest.mark.parametrize(("share", "stable"), [(0.196, True), (0.204, False)])
def test_a_mesh_is_unstable_as_mathieus_equation(share, stable):
    # with the damping ratio zeta, the principal resonance begins at the share 4 zeta
    orbit, expected = driven(share, 0.05)
    received = orbit.multipliers
    print(received, expected)
    np.testing.assert_allclose(np.sort(received.real), np.sort(expected.real), rtol=1e-6)
    assert (np.abs(received).max() < 1) == stable


def test_the_contact_ratio_gives_the_series_of_a_rectangle():
    count = 400
    system = gears(contact_ratio=1.7, harmonics=count)
    x = np.linspace(0, 2 * np.pi, 9, endpoint=False) + 0.1
    stiffness = [lp.start_point(system, start={"a.phi": float(v / Z), "mesh.s": 1e-6}) for v in x]
    read = system.function(["mesh.f"])
    received = [float(read(p.x, p.theta, p.time, p.settings)) / 1e-6 for p in stiffness]
    two_pairs = np.abs((x + np.pi) % (2 * np.pi) - np.pi) < 0.7 * np.pi
    expected = C / 1.7 * np.where(two_pairs, 2.0, 1.0)
    np.testing.assert_allclose(received, expected, rtol=0.01)  # the series is cut off


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"stiffness": ((1, 0.2),)}, "harmonic, amplitude and phase"),
        ({"error": ((1, np.inf, 0.0),)}, "finite numbers"),
        ({"contact_ratio": 0.7}, "at least 1"),
        ({"contact_ratio": 1.7, "stiffness": ((1, 0.2, 0.0),)}, "give one of them"),
    ],
)
def test_slips_of_a_mesh_are_named(fields, match):
    refused(LumpedError, lambda: gears(**fields), match, "mesh")


def propeller(blades):
    return assemble_rows(
        "drive engine shaft water propeller",
        water=Inertia(J=600.0),
        propeller=Propeller(tau_nominal=4000.0, w_nominal=10.0, blades=blades, phase=0.2),
        shaft=SpringDamper(c=4e5, d=100.0),
        engine=Inertia(J=900.0),
        drive=Torque(tau=0.0),
    )


def test_a_propeller_excites_by_its_blades_and_damps_by_its_law():
    blades = ((4, 0.08, 0.5), (8, 0.02, -1.0))
    speeds = np.linspace(3.0, 14.0, 12)
    response = lp.vibration.order_response(
        propeller(blades),
        speeds=speeds,
        of=["shaft.phi_rel", "propeller.tau"],
        shaft="water.phi",
        orders=[4, 8],
        free="drive.tau",
    )
    np.testing.assert_allclose(response.mean("propeller.tau"), 40.0 * speeds**2, rtol=1e-9)
    place = response.system.places(["drive.tau"])[0]
    np.testing.assert_allclose(response.rotation.theta[:, place], 40.0 * speeds**2, rtol=1e-9)
    for i, (n, share, phase) in enumerate(blades):
        for k, speed in enumerate(speeds):
            w = 1j * n * speed
            c, J, d = 4e5 + 100.0 * w, np.diag([900.0, 600.0]), np.diag([0.0, 80.0 * speed])
            matrix = w**2 * J + w * d + c * np.array([[1, -1], [-1, 1]])
            torque = -share * 40.0 * speed**2 * np.exp(1j * (phase - n * 0.2))
            phi = np.linalg.solve(matrix, [0.0, torque])
            received = response["shaft.phi_rel"][k, i]
            assert received == pytest.approx(phi[1] - phi[0], rel=1e-9)


def test_a_propeller_brakes_in_both_directions():
    system = propeller(())
    read = system.function(["propeller.tau"])
    for w in (5.0, -5.0):
        point = lp.start_point(system, start={"water.w": w})
        received = float(read(point.x, point.theta, point.time, point.settings))
        assert received == pytest.approx(40.0 * 25.0 * np.sign(w))


def test_an_air_gap_swings_at_the_frequency_of_its_stiffness():
    p, tau_max, J, tau = 2, 9000.0, 30.0, 5000.0
    system = assemble_row(
        gap=AirGap(tau_max=tau_max, p=p, d=40.0, w_s=157.08),
        rotor=Inertia(J=J, w=157.08),
        turbine=Torque(tau=tau),
    )
    theta = np.arcsin(tau / tau_max) / p
    modes = lp.modes(system, at=lp.start_point(system, start={"gap.theta": float(theta)}))
    stiffness = p * np.sqrt(tau_max**2 - tau**2)
    assert modes.hertz[0] * 2 * np.pi == pytest.approx(np.sqrt(stiffness / J), rel=1e-12)
    decay = modes.damping[0] * 2 * np.sqrt(stiffness * J)
    assert decay == pytest.approx(40.0, rel=1e-10)
    run = lp.simulate(system, until=30.0, start={"gap.theta": 0.2}, certify=True, rtol=1e-10)
    assert run["gap.tau"][-1] == pytest.approx(tau, rel=1e-6)
    assert run["rotor.w"][-1] == pytest.approx(157.08, rel=1e-8)
    assert run.certificate.energy.error < 1e-8


def test_an_air_gap_lets_orders_be_computed_at_the_speed_of_its_field():
    speeds = np.linspace(100.0, 160.0, 7)
    system = assemble_row(
        gap=AirGap(tau_max=9000.0, p=2, d=40.0, w_s=157.08),
        damper=LinearTorque(tau_nominal=-5000.0, w_nominal=150.0),
        rotor=Inertia(J=30.0),
        turbine=Torque(tau=0.0),
    )

    def at(w):
        theta = float(np.arcsin(-5000.0 * w / 150.0 / 9000.0) / 2)
        changed = {"gap.w_s": w}
        return lp.start_point(system, parameters=changed, start={"rotor.w": w, "gap.theta": theta})

    response = lp.vibration.order_response(
        system, speeds=speeds, of=["gap.theta"], at=at, excitations={"turbine.tau": {0.5: 100.0}}
    )
    w = 0.5 * speeds
    tau = -5000.0 * speeds / 150.0
    stiffness = 2 * np.sqrt(9000.0**2 - tau**2)
    viscous = 40.0 + 5000.0 / 150.0
    expected = 100.0 / (stiffness - 30.0 * w**2 + 1j * w * viscous)
    np.testing.assert_allclose(response["gap.theta"][:, 0], expected, rtol=1e-8)
