import numpy as np
import pytest
from rows import assemble_row
from torsional_cases import columns

import lumped as lp
from lumped.components import (
    Fixed,
    Inertia,
    Spring,
    Torque,
    TunedDamper,
    TunedLossDamper,
    ViscousDamper,
)
from lumped.errors import OptionError, ParameterError


def drive(damper, torque=0.0):
    """An inertia of 1 on a spring of 1 to the ground, with a damper."""
    return assemble_row(
        torque=Torque(tau=torque),
        damper=damper,
        main=Inertia(J=1.0),
        spring=Spring(c=1.0),
        ground=Fixed(),
    )


def shaken(damper, g, order=1):
    """Response of the spring, whose twist for a torque of 1 is 1, at frequencies g."""
    return lp.vibration.order_response(
        drive(damper),
        speeds=np.atleast_1d(g),
        of=["spring.phi_rel"],
        excitations={"torque.tau": {order: 1.0}},
    )


def largest(damper, g):
    """Largest vibration near the frequency g."""
    return shaken(damper, g * np.linspace(0.9, 1.1, 2001)).magnitude("spring.phi_rel", 1).max()


def houdaille(mu, z, g):
    """Amplification with a ring in fluid (Den Hartog)."""
    top = 4 * z**2 + g**2
    bottom = 4 * z**2 * (g**2 + mu * g**2 - 1) ** 2 + g**2 * (g**2 - 1) ** 2
    return np.sqrt(top / bottom)


def test_the_optimum_of_a_viscous_damper_is_that_of_den_hartog():
    table = columns("10_viscous_damper", "optimum.csv")
    for i, mu in enumerate(table["mu"]):
        best = ViscousDamper.optimum(mu)
        for found, name in (
            (best.ring, "zeta_opt_c_over_2_Jd_wn"),
            (best.main, "zeta_opt_c_over_2_J_wn"),
            (best.frequency, "g_at_peak"),
            (best.peak, "peak_amplification"),
            (2 * best.main, "c_opt_over_J_wn"),
        ):
            assert found == pytest.approx(table[name][i], rel=1e-9), (mu, name)


@pytest.mark.parametrize("mu", [0.02, 0.05, 0.1, 0.2, 0.25, 0.3, 0.6, 1.0, 1.5, 2.0])
def test_a_drive_with_the_best_viscous_damper_has_that_peak(mu):
    best = ViscousDamper.optimum(mu)
    damper = ViscousDamper(J_ring=mu, d=2 * best.main)
    there = shaken(damper, best.frequency).magnitude("spring.phi_rel", 1)[0]
    assert there == pytest.approx(1 + 2 / mu, rel=1e-12)
    assert largest(damper, best.frequency) <= there * (1 + 1e-12)
    # any other damping has a larger peak, as all curves pass through this point
    for share in (0.8, 1.25):
        other = ViscousDamper(J_ring=mu, d=2 * share * best.main)
        assert largest(other, best.frequency) > there * 1.001


def test_other_dampings_vibrate_as_the_table_says():
    table = columns("10_viscous_damper", "off_optimum.csv")
    rows = zip(*(table[name] for name in table), strict=True)
    for mu, z, peak, g in rows:
        damper = ViscousDamper(J_ring=mu, d=2 * mu * z)
        there = shaken(damper, g).magnitude("spring.phi_rel", 1)[0]
        assert there == pytest.approx(peak, rel=1e-8)
        assert largest(damper, g) <= peak * (1 + 1e-8)


@pytest.mark.parametrize("mu", [0.25, 1.0])
def test_a_viscous_damper_vibrates_as_its_closed_form_says(mu):
    g = np.linspace(0.3, 2.0, 40)
    for z in (0.05, 0.3, 1.0, 2.0):
        found = shaken(ViscousDamper(J_ring=mu, d=2 * mu * z), g).magnitude("spring.phi_rel", 1)
        assert np.abs(found / houdaille(mu, z, g) - 1).max() < 1e-12


