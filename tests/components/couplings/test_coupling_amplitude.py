"""Couplings whose stiffness and damping depend on the amplitude of the vibrating torque."""

import numpy as np
import pytest
import scipy
from rows import assemble_row, assemble_rows, in_a_row

import lumped as lp
from lumped.components import Damper, ElasticCoupling, Fixed, Inertia, QuadraticTorque, Torque
from lumped.errors import EquationError, OptionError, SolverError
from lumped.vibration.ordered import order_solution

J = 12.0, 30.0, 9.0
C = 8e4, 5e4
PSI = 0.8, 0.6
ROWS = ((0.0, 1.0, 1.0), (200.0, 0.8, 1.1), (1000.0, 0.55, 1.3))


def law(amplitude, number=0):
    """Complex stiffness of a coupling by the rows."""
    where, stiff, loss = np.transpose(ROWS)
    k = C[number] * np.interp(amplitude, where, stiff)
    return k * (1 + 1j * PSI[number] * np.interp(amplitude, where, loss) / (2 * np.pi))


def drive(gas=0.0, **given):
    """Two inertias and a coupling between torques."""
    values = {"stiffness": ((0, C[0]),), "psi": PSI[0], "w_loss": 90.0, "extrapolate": True}
    return in_a_row(
        gas=Torque(tau=gas),
        engine=Inertia(J=J[0]),
        coupling=ElasticCoupling(**{**values, "over_amplitude": ROWS, **given}),
        load=Inertia(J=J[1]),
        brake=Torque(tau=0.0),
    )


def row():
    """Three inertias with two couplings that each have an amplitude of their own."""
    shape = {"w_loss": 90.0, "extrapolate": True, "over_amplitude": ROWS}
    return in_a_row(
        gas=Torque(tau=0.0),
        a=Inertia(J=J[0]),
        first=ElasticCoupling(stiffness=((0, C[0]),), psi=PSI[0], **shape),
        b=Inertia(J=J[1]),
        second=ElasticCoupling(stiffness=((0, C[1]),), psi=PSI[1], **shape),
        c=Inertia(J=J[2]),
    )


def answer(w, kc, torque=150.0):
    """Torque of the coupling between two inertias under a torque on the first."""
    return kc * torque * J[1] / (J[0] + J[1]) / (kc - J[0] * J[1] / (J[0] + J[1]) * w**2)


def test_the_amplitude_at_each_speed_is_that_of_a_scalar_fixed_point():
    w = np.linspace(30.0, 140.0, 56)
    response = lp.vibration.order_response(
        lp.assemble(drive()), speeds=w, of=["coupling.tau"], excitations={"gas.tau": {1: 150.0}}
    )
    worst = 0.0
    for k, speed in enumerate(w):
        root = scipy.optimize.brentq(
            lambda a, speed=speed: abs(answer(speed, law(a))) - a, 0.0, 5e3, xtol=1e-10
        )
        expected = answer(speed, law(root))
        worst = max(worst, abs(-response["coupling.tau"][k, 0] / expected - 1))
        worst = max(worst, abs(response.law_amplitudes["coupling.amplitude"][k] / root - 1))
    print(f"{worst:.1e}, unsettled {response.unsettled:.1e}")
    assert worst < 1e-9
    assert response.unsettled < 1e-10
    assert f"amplitudes to {response.unsettled:.1e}" in repr(response)


def test_two_couplings_and_two_orders_agree_with_their_matrices():
    """Half the range over the turn of both orders counts, from 3 by 3 matrices."""
    w, pushes = np.array([35.0, 52.0, 61.0, 90.0]), {1: 120.0, 2.5: 80.0j}
    response = lp.vibration.order_response(
        lp.assemble(row()),
        speeds=w,
        of=["first.tau", "second.phi_rel"],
        excitations={"gas.tau": pushes},
    )
    amplitudes = np.column_stack([response.law_amplitudes[f"{n}.amplitude"] for n in names()])
    angle = np.linspace(0, 4 * np.pi, 200_001)
    worst = 0.0
    for k, speed in enumerate(w):
        k1, k2 = (law(a, i) for i, a in enumerate(amplitudes[k]))
        courses = np.zeros((2, len(angle)))
        for o, (order, push) in enumerate(pushes.items()):
            springs = np.array([[k1, -k1, 0], [-k1, k1 + k2, -k2], [0, -k2, k2]])
            phi = np.linalg.solve(springs - np.diag(J) * (order * speed) ** 2, [push, 0, 0])
            torques = k1 * (phi[1] - phi[0]), k2 * (phi[2] - phi[1])
            courses += np.real(np.outer(torques, np.exp(1j * order * angle)))
            found = response["first.tau"][k, o], response["second.phi_rel"][k, o]
            expected = torques[0], phi[2] - phi[1]
            worst = max(worst, *np.abs(np.array(found) / expected - 1))
        half = np.ptp(courses, axis=1) / 2
        worst = max(worst, *np.abs(amplitudes[k] / half - 1))
    print(f"{worst:.1e}")
    assert worst < 2e-8  # the range is taken from points


