"""Modes against closed forms and independent eigenvalue calculations."""

from dataclasses import replace

import numpy as np
import pytest
import scipy
from drive_chains import Pendulum, damped_pair, uniform, uniform_hertz
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import (
    Constant,
    Damper,
    DCMotor,
    ElastoBacklash,
    Fixed,
    Ground,
    IdealGear,
    Inertia,
    Resistor,
    Spring,
    SpringDamper,
    VoltageSource,
)


@pytest.mark.parametrize("n", [2, 5, 40, 300])
def test_a_uniform_free_chain_has_its_closed_form_frequencies(n):
    received, k = lp.modes(lp.assemble(uniform(n))), np.arange(1, n)
    assert received.hertz == pytest.approx(uniform_hertz(n), rel=1e-12)
    assert received.rigid == 1
    assert (received.damping == 0).all()
    shape = np.array([received.shape(f"body[{i}].phi") for i in range(n)])
    form = np.cos(np.outer(np.arange(n) + 0.5, k) * np.pi / n)
    largest = np.abs(shape).argmax(axis=0), np.arange(n - 1)
    form *= np.sign(shape[largest]) / form[largest]
    assert shape.max(axis=0) == pytest.approx(np.ones(n - 1))  # both ends are largest
    assert np.abs(shape - form).max() < 1e-9
    assert received.rigid_shape("body[0].phi") == pytest.approx([1.0])


def test_an_overdamped_shaft_gives_two_decays():
    w0, free = np.sqrt(300.0 * 1.5), lp.modes(lp.assemble(damped_pair(3.0)))
    expected = w0 * (-3.0 + np.array([-1, 1]) * np.sqrt(8.0))
    assert len(free.hertz) == 0
    assert free.decays == pytest.approx(np.sort(expected), rel=1e-12)
    lines = repr(free).splitlines()
    assert "0 oscillating" in lines[0]
    assert lines[1] == "decays, 1/s: " + ", ".join(f"{value:.4g}" for value in np.sort(expected))


class Inverted(lp.Component):
    """What falls away from its upper position, with e^2t and e^-2t."""

    phi = lp.var("rad", "angle", state="prefer")
    w = lp.var("rad/s", "speed", state="prefer")

    def equations(self):
        yield lp.der(self.phi) == self.w
        yield lp.der(self.w) == 4 * self.phi


def test_what_grows_is_no_decay():
    lines = repr(lp.modes(lp.assemble(Inverted()))).splitlines()
    assert "1 decays" in lines[0]
    assert lines[1:] == ["decays, 1/s: -2", "unstable: grows, 1/s: 2"]


def test_shapes_follow_a_gear():
    model = in_a_row(
        motor=Inertia(J=1.0), shaft=Spring(c=900.0), gear=IdealGear(ratio=3.0), load=Inertia(J=9.0)
    )
    free = lp.modes(lp.assemble(model))
    assert free.hertz == pytest.approx([np.sqrt(900.0 * 2) / (2 * np.pi)], rel=1e-13)
    received = [free.shape(n)[0] for n in ("motor.phi", "gear.flange_a.phi", "load.phi")]
    assert received == pytest.approx([1.0, -1.0, -1 / 3], rel=1e-12)
    w = 2 * np.pi * free.hertz[0]
    assert abs(free.shape("load.w")[0]) == pytest.approx(w / 3, rel=1e-12)
    assert free.rigid_shape("load.phi") == pytest.approx([1 / 3], rel=1e-12)


def test_separate_drives_have_separate_rigid_modes():
    model = lp.compose(
        one=in_a_row(a=Inertia(J=1.0), shaft=Spring(c=100.0), b=Inertia(J=1.0)),
        two=in_a_row(a=Inertia(J=2.0), shaft=Spring(c=100.0), b=Inertia(J=2.0)),
        held=in_a_row(body=Inertia(J=1.0), shaft=Spring(c=50.0), wall=Fixed()),
        lone=Inertia(J=1.0),
    )
    free = lp.modes(lp.assemble(model))
    assert free.rigid == 3
    assert set(free.rigid_names) == {"one.a.phi, one.b.phi", "two.a.phi, two.b.phi", "lone.phi"}
    expected = np.sqrt(np.sort([100 * 2, 100 * 1, 50])) / (2 * np.pi)
    assert free.hertz == pytest.approx(expected, rel=1e-13)
    assert free.shape("two.a.phi")[2] == 0.0


