"""Motor with permanent magnets: optima by SciPy, closed forms, a second integration, bad input."""

import numpy as np
import pytest
import scipy
from checks import refused

import lumped as lp
from lumped.components import Ground, MagnetMotor, Speed, VoltageSource
from lumped.errors import ParameterError, SolverError

PAIRS, V_DC, I_MAX, R = 4, 300.0, 400.0, 0.01
FACTOR = 1.5 * PAIRS
LIMIT = V_DC / 3**0.5 - R * I_MAX
KINDS = {
    "salient": {"psi": 0.09, "L_d": 2e-4, "L_q": 5e-4},
    "salient, reaches MTPV": {"psi": 0.06, "L_d": 2e-4, "L_q": 5e-4},
    "strong reluctance": {"psi": 0.03, "L_d": 2e-4, "L_q": 9e-4},
    "round": {"psi": 0.09, "L_d": 2.5e-4, "L_q": 2.5e-4},
    "round, reaches MTPV": {"psi": 0.06, "L_d": 2.5e-4, "L_q": 2.5e-4},
}


class Stand(lp.Component):
    """The motor on a stiff direct voltage, turned by a source of speed."""

    source: lp.Component = VoltageSource(v=V_DC)
    ground: Ground = Ground()
    motor: lp.Component = MagnetMotor(
        pairs=PAIRS, **KINDS["salient"], R=R, I_max=I_MAX, T=1e-3, J=0.05, wanted=0.0
    )
    turn: Speed = Speed(w=0.0)

    def connections(self):
        yield lp.connect(self.source.p, self.motor.p)
        yield lp.connect(self.source.n, self.motor.n, self.ground.pin)
        yield lp.connect(self.motor.flange, self.turn.flange)


@pytest.fixture(scope="module")
def stand():
    return lp.assemble(Stand())


def settle(stand, kind, w, wanted):
    given = {f"motor.{name}": value for name, value in KINDS[kind].items()}
    return lp.equilibrium(stand, parameters=given | {"turn.w": w, "motor.wanted": wanted})


def laws(kind):
    """Torque and square of the flux linkage, of currents in I_MAX."""
    psi, L_d, L_q = KINDS[kind].values()

    def torque(x):
        return FACTOR * (psi - (L_q - L_d) * I_MAX * x[0]) * I_MAX * x[1]

    def flux(x):
        return np.hypot(psi + L_d * I_MAX * x[0], L_q * I_MAX * x[1])

    return torque, flux


def optimise(kind, w, wanted=None):
    """Currents with the least heat for a torque, or with the greatest torque, by SciPy."""
    torque, flux = laws(kind)
    limits = [
        {"type": "ineq", "fun": lambda x: 1 - x @ x},
        {"type": "ineq", "fun": lambda x: (LIMIT - PAIRS * w * flux(x)) / LIMIT},
    ]
    scale = FACTOR * KINDS[kind]["psi"] * I_MAX
    if wanted is not None:
        limits.append({"type": "eq", "fun": lambda x: (torque(x) - wanted) / scale})
    aim = (lambda x: x @ x) if wanted is not None else (lambda x: -torque(x) / scale)
    found = [
        scipy.optimize.minimize(
            aim, begin, constraints=limits, method="SLSQP", options={"ftol": 1e-15, "maxiter": 500}
        )
        for begin in ((-0.9, 0.2), (-0.6, 0.5), (-0.2, 0.2))
    ]
    good = [x for x in found if min(c["fun"](x.x) for c in limits[:2]) > -1e-9]
    best = min(good, key=lambda x: x.fun)
    return best.x * I_MAX


@pytest.mark.parametrize("w", [0.0, 150.0, 400.0, 900.0])
@pytest.mark.parametrize("kind", KINDS)
def test_the_greatest_torque_is_that_of_an_optimum(stand, kind, w):
    torque, _ = laws(kind)
    point = settle(stand, kind, w, 1e4)
    expected = optimise(kind, w)
    assert point["motor.limit"] == pytest.approx(torque(expected / I_MAX), rel=1e-7)
    assert point["motor.tau"] == pytest.approx(point["motor.limit"], rel=1e-9)
    received = np.array([point["motor.i_d"], point["motor.i_q"]])
    assert received == pytest.approx(expected, abs=2e-4 * I_MAX)  # flat: root of the tolerance


@pytest.mark.parametrize("share", [0.15, 0.6, 0.95])
@pytest.mark.parametrize("w", [0.0, 150.0, 400.0, 900.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_torque_takes_the_least_current(stand, kind, w, share):
    _, flux = laws(kind)
    limit = settle(stand, kind, w, 0.0)["motor.limit"]
    point = settle(stand, kind, w, -share * limit)
    assert point["motor.tau"] == pytest.approx(-share * limit, rel=1e-9)
    received = np.array([point["motor.i_d"], -point["motor.i_q"]])
    expected = optimise(kind, w, share * limit)
    assert received == pytest.approx(expected, abs=2e-5 * I_MAX)
    assert np.hypot(*received) == pytest.approx(np.hypot(*expected), rel=1e-6)
    assert PAIRS * w * flux(received / I_MAX) < LIMIT * (1 + 1e-9)


@pytest.mark.parametrize("wanted", [40.0, 1e4])
@pytest.mark.parametrize("kind", KINDS)
def test_weakening_lies_on_the_ellipse_of_the_voltage(stand, kind, wanted):
    _, flux = laws(kind)
    point = settle(stand, kind, 900.0, wanted)
    received = PAIRS * 900.0 * flux(np.array([point["motor.i_d"], point["motor.i_q"]]) / I_MAX)
    expected = LIMIT
    assert received == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "MTPV" in kind])
