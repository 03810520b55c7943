"""A vehicle on a road, as the load of a drive train."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Input, LinearFlange, Param, Var, der, param, var
from lumped.components.loads.speed_torques import saturate
from lumped.ops import atan, cos, sin, smooth

__all__ = ["Vehicle"]


class Vehicle(Component):
    """Vehicle in straight motion: ``(m + J/R^2) a = tau/R + f - f_drag - f_roll - f_grade``.

    Air drag ``rho/2 cd A u |u|`` of the wind relative to the vehicle, ``u = v - v_wind``; rolling
    resistance ``cr m g cos(atan(inclination))``, against the motion and proportional to the
    velocity below `v_reg`; grade ``m g sin(atan(inclination))`` (Mitschke and Wallentowitz,
    Dynamik der Kraftfahrzeuge, ch. 2). Wheels roll without slip. The wheel shaft is driven at
    `wheel`, a trailer is coupled at `coupling`; either may stay open.
    """

    symbol = "vehicle"
    wheel = Flange(free=True)
    coupling = LinearFlange(free=True)
    m: Param = param("kg", "mass of the whole vehicle", above=0)
    J: Param = param("kg.m2", "moment of inertia of what turns with the wheels", 0.0, min=0)
    R: Param = param("m", "rolling radius of the wheels", above=0)
    A: Param = param("m2", "frontal area", min=0)
    cd: Param = param("1", "drag coefficient", min=0)
    rho: Param = param("kg/m3", "density of the air", 1.2, min=0)
    v_reg: Param = param("m/s", "velocity below which rolling resistance falls", 1e-3, above=0)
    g: Param = param("m/s2", "acceleration of gravity", 9.80665, min=0)
    cr: Input = Input("1", "rolling resistance coefficient, not negative", min=0)
    inclination: Input = Input("1", "tangent of the angle of the road, positive uphill")
    v_wind: Input = Input("m/s", "velocity of the wind, positive from behind")
    s: Var = var("m", "position")
    v: Var = var("m/s", "velocity")
    f_drag: Var = var("N", "air drag")
    f_roll: Var = var("N", "rolling resistance")
    f_grade: Var = var("N", "downhill force")

    def equations(self) -> Iterator[Equation]:
        yield self.coupling.s == self.s
        yield self.R * self.wheel.phi == self.s
        yield self.v == der(self.s)
        u, slope = self.v - self.v_wind, atan(self.inclination)
        weight = self.m * self.g
        yield self.f_drag == self.rho / 2 * self.cd * self.A * smooth(u * abs(u))
        yield self.f_roll == self.cr * weight * cos(slope) * saturate(self.v, self.v_reg)
        yield self.f_grade == weight * sin(slope)
        resistance = self.f_drag + self.f_roll + self.f_grade
        driving = self.wheel.tau / self.R + self.coupling.f
        yield (self.m + self.J / self.R**2) * der(self.v) == driving - resistance
