"""Calls of compiled functions with numbers, without conversions on the way."""

from __future__ import annotations

from typing import Any, Literal

import casadi as ca
import numpy as np
import numpy.typing as npt

from lumped.system import System

__all__ = ["Call", "called"]


class Call:
    """A CasADi function that takes and gives dense arrays.

    Calling the function itself turns every argument and result into CasADi's matrices, which
    costs more than a small model's right-hand side.

    Parameters
    ----------
    function : Function
        All inputs and outputs dense.
    """

    def __init__(self, function: ca.Function) -> None:
        buffer: Any
        buffer, self._run = function.buffer()
        self._arguments = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self._results = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        self._name = function.name()
        self._returned = buffer.ret
        for i, argument in enumerate(self._arguments):
            buffer.set_arg(i, argument.data)
        for i, result in enumerate(self._results):
            buffer.set_res(i, result.data)

    def __call__(self, *arguments: npt.ArrayLike) -> list[np.ndarray]:
        """Results as flat arrays, column after column.

        Raises
        ------
        RuntimeError
            If the evaluation fails.
        """
        for held, given in zip(self._arguments, arguments, strict=True):
            held[:] = given
        self._run()
        if self._returned():
            raise RuntimeError(f"{self._name} could not be evaluated")
        return [result.copy() for result in self._results]


def called(system: System, name: Literal["rhs", "look", "margins"]) -> Call:
    """A function of a system, to be called with numbers."""
    key = ("call", name)
    if key not in system.made:
        system.made[key] = Call(getattr(system, name))
    call: Call = system.made[key]
    return call
