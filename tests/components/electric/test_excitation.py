"""Exciter and stabiliser: the plant in NumPy, Heffron and Phillips, transfer functions.

The machine is that of Kundur's examples (2220 MVA; the numbers stand in OpenIPSL's KundurSMIB).
"""

import numpy as np
import pytest
from checks import by_complex_step, refused
from rotor_axes import axis

import lumped as lp
from lumped.components import (
    InfiniteBus,
    PerUnit,
    PowerSystemStabiliser,
    SpeedSensor,
    StaticExciter,
    ThreePhaseLine,
    Torque,
    WoundFieldMachine,
    standard_parameters,
    wires,
)
from lumped.errors import ParameterError

BASE = PerUnit(S=2220e6, V=24e3, f=60.0)
FULL = {
    "X_d": (1.81, 0.3, 0.23),
    "T_do": (8.0, 0.03),
    "X_q": (1.76, 0.65, 0.25),
    "T_qo": (1.0, 0.07),
    "X_l": 0.15,
    "R_a": 0.003,
}
FIELD = {"X_d": (1.81, 0.3), "T_do": (8.0,), "X_q": (1.76,), "T_qo": (), "X_l": 0.15, "R_a": 0.0}
H, P, Q, X = 3.5, 0.9, 0.436, 0.15 + 0.5 * 0.93 / 1.43
CONTROL = {"T_R": 0.015, "K_A": 200.0, "T_A": 0.01}
STAGES = {"T_w": 1.41, "T_1": 0.154, "T_2": 0.033, "T_3": 0.05, "T_4": 0.02}
FREE = ["bus.V", "bus.phase", "turbine.tau", "exciter.V_ref"]


class Plant(lp.Component):
    """Generator with exciter and stabiliser on a line to an infinite bus."""

    bus: lp.Component = InfiniteBus(V=BASE.v, f=BASE.f)
    line: lp.Component = ThreePhaseLine(L=X * BASE.L)
    gen: lp.Component = WoundFieldMachine(J=1.0)
    turbine: lp.Component = Torque(tau=P * BASE.tau)
    sensor: lp.Component = SpeedSensor()
    exciter: lp.Component = StaticExciter(
        **CONTROL, V_n=BASE.v, v_n=1.0, E_min=-6.4, E_max=7.0, steady=True
    )
    stabiliser: lp.Component = PowerSystemStabiliser(
        **STAGES, w_s=BASE.speed, K=9.5, y_min=-0.2, y_max=0.2
    )

    def connections(self):
        yield from wires(self.bus, self.line, self.gen)
        yield lp.connect(self.turbine.flange, self.gen.flange, self.sensor.flange)
        yield lp.connect(self.gen.V_meas, self.exciter.V)
        yield lp.connect(self.sensor.w, self.stabiliser.w)
        yield lp.connect(self.stabiliser.y, self.exciter.u)
        yield lp.connect(self.exciter.y, self.gen.v_f)

    def initial_equations(self):
        yield lp.der(self.gen.w) == 0


def plant(standard):
    numbers = standard_parameters(BASE, **standard)
    machine = WoundFieldMachine(
        **numbers,
        J=BASE.J(H),
        w=BASE.speed,
        steady=True,
        P_0=-P * BASE.S,
        Q_0=-Q * BASE.S,
        V_0=BASE.v,
    )
    v_n = numbers["R_f"] * BASE.v / (BASE.w * numbers["L_md"])
    return lp.assemble(Plant(gen=machine).with_({"exciter.v_n": v_n}))


def eigenvalues(standard, K, K_A=200.0):
    system = plant(standard)
    given = {"stabiliser.K": K, "exciter.K_A": K_A}
    point = lp.start_point(system, start={"gen.phi": 0.3}, free=FREE, parameters=given)
    return np.linalg.eigvals(lp.linearise(system, at=point).A)


