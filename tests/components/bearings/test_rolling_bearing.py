"""Rolling bearings by the catalogue's formulas in NumPy, run-down by quadrature, seals, windage."""

import numpy as np
import pytest
from rows import assemble_one, assemble_row, in_a_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import (
    DEEP_GROOVE,
    AngularContact,
    BallBearingInBath,
    DeepGroove,
    DiscWindage,
    GearWindage,
    Inertia,
    RollingBearing,
    ShaftSeal,
    Speed,
    SphericalRoller,
    Torque,
    viscosity,
)
from lumped.errors import EquationError, ParameterError, SolverError

RPM = np.pi / 30
SIZE = {"d": 0.05, "D": 0.09, "nu_40": 46e-6, "nu_100": 6.8e-6, "K_rs": 3e-8, "mu_film": 0.05}
ROLLER = (1.6e-6, 5.84, 2.81e-6, 5.8, 3.62e-3, 508.0, 8.8e-3, 117.0)
LOADS = {"F_r": 3000.0, "F_a": 500.0, "T": 343.15}
KINDS = {
    "radial": (DeepGroove(23200.0, *DEEP_GROOVE["62"]), 3.1, 3000.0, 0.0),
    "groove": (DeepGroove(23200.0, *DEEP_GROOVE["62"]), 3.1, 3000.0, 500.0),
    "angular": (AngularContact(), 4.4, 3000.0, 2000.0),
    "spherical": (SphericalRoller(*ROLLER), 5.5, 9000.0, 1000.0),
}


def walther(T, nu_40=46.0, nu_100=6.8):
    """Viscosity in mm2/s by decimal logarithms."""
    one_, two = (np.log10(np.log10(nu + 0.8)) for nu in (nu_40, nu_100))
    slope = (one_ - two) / np.log10(373.15 / 313.15)
    return 10**10 ** (two + slope * np.log10(373.15 / T)) - 0.8


def variables(kind, d_m, n, loads=None):
    """G_rr and G_sl of the bearings above, as in the catalogue, and K_Z."""
    _, K_Z, *own = KINDS[kind]
    r, a = loads or own
    if kind == "radial":
        return 3.9e-7 * d_m**1.96 * r**0.54, 3.23e-3 * d_m**-0.26 * r ** (5 / 3), K_Z
    if kind == "groove":
        sine = np.sin(np.radians(24.6 * (a / 23200) ** 0.24))
        G_rr = 3.9e-7 * d_m**1.96 * (r + 1.7 / sine * a) ** 0.54
        thrust = r**5 + 36.5 * d_m**1.5 / sine * a**4
        return G_rr, 3.23e-3 * d_m**-0.145 * thrust ** (1 / 3), K_Z
    if kind == "angular":
        ball = 1.9e-12 * d_m**4 * n**2
        G_rr = 5.03e-7 * d_m**1.97 * (r + ball + 1.97 * a) ** 0.54
        ball *= 1.91 / 1.9
        return G_rr, 1.3e-2 * d_m**0.26 * ((r + ball) ** (4 / 3) + 0.68 * a ** (4 / 3)), K_Z
    G_rr = min(
        1.6e-6 * d_m**1.85 * (r + 5.84 * a) ** 0.54, 2.81e-6 * d_m**2.3 * (r + 5.8 * a) ** 0.31
    )
    ellipse = 3.62e-3 * d_m**0.25 * (r**4 + 508 * a**4) ** (1 / 3)
    return G_rr, min(ellipse, 8.8e-3 * d_m**0.94 * (r**3 + 117 * a**3) ** (1 / 3)), K_Z


def moment(kind, n, nu, d=50.0, D=90.0, loads=None):
    """Friction in N.m at a speed in 1/min."""
    d_m = (d + D) / 2
    G_rr, G_sl, K_Z = variables(kind, d_m, n, loads)
    ish = 1 / (1 + 1.84e-9 * (n * d_m) ** 1.28 * nu**0.64)
    rs = 1 / np.exp(3e-8 * nu * n * (d + D) * np.sqrt(K_Z / (2 * (D - d))))
    bl = 1 / np.exp(2.6e-8 * (n * nu) ** 1.4 * d_m)
    return 1e-3 * (ish * rs * G_rr * (nu * n) ** 0.6 + G_sl * (bl * 0.12 + (1 - bl) * 0.05))