def names():
    return "first", "second"


def test_orders_may_be_excited_at_some_speeds_only():
    """Where a speed has one order left, its amplitude is that of this order alone."""
    w = np.array([40.0, 60.0, 80.0])
    options = {"speeds": w, "of": ["coupling.tau"]}
    system = lp.assemble(drive())
    both = lp.vibration.order_response(
        system, excitations={"gas.tau": {1: 150.0, 2: np.array([90.0, 0.0, 0.0])}}, **options
    )
    alone = lp.vibration.order_response(system, excitations={"gas.tau": {1: 150.0}}, **options)
    assert both["coupling.tau"][1:, 0] == pytest.approx(alone["coupling.tau"][1:, 0], rel=1e-9)
    assert abs(both["coupling.tau"][0, 0] / alone["coupling.tau"][0, 0] - 1) > 1e-2


def test_a_coupling_under_mean_torque_has_its_stiffness_there():
    rows = ((0, 60e3), (1000, 95e3), (3000, 225e3))
    system = lp.assemble(drive(stiffness=rows, extrapolate=False))
    mean = 2000.0
    at = lp.equilibrium(system, parameters={"gas.tau": mean, "brake.tau": -mean})
    response = lp.vibration.order_response(
        system,
        speeds=[80.0],
        of=["coupling.tau", "coupling.phi_rel"],
        excitations={"gas.tau": {1: 150.0}},
        at=at,
    )
    received = response["coupling.tau"][0, 0] / response["coupling.phi_rel"][0, 0]
    amplitude = response.magnitude("coupling.tau", 1)[0]
    expected = 160e3 / C[0] * law(amplitude)
    assert received == pytest.approx(expected, rel=1e-8)


def test_a_run_at_the_amplitude_found_vibrates_as_the_response():
    w = 80.0

    def held(push):
        parts = {n: getattr(drive(w_loss=w), n) for n in ("engine", "coupling", "load")}
        return assemble_row(gas=Torque(tau=push), **parts, damper=Damper(d=3.0), wall=Fixed())

    response = lp.vibration.order_response(
        held(0.0), speeds=[w], of=["coupling.phi_rel"], excitations={"gas.tau": {1: 150.0}}
    )
    amplitude = float(response.law_amplitudes["coupling.amplitude"][0])
    orbit = lp.periodic(
        held(150.0 * lp.ops.cos(w * lp.time)),
        period=2 * np.pi / w,
        parameters={"coupling.amplitude": amplitude},
        rtol=1e-11,
    )
    received = orbit.harmonics("coupling.phi_rel", 1)[1]
    error = abs(received / response["coupling.phi_rel"][0, 0] - 1)
    heat = abs(orbit.mean("coupling.power") / response.mean_power("coupling.power")[0, 0] - 1)
    vibrating = abs(abs(orbit.harmonics("coupling.tau", 1)[1]) / amplitude - 1)
    print(f"twist {error:.1e}, heat {heat:.1e}, torque {vibrating:.1e}")
    assert max(error, heat, vibrating) < 1e-6


