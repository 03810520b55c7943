"""What is printed of a linearisation says where it was made."""

import numpy as np
import pytest
from drives_at_points import Fan
from rows import assemble_row, in_a_row, in_rows

import lumped as lp
from lumped.components import (
    Backlash,
    BearingFriction,
    Brake,
    Clutch,
    ElastoBacklash,
    Fixed,
    Inertia,
    OneWayClutch,
    SpringDamper,
    Stop,
    Torque,
)
from lumped.errors import OptionError


def lash():
    return assemble_row(
        a=Inertia(J=1.0),
        s=ElastoBacklash(c=1e3, d=1.0, b=0.01),
        b=Inertia(J=10.0),
        t=Torque(tau=0.0),
    )


def first_line(result):
    return repr(result).splitlines()[0]


def test_an_open_lash_is_named_on_the_first_line():
    system = lash()
    received = first_line(lp.modes(system))
    expected = "Model: 0 oscillating and 2 rigid-body modes, 0 decays; open: s"
    assert received == expected
    assert first_line(lp.linearise(system)).endswith("; open: s")
    answer = lp.frequency_response(system, inputs=["t.tau"], outputs=["b.w"], hertz=[1.0])
    assert first_line(answer).endswith("; open: s")
    diagram = lp.campbell(system, speeds=[0.0, 1.0], orders=[1])
    assert first_line(diagram).endswith("; open: s")
    assert first_line(lp.vibration.root_locus(system, along={"a.J": [1.0, 2.0]})).endswith(
        "; open: s"
    )


def test_a_lash_in_contact_is_not_open():
    system = lash()
    closed = lp.start_point(system, start={"s.phi_rel": 0.006})
    modes = lp.modes(system, at=closed)
    assert modes.hertz == pytest.approx([np.sqrt(1e3 * 1.1) / (2 * np.pi)], rel=1e-9)
    assert "open" not in repr(modes)


def test_a_locus_that_passes_several_situations_names_them_all():
    system = lash()

    def at(J):
        return lp.start_point(
            system, parameters={"a.J": J}, start={"s.phi_rel": 0.0 if J < 2 else 0.006}
        )

    found = lp.vibration.root_locus(system, along={"a.J": [1.0, 3.0]}, at=at)
    assert found.situations == ("; open: s", "")


def held():
    """A brake that sticks, one that slides, a clutch that is released, a play that is closed."""
    return in_rows(
        "t a",
        "play a",
        "b play",
        "b spring c clutch d",
        "b stuck",
        "d sliding",
        t=Torque(tau=1.0),
        a=Inertia(J=1.0),
        play=Backlash(b=0.1, phi_rel=0.05),
        b=Inertia(J=1.0),
        stuck=Brake(f_max=100.0, u=1.0),
        spring=SpringDamper(c=50.0, d=1.0),
        c=Inertia(J=1.0),
        clutch=Clutch(f_max=100.0, u=0.0),
        d=Inertia(J=1.0, w=5.0),
        sliding=BearingFriction(characteristic=((0.0, 2.0),)),
    )


def test_what_sticks_slides_is_closed_or_released_is_named():
    received = first_line(lp.modes(lp.assemble(held())))
    assert received.endswith("; closed: play; stuck: stuck; sliding: sliding; released: clutch")


def test_what_a_brake_holds_is_no_rigid_body_mode():
    """One body on a spring from the body that the brake holds, between two other springs."""
    model = in_rows(
        "a spring b soft wall",
        "a brake",
        a=Inertia(J=1.0),
        brake=Brake(f_max=100.0, u=1.0),
        spring=SpringDamper(c=50.0, d=1.0),
        b=Inertia(J=2.0),
        soft=SpringDamper(c=30.0, d=1.0),
        wall=Fixed(),
    )
    modes = lp.modes(lp.assemble(model, keep=["a.phi"]))
    assert modes.rigid == 0
    assert modes.hertz == pytest.approx([np.sqrt(80 / 2.0) / (2 * np.pi)], rel=1e-9)


def test_a_drive_without_contact_or_friction_has_nothing_to_say():
    model = in_a_row(a=Inertia(J=1.0), s=SpringDamper(c=1e3, d=1.0), b=Inertia(J=10.0))
    received = first_line(lp.modes(lp.assemble(model)))
    assert received == "Model: 1 oscillating and 1 rigid-body modes, 0 decays"


def test_a_fan_at_rest_is_not_open_and_has_one_linearisation():
    model = in_a_row(
        a=Inertia(J=1.0),
        fan=Fan(),
    )
    received = repr(lp.linearise(lp.assemble(model)))
    assert "open" not in received
    assert "one-sided" not in received


def test_a_point_at_a_border_is_called_one_sided():
    system = lash()
    point = lp.start_point(system, start={"s.phi_rel": 0.005})
    for found in (lp.linearise(system, at=point), lp.modes(system, at=point)):
        assert "one-sided: exactly at a border of s (" in repr(found)
    inside = lp.start_point(system, start={"s.phi_rel": 0.005 + 1e-6})
    assert "one-sided" not in repr(lp.modes(system, at=inside))


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (Stop(gap=0.0), "one-sided: exactly at a border of part (closed, with its reaction"),
        (OneWayClutch(u=0.0), "one-sided: exactly at a border of part (stuck, with its reaction"),
    ],
)
def test_a_contact_that_carries_nothing_is_one_sided(part, text):
    model = in_a_row(wall=Fixed(), part=part, a=Inertia(J=1.0))
    assert text in repr(lp.modes(lp.assemble(model)))


@pytest.mark.parametrize("ratio", [1e24, 1e26, 1e28])
@pytest.mark.parametrize("d", [0.0, 1e-3])
def test_modes_lost_beside_an_extreme_stiffness_are_counted(ratio, d):
    """Three bodies: one rigid-body mode, the soft one, and that of the two stiffly joined."""
    model = in_a_row(
        b1=Inertia(J=1.0),
        s1=SpringDamper(c=1.0, d=d),
        b2=Inertia(J=1.0),
        s2=SpringDamper(c=ratio, d=0.0),
        b3=Inertia(J=1.0),
    )
    modes = lp.modes(lp.assemble(model))
    found = 2 * len(modes.hertz)
    assert modes.hertz[-1] == pytest.approx(np.sqrt(2 * ratio) / (2 * np.pi), rel=1e-9)
    assert (modes.rigid, modes.lost) == (1 + 4 - found, 4 - found)
    assert ("note: 2 eigenvalues that are not zero" in repr(modes)) == (found < 4)


def test_orders_that_are_no_sequence_are_refused():
    system = lash()
    for orders in (1, ["a"], [None]):
        with pytest.raises(OptionError, match=r"orders = .* a list of finite numbers"):
            lp.campbell(system, speeds=[0.0, 1.0], orders=orders)
        with pytest.raises(OptionError, match=r"orders = .* a list of finite numbers"):
            lp.vibration.critical_speeds(lp.modes(system), orders)
