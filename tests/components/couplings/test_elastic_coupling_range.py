"""An elastic coupling beyond its rows, and wrong rows."""

import numpy as np
import pytest
from test_elastic_coupling import drive

import lumped as lp
from lumped.errors import EquationError, LumpedError, ParameterError, SolverError


@pytest.mark.parametrize("grid", [500, None, (0.0, 1.0)])
def test_a_run_beyond_the_table_is_refused(grid):
    system = drive()
    fine = {"gas.tau": 1500.0, "motor.tau_nominal": 0.0}
    run = lp.simulate(system, until=1.0, grid=grid, parameters=fine)
    assert np.abs(run["coupling.tau_c"]).max() < 3000
    with pytest.raises(SolverError, match=r"coupling.*torque = -3.*t = 0.02.*-3000 to 3000 N\.m"):
        lp.simulate(system, until=1.0, grid=grid, parameters={**fine, "gas.tau": 2200.0})
    run = lp.simulate(
        drive(extrapolate=True), until=1.0, grid=grid, parameters={**fine, "gas.tau": 2200.0}
    )
    assert not run.events


def beyond():
    """Analyses that a coupling leaves its table in."""
    system = drive(over_frequency=((50.0, 1.0, 1.0), (500.0, 1.2, 0.9)))
    still = {"motor.tau_nominal": 0.0}
    load = {**still, "gas.tau": 3500.0, "brake.tau": -3500.0}
    orders = {"speeds": [60.0], "of": ["coupling.tau"], "parameters": still}
    wound = lp.start_point(system, start={"coupling.phi_rel": 0.05})
    return {
        "equilibrium": (lambda: lp.equilibrium(system, parameters=load), "at the equilibrium"),
        "modes": (lambda: lp.modes(system, at=wound), "at the operating point"),
        "mean": (
            lambda: lp.vibration.order_response(
                system, **{**orders, "parameters": None}, at=wound, excitations={"gas.tau": {2: 1}}
            ),
            "in the mean at 60 rad/s",
        ),
        "vibration": (
            lambda: lp.vibration.order_response(
                system, **orders, excitations={"gas.tau": {1: 4e3, 2: 4e3}}
            ),
            "with the vibration at 60 rad/s",
        ),
        "frequency": (
            lambda: lp.vibration.order_response(
                system, **orders, excitations={"gas.tau": {2: 1.0, 9: 1.0}}
            ),
            r"frequency of vibration = 540 rad/s for order 9 at 60 rad/s lies outside 50 to 500",
        ),
    }


@pytest.mark.parametrize("case", list(beyond()))
def test_an_analysis_beyond_the_table_is_refused(case):
    call, match = beyond()[case]
    with pytest.raises(SolverError, match=match) as refused:
        call()
    assert "coupling (ElasticCoupling)" in str(refused.value)
    assert "extrapolate=True" in str(refused.value)


@pytest.mark.parametrize(
    ("given", "error", "match"),
    [
        ({"psi": -0.1}, ParameterError, "psi"),
        ({"w_loss": 0.0}, ParameterError, "w_loss"),
        ({"stiffness": ((0, 1e4), (500, 2e4), (400, 3e4))}, EquationError, "500 -> 400"),
        ({"stiffness": ((100, 1e4), (500, 2e4))}, EquationError, "begin at zero"),
        ({"stiffness": ((0, 1e4), (500, -2e4))}, EquationError, "-20000 N.m/rad at 500 N.m"),
        ({"stiffness": ((0, 1e4), (500,))}, EquationError, "rows of torque"),
        ({"stiffness": ((0, 1e4), (500, np.nan))}, EquationError, "finite numbers"),
        ({"stiffness": ()}, EquationError, "either stiffness=.* or twist="),
        ({"twist": ((0, 0), (0.1, 10))}, EquationError, "either stiffness=.* or twist="),
        ({"stiffness": (), "twist": ((0, 0), (0.1, 9), (0.2, 8))}, EquationError, "9 -> 8 N.m"),
        ({"stiffness": (), "twist": ((0, 0),)}, EquationError, "at least two rows"),
        ({"damping": ((0, 1.0), (500, -0.2))}, EquationError, "-0.2 at 500 must not be negative"),
        ({"damping": ((100, 1.0), (500, 0.2))}, EquationError, "begin at zero"),
        ({"over_frequency": ((10, 1.0), (50, 1.1))}, EquationError, "factor of psi are needed"),
        ({"over_frequency": ((50, 1.0, 1), (10, 1.1, 1))}, EquationError, "50 -> 10"),
        ({"over_temperature": ((293, 1, 1), (350, 0, 1))}, EquationError, "must be above zero"),
        ({"over_temperature": ((293, 1, 1), (350, 0.7, 1)), "T": 400.0}, SolverError, "400 K"),
        ({"over_temperature": ((293, 1, 1), (350, 0.7, 1)), "T": -20.0}, ParameterError, "T"),
    ],
)
def test_slips_are_named(given, error, match):
    with pytest.raises(error, match=match) as refused:
        lp.simulate(drive(**given), until=0.1)
    assert isinstance(refused.value, LumpedError)
    assert "coupling" in str(refused.value)