def bearing(case, /, **given):
    function, K_Z, F_r, F_a = KINDS[case]
    values = SIZE | {"kind": function, "K_Z": K_Z, "F_r": F_r, "F_a": F_a, "T": 343.15} | given
    return RollingBearing(**values)


def torque_at(part, w, path="part.tau"):
    return lp.start_point(assemble_row(turn=Speed(w=w), part=part))[path]


def oil(T, nu_40, nu_100):
    def equations(self):
        yield self.nu == viscosity(250.0 + lp.time, nu_40, nu_100)

    system = assemble_one(equations, nu=lp.var("m2/s", "viscosity"), keep=["nu"])
    return lp.simulate(system, until=200.0, grid=[T - 250.0])["nu"][0]


@pytest.mark.parametrize(("celsius", "published"), [(40, 30.8), (80, 9.12), (90, 7.25), (100, 5.9)])
def test_viscosity_is_that_of_the_data_sheet_of_an_oil(celsius, published):
    """SAE 70W-75W gear oil: 30.8 and 5.9 mm2/s at 40 and 100 degrees Celsius."""
    received = oil(celsius + 273.15, 30.8e-6, 5.9e-6)
    assert 1e6 * received == pytest.approx(published, rel=1e-3)
    assert 1e6 * received == pytest.approx(walther(celsius + 273.15, 30.8, 5.9), rel=1e-12)


@pytest.mark.parametrize("n", [20.0, 1500.0, 9000.0])
@pytest.mark.parametrize("kind", KINDS)
def test_friction_is_that_of_the_formulas_of_the_catalogue(kind, n):
    received = torque_at(bearing(kind, M_seal=0.02), n * RPM)
    assert received == pytest.approx(moment(kind, n, walther(343.15)) + 0.02, rel=1e-8)
    assert torque_at(bearing(kind, M_seal=0.02), -n * RPM) == pytest.approx(-received, rel=1e-12)


def test_the_formulas_have_both_contacts_of_a_spherical_roller_bearing():
    """The rows that the cases above do not take."""
    line = (1.0, 5.84, 2.81e-6, 5.8, 1.0, 508.0, 8.8e-3, 117.0)
    received = torque_at(bearing("spherical", kind=SphericalRoller(*line)), 1500 * RPM)
    r, a, d_m, nu = 9000.0, 1000.0, 70.0, walther(343.15)
    G_rr = 2.81e-6 * d_m**2.3 * (r + 5.8 * a) ** 0.31
    G_sl = 8.8e-3 * d_m**0.94 * (r**3 + 117 * a**3) ** (1 / 3)
    ish = 1 / (1 + 1.84e-9 * (1500 * d_m) ** 1.28 * nu**0.64)
    rs = np.exp(-3e-8 * nu * 1500 * 140 * np.sqrt(5.5 / 80))
    bl = np.exp(-2.6e-8 * (1500 * nu) ** 1.4 * d_m)
    expected = ish * rs * G_rr * (nu * 1500) ** 0.6 + G_sl * (bl * 0.12 + (1 - bl) * 0.05)
    assert received == pytest.approx(1e-3 * expected, rel=1e-8)


@pytest.mark.parametrize("level", [0.01, 0.03, 0.06, 0.2])
def test_an_oil_bath_drags_by_the_formula_of_the_catalogue(level):
    V_M, n, nu, d_m = 3e-4, 3000.0, walther(343.15), 70.0
    loaded = {"K_rs": 0.0, "kind": KINDS["radial"][0], "F_r": 3000.0, "F_a": 0.0, "T": 343.15}
    part = BallBearingInBath(**SIZE | loaded, H=level, V_M=V_M)
    dry = torque_at(RollingBearing(**SIZE | loaded), n * RPM)
    H = min(1e3 * level, 1.2 * d_m)
    t = 2 * np.arccos((0.6 * d_m - H) / (0.6 * d_m))
    f_t = np.sin(t / 2) if t < np.pi else 1.0
    K_ball = 3.1 * 140 / 40 * 1e-12
    R_s = 0.36 * d_m**2 * (t - np.sin(t)) * 0.05 * 3.1 * 140 / 40
    ring = 1.093e-7 * n**2 * d_m**3 * (n * d_m**2 * f_t / nu) ** -1.379 * R_s
    drag = 1e-3 * (0.4 * V_M * K_ball * d_m**5 * n**2 + ring)
    assert torque_at(part, n * RPM) - dry == pytest.approx(drag, rel=1e-6)
    assert drag > 1e-4 * dry