def test_at_high_speed_the_greatest_torque_is_that_over_voltage(stand, kind):
    """``L (psi_d^2 - psi_q^2) = L_q psi psi_d`` on the ellipse, inside the circle."""
    psi, L_d, L_q = KINDS[kind].values()
    point = settle(stand, kind, 2500.0, 1e4)
    i_d, i_q = point["motor.i_d"], point["motor.i_q"]
    psi_d, psi_q = psi + L_d * i_d, L_q * i_q
    assert np.hypot(i_d, i_q) < 0.99 * I_MAX
    assert (L_q - L_d) * (psi_d**2 - psi_q**2) == pytest.approx(
        L_q * psi * psi_d, abs=1e-7 * L_q * psi * LIMIT / (PAIRS * 2500.0)
    )


def test_the_torque_is_constant_up_to_the_base_speed(stand):
    """MTPA at ``I_max``: ``i_d = (psi - sqrt(psi^2 + 8 L^2 I^2)) / (4 L)``."""
    psi, L_d, L_q = KINDS["salient"].values()
    L = L_q - L_d
    i_d = (psi - np.sqrt(psi**2 + 8 * (L * I_MAX) ** 2)) / (4 * L)
    i_q = np.sqrt(I_MAX**2 - i_d**2)
    base = LIMIT / (PAIRS * np.hypot(psi + L_d * i_d, L_q * i_q))
    full = FACTOR * (psi - L * i_d) * i_q
    received = [
        settle(stand, "salient", share * base, 0.0)["motor.limit"]
        for share in (0.5, 0.999999, 1.01)
    ]
    assert received[:2] == pytest.approx([full, full], rel=1e-12)
    assert received[2] < 0.9999 * full


@pytest.mark.parametrize("wanted", [150.0, -150.0])
def test_the_source_gives_the_power_of_shaft_and_heat(stand, wanted):
    point = settle(stand, "salient", 500.0, wanted)
    heat = 1.5 * R * (point["motor.i_d"] ** 2 + point["motor.i_q"] ** 2)
    received = V_DC * point["motor.i_dc"]
    expected = point["motor.tau"] * 500.0 + heat
    assert received == pytest.approx(expected, rel=1e-9)


def test_within_the_voltage_currents_are_lags(stand):
    given = {"turn.w": 100.0, "motor.wanted": 50.0}
    run = lp.simulate(stand, until=0.01, parameters=given, start={"motor.i_dc": 0.0}, rtol=1e-10)
    end = settle(stand, "salient", 100.0, 50.0)
    for name in ("motor.i_d", "motor.i_q"):
        received, expected = run[name], end[name] * (1 - np.exp(-run.t / 1e-3))
        assert received == pytest.approx(expected, abs=1e-7 * I_MAX)


def test_a_step_beyond_the_voltage_follows_a_second_integration(stand):
    """PI controls with a limited voltage and anti-windup, written out for SciPy."""
    psi, L_d, L_q = KINDS["salient"].values()
    w, T = 500.0, 2e-4
    end = settle(stand, "salient", w, 190.0)
    aim = np.array([end["motor.i_d"], end["motor.i_q"]])
    L, w_e, most = np.array([L_d, L_q]), PAIRS * w, V_DC / 3**0.5

    def rates(_, x):
        i, kept = x[:2], x[2:]
        induced = w_e * np.array([-L_q * i[1], psi + L_d * i[0]])
        u = L / T * (aim - i) + kept + induced
        v = u * min(1.0, most / np.hypot(*u))
        return np.concatenate([(v - R * i - induced) / L, R / T * (aim - i) + R / L * (v - u)])

    given = {"turn.w": w, "motor.wanted": 190.0, "motor.T": T}
    run = lp.simulate(stand, until=0.01, parameters=given, start={"motor.i_dc": 0.0}, rtol=1e-10)
    expected = scipy.integrate.solve_ivp(
        rates, (0, 0.01), np.zeros(4), "DOP853", t_eval=run.t, rtol=1e-11, atol=1e-11, max_step=1e-5
    ).y
    lag = aim[1] * (1 - np.exp(-run.t / T))
    assert np.abs(run["motor.i_q"] - lag).max() > 0.2 * aim[1]  # the voltage does limit
    for name, course in zip(("i_d", "i_q", "x_d", "x_q"), expected, strict=True):
        assert run[f"motor.{name}"] == pytest.approx(course, abs=1e-6 * np.abs(course).max())


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"motor.L_d": 0.0}, "motor.L_d = 0 H"),
        ({"motor.L_q": 1e-4}, "motor.L_q = 0.0001 H"),
        ({"motor.I_max": -1.0}, "motor.I_max = -1 A"),
        ({"motor.T": 0.0}, "motor.T = 0 s"),
    ],
)
def test_data_that_make_no_sense_are_refused(changed, text):
    refused(ParameterError, lambda: lp.assemble(Stand().with_(changed)), text)


@pytest.mark.parametrize(
    "changed",
    [{"source.v": 6.0}, {"turn.w": 5000.0}, {"source.v": -V_DC}],
    ids=["voltage", "speed", "reversed poles"],
)
def test_a_voltage_below_that_of_current_and_magnets_is_refused(stand, changed):
    refused(
        SolverError,
        lambda: lp.simulate(stand, until=0.01, parameters=changed),
        "motor",
        "needed share of the voltage",
        "Raise the direct voltage",
    )
