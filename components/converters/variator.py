"""Continuously variable gear whose contact slips."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Input, Param, Var, der, param, var
from lumped.components.characteristic import Characteristic, drag_at
from lumped.errors import EquationError, shown
from lumped.language.validity import Range
from lumped.ops import maximum, smooth

__all__ = ["Variator"]


class Variator(Component):
    """Variator by traction: ``f_t = mu(s) f_n``, ``tau_a = r_a f_t``, ``tau_b = -r_b f_t``.

    The command `ratio` moves the radii at which the surfaces meet, ``r_b = ratio r_a`` with
    ``r_a + r_b = 2 R``, as in a full-toroidal variator and nearly so with a belt. The slip is

        ``s = (r_a w_a - r_b w_b) / v``,   ``v = max(|r_a w_a|, |r_b w_b|, v_low)``

    so the torque ratio is `ratio` and the efficiency of the contact ``1 - |s|``, whichever side
    drives; slip 1 is a side that stands still. `characteristic` gives the traction coefficient mu
    over the slip: rows of both from (0, 0) on, or a function. Above its peak the contact slips
    grossly. A ratio outside of `ratios` is an error. Below the speed `v_low` the slip counts
    relative to it, so at standstill a loaded variator creeps. Speeds count from the support, which
    takes ``-tau_a - tau_b``.

    Source: Carbone, Mangialardi and Mantriota, A comparison of the performances of full and half
    toroidal traction drives, Mechanism and Machine Theory 39 (2004) 921.
    """

    symbol = "variator"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    characteristic: Characteristic = ()
    ratios: tuple[float, float] = (0.4, 2.5)
    ratio: Input = Input("1", "speed of a over speed of b without slip")
    f_n: Input = Input("N", "normal force of the contact, not negative", min=0)
    R: Param = param("m", "mean of both radii", above=0)
    v_low: Param = param("m/s", "surface speed below which slip counts relative to it", above=0)
    r_a: Var = var("m", "radius of the contact on side a")
    r_b: Var = var("m", "radius of the contact on side b")
    w_a: Var = var("rad/s", "speed of side a")
    w_b: Var = var("rad/s", "speed of side b")
    s: Var = var("1", "slip")
    f_t: Var = var("N", "traction")

    def equations(self) -> Iterator[Equation]:
        a, b, frame = self.flange_a, self.flange_b, self.support
        self._ends()
        yield self.r_a == 2 * self.R / (1 + self.ratio)
        yield self.r_b == 2 * self.R - self.r_a
        yield self.w_a == der(a.phi - frame.phi)
        yield self.w_b == der(b.phi - frame.phi)
        v_a, v_b = self.r_a * self.w_a, self.r_b * self.w_b
        faster = smooth(maximum(maximum(abs(v_a), abs(v_b)), self.v_low))
        yield self.s == (v_a - v_b) / faster
        yield self.f_t == self.f_n * drag_at(self.characteristic, self.s)
        yield a.tau == self.r_a * self.f_t
        yield b.tau == -self.r_b * self.f_t
        yield frame.tau == -a.tau - b.tau

    def loss(self) -> Expr:
        """Heat of the slip, W."""
        return self.f_t * (self.r_a * self.w_a - self.r_b * self.w_b)

    def valid(self) -> Iterator[Range]:
        """Ratios that the radii reach."""
        hint = "Command a ratio within ratios, or give others"
        yield Range(self.ratio, *self._ends(), "1", "ratio", hint)
        hint = "A contact does not pull; let the command end at zero"
        yield Range(self.f_n, 0.0, float("inf"), "N", "normal force", hint)

    def _ends(self) -> tuple[float, float]:
        """The least and the greatest ratio."""
        try:
            low, high = map(float, self.ratios)
        except (TypeError, ValueError):
            low = high = 0.0
        if not 0 < low <= high < float("inf"):
            raise EquationError(
                f"ratios = {shown(self.ratios)}: the least and the greatest ratio are needed, both "
                "above 0, such as (0.4, 2.5)."
            )
        return low, high
