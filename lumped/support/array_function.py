"""Calls of compiled functions with numbers, without conversions on the way."""

from __future__ import annotations

import threading
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt


class ArrayFunction:
    """A CasADi function that takes and gives arrays.

    Calling the function itself turns every argument and result into CasADi's matrices, which
    costs more than a small model's right-hand side.

    Parameters
    ----------
    function : Function
        Of sparse inputs and outputs only the nonzeros are given.
    """

    def __init__(self, function: ca.Function) -> None:
        self._function, self._own = function, threading.local()

    def __call__(self, *arguments: npt.ArrayLike) -> list[np.ndarray]:
        """Results as flat arrays, column after column.

        Raises
        ------
        RuntimeError
            If the evaluation fails.
        """
        # a lock would stay closed where an interrupt comes between its two ends
        room: _Room | None = getattr(self._own, "room", None)
        if room is None:
            room = self._own.room = _Room(self._function)
        for held, given in zip(room.arguments, arguments, strict=True):
            held[:] = given
        room.run()
        if room.returned():
            raise RuntimeError(f"{self._function.name()} could not be evaluated")
        return [result.copy() for result in room.results]


class _Room:
    """Where one thread puts arguments and finds results."""

    def __init__(self, function: ca.Function) -> None:
        buffer: Any
        buffer, self.run = function.buffer()
        self.arguments = [np.zeros(function.nnz_in(i)) for i in range(function.n_in())]
        self.results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        self.returned = buffer.ret
        for i, argument in enumerate(self.arguments):
            buffer.set_arg(i, argument.data)
        for i, result in enumerate(self.results):
            buffer.set_res(i, result.data)