def by_hand(standard, K):
    """All equations in per unit, in the axes of the rotor, currents into the machine."""
    w_0 = BASE.w
    (d, R_d), (q, R_q) = (
        axis(standard[f"X_{a}"], standard[f"T_{a}o"], standard["X_l"], standard["R_a"], w_0)
        for a in "dq"
    )
    with_d, with_q = (x + np.diag([X] + [0.0] * (len(x) - 1)) for x in (d, q))
    n, m = len(d), len(q)
    current = -(P - 1j * Q)
    rotor = np.exp(-1j * (np.angle(1 - (R_d[0] + 1j * q[0, 0]) * current) - np.pi / 2))
    v, i, e = (x * rotor for x in (1, current, 1 + 1j * X * current))
    i_f = (v.imag - R_d[0] * i.imag - d[0, 0] * i.real) / d[0, 1]
    per_unit = R_d[1] / d[0, 1]  # field voltage for one pu without load
    begin_d, begin_q = np.zeros(n), np.zeros(m)
    begin_d[:2], begin_q[0] = (i.real, i_f), i.imag
    steam = (d @ begin_d)[0] * i.imag - (q @ begin_q)[0] * i.real
    V_ref = 1 + R_d[1] * i_f / per_unit / CONTROL["K_A"]
    T = STAGES

    def rates(*x):
        x = np.array(x)
        psi_d, psi_q, (theta, w, V_1, E, x_w, x_1, x_2) = x[:n], x[n : n + m], x[n + m :]
        i_d, i_q = np.linalg.solve(with_d, psi_d), np.linalg.solve(with_q, psi_q)
        c, s = np.cos(theta), np.sin(theta)
        e_d, e_q = e.real * c + e.imag * s, e.imag * c - e.real * s
        given_d, given_q = np.zeros(n, complex), np.zeros(m, complex)
        given_d[:2], given_q[0] = (e_d + w * psi_q[0], per_unit * E), e_q - w * psi_d[0]
        rate_d, rate_q = w_0 * (given_d - R_d * i_d), w_0 * (given_q - R_q * i_q)
        slope_d, slope_q = (np.linalg.solve(with_d, rate_d)[0], np.linalg.solve(with_q, rate_q)[0])
        v_d = e_d - X * slope_d / w_0 + w * X * i_q[0]
        v_q = e_q - X * slope_q / w_0 - w * X * i_d[0]
        V = np.sqrt(v_d**2 + v_q**2)
        washed = K * (w - 1) - x_w
        first = x_1 + T["T_1"] / T["T_2"] * (washed - x_1)
        second = x_2 + T["T_3"] / T["T_4"] * (first - x_2)
        torque = (d @ i_d)[0] * i_q[0] - (q @ i_q)[0] * i_d[0]
        rest = [
            w_0 * (w - 1),
            (torque - steam) / (2 * H),
            (V - V_1) / CONTROL["T_R"],
            (CONTROL["K_A"] * (V_ref + second - V_1) - E) / CONTROL["T_A"],
            washed / T["T_w"],
            (washed - x_1) / T["T_2"],
            (first - x_2) / T["T_4"],
        ]
        return np.concatenate([rate_d, rate_q, rest])

    at = [0.0, 1.0, 1.0, R_d[1] * i_f / per_unit, 0.0, 0.0, 0.0]
    steady = np.concatenate([with_d @ begin_d, with_q @ begin_q, at])
    assert np.abs(rates(*steady)).max() < 1e-9
    return np.linalg.eigvals(by_complex_step(rates, steady))


def swing(found):
    """The electromechanical mode: the eigenvalue between 0.8 and 1.6 Hz."""
    (root,) = found[(found.imag > 5) & (found.imag < 10)]
    return root


@pytest.mark.parametrize("K", [0.0, 9.5, 20.0])
@pytest.mark.parametrize("standard", [FULL, FIELD], ids=["four windings", "field"])
def test_all_eigenvalues_are_those_by_hand(standard, K):
    received, expected = eigenvalues(standard, K), by_hand(standard, K)
    assert len(received) == len(expected)
    distances = np.abs(received[:, None] - expected)
    assert distances.min(axis=0).max() < 1e-7
    assert distances.min(axis=1).max() < 1e-7


def test_the_stabiliser_damps_what_the_exciter_excites():
    ratios = [-r.real / abs(r) for r in (swing(eigenvalues(FULL, K)) for K in (0.0, 9.5))]
    expected = [-r.real / abs(r) for r in (swing(by_hand(FULL, K)) for K in (0.0, 9.5))]
    assert ratios == pytest.approx(expected, abs=1e-8)
    assert ratios[0] < -0.04
    assert ratios[1] > 0.15


