"""Taylor coefficients of the states of a system in machine code, for the tolerance of a run."""

from __future__ import annotations

import math

import numpy as np

from lumped.code.functions import compiled_series
from lumped.code.machine_code import Code
from lumped.code.operations import Operations, UnsupportedError
from lumped.code.taylor import series_of
from lumped.errors import OptionError
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

__all__ = ["TaylorSeries"]

_LEAST = 4
_LINEAR = 8.0, 4 / 3
"""Order for a linear system at a tolerance of one, and its rise for each digit.

A term costs the same at any order, so the order is as high as leaves a step at most three radians
of what is fastest: longer ones lose digits by cancellation, and hide extremes inside them."""


class TaylorSeries:
    """Coefficients of one system, compiled when they are first asked for.

    Parameters
    ----------
    rates : Operations
        Derivatives of the states.
    implicit : int
        Number of quantities that are found by iteration.
    """

    def __init__(self, rates: Operations, implicit: int) -> None:
        self._rates, self._implicit = rates, implicit
        self._functions: dict[int, Function] = {}
        self._kept: list[Code] = []

    def order(self, rtol: float) -> int:
        """Order for a tolerance: where sums over orders are needed, that of Jorba and Zou.

        Raises
        ------
        OptionError
            If there are no coefficients.
        """
        if self._implicit:
            raise OptionError(
                "method = 'taylor': a closed linkage or implicit equation is solved by iteration, "
                "which has no Taylor coefficients; take method='steps'."
            )
        try:
            is_linear = series_of(self._rates).is_linear
        except UnsupportedError as fault:
            raise OptionError(
                f"method = 'taylor': the rates contain {fault} of a quantity that varies, which "
                "has no Taylor coefficients; take method='steps', or write it as a condition "
                "or as a smooth function."
            ) from None
        if is_linear:
            begin, rise = _LINEAR
            return max(_LEAST, math.ceil(begin - rise * math.log10(rtol)))
        return max(_LEAST, math.ceil(1 - math.log(rtol) / 2))

    def add_to(self, run: Run, rtol: float) -> None:
        """Let a run make steps by series."""
        order = self.order(rtol)
        if order not in self._functions:
            code = compiled_series(self._rates, order)
            self._kept.append(code)
            self._functions[order] = Function(address=code.addresses["series"])
        run.series, run.order = self._functions[order], order
        run.coefficients = np.zeros((order + 1) * run.plant.states)
