"""Types of what a component can be given."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from lumped.language.expression import Expr


class _WithUnit(Protocol):
    """A quantity of pint."""

    @property
    def magnitude(self) -> Any: ...
    @property
    def units(self) -> Any: ...


Value = Expr | float | str | np.integer[Any] | np.floating[Any] | _WithUnit
"""Value of a parameter or input, or start value: a number, one with a unit, or an expression."""

Numbers = Sequence[float] | np.ndarray
"""Numbers of a structural choice."""

Rows = Sequence[Sequence[float]] | np.ndarray
"""Rows of a table that is a structural choice."""
