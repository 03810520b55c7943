"""Gears whose ratio varies over a turn: elliptical and other non-circular pairs.

Both flanges count from the housing, which takes ``tau_support = -tau_a - tau_b``; an open support
stands still. A pair in external mesh turns its flanges in opposite directions. Torques follow from
virtual work. The angle of flange b is a continuous function of that of flange a, over any number of
turns.

Source: Litvin, Fuentes-Aznar, Gonzalez-Perez and Hayasaka, Noncircular Gears, 2009, ch. 2 and 4.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, param, var
from lumped.components.seen_angle import seen_angle
from lumped.errors import EquationError
from lumped.language.expression import Number, Partial, as_expr
from lumped.ops import pi

__all__ = ["EllipticalGear", "NonCircularGear", "elliptical", "slowest_at"]

Transmission = Callable[[Expr], Number]


class EllipticalGear(Component):
    """Two equal ellipses in external mesh, each turning about a focus: ``phi_b = -psi(phi_a)``.

    With ``x = phi_a - phase``, the ratio ``-w_b / w_a = (1 - e^2) / (1 + e^2 - 2 e cos x)`` lies
    between ``(1 - e) / (1 + e)`` and its inverse, which it reaches at ``phi_a = phase``. Its
    integral is ``psi = x + 2 atan2(e sin x, 1 - e cos x)``, counted from ``phi_a = 0``; the
    second term is bounded. `slowest_at` gives the phase for which b is slowest at a wanted angle.
    """

    symbol = "ellipses"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    e: Param = param("1", "eccentricity of the ellipses", min=0, below=1)
    phase: Param = param("rad", "angle of flange a at which b is fastest", 0.0)
    phi: Var = var("rad", "angle of flange a relative to the support", state="avoid")

    def equations(self) -> Iterator[Equation]:
        yield from _meshing(self, -elliptical(self.phi, self.e, self.phase))


class NonCircularGear(Component):
    """Gear pair of a given transmission function: ``phi_b = transmission(phi_a)``.

    `transmission` takes the angle of flange a and returns that of flange b, both relative to the
    support, written with `lumped.ops`; for external mesh it falls. For example
    ``lambda x: -(x + 0.1 * lp.ops.sin(2 * x))``; `lumped.transmissions` makes one from points or
    from a wanted ratio. The ratio ``w_b / w_a`` is its derivative,
    ``tau_a = -(w_b / w_a) tau_b``.
    """

    symbol = "ellipses"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    transmission: Transmission | None = None
    phi: Var = var("rad", "angle of flange a relative to the support", state="avoid")

    def equations(self) -> Iterator[Equation]:
        if not callable(self.transmission):
            raise EquationError(
                f"transmission = {self.transmission!r}: a function of the angle of flange a is "
                "needed, for example transmission=lambda x: -(x + 0.1 * lp.ops.sin(2 * x))."
            )
        yield from _meshing(self, as_expr(self.transmission(self.phi)))


def _meshing(gear: EllipticalGear | NonCircularGear, driven: Expr) -> Iterator[Equation]:
    """Kinematics with the angle of b over that of a, and torques by virtual work."""
    a, b, housing = gear.flange_a, gear.flange_b, gear.support
    yield gear.phi == a.phi - housing.phi
    yield b.phi == housing.phi + driven
    yield a.tau == -Partial(driven, gear.phi) * b.tau  # type: ignore[arg-type]
    yield housing.tau == -a.tau - b.tau


def elliptical(phi: Number, e: Number, phase: Number) -> Expr:
    """Angle of the driven ellipse against the driving one's, zero together; in rad.

    Parameters
    ----------
    phi : expression
        Angle of the driving ellipse, rad.
    e : expression
        Eccentricity.
    phase : expression
        Angle of the driving ellipse at which the driven one is fastest, rad.

    Returns
    -------
    Expr
    """
    lead = seen_angle(as_expr(phi) - phase, e) + seen_angle(phase, e)
    return as_expr(phi) + 2 * lead


def slowest_at(phi_b: Number, e: Number) -> Expr:
    """Phase of an `EllipticalGear` whose flange b is slowest at the angle ``-phi_b``, rad.

    There flange a turns ``(1 + e) / (1 - e)`` times as fast as b.

    Parameters
    ----------
    phi_b : expression
        Angle of flange b, counted against its direction, rad.
    e : expression
        Eccentricity.

    Returns
    -------
    Expr
    """
    return pi + elliptical(phi_b, e, phi_b)
