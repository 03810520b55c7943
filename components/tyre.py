"""Tyres that slip."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Flange,
    Input,
    LinearFlange,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.ops import atan, cos, minimum, pi, sin

__all__ = ["Tyre"]


class Tyre(Component):
    """Tyre rolling and slipping on a road: ``f = f_n mu sin(C atan(B q - E (B q - atan(B q))))``.

    The slip `k` follows the difference of the speeds of tread and road within the way `sigma`::

        sigma der(k) + V k = R w - v,   V = (|v| + |R w|) / 2
        q = k + h(V) (R w - v) / v_d,   h = (1 + cos(pi V / v_low)) / 2 below v_low, then 0

    So it rolls steadily with ``k = (R w - v) / V``: 2 for a wheel that spins on the spot, -2 for
    one that is locked. Where data count the slip s against the speed of the road alone,
    ``k = s / (1 + s/2)``. At standstill nothing is divided by zero: the tyre is a spring of the
    stiffness ``f_n mu B C / sigma`` that holds a vehicle, damped by ``f_n mu B C / v_d``. The wheel
    has no inertia here; join an `Inertia` to `wheel`, and the vehicle to `hub`.

    Source: Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, ch. 4.3 (magic formula), 7 and 8
    (relaxation length, damping at low speed).
    """

    symbol = "wheel"
    wheel = Flange()
    hub = LinearFlange()
    f_n = Input("N", "load of the wheel, not negative")
    R: Param = param("m", "rolling radius", above=0)
    mu: Param = param("1", "greatest force over load (peak factor D)", above=0)
    B: Param = param("1", "stiffness factor", 10.0, above=0)
    C: Param = param("1", "shape factor", 1.6, above=0, max=2)
    E: Param = param("1", "curvature factor", 0.0, max=1)
    sigma: Param = param("m", "relaxation length", 0.3, above=0)
    v_d: Param = param("m/s", "stiffness over damping at standstill", 40.0, above=0)
    v_low: Param = param("m/s", "speed from which there is no such damping", 2.5, above=0)
    k: Var = var("1", "slip", nominal=1e-2, state="always")
    w: Var = var("rad/s", "angular velocity of the wheel")
    v: Var = var("m/s", "velocity of the hub over the road")
    v_slip: Var = var("m/s", "speed of the tread against the road")
    f: Var = var("N", "driving force of the road on the tyre")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.wheel.phi)
        yield self.v == der(self.hub.s)
        yield self.v_slip == self.R * self.w - self.v
        V = (abs(self.v) + abs(self.R * self.w)) / 2
        yield self.sigma * der(self.k) + V * self.k == self.v_slip
        fading = (1 + cos(pi * minimum(V / self.v_low, 1.0))) / 2
        x = self.B * (self.k + fading * self.v_slip / self.v_d)
        yield self.f == self.f_n * self.mu * sin(self.C * atan(x - self.E * (x - atan(x))))
        yield self.wheel.tau == self.R * self.f
        yield self.hub.f == -self.f
