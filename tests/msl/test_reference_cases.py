"""Trajectories of the reference results of the Modelica Standard Library."""

import numpy as np
import pytest
from specification import build, read

import lumped as lp
from lumped.components import Damper, Fixed, Inertia
from lumped.components.translation import Force, Mass

G = 9.80665  # m/s2
POSITIONS = ("phi", "s")


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


class Engine(lp.Component):
    """Slider-crank engine without gas: flywheel, crank, connecting rod and piston, with weight."""

    inertia: Inertia = Inertia(J=1.0)
    crank: Inertia = Inertia(J=0.0114306736)
    crank_top: Cosine = Cosine(radius=1.0)
    crank_weight: Force = Force(f=-G * 0.131428093)  # static moment, on an arm of 1 m
    piston_lift: Connecting = Connecting(share=1.0)
    piston: Mass = Mass(m=6.04756586)
    piston_weight: Force = Force(f=-G * 6.04756586)
    rod_lift: Connecting = Connecting(share=0.5)
    rod_up: Mass = Mass(m=1.848)
    rod_weight: Force = Force(f=-G * 1.848)
    rod_sway: Cosine = Cosine(radius=0.05, phase=np.pi / 2)
    rod_aside: Mass = Mass(m=1.848)
    rod_tilt: Tilt = Tilt()
    rod: Inertia = Inertia(J=0.0067144)

    def connections(self):
        lifts = (self.crank_top, self.piston_lift, self.rod_lift, self.rod_sway, self.rod_tilt)
        yield lp.connect(self.inertia.flange_b, self.crank.flange_a, *(p.turn for p in lifts))
        yield lp.connect(self.crank_top.slide, self.crank_weight.flange)
        yield lp.connect(self.piston_lift.slide, self.piston.flange_a, self.piston_weight.flange)
        yield lp.connect(self.rod_lift.slide, self.rod_up.flange_a, self.rod_weight.flange)
        yield lp.connect(self.rod_sway.slide, self.rod_aside.flange_a)
        yield lp.connect(self.rod_tilt.tilt, self.rod.flange_a)


class Pendulum(lp.Component):
    """Planar body on a damped joint, level at the angle zero."""

    rev: Inertia = Inertia(J=0.001)
    joint: Damper = Damper(d=0.1)
    ground: Fixed = Fixed()
    across: Cosine = Cosine(radius=0.5)
    up: Cosine = Cosine(radius=0.5, phase=np.pi / 2)
    body_across: Mass = Mass(m=1.0)
    body_up: Mass = Mass(m=1.0)
    weight: Force = Force(f=-G)

    def connections(self):
        yield from lp.chain(self.ground, self.joint, self.rev)
        yield lp.connect(self.rev.flange_b, self.across.turn, self.up.turn)
        yield lp.connect(self.across.slide, self.body_across.flange_a)
        yield lp.connect(self.up.slide, self.body_up.flange_a, self.weight.flange)


WRITTEN_OUT = {"engine_motored": Engine, "pendulum_damped": Pendulum}
BUILT = (
    "mt_connection_possibilities",
    "mt_directions2",
    "mt_initialization_inertia",
    "mt_simple_drive_train",
    "mt_test_speed",
    "rot_first",
    "rot_first_grounded",
    "rot_generation_of_fmus",
    "tr_accelerate",
    "tr_damper",
    "tr_initial_conditions",
    "tr_oscillator",
    "tr_sensors",
    "tr_sign_convention",
)


def outside_of_tube(t, curve, case, expected, half_width):
    """Distance of each reference point from the range of the curve within the time window."""
    result = []
    for at, value in zip(case.t, expected, strict=True):
        ends = np.clip([at - half_width, at + half_width], 0, case.stop)
        inside = curve[(t >= ends[0]) & (t <= ends[1])]
        reached = np.concatenate([inside, np.interp(ends, t, curve)])
        result.append(max(reached.min() - value, value - reached.max(), 0.0))
    return np.array(result)


@pytest.mark.parametrize("name", [*BUILT, *WRITTEN_OUT])
def test_the_trajectory_follows_the_reference(name):
    case = read(name)
    model = WRITTEN_OUT[name]() if name in WRITTEN_OUT else build(case)
    keep = [q for q in case.columns if q.rpartition(".")[2] in POSITIONS]
    system = lp.assemble(model, keep=keep)
    options = {"until": case.stop, "start": case.start, "rtol": 1e-9}
    at_times = lp.simulate(system, grid=case.t, **options)
    fine = lp.simulate(system, grid=4000, **options)
    rule = case.facts["tolerance"]
    known = case.facts["reference_check"]["max_pointwise_deviation"]
    limit = 1e-4 if known <= 1e-4 else known + 1e-4
    last_at_its_time = np.append(np.diff(case.t) > 0, True)
    faults = []
    for column, expected in case.columns.items():
        span = np.ptp(expected)
        pointwise = np.abs(at_times[column] - expected)[last_at_its_time].max()
        tube = outside_of_tube(
            fine.t, fine[column], case, expected, rule["relative_width"] * case.stop
        ).max()
        if span < 1e-9:
            print(f"{name} {column}: constant, worst deviation {pointwise:.1e}")
            passes = pointwise <= 1e-6
        else:
            print(
                f"{name} {column}: worst deviation {pointwise / span:.1e} of the range "
                f"(limit {limit:.1e}), {tube / span:.1e} within the time window"
            )
            passes = pointwise <= limit * span and tube <= rule["relative_height"] * span
        if not passes:
            faults.append(column)
    assert not faults