def test_keeping_the_absolute_angle_changes_no_mode(two_mass):
    plain = lp.modes(lp.assemble(two_mass))
    kept = lp.modes(lp.assemble(two_mass, keep=["a.phi"]))
    assert kept.hertz == pytest.approx(plain.hertz, rel=1e-14)
    assert kept.rigid == plain.rigid == 1
    assert kept.shape("b.phi") == pytest.approx(plain.shape("b.phi"), rel=1e-12)
    assert kept.rigid_names == plain.rigid_names == ("a.phi, b.phi",)


def test_modes_hold_at_the_operating_point_asked_for():
    system = lp.assemble(lp.compose(p=Pendulum()))
    below = lp.modes(system)
    assert below.hertz == pytest.approx([np.sqrt(15.0) / (2 * np.pi)], rel=1e-14)
    above = lp.modes(system, at=lp.start_point(system, start={"p.phi": lp.ops.pi}))
    assert above.decays == pytest.approx([-np.sqrt(15.0), np.sqrt(15.0)], rel=1e-12)
    sideways = lp.modes(system, at=lp.start_point(system, start={"p.phi": 1.0}))
    assert sideways.hertz == pytest.approx([np.sqrt(15 * np.cos(1.0)) / (2 * np.pi)], rel=1e-13)


def test_a_table_of_modes_is_readable(two_mass):
    text = repr(lp.modes(lp.assemble(two_mass)))
    assert "natural frequency, Hz" in text
    assert "b.phi +1.000; a.phi -0.500" in text
    assert "rigid body: a.phi, b.phi" in text


@pytest.mark.parametrize("zeta", [0.0, 0.3, 0.99])
def test_conditions_and_residuals_have_their_closed_forms(zeta):
    """An oscillator: 1/sqrt(1 - zeta^2); a wrong frequency misses by its error."""
    modes = lp.modes(lp.assemble(damped_pair(zeta)))
    assert modes.accuracy.conditions == pytest.approx([1 / np.sqrt(1 - zeta**2)], rel=1e-2)
    assert modes.accuracy.residuals.max() < 1e-15
    assert modes.damped_hertz == pytest.approx(modes.hertz * np.sqrt(1 - zeta**2), rel=1e-10)
    assert "residual of eigenpairs below 1e-14" in repr(modes)
    wrong = replace(modes, eigenvalues=modes.eigenvalues * 1.01)
    expected = 0.01 if zeta == 0 else 0.01 / (1 + 2 * zeta)
    assert wrong.accuracy.residuals == pytest.approx([expected], rel=0.35)


def test_an_open_play_is_a_rigid_motion_of_bodies():
    parts = {"a": Inertia(J=1.0), "play": ElastoBacklash(c=1e3, d=1.0, b=0.1), "b": Inertia(J=2.0)}
    modes = lp.modes(lp.assemble(in_a_row(**parts)))
    assert set(modes.rigid_names) == {"a.phi, b.phi", "play.phi_rel"}
    assert "no body" not in repr(modes)


class Clock(lp.Component):
    """A count that keeps its value, and a lag behind it."""

    count: lp.Var = lp.var("1", "count", start=3.0)
    lag: lp.Var = lp.var("1", "lag")

    def equations(self):
        yield lp.der(self.count) == 0
        yield 0.5 * lp.der(self.lag) == self.count - self.lag


def test_what_keeps_its_value_without_a_body_is_named_and_decays_have_vectors(two_mass):
    model = lp.compose(drive=two_mass, clock=Clock(), connections=lambda m: [])
    found = lp.modes(lp.assemble(model))
    assert set(found.rigid_names) == {"drive.a.phi, drive.b.phi", "no body, clock.count, clock.lag"}
    assert found.decays == pytest.approx([-2.0], rel=1e-15)
    (moved,) = np.flatnonzero(found.decay_vectors[:, 0])
    assert found.system.state_names[moved] == "clock.lag"


