"""Direct-current motors with permanent magnets, series field or separate field.

A positive current into the pin `p` drives forward. The quasi-static motors leave the inductances
out and save the fast states of the currents.

Source: Fischer, Elektrische Maschinen, 17th ed., ch. 2.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Equation, Expr, Param, Pin, Var, der, param, var
from lumped.components.electric.motors import _Machine

__all__ = [
    "DCMotor",
    "QuasiStaticDCMotor",
    "QuasiStaticExcitedDCMotor",
    "QuasiStaticSeriesDCMotor",
    "SeparatelyExcitedDCMotor",
    "SeriesDCMotor",
]


class _DirectCurrent(_Machine):
    """Armature between the pins."""

    p = Pin()
    n = Pin()
    i: Var = var("A", "armature current", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.p.i == self.i
        yield self.n.i == -self.i

    @property
    def _voltage(self) -> Expr:
        return self.p.v - self.n.v


class DCMotor(_DirectCurrent):
    """Direct-current motor with permanent magnets: ``v = R i + L der(i) + k w``, ``tau = k i``.

    `k` is the torque constant. From rated voltage, current and speed ``k = (V - R I) / w``.
    """

    k: Param = param("N.m/A", "torque over current, voltage over speed", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", min=0)
    L: Param = param("H", "inductance of the armature; for none, take QuasiStaticDCMotor", above=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self._voltage == self.R * self.i + self.L * der(self.i) + self.k * self._speed
        yield self.tau == self.k * self.i

    def loss(self) -> Expr:
        """Heat in the armature, W."""
        return self.R * self.i**2


class QuasiStaticDCMotor(_DirectCurrent):
    """Direct-current motor whose current follows at once: ``v = R i + k w``, ``tau = k i``.

    For drives much slower than ``L / R``, where it saves a fast state.
    """

    k: Param = param("N.m/A", "torque over current, voltage over speed", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", above=0)
    i: Var = var("A", "armature current", state="avoid")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self._voltage == self.R * self.i + self.k * self._speed
        yield self.tau == self.k * self.i

    def loss(self) -> Expr:
        """Heat in the armature, W."""
        return self.R * self.i**2


class SeriesDCMotor(_DirectCurrent):
    """Motor with its field in series: ``v = R i + L der(i) + k i w``, ``tau = k i^2``.

    From rated voltage, current and speed ``k = (V - R I) / (I w)``. Without load it runs away.
    """

    k: Param = param("N.m/A2", "torque over current squared", above=0)
    R: Param = param("Ohm", "resistance of armature and field", min=0)
    L: Param = param("H", "inductance of armature and field", above=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        induced = self.k * self.i * self._speed
        yield self._voltage == self.R * self.i + self.L * der(self.i) + induced
        yield self.tau == self.k * self.i**2

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2


class SeparatelyExcitedDCMotor(_DirectCurrent):
    """Motor with a field of its own: ``v = R i + L der(i) + k i_f w``, ``tau = k i_f i``.

    The field between the pins `field_p` and `field_n`: ``v_f = R_f i_f + L_f der(i_f)``. With the
    field on the pins of the armature it is a shunt motor; a weaker field gives higher speeds.
    """

    field_p = Pin()
    field_n = Pin()
    k: Param = param("N.m/A2", "torque over the product of the currents", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", min=0)
    L: Param = param("H", "inductance of the armature", above=0)
    R_f: Param = param("Ohm", "resistance of the field", min=0)
    L_f: Param = param("H", "inductance of the field", above=0)
    i_f: Var = var("A", "field current", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        flux = self.k * self.i_f
        yield self._voltage == self.R * self.i + self.L * der(self.i) + flux * self._speed
        yield self.tau == flux * self.i
        yield self.field_p.i == self.i_f
        yield self.field_n.i == -self.i_f
        v_f = self.field_p.v - self.field_n.v
        yield v_f == self.R_f * self.i_f + self.L_f * der(self.i_f)

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2 + self.R_f * self.i_f**2


class QuasiStaticSeriesDCMotor(_DirectCurrent):
    """Motor with its field in series whose current follows at once: ``v = (R + k w) i``.

    ``tau = k i^2``, as in `SeriesDCMotor`. Driven backward at ``w = -R / k`` it excites itself:
    the current has no finite value, and a run that reaches this speed ends with an error.
    """

    k: Param = param("N.m/A2", "torque over current squared", above=0)
    R: Param = param("Ohm", "resistance of armature and field", above=0)
    i: Var = var("A", "armature current", state="avoid")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self._voltage == (self.R + self.k * self._speed) * self.i
        yield self.tau == self.k * self.i**2

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2


class QuasiStaticExcitedDCMotor(_DirectCurrent):
    """Motor with a field of its own whose currents follow at once: ``v = R i + k i_f w``.

    ``v_f = R_f i_f`` and ``tau = k i_f i``, as in `SeparatelyExcitedDCMotor`. For drives much
    slower than the time constants of armature and field.
    """

    field_p = Pin()
    field_n = Pin()
    k: Param = param("N.m/A2", "torque over the product of the currents", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", above=0)
    R_f: Param = param("Ohm", "resistance of the field", above=0)
    i: Var = var("A", "armature current", state="avoid")
    i_f: Var = var("A", "field current", state="avoid")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        flux = self.k * self.i_f
        yield self._voltage == self.R * self.i + flux * self._speed
        yield self.tau == flux * self.i
        yield self.field_p.i == self.i_f
        yield self.field_n.i == -self.i_f
        yield self.field_p.v - self.field_n.v == self.R_f * self.i_f

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2 + self.R_f * self.i_f**2
