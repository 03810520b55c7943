"""How much damage a cycle of a load does: an S-N curve and a rule for means, in numbers."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from lumped.kernel.cycles import FKM, GERBER, GOODMAN, NO_MEAN, SMITH_WATSON_TOPPER, WALKER

_RULES = {
    NO_MEAN: "no effect of means",
    GOODMAN: "Goodman, ultimate strength {:.6g} Pa",
    GERBER: "Gerber, ultimate strength {:.6g} Pa",
    SMITH_WATSON_TOPPER: "Smith, Watson and Topper",
    WALKER: "Walker, exponent {:.6g}",
    FKM: "FKM, mean-stress sensitivity {:.6g}",
}


class MeanStress(NamedTuple):
    """How the mean of a cycle counts.

    Attributes
    ----------
    kind : int
        Which rule (see `lumped.kernel.cycles`).
    number : float
        What belongs to it: ultimate strength, Pa, exponent, or sensitivity.
    """

    kind: int = NO_MEAN
    number: float = 0.0

    def __str__(self) -> str:
        return _RULES[self.kind].format(self.number)


class DamageLaw(NamedTuple):
    """How much damage a cycle does.

    Attributes
    ----------
    rows : tuple of (float, float, float)
        Amplitude, damage of a cycle there, and slope up to the next row, ascending.
    extends_down : bool
        Whether the law of the first row holds below it; otherwise there is no damage.
    mean_stress : MeanStress
        How means count.
    scale : float
        Stress for each unit of the load.
    """

    rows: tuple[tuple[float, float, float], ...] = ()
    extends_down: bool = False
    mean_stress: MeanStress = MeanStress()
    scale: float = 1.0

    def __str__(self) -> str:
        slopes = "/".join(f"{slope:.6g}" for _, _, slope in self.rows)
        amplitude, share, _ = self.rows[0]
        text = f"{1 / share:.6g} cycles at {amplitude:.6g}, slope {slopes}"
        return text if self.mean_stress.kind == NO_MEAN else f"{text}, {self.mean_stress}"


class Curve(Protocol):
    """How much damage a cycle does, as an S-N curve says it."""

    def law(self, mean_stress: MeanStress | None, scale: float) -> DamageLaw:
        """The numbers of the curve."""
        ...