def heffron_phillips(K):
    """Eigenvalues of the classical model of one axis, without transients of stator and line.

    Its derivatives are the constants K_1 to K_6 (Kundur, ch. 12.3).
    """
    X_d, X_1 = FIELD["X_d"]
    X_q, T_do = FIELD["X_q"][0], FIELD["T_do"][0]
    current, T, c = P - 1j * Q, STAGES, CONTROL
    behind, bus = 1 + 1j * X_q * current, 1 - 1j * X * current
    i_d = -(current * np.exp(1j * (np.pi / 2 - np.angle(behind)))).real
    E_q = abs(behind) - (X_q - X_1) * -i_d
    angle = np.angle(behind) - np.angle(bus)
    E_f = E_q + (X_d - X_1) * -i_d

    def rates(*x):
        theta, w, E_1, V_1, E, x_w, x_1, x_2 = x
        i_d = (E_1 - abs(bus) * np.cos(theta)) / (X + X_1)
        i_q = abs(bus) * np.sin(theta) / (X + X_q)
        torque = (E_1 + (X_q - X_1) * i_d) * i_q
        V = np.sqrt((X_q * i_q) ** 2 + (E_1 - X_1 * i_d) ** 2)
        washed = K * (w - 1) - x_w
        first = x_1 + T["T_1"] / T["T_2"] * (washed - x_1)
        second = x_2 + T["T_3"] / T["T_4"] * (first - x_2)
        return np.array(
            [
                BASE.w * (w - 1),
                (P - torque) / (2 * H),
                (E - E_1 - (X_d - X_1) * i_d) / T_do,
                (V - V_1) / c["T_R"],
                (c["K_A"] * (1 + E_f / c["K_A"] + second - V_1) - E) / c["T_A"],
                washed / T["T_w"],
                (washed - x_1) / T["T_2"],
                (first - x_2) / T["T_4"],
            ]
        )

    steady = np.array([angle, 1.0, E_q, 1.0, E_f, 0.0, 0.0, 0.0])
    assert np.abs(rates(*steady)).max() < 1e-9
    return np.linalg.eigvals(by_complex_step(rates, steady))


@pytest.mark.parametrize("K", [0.0, 9.5])
def test_the_swing_is_near_that_of_heffron_and_phillips(K):
    received, expected = swing(eigenvalues(FIELD, K)), swing(heffron_phillips(K))
    assert abs(received - expected) < 0.02 * abs(expected)  # the stator follows within a period


class Fed(lp.Component):
    """Exciter and stabiliser alone."""

    V: lp.Param = lp.param("V", "voltage", 100.0)
    w: lp.Param = lp.param("rad/s", "speed", 10.0)
    stabiliser: lp.Component = PowerSystemStabiliser(
        **STAGES, w=w, w_s=10.0, K=9.5, y_min=-0.2, y_max=0.1
    )
    exciter: lp.Component = StaticExciter(
        **CONTROL, V=V, u=0.0, V_n=100.0, v_n=2.0, E_min=-6.4, E_max=7.0
    )


def test_the_stabiliser_has_its_transfer_function():
    system = lp.assemble(Fed())
    line = lp.linearise(system, inputs=["w"], outputs=["stabiliser.y"])
    for w in (0.3, 7.0, 40.0):
        s, T = 1j * w, STAGES
        received = line.C @ np.linalg.solve(s * np.eye(len(line.A)) - line.A, line.B) + line.D
        expected = 9.5 / 10.0 * T["T_w"] * s / (1 + T["T_w"] * s)
        expected *= (1 + T["T_1"] * s) / (1 + T["T_2"] * s)
        expected *= (1 + T["T_3"] * s) / (1 + T["T_4"] * s)
        assert received[0, 0] == pytest.approx(expected, rel=1e-9)


def test_its_output_is_limited():
    run = lp.simulate(lp.assemble(Fed()), until=5.0, parameters={"w": 11.0})
    y = run["stabiliser.y"]
    assert y.max() == pytest.approx(0.1, abs=1e-12)
    run = lp.simulate(lp.assemble(Fed()), until=5.0, parameters={"w": 8.0})
    assert run["stabiliser.y"].min() == pytest.approx(-0.2, abs=1e-12)


def test_the_bridge_gives_less_from_a_lower_voltage():
    """Half the voltage asks for more than the bridge has: ``E_max V / V_n`` after a lag."""
    start = {"exciter.V_1": 0.5, "exciter.E": 0.0}
    run = lp.simulate(
        lp.assemble(Fed()), until=0.05, parameters={"V": 50.0}, start=start, rtol=1e-10
    )
    expected = 2.0 * 3.5 * (1 - np.exp(-run.t / CONTROL["T_A"]))
    assert run["exciter.y"] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"exciter.T_R": 0.0}, "exciter.T_R = 0 s"),
        ({"exciter.E_max": -7.0}, "exciter.E_max = -7"),
        ({"exciter.V_n": 0.0}, "exciter.V_n = 0 V"),
        ({"stabiliser.T_2": 0.0}, "stabiliser.T_2 = 0 s"),
        ({"stabiliser.y_max": -0.3}, "stabiliser.y_max = -0.3"),
    ],
)
def test_data_that_make_no_sense_are_refused(changed, text):
    refused(ParameterError, lambda: lp.assemble(Fed().with_(changed)), text)
