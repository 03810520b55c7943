"""Every mistake gets an error of lumped that names the place and says what to do."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    Gain,
    IdealGear,
    Inertia,
    Position,
    RackAndPinion,
    Speed,
    Spring,
    Torque,
)
from lumped.errors import (
    ConnectError,
    EquationError,
    LumpedError,
    OptionError,
    ParameterError,
    SingularModelError,
    SolverError,
    StartError,
    UnitError,
    UnknownNameError,
)


def model(connections, **parts):
    return lp.compose(connections=connections, **parts)


def message(kind, action):
    with pytest.raises(kind) as caught:
        action()
    assert isinstance(caught.value, LumpedError)
    print(f"\n{kind.__name__}: {caught.value}")
    return str(caught.value)


def test_all_parameter_faults_of_a_model_come_in_one_error():
    rig = model(
        lambda m: lp.chain(m.motor, m.shaft, m.load),
        motor=Inertia(J=-0.02),
        shaft=Spring(),
        load=Inertia(J=0.0),
        gear=IdealGear(ratio=0.0),
    )
    text = message(ParameterError, lambda: lp.assemble(rig))
    assert "motor.J = -0.02 kg.m2 (moment of inertia) must be greater than 0" in text
    assert "shaft.c (torsional stiffness, N.m/rad) has no value" in text
    assert "load.J = 0 kg.m2" in text
    assert "gear.ratio = 0 (gear ratio, speed of a over speed of b) must not be zero" in text


def test_a_bound_parameter_out_of_range_is_named():
    class Rig(lp.Component):
        """Rotor with bound inertia: J = 1 - x."""

        x: lp.Param = lp.param("1", "share", 3.0)
        rotor: Inertia = Inertia(J=1 - x)

    text = message(ParameterError, lambda: lp.assemble(Rig()))
    assert "rotor.J = -2 kg.m2" in text
    system = lp.assemble(Rig(x=0.5))
    text = message(ParameterError, lambda: lp.simulate(system, until=1, parameters={"x": 2.0}))
    assert "rotor.J = -1" in text
    text = message(
        UnknownNameError, lambda: lp.simulate(system, until=1, parameters={"rotor.J": 2})
    )
    assert "bound" in text
    text = message(UnitError, lambda: lp.simulate(system, until=1, parameters={"x": "big"}))
    assert "x = 'big'" in text


def test_parameters_bound_in_a_circle_are_named():
    class Rig(lp.Component):
        """Two parameters bound to each other: a = b, b = a."""

        a: lp.Param = lp.param("1", "first", 1.0)
        b: lp.Param = lp.param("1", "second", 2 * a)

    Rig.b.default = 2 * Rig.b
    text = message(ParameterError, lambda: lp.assemble(Rig()))
    assert "circle" in text


def test_ports_of_different_kind_are_refused_at_the_call():
    rack, body = RackAndPinion(radius=0.1), Inertia(J=1.0)
    text = message(ConnectError, lambda: lp.connect(body.flange_b, rack.flange_b))
    assert "rotational flange" in text
    assert "translational flange" in text
    assert "rack and pinion" in text


def test_an_unconnected_needed_port_is_named():
    rig = model(lambda m: lp.chain(m.motor, m.shaft), motor=Inertia(J=1), shaft=Spring(c=1))
    text = message(ConnectError, lambda: lp.assemble(rig))
    assert "shaft.flange_b of shaft (Spring) is not connected" in text


def test_a_foreign_component_in_a_connection_is_named():
    stranger = Inertia(J=1.0)
    rig = model(lambda m: [lp.connect(m.motor.flange_b, stranger.flange_a)], motor=Inertia(J=1))
    assert "not one of its parts" in message(ConnectError, lambda: lp.assemble(rig))


def test_an_input_without_source_and_one_with_two_are_named():
    rig = model(lambda m: lp.chain(m.drive, m.body), drive=Torque(), body=Inertia(J=1))
    text = message(ConnectError, lambda: lp.assemble(rig))
    assert "drive.tau: the input (driving torque, N.m) has no source" in text


def test_two_supports_on_one_shaft_are_explained():
    rig = model(
        lambda m: [
            lp.connect(m.wall.flange, m.wall2.flange, m.shaft.flange_a),
            lp.connect(m.shaft.flange_b, m.body.flange_a),
        ],
        wall=Fixed(),
        wall2=Fixed(),
        shaft=Spring(c=1),
        body=Inertia(J=1),
    )
    text = message(SingularModelError, lambda: lp.assemble(rig))
    assert "wall.flange.phi = wall.phi0" in text
    assert "wall2.flange.phi = wall2.phi0" in text
    assert "Nothing determines: wall2.flange.tau" in text
    assert "two supports" in text


def test_two_speed_sources_on_a_rigid_shaft_are_explained():
    rig = model(
        lambda m: [
            lp.connect(m.one.flange, m.body.flange_a),
            lp.connect(m.two.flange, m.body.flange_b),
        ],
        one=Speed(w=1.0),
        two=Speed(w=2.0),
        body=Inertia(J=1),
    )
    text = message(SingularModelError, lambda: lp.assemble(rig))
    assert "one.w" in text
    assert "two.w" in text


def test_a_speed_and_an_angle_prescribed_together_are_explained():
    rig = model(
        lambda m: [
            lp.connect(m.one.flange, m.body.flange_a),
            lp.connect(m.two.flange, m.body.flange_b),
        ],
        one=Speed(w=1.0),
        two=Position(phi=2.0),
        body=Inertia(J=1),
    )
    text = message(SingularModelError, lambda: lp.assemble(rig))
    assert "two.phi = 2" in text
    assert "one.w = 1" in text
    assert "prescribed motions meet at" in text


def test_a_shaft_between_two_torques_without_inertia_is_explained():
    rig = model(
        lambda m: lp.chain(m.one, m.shaft, m.two),
        one=Torque(tau=1.0),
        shaft=Spring(c=10.0),
        two=Torque(tau=-1.0),
    )
    text = message(SingularModelError, lambda: lp.assemble(rig))
    assert "shaft" in text


def test_a_rigid_gear_loop_is_explained():
    rig = model(
        lambda m: [
            lp.connect(m.a.flange_b, m.g1.flange_a, m.g2.flange_a),
            lp.connect(m.b.flange_a, m.g1.flange_b, m.g2.flange_b),
        ],
        a=Inertia(J=1),
        b=Inertia(J=1),
        g1=IdealGear(ratio=2.0),
        g2=IdealGear(ratio=2.0),
    )
    text = message(SingularModelError, lambda: lp.assemble(rig))
    assert "closed loop of rigid gears" in text
    assert "g2.flange_a.phi" in text or "g1.flange_a.phi" in text


class Loose(lp.Component):
    """Brings one equation too few: x = 1."""

    x: lp.Var = lp.var("1", "known")
    y: lp.Var = lp.var("1", "forgotten")

    def equations(self):
        yield self.x == 1


class Tight(lp.Component):
    """Brings one equation too many: x = 1, x = 2."""

    x: lp.Var = lp.var("1", "known twice")

    def equations(self):
        yield self.x == 1
        yield self.x == 2


def test_a_component_out_of_balance_is_named_with_its_equations():
    text = message(SingularModelError, lambda: lp.assemble(model((), part=Loose())))
    assert "part (Loose) brings 1 equations but needs 2" in text
    assert "x, y" in text
    text = message(SingularModelError, lambda: lp.assemble(model((), part=Tight())))
    assert "brings 2 equations but needs 1, too many" in text
    assert "x == 2" in text


class Impossible(lp.Component):
    """No real number does this: x**2 = -1."""

    x: lp.Var = lp.var("1", "implicit", 1.0)

    def equations(self):
        yield self.x**2 == -1


def test_an_implicit_equation_without_solution_is_named():
    system = lp.assemble(model((), part=Impossible()))
    text = message(StartError, lambda: lp.simulate(system, until=1))
    assert "part.x" in text


class Yields(lp.Component):
    """Yields something that is no equation: x = 0."""

    x: lp.Var = lp.var("1", "unused")

    def equations(self):
        yield self.x - 1


def test_what_is_yielded_must_be_an_equation():
    text = message(EquationError, lambda: lp.assemble(model((), part=Yields())))
    assert "Yields yielded x - 1" in text


def test_contradictory_start_values_are_named():
    rig = model(
        lambda m: lp.chain(m.a, m.gear, m.b),
        a=Inertia(J=1, w=10.0),
        gear=IdealGear(ratio=2.0),
        b=Inertia(J=1, w=10.0),
    )
    text = message(StartError, lambda: lp.start_point(lp.assemble(rig)))
    assert "b.w = 10 rad/s" in text
    assert "a.w = 10 rad/s" in text
    rigid = model(lambda m: lp.chain(m.a, m.b), a=Inertia(J=1, w=1.0), b=Inertia(J=1, w=2.0))
    text = message(StartError, lambda: lp.start_point(lp.assemble(rigid)))
    assert "a.w = 1 rad/s" in text
    assert "b.w = 2 rad/s" in text
    held = model(lambda m: lp.chain(m.wall, m.a), wall=Fixed(), a=Inertia(J=1, w=1.0))
    assert "a.w = 1" in message(StartError, lambda: lp.start_point(lp.assemble(held)))


def test_unknown_names_get_the_nearest_ones(two_mass):
    system = lp.assemble(two_mass)
    run = lp.simulate(system, until=0.1, grid=1)
    calls = {
        "a.J": lambda: lp.simulate(system, until=1, parameters={"a.j": 1.0}),
        "shaft.tau": lambda: run["shaft.torque"],
        "b.w": lambda: lp.simulate(system, until=1, start={"b.omega": 1.0}),
        "shaft.c": lambda: lp.linearise(system, inputs=["shaft.C"]),
        "shaft.phi_rel": lambda: lp.linearise(system, outputs=["shaft.phirel"]),
        "a.phi": lambda: lp.modes(system).shape("a.ph"),
        "a.w": lambda: lp.assemble(two_mass, of=["aw"]),
    }
    for expected, call in calls.items():
        assert expected in message(UnknownNameError, call)


def test_what_was_left_out_is_said_when_asked_for(two_mass):
    system = lp.assemble(two_mass, of=["a.w"])
    text = message(UnknownNameError, lambda: lp.linearise(system, outputs=["b.phi"]))
    assert "left out" in text
    assert "keep=['b.phi']" in text


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        ({"until": 0.0}, "until = 0.0 s"),
        ({"until": -1.0}, "positive"),
        ({"until": np.nan}, "finite"),
        ({"until": np.inf}, "finite"),
        ({"until": 1.0, "rtol": 0.0}, "rtol"),
        ({"until": 1.0, "atol": -1.0}, "atol"),
        ({"until": 1.0, "method": "rk4"}, "explicit"),
        ({"until": 1.0, "grid": 0}, "interval"),
        ({"until": 1.0, "grid": [0.5, 0.2]}, "decrease"),
        ({"until": 1.0, "grid": [0.5, 2.0]}, "leave 0 to 1 s"),
        ({"until": 1.49813, "grid": [0.0, 1.4981301]}, "from 0 to 1.4981301 s leave 0 to 1.49813"),
        ({"until": 1.0, "grid": [-1e-9, 1.0]}, "times from -1e-09 to 1 s leave 0 to 1 s"),
        ({"until": 1.0, "grid": [0.0, np.nan, 1.0]}, "grid = [0.0, nan, 1.0]"),
        ({"until": 1.0, "grid": [np.nan, np.nan]}, "grid = [nan, nan]"),
        ({"until": 1.0, "grid": [0.0, np.inf]}, "finite numbers"),
        ({"until": 1.0, "grid": 10**13}, "grid = 10000000000000: the number of output intervals"),
        ({"until": 1.0, "grid": True}, "grid = True"),
        ({"until": 1.0, "grid": 10.0}, "grid = 10.0: a whole number"),
        ({"until": 1.0, "grid": [[0.0, 1.0]]}, "grid = [[0.0, 1.0]]"),
        ({"until": 1.0, "grid": [0.0, None]}, "grid = [0.0, None]"),
        ({"until": 1.0, "grid": object()}, "grid = "),
        ({"until": [1.0, 2.0]}, "until = [1.0, 2.0]: a finite number or a text"),
        ({"until": None}, "until = None: a finite number or a text"),
    ],
)
def test_options_that_make_no_sense_are_refused(two_mass, options, hint):
    assert hint in message(OptionError, lambda: lp.simulate(lp.assemble(two_mass), **options))


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        ({"until": "500 mm"}, "until = '500 mm': the unit must be of the kind s"),
        ({"until": "500ms"}, "until = '500ms': a number in s, or a number, a space and a unit"),
        ({"until": 1.0, "grid": ["0 s", "1 m"]}, "grid: time = '1 m'"),
    ],
)
def test_texts_that_are_no_times_are_refused(two_mass, options, hint):
    assert hint in message(UnitError, lambda: lp.simulate(lp.assemble(two_mass), **options))


def test_times_may_have_units(two_mass):
    """Body a swings as ``w_a = 2 + cos(sqrt(c (1/J_a + 1/J_b)) t)``."""
    system = lp.assemble(two_mass, keep=["a.phi"])
    given = {"start": {"a.w": 3.0}}
    run = lp.simulate(system, until=0.5, grid=[0.0, 0.1, 0.5], **given)
    same = lp.simulate(system, until="500 ms", grid=["0 s", "100 ms", "0.5 s"], **given)
    assert (same["a.w"] == run["a.w"]).all()
    assert same.t == pytest.approx(run.t, rel=1e-15)
    assert same.point("100 ms")["a.w"] == run.point(0.1)["a.w"]
    omega = np.sqrt(300.0 * 1.5)
    slope = -np.sin(0.5 * omega) * 0.5 * omega / (2 * 300.0)
    to, of = ["shaft.c"], lp.functionals.final("a.w")
    moved = lp.sensitivity(system, of=["a.w"], by=to, until="500 ms", rtol=1e-9, **given)
    assert moved["a.w", "shaft.c"][-1] == pytest.approx(slope, rel=1e-6)
    slopes = lp.gradient(system, of=[of], by=to, until="500 ms", **given)
    assert slopes.derivatives[0, 0] == pytest.approx(slope, rel=1e-6)
    tried = lp.simulation.work_precision(
        system, until="500 ms", tolerances=[1e-4], methods=["explicit"], **given
    )
    assert tried.rows[0].outcome == "ok"


def test_output_times_that_miss_the_end_by_a_rounding_are_meant_to_be_it(two_mass):
    system, until = lp.assemble(two_mass), 1.49813
    for off in (np.nextafter(until, 2.0), until * (1 + 5e-15)):
        run = lp.simulate(system, until=until, grid=[-1e-17, 0.5, off])
        assert run.t.tolist() == [0.0, 0.5, until]


class Explodes(lp.Component):
    """Runs to infinity at t = 1: der(x) = x**2, x(0) = 1."""

    x: lp.Var = lp.var("1", "growing", 1.0)

    def equations(self):
        yield lp.der(self.x) == self.x**2


class Roots(lp.Component):
    """Leaves the range of a root at t = 1: der(x) = -1, y = sqrt(x)."""

    x: lp.Var = lp.var("1", "falling", 1.0)
    y: lp.Var = lp.var("1", "root of it integrated")

    def equations(self):
        yield lp.der(self.x) == -1
        yield lp.der(self.y) == lp.ops.sqrt(self.x)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("part", [Explodes(), Roots()])
def test_a_failed_run_keeps_what_it_computed(part, method):
    system = lp.assemble(model((), part=part))
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=2.0, method=method, grid=None)
    print(f"\n{caught.value}")
    partial = caught.value.partial
    early = partial.t < 0.9
    expected = 1 / (1 - partial.t) if isinstance(part, Explodes) else 1 - partial.t
    error = np.abs(partial["part.x"] / expected - 1)[early].max()
    print(f"reached t = {partial.t[-1]:.9f} of 1, relative error up to 0.9 s {error:.2e}")
    assert partial.t[-1] == pytest.approx(1.0, abs=1e-5)
    assert error < 1e-5
    assert "part." in str(caught.value)


def test_a_run_that_takes_too_many_steps_says_so(two_mass):
    system = lp.assemble(two_mass)
    with pytest.raises(SolverError, match="max_steps = 300") as caught:
        lp.simulate(system, until=1e4, start={"a.w": 1.0}, max_steps=300, grid=None)
    assert caught.value.partial.t[-1] > 0


def test_a_free_drive_with_net_torque_has_no_equilibrium(driven_mass):
    text = message(SolverError, lambda: lp.equilibrium(lp.assemble(driven_mass)))
    assert "body.w" in text
    assert "accelerates for ever" in text


def test_a_prescribed_jump_of_a_rigid_mass_is_refused():
    rig = model(
        lambda m: lp.chain(m.guide, m.body),
        guide=Position(phi=lp.ops.where(lp.time >= 0.5, 1.0, 0.0)),
        body=Inertia(J=1),
    )
    text = message(SolverError, lambda: lp.simulate(lp.assemble(rig), until=1.0))
    assert "body.phi would have to jump from 0 to 1 at t = 0.5 s" in text


def test_a_massless_joint_held_by_a_damper_of_zero_is_named():
    rig = model(
        lambda m: lp.chain(m.a, m.one, m.two, m.b),
        a=Inertia(J=1),
        one=Damper(d=0.0),
        two=Damper(d=0.0),
        b=Inertia(J=1),
    )
    text = message(SingularModelError, lambda: lp.simulate(lp.assemble(rig), until=1.0))
    assert "one" in text


def test_a_loop_of_signals_of_gain_one_is_told_as_such():
    parts = {"first": Gain(k=0.5), "second": Gain(k=2.0)}
    rig = model(
        lambda m: [lp.connect(m.first.y, m.second.u), lp.connect(m.second.y, m.first.u)], **parts
    )
    text = message(SingularModelError, lambda: lp.start_point(lp.assemble(rig))["first.y"])
    assert "first, second form a loop of signals whose gain is 1" in text
    assert "Filter" in text
    other = lp.assemble(rig.with_({"first.k": 3.0}))
    assert lp.start_point(other)["first.y"] == 0.0
