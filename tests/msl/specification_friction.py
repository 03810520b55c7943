"""Friction elements of the reference cases, and the loads that stand beside them."""

import numpy as np

import lumped as lp
from lumped.components import BearingFriction, Brake, Clutch, OneWayClutch, Stribeck, translation


class QuadraticLoad(lp.Component):
    """Torque that grows with the square of the speed: ``tau = nominal w |w| / v_nominal^2``."""

    flange = lp.Flange()
    nominal: lp.Param = lp.param("N.m", "accelerating torque at the nominal speed")
    v_nominal: lp.Param = lp.param("rad/s", "nominal speed", nonzero=True)
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == -self.nominal * self.w * abs(self.w) / self.v_nominal**2


class TorqueStep(lp.Component):
    """Torque that jumps: ``tau = offset``, from `t_step` on ``offset + step``."""

    flange = lp.Flange()
    offset: lp.Param = lp.param("N.m", "torque before")
    step: lp.Param = lp.param("N.m", "jump")
    t_step: lp.Param = lp.param("s", "instant")

    def equations(self):
        risen = lp.ops.where(lp.time >= self.t_step, self.step, 0)
        yield self.flange.tau == -(self.offset + risen)


ROTATION = {
    "bearing_friction": BearingFriction,
    "brake": Brake,
    "clutch": Clutch,
    "load_quadratic": QuadraticLoad,
    "load_step": TorqueStep,
    "one_way_clutch": OneWayClutch,
}
TRANSLATION = {
    "bearing_friction": translation.SupportFriction,
    "brake": translation.Brake,
    "mass_with_stops_and_friction": translation.MassWithStopAndFriction,
}
PRESSED = {"mu": "characteristic", "cgeo": "c_geo", "fn_max": "f_max"}
PARAMETERS = {
    ("bearing_friction", False): {"table": "characteristic"},
    ("bearing_friction", True): {"table": "characteristic"},
    ("brake", False): PRESSED,
    ("brake", True): PRESSED,
    ("clutch", False): PRESSED,
    ("one_way_clutch", False): PRESSED,
    ("mass_with_stops_and_friction", True): {"L": "length", "smin": "s_min", "smax": "s_max"},
}


def plain(facts):
    """A component's facts with its friction as rows or a curve."""
    facts = dict(facts)
    if facts.get("table") == "stribeck_table":
        curve = [(v, 5 + v + 10 * np.exp(-2 * v)) for v in 12 * np.arange(50) / 49]
        facts["table"] = [[float(v), float(f)] for v, f in curve]
    if facts["type"] == "mass_with_stops_and_friction":
        viscous, coulomb, more, decay = (
            facts.pop(key) for key in ("F_prop", "F_Coulomb", "F_Stribeck", "fexp")
        )
        facts["characteristic"] = Stribeck(coulomb, coulomb + more, decay, viscous)
        facts["peak"] = 1.001
    if facts["type"] == "load_quadratic" and facts.pop("same_direction"):
        raise NotImplementedError("a load that drives in one direction")
    return facts