def test_a_frequency_response_has_the_stated_amplitude():
    point = lp.start_point(lp.assemble(drive()), parameters={"coupling.amplitude": 500.0})
    response = lp.frequency_response(
        point.system, inputs=["gas.tau"], outputs=["coupling.tau"], hertz=[9.0], at=point
    )
    expected = -answer(2 * np.pi * 9.0, law(500.0), 1.0)
    assert response["coupling.tau", "gas.tau"][0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("measure", ["half range", 2])
def test_derivatives_of_a_response_equal_differences(measure):
    warm = ((293.0, 1.0, 1.0), (353.0, 0.7, 0.6))
    fan = QuadraticTorque(tau_nominal=1500.0, w_nominal=60.0)
    rows = ((0, 60e3), (3000, 225e3))
    system = assemble_rows(
        "fan gas engine coupling load brake",
        **{n: getattr(drive(), n) for n in ("engine", "load", "gas", "brake")},
        coupling=ElasticCoupling(
            stiffness=rows,
            psi=0.8,
            w_loss=90.0,
            over_amplitude=ROWS,
            over_temperature=warm,
            T=313.0,
        ),
        fan=fan,
    )
    options = {
        "speeds": [50.0, 58.0],
        "of": ["coupling.phi_rel"],
        "shaft": "engine.phi",
        "free": "brake.tau",
        "excitations": {"gas.tau": {1: 40.0, 2: 150.0}},
    }

    def value(name, change):
        parameters = {name: system.parameters[name] + change}
        found = lp.vibration.order_response(system, parameters=parameters, **options)
        if measure == 2:
            return found.magnitude("coupling.phi_rel", 2)[1]
        return found.synthesis("coupling.phi_rel").half_range[1]

    response = lp.vibration.order_response(system, **options)
    slopes = lp.vibration.order_sensitivity(
        response, "coupling.phi_rel", measure=measure, speed=58.0
    )
    for name in ("coupling.psi", "coupling.T", "fan.tau_nominal", "load.J"):
        h = 1e-3 * system.parameters[name]
        near, far = value(name, h) - value(name, -h), value(name, 2 * h) - value(name, -2 * h)
        error = abs(slopes[name] / ((8 * near - far) / (12 * h)) - 1)
        print(f"{name}: {error:.1e}")
        assert error < 2e-6, name


def test_an_amplitude_beyond_the_rows_is_refused():
    with pytest.raises(SolverError, match=r"coupling.*amplitude.* outside 0 to 1000 N\.m") as told:
        lp.vibration.order_response(
            lp.assemble(drive(stiffness=((0, C[0]), (1e4, C[0])), extrapolate=False)),
            speeds=[30.0, 85.0, 110.0],
            of=["load.w"],
            excitations={"gas.tau": {1: 900.0}},
        )
    assert "extrapolate=True" in str(told.value)
    stated = lp.assemble(drive(stiffness=((0, C[0]), (1e4, C[0])), extrapolate=False))
    with pytest.raises(SolverError, match=r"amplitude of vibration = 1500 N\.m"):
        lp.simulate(stated, until=0.1, parameters={"coupling.amplitude": 1500.0})


def test_amplitudes_that_do_not_settle_are_told(monkeypatch):
    monkeypatch.setattr(
        order_solution, "solve_amplitudes", lambda _, begin: (begin + 7.0, np.array([0.0, 0.3]))
    )
    with pytest.raises(
        SolverError, match=r"at 85 rad/s no amplitude.*coupling\.amplitude = 7 .* 3\.0e-01"
    ):
        lp.vibration.order_response(
            lp.assemble(drive()),
            speeds=[30.0, 85.0],
            of=["load.w"],
            excitations={"gas.tau": {1: 60.0}},
        )


@pytest.mark.parametrize(
    ("rows", "match"),
    [
        (((50.0, 1.0, 1.0), (500.0, 0.8, 1.0)), r"begins at 50 N\.m; it must begin at zero"),
        (((0.0, 1.0), (500.0, 0.8)), "rows of amplitude.*factor of psi are needed"),
        (((0.0, 1.0, 1.0), (500.0, 0.0, 1.0)), "must be above zero"),
        (((0.0, 1.0, 1.0), (500.0, 0.8, -1.0)), "must not be negative"),
        (((0.0, 1.0, 1.0), (0.0, 0.8, 1.0)), "must increase"),
    ],
)
def test_rows_that_make_no_sense_are_refused(rows, match):
    with pytest.raises(EquationError, match=match) as refused:
        lp.assemble(drive(over_amplitude=rows))
    assert "coupling" in str(refused.value)


def test_an_amplitude_that_is_bound_is_refused():
    class Drive(lp.Component):
        most = lp.param("N.m", "amplitude", 100.0)
        wall = Fixed()
        gas = Torque(tau=0.0)
        rotor = Inertia(J=3.0)
        coupling = ElasticCoupling(
            stiffness=((0, 8e4), (1e3, 9e4)),
            psi=0.8,
            w_loss=90.0,
            over_amplitude=ROWS,
            amplitude=most,
        )

        def connections(self):
            yield from lp.chain(self.wall, self.coupling, self.rotor, self.gas)

    with pytest.raises(OptionError, match=r"coupling\.amplitude is .* bound to an expression"):
        lp.vibration.order_response(
            lp.assemble(Drive()), speeds=[30.0], of=["rotor.w"], excitations={"gas.tau": {1: 60.0}}
        )
