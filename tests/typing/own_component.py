"""What type checkers say of components that a user declares; a mark names the error of a line."""

from collections.abc import Iterator, Sequence
from typing import Literal, assert_type

import numpy as np

import lumped as lp
from lumped.components import Inertia, Spring, SpringDamper, Torque


class Drive(lp.Component):
    """Motor and load on a shaft; annotated declarations are arguments."""

    J: lp.Param = lp.param("kg.m2", "moment of inertia of the motor", above=0)
    c: lp.Param = lp.param("N.m/rad", "stiffness", 1e4, above=0)
    u: lp.Input = lp.Input("N.m", "torque of the motor")
    twist: lp.Var = lp.var("rad", "twist of the shaft")
    power = lp.Output("W", "power of the motor")
    load = lp.Flange()
    free: lp.Flange = lp.Flange(free=True)
    sort: Literal["stiff", "soft"] = "stiff"
    braked: bool = False
    motor: Torque = Torque()
    rotor: Inertia = Inertia(J=2 * J, w=3)
    shaft: Spring | SpringDamper = Spring(c=c)
    masses: Sequence[Inertia] = (Inertia(J=J), Inertia(J="1 kg.m2"))
    hub = Inertia(J=J / 10)

    def equations(self) -> Iterator[lp.Equation]:
        assert_type(self.J, lp.Expr)
        assert_type(self.u, lp.Expr)
        assert_type(self.power, lp.Expr)
        assert_type(self.rotor.w, lp.Expr)
        assert_type(self.hub, Inertia)
        assert_type(self.braked, bool)
        yield self.twist == self.shaft.phi_rel
        yield self.power == self.u * self.rotor.w
        yield self.twist == self.rotor.speed  # error: attr-defined, reportAttributeAccessIssue

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.motor, self.rotor, self.shaft, self.load)
        yield lp.connect(self.u, self.motor.tau)


class Geared(Drive):
    """A subclass has the arguments of its base too."""

    ratio: lp.Param = lp.param("1", "gear ratio", 1.0, nonzero=True)
    c: lp.Param = lp.param("N.m/rad", "stiffness, greater here", 2e4, above=0)


class Plant(lp.Component):
    """Arguments are checked in class bodies too, where parameters are expressions."""

    c: lp.Param = lp.param("N.m/rad", "stiffness of both drives", above=0)
    left: Geared = Geared(J=1, c=2 * c, u=lp.ops.sin(lp.time), ratio=-3)
    right: Geared = Geared(J=1, k=2 * c)  # error: call-arg, reportCallIssue


Drive(J=1, c="5 kN.m/rad", u=3.0, twist=0, sort="soft", braked=True)
Drive(shaft=SpringDamper(c=3, d=1), masses=[Inertia(J=np.float64(1))])
geared = Geared(J=1, ratio=2, u=5 * lp.time, braked=True)
assert_type(geared.ratio, lp.Expr)
assert_type(geared.rotor, Inertia)
kind: type[lp.Component] = Drive
kind(J=3)

Drive(K=3)  # error: call-arg, reportCallIssue
Drive(J=[1, 2])  # error: arg-type, reportArgumentType
Drive(ratio=2)  # error: call-arg, reportCallIssue
Drive(power=3.0)  # error: call-arg, reportCallIssue
Drive(load=lp.Flange())  # error: call-arg, reportCallIssue
Drive(free=lp.Flange())  # error: arg-type, reportArgumentType
Drive(hub=Inertia(J=1))  # error: call-arg, reportCallIssue
Drive(sort="hard")  # error: arg-type, reportArgumentType
Drive(braked=3)  # error: arg-type, reportArgumentType
Drive(rotor=Spring(c=1))  # error: arg-type, reportArgumentType
Drive(rotor=3.0)  # error: arg-type, reportArgumentType
Geared(ratio=None)  # error: arg-type, reportArgumentType
geared.ratio = 3.0  # error: arg-type, reportAttributeAccessIssue
