"""Taylor coefficients of the states of a system in machine code, for the tolerance of a run."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from lumped.code.functions import compile_series
from lumped.code.machine_code import Code
from lumped.code.operations import Operations, UnsupportedError, join_functions
from lumped.code.taylor import series_of
from lumped.errors import OptionError
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

_LINEAR, _SUMMED = (12.0, 4 / 3), (6.0, 1.1)
"""Order at a tolerance of one and its rise for each digit, without sums over orders and with them.

Without sums a term costs the same at any order, so the order is as high as leaves a step of about
four radians of what is fastest: longer ones would hide extremes inside them. With sums these orders
cost least; those of Jorba and Zou, where sums were all the cost, are lower."""
_CAUTION = 0.9
"""With sums the series ends at a pole, and what it lacks is not much less than its last term."""


class TaylorSeries:
    """Coefficients of one system, compiled when they are first asked for.

    Parameters
    ----------
    rates : Operations
        Derivatives of the states, then what is integrated.
    states : int
        Number of states.
    implicit : int
        Number of quantities that are found by iteration.
    """

    def __init__(self, rates: Operations, states: int, implicit: int) -> None:
        self._rates, self._states, self._implicit = rates, states, implicit
        self._functions: dict[int, Function] = {}
        self._kept: list[Code] = []

    def with_integrals(self, integrands: Operations) -> TaylorSeries:
        """The same with integrals of quantities; itself if their series would do badly.

        The square of a sine has a series of twice the frequency, so where steps are as long as a
        linear system allows, only what is linear has integrals of the same accuracy.
        """
        if not _has_series(integrands):
            return self
        whole = join_functions(self._rates, integrands)
        more = TaylorSeries(whole, self._states, self._implicit)
        return self if self.is_linear and not more.is_linear else more

    @cached_property
    def exist(self) -> bool:
        """Whether there are coefficients."""
        try:
            return self.is_linear is not None
        except OptionError:
            return False

    @cached_property
    def is_linear(self) -> bool:
        """Whether no coefficients need sums over orders.

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
            return series_of(self._rates).is_linear
        except UnsupportedError as fault:
            raise OptionError(
                f"method = 'taylor': the rates contain {fault} of a quantity that varies, which "
                "has no Taylor coefficients; take method='steps', or write it as a condition "
                "or as a smooth function."
            ) from None

    def order(self, rtol: float) -> int:
        """Order for a tolerance."""
        begin, rise = _LINEAR if self.is_linear else _SUMMED
        return math.ceil(begin - rise * math.log10(rtol))

    def _function(self, order: int) -> Function:
        if order not in self._functions:
            code = compile_series(self._rates, order, self._states)
            self._kept.append(code)
            self._functions[order] = Function(address=code.address("series"))
        return self._functions[order]

    def compile_lanes(self, rtol: float, count: int) -> None:
        """Make machine code for several runs side by side."""
        order = self.order(rtol)
        function = self._function(order)
        if not function.wide_address:
            code = compile_series(self._rates, order, self._states, count)
            self._kept.append(code)
            function.wide_address = code.address("series")

    def add_to(self, run: Run, rtol: float) -> None:
        """Let a run make steps by series."""
        run.order = self.order(rtol)
        run.series = self._function(run.order)
        run.caution = 1.0 if self.is_linear else _CAUTION
        run.terms, run.row = run.order + 1, self._rates.results
        run.coefficients = np.zeros(run.terms * run.row)


def _has_series(function: Operations) -> bool:
    try:
        series_of(function)
    except UnsupportedError:
        return False
    return True
