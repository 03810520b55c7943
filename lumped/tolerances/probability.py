"""The probability that a functional passes a limit, and conditions of it on a design."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NoReturn

from lumped.ensembles.variants import Over
from lumped.errors import OptionError, shown
from lumped.functionals import Condition, Functional
from lumped.support.arguments import checked


@dataclass(frozen=True, eq=False)
class Probability:
    """The probability that a functional passes a limit where parameters scatter.

    ``probability(...) <= 1e-4`` is a condition for `subject_to` of `optimise`.

    Attributes
    ----------
    of : functional
        What is limited.
    above, below : float or str or None
        The limit that it passes.
    over : mapping of name to distribution, or Correlated
        What scatters.
    runs : int
        Samples by which the result is checked.
    seed : int
        Of these.
    """

    of: Functional
    above: float | str | None
    below: float | str | None
    over: Over = field(repr=False)
    runs: int
    seed: int

    def __str__(self) -> str:
        side, limit = ("above", self.above) if self.below is None else ("below", self.below)
        told = limit if isinstance(limit, str) else f"{limit:g}"
        return f"probability({self.of} {side} {told})"

    def __le__(self, most: float | str) -> Condition:
        if isinstance(most, str | bool) or not 0 < most < 1:
            raise OptionError(
                f"{self} <= {shown(most)}: a number greater than 0 and less than 1 is needed."
            )
        return Condition(self, None, most)

    def _refuse(self, other: object) -> NoReturn:
        raise OptionError(
            f"{self} is a condition only with `<=` and a number, such as probability(...) <= 1e-4."
        )

    # what a condition cannot be made of
    __lt__ = __gt__ = __ge__ = __eq__ = __ne__ = _refuse
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        self._refuse(None)


@checked
def probability(
    of: Functional,
    *,
    over: Any,
    above: float | str | None = None,
    below: float | str | None = None,
    runs: int = 1000,
    seed: int = 0,
) -> Probability:
    """The probability that a functional passes a limit, to be bounded or made small by `optimise`.

    Parameters
    ----------
    of : functional
        From `lumped.functionals`.
    over : mapping of name to distribution, or correlated distributions
        What scatters, as for `ensemble`. Distributions that are `scaled` move with the design.
    above, below : float or str
        One of these: the limit, in the SI unit of the functional or with a unit, such as
        ``"5 kN.m"``; the functional fails above or below it.
    runs : int
        Samples by which the probability of the best design is checked.
    seed : int
        Of these samples.

    Returns
    -------
    Probability
        ``probability(...) <= 1e-4`` is a condition.

    Raises
    ------
    OptionError
        If there is not one limit, or something else than ``<=`` is made of it.
    """
    if (above is None) == (below is None):
        raise OptionError(
            f"probability: above = {shown(above)} and below = {shown(below)}: give one limit, "
            "above or below which the functional fails."
        )
    if runs < 100:
        raise OptionError(f"probability: runs = {runs}: at least 100 are needed for the check.")
    return Probability(of, above, below, over, runs, seed)
