"""Functionals of a run whose states are unknown at nodes: as expressions, and as numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.functionals.readings import Extreme, Integral, OfQuantities, Reading, Span, Value
from lumped.language.expression import Call, ConstantExpression, Expr
from lumped.language.lowering import OPERATIONS
from lumped.numerics.nlp import Programme
from lumped.optimisation.discretisation import Discretisation
from lumped.orbits.smooth_curves import curves, extreme, integral
from lumped.timeloop.results.trajectory import Trajectory

_INCREASING = ("exp", "log", "sinh", "tanh", "atan")
_LINEAR = [("*", [True, False]), ("*", [False, True]), ("/", [True, False])]
_KINKED: dict[str, Callable[..., ca.SX]] = {
    "abs": ca.fabs,
    "max": ca.fmax,
    "min": ca.fmin,
    "sign": ca.sign,
}


@dataclass(frozen=True, eq=False)
class Term:
    """A functional as an expression of the unknowns.

    Attributes
    ----------
    value : SX
        In the unit of the functional.
    scale : float
        Its size at the start.
    side : {0, 1, -1}
        1 where the expression is an upper bound of the functional, which can be made small, not
        large; -1 where it is a lower bound.
    """

    value: ca.SX
    scale: float
    side: int


def refuse_side(label: str, term: Term, weight: float, low: float, high: float) -> None:
    """Refuse to make a functional large of which there is only an upper bound, or the reverse.

    Raises
    ------
    OptionError
    """
    sides = "small or bounded above", "large or bounded below"
    can, cannot = sides if term.side > 0 else sides[::-1]
    is_high, is_low = np.isfinite(high) or weight > 0, np.isfinite(low) or weight < 0
    if (term.side > 0 and is_low) or (term.side < 0 and is_high):
        raise OptionError(
            f"optimise: {label} can be made {can}, not made {cannot}: that has no smooth form."
        )


class _Rows(NamedTuple):
    """What an unknown bounds: a column of expressions of about one size."""

    label: str
    values: ca.SX
    size: float
    unit: str
    times: np.ndarray | None


class _Part(NamedTuple):
    """A part of a functional.

    Attributes
    ----------
    value : SX
        An expression of the unknowns.
    start : float
        Its value at the start, about.
    side : {0, 1, -1}
        As in `Term`.
    is_sum : bool
        Whether it sums up all instants.
    rows : tuple of _Rows
        What it bounds, where it is an unknown that is still to be made.
    """

    value: ca.SX
    start: float
    side: int = 0
    is_sum: bool = False
    rows: tuple[_Rows, ...] = ()


class TermMaker:
    """Makes the term of a functional.

    Parameters
    ----------
    names : sequence of str
        Quantities that are known, among them those of the functional.
    quantities : SX, shape (len(names), n)
        Along the course.
    start : ndarray, shape (k, len(names))
        At the start.

    Raises
    ------
    OptionError
        If it reads what the course does not give.
    """

    def __init__(
        self,
        programme: Programme,
        course: Discretisation,
        functional: Functional,
        names: Sequence[str],
        quantities: ca.SX,
        start: np.ndarray,
    ) -> None:
        for reading in functional.readings:
            if not _is_whole(reading):
                raise OptionError(
                    f"optimise: {functional}: {reading} is none of highest, lowest, integral, "
                    "final and span over the whole run, of which functionals consist here. Give "
                    "the system and until= for the others."
                )
        self.programme, self.course, self.functional = programme, course, functional
        self.system, self.names, self.y, self.start = course.system, list(names), quantities, start
        t, weights = course.t, course.weights
        self.times = t if isinstance(t, np.ndarray) else None
        self.weights = ca.SX(ca.DM(weights)) if isinstance(weights, np.ndarray) else weights
        self.begins = np.array([self._begin(reading) for reading in functional.readings])
        self.sizes = np.array([self._size(reading) for reading in functional.readings])
        self.slopes = self._slopes_at_start()
        self.scale = float(np.abs(self.slopes) @ self.sizes) or 1.0

    def term(self) -> Term:
        """The functional as an expression.

        Raises
        ------
        OptionError
            If extremes stand in it so that it cannot be bounded.
        """
        part = self._make_bound(self.functional.fold(self._leaf, self._node))
        return Term(part.value, self.scale, part.side)

    def _slopes_at_start(self) -> np.ndarray:
        try:
            return self.functional.branches(self.begins, 0.0)[0].slopes
        except SolverError:  # such as of a root of zero
            return np.zeros(len(self.begins))

    def _product(self, reading: OfQuantities) -> tuple[ca.SX, np.ndarray]:
        """What is read along the course, shape (1, n), and at the start, shape (k,)."""
        y, start = ca.SX(1.0), np.ones(len(self.start))
        for name in reading.factors:
            row = self.names.index(name)
            y, start = y * self.y[row, :], start * self.start[:, row]
        return y, start

    def _begin(self, reading: Reading) -> float:
        """A reading at the start, by the mean of what is integrated."""
        if not isinstance(reading, OfQuantities):
            return self.course.span
        start = self._product(reading)[1]
        return _read(reading, start, np.full(len(start), self.course.span / len(start)))

    def _size(self, reading: Reading) -> float:
        if not isinstance(reading, OfQuantities):
            return self._begin(reading)
        size = float(np.abs(self._product(reading)[1]).max()) or 1.0
        return size * self.course.span if isinstance(reading, Integral) else size

    def _leaf(self, reading: Reading) -> _Part:
        place = self.functional.readings.index(reading)
        begin, size = float(self.begins[place]), float(self.sizes[place])
        if not isinstance(reading, OfQuantities):
            return _Part(ca.sum1(self.weights), begin)
        y = self._product(reading)[0]
        if isinstance(reading, Extreme):
            unit = self.system.quantity(reading.factors[0]).unit
            rows = _Rows(reading.text, y.T, size, unit, self.times)
            part = _Part(ca.SX(), begin, reading.sign or 1, rows=(rows,))
            return part if reading.sign else self._bound_parts([part, self._negate(part)], begin, 1)
        if isinstance(reading, Value):
            return _Part(y[-1], begin)
        return _Part(ca.mtimes(y, self.weights), begin, is_sum=True)

    def _make_bound(self, part: _Part) -> _Part:
        """A bound as an unknown."""
        if not part.rows:
            return part
        e = self.programme.unknown(part.start, max(rows.size for rows in part.rows))
        for rows in part.rows:
            self.programme.constrain(
                f"{self.functional}: bound less {rows.label}",
                part.side * (e - rows.values),
                0.0,
                np.inf,
                scale=rows.size,
                unit=rows.unit,
                times=rows.times,
            )
        return _Part(e, part.start, part.side)

    def _negate(self, part: _Part) -> _Part:
        rows = (r._replace(label=f"-{r.label}", values=-r.values) for r in part.rows)
        return _Part(-part.value, -part.start, -part.side, part.is_sum, tuple(rows))

    def _bound_parts(self, parts: list[_Part], start: float, sign: int) -> _Part:
        """The greatest of parts (sign 1), or the least, as a bound that is still to be made."""
        rows: list[_Rows] = []
        for part in parts:
            own = _Rows(str(self.functional), part.value, self.scale, "1", None)
            rows += part.rows or (own,)
        return _Part(ca.SX(), start, sign, rows=tuple(rows))

    def _node(self, node: Expr, parts: list[_Part]) -> _Part:
        if isinstance(node, ConstantExpression):
            return _Part(ca.SX(node.value), node.value)
        assert isinstance(node, Call)
        if node.op == "neg":
            return self._negate(parts[0])
        start = float(_apply(node, [ca.SX(part.start) for part in parts]))
        if node.op in ("max", "min", "abs"):
            sign = -1 if node.op == "min" else 1
            several = [*parts, *map(self._negate, parts)] if node.op == "abs" else parts
            if {part.side for part in several} <= {0, sign}:
                return self._bound_parts(several, start, sign)
        parts = [self._make_bound(part) for part in parts]
        sides = {part.side for part in parts} - {0}
        if node.op == "sqrt" and not parts[0].value.is_constant():
            # a square has a slope at zero, where a root has none
            size = abs(start) or self.scale
            e = self.programme.unknown(start, size, low=0.0)
            label = f"{self.functional}: square less what it is the root of"
            self.programme.constrain(label, e**2 - parts[0].value, 0.0, 0.0, scale=size**2)
            return _Part(e, start, parts[0].side)
        is_scaled = node.op in ("*", "/") and any(part.value.is_constant() for part in parts)
        if node.op == "-":
            sides = {parts[0].side, -parts[1].side} - {0}
        elif is_scaled and sides:
            factor = next(part.start for part in parts if part.value.is_constant())
            sides = {side if factor > 0 else -side for side in sides}
            sides |= {1, -1} if parts[-1].side and node.op == "/" else set()
        elif node.op not in ("+", *_INCREASING) and sides:
            sides = {1, -1}
        if len(sides) > 1:
            raise OptionError(
                f"optimise: {self.functional}: highest and lowest values stand in it so that no "
                "bound of them bounds it. Build it by sums, differences, maxima and factors, or "
                "give the system and until=."
            )
        sums = [part.is_sum for part in parts]
        is_linear = node.op in ("+", "-") or (node.op, sums) in _LINEAR
        if not is_linear:
            parts = [self._alone(part) for part in parts]
        value = _apply(node, [part.value for part in parts])
        return _Part(value, start, next(iter(sides), 0), is_linear and any(sums))

    def _alone(self, part: _Part) -> _Part:
        """A sum as an unknown: a nonlinear function of it would couple all instants."""
        if not part.is_sum:
            return part
        size = abs(part.start) or self.scale
        s = self.programme.unknown(part.start, size)
        self.programme.constrain(f"{self.functional}: a sum", s - part.value, 0.0, 0.0, scale=size)
        return _Part(s, part.start, part.side)


def _apply(node: Call, values: list[ca.SX]) -> ca.SX:
    """An operation on expressions."""
    if node.op in _KINKED:
        return _KINKED[node.op](*values)
    return OPERATIONS[node.op](*values)


def _is_whole(reading: Reading) -> bool:
    """Whether a reading is one of the whole run, at all its instants or at its end."""
    if isinstance(reading, Value):
        return reading.at is None
    return isinstance(reading, Extreme | Integral | Span) and reading.between is None


def _read(reading: OfQuantities, y: np.ndarray, weights: np.ndarray) -> float:
    """A reading of values at nodes, with weights of an integral over time, s."""
    if isinstance(reading, Extreme):
        sizes = np.abs(y) if reading.sign == 0 else y
        return float(sizes.min() if reading.sign < 0 else sizes.max())
    return float(weights @ y) if isinstance(reading, Integral) else float(y[-1])


def number_of(
    functional: Functional, names: Sequence[str], values: np.ndarray, weights: np.ndarray
) -> float:
    """A functional of numbers at nodes.

    Parameters
    ----------
    names : sequence of str
        The quantities.
    values : ndarray, shape (n, len(names))
        What they are.
    weights : ndarray, shape (n,)
        Of an integral over time, s.
    """
    read = []
    for reading in functional.readings:
        if isinstance(reading, OfQuantities):
            columns = [values[:, list(names).index(name)] for name in reading.factors]
            read.append(_read(reading, np.prod(columns, axis=0), weights))
        else:
            read.append(float(weights.sum()))
    return float(functional.value(np.array([read]))[0])


def measure_functional(functional: Functional, run: Trajectory) -> float:
    """A functional of a run without states, between its output times too, by quintics."""
    read = []
    for reading in functional.readings:
        if not isinstance(reading, OfQuantities):
            read.append(float(run.t[-1] - run.t[0]))
        elif isinstance(reading, Value):
            read.append(float(np.prod([run[name][-1] for name in reading.factors])))
        else:
            pieces = curves(run, run.system.product(reading.factors))
            if isinstance(reading, Extreme):
                signs = (reading.sign,) if reading.sign else (1, -1)
                both = [extreme(pieces, sign).value for sign in signs]
                read.append(both[0] if reading.sign else max(map(abs, both)))
            else:
                read.append(integral(pieces).real)
    return float(functional.value(np.array([read]))[0])
