"""Machine with field winding: closed forms of faults and of synchronisation, energy, bad input."""

import numpy as np
import pytest
import scipy
from checks import refused
from rows import in_a_row

import lumped as lp
from lumped.components import (
    CircuitBreaker,
    InfiniteBus,
    PerUnit,
    QuadraticTorque,
    ShortCircuit,
    Speed,
    SquirrelCageMotor,
    ThreePhaseLine,
    WoundFieldMachine,
    standard_parameters,
    wires,
)
from lumped.errors import ConnectError, EquationError, ParameterError
from lumped.models.turbine_generator.drive import BASE, STANDARD, Generator
from lumped.models.turbine_generator.scenes import run_reclosing

NONE = 1e-10  # pu  resistance where the closed form has none
X_D, X_Q = STANDARD["X_d"][-1], STANDARD["X_q"][-1]


def without_resistance(x_d=X_D, x_q=X_Q, **given):
    """The machine with these subtransient reactances, unloaded, at constant speed."""
    T = 1.0 / NONE
    numbers = standard_parameters(
        BASE,
        X_d=(1.79, 0.25, x_d),
        T_do=(2 * T, T),
        X_q=(1.71, 0.26, x_q),
        T_qo=(2 * T, T),
        X_l=0.1,
    )
    return WoundFieldMachine(
        **(numbers | {"J": 1.0, "v_f": 0.0, "steady": True, "V_0": BASE.v} | given)
    )


class Turned(Generator):
    """The generator at constant speed, without losses in line or machine."""

    line: lp.Component = ThreePhaseLine(L=0.7 * BASE.L)
    fault: lp.Component = ShortCircuit(begin=0.0)
    gen: lp.Component = without_resistance()
    shaft: lp.Component = Speed(w=BASE.speed)

    def connections(self):
        yield from super().connections()
        yield lp.connect(self.shaft.flange, self.gen.flange)


class Synchronised(lp.Component):
    """An excited machine that runs on its own, and is joined to the bus at the time zero."""

    bus: lp.Component = InfiniteBus(V=BASE.v, f=BASE.f)
    line: lp.Component = ThreePhaseLine(L=0.3 * BASE.L)
    breaker: lp.Component = CircuitBreaker(closed=lp.ops.where(lp.time < 0.0, 0.0, 1.0))
    gen: lp.Component = without_resistance(0.2, 0.2)
    shaft: lp.Component = Speed(w=BASE.speed)

    def connections(self):
        yield from wires(self.bus, self.line, self.breaker, self.gen)
        yield lp.connect(self.shaft.flange, self.gen.flange)


class Isolated(Synchronised):
    """The machine with the breaker open, and a fault at its terminals."""

    breaker: lp.Component = CircuitBreaker(closed=0.0)
    fault: lp.Component = ShortCircuit(begin=0.0, phases="bc")

    def connections(self):
        yield from super().connections()
        yield from wires(self.gen, self.fault)


def torque(model, th0, x, free=("bus.V", "bus.phase", "gen.v_f"), **options):
    """Air-gap torque in pu over the angle x of the supply after the time zero."""
    begin = -0.01
    run = lp.simulate(
        lp.assemble(model, keep=["gen.phi"]),
        until=x[-1] / BASE.w,
        begin=begin,
        grid=np.concatenate([[begin], x / BASE.w]),
        start={"gen.phi": th0 + BASE.w * begin},
        free=free,
        rtol=1e-10,
        **options,
    )
    return -run["gen.tau"][np.isin(run.t, x / BASE.w)] / BASE.tau


X = np.linspace(0.0, 6 * np.pi, 200)[1:]


def two_phase(x, th0, x_d=X_D, x_q=X_Q):
    s, c = np.sin(x + th0), np.cos(x + th0)
    i = (s - np.sin(th0)) / (x_d * s**2 + x_q * c**2)
    return c * i - (x_d - x_q) * s * c * i**2


def three_phase(x, x_d=X_D, x_q=X_Q):
    return np.sin(x) / x_d - np.sin(2 * x) / 2 * (1 / x_d - 1 / x_q)


@pytest.mark.parametrize("th0", [-np.pi / 2, 0.4])
def test_without_resistance_a_three_phase_fault_has_line_frequency_and_saliency(th0):
    received = torque(Turned(), th0, X)
    error = np.abs(received - three_phase(X)).max()
    assert error < 1e-6


@pytest.mark.parametrize("th0", [-np.pi / 2, 0.0, 1.1])
def test_without_resistance_a_line_to_line_fault_follows_the_closed_form(th0):
    received = torque(Isolated(gen=without_resistance()), th0, X, free=["gen.v_f"])
    error = np.abs(received - two_phase(X, th0)).max()
    assert error < 1e-6


def test_the_wires_are_alike():
    courses = []
    for phases, turn in (("bc", 0.0), ("ca", 2 * np.pi / 3), ("ab", -2 * np.pi / 3)):
        model = Turned(fault=ShortCircuit(begin=0.0, phases=phases))
        courses.append(torque(model, 0.3 + turn, X))
    assert courses[1] == pytest.approx(courses[0], abs=1e-7)
    assert courses[2] == pytest.approx(courses[0], abs=1e-7)


