"""Parts and drives that several tests use."""

from rows import in_a_row

import lumped as lp
from lumped.components import ElastoBacklash, IdealGear, Inertia, SpringDamper, Torque


def geared(torque=5.0, ratio=5.0, **starts):
    """Motor, play, gear, elastic shaft and a load that balances the motor."""
    return in_a_row(
        motor=Torque(tau=torque),
        a=Inertia(J=1.0),
        play=ElastoBacklash(c=1e3, d=1.0, b=0.01),
        b=Inertia(J=10.0),
        gear=IdealGear(ratio=ratio),
        shaft=SpringDamper(c=1e3, d=1.0),
        e=Inertia(J=20.0),
        load=Torque(tau=-torque * ratio),
    ).with_(starts)


class Fan(lp.Component):
    """Torque ``k w |w|`` against the motion, in two pieces that join smoothly."""

    flange = lp.Flange()
    k: lp.Param = lp.param("N.m.s2/rad2", "factor", 2.0)

    def equations(self):
        w = lp.der(self.flange.phi)
        yield self.flange.tau == lp.ops.where(w > 0, self.k * w**2, -self.k * w**2)


class Steady(Inertia):
    """Inertia that starts without acceleration."""

    def initial_equations(self):
        yield lp.der(self.w) == 0
