"""A report lists parameters that no equation has."""

import lumped as lp
from lumped.components import Inertia


class Rotor(lp.Component):
    """A wheel of a disc and a ring, of which some numbers have no effect."""

    r: lp.Param = lp.param("m", "radius, by which the inertia follows", 0.5)
    J: lp.Param = lp.param("kg.m2", "inertia", lambda rotor: 3.0 * rotor.r**2)
    w0: lp.Param = lp.param("rad/s", "speed at the start", 2.0)
    forgotten: lp.Param = lp.param("1", "factor that no equation has", 1.0)
    wheel: Inertia = Inertia(J=J, w=w0)


def test_parameters_without_effect_are_listed():
    report = lp.assemble(lp.compose(rotor=Rotor(), other=Inertia(J=1.0))).report()
    assert report.idle == ("rotor.forgotten",)
    assert "parameters in no equation\n  rotor.forgotten" in repr(report)