def test_shapes_are_scaled_by_angles_though_voltages_are_larger():
    model = in_rows(
        "battery.p cable.p",
        "cable.n motor.p",
        "motor.n battery.n ground.pin",
        "motor.flange shaft wall",
        battery=VoltageSource(v=100.0),
        ground=Ground(),
        cable=Resistor(R=5.0),
        motor=DCMotor(J=0.1, k=2.0, R=1.0, L=0.02),
        shaft=Spring(c=500.0),
        wall=Fixed(),
    )
    found = lp.modes(lp.assemble(model))
    assert np.abs(found.shape("motor.phi")) == pytest.approx([1.0], rel=1e-12)
    # cable and armature turn the speed into a current: i = -k w / (R + s L)
    s = found.eigenvalues[0]
    expected = 5.0 * 2.0 * np.abs(s / (6.0 + 0.02 * s))
    assert np.abs(found.shape("motor.p.v")) == pytest.approx([expected], rel=1e-10)
    assert expected > 10


def test_a_model_in_which_nothing_moves_prints_its_lack_of_modes():
    modes = lp.modes(lp.assemble(lp.compose(wanted=Constant(k=3.0))))
    assert "0 oscillating and 0 rigid-body modes, 0 decays" in repr(modes)


def damped_chain(n, alpha, beta, vary=0.0):
    """Equal discs on equal springs with dampers beside them, and dampers to the ground."""
    J, c = 0.3, 2e4
    row = [(f"body{i}", Inertia(J=J)) for i in range(n)]
    shafts = [SpringDamper(c=c, d=beta * c * (1 + vary * i)) for i in range(n - 1)]
    aside = [Damper(d=alpha * J) for _ in range(n)] if alpha else []

    def connections(m):
        bodies = [getattr(m, name) for name, _ in row]
        yield from lp.chain(
            *(p for pair in zip(bodies, m.shaft, strict=False) for p in pair), bodies[-1]
        )
        for body, damper in zip(bodies, m.brake if alpha else (), strict=False):
            yield lp.connect(body.flange_a, damper.flange_a)
            yield lp.connect(damper.flange_b, m.ground.flange)

    more = {"brake": aside, "ground": Fixed()} if alpha else {}
    return lp.assemble(lp.compose(**dict(row), shaft=shafts, **more, connections=connections))


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 1e-4), (0.8, 0.0), (0.8, 1e-4), (0.0, 1e-2)])
def test_proportional_damping_keeps_undamped_shapes(alpha, beta, monkeypatch):
    n = 120
    monkeypatch.setattr(scipy.linalg, "eig", None)  # too slow for many inertias
    found = lp.modes(damped_chain(n, alpha, beta))
    w = 2 * np.pi * uniform_hertz(n, 0.3, 2e4)
    half = 0.5 * (alpha + beta * w**2)
    slow = half < w
    np.testing.assert_allclose(2 * np.pi * found.hertz, w[slow], rtol=1e-12)
    np.testing.assert_allclose(found.damping, (half / w)[slow], rtol=1e-9)
    fast = half[~slow] + np.sqrt(half[~slow] ** 2 - w[~slow] ** 2)
    decays = np.concatenate([-fast, -(w[~slow] ** 2) / fast, [-alpha] * (alpha > 0)])
    np.testing.assert_allclose(found.decays, np.sort(decays), rtol=1e-12)
    assert found.rigid == (alpha == 0)


def test_a_rigid_motion_beside_damping_needs_no_singular_values(monkeypatch):
    system = damped_chain(60, 0.0, 1e-4, vary=0.01)
    expected = np.linalg.eigvals(lp.linearise(system).A)
    monkeypatch.setattr(np.linalg, "svd", None)
    found = lp.modes(system)
    upper = expected[expected.imag > 1e-6]
    np.testing.assert_allclose(
        found.eigenvalues, upper[np.argsort(np.abs(upper))], rtol=1e-9, atol=1e-9
    )
    assert found.rigid == 1
    assert found.rigid_shape("body7.phi") == pytest.approx([1.0], rel=1e-12)
