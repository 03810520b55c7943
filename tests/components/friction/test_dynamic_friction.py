"""Dahl, LuGre and Bouc-Wen against closed forms and SciPy."""

import itertools

import numpy as np
import pytest
from rows import assemble_row
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.components import BoucWen, Dahl, Fixed, Inertia, LuGre, Speed, Spring, Stribeck, Torque
from lumped.errors import EquationError

OMEGA = 2 * np.pi


def driven(part, w):
    return assemble_row(wall=Fixed(), part=part, drive=Speed(w=w))


def swung(part, amplitude):
    """A part whose one flange moves as ``amplitude sin(2 pi t)``."""
    return driven(part, amplitude * OMEGA * lp.ops.cos(OMEGA * lp.time))


def work(system, period):
    """Work of one period, counted from 0."""
    run = lp.simulate(system, until=period + 1.0, rtol=1e-11)
    between = (float(period), period + 1.0)
    return run.value(lp.functionals.integral("part.tau", "part.w_rel", between=between))


# -- Dahl --------------------------------------------------------------------------------------

C, TAU = 1000.0, 5.0


def test_dahl_comes_to_its_torque_by_an_exponential_and_turns_in_the_same_way():
    turns = lp.ops.where(lp.time < 0.01, 1.0, -1.0)
    run = lp.simulate(driven(Dahl(c=C, tau_c=TAU), turns), until=0.03, rtol=1e-12)
    phi, tau = run["part.phi_rel"], run["part.tau"]
    there, top = run.t <= 0.01, TAU * (1 - np.exp(-C * 0.01 / TAU))
    forward = TAU * (1 - np.exp(-C * phi / TAU))
    back = -TAU + (top + TAU) * np.exp(-C * (0.01 - phi) / TAU)
    assert tau == pytest.approx(np.where(there, forward, back), abs=1e-10)


def test_a_loop_of_dahl_has_its_area():
    """Steady: ``4 A tau - 4 tau^2 / c tanh(c A / tau)``, from the exponentials both ways."""
    amplitude = 0.008
    area = 4 * amplitude * TAU - 4 * TAU**2 / C * np.tanh(C * amplitude / TAU)
    assert work(swung(Dahl(c=C, tau_c=TAU), amplitude), 4) == pytest.approx(area, rel=1e-8)


# -- LuGre -------------------------------------------------------------------------------------

# of Canudas de Wit and others 1995, as public programs have them
SIGMA_0, SIGMA_1, SIGMA_2, F_C, F_S, V_S = 1e5, np.sqrt(1e5), 0.4, 1.0, 1.5, 0.001


def g(w):
    return F_C + (F_S - F_C) * lp.ops.exp(-((w / V_S) ** 2))


LUGRE = {"c": SIGMA_0, "d": SIGMA_1, "d_viscous": SIGMA_2, "characteristic": g}


@pytest.mark.parametrize("w", [1e-4, -1e-3, 0.02, -5.0])
def test_lugre_has_its_curve_in_steady_motion(w):
    run = lp.simulate(driven(LuGre(**LUGRE), w), until=5e-4 / abs(w), rtol=1e-10)
    steady = F_C + (F_S - F_C) * np.exp(-((w / V_S) ** 2))
    assert run["part.tau"][-1] == pytest.approx(np.sign(w) * steady + SIGMA_2 * w, rel=1e-9)


def test_before_sliding_lugre_is_a_spring_that_creeps():
    """With one value of g it bends as Dahl: ``phi = -(g / c) ln(1 - tau / g)``; at first c."""
    rises = 0.9 * lp.time
    part = LuGre(c=SIGMA_0, characteristic=((0.0, F_C),), d=0.0)
    system = assemble_row(wall=Fixed(), part=part, body=Inertia(J=1e-3), push=Torque(tau=rises))
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    tau = run["part.tau"][-1]
    creep = -F_C / SIGMA_0 * np.log(1 - tau / F_C)
    assert run["part.phi_rel"][-1] == pytest.approx(creep, rel=1e-7)


def test_stick_slip_follows_another_integration():
    """A mass on a spring, the end of which moves at 0.1: 1 kg and 2 N/m."""
    J, k, v = 1.0, 2.0, 0.1
    system = assemble_row(
        wall=Fixed(), part=LuGre(**LUGRE), body=Inertia(J=J), spring=Spring(c=k), drive=Speed(w=v)
    )
    run = lp.simulate(system, until=30.0, rtol=1e-9)

    def rates(t, y):
        x, w, z = y
        curve = F_C + (F_S - F_C) * np.exp(-((w / V_S) ** 2))
        z_rate = w - SIGMA_0 * abs(w) / curve * z
        tau = SIGMA_0 * z + SIGMA_1 * z_rate + SIGMA_2 * w
        return [w, (k * (v * t - x) - tau) / J, z_rate]

    found = solve_ivp(rates, (0, 30), [0, 0, 0], "Radau", rtol=1e-10, atol=1e-13)
    moved = run["part.phi_rel"]
    assert moved[-1] == pytest.approx(found.y[0, -1], rel=1e-5)
    assert run["body.w"].max() == pytest.approx(found.y[1].max(), rel=1e-3)
    assert (run["body.w"] < 1e-3).mean() > 0.1
    assert run.statistics.steps < 20_000


