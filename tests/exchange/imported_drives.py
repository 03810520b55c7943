"""A drive with a controller that may be a unit of FMI."""

from rows import assemble_rows

import lumped as lp
from lumped.components import (
    Damper,
    Fixed,
    Inertia,
    SampleHold,
    SpeedSensor,
    SpringDamper,
    Torque,
    from_fmu,
)

T_S = 0.01


class PI(lp.Component):
    """``M = k (e + x / T_i)``, ``x' = e``."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    measured: lp.Input = lp.Input("rad/s", "measured speed")
    M = lp.Output("N.m", "torque")
    x: lp.Var = lp.var("rad", "integral")
    k: lp.Param = lp.param("N.m.s/rad", "gain", 5.0)
    T_i: lp.Param = lp.param("s", "integral time", 0.5)

    def equations(self):
        e = self.wanted - self.measured
        yield lp.der(self.x) == e
        yield self.k * (e + self.x / self.T_i) == self.M


def drive(controller, *, held):
    """Two masses and a controller; between samples and holds if it does not sample by itself."""
    parts = {
        "motor": Torque(),
        "rotor": Inertia(J=2.0),
        "shaft": SpringDamper(c=400.0, d=0.5),
        "roll": Inertia(J=3.0),
        "friction": Damper(d=0.3),
        "ground": Fixed(),
        "sensor": SpeedSensor(),
        "pi": controller,
    }
    if held:
        parts |= {"sample": SampleHold(T_s=T_S), "hold": SampleHold(T_s=T_S)}
        rows = ["sensor.w sample.u", "sample.y pi.measured", "pi.M hold.u", "hold.y motor.tau"]
    else:
        rows = ["sensor.w pi.measured", "pi.M motor.tau"]
    return assemble_rows("motor rotor shaft roll friction ground", "rotor sensor", *rows, **parts)


def unit_of(folder, version="3.0", kind="co_simulation", **values):
    return from_fmu(folder / f"pi_{version}.fmu", kind=kind, T_s=T_S, wanted=10.0, **values)
