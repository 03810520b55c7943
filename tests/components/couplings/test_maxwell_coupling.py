import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, MaxwellCoupling, Torque
from lumped.errors import DeclarationError, EquationError, ParameterError, SolverError

C, J = 8e4, 20.0
ROWS = ((0, 60e3), (1000, 95e3), (2000, 150e3), (3000, 225e3))
CATALOGUE = {"static": 0.7, "psi": 0.8, "band": (30.0, 300.0)}


def clamped(push=0.0, **given):
    """A coupling between a wall and a rotor under a torque."""
    values = {"stiffness": ((0, C),), "extrapolate": True, **CATALOGUE, **given}
    return in_a_row(
        wall=Fixed(), coupling=MaxwellCoupling(**values), rotor=Inertia(J=J), gas=Torque(tau=push)
    )


def stiffness(system, w, mean=0.0, **parameters):
    """Complex stiffness that a vibration about a mean torque meets."""
    values = {"gas.tau": mean, **parameters}
    response = lp.vibration.order_response(
        system,
        speeds=w,
        of=["coupling.tau", "coupling.phi_rel"],
        excitations={"gas.tau": {1: 10.0}},
        at=lp.equilibrium(system, parameters=values),
    )
    return response["coupling.tau"][:, 0] / response["coupling.phi_rel"][:, 0]


def law(branches, w, static=0.7):
    """``static + sum(share j w T / (1 + j w T))``."""
    jw = 1j * np.asarray(w)[:, None]
    share, time = np.transpose(branches)
    return static + (share * jw * time / (1 + jw * time)).sum(axis=1)


def test_one_branch_is_the_zener_model():
    # c_0 (1 + j w T_1) / (1 + j w T), T_1 = T (c_0 + c_1) / c_0
    share, time, static = 0.45, 0.012, 0.8
    system = lp.assemble(clamped(static=static, n_branches=1, band=(60.0, 120.0)))
    w = np.geomspace(1.0, 1e4, 25)
    received = stiffness(
        system, w, **{"coupling.branches[0].share": share, "coupling.branches[0].t_relax": time}
    )
    T1 = time * (static + share) / static
    expected = C * static * (1 + 1j * w * T1) / (1 + 1j * w * time)
    assert received == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("mean", [0.0, 1500.0, -2500.0])
def test_stiffness_and_psi_are_those_of_the_catalogue_within_the_error_of_the_fit(mean):
    model = clamped(stiffness=ROWS)
    system, fit = lp.assemble(model), model.coupling.fit()
    low, high = CATALOGUE["band"]
    w = np.geomspace(low, high, 200)
    received = stiffness(system, w, mean)
    c = np.interp(abs(mean), *np.transpose(ROWS))
    assert received / c == pytest.approx(law(fit.branches, w), rel=1e-7)  # of the equilibrium
    psi = 2 * np.pi * received.imag / received.real
    errors = np.abs(received.real / c - 1).max(), np.abs(psi / CATALOGUE["psi"] - 1).max()
    assert errors == pytest.approx((fit.stiffness_error, fit.psi_error), abs=1e-4)
    assert max(errors) < 0.1


def test_no_other_two_branches_meet_the_catalogue_better():
    """A search over all pairs of relaxation times on a grid finds no smaller sum of squares."""
    static, psi, band = 0.75, 0.6, (40.0, 160.0)
    fit = clamped(static=static, psi=psi, band=band, n_branches=2).coupling.fit()
    w = np.geomspace(*band, 64)

    def squares(found):
        loss = 2 * np.pi * found.imag / (psi * found.real) - 1
        return (loss**2 + (found.real - 1) ** 2).sum()

    times = np.geomspace(1e-3, 1.0, 16)
    shares = np.linspace(0.02, 0.8, 16)
    least = min(
        squares(law(((a, t), (b, s)), w, static))
        for i, t in enumerate(times)
        for s in times[:i]
        for a in shares
        for b in shares
    )
    received = squares(law(fit.branches, w, static))
    assert received <= least


