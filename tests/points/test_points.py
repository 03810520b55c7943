"""Start points, equilibria and linearisations."""

import numpy as np
import pytest
from linkages import double_rocker
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    Spring,
    SpringDamper,
    SwingingMass,
    Torque,
)
from lumped.errors import OptionError, SolverError, StartError


def test_a_start_angle_of_the_load_turns_the_drive_and_does_not_twist_the_shaft(two_mass):
    system = lp.assemble(two_mass, keep=["a.phi"])
    point = lp.start_point(system, start={"b.phi": 0.7})
    received = [point[n] for n in ("a.phi", "b.phi", "shaft.phi_rel")]
    assert received == pytest.approx([0.7, 0.7, 0.0], abs=1e-15)


def test_a_start_acceleration_sets_the_twist(two_mass):
    point = lp.start_point(lp.assemble(two_mass), start={"b.a": -6.0})
    assert point["shaft.tau"] == pytest.approx(6.0, rel=1e-12)
    assert point["shaft.phi_rel"] == pytest.approx(0.02, rel=1e-12)


def test_a_rest_length_follows_from_the_position_in_which_it_holds_a_body():
    from lumped.components import translation

    system = assemble_row(
        wall=translation.Fixed(),
        spring=translation.Spring(c=1e3),
        body=translation.Mass(m=2.0, s=0.5, v=0.0, a=0.0),
        weight=translation.Force(f=-19.62),
    )
    point = lp.start_point(system, free=["spring.s_rel0"])
    # c (0.5 - s_rel0) = -m g
    assert point.parameters["spring.s_rel0"] == pytest.approx(0.5 + 19.62 / 1e3, rel=1e-12)
    run = lp.simulate(system, until=1.0, free=["spring.s_rel0"], grid=10)
    assert run["body.s"] == pytest.approx(np.full(11, 0.5), rel=1e-6)
    with pytest.raises(StartError, match=r"spring\.s_rel0 is not determined"):
        lp.start_point(system, free=["spring.s_rel0", "spring.c"])
    with pytest.raises(StartError, match=r"No start state was found.*body\.a = 50"):
        lp.start_point(system, start={"body.a": 50.0}, free=["body.m"])  # a negative mass


def test_a_run_starts_from_an_equilibrium():
    system = assemble_row(
        drive=Torque(tau=12.0),
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=400.0, d=0.2),
        b=Inertia(J=2.0),
        load=Damper(d=0.5),
        ground=Fixed(),
    )
    steady = lp.equilibrium(system, parameters={"drive.tau": 10.0})
    run = lp.simulate(system, until=5.0, start=steady, grid=20)
    assert run["b.w"] == pytest.approx(np.full(21, 20.0), rel=1e-6)
    slower = lp.simulate(system, until=200.0, start=steady, parameters={"drive.tau": 9.0})
    assert slower["b.w"][[0, -1]] == pytest.approx([20.0, 18.0], rel=1e-6)


def test_a_start_value_bound_to_a_parameter_follows_it():
    class Rig(lp.Component):
        """Body with bound speed: w0 = 2 v."""

        v: lp.Param = lp.param("rad/s", "half the speed", 3.0)
        body: Inertia = Inertia(J=1.0, w=2 * v)

    system = lp.assemble(Rig())
    assert lp.start_point(system)["body.w"] == 6.0
    assert lp.start_point(system, parameters={"v": 5.0})["body.w"] == 10.0


def test_a_linearisation_is_the_closed_form(two_mass):
    model = in_a_row(
        drive=Torque(tau=1.0),
        a=Inertia(J=2.0),
        shaft=SpringDamper(c=300.0, d=0.6),
        b=Inertia(J=1.0),
    )
    linear = lp.linearise(
        lp.assemble(model), inputs=["drive.tau"], outputs=["shaft.tau", "b.w", "a.a"]
    )
    assert linear.states == ("a.w", "shaft.phi_rel", "b.w")
    expected = {
        "A": [[-0.3, 150, 0.3], [-1, 0, 1], [0.6, -300, -0.6]],
        "B": [[0.5], [0], [0]],
        "C": [[-0.6, 300, 0.6], [0, 0, 1], [-0.3, 150, 0.3]],
        "D": [[0], [0], [0.5]],
    }
    for name, matrix in expected.items():
        np.testing.assert_allclose(getattr(linear, name), matrix, rtol=1e-14, atol=0)
    assert "shaft.phi_rel" in repr(linear)


class Hot(lp.Component):
    """Damping with a root: J der(w) = -sqrt(w)."""

    w: lp.Var = lp.var("rad/s", "speed", 1.0)

    def equations(self):
        yield lp.der(self.w) == -lp.ops.sqrt(self.w)


