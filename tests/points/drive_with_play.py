"""A drive with play in it, which several tests use."""

import lumped as lp
from lumped.components import ElastoBacklash, IdealGear, Inertia, SpringDamper, Torque


def geared(torque=5.0, ratio=5.0, **starts):
    """Motor, play, gear, elastic shaft and a load that balances the motor."""
    return lp.compose(
        motor=Torque(tau=torque),
        a=Inertia(J=1.0),
        play=ElastoBacklash(c=1e3, d=1.0, b=0.01),
        b=Inertia(J=10.0),
        gear=IdealGear(ratio=ratio),
        shaft=SpringDamper(c=1e3, d=1.0),
        e=Inertia(J=20.0),
        load=Torque(tau=-torque * ratio),
        connections=lambda m: lp.chain(m.motor, m.a, m.play, m.b, m.gear, m.shaft, m.e, m.load),
    ).with_(starts)
