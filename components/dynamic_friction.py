"""Friction with an inner state: bristles that bend before they slide.

Torque is continuous through standstill, so nothing sticks exactly: a shaft under a constant torque
creeps. For exact standstill take the elements of `lumped.components.friction`.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Expr, Param, Var, der, param, var
from lumped.components.characteristic import Characteristic, friction_at, refuse_zero
from lumped.components.hysteresis import _Twisted
from lumped.language.switch import Item
from lumped.ops import maximum, sign, smooth

__all__ = ["BoucWen", "Dahl", "LuGre"]


_LEAST = 1e-12
"""Share of the twist of yield below which the yielding part counts as it."""


class _Bristles(_Twisted):
    """Bristles of the stiffness c, bent by phi."""

    symbol = "bearing"
    c: Param = param("N.m/rad", "stiffness before sliding", above=0)
    phi: Var = var("rad", "bend of the bristles", nominal=1e-4, state="always")
    w_phi: Var = var("rad/s", "speed at which they bend")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.w_phi == der(self.phi)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau * self.w_rel - self.c * self.phi * self.w_phi

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return self.c * self.phi**2 / 2


class Dahl(_Bristles):
    """Dahl's friction: ``tau = c phi``, ``der(phi) = w_rel - abs(w_rel) tau / tau_c``.

    From ``tau = 0`` and in one direction ``tau = tau_c (1 - exp(-c phi_rel / tau_c))``; after a
    turn the torque comes to `tau_c` on the other side in the same way. The loop does not depend on
    the speed.

    Source: P. R. Dahl, AIAA J. 14 (1976) 1675, with the exponent 1.
    """

    tau_c: Param = param("N.m", "friction torque while it slides", above=0)

    def rating(self) -> tuple[str, Expr]:
        return "N.m", self.tau_c

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.tau == self.c * self.phi
        yield self.w_phi == self.w_rel - abs(self.w_rel) * self.tau / self.tau_c


class LuGre(_Bristles):
    """LuGre friction: ``tau = c phi + d w_phi + d_viscous w_rel``, ``w_phi = der(phi)``.

    ``w_phi = w_rel - c abs(w_rel) phi / g(abs(w_rel))``. `characteristic` gives g, the friction
    torque in N.m over the sliding speed in rad/s without the viscous part, greater than zero: rows
    of both, or a function such as `lumped.components.Stribeck`. In steady motion
    ``tau = g(w_rel) + d_viscous w_rel``; near standstill it is a spring c with a damper d.

    With Coulomb friction, one value of g, the element never gives energy. With values from
    `coulomb` up to `static` it can while it begins to slide fast, unless
    ``d_viscous >= d (static / coulomb - 1)``.

    Sources: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Automatic Control 40 (1995)
    419; Barabanov and Ortega, IEEE Trans. Automatic Control 45 (2000) 830, on passivity.
    """

    characteristic: Characteristic = ()
    d: Param = param("N.m.s/rad", "damping of the bristles", 0.0, min=0)
    d_viscous: Param = param("N.m.s/rad", "viscous damping", 0.0, min=0)

    def rating(self) -> tuple[str, Expr]:
        return "N.m", friction_at(self.characteristic, 0.0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        refuse_zero(self.characteristic)
        speed = abs(self.w_rel)
        yield self.tau == self.c * self.phi + self.d * self.w_phi + self.d_viscous * self.w_rel
        sliding = self.c * speed * self.phi / friction_at(self.characteristic, speed)
        yield self.w_phi == self.w_rel - sliding


class BoucWen(_Twisted):
    """Bouc-Wen hysteresis: ``tau = alpha c phi_rel + (1 - alpha) c z``.

    ``der(z) = w_rel - abs(z / phi_y)**n (beta abs(w_rel) sign(z) + (1 - beta) w_rel)``. The
    stiffness is c at first and ``alpha c`` beyond the twist of yield `phi_y`, at which z ends; with
    n the knee becomes sharper. In the usual names ``A = 1``, and beta and ``1 - beta`` are
    ``beta phi_y**n`` and ``gamma phi_y**n``. Below ``beta = 0.5`` it would give energy.

    Sources: Y. K. Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249; Ismail, Ikhouane and Rodellar, Arch.
    Comput. Methods Eng. 16 (2009) 161, on its parameters.
    """

    symbol = "spring"
    c: Param = param("N.m/rad", "stiffness at first", above=0)
    alpha: Param = param("1", "stiffness after yield over that at first", 0.0, min=0, below=1)
    phi_y: Param = param("rad", "twist of yield", above=0)
    beta: Param = param("1", "shape: 1/2 turns back in a straight line", 0.5, min=0.5)
    n: Param = param("1", "sharpness of the knee", 1.0, min=1)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    z: Var = var("rad", "twist of the part that yields", nominal=1e-4, state="always")
    w_z: Var = var("rad/s", "its speed")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.tau == self.c * (self.alpha * self.phi_rel + (1 - self.alpha) * self.z)
        shape = self.beta * abs(self.w_rel) * sign(self.z) + (1 - self.beta) * self.w_rel
        share = smooth(maximum(abs(self.z / self.phi_y), _LEAST))  # a power of 0 has no slope by n
        yield self.w_z == self.w_rel - share**self.n * shape
        yield self.w_z == der(self.z)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return (1 - self.alpha) * self.c * self.z * (self.w_rel - self.w_z)

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return self.c * (self.alpha * self.phi_rel**2 + (1 - self.alpha) * self.z**2) / 2