def test_a_linearisation_that_is_not_finite_is_refused():
    system = lp.assemble(lp.compose(h=Hot()))
    with pytest.raises(SolverError, match=r"h\.w"):
        lp.linearise(system, at=lp.start_point(system, start={"h.w": 0.0}))
    with pytest.raises(SolverError, match="not finite"):
        lp.modes(system, at=lp.start_point(system, start={"h.w": 0.0}))


def test_a_point_of_a_run_is_where_it_is_linearised():
    """A swinging arm on a spring: its frequency at an angle is that of the tangent there."""
    system = assemble_row(
        ground=Fixed(), spring=Spring(c=3.0), arm=SwingingMass(m=2.0, R=0.5, g=9.81)
    )
    run = lp.simulate(system, until=2.0, start={"arm.flange.phi": 0.4}, rtol=1e-9)
    for time in (0.0, 0.7, 2.0):
        point = run.point(time)
        phi = point["arm.flange.phi"]
        k = np.abs(run.t - time).argmin()
        assert (point.time, phi) == (run.t[k], run["arm.flange.phi"][k])
        stiffness = lp.linearise(system, at=point).A
        slope = (3.0 - 2.0 * 9.81 * 0.5 * np.sin(phi)) / (2.0 * 0.25)
        assert np.linalg.eigvals(stiffness)[0] ** 2 == pytest.approx(-slope, rel=1e-12)
    with pytest.raises(OptionError, match="not within the run"):
        run.point(2.1)


# -- states that were asked for ----------------------------------------------------------------


class Soft(lp.Component):
    """Slip that follows a speed, and a torque that it makes: smooth, and steep where it begins."""

    flange = lp.Flange()
    s: lp.Var = lp.var("1", "slip", state="prefer")
    F: lp.Var = lp.var("N.m", "torque")
    rate: lp.Var = lp.var("N.m/s", "its rate")

    def equations(self):
        yield 0.01 * lp.der(self.s) == lp.der(self.flange.phi) - 10 * self.s
        yield 1000 * lp.ops.sin(1.6 * lp.ops.atan(10 * self.s)) == self.F
        yield self.rate == lp.der(self.F)
        yield self.flange.tau == self.F


def test_a_preferred_state_leads_although_what_it_makes_is_steep():
    system = assemble_row(push=Torque(tau=5.0), body=Inertia(J=1.0), tyre=Soft())
    run = lp.simulate(system, until=1.0, rtol=1e-9, grid=[1.0])
    assert run.events == ()
    assert {piece.system for piece in run.pieces} == {system}

    def slip(torque):  # 5 N.m = F(s)
        return np.tan(np.arcsin(torque / 1000.0) / 1.6) / 10

    assert run["tyre.s"][-1] == pytest.approx(slip(5.0), rel=1e-6)
    of = [lp.functionals.final("tyre.s")]
    found = lp.gradient(system, of=of, by=["push.tau"], until=1.0)
    expected = (slip(5.001) - slip(4.999)) / 2e-3
    assert found.derivatives[0, 0] == pytest.approx(expected, rel=1e-4)


def test_derivatives_go_on_where_states_change():
    """Against differences of runs, across the dead centre of a crank."""
    system = lp.assemble(double_rocker(w=3.0))

    def end(J, w):
        changes = {"parameters": {"crank.J": J}, "start": {"crank.w": w}}
        run = lp.simulate(system, until=5.0, rtol=1e-12, grid=[5.0], **changes)
        assert [event.kind for event in run.events] == ["states"]
        return run["crank.w"][-1]

    J, h = system.parameters["crank.J"], 2e-5
    expected = [
        (end(J + h, 3.0) - end(J - h, 3.0)) / (2 * h),
        (end(J, 3.0 + h) - end(J, 3.0 - h)) / (2 * h),
    ]
    by, options = ["crank.J", "crank.w"], {"until": 5.0, "rtol": 1e-9}
    of = [lp.functionals.final("crank.w")]
    found = lp.gradient(system, of=of, by=by, start={"crank.w": 3.0}, **options)
    assert found.derivatives[0] == pytest.approx(expected, rel=1e-6)
    found = lp.sensitivity(system, of=["crank.w"], by=by, start={"crank.w": 3.0}, **options)
    at_end = [found["crank.w", name][-1] for name in by]
    assert at_end == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("action", [lp.start_point, lp.equilibrium])
def test_a_free_parameter_named_twice_is_refused(action):
    model = in_a_row(drive=Torque(tau=5.0), body=Inertia(J=2.0), oil=Damper(d=1.0), housing=Fixed())
    system = lp.assemble(model)
    with pytest.raises(OptionError, match=r"free parameter drive\.tau is named twice"):
        action(system, free=["drive.tau", model.drive.tau], start={"body.w": 3.0})
    for tolerance in (0.0, 1.0, -1e-6):
        with pytest.raises(OptionError, match=r"tolerance = .* between 0 and 1"):
            lp.equilibrium(system, tolerance=tolerance)
