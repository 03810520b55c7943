"""What contacts ask of the hybrid kernel."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components.translation import Force, Mass, Stop
from lumped.errors import StartError


def pressed(*contacts, mass=1.0, force=-10.0, **start):
    """A mass with contacts, pressed by a force."""

    def connections(model):
        ends = [contact.flange_b for contact in model.contacts]
        yield lp.connect(model.mass.flange_a, model.force.flange, *ends)

    model = lp.compose(
        mass=Mass(m=mass, **start),
        force=Force(f=force),
        contacts=list(contacts),
        connections=connections,
    )
    return lp.assemble(model)


def test_two_equal_supports_share_the_load_and_nothing_moves():
    run = lp.simulate(pressed(Stop(), Stop(), s=0.1, v=0.0), until=1.0, rtol=1e-9)
    received = [run[f"contacts[{i}].f"][-1] for i in (0, 1)]
    expected = [-5.0, -5.0]
    np.testing.assert_allclose(received, expected, rtol=1e-7)
    np.testing.assert_allclose(run["mass.s"][-1], 0.0, atol=1e-12)


def test_a_body_that_starts_inside_another_is_refused_with_name_and_depth():
    with pytest.raises(StartError, match=r"contacts\[0\] starts 0\.25 m inside"):
        lp.start_point(pressed(Stop(), s=-0.25, v=0.0))


@pytest.mark.parametrize("depth", [0.2, 0.05, 1e-2, 1e-4, 1e-7])
def test_a_contact_that_would_last_less_than_a_step_is_found(depth):
    # without the ceiling the mass would rise v^2 / 2 g, and `depth` of that is above it
    v, g = 10.0, 9.81
    rise = v**2 / (2 * g) - depth
    system = pressed(Stop(), force=g, s=rise, v=-v)  # upside down
    run = lp.simulate(system, until=2.0)
    hit = run.events[0].time
    expected = v / g - np.sqrt(2 * depth / g)
    assert hit == pytest.approx(expected, rel=1e-9)
    assert run["mass.s"].min() >= -1e-12


def test_a_contact_that_separates_takes_an_impact_without_being_entered():
    # a hits b, which is just leaving c at the same place: b must not be driven into c
    model = in_a_row(
        a=Mass(m=5.0, s=0.0, v=10.0),
        first=Stop(restitution=0.5),
        b=Mass(m=1.0, s=0.0, v=0.0),
        second=Stop(restitution=0.5),
        c=Mass(m=1.0, s=0.0, v=0.1),
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    assert run["second.gap"].min() >= -1e-12
    # b and c go on together, a at half the speed of approach slower
    a = (5 * 10.0 + 0.1 - 2 * 5.0) / 7
    speeds = [run[f"{name}.v"][-1] for name in "abc"]
    np.testing.assert_allclose(speeds, [a, a + 5.0, a + 5.0], rtol=1e-12)
