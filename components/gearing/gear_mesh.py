"""Gear mesh whose stiffness varies over the pitch, with transmission error and backlash.

Sources: Oezguven and Houser, Mathematical models used in gear dynamics, J. Sound and Vibration 121
(1988) 383 (mesh stiffness and transmission error along the line of action); Kahraman and Singh,
Non-linear dynamics of a spur gear pair, J. Sound and Vibration 142 (1990) 49 (backlash); Oh, Grosh
and Barber, Energy conserving equations of motion for gear systems, J. Vibration and Acoustics 127
(2005), doi 10.1115/1.1891815 (torques by virtual work).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.gearing.mesh_series import (
    mean_of_curve,
    of_contact,
    of_curve,
    of_rows,
    positive,
    summed,
)
from lumped.components.unilateral import across_play, force_across_play
from lumped.errors import EquationError, shown
from lumped.language.expression import Number
from lumped.language.value_types import Rows

if TYPE_CHECKING:
    from lumped.life.mesh_stiffness import MeshStiffness
    from lumped.numerics.harmonics import Harmonics

__all__ = ["GearMesh"]

FLANKS = ("drive flank", "back flank", "parted")


def _teeth(mesh: GearMesh) -> MeshStiffness | None:
    if mesh.teeth is not None and not hasattr(mesh.teeth, "shares"):
        raise EquationError(
            f"teeth = {shown(mesh.teeth)}: lumped.life.MeshStiffness(pair) of a GearPair is needed."
        )
    return mesh.teeth


def _of_teeth(read: Callable[[MeshStiffness], float], without: float | None = None) -> Any:
    """Default of a parameter that follows from the teeth."""

    def default(mesh: GearMesh) -> float | None:
        teeth = _teeth(mesh)
        return without if teeth is None else read(teeth)

    return default


def _mean_stiffness(mesh: GearMesh) -> float | None:
    """Default of the mean stiffness, N/m: that of the curve or of the teeth."""
    if len(mesh.stiffness_curve):
        return mean_of_curve("stiffness_curve", mesh.stiffness_curve)
    teeth = _teeth(mesh)
    return None if teeth is None else teeth.mean


class GearMesh(Component):
    """Elastic mesh of two gears: ``f = c(x) g + f_d``, ``x = z phi_a``, g the deflection of teeth.

    Along the line of action, ``s = r_a phi_a + r_b phi_b - e(x)`` between external gears, which
    turn in opposite senses; if gear b is `internal`, ``s = r_a phi_a - r_b phi_b - e(x)``. Angles
    count from the housing, `support`. With the backlash `b` along the line of action the drive
    flanks touch where ``s > b / 2``, ``g = s - b / 2``, and the back flanks where ``s < -b / 2``,
    ``g = s + b / 2``; between, the teeth are parted and there is no force. Without backlash (below
    1e-10 m) they never part, ``g = s``.

    Flanks push and never pull. Their damping is ``f_d = d der(s)``; if `limited`, it is never
    greater than the elastic part, so that the force begins at zero; else the force jumps where
    flanks meet.

    Over the angle x, which grows by 2 pi with each tooth (``k = 1 / z`` is once in a turn of a)::

        c(x) = c (1 + sum(share cos(k x + p)))
        e(x) = sum(amplitude cos(k x + p))

    `stiffness` are rows of k, share and p, rad; `error` are rows of k, amplitude, m, and p. Instead
    of `stiffness`, `stiffness_curve` are rows of the position, ``x / (2 pi)``, and the stiffness,
    N/m, joined by straight lines over one pitch, of which the mean is the default of `c`; or
    `contact_ratio` and `overlap_ratio` give the length of the lines of contact, to which the
    stiffness is proportional: without overlap, n or ``n + 1`` pairs of teeth at once. Instead of
    `error`, `error_curve` are rows of the position and the error, m, such as that of a profile
    relief, of which the mean does not count. Curves and contact ratios are taken by their first
    `harmonics`; with none of them the stiffness is its mean.

    With `teeth`, a `lumped.life.MeshStiffness`, gear a is the pinion: radii, stiffness and backlash
    follow from the geometry of the pair, and b is internal if its wheel is.

    `dte` is the dynamic transmission error, ``s + e``. The torques follow from virtual work,
    ``tau_a = f (r_a - z e') + z c' g^2 / 2`` and ``tau_b = f r_b``, ``-f r_b`` if internal.
    """

    symbol = "gear"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    teeth: MeshStiffness | None = None
    internal: bool = False
    stiffness: Rows = ()
    stiffness_curve: Rows = ()
    contact_ratio: float = 0.0
    overlap_ratio: float = 0.0
    error: Rows = ()
    error_curve: Rows = ()
    harmonics: int = 8
    limited: bool = True
    r_a: Param = param(
        "m", "base radius of gear a", _of_teeth(lambda t: t.pair.base_diameters[0] / 2), above=0
    )
    r_b: Param = param(
        "m",
        "base radius of gear b",
        _of_teeth(lambda t: abs(t.pair.base_diameters[1]) / 2),
        above=0,
    )
    z: Param = param("1", "teeth of gear a", _of_teeth(lambda t: t.pair.teeth[0]), min=1)
    c: Param = param("N/m", "mean stiffness along the line of action", _mean_stiffness, above=0)
    d: Param = param("N.s/m", "viscous damping along the line of action", 0.0, min=0)
    b: Param = param(
        "m",
        "whole backlash along the line of action",
        _of_teeth(lambda t: max(t.pair.backlash, 0.0), 0.0),
        min=0,
    )
    x: Var = var("rad", "angle of the mesh, 2 pi for each tooth", state="avoid")
    e: Var = var("m", "transmission error of the unloaded teeth")
    s: Var = var("m", "deflection along the line of action", nominal=1e-5, state="prefer")
    dte: Var = var("m", "dynamic transmission error", state="avoid")
    g: Var = var("m", "deflection beyond the backlash")
    v: Var = var("m/s", "rate of the deflection")
    f: Var = var("N", "force along the line of action, positive on the drive flank")

    def rating(self) -> tuple[str, Expr]:
        return "1", self.r_b / self.r_a

    def equations(self) -> Iterator[Equation]:
        a, b, housing = self.flange_a, self.flange_b, self.support
        phi_a, phi_b = a.phi - housing.phi, b.phi - housing.phi
        internal = self.internal or (self.teeth is not None and self.teeth.pair.internal)
        r_b = -self.r_b if internal else self.r_b
        if not isinstance(self.harmonics, int) or self.harmonics < 0:
            raise EquationError(
                f"harmonics = {shown(self.harmonics)}: a whole number, not negative, is needed."
            )
        x = self.z * phi_a
        e, e_slope = summed(self._error(), x)
        c, c_slope = self._stiffness(x), self.c * summed(self._shares(), x)[1]
        yield self.x == x
        yield self.e == e
        yield self.s == self.r_a * phi_a + r_b * phi_b - self.e
        yield self.dte == self.s + self.e
        yield self.v == der(self.s)
        flanks = self.s - self.b / 2, self.s + self.b / 2
        yield self.g == across_play(self.s, self.b, flanks, self.s, FLANKS)
        yield self.f == force_across_play(
            self.s, self.b, c, self.d * self.v, self.d, FLANKS, limited=self.limited
        )
        bend = self.z * c_slope * self.g**2 / 2
        yield a.tau == self.f * (self.r_a - self.z * e_slope) + bend
        yield b.tau == self.f * r_b
        yield housing.tau == -a.tau - b.tau

    def static_error(self, f: Number) -> Expr:
        """Static transmission error under a constant force of the drive flank, over `x`, m.

        ``b / 2 + f / c(x) + e(x)``; a run or a periodic motion gives it like a quantity,
        ``run[model.mesh.static_error(2000.0)]``.
        """
        return self.b / 2 + f / self._stiffness(self.x) + summed(self._error(), self.x)[0]

    def _stiffness(self, x: Expr) -> Expr:
        return self.c * (1 + summed(self._shares(), x)[0])

    def _shares(self) -> Harmonics:
        """What the stiffness varies by, relative to its mean."""
        rows, curve, ratio = self.stiffness, self.stiffness_curve, self.contact_ratio
        if self.overlap_ratio and not ratio:
            raise EquationError(
                f"overlap_ratio = {shown(self.overlap_ratio)}: contact_ratio is needed beside it."
            )
        if sum((len(rows) > 0, len(curve) > 0, ratio != 0, self.teeth is not None)) > 1:
            raise EquationError(
                "stiffness, stiffness_curve, contact_ratio and teeth: give one of them at most."
            )
        if len(rows):
            return positive(of_rows("stiffness", rows))
        if len(curve):
            mean = mean_of_curve("stiffness_curve", curve)
            found = of_curve("stiffness_curve", curve, self.harmonics)
            return positive([(k, amplitude / mean, p) for k, amplitude, p in found])
        if ratio:
            return positive(of_contact(ratio, self.overlap_ratio, self.harmonics))
        return [] if self.teeth is None else positive(self.teeth.shares(self.harmonics))

    def _error(self) -> Harmonics:
        """Transmission error of the unloaded teeth."""
        if len(self.error) and len(self.error_curve):
            raise EquationError("error and error_curve: give one of them at most.")
        if len(self.error_curve):
            return of_curve("error_curve", self.error_curve, self.harmonics)
        return of_rows("error", self.error)

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self._stiffness(self.x) * self.g**2

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return (self.f - self._stiffness(self.x) * self.g) * self.v