def test_a_slow_twist_meets_the_static_stiffness():
    system = lp.assemble(clamped(stiffness=ROWS))
    h = 1e-2
    twist = [
        lp.equilibrium(system, parameters={"gas.tau": tau})["coupling.phi_rel"]
        for tau in (1500 - h, 1500 + h)
    ]
    received = 2 * h / (twist[1] - twist[0])
    assert received == pytest.approx(0.7 * np.interp(1500, *np.transpose(ROWS)), rel=1e-5)


@pytest.mark.parametrize("w", [20.0, 70.0, 250.0])
def test_a_run_has_the_complex_stiffness_and_loses_psi_of_its_elastic_energy(w):
    model = clamped(push=300.0 * lp.ops.cos(w * lp.time))
    orbit = lp.periodic(lp.assemble(model), period=2 * np.pi / w, rtol=1e-11)
    twist, torque = (orbit.harmonics(f"coupling.{name}", 1)[1] for name in ("phi_rel", "tau"))
    expected = C * law(model.coupling.fit().branches, [w])[0]
    error = abs(torque / twist / expected - 1)
    loss = orbit.work(("coupling.tau", "coupling.w_rel"))
    psi = abs(loss) / (0.5 * expected.real * abs(twist) ** 2)
    other = abs(psi / (2 * np.pi * expected.imag / expected.real) - 1)
    heat = abs(orbit.mean("coupling.power") * 2 * np.pi / w / loss - 1)
    assert max(error, other, heat) < 1e-6


def test_a_response_tells_the_heat():
    system = lp.assemble(clamped(stiffness=ROWS))
    w = np.array([40.0, 90.0, 200.0])
    response = lp.vibration.order_response(
        system,
        speeds=w,
        of=["coupling.phi_rel"],
        excitations={"gas.tau": {1: 100.0}},
        at=lp.equilibrium(system, parameters={"gas.tau": 1500.0}),
    )
    k = stiffness(system, w, 1500.0)
    expected = 0.5 * w * k.imag * response.magnitude("coupling.phi_rel", 1) ** 2
    assert response.mean_power("coupling.power")[:, 0] == pytest.approx(expected, rel=1e-9)


def test_a_run_beyond_the_rows_is_refused():
    model = clamped(push=2500.0, stiffness=ROWS)
    with pytest.raises(SolverError, match=r"coupling \(MaxwellCoupling\).*-3000 to 3000 N\.m"):
        lp.simulate(lp.assemble(model.with_({"coupling.extrapolate": False})), until=1.0)


def test_limits_are_those_of_the_catalogue():
    model = clamped(tau_vibratory=400.0, power_max=30.0)
    assert [limit.permitted for limit in model.coupling.limits()] == [400.0, 30.0]


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"static": 1.0}, r"static = 1\.0: a number above 0 and below 1"),
        ({"static": "half"}, "static = 'half'"),
        ({"psi": 0.0}, r"psi = 0\.0: a number above 0"),
        ({"band": (300.0, 30.0)}, "least and the largest angular frequency"),
        ({"band": 30.0}, "least and the largest angular frequency"),
        ({"n_branches": 0}, "n_branches = 0: a whole number"),
        ({"n_branches": 1}, r"n_branches = 1: .* psi by \d+% in the band from 30 to 300"),
        ({"static": 0.99, "psi": 1.2}, "another static stiffness"),
    ],
)
def test_numbers_that_cannot_be_met_are_refused(given, match):
    with pytest.raises(DeclarationError, match=match) as refused:
        lp.assemble(clamped(**given))
    assert "coupling (MaxwellCoupling)" in str(refused.value)


def test_rows_and_parameters_are_checked():
    with pytest.raises(EquationError, match=r"coupling.*begin at zero"):
        lp.assemble(clamped(stiffness=((100, 1e4), (500, 2e4))))
    with pytest.raises(ParameterError, match=r"branches\[0\]\.t_relax = 0 s"):
        lp.simulate(
            lp.assemble(clamped()), until=0.1, parameters={"coupling.branches[0].t_relax": 0.0}
        )
