"""What analyses tell about their cost and accuracy, and what they say when they cannot work."""

from dataclasses import replace

import numpy as np
import pytest
from drive_chains import Pendulum
from rows import assemble_row, in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    LinearTorque,
    NonlinearSpring,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import SolverError


def loaded(d=0.4, torque=6.0):
    """Wall, damped shaft, body under a torque: phi == tau / c."""
    return assemble_row(
        wall=Fixed(), shaft=SpringDamper(c=200.0, d=d), body=Inertia(J=2.0), load=Torque(tau=torque)
    )


def test_a_linear_equilibrium_takes_one_iteration_and_a_stable_one_says_no_more():
    point = lp.equilibrium(loaded())
    assert point["shaft.phi_rel"] == pytest.approx(6.0 / 200.0, rel=1e-13)
    assert point.search.iterations == 1
    assert point.search.evaluations >= 2
    assert point.search.residual < 1e-13
    assert np.isfinite(point.search.condition)
    assert point.search.growth == 0
    assert "unstable" not in repr(point)
    assert "found in 1 iterations" in repr(point)


def test_an_unstable_equilibrium_says_so():
    """Upright: growth (-d + sqrt(d^2 + 4 J weight)) / 2 J."""
    system = assemble_row(p=Pendulum(phi=3.0), oil=Damper(d=0.1), wall=Fixed())
    point = lp.equilibrium(system)
    assert point["p.phi"] == pytest.approx(np.pi, rel=1e-9)
    expected = (-0.1 + np.sqrt(0.01 + 8 * 30.0)) / 4
    assert point.search.growth == pytest.approx(expected, rel=1e-9)
    assert f"unstable, grows as exp({expected:.4g} t)" in repr(point)


def test_no_steady_response_of_an_unstable_linearisation():
    """A drive whose torque rises with its speed by more than the damper takes."""
    model = in_rows(
        "drive body oil wall",
        "load body",
        drive=LinearTorque(tau_nominal=0.9, w_nominal=1.0),
        body=Inertia(J=2.0),
        oil=Damper(d=0.4),
        wall=Fixed(),
        load=Torque(tau=0.0),
    )
    with pytest.raises(SolverError, match=r"unstable.* exp\(0\.25 t\), most in drive\.w"):
        lp.frequency_response(
            lp.assemble(model), inputs=["load.tau"], outputs=["body.w"], hertz=[1.0]
        )


def test_an_operating_point_that_is_no_number_is_refused_by_name():
    system = loaded()
    point = lp.start_point(system)
    bad = replace(point, x=np.full_like(point.x, np.nan))
    message = r"not finite: shaft\.phi_rel = nan"
    with pytest.raises(SolverError, match=message):
        lp.modes(system, at=bad)
    with pytest.raises(SolverError, match=message):
        lp.linearise(system, at=bad)
    with pytest.raises(SolverError, match=message):
        lp.frequency_response(system, inputs=["load.tau"], outputs=["body.w"], hertz=[1.0], at=bad)


def test_a_point_without_stiffness_has_a_rigid_body_mode_by_name_and_no_static_response():
    system = assemble_row(
        wall=Fixed(),
        soft=NonlinearSpring(characteristic=lambda twist: 5e4 * twist**3),
        a=Inertia(J=2.0),
        shaft=Spring(c=300.0),
        b=Inertia(J=1.0),
        load=Torque(tau=0.0),
    )
    found = lp.modes(system)
    assert found.hertz == pytest.approx([np.sqrt(450.0) / (2 * np.pi)], rel=1e-12)
    assert found.rigid_names == ("a.phi, b.phi",)
    with pytest.raises(SolverError, match="moves freely"):
        lp.frequency_response(system, inputs=["load.tau"], outputs=["b.w"], hertz=[0.0, 1.0])


def test_newtons_method_that_does_not_converge_tells_iterations_and_the_worst_by_name():
    told = r"der\(body\.w\) stays at 1\.5 after \d+ iterations of Newton's method"
    with pytest.raises(SolverError, match=told):
        lp.equilibrium(assemble_row(load=Torque(tau=3.0), body=Inertia(J=2.0)))


def test_responses_and_campbell_diagrams_tell_residuals_and_evaluations():
    system = loaded()
    response = lp.frequency_response(
        system, inputs=["load.tau"], outputs=["body.w"], hertz=np.linspace(0.5, 3, 20)
    )
    assert response.residual < 1e-14
    assert "20 frequencies" in repr(response)
    assert "residual" in repr(response)
    slopes = lp.vibration.response_sensitivity(response, by=["shaft.c", "shaft.d", "body.J"])
    text = repr(slopes)
    # near the resonance w/F = 1/d: inverse to the damping
    (row,) = [line for line in text.splitlines() if line.startswith("body.w / load.tau")]
    k = np.abs(response["body.w", "load.tau"]).argmax()
    w, c, d, J = 2 * np.pi * response.hertz[k], 200.0, 0.4, 2.0
    z = d + 1j * (w * J - c / w)
    assert f"shaft.d {(-d * (1 / z).real):+.4f}" in row
    fixed = lp.campbell(system, speeds=[1.0, 30.0], orders=[1, 2])
    assert fixed.evaluations == 1
    assert fixed.residual < 1e-12
    moving = lp.campbell(
        system,
        speeds=[1.0, 30.0],
        orders=[1],
        at=lambda w: lp.start_point(system, parameters={"shaft.c": 200.0 + w}),
    )
    # (200 + w) / 2 == w^2
    assert moving.critical[0].speed == pytest.approx((0.5 + np.sqrt(0.25 + 400)) / 2, rel=1e-9)
    assert moving.residual < 1e-9
    assert moving.evaluations > 2
    assert f"modes at {moving.evaluations} speeds" in repr(moving)


def test_derivatives_of_runs_tell_tolerance_and_evaluations():
    system = loaded()
    forward = lp.sensitivity(system, of=["body.w"], by=["shaft.c", "load.tau"], until=0.3)
    assert forward.evaluations > 0
    assert forward.rtol == 1e-6
    # the speed is proportional to the torque
    assert "load.tau +1.0000" in repr(forward)
    back = lp.gradient(system, of=[fun.final("body.w")], until=0.3, rtol=1e-9)
    assert back.rtol == 1e-9
    assert "rtol 1e-09" in repr(back)


def test_linearisations_tell_how_far_the_point_is_from_rest():
    assert "der(body.w) = 3 is the fastest change" in repr(lp.linearise(loaded()))
