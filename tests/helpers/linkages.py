"""Closed linkages that several tests use."""

import numpy as np
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import Inertia
from lumped.components.translation import Force, Mass
from lumped.ops import cos, sin, sqrt


class FourBar(lp.Component):
    """Crank, coupler and rocker on a frame: r cos a + c cos q = d + s cos b, the same with sin."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    r: lp.Param = lp.param("m", "crank", 1.0, above=0)
    c: lp.Param = lp.param("m", "coupler", 3.0, above=0)
    s: lp.Param = lp.param("m", "rocker", 2.5, above=0)
    d: lp.Param = lp.param("m", "frame", 3.2, above=0)
    q: lp.Var = lp.var("rad", "angle of the coupler", 0.8)
    f_x: lp.Var = lp.var("N", "force in the joint")
    f_y: lp.Var = lp.var("N", "force in the joint")

    def equations(self):
        a, b, q = self.flange_a.phi, self.flange_b.phi, self.q
        yield self.r * cos(a) + self.c * cos(q) == self.d + self.s * cos(b)
        yield self.r * sin(a) + self.c * sin(q) == self.s * sin(b)
        yield self.flange_a.tau == self.r * (self.f_y * cos(a) - self.f_x * sin(a))
        yield self.flange_b.tau == self.s * (self.f_x * sin(b) - self.f_y * cos(b))
        yield self.f_y * cos(q) - self.f_x * sin(q) == 0


class Crank(lp.Component):
    """Crank and rod without mass: s = r cos(phi) + sqrt(length^2 - r^2 sin^2)."""

    flange_a = lp.Flange()
    flange_b = lp.LinearFlange()
    r: lp.Param = lp.param("m", "radius of the crank", 0.1, above=0)
    length: lp.Param = lp.param("m", "length of the rod", 0.3, above=0)

    def equations(self):
        phi, r = self.flange_a.phi, self.r
        s = r * cos(phi) + sqrt(self.length**2 - (r * sin(phi)) ** 2)
        yield lp.lossless(self.flange_b.s == s, self.flange_a, self.flange_b)


class Yoke(lp.Component):
    """Pin of a crank in a straight slot: s = r sin(phi)."""

    flange_a = lp.Flange()
    flange_b = lp.LinearFlange()
    r: lp.Param = lp.param("m", "radius of the crank", 0.1, above=0)

    def equations(self):
        law = self.flange_b.s == self.r * sin(self.flange_a.phi)
        yield lp.lossless(law, self.flange_a, self.flange_b)


class Rod(lp.Component):
    """Rigid rod between a slide along x and one along y: x^2 + y^2 = length^2."""

    x = lp.LinearFlange()
    y = lp.LinearFlange()
    length: lp.Param = lp.param("m", "length", 2.0, above=0)
    pull: lp.Var = lp.var("N/m", "force in the rod over its length")

    def equations(self):
        yield self.x.s**2 + self.y.s**2 == self.length**2
        yield self.x.f == self.pull * self.x.s
        yield self.y.f == self.pull * self.y.s


def pendulum(v):
    """A mass on a rod, in coordinates across and down, with a speed at its lowest place."""
    return in_rows(
        "across.flange_a rod.x",
        "down.flange_a rod.y weight.flange",
        across=Mass(m=1.0, s=0.0, v=v),
        down=Mass(m=1.0, s=2.0),
        rod=Rod(),
        weight=Force(f=9.81),
    )


def four_bar(**starts):
    return in_a_row(
        crank=Inertia(J=2.0, **starts),
        linkage=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),  # where the search begins: the rocker above the frame
    )


def double_rocker(**starts):
    """A linkage whose crank swings to and fro between dead centres while the coupler turns."""
    lengths = {"linkage.r": 2.6, "linkage.s": 2.5, "linkage.c": 1.2, "linkage.d": 3.0}
    guesses = {"crank.phi": 0.6, "rocker.phi": 1.4, "linkage.q": 0.3}
    return four_bar(**starts).with_({**lengths, **guesses})


def rocker_angle(phi):
    """Freudenstein's closed form for the assembly with the rocker above the frame."""
    r, coupler, s, d = 1.0, 3.0, 2.5, 3.2
    x, y = d - r * np.cos(phi), -r * np.sin(phi)  # from crank pin to rocker pivot
    k = (x * x + y * y + s * s - coupler * coupler) / (2 * s)
    return np.arctan2(-y, -x) - np.arccos(k / np.hypot(x, y))