@pytest.mark.parametrize("kind", ["groove", "angular"])
def test_a_rotor_runs_down_in_the_time_of_the_quadrature(kind):
    J, w_0 = 0.05, 160.0
    run = lp.simulate(
        assemble_row(rotor=Inertia(J=J, w=w_0), part=bearing(kind)), until=200.0, rtol=1e-10
    )
    nu = walther(343.15)
    # with w = x^2 the root of the speed at standstill is smooth
    stop = quad(
        lambda x: 2 * x * J / moment(kind, x * x / RPM, nu), 0, w_0**0.5, epsabs=0, epsrel=1e-11
    )[0]
    (event,) = run.events
    assert event.after == "stuck"
    assert event.time == pytest.approx(stop, rel=1e-6)
    assert run["rotor.w"][-1] == 0.0


def test_it_breaks_away_at_the_starting_torque_of_the_loads():
    """0.15 of the sliding variable, and the seals; then 0.12."""
    _, G_sl, _ = variables("groove", 70.0, 0.0)
    start = 1e-3 * 0.15 * G_sl + 0.03
    drive = Torque(tau=0.1 * lp.time)
    model = in_a_row(drive=drive, rotor=Inertia(J=1.0), part=bearing("groove", M_seal=0.03))
    run = lp.simulate(lp.assemble(model), until=12 * start, grid=None)
    slips = next(event for event in run.events if event.after == "forward")
    assert slips.time == pytest.approx(start / 0.1, rel=1e-9)
    after = run["part.tau"][run.t > slips.time][0]
    assert after == pytest.approx(1e-3 * 0.12 * G_sl + 0.03, rel=1e-2)


def test_warm_oil_lowers_the_friction_during_a_run():
    T = 313.15 + 6 * lp.time
    part = bearing("radial", T=T)
    system = assemble_row(turn=Speed(w=3000 * RPM), part=part, keep=["part.tau"])
    run = lp.simulate(system, until=10.0, grid=5)
    expected = [moment("radial", 3000.0, walther(313.15 + 6 * t)) for t in run.t]
    assert run["part.tau"] == pytest.approx(expected, rel=1e-8)
    assert run["part.tau"][-1] < 0.6 * run["part.tau"][0]


LOADS_THROUGH_ZERO = {
    "ramp": (100 * lp.time, 200.0),
    "magnitude": (500 * abs(lp.ops.sin(5 * lp.time + 0.3)), 500 * abs(np.sin(10.3))),
    "half waves": (lp.ops.maximum(500 * lp.ops.sin(5 * lp.time + 4.0), 0.0), 500 * np.sin(14.0)),
    "table": (lp.ops.table([0.0, 0.5, 1.0, 2.0], [300.0, 0.0, 0.0, 300.0]), 300.0),
}


@pytest.mark.parametrize("way", ["F_r", "F_a"])
@pytest.mark.parametrize("load", LOADS_THROUGH_ZERO)
@pytest.mark.parametrize("kind", ["groove", "angular", "spherical"])
def test_a_load_may_come_down_to_zero(kind, load, way):
    signal, end = LOADS_THROUGH_ZERO[load]
    part = bearing(kind, **{"F_r": 0.0, "F_a": 0.0, way: signal})
    run = lp.simulate(assemble_row(turn=Speed(w=1500 * RPM), part=part, keep=["part.tau"]), until=2)
    loads = (end, 0.0) if way == "F_r" else (0.0, end)
    case = "radial" if (kind, way) == ("groove", "F_r") else kind
    expected = moment(case, 1500.0, walther(343.15), loads=loads)
    assert run["part.tau"][-1] == pytest.approx(expected, rel=1e-8)
    assert run["part.tau"].min() >= 0.0


@pytest.mark.parametrize("kind", ["groove", "angular", "spherical"])
def test_without_load_it_has_derivatives(kind):
    part = bearing(kind, F_r=0.0, F_a=0.0, M_seal=0.02)
    system = assemble_row(rotor=Inertia(J=0.05, w=160.0), part=part)
    of = lp.functionals.final("rotor.w")
    found = lp.gradient(system, of=[of], by=["part.M_seal"], until=1.0, rtol=1e-10)
    (slope,) = found.derivatives.ravel()
    step = [
        lp.simulate(system, until=1.0, rtol=1e-11, parameters={"part.M_seal": M}).value(of)
        for M in (0.0201, 0.0199)
    ]
    assert slope == pytest.approx((step[0] - step[1]) / 2e-4, rel=1e-6)


