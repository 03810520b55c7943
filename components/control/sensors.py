"""Ideal sensors of rotation: they measure and do nothing else.

Angles and speeds are measured beside the power path, without torque; torque and power are measured
in it, by a rigid shaft without inertia. Each gives one output signal. Every quantity can also be
read by its name after a run; sensors are for signals that a controller needs.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Output, der, lossless

__all__ = [
    "AccelerationSensor",
    "AngleSensor",
    "PowerSensor",
    "RelativeAngleSensor",
    "RelativeSpeedSensor",
    "SpeedSensor",
    "TorqueSensor",
]


class AngleSensor(Component):
    """Ideal sensor of an angle: ``phi = phi_flange``; takes no torque."""

    symbol = "sensor"
    flange = Flange()
    phi = Output("rad", "angle")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.tau == 0
        yield self.phi == self.flange.phi


class SpeedSensor(Component):
    """Ideal sensor of an angular velocity: ``w = der(phi_flange)``; takes no torque."""

    symbol = "sensor"
    flange = Flange()
    w = Output("rad/s", "angular velocity")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.tau == 0
        yield self.w == der(self.flange.phi)


class AccelerationSensor(Component):
    """Ideal sensor of an angular acceleration: ``a = der(der(phi_flange))``; takes no torque."""

    symbol = "sensor"
    flange = Flange()
    a = Output("rad/s2", "angular acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.tau == 0
        yield self.a == der(der(self.flange.phi))


class RelativeAngleSensor(Component):
    """Ideal sensor of a twist: ``phi_rel = phi_b - phi_a``; takes no torque."""

    symbol = "sensor"
    flange_a = Flange()
    flange_b = Flange()
    phi_rel = Output("rad", "relative angle")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.tau == 0
        yield self.flange_b.tau == 0
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi


class RelativeSpeedSensor(Component):
    """Ideal sensor of a relative angular velocity: ``w_rel = der(phi_b - phi_a)``; no torque."""

    symbol = "sensor"
    flange_a = Flange()
    flange_b = Flange()
    w_rel = Output("rad/s", "relative angular velocity")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.tau == 0
        yield self.flange_b.tau == 0
        yield self.w_rel == der(self.flange_b.phi - self.flange_a.phi)


class TorqueSensor(Component):
    """Ideal sensor in a rigid shaft: ``tau = tau_a``, the torque flowing from a to b."""

    symbol = "sensor"
    flange_a = Flange()
    flange_b = Flange()
    tau = Output("N.m", "torque from a to b")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.phi == a.phi, a, b)
        yield self.tau == a.tau


class PowerSensor(Component):
    """Ideal sensor in a rigid shaft: ``power = tau_a der(phi_a)``, power flowing from a to b."""

    symbol = "sensor"
    flange_a = Flange()
    flange_b = Flange()
    power = Output("W", "power from a to b")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.phi == a.phi, a, b)
        yield self.power == a.tau * der(a.phi)
