"""Numbers that sum up a run, its modes or its vibration, as expressions, and their conditions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import EquationError, OptionError, SolverError, shown
from lumped.functionals.readings import OfQuantities, Reading
from lumped.language.arithmetic import Arithmetic
from lumped.language.expression import Call, Compare, Expr, as_expr, text_of_node, walk
from lumped.language.formula import content_of_expression, unit_of_node
from lumped.language.lowering import Kinks, Plain, lower
from lumped.support.array_function import ArrayFunction
from lumped.support.units import plain


class Bounded:
    """What ``<=`` and ``>=`` with a number make a condition of."""

    __slots__ = ()

    def __le__(self, most: float | str) -> Condition:
        return Condition(self, None, most)

    def __ge__(self, least: float | str) -> Condition:
        return Condition(self, least, None)


@dataclass(frozen=True, eq=False)
class Condition:
    """A number is at most, or at least, another one.

    Attributes
    ----------
    of : Bounded
        What is bounded, such as a functional.
    low, high : float or str or None
        Its bound, in the SI unit of the functional or with a unit, such as ``"5 kN.m"``; one of
        them is None.
    """

    of: Any
    low: float | str | None
    high: float | str | None

    def bounds(self, unit: str, analysis: str) -> tuple[float, float]:
        """Lower and upper bound as numbers in a unit; one is infinite.

        Raises
        ------
        UnitError
            If the bound has a unit of another dimension.
        OptionError
            If it is no number.
        """
        what = f"{analysis}: {self}:"
        if self.low is None:
            return -math.inf, plain(self.high, unit, what, OptionError)
        return plain(self.low, unit, what, OptionError), math.inf

    def __str__(self) -> str:
        sign, bound = ("<=", self.high) if self.low is None else (">=", self.low)
        return f"{self.of} {sign} {bound if isinstance(bound, str) else shown(bound)}"

    def __bool__(self) -> bool:
        raise OptionError(
            f"{self} is a condition of a design or a run, neither true nor false by itself. Give "
            "several as a list, such as [f >= 1, f <= 2], without `and` and without 1 <= f <= 2."
        )


T = TypeVar("T")

_BLOCK = 256
"""Sets of readings that are evaluated at once."""

_CALLED = {"run": "a run", "modes": "modes", "order response": "an order response"}
_EXAMPLES = {
    "run": "peak('shaft.tau')",
    "modes": "frequency(0)",
    "order response": "order_peak('shaft.tau')",
}


class _Leaf(Expr):
    """A reading in an expression."""

    __slots__ = ("name",)

    def __init__(self, reading: Reading) -> None:
        self.name = reading


class Functional(Arithmetic["Functional"], Bounded):
    """A number that sums up a run, its modes or its vibration.

    Combine with ``+ - * / **`` and the functions of `lumped.ops`; ``<=`` and ``>=`` with a number,
    or a text such as ``"5 kN.m"``, give a condition. Functionals of the same readings and
    operations are equal.

    Parameters
    ----------
    root : Expr
        Expression of readings.
    text : str
        How it is printed.
    rank : int
        How tightly the text binds, for brackets around it.
    """

    __slots__ = ("_content", "_root", "rank", "readings", "text")

    def __init__(self, root: Expr, text: str, rank: int = 5) -> None:
        self._root, self.text, self.rank = root, text, rank
        leaves = (node.name for node in walk(root) if isinstance(node, _Leaf))
        self.readings: tuple[Reading, ...] = tuple(dict.fromkeys(leaves))
        self._content = content_of_expression(root, lambda _: None)

    @classmethod
    def of(cls, reading: Reading) -> Functional:
        """The functional that is a reading."""
        return cls(_Leaf(reading), str(reading))

    @classmethod
    def operand(cls, value: object) -> Functional:
        """A functional from one or a number."""
        if isinstance(value, Functional):
            return value
        if isinstance(value, Expr) or not isinstance(value, int | float | np.number):
            raise EquationError(
                f"{shown(value)} stands beside a functional, which is combined with functionals "
                "and numbers. Sum up first what a run gives at each instant, as by "
                "lumped.functionals.peak."
            )
        node = as_expr(value)
        return cls(node, *text_of_node(node, [], str))

    @classmethod
    def apply(cls, op: str, operands: tuple[object, ...]) -> Functional:
        """An operator or function applied to functionals and numbers."""
        parts = [cls.operand(each) for each in operands]
        node = Call(op, tuple(part._root for part in parts))
        return cls(node, *text_of_node(node, [(part.text, part.rank) for part in parts], str))

    def called(self, text: str) -> Functional:
        """The same under another text."""
        return Functional(self._root, text)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Functional) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    def __repr__(self) -> str:
        return self.text

    def __reduce__(self) -> tuple[Any, ...]:
        return Functional, (self._root, self.text, self.rank)

    @property
    def reading(self) -> Reading | None:
        """The reading that it is, if it is one."""
        return self._root.name if isinstance(self._root, _Leaf) else None

    def is_of(self, what: str) -> bool:
        """Whether a run, modes or an order response have all that it reads."""
        kinds = ("modes", what) if what == "order response" else (what,)
        return bool(self.readings) and all(reading.of in kinds for reading in self.readings)

    @property
    def names(self) -> tuple[str, ...]:
        """Names and formulas of the quantities of a run that it reads."""
        read = (r for r in self.readings if isinstance(r, OfQuantities))
        return tuple(dict.fromkeys(name for reading in read for name in reading.factors))

    def fold(self, leaf: Callable[[Reading], T], node: Callable[[Expr, list[T]], T]) -> T:
        """What becomes of the expression, from what becomes of readings and of operands."""
        done: dict[int, T] = {}
        for each in walk(self._root):
            if isinstance(each, _Leaf):
                done[id(each)] = leaf(each.name)
            else:
                done[id(each)] = node(each, [done[id(child)] for child in each.children()])
        return done[id(self._root)]

    def unit(self, system: System) -> str:
        """Unit of its value."""

        def of_leaf(reading: Reading) -> str:
            unit = reading.unit(system)
            return "" if unit == "1" else unit

        return self.fold(of_leaf, unit_of_node) or "1"

    def value(self, readings: np.ndarray) -> np.ndarray:
        """Values from those of the readings, shapes (n, len(readings)) and (n,).

        Where a reading is nan, so is the value.
        """
        if self.reading is not None:
            return readings[:, 0]
        count, width = readings.shape
        blocks = np.zeros((-(-count // _BLOCK), _BLOCK, width))
        blocks.reshape(-1, width)[:count] = readings
        function = _value(self)
        found = np.array([function(block.ravel())[0] for block in blocks]).ravel()[:count]
        found[np.isnan(readings).any(axis=1)] = np.nan
        return found

    def branches(self, readings: np.ndarray, rtol: float) -> list[Branch]:
        """Derivatives by the readings: one, or several where an ``abs``, `maximum` has a kink.

        Parameters
        ----------
        readings : ndarray, shape (len(readings),)
            Their values.
        rtol : float
            Relative accuracy of these, up to which two operands are the same.

        Returns
        -------
        list of Branch

        Raises
        ------
        SolverError
            If there is none, as for a root of zero.
        """
        if self.reading is not None:
            return [Branch(np.ones(1), [])]
        function, count = _slopes(self)
        every: list[list[int]] = [[]]
        tied: set[int] = set()
        for i in range(count):
            longer = []
            for modes in every:
                given = modes + [0] * (count - len(modes))
                _, margins, by = function(readings, given)
                size = float(np.abs(by[i::count]) @ np.abs(readings))
                margin = float(margins[i])
                if abs(margin) <= rtol * size:
                    tied.add(i)
                    longer += [[*modes, 0], [*modes, 1]]
                else:
                    longer.append([*modes, int(margin >= 0)])
            every = longer
        found = []
        for modes in every:
            slopes, _, by = function(readings, modes)
            if not np.isfinite(slopes).all():
                raise SolverError(
                    f"{self}: where {', '.join(map(str, self.readings))} are "
                    f"{', '.join(f'{value:.6g}' for value in readings)}, it has no derivative, as "
                    "a root of zero has none."
                )
            found.append(Branch(slopes, [(by[i::count], modes[i]) for i in sorted(tied)]))
        return found


class Branch(NamedTuple):
    """Derivatives of a functional by its readings on one side of its kinks.

    Attributes
    ----------
    slopes : ndarray, shape (n,)
    kinks : list of (ndarray, int)
        Derivatives of what changes its sign at each kink, and 1 where it is positive, else 0.
    """

    slopes: np.ndarray
    kinks: list[tuple[np.ndarray, int]]

    def lies(self, rates: np.ndarray) -> np.ndarray:
        """Whether a change of the readings leads here, shapes (n, k) and (k,)."""
        found = np.ones(rates.shape[1], dtype=bool)
        for by, mode in self.kinks:
            found &= (by @ rates >= 0) == mode
        return found


class _Kinks(Plain):
    """Kinks whose sides are given."""

    def __init__(self) -> None:
        self.modes: list[ca.SX] = []
        self.margins: list[ca.SX] = []

    def mode(self, condition: Compare, greater: ca.SX, less: ca.SX) -> ca.SX:
        self.modes.append(ca.SX.sym("mode"))
        self.margins.append(greater - less)
        return self.modes[-1]


def _lower(
    functional: Functional, leaf: Callable[[Reading], ca.SX], kinks: Kinks | None = None
) -> ca.SX:
    """A functional as an expression of its readings."""
    return lower(functional._root, lambda node: leaf(node.name), kinks=kinks)  # type: ignore[attr-defined]


def refuse_other(of: Iterable[object], what: str, analysis: str) -> None:
    """Refuse functionals that belong to something else than a run, modes or an order response.

    Raises
    ------
    OptionError
    """
    for wanted in of:
        if not (isinstance(wanted, Functional) and wanted.is_of(what)):
            raise OptionError(
                f"{analysis}: {wanted!r:.60} is no functional of "
                f"{_CALLED[what]}; take one of lumped.functionals, such as {_EXAMPLES[what]}."
            )


@lru_cache(256)
def _value(functional: Functional) -> ArrayFunction:
    """Values of a functional from a block of sets of readings, one set after the other."""
    leaves = ca.SX.sym("readings", len(functional.readings))
    places = dict(zip(functional.readings, ca.vertsplit(leaves), strict=True))
    value = ca.Function("value", [leaves], [ca.densify(_lower(functional, places.__getitem__))])
    return ArrayFunction(value.map(_BLOCK))


@lru_cache(256)
def _slopes(functional: Functional) -> tuple[ArrayFunction, int]:
    """Derivatives of a functional, and how many kinks it has.

    (readings, modes) -> (slopes, margins, slopes of margins by one reading after the other)
    """
    leaves, kinks = ca.SX.sym("readings", len(functional.readings)), _Kinks()
    places = dict(zip(functional.readings, ca.vertsplit(leaves), strict=True))
    value = _lower(functional, places.__getitem__, kinks)
    modes, margins = (ca.vertcat(ca.SX(0, 1), *parts) for parts in (kinks.modes, kinks.margins))
    found = ca.jacobian(value, leaves), margins, ca.jacobian(margins, leaves)
    function = ca.Function("slopes", [leaves, modes], [ca.densify(each) for each in found])
    return ArrayFunction(function), modes.numel()


def readings_of(functionals: Iterable[Functional]) -> tuple[Reading, ...]:
    """All readings of functionals, each once."""
    return tuple(dict.fromkeys(reading for f in functionals for reading in f.readings))


def watching(system: System, of: Iterable[Functional]) -> System:
    """The system for runs of which functionals are wanted: they stop at the kinks of formulas."""
    return system.watching([name for functional in of for name in functional.names])
