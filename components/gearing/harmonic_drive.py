"""Harmonic drive: wave generator, flexspline and circular spline.

Sources: Tuttle and Seering, A nonlinear model of a harmonic drive gear transmission, IEEE
Transactions on Robotics and Automation 12 (1996) 368 (kinematic error); catalogues of Harmonic
Drive SE (three stiffnesses K1, K2, K3 with the limit torques T1, T2).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, param, var
from lumped.components.cams import harmonic_sum
from lumped.language.expression import Partial
from lumped.language.value_types import Rows
from lumped.ops import maximum, minimum

__all__ = ["HarmonicDrive"]


class HarmonicDrive(Component):
    """Elastic harmonic drive: ``(ratio + 1) w_circular = w_wave + ratio w_flex`` without twist.

    With ``x = phi_wave - phi_circular``, the flexspline would stand at ``-x / ratio + e(x)``,
    where ``e(x) = sum(A sin(order x + phase))`` is the kinematic error. It is `phi_rel` ahead and
    gives way with the torque `tau` at it::

        tau = K1 phi_rel up to T1, then the slope K2 up to T2, then K3, both ways alike

    The torque of the wave generator follows by virtual work, ``tau_wave = (1 / ratio - e') tau``,
    and the circular spline takes the rest. Hold the circular spline and the flexspline is the
    output, which turns backwards; hold the flexspline and the circular spline turns with the wave
    generator, ``ratio + 1`` times slower.
    """

    symbol = "harmonic_drive"
    wave_generator = Flange()
    flexspline = Flange()
    circular_spline = Flange(grounded=True)
    errors: Rows = ()
    ratio: Param = param("1", "teeth of the flexspline over the difference of teeth", above=0)
    K1: Param = param("N.m/rad", "stiffness at the flexspline up to T1", above=0)
    K2: Param = param("N.m/rad", "stiffness between T1 and T2", above=0)
    K3: Param = param("N.m/rad", "stiffness above T2", above=0)
    T1: Param = param("N.m", "torque at which K2 begins", above=0)
    T2: Param = param("N.m", "torque at which K3 begins", above=T1)
    phi: Var = var("rad", "angle of the wave generator from the circular spline", state="avoid")
    phi_rel: Var = var("rad", "twist at the flexspline", nominal=1e-4, state="prefer")
    tau: Var = var("N.m", "torque on the flexspline")

    def equations(self) -> Iterator[Equation]:
        wave, flex, circular = self.wave_generator, self.flexspline, self.circular_spline
        place = -self.phi / self.ratio
        if self.errors:
            place = place + harmonic_sum(
                "errors", self.errors, self.phi, "rad", "((2, 1e-4, 0.0),)"
            )
        yield self.phi == wave.phi - circular.phi
        yield self.phi_rel == flex.phi - circular.phi - place
        first, second = self._beyond()
        yield self.tau == (
            self.K1 * self.phi_rel + (self.K2 - self.K1) * first + (self.K3 - self.K2) * second
        )
        yield flex.tau == self.tau
        yield wave.tau == -Partial(place, self.phi) * self.tau  # type: ignore[arg-type]
        yield circular.tau == -wave.tau - flex.tau

    def stored(self) -> Expr:
        """Elastic energy, J."""
        first, second = self._beyond()
        return 0.5 * (
            self.K1 * self.phi_rel**2
            + (self.K2 - self.K1) * first**2
            + (self.K3 - self.K2) * second**2
        )

    def _beyond(self) -> Iterator[Expr]:
        """Twist beyond that at T1 and at T2, in its direction."""
        at_first = self.T1 / self.K1
        for limit in (at_first, at_first + (self.T2 - self.T1) / self.K2):
            yield self.phi_rel - minimum(maximum(self.phi_rel, -limit), limit)
