"""Scatter by polynomials that are fitted to few runs."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.tolerances.chaos import Chaos
from lumped.tolerances.intervals import CONFIDENCE, Quantile, Share, quantile_of, share_of
from lumped.tolerances.shares import correlated
from lumped.tolerances.spread import Spread, explained, ranked_shares, skewness_of

__all__ = ["ChaosSpread"]

_WIDTH = float(scipy.special.ndtri(0.5 + 0.5 * CONFIDENCE))
"""Standard errors in half an interval."""


class ChaosSpread(Spread):
    """From the polynomials of one functional.

    Intervals are those of a large sample of the polynomials, with standard errors from leaving out
    each run.
    """

    def __init__(self, chaos: Chaos, k: int) -> None:
        one, values = chaos.expansions[k], chaos.sample[:, k]
        super().__init__(chaos.names, chaos.scene.physical(chaos.many_scores), values)
        self.label, self.unit = chaos.labels[k], chaos.units[k]
        self.mean, self.std = one.mean, float(np.sqrt(one.variance))
        self._chaos, self._q2 = chaos, one.q2
        self.skewness = skewness_of(values)
        there = int(np.isfinite(chaos.values_of_runs[:, k]).sum())
        self.missing = share_of(chaos.runs - there, chaos.runs)
        if correlated(chaos.scene).any():
            shares = np.array([explained(column, values) for column in self._x.T])
        else:
            shares = chaos.first[k]
        self.ranking = ranked_shares(chaos.names, shares)

    def _quantile(self, q: float) -> Quantile:
        off, found = self._error(q), quantile_of(self._ascending, q)
        return Quantile(found.value, found.low - off, found.high + off)

    def _error(self, q: float) -> float:
        """Half the width of an interval that the polynomials owe to their runs."""
        return _WIDTH * float(self._chaos.quantile(self.label, q)[1][0])

    def _share(self, limit: float, above: bool) -> Share:
        known = self._ascending
        under = float((known <= limit).mean())
        inside = min(max(under, 1 / len(known)), 1 - 1 / len(known))
        off, side = self._error(inside), 1 if above else -1
        value, least, most = (
            share_of(int((known > end if above else known < end).sum()), len(known))
            for end in (limit, limit + side * off, limit - side * off)
        )
        return Share(value.value, least.low, most.high)

    def trust(self) -> str:
        """How far the polynomials hold, in words."""
        return f"predicts {100 * max(self._q2, 0.0):.4g} % of the variance of runs left out"
