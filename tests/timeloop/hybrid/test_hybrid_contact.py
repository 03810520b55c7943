"""What contacts ask of the hybrid kernel; the components here are the smallest that show it."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components.translation import Force, Mass
from lumped.errors import StartError


class Slot(lp.Component):
    """A pin in a slot of unit width: two opposite contacts at one body."""

    flange = lp.LinearFlange()
    x: lp.Var = lp.var("m", "position in the slot", state="prefer")
    v: lp.Var = lp.var("m/s", "velocity", state="prefer")
    v_back: lp.Var = lp.var("m/s", "velocity the other way", state="avoid")
    lower: lp.Var = lp.var("N", "reaction of the lower end")
    upper: lp.Var = lp.var("N", "reaction of the upper end")

    def equations(self):
        yield self.x == self.flange.s
        yield self.v == lp.der(self.x)
        yield self.v_back == -self.v
        yield self.flange.f == self.lower - self.upper
        yield lp.hold(self.lower, self.v, gap=self.x + 0.5)
        yield lp.hold(self.upper, self.v_back, gap=0.5 - self.x)


class Slide(lp.Component):
    """Contact from above with a floor at the height zero."""

    flange = lp.LinearFlange()
    s: lp.Var = lp.var("m", "height", state="prefer")
    v: lp.Var = lp.var("m/s", "velocity", state="prefer")
    f: lp.Var = lp.var("N", "reaction")

    def equations(self):
        yield self.s == self.flange.s
        yield self.v == lp.der(self.s)
        yield self.flange.f == self.f
        yield lp.hold(self.f, self.v, gap=self.s)


def pressed(*contacts, mass=1.0, force=-10.0, **start):
    """A mass with contacts, pressed by a force."""

    def connections(model):
        ends = [contact.flange for contact in model.contacts]
        yield lp.connect(model.mass.flange_a, model.force.flange, *ends)

    model = lp.compose(
        mass=Mass(m=mass, **start),
        force=Force(f=force),
        contacts=list(contacts),
        connections=connections,
    )
    return lp.assemble(model)


@pytest.mark.parametrize("mass", [0.5, 1.0, 3.0])
def test_opposite_contacts_of_one_body_carry_the_whole_force(mass):
    run = lp.simulate(pressed(Slot(), mass=mass, s=-0.4, v=0.0), until=1.0, rtol=1e-9)
    received = [run["contacts[0].lower"][-1], run["contacts[0].upper"][-1]]
    expected = [-10.0, 0.0]
    np.testing.assert_allclose(received, expected, rtol=1e-14)
    assert run["mass.v"][-1] == 0.0


def test_two_equal_supports_share_the_load_and_nothing_moves():
    run = lp.simulate(pressed(Slide(), Slide(), s=0.1, v=0.0), until=1.0, rtol=1e-9)
    received = [run[f"contacts[{i}].f"][-1] for i in (0, 1)]
    expected = [-5.0, -5.0]
    np.testing.assert_allclose(received, expected, rtol=1e-7)
    np.testing.assert_allclose(run["mass.s"][-1], 0.0, atol=1e-12)


def test_a_body_that_starts_in_contact_and_moving_into_it_collides_at_once():
    run = lp.simulate(pressed(Slide(), mass=3.0, s=0.0, v=-2.0), until=1.0)
    hits = [(event.time, event.component, event.after, event.loss) for event in run.events]
    expected = [(0.0, "contacts[0]", "closed", pytest.approx(3.0 * 2.0**2 / 2, rel=1e-14))]
    assert hits == expected
    assert run["mass.v"][0] == 0.0


def test_a_body_that_starts_inside_another_is_refused_with_name_and_depth():
    with pytest.raises(StartError, match=r"contacts\[0\] starts 0\.25 m inside"):
        lp.start_point(pressed(Slide(), s=-0.25, v=0.0))


@pytest.mark.parametrize("depth", [0.2, 0.05, 1e-2, 1e-4, 1e-7])
def test_a_contact_that_would_last_less_than_a_step_is_found(depth):
    # without the ceiling the mass would rise v^2 / 2 g, and `depth` of that is above it
    v, g = 10.0, 9.81
    rise = v**2 / (2 * g) - depth
    system = pressed(Slide(), force=g, s=rise, v=-v)  # upside down
    run = lp.simulate(system, until=2.0)
    hit = run.events[0].time
    expected = v / g - np.sqrt(2 * depth / g)
    assert hit == pytest.approx(expected, rel=1e-9)
    assert run["mass.s"].min() >= -1e-12


def test_a_contact_that_separates_takes_an_impact_without_being_entered():
    # a hits b, which is just leaving c at the same place: b must not be driven into c
    class Pair(lp.Component):
        """Contact between two bodies."""

        flange_a = lp.LinearFlange()
        flange_b = lp.LinearFlange()
        gap: lp.Var = lp.var("m", "gap", state="prefer")
        v: lp.Var = lp.var("m/s", "velocity", state="prefer")
        f: lp.Var = lp.var("N", "reaction")

        def equations(self):
            yield self.gap == self.flange_b.s - self.flange_a.s
            yield self.v == lp.der(self.gap)
            yield self.flange_b.f == self.f
            yield self.flange_a.f == -self.f
            yield lp.hold(self.f, self.v, gap=self.gap, restitution=0.5)

    model = in_a_row(
        a=Mass(m=5.0, s=0.0, v=10.0),
        first=Pair(),
        b=Mass(m=1.0, s=0.0, v=0.0),
        second=Pair(),
        c=Mass(m=1.0, s=0.0, v=0.1),
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    assert run["second.gap"].min() >= -1e-12
    # b and c go on together, a at half the speed of approach slower
    a = (5 * 10.0 + 0.1 - 2 * 5.0) / 7
    speeds = [run[f"{name}.v"][-1] for name in "abc"]
    np.testing.assert_allclose(speeds, [a, a + 5.0, a + 5.0], rtol=1e-12)
