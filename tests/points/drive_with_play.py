"""A drive with play in it, which several tests use."""

from rows import in_a_row

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