@pytest.mark.parametrize(("d", "q"), [(0, 0), (0, 1), (1, 0), (1, 1), (2, 1), (2, 2)])
def test_currents_of_a_fault_at_constant_speed_are_exponentials(d, q):
    """``der(psi) = A psi + b`` in the axes of the rotor, with any number of dampers."""
    dampers = ((0.02, 0.005), (0.1, 0.02))
    field = (0.2, 0.002)
    numbers = BASE.circuit(
        X_l=0.12, X_ad=1.5, X_aq=1.2, field=field, d=dampers[:d], q=dampers[:q], R_a=0.01
    )
    machine = WoundFieldMachine(**numbers, J=1.0, v_f=1.0, steady=True, V_0=BASE.v, P_0=-4e8)
    model = Turned(gen=machine)
    received = torque(model, 0.2, X)

    rows_d, rows_q = (0.12, 0.01), (0.12, 0.01)
    L_d = 1.5 + np.diag([rows_d[0], field[0], *(x for x, _ in dampers[:d])])
    L_q = 1.2 + np.diag([rows_q[0], *(x for x, _ in dampers[:q])])
    L = scipy.linalg.block_diag(L_d, L_q)
    R = np.diag([0.01, field[1], *(r for _, r in dampers[:d]), 0.01, *(r for _, r in dampers[:q])])
    k = 2 + d  # place of the q axis of the stator
    A = -R @ np.linalg.inv(L)
    A[0, k] += 1.0
    A[k, 0] -= 1.0
    # steady state before: phasors with motor currents
    current = -4e8 / BASE.S
    ahead = np.angle(1 - (0.01 + 1.32j) * current)
    v_d, v_q = np.sin(ahead), np.cos(ahead)
    i = np.zeros(len(L))
    i[0], i[k] = current * np.sin(ahead), current * np.cos(ahead)
    i[1] = (v_q - 0.01 * i[k] - (L @ i)[0]) / 1.5
    assert v_d == pytest.approx(0.01 * i[0] - (L @ i)[k])
    b = np.zeros(len(L))
    b[1] = field[1] * i[1]
    rest = np.linalg.solve(A, -b)
    expected = []
    for x in X:
        psi = rest + scipy.linalg.expm(A * x) @ (L @ i - rest)
        now = np.linalg.solve(L, psi)
        expected.append(psi[k] * now[0] - psi[0] * now[k])
    assert received == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(("error", "V"), [(0.5, 1.0), (2 * np.pi / 3, 1.0), (np.pi, 0.9), (0, 1.1)])
def test_wrong_synchronisation_follows_the_closed_form(error, V):
    """Constant flux of the rotor behind the subtransient reactance, on a bus behind its line.

    With the voltages E of the machine and V of the bus, which lags by the error, the current into
    the machine is ``A (exp(j x) - 1)``, ``A = (V exp(-j error) - E) / (j X)``.
    """
    model = Synchronised(bus=InfiniteBus(V=V * BASE.v, f=BASE.f))
    th0 = -np.pi / 2 + error  # voltage of the machine ahead of that of the bus
    received = torque(model, th0, X, free=("gen.v_f",))
    A = (V * np.exp(-1j * error) - 1) / 0.5j
    expected = -(np.conj(A) * (1 - np.exp(1j * X))).real
    assert received == pytest.approx(expected, abs=1e-6)


def test_without_voltage_on_its_field_a_round_machine_starts_as_one_with_a_cage():
    """The field winding and one damper in q are the cage."""
    x = 2 * np.pi * 60
    L_m, leak, J = 26.13 / x, 0.754 / x, 0.089
    cage = SquirrelCageMotor(
        R_s=0.435, R_r=0.816, L_m=L_m, L_ls=leak, L_lr=leak, pairs=2, J=J, V=180.0, f=60.0
    )
    machine = WoundFieldMachine(
        dampers_d=0,
        pairs=2,
        J=J,
        v_f=0.0,
        R_s=0.435,
        L_ls=leak,
        L_md=L_m,
        L_mq=L_m,
        R_f=0.816,
        L_lf=leak,
        R_1q=0.816,
        L_l1q=leak,
    )
    fan = QuadraticTorque(tau_nominal=-10.0, w_nominal=185.0)
    expected = in_a_row(motor=cage, fan=fan)
    model = lp.compose(
        bus=InfiniteBus(V=180.0, f=60.0),
        motor=machine,
        fan=fan,
        connections=lambda m: [*wires(m.bus, m.motor), lp.connect(m.motor.flange, m.fan.flange)],
    )
    grid = np.linspace(0.0, 0.6, 301)
    runs = [
        lp.simulate(lp.assemble(part), until=0.6, grid=grid, rtol=1e-10)
        for part in (model, expected)
    ]
    for name in ("motor.tau", "motor.w", "motor.i"):
        received, other = (run[name] for run in runs)
        assert received == pytest.approx(other, abs=1e-7 * np.abs(other).max())


