"""Calls of compiled functions with numbers, without conversions on the way."""

from __future__ import annotations

import threading
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from lumped.compiler.system import System

__all__ = ["Call", "expanded"]

_EXPAND_BELOW = 200
"""States up to which what is called often is expanded to scalar operations."""


class Call:
    """A CasADi function that takes and gives arrays.

    Calling the function itself turns every argument and result into CasADi's matrices, which
    costs more than a small model's right-hand side.

    Parameters
    ----------
    function : Function
        Of sparse inputs and outputs only the nonzeros are given.
    """

    def __init__(self, function: ca.Function) -> None:
        buffer: Any
        buffer, self._run = function.buffer()
        self._arguments = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self._results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self._name, self._lock = function.name(), threading.Lock()
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
        with self._lock:
            for held, given in zip(self._arguments, arguments, strict=True):
                held[:] = given
            self._run()
            if self._returned():
                raise RuntimeError(f"{self._name} could not be evaluated")
            return [result.copy() for result in self._results]


def expanded(function: ca.Function, system: System) -> ca.Function:
    """The function as scalar operations, unless the system is so large that they are too many."""
    return function.expand() if len(system.states) <= _EXPAND_BELOW else function