def lowest_loss(d_viscous):
    """Least loss while it is bent slowly up to its static torque and then moved fast."""
    part = LuGre(**LUGRE | {"d_viscous": d_viscous})
    run = lp.simulate(driven(part, lp.ops.where(lp.time < 3.0, 1e-4, 0.05)), until=3.01, rtol=1e-9)
    return run.value(lp.functionals.lowest(run.system.model.part.loss()))


def test_lugre_gives_no_energy_from_the_bound_of_its_viscous_damping_on():
    """Just after the start ``g w x^2 + d w^2 (1 - x) + d_viscous w^2`` with ``x = static / g``."""
    w, x = 0.05, (F_C + (F_S - F_C) * np.exp(-((1e-4 / V_S) ** 2))) / F_C
    least = F_C * w * x**2 + SIGMA_1 * w**2 * (1 - x)
    assert least < 0
    assert lowest_loss(0.0) == pytest.approx(least, rel=1e-6)
    assert lowest_loss(SIGMA_1 * (F_S / F_C - 1)) >= 0.0


# -- Bouc-Wen ----------------------------------------------------------------------------------

PHI_Y = 0.005


def test_a_loop_of_bouc_wen_with_straight_returns_has_its_area():
    """N = 1, beta = 1/2: straight back to zero, then an exponential; the tip is a fixed point."""
    amplitude, alpha = 0.02, 0.1
    tip = brentq(
        lambda z: PHI_Y * (1 - np.exp(-(2 * amplitude - z) / PHI_Y)) - z, 0, PHI_Y, xtol=1e-16
    )
    length = 2 * amplitude - tip
    half = -(tip**2) / 2 + PHI_Y * (length - PHI_Y * (1 - np.exp(-length / PHI_Y)))
    part = BoucWen(c=C, alpha=alpha, phi_y=PHI_Y)
    area = (1 - alpha) * C * 2 * half
    assert work(swung(part, amplitude), 6) == pytest.approx(area, rel=1e-8)


@pytest.mark.parametrize(("beta", "n"), [(0.5, 1.0), (0.8, 2.0), (1.3, 3.5)])
def test_bouc_wen_in_the_usual_parameters(beta, n):
    """``der(z) = w - b abs(w) abs(z)^(n-1) z - g w abs(z)^n``, by SciPy in pieces of one way."""
    alpha, amplitude = 0.2, 0.012
    b, gamma = beta / PHI_Y**n, (1 - beta) / PHI_Y**n
    part = BoucWen(c=C, alpha=alpha, phi_y=PHI_Y, beta=beta, n=n)
    run = lp.simulate(swung(part, amplitude), until=1.25, rtol=1e-11)

    def slope(way):
        def rate(x, z):
            return 1 - way * b * abs(z) ** (n - 1) * z - gamma * abs(z) ** n

        return rate

    z, ends = 0.0, [0.0, amplitude, -amplitude, amplitude]
    for begin, end in itertools.pairwise(ends):
        way = np.sign(end - begin)
        z = solve_ivp(slope(way), (begin, end), [z], "DOP853", rtol=1e-12, atol=1e-15).y[0, -1]
    assert run["part.z"][-1] == pytest.approx(z, rel=1e-8)
    torque = C * (alpha * amplitude + (1 - alpha) * z)
    assert run["part.tau"][-1] == pytest.approx(torque, rel=1e-8)


def test_a_body_is_slowed_with_its_energy_kept():
    """What a body loses goes into springs and heat (a certificate compares them)."""
    for part in (BoucWen(c=C, phi_y=PHI_Y, alpha=0.1), Dahl(c=C, tau_c=TAU), LuGre(**LUGRE)):
        system = assemble_row(wall=Fixed(), part=part, body=Inertia(J=1.0, w=0.3))
        run = lp.simulate(system, until=0.05, certify=True)
        assert run.certificate.energy.error < 1e-6


def test_stribeck_serves_as_its_curve():
    curve = Stribeck(coulomb=F_C, static=F_S, decay=100.0)
    run = lp.simulate(driven(LuGre(c=1e4, characteristic=curve), 0.01), until=1.0, rtol=1e-10)
    assert run["part.tau"][-1] == pytest.approx(F_C + 0.5 * np.exp(-1.0), rel=1e-9)


def test_the_knee_has_a_derivative_by_its_sharpness_from_rest_on():
    """Forward ``u = z / phi_y`` solves ``x = int(1 / (1 - s^n))`` from 0 to u; n varies at 2."""
    x, w = 0.8, 0.5
    system = driven(BoucWen(c=C, phi_y=PHI_Y, n=2.0), w)
    of, until = lp.functionals.final("part.tau"), x * PHI_Y / w
    found = lp.gradient(system, of=[of], by=["part.n"], until=until, rtol=1e-10)
    u = np.tanh(x)
    spread = quad(lambda s: s**2 * np.log(s) / (1 - s**2) ** 2, 0.0, u, epsabs=0, epsrel=1e-12)[0]
    assert found.values[0] == pytest.approx(C * PHI_Y * u, rel=1e-8)
    assert found.derivatives[0, 0] == pytest.approx(-C * PHI_Y * (1 - u**2) * spread, rel=1e-6)


@pytest.mark.parametrize(
    "characteristic", [((0, 1.0), (1, 0.5), (2, 0.0)), ((0, 0.0), (1, 1.0)), lambda w: 0.0 * w]
)
def test_bristles_without_friction_are_refused(characteristic):
    with pytest.raises(EquationError, match="friction must be above 0"):
        driven(LuGre(c=C, characteristic=characteristic), 1.0)