@pytest.fixture(scope="module")
def rejected():
    """A fault of three phases, cleared; then the load rejected, and reclosed."""
    return run_reclosing(0.41, grid=2051, rtol=1e-10)


def test_contacts_open_where_their_currents_pass_zero(rejected):
    run = rejected
    opened = [e.time for e in run.events if e.component == "fault" and e.after == "stuck"]
    assert len(opened) == 2
    assert 0.07 < min(opened) < max(opened) < 0.07 + 1 / BASE.f
    steps = np.abs(np.diff(run["fault.i_a"])).max() / BASE.i
    assert steps < 14 * BASE.w * 0.0002 * 1.5  # no jump: slope of 14 pu at line frequency
    after = run.t > max(opened)
    assert np.abs(run["fault.i_a"][after]).max() == 0
    assert np.abs(run["fault.i_c"][after]).max() == 0


def test_after_load_rejection_there_is_neither_current_nor_torque(rejected):
    run = rejected
    opened = max(e.time for e in run.events if e.component == "breaker" and e.after == "stuck")
    assert 0.15 < opened < 0.15 + 1 / BASE.f
    off = (run.t > opened) & (run.t < 0.25)
    for name in "abc":
        assert np.abs(run[f"breaker.i_{name}"][off]).max() < 1e-9 * BASE.i
    assert np.abs(run["gen.tau"][off]).max() < 1e-9 * BASE.tau
    assert np.abs(run["gen.tau"][run.t > 0.26]).max() > 0.5 * BASE.tau


# -- data and bad input ------------------------------------------------------------------------


def test_base_values_are_those_of_the_rated_machine():
    base = PerUnit(S=892.4e6, V=26e3, f=60.0, pairs=2)
    assert pytest.approx(26e3**2 / 892.4e6) == base.Z
    assert 1.5 * base.v * base.i == pytest.approx(892.4e6)
    assert base.tau * base.speed == pytest.approx(892.4e6)
    assert base.psi == pytest.approx(base.L * base.i)
    assert base.J(3.0) * base.speed**2 / 2 == pytest.approx(3.0 * 892.4e6)


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"X_d": (1.79, 0.169, 0.25)}, "X''d = 0.25 pu must be less than X'd = 0.169 pu"),
        ({"X_d": (1.79, 0.169, 0.1)}, "X_l = 0.13 pu must be less than X''d = 0.1 pu"),
        ({"T_do": (4.3, -0.032)}, "T''do = -0.032 s must be positive"),
        ({"T_do": (0.03, 0.04)}, "T''do = 0.04 s must be less than T'do = 0.03 s"),
        ({"T_qo": (0.85,)}, "3 reactances X_q need 2 time constants"),
        ({"X_l": 0.0}, "X_l = 0 pu must be positive"),
        ({"X_d": (1.79,), "T_do": ()}, "X'd and T'do of the field winding"),
        ({"R_a": -0.1}, "must be at least 0 pu"),
        ({"X_d": (1.8, 0.5, 0.4, 0.3, 0.2), "T_do": (4, 3, 2, 1)}, "at most two for each axis"),
    ],
)
def test_standard_parameters_that_do_not_fit_are_refused(changed, text):
    refused(ParameterError, lambda: standard_parameters(BASE, **(STANDARD | changed)), text)


@pytest.mark.parametrize("name", ["S", "V", "f", "pairs"])
def test_a_base_of_zero_is_refused(name):
    with pytest.raises(ParameterError, match=f"{name} = 0"):
        PerUnit(**({"S": 1e6, "V": 1e3, "f": 50.0, "pairs": 1} | {name: 0}))


@pytest.mark.parametrize(
    ("changed", "kind", "text"),
    [
        ({"fault": ShortCircuit(begin=0.2, end=0.1)}, ParameterError, "fault.end = 0.1 s"),
        ({"fault": ShortCircuit(begin=0.2, phases="ag")}, EquationError, "phases = 'ag'"),
        (
            {"gen": without_resistance(dampers_d=3, R_2d=1.0, L_l2d=1.0)},
            EquationError,
            "dampers_d = 3",
        ),
        ({"gen": without_resistance(dampers_d=2)}, ParameterError, "gen.R_2d = 0 Ohm"),
        ({"gen": without_resistance(V_0=0.0)}, ParameterError, "gen.V_0 = 0 V"),
        ({"line": ThreePhaseLine(L=0.0)}, ParameterError, "line.L = 0 H"),
    ],
)
def test_a_model_that_makes_no_sense_is_refused_by_name(changed, kind, text):
    refused(kind, lambda: lp.assemble(Turned(**changed)), text)


def test_parts_without_wires_are_refused():
    with pytest.raises(ConnectError, match="has no pin 'a' or 'a_1'"):
        list(wires(InfiniteBus(V=1.0, f=50.0), Speed(w=1.0)))
