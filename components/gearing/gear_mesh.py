"""Gear mesh whose stiffness varies with the angle, with transmission error.

Source: Oezguven and Houser, Mathematical models used in gear dynamics, J. Sound and Vibration 121
(1988) 383 (mesh stiffness and transmission error along the line of action); Oh, Grosh and Barber,
Energy conserving equations of motion for gear systems, J. Vibration and Acoustics 127 (2005),
doi 10.1115/1.1891815 (torques by virtual work).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.engines.engine import rows_of
from lumped.errors import EquationError
from lumped.language.expression import Datum, Number
from lumped.language.value_types import Rows
from lumped.ops import cos, pi, sin

__all__ = ["GearMesh"]


class GearMesh(Component):
    """Elastic mesh of two external gears: ``f = c(x) s + d der(s)``, ``x = z phi_a``.

    The deflection along the line of action is ``s = r_a phi_a + r_b phi_b - e(x)``, so the gears
    turn in opposite senses; angles count from the housing, `support`. Over the angle x of the mesh,
    which grows by 2 pi with each tooth::

        c(x) = c (1 + sum(share cos(k x + p)))
        e(x) = sum(amplitude cos(k x + p))

    `stiffness` are rows of k, share and p, rad; `error` are rows of k, amplitude, m, and p. Instead
    of `stiffness`, the contact ratio ``n + q`` of pairs of teeth that come and go at once, n or
    ``n + 1`` of equal stiffness, gives the shares ``2 sin(pi k q) / (pi k (n + q))`` of the first
    `harmonics`.

    The torques follow from virtual work, ``tau_a = f (r_a - z e') + z c' s^2 / 2`` and
    ``tau_b = f r_b``. Teeth never part.
    """

    symbol = "gear"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    stiffness: Rows = ()
    contact_ratio: float = 0.0
    harmonics: int = 8
    error: Rows = ()
    r_a: Param = param("m", "base radius of gear a", above=0)
    r_b: Param = param("m", "base radius of gear b", above=0)
    z: Param = param("1", "teeth of gear a", min=1)
    c: Param = param("N/m", "mean stiffness along the line of action", above=0)
    d: Param = param("N.s/m", "viscous damping along the line of action", 0.0, min=0)
    x: Var = var("rad", "angle of the mesh, 2 pi for each tooth", state="avoid")
    e: Var = var("m", "transmission error")
    s: Var = var("m", "deflection along the line of action", nominal=1e-5, state="prefer")
    v: Var = var("m/s", "rate of the deflection")
    f: Var = var("N", "force along the line of action")

    def rating(self) -> tuple[str, Expr]:
        return "1", self.r_b / self.r_a

    def equations(self) -> Iterator[Equation]:
        a, b, housing = self.flange_a, self.flange_b, self.support
        phi_a, phi_b = a.phi - housing.phi, b.phi - housing.phi
        x = self.z * phi_a
        e, e_slope = harmonic_sum(harmonic_rows("error", self.error), x)
        share, share_slope = self._share(x)
        yield self.x == x
        yield self.e == e
        yield self.s == self.r_a * phi_a + self.r_b * phi_b - self.e
        yield self.v == der(self.s)
        yield self.f == self.c * (1 + share) * self.s + self.d * self.v
        bend = self.z * self.c * share_slope * self.s**2 / 2
        yield a.tau == self.f * (self.r_a - self.z * e_slope) + bend
        yield b.tau == self.f * self.r_b
        yield housing.tau == -a.tau - b.tau

    def _share(self, x: Expr) -> tuple[Expr, Expr]:
        """What the stiffness varies by, relative to its mean, and its derivative by the angle."""
        ratio = self.contact_ratio
        if not ratio:
            return harmonic_sum(harmonic_rows("stiffness", self.stiffness), x)
        if self.stiffness:
            raise EquationError("stiffness and contact_ratio: give one of them.")
        if not 1 <= ratio < float("inf"):
            raise EquationError(f"contact_ratio = {ratio!r}: at least 1 is needed.")
        q = ratio - int(ratio)
        rows = [
            (float(k), 2 * sin(pi * k * q) / (pi * k * ratio), 0.0)
            for k in range(1, self.harmonics + 1)
        ]
        return harmonic_sum(rows, x)

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (1 + self._share(self.x)[0]) * self.s**2

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.v**2


def harmonic_rows(name: str, rows: Rows) -> list[tuple[float, Number, float]]:
    """Rows of harmonic, amplitude and phase; none without rows.

    Raises
    ------
    EquationError
        If they are no such rows.
    """
    if not rows:
        return []
    what = "harmonic, amplitude and phase (rad)"
    found = rows_of(name, rows, what, "((1, 0.2, 0.0), (2, 0.1, 0.0))", 3)
    return [(k, Datum(amplitude), p) for k, amplitude, p in found]


def harmonic_sum(rows: Iterable[tuple[float, Number, float]], x: Expr) -> tuple[Expr, Expr]:
    """Sum of harmonics, and its derivative by the angle."""
    total: Expr = Datum(0.0)
    slope: Expr = Datum(0.0)
    for k, amplitude, p in rows:
        total = total + amplitude * cos(k * x + p)
        slope = slope - k * amplitude * sin(k * x + p)
    return total, slope
