"""Linear blocks: state space and transfer functions, continuous or in a computer.

What another tool designed comes back by the method `of` of each block. Signals have the unit of
what they are connected to; coefficients are numbers in SI units.

Sources: Astrom and Murray, Feedback Systems, 2008, ch. 5 and 8 (state space, reachable canonical
form); Astrom and Wittenmark, Computer-Controlled Systems, 3rd ed., ch. 2 (sampled systems).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from typing import Any, Self

from lumped import Component, Connection, Equation, Expr, Input, Output, Var, connect, der, var
from lumped.components.control.controllers import Integrator
from lumped.components.control.sampled import _Clocked, _Sampled
from lumped.errors import DeclarationError, shown
from lumped.language.component import Made, path_of
from lumped.language.declared import quantities_of
from lumped.language.switch import Item
from lumped.language.value_types import Numbers, Rows
from lumped.ops import where

__all__ = [
    "LinearBlock",
    "SampledLinearBlock",
    "SampledStateSpace",
    "SampledTransferFunction",
    "StateSpaceBlock",
    "TransferFunction",
]


class _Rate(Component):
    """Derivative of a state: ``y = u``."""

    symbol = "gain"
    u: Input = Input("1", "signal")
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.u


class _Kept(Component):
    """State that only samples change: ``der(x) = 0``."""

    x: Var = var("1", "state since the last sample", state="always")

    def equations(self) -> Iterator[Equation]:
        yield der(self.x) == 0


def _label(block: Component) -> str:
    path, kind = path_of(block), type(block).__name__
    return f"{path} ({kind})" if path else kind


def _row(block: Component, name: str, given: Any) -> list[float]:
    """Finite numbers, out of a structural choice."""
    try:
        found = [float(value) for value in given]
    except (TypeError, ValueError):
        found = [float("nan")]
    if not all(abs(value) < float("inf") for value in found):
        what = "rows of finite numbers, [[...], ...]" if name in "ABCD" else "finite numbers"
        raise DeclarationError(
            f"{_label(block)}: {name} = {shown(getattr(block, name))}: give {what}."
        )
    return found


def _matrix(block: Component, name: str) -> list[list[float]]:
    rows = getattr(block, name)
    return [_row(block, name, row) for row in (rows if hasattr(rows, "__iter__") else [rows])]


def _join_matrices(block: Component) -> list[list[float]]:
    """``[[A, B], [C, D]]`` of a block, whose shapes fit each other and its signals."""
    A, B, C, D = (_matrix(block, name) for name in "ABCD")
    n, inputs, outputs = len(A), len(_signals(block, Input)), len(_signals(block, Output))
    if not n:
        B, C = [], [[] for _ in range(outputs)]
    needed = ((A, n, n), (B, n, inputs), (C, outputs, n), (D, outputs, inputs))
    if any(list(map(len, m)) != rows * [columns] for m, rows, columns in needed):
        shapes = ", ".join(
            f"{name} ({rows}, {columns})"
            for name, (_, rows, columns) in zip("ABCD", needed, strict=True)
        )
        raise DeclarationError(
            f"{_label(block)}: the matrices do not fit {n} rows of A, {inputs} inputs and "
            f"{outputs} outputs: {shapes} are needed. For other signals write a class that "
            "declares them, class Feedback(LinearBlock)."
        )
    return [a + b for a, b in zip(A + C, B + D, strict=True)]


def _polynomials(block: Component) -> tuple[list[float], list[float], float]:
    """Last row of A, and C and D of the reachable canonical form of a transfer function.

    The states are ``x, s x, s^2 x, ...``; B is (0, ..., 0, 1).
    """
    above, below = (
        _row(block, name, getattr(block, name)) for name in ("numerator", "denominator")
    )
    while above and not above[0]:
        above = above[1:]
    while below and not below[0]:
        below = below[1:]
    if not below:
        raise DeclarationError(f"{_label(block)}: the denominator is zero; give its coefficients.")
    n = len(below) - 1
    if len(above) > n + 1:
        raise DeclarationError(
            f"{_label(block)}: the numerator has the degree {len(above) - 1}, the denominator "
            f"{n}: this would need what comes later, or the rate of the input. Add a filter, such "
            "as a factor T s + 1 in the denominator."
        )
    above = [c / below[0] for c in [0.0] * (n + 1 - len(above)) + above]
    below = [c / below[0] for c in below]
    c = [b - above[0] * a for b, a in zip(above, below, strict=True)]
    return [-a for a in below[:0:-1]], c[:0:-1], above[0]


def _signals(block: Component, kind: type[Input] | type[Output]) -> list[Expr]:
    found = quantities_of(block).items()
    return [getattr(block, name) for name, quantity in found if isinstance(quantity, kind)]


def _rows(block: Any) -> list[Expr]:
    """``A x + B u`` and ``C x + D u`` of a block, one expression for each row."""
    signals = [*(s.x for s in block.state), *_signals(block, Input)]
    return [_sum(row, signals) for row in _join_matrices(block)]


def _clock(cls: type[Component], system: Any, other: str) -> dict[str, float]:
    """Sample time for a class; refused if the system is of the other kind."""
    dt = getattr(system, "dt", None)
    if dt is True:
        raise DeclarationError(
            f"{cls.__name__}.of: the system is sampled (dt = True) but has no sample time; give it "
            "one, s."
        )
    T_s, samples = float(dt or 0.0), issubclass(cls, _Clocked)
    if bool(T_s) != samples:
        kind = f"sampled, dt = {T_s:g} s" if T_s else "continuous"
        raise DeclarationError(f"{cls.__name__}.of: the system is {kind}; take {other}.of.")
    return {"T_s": T_s} if samples else {}


def _attributes(cls: type[Component], system: Any, names: str, what: str) -> list[Any]:
    missing = [name for name in names.split() if not hasattr(system, name)]
    if missing:
        raise DeclarationError(
            f"{cls.__name__}.of: {shown(system)} has no {missing[0]}; give {what}."
        )
    return [getattr(system, name) for name in names.split()]


def _sum(coefficients: Sequence[float], signals: Sequence[Expr]) -> Expr:
    """Weighted sum of signals, without those of weight zero."""
    pairs = zip(coefficients, signals, strict=True)
    terms = [signal if c == 1 else c * signal for c, signal in pairs if c]
    return reduce(lambda a, b: a + b, terms) if terms else 0 * signals[0]


class _StateSpace(Component):
    """Matrices of a linear block."""

    A: Rows = ()
    B: Rows = ()
    C: Rows = ()
    D: Rows = ()

    @classmethod
    def of(cls, system: Any) -> Self:
        """The block of a state space that another tool designed.

        Parameters
        ----------
        system : control.StateSpace, scipy.signal.StateSpace or the like
            An object with A, B, C, D, and for a sampled block its sample time `dt`, s.

        Raises
        ------
        DeclarationError
            If it has no matrices, or is continuous where the block is sampled or the reverse.
        """
        matrices = _attributes(cls, system, "A B C D", "a state space, such as control.ss(system)")
        clock = _clock(cls, system, _OTHERS[issubclass(cls, _Clocked)][0])
        given: dict[str, Any] = {**dict(zip("ABCD", matrices, strict=True)), **clock}
        return cls(**given)


class _Polynomials(Component):
    """Numerator and denominator of a linear block."""

    numerator: Numbers = ()
    denominator: Numbers = ()

    @classmethod
    def of(cls, system: Any) -> Self:
        """The block of a transfer function that another tool designed.

        Parameters
        ----------
        system : control.TransferFunction, scipy.signal.TransferFunction or the like
            An object with `num` and `den` of one input and one output, and for a sampled block its
            sample time `dt`, s.

        Raises
        ------
        DeclarationError
            If it has no polynomials or several, or is continuous where the block is sampled or the
            reverse.
        """
        polynomials = _attributes(cls, system, "num den", "a transfer function")
        clock = _clock(cls, system, _OTHERS[issubclass(cls, _Clocked)][1])
        above, below = (_only(cls, p) for p in polynomials)
        given: dict[str, Any] = {"numerator": above, "denominator": below, **clock}
        return cls(**given)


_OTHERS = (
    ("SampledStateSpace", "SampledTransferFunction"),
    ("StateSpaceBlock", "TransferFunction"),
)
"""Classes for systems that a continuous block, and a sampled one, cannot be."""


def _only(cls: type[Component], given: Any) -> list[float]:
    """The polynomial of one input and one output, also from rows and columns of such."""
    if hasattr(given[0], "__len__"):
        if len(given) != 1 or len(given[0]) != 1:
            raise DeclarationError(
                f"{cls.__name__}.of: the system has {len(given[0])} inputs and {len(given)} "
                "outputs, but the block one of each; make a state space of it."
            )
        given = given[0][0]
    return [float(c) for c in given]


def _states(block: LinearBlock) -> list[Integrator]:
    return [Integrator() for _ in _matrix(block, "A")]


def _rates(block: LinearBlock) -> list[_Rate]:
    return [_Rate(u=row) for row in _rows(block)[: len(block.state)]]


class LinearBlock(_StateSpace):
    """Base of linear blocks with any signals: ``der(x) = A x + B u``, ``y = C x + D u``.

    A subclass declares the inputs and outputs, which make `u` and `y` in their order. States are
    ``state[0].x``, ``state[1].x``, ...; they begin at 0 unless `start` gives them. A block without
    states has ``A=()``.
    """

    symbol = "controller"
    state: Any = Made(_states)
    rate: Any = Made(_rates)

    def equations(self) -> Iterator[Equation]:
        for y, row in zip(_signals(self, Output), _rows(self)[len(self.state) :], strict=True):
            yield y == row

    def connections(self) -> Iterator[Connection]:
        for rate, state in zip(self.rate, self.state, strict=True):
            yield connect(rate.y, state.u)


class StateSpaceBlock(LinearBlock):
    """Linear block of one input and one output: ``der(x) = A x + B u``, ``y = C x + D u``.

    For several signals derive a class from `LinearBlock`. States are ``state[0].x``, ..., and
    begin at 0 unless `start` gives them.
    """

    u: Input = Input("1", "signal")
    y = Output("1", "signal")


def _chain(block: TransferFunction) -> list[Integrator]:
    return [Integrator() for _ in _polynomials(block)[0]]


def _highest(block: TransferFunction) -> list[_Rate]:
    last, _, _ = _polynomials(block)
    signals = [*(s.x for s in block.state), block.u]
    return [_Rate(u=_sum([*last, 1.0], signals))] if len(last) else []


class TransferFunction(_Polynomials):
    """Transfer function ``y / u = numerator(s) / denominator(s)``, highest powers first.

    In reachable canonical form: with the denominator ``s^n + a_1 s^(n-1) + ... + a_n`` the states
    are ``der(x_i) = x_(i+1)`` and ``der(x_n) = u - a_n x_1 - ... - a_1 x_n``. They are
    ``state[0].x``, ..., and begin at 0 unless `start` gives them. The degree of the numerator may
    not exceed that of the denominator.
    """

    symbol = "controller"
    u: Input = Input("1", "signal")
    y = Output("1", "signal")
    state: Any = Made(_chain)
    rate: Any = Made(_highest)

    def equations(self) -> Iterator[Equation]:
        _, c, d = _polynomials(self)
        yield self.y == _sum([*c, d], [*(s.x for s in self.state), self.u])

    def connections(self) -> Iterator[Connection]:
        for state, following in zip(self.state, [*self.state[1:], *self.rate], strict=True):
            yield connect(following.y, state.u)


def _make_kept_states(block: SampledLinearBlock) -> list[_Kept]:
    return [_Kept() for _ in _matrix(block, "A")]


def _make_kept_outputs(block: Component) -> list[_Kept]:
    return [_Kept() for _ in _signals(block, Output)]


class SampledLinearBlock(_StateSpace, _Clocked):
    """Base of linear blocks in a computer: ``y = C x + D u``, then ``x = A x + B u``.

    It samples at the instants ``start_time + k T_s`` and holds its outputs in between; before the
    first sample they are 0. Signals and states as those of `LinearBlock`.
    """

    symbol = "stairs"
    state: Any = Made(_make_kept_states)
    held: Any = Made(_make_kept_outputs)

    def equations(self) -> Iterator[Item]:
        rows, outputs = _rows(self), _signals(self, Output)
        kept = [s.x for s in (*self.state, *self.held)]
        for y, row, held in zip(outputs, rows[len(self.state) :], self.held, strict=True):
            yield y == where(self.due, row, held.x)
        yield from self._count_samples(dict(zip(kept, rows, strict=True)))


class SampledStateSpace(SampledLinearBlock):
    """Linear block in a computer: ``y = C x + D u``, then ``x = A x + B u``, at each sample.

    One input and one output; for several derive a class from `SampledLinearBlock`.
    """

    u: Input = Input("1", "signal")
    y = Output("1", "signal")


def _make_kept_chain(block: SampledTransferFunction) -> list[_Kept]:
    return [_Kept() for _ in _polynomials(block)[0]]


class SampledTransferFunction(_Polynomials, _Sampled):
    """Transfer function in a computer: ``y / u = numerator(z) / denominator(z)``, held in between.

    It samples at the instants ``start_time + k T_s``. Coefficients begin with the highest power of
    ``z``, and the degree of the numerator may not exceed that of the denominator. States as those
    of `TransferFunction`, with the next sample in place of the derivative.
    """

    symbol = "stairs"
    u: Input = Input("1", "signal")
    state: Any = Made(_make_kept_chain)

    def equations(self) -> Iterator[Item]:
        last, c, d = _polynomials(self)
        states = [s.x for s in self.state]
        ahead = [*states[1:], _sum([*last, 1.0], [*states, self.u])][: len(states)]
        value = _sum([*c, d], [*states, self.u])
        yield from self._hold_samples(value, dict(zip(states, ahead, strict=True)))