def test_power_of_a_viscous_damper_is_the_mean_over_the_cycle_of_all_orders():
    damper = ViscousDamper(J_ring=0.4, d=0.3)
    speed = 0.6
    response = lp.vibration.order_response(
        drive(damper),
        speeds=[speed],
        of=["damper.w_rel", "main.w"],
        excitations={"torque.tau": {1: 1.0, 2.5: 0.7j}},
    )
    power = response.mean_power("damper.power")[0]
    w_rel = np.abs(response["damper.w_rel"][0])
    assert power == pytest.approx(0.5 * 0.3 * w_rel**2, rel=1e-12)
    push = lp.ops.cos(speed * lp.time) - 0.7 * lp.ops.sin(2.5 * speed * lp.time)
    orbit = lp.periodic(drive(damper, push), period=4 * np.pi / speed, rtol=1e-10)
    run = orbit.run
    mean = np.trapezoid(run["damper.power"], run.t) / (run.t[-1] - run.t[0])
    assert power.sum() == pytest.approx(mean, rel=1e-7)
    # what drives gives it: the mean of the product of a torque that is no state, and a speed
    model = lp.compose(main=Inertia(J=1.0), torque=Torque(tau=0.0))
    supplied = response.mean_power(model.torque.tau * model.main.w)[0]
    assert supplied == pytest.approx(power, rel=1e-10)


@pytest.mark.parametrize("d", [0.0, 0.02, 0.3])
def test_all_dampings_of_a_tuned_damper_pass_through_two_points(d):
    # Den Hartog, section 3.3: with the tuning 1/(1 + mu) both have the height sqrt(1 + 2/mu)
    mu = 0.2
    f = 1 / (1 + mu)
    half = (1 + f**2 + mu * f**2) / (2 + mu)
    for side in (-1, 1):
        g = np.sqrt(half + side * np.sqrt(half**2 - 2 * f**2 / (2 + mu)))
        damper = TunedDamper(J_ring=mu, c=mu * f**2, d=d)
        found = shaken(damper, g).magnitude("spring.phi_rel", 1)[0]
        assert found == pytest.approx(np.sqrt(1 + 2 / mu), rel=1e-10)


@pytest.mark.parametrize("kind", ["viscous", "loss"])
def test_a_tuned_damper_vibrates_as_its_matrices_say(kind):
    mu, c, d, eta = 0.15, 0.11, 0.03, 0.25
    if kind == "viscous":
        damper = TunedDamper(J_ring=mu, c=c, d=d)
    else:
        damper = TunedLossDamper(J_ring=mu, c=c, eta=eta, w_loss=0.7)
    g = np.linspace(0.2, 1.9, 30)
    response = shaken(damper, g, order=1)
    power = response.mean_power("damper.power")[:, 0]
    for k, w in enumerate(g):
        kc = c + 1j * w * d if kind == "viscous" else c * (1 + 1j * eta)
        main, ring = np.linalg.solve([[1 + kc - w**2, -kc], [-kc, kc - mu * w**2]], [1.0, 0.0])
        assert abs(response["spring.phi_rel"][k, 0]) == pytest.approx(abs(main), rel=1e-11)
        lost = 0.5 * kc.imag * w * abs(main - ring) ** 2
        assert power[k] == pytest.approx(lost, rel=1e-10)


@pytest.mark.parametrize(
    ("make", "error", "match"),
    [
        (lambda: drive(ViscousDamper(J_ring=0.0, d=1.0)), ParameterError, "damper.J_ring"),
        (lambda: drive(ViscousDamper(J_ring=1.0, d=-1.0)), ParameterError, "damper.d"),
        (lambda: drive(TunedDamper(J_ring=1.0, c=0.0, d=1.0)), ParameterError, "damper.c"),
        (
            lambda: drive(TunedLossDamper(J_ring=1.0, c=1.0, eta=-0.1, w_loss=1.0)),
            ParameterError,
            "damper.eta",
        ),
        (lambda: ViscousDamper.optimum(0.0), OptionError, "mu = 0.0 must be above zero"),
    ],
)
def test_slips_are_named(make, error, match):
    with pytest.raises(error, match=match):
        make()
