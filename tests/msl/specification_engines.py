"""Reference cases of engines and a pendulum, written out."""

import numpy as np
from rows import in_rows

import lumped as lp
from lumped.components import Damper, Fixed, Inertia
from lumped.components.translation import Force, Mass

G = 9.80665  # m/s2


class Cosine(lp.Component):
    """Height of a point that turns: ``s = radius cos(phi - phase)``."""

    turn = lp.Flange()
    slide = lp.LinearFlange()
    radius: lp.Param = lp.param("m", "radius")
    phase: lp.Param = lp.param("rad", "angle of the top", 0.0)

    def equations(self):
        angle = self.turn.phi - self.phase
        yield lp.lossless(self.slide.s == self.radius * lp.ops.cos(angle), self.turn, self.slide)


class Connecting(lp.Component):
    """Height of a point of a connecting rod: crank pin plus `share` of the rod's height."""

    turn = lp.Flange()
    slide = lp.LinearFlange()
    r: lp.Param = lp.param("m", "radius of the crank", 0.1)
    rod: lp.Param = lp.param("m", "length of the rod", 0.2)
    share: lp.Param = lp.param("1", "distance from the crank pin over length of the rod")

    def equations(self):
        phi, r = self.turn.phi, self.r
        height = lp.ops.sqrt(self.rod**2 - (r * lp.ops.sin(phi)) ** 2)
        s = r * lp.ops.cos(phi) + self.share * height
        yield lp.lossless(self.slide.s == s, self.turn, self.slide)


class Tilt(lp.Component):
    """Angle of a connecting rod to its line of stroke: ``rod sin(beta) = r sin(phi)``."""

    turn = lp.Flange()
    tilt = lp.Flange()
    r: lp.Param = lp.param("m", "radius of the crank", 0.1)
    rod: lp.Param = lp.param("m", "length of the rod", 0.2)

    def equations(self):
        beta = lp.ops.asin(self.r / self.rod * lp.ops.sin(self.turn.phi))
        yield lp.lossless(self.tilt.phi == beta, self.turn, self.tilt)


def engine(*rows, **more):
    """Slider-crank engine without gas: flywheel, crank, connecting rod and piston, with weight."""
    return in_rows(
        "inertia.flange_b crank.flange_a crank_top.turn piston_lift.turn rod_lift.turn "
        "rod_sway.turn rod_tilt.turn",
        *("crank_top.slide crank_weight.flange", "piston_lift.slide piston.flange_a"),
        *("piston_weight piston", "rod_lift.slide rod_up.flange_a", "rod_weight rod_up"),
        *("rod_sway.slide rod_aside.flange_a", "rod_tilt.tilt rod.flange_a"),
        *rows,
        inertia=Inertia(J=1.0),
        crank=Inertia(J=0.0114306736),
        crank_top=Cosine(radius=1.0),
        crank_weight=Force(f=-G * 0.131428093),  # static moment, on an arm of 1 m
        piston_lift=Connecting(share=1.0),
        piston=Mass(m=6.04756586),
        piston_weight=Force(f=-G * 6.04756586),
        rod_lift=Connecting(share=0.5),
        rod_up=Mass(m=1.848),
        rod_weight=Force(f=-G * 1.848),
        rod_sway=Cosine(radius=0.05, phase=np.pi / 2),
        rod_aside=Mass(m=1.848),
        rod_tilt=Tilt(),
        rod=Inertia(J=0.0067144),
        **more,
    )


def pendulum():
    """Planar body on a damped joint, level at the angle zero."""
    return in_rows(
        *("ground joint rev", "rev.flange_b across.turn up.turn", "weight body_up"),
        *("across.slide body_across.flange_a", "up.slide body_up.flange_a"),
        rev=Inertia(J=0.001),
        joint=Damper(d=0.1),
        ground=Fixed(),
        across=Cosine(radius=0.5),
        up=Cosine(radius=0.5, phase=np.pi / 2),
        body_across=Mass(m=1.0),
        body_up=Mass(m=1.0),
        weight=Force(f=-G),
    )


class GasForce(lp.Component):
    """Gas force on a piston, from its position and the sign of its speed."""

    flange = lp.LinearFlange()
    v: lp.Var = lp.var("m/s", "speed away from the head")

    def equations(self):
        # the flange is the piston pin, 0.1 m below the top of the piston
        s = 0.45 - (self.flange.s + 0.1)
        yield self.v == -lp.der(self.flange.s)
        x = 1 - s / 0.35
        compression = lp.ops.where(
            x < 0.986061,
            177.4132 * x**4 - 287.2189 * x**3 + 151.8252 * x**2 - 24.9973 * x + 2.4,
            2836360 * x**4 - 10569296 * x**3 + 14761814 * x**2 - 9158505 * x + 2129670,
        )
        expansion = lp.ops.where(
            x <= 0.933,
            145.930 * x**4 - 131.707 * x**3 + 17.3438 * x**2 + 17.9272 * x + 2.4,
            -3929704 * x**4 + 14748765 * x**3 - 20747000 * x**2 + 12964477 * x - 3036495,
        )
        pressure = 1e5 * lp.ops.where(self.v < 0, compression, expansion)
        yield self.flange.f == pressure * np.pi * 0.1**2 / 4


WRITTEN_OUT = {
    "engine_fired": lambda: engine("gas piston", gas=GasForce()),
    "engine_motored": engine,
    "pendulum_damped": pendulum,
}