class TestSeal:
    def test_its_loss_is_that_of_the_technical_report(self):
        """7.69e-6 d^2 n: 50 mm and 1500 1/min lose 28.8 W."""
        w = 1500 * RPM
        tau = torque_at(ShaftSeal(d=0.05), w)
        assert tau * w == pytest.approx(7.69e-6 * 50**2 * 1500, rel=1e-12)

    def test_it_holds_up_to_its_peak(self):
        limit = 1.3 * 7.69e-6 * 50**2 / RPM
        drive = Torque(tau=lp.time)
        part = ShaftSeal(d=0.05, peak=1.3)
        run = lp.simulate(assemble_row(drive=drive, rotor=Inertia(J=1.0), part=part), until=1.0)
        assert run.events[0].time == pytest.approx(limit, rel=1e-9)


class TestWindage:
    R, rho, nu = 0.3, 1.2, 1.5e-5

    def test_a_laminar_disc_runs_down_as_its_closed_form(self):
        """``J dw/dt = -k w^1.5``: ``w^-0.5 = w_0^-0.5 + k t / (2 J)``."""
        J, w_0 = 0.02, 8.0
        disc = DiscWindage(R=self.R, rho=self.rho, nu=self.nu)
        run = lp.simulate(
            assemble_row(rotor=Inertia(J=J, w=w_0), part=disc), until=500.0, rtol=1e-11
        )
        assert w_0 * self.R**2 / self.nu < 55_600
        k = 0.616 * np.pi * self.rho * self.R**4 * self.nu**0.5
        expected = (w_0**-0.5 + k * run.t / (2 * J)) ** -2
        assert run["rotor.w"] == pytest.approx(expected, rel=1e-8)

    @pytest.mark.parametrize("w", [2.0, 100.0, -300.0])
    def test_its_coefficient_is_the_greater_of_laminar_and_turbulent(self, w):
        received = torque_at(DiscWindage(R=self.R, rho=self.rho, nu=self.nu), w)
        Re = abs(w) * self.R**2 / self.nu
        C_M = 3.87 / Re**0.5 if Re < 55_600 else 0.146 / Re**0.2
        assert received == pytest.approx(
            np.sign(w) * C_M * self.rho * self.R**5 * w * w / 2, rel=2e-4
        )

    @pytest.mark.parametrize(("name", "words"), [("rho", "density = -"), ("nu", "viscosity = -")])
    def test_a_fluid_of_no_sense_is_refused(self, name, words):
        fluid = {"rho": self.rho, "nu": self.nu}
        disc = DiscWindage(R=self.R, **fluid | {name: fluid[name] * lp.ops.cos(lp.time)})
        with pytest.raises(SolverError, match=words):
            lp.simulate(assemble_row(turn=Speed(w=9.0), part=disc), until=2.0)

    def test_air_takes_little_of_a_gear_at_fifty_metres_a_second(self):
        w = 500.0
        received = torque_at(GearWindage(d=0.2, b=0.03, m=0.004), w)
        expected = 1.37e-9 * 50**1.9 * 200**1.6 * 30**0.52 * 4**0.69
        assert received == pytest.approx(expected, rel=1e-10)


class TestRefused:
    def test_a_bearing_without_a_type(self):
        values = {**SIZE, **LOADS}
        with pytest.raises(EquationError, match="kind = None"):
            assemble_row(rotor=Inertia(J=1.0), part=RollingBearing(**values))

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"nu_100": -1e-6}, "nu_100 = -1e-06 m2/s"),
            ({"nu_40": 5e-6}, "nu_40"),
            ({"D": 0.04}, "D"),
            ({"F_r": -1.0}, "F_r"),
            ({"T": 70.0}, "T = 70 K .*in kelvin.* at least 200"),
        ],
    )
    def test_numbers_that_make_no_sense(self, given, words):
        with pytest.raises(ParameterError, match=words):
            assemble_row(rotor=Inertia(J=1.0), part=bearing("groove", **given))

    def test_a_constant_that_is_no_number(self):
        with pytest.raises(ParameterError, match="C_0 = -3"):
            DeepGroove(-3, *DEEP_GROOVE["62"])

    def test_a_load_that_turns_negative_during_a_run(self):
        part = bearing("angular", F_r=1000 * (1 - lp.time))
        system = assemble_row(turn=Speed(w=10.0), part=part)
        with pytest.raises(SolverError, match="radial load"):
            lp.simulate(system, until=2.0)
