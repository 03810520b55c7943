"""Derivatives of runs against closed forms."""

import numpy as np
import pytest
from checks import STEP, refused, worst
from rows import assemble_row, in_a_row, one
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    BearingFriction,
    Damper,
    Fixed,
    IdealGear,
    Inertia,
    SpringDamper,
    Torque,
)
from lumped.errors import OptionError, UnknownNameError


@pytest.fixture
def oscillator():
    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -self.k * self.x
        yield self.y == self.x + self.v

    return lp.assemble(
        one(
            equations,
            k=lp.param("1/s2", "stiffness over mass", 4.0),
            x=lp.var("m", "position", start=1.5),
            v=lp.var("m/s", "velocity"),
            y=lp.var("1", "sum"),
        )
    )


@pytest.mark.parametrize(("d", "method"), [(3.0, "explicit"), (3e4, "implicit")])
def test_a_damped_drive_agrees_with_a_matrix_exponential(d, method):
    J_a, J_b, c, w = 0.5, 2.0, 800.0, 3.0
    system = assemble_row(a=Inertia(J=J_a, w=w), shaft=SpringDamper(c=c, d=d), b=Inertia(J=J_b))
    to = ["a.J", "shaft.c", "shaft.d", "a.w"]
    found = lp.sensitivity(system, of=["b.w", "shaft.tau"], by=to, until=0.5, grid=20, rtol=1e-8)
    assert method in found.run.statistics.method

    def matrix(J_a, c, d):
        """Rates of w_a, w_b and the twist b - a."""
        return np.array(
            [[-d / J_a, d / J_a, c / J_a], [d / J_b, -d / J_b, -c / J_b], [-1.0, 1.0, 0.0]]
        )

    def follow(J_a, c, d, w):
        """Speed of b, and torque of the shaft with the sizes of its terms."""
        found = [expm(matrix(J_a, c, d) * t) @ np.array([w, 0, 0]) for t in found_at]
        w_a, w_b, twist = np.array(found).T
        return w_b, c * twist, d * w_b, -d * w_a

    found_at = found.run.t
    point = np.array([J_a, c, d, w])
    for k, name in enumerate(to):
        moved = point + STEP * np.eye(4)[k]
        speed, *terms = (np.imag(v) / STEP.imag for v in follow(*moved))
        assert worst(found["b.w", name], speed) < 1e-5
        # the two terms of the damper nearly cancel
        size = np.abs(terms).sum(axis=0).max()
        assert np.abs(found["shaft.tau", name] - sum(terms)).max() / size < 1e-7


def test_a_body_that_friction_stops_comes_to_rest_whatever_its_start():
    J, w, mu = 2.0, 6.0, 5.0
    system = assemble_row(
        push=Torque(tau=0.5),
        body=Inertia(J=J, w=w),
        bearing=BearingFriction(characteristic=((0.0, mu),)),
        keep=["body.phi"],
    )
    found = lp.sensitivity(system, of=["body.w", "body.phi"], by=["body.w", "push.tau"], until=4.0)
    t, a = found.run.t, (mu - 0.5) / J
    stop = w / a
    sliding, stuck = t < stop * (1 - 1e-9), t > stop * (1 + 1e-9)
    for pair, part, expected in (
        (("body.w", "body.w"), sliding, 1.0),
        (("body.phi", "body.w"), stuck, w / a),
        (("body.phi", "push.tau"), stuck, w**2 / (2 * a**2) / J),
    ):
        assert found[pair][part] == pytest.approx(expected, rel=1e-9)
    assert np.abs(found["body.w", "body.w"][stuck]).max() < 1e-12
    ((_, slopes, components, _),) = found.instants
    assert components == ("bearing",)
    assert slopes == pytest.approx([1 / a, w / a**2 / J], rel=1e-9)


def test_what_cannot_be_differentiated_is_named(oscillator):
    def call(system=oscillator, of=("x",), to=("k",), **options):
        return lambda: lp.sensitivity(system, of=of, by=to, until=1.0, **options)

    refused(OptionError, call(grid=[0.0, 1.0]), "a whole number")
    refused(OptionError, call(to=()), "at least one")
    text = "y is no parameter that can be changed, no given start value and no state"
    refused(OptionError, call(to=("y",)), text)


def test_start_values_that_determine_states_through_equations_are_followed():
    # the load turns at w_motor / ratio: no state, and its start value depends on the ratio
    model = in_a_row(
        a=Inertia(J=1.0),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0, w=3.0),
        oil=Damper(d=0.5),
        wall=Fixed(),
    )
    to = ["gear.ratio", "b.w"]
    found = lp.sensitivity(lp.assemble(model), of=["a.w"], by=to, until=2.0, rtol=1e-9)
    # w_a = r w_b exp(-d t / J), J = J_b + r^2 J_a
    t, r, d, J = found.run.t, 4.0, 0.5, 2.0 + 16.0
    decay = np.exp(-d * t / J)
    assert worst(found["a.w", "b.w"], r * decay) < 1e-7
    assert worst(found["a.w", "gear.ratio"], 3.0 * decay * (1 + r * d * t / J**2 * 2 * r)) < 1e-7


def test_a_closed_linkage_agrees_with_its_closed_form():
    # a massless follower: y^2 = l^2 - x^2 with x at constant speed
    def equations(self):
        yield lp.der(self.x) == self.v
        yield self.x**2 + self.y**2 == self.l**2

    system = lp.assemble(
        one(
            equations,
            v=lp.param("m/s", "speed", 0.5),
            l=lp.param("m", "length of the rod", 2.0),
            x=lp.var("m", "one end", state="always"),
            y=lp.var("m", "other end", start=2.0),
        )
    )
    found = lp.sensitivity(system, of=["y"], by=["v", "l"], until=2.0)
    x = 0.5 * found.run.t
    y = np.sqrt(4 - x**2)
    assert worst(found["y", "v"], -x * found.run.t / y) < 1e-9
    assert worst(found["y", "l"], 2.0 / y) < 1e-9


def test_what_was_not_differentiated_and_instants_outside_of_the_run_are_refused(oscillator):
    found = lp.sensitivity(oscillator, of=["x"], by=["k"], until=1.0, grid=4)
    for action in (found.ranked, found.plot):
        unknown = "'y' is not in this sensitivity. Known: x"
        refused(UnknownNameError, lambda a=action: a("y"), unknown)
        for at in (-0.5, 7.0):
            outside = "s is not within the run, 0 to 1 s"
            refused(OptionError, lambda a=action, t=at: a("x", at=t), outside)
