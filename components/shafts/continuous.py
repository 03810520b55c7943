"""Piece of a shaft as a bar with distributed inertia, exact in responses to a vibration."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Equation, Expr, Output, Param, Var, der, param, var
from lumped.components.shafts.element import ShaftElement
from lumped.language.validity import Range
from lumped.ops import atan, cos, cosh, pi, sin, sinh, sqrt

__all__ = ["ContinuousElement", "bars_needed"]

_MOST = 3.0
"""Phase of a wave between the flanges up to which the law is used, rad; it has a pole at pi."""


def bars_needed(transit: float, f_max: float) -> int:
    """Number of equal bars that a uniform bar is cut into, so that its law holds up to `f_max`.

    Parameters
    ----------
    transit : float
        Time a wave takes from end to end, s.
    f_max : float
        Highest frequency of interest, Hz.

    Returns
    -------
    int
        At least one.
    """
    return max(1, -int(-2 * pi * f_max * transit / _MOST // 1))


class ContinuousElement(ShaftElement):
    """Uniform bar with distributed inertia, in responses to a vibration of the frequency w exact.

    There ``tau = c x / sin(x) [[cos(x), -1], [-1, cos(x)]] phi`` for torques and angles of the
    flanges; ``x = w sqrt((J_a + J_b) / c)`` is the phase of a wave from end to end. A spring
    ``c x / sin(x)`` with the inertias ``J_a tan(x/2) / (x/2)`` and ``J_b tan(x/2) / (x/2)`` at the
    flanges has the same torques, and is what is computed. With a loss factor `c` is everywhere
    ``c (1 + j eta)``. An element with unequal J_a and J_b, a piece of a cone, is no uniform bar:
    rows of them converge.

    Runs and operating points have ``w = 0``: a spring with J_a and J_b at the ends, and a damper
    that loses as much at `w_loss` as `eta` says. Responses to a vibration put its own frequency in
    the place of both. The law is used up to x = 3, below the first natural frequency of the bar
    between clamped ends (x = pi), where it has a pole: a longer bar is cut, which changes nothing
    else.

    `tau` and `stress` are those in the middle, `stress_a` and `stress_b` those at the flanges.

    Source: solution of the wave equation (Clough and Penzien, Dynamics of Structures, ch. 17); loss
    factor as in `LossSpring`.
    """

    stress_a = Output("Pa", "nominal shear stress at flange a")
    stress_b = Output("Pa", "nominal shear stress at flange b")
    eta: Param = param("1", "loss factor", 0.0, min=0)
    w: Param = param(
        "rad/s", "angular frequency of vibration for the inertia", 0.0, min=0, vibrates=True
    )
    w_loss: Param = param(
        "rad/s", "angular frequency of vibration to which eta applies", 1.0, above=0, vibrates=True
    )
    w_rel: Var = var("rad/s", "relative angular velocity")

    def equations(self) -> Iterator[Equation]:
        a, b = self.flange_a, self.flange_b
        x, fading = self._phase()
        heavy, resisting = _tangent(x, fading)
        yield self.phi_rel == b.phi - a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.w_a == der(a.phi)
        yield self.w_b == der(b.phi)
        yield self.tau == self._torque(x / 2, fading / 2)
        between = self._torque(x, fading)
        # the loss of an inertia J (heavy + j resisting) is a damper to the ground
        for J, flange, speed, sign in (
            (self.J_a, a, self.w_a, -1),
            (self.J_b, b, self.w_b, 1),
        ):
            yield flange.tau == (
                J * heavy * der(speed) - J * resisting * self.w * speed + sign * between
            )
        yield self.stress == self.tau / self.W
        yield self.stress_a == -a.tau / self.W
        yield self.stress_b == b.tau / self.W

    def loss(self) -> Expr:
        """Dissipated power, W."""
        x, fading = self._phase()
        _, damper = self._stiffness(x, fading)
        _, resisting = _tangent(x, fading)
        slow = self.J_a * self.w_a**2 + self.J_b * self.w_b**2
        return damper * self.w_rel**2 - resisting * self.w * slow

    def stored(self) -> Expr:
        """Elastic and kinetic energy, J."""
        x, fading = self._phase()
        stiff, _ = self._stiffness(x, fading)
        heavy, _ = _tangent(x, fading)
        moving = self.J_a * self.w_a**2 + self.J_b * self.w_b**2
        return 0.5 * (heavy * moving + stiff * self.phi_rel**2)

    def valid(self) -> Iterator[Range]:
        """Frequencies below that of the bar between clamped ends."""
        advice = "Cut the section into more elements by f_max= of the shaft, or by n_elements="
        phase = self.w * sqrt((self.J_a + self.J_b) / self.c)
        yield Range(phase, 0.0, _MOST, "rad", "phase of a wave from end to end", advice)

    def _phase(self) -> tuple[Expr, Expr]:
        """Real and imaginary part of ``x / sqrt(1 + j eta)``; not quite zero without vibration."""
        x = sqrt(self.w**2 * (self.J_a + self.J_b) / self.c + _NOTHING)
        size, turn = (1 + self.eta**2) ** 0.25, atan(self.eta) / 2
        return x * cos(turn) / size, -x * sin(turn) / size

    def _stiffness(self, x: Expr, fading: Expr) -> tuple[Expr, Expr]:
        """Stiffness and damping of ``c (1 + j eta) z / sin(z)``, N.m/rad and N.m.s/rad."""
        real, imaginary = _over_sine(x, fading)
        damping = (imaginary + self.eta * real) / self.w_loss
        return self.c * (real - self.eta * imaginary), self.c * damping

    def _torque(self, x: Expr, fading: Expr) -> Expr:
        stiff, damper = self._stiffness(x, fading)
        return stiff * self.phi_rel + damper * self.w_rel


_NOTHING = 1e-30
"""Square of a phase, rad2, beside which every other one is large: ``x / sin(x)`` is 1 there."""


def _over_sine(x: Expr, y: Expr) -> tuple[Expr, Expr]:
    """Real and imaginary part of ``z / sin(z)``, ``z = x + j y``."""
    real, imaginary = sin(x) * cosh(y), cos(x) * sinh(y)
    size = real**2 + imaginary**2
    return (x * real + y * imaginary) / size, (y * real - x * imaginary) / size


def _tangent(x: Expr, y: Expr) -> tuple[Expr, Expr]:
    """Real and imaginary part of ``tan(z / 2) / (z / 2)``, ``z = x + j y``."""
    real, imaginary = sin(x), sinh(y)
    size = (cos(x) + cosh(y)) * (x**2 + y**2) / 2
    return (x * real + y * imaginary) / size, (x * imaginary - y * real) / size
