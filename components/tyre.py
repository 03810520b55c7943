"""Tyres that slip."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Input, LinearFlange, Param, Var, der, param, var
from lumped.language.expression import Datum
from lumped.ops import atan, exp, sin, sqrt

__all__ = ["Tyre"]

_STILL = Datum(1e-15)
"""Speed in m/s, and slip, that avoid a division by zero."""


class Tyre(Component):
    """Tyre rolling and slipping on a road: ``f = f_n mu m(k)`` where it rolls steadily.

    ``m(k) = sin(C atan(B k - E (B k - atan(B k))))`` with the slip ``k = (R w - v) / V``,
    ``V = (|v| + |R w|) / 2``: 2 for a wheel that spins on the spot, -2 for one that is locked. For
    data over the slip s relative to the speed of the road alone, ``k = s / (1 + s/2)``.

    The tread follows as a spring between rim and road, with the deflection ``sigma z``::

        sigma der(z) = (R w - v) - V z B C k / m(k)
        f = f_n mu B C (z + T_d exp(-(V / v_low)^2) der(z))

    So the force builds up over the distance `sigma` for small slip, over a shorter one for large
    slip, and is bounded by that of the formula. At standstill nothing is divided by zero: the tyre
    is a spring of the stiffness ``f_n mu B C / sigma`` that holds a vehicle, with a damper that
    fades from the speed `v_low` on. The wheel has no inertia here; join an `Inertia` to `wheel`,
    and the vehicle to `hub`.

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, ch. 4.3 (magic formula) and 7.2
    (relaxation); Canudas de Wit, Tsiotras, Velenis, Basset and Gissinger, Vehicle System Dynamics
    39 (2003) 189 (the same as friction with a state, about standstill).
    """

    symbol = "wheel"
    wheel = Flange()
    hub = LinearFlange()
    f_n: Input = Input("N", "load of the wheel, not negative", min=0)
    R: Param = param("m", "rolling radius", above=0)
    mu: Param = param("1", "greatest force over load (peak factor D)", above=0)
    B: Param = param("1", "stiffness factor", 10.0, above=0)
    C: Param = param("1", "shape factor", 1.6, above=0, below=2)
    E: Param = param("1", "curvature factor", 0.0, max=1)
    sigma: Param = param("m", "relaxation length", 0.3, above=0)
    T_d: Param = param("s", "damping over stiffness of the tread at standstill", 0.005, min=0)
    v_low: Param = param("m/s", "speed at which this damping fades", 2.5, above=0)
    e: Var = var("m", "deflection of the tread", nominal=3e-3, state="always")
    z: Var = var("1", "deflection of the tread over sigma", nominal=1e-2)
    w: Var = var("rad/s", "angular velocity of the wheel")
    v: Var = var("m/s", "velocity of the hub over the road")
    k: Var = var("1", "slip")
    f: Var = var("N", "driving force of the road on the tyre")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.wheel.phi)
        yield self.v == der(self.hub.s)
        V = (abs(self.v) + abs(self.R * self.w)) / 2
        v_slip = self.R * self.w - self.v
        yield self.k == v_slip / (V + _STILL)
        k = sqrt(self.k**2 + _STILL**2)
        x = self.B * k
        magic = sin(self.C * atan(x - self.E * (x - atan(x))))
        steep = self.B * self.C
        yield self.e == self.sigma * self.z
        yield der(self.e) == v_slip - V * self.z * steep * k / magic
        damping = self.T_d * exp(-((V / self.v_low) ** 2))
        yield self.f == self.f_n * self.mu * steep * (self.z + damping * der(self.z))
        yield self.wheel.tau == self.R * self.f
        yield self.hub.f == -self.f
