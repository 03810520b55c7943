"""Expressions as the user writes them: a small tree, lowered to CasADi at flattening.

Equations are kept as trees and not as CasADi nodes because a CasADi ``==`` simplifies
``x == x`` to a constant, ``math.sin`` of a symbol silently returns nan, and an operator on
scalar symbols costs 15 microseconds; error texts print the trees, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn, Union

from lumped.errors import EquationError, shown
from lumped.language.arithmetic import Arithmetic
from lumped.language.pieces import Pieces

if TYPE_CHECKING:
    from lumped.language.quantity import Quantity

Number = Union["Expr", float, int]


class Expr(Arithmetic["Expr"]):
    """A node of an expression; combine with ``+ - * / **``, functions of `lumped.ops`, ``==``."""

    __slots__ = ()

    def children(self) -> tuple[Expr, ...]:
        """Operands, in order."""
        return ()

    @classmethod
    def operand(cls, value: object) -> Expr:
        """An expression from one or a number."""
        return as_expr(value)

    @classmethod
    def apply(cls, op: str, operands: tuple[object, ...]) -> Expr:
        """An operator or function applied to operands."""
        return Call(op, tuple(map(as_expr, operands)))

    def __eq__(self, other: object) -> Equation:  # type: ignore[override]
        return Equation(self, as_expr(other))

    def __ne__(self, other: object) -> NoReturn:
        raise EquationError(f"{self} != {other} is not an equation; write ==.")

    def __lt__(self, other: Number) -> Compare:
        return Compare(as_expr(other), self, strict=True)

    def __le__(self, other: Number) -> Compare:
        return Compare(as_expr(other), self)

    def __gt__(self, other: Number) -> Compare:
        return Compare(self, as_expr(other), strict=True)

    def __ge__(self, other: Number) -> Compare:
        return Compare(self, as_expr(other))

    __hash__ = object.__hash__

    def __bool__(self) -> NoReturn:
        raise EquationError(
            f"'{self}' has no truth value: it is a symbol, not a number. "
            "Use lumped.ops.where(condition, a, b) instead of 'if', and a plain typed field "
            "for a choice that changes the structure."
        )

    def __float__(self) -> NoReturn:
        raise EquationError(
            f"'{self}' is a symbol, not a number. Use the functions of lumped.ops "
            "(sin, cos, atan2, sqrt, ...) instead of those of math or numpy; where a plain number "
            "is needed, as in the fields of a component, no symbol can stand."
        )

    def __mod__(self, other: object) -> NoReturn:
        raise EquationError(
            f"'{self}' is a symbol, not a number: it has no remainder and is not rounded. Where a "
            "function repeats, lumped.ops.periodic_spline and sin do."
        )

    __rmod__ = __floordiv__ = __rfloordiv__ = __divmod__ = __mod__

    def __round__(self, digits: int = 0) -> NoReturn:
        self.__mod__(digits)

    __int__ = __float__
    __complex__ = __float__
    __index__ = __float__

    def __iter__(self) -> Iterator[Expr]:
        raise EquationError(f"'{self}' is one quantity and cannot be iterated over.")

    def __repr__(self) -> str:
        return text(self)


@dataclass(eq=False, repr=False, slots=True)
class ConstantExpression(Expr):
    """A number."""

    value: float


class Datum(ConstantExpression):
    """A number from a table, in the unit of its column."""

    __slots__ = ()


class Time(Expr):
    """The time."""

    __slots__ = ()


@dataclass(eq=False, repr=False, slots=True)
class Ref(Expr):
    """A quantity of a component instance: ``self.phi`` in a component, ``rig.shaft.tau`` outside.

    Attributes
    ----------
    owner : Component
        Instance that declares the quantity.
    name : str
        Name inside the owner, with the port's name in front for port quantities.
    quantity : Quantity
        Its declaration.
    """

    owner: Any
    name: str
    quantity: Quantity


@dataclass(eq=False, repr=False, slots=True)
class Call(Expr):
    """An operator or function applied to operands."""

    op: str
    args: tuple[Expr, ...]

    def children(self) -> tuple[Expr, ...]:
        """Operands, in order."""
        return self.args


@dataclass(eq=False, repr=False, slots=True)
class _Unary(Expr):
    """What is made of one expression."""

    of: Expr

    def children(self) -> tuple[Expr, ...]:
        """The expression."""
        return (self.of,)


class Der(_Unary):
    """Time derivative of an expression."""

    __slots__ = ()


@dataclass(eq=False, repr=False, slots=True)
class Partial(Expr):
    """Partial derivative of an expression by one quantity in it."""

    of: Expr
    by: Ref

    def children(self) -> tuple[Expr, ...]:
        """The expression and the quantity."""
        return (self.of, self.by)


@dataclass(eq=False, repr=False, slots=True)
class Compare:
    """The relation ``greater >= less``, or ``greater > less`` if strict.

    Events tell `words` while it holds and while it does not; without them, its sides.
    """

    greater: Expr
    less: Expr
    strict: bool = False
    words: tuple[str, str] | None = None

    def called(self, yes: str, no: str) -> Compare:
        """The same relation, of which events tell `yes` while it holds, else `no`."""
        return Compare(self.greater, self.less, self.strict, (yes, no))

    def __bool__(self) -> NoReturn:
        raise EquationError(
            f"'{self!r}' has no truth value: it changes during a run. "
            "Use lumped.ops.where(condition, a, b) instead of 'if', 'min', 'max' or 'and'."
        )

    def __and__(self, other: object) -> NoReturn:
        raise EquationError(
            f"'{self!r}' is a relation, not a number: it is not added, multiplied or joined by & "
            "and |. Write lumped.ops.where(condition, 1, 0), and one where inside the other for "
            "two conditions."
        )

    __or__ = __xor__ = __add__ = __sub__ = __mul__ = __truediv__ = __and__
    __rand__ = __ror__ = __rxor__ = __radd__ = __rsub__ = __rmul__ = __rtruediv__ = __and__

    def __invert__(self) -> NoReturn:
        self.__and__(self)

    def __repr__(self) -> str:
        return f"{text(self.greater)} {'>' if self.strict else '>='} {text(self.less)}"


@dataclass(eq=False, repr=False, slots=True)
class Where(Expr):
    """One of two expressions, chosen by a relation."""

    condition: Compare
    yes: Expr
    no: Expr

    def children(self) -> tuple[Expr, ...]:
        """Both sides of the relation, and what is chosen from."""
        return (self.condition.greater, self.condition.less, self.yes, self.no)


@dataclass(eq=False, repr=False, slots=True)
class Piecewise(Expr):
    """Piecewise polynomial of an expression.

    Attributes
    ----------
    of : Expr
        The argument.
    pieces : Pieces
        The polynomials.
    heights : tuple of Expr
        Values at the points of straight lines, if they are not numbers; the rows of `pieces` are
        then zeros.
    """

    of: Expr
    pieces: Pieces
    heights: tuple[Expr, ...] = ()

    def children(self) -> tuple[Expr, ...]:
        """The argument, then the heights."""
        return (self.of, *self.heights)


class Smooth(_Unary):
    """An expression whose kinks the user declares to be unimportant."""

    __slots__ = ()


@dataclass(eq=False, repr=False, slots=True)
class Equation:
    """``left == right``, to be yielded by ``equations()``.

    Attributes
    ----------
    left, right : Expr
        The sides.
    """

    left: Expr
    right: Expr

    __hash__ = None  # type: ignore[assignment]

    def __bool__(self) -> NoReturn:
        raise EquationError(
            f"the equation '{self!r}' was used as a truth value. Yield each equation by itself "
            "(a == b == c is two equations), and do not search lists of quantities with 'in'."
        )

    def __repr__(self) -> str:
        return f"{text(self.left)} == {text(self.right)}"


time = Time()
"""The time in seconds, as a symbol."""


def as_expr(value: object) -> Expr:
    """An expression from an expression or a number."""
    if isinstance(value, Expr):
        return value
    try:
        if isinstance(value, str):
            raise TypeError
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise EquationError(
            f"{shown(value)} of type {type(value).__name__} cannot stand in an equation; "
            "only quantities of the model and numbers can."
        ) from None
    if number != number:
        raise EquationError(
            "nan stands in an expression; only finite numbers have a meaning there."
        )
    return ConstantExpression(number)


def der(of: Expr) -> Expr:
    """Time derivative of an expression.

    Parameters
    ----------
    of : expression
        Expression to differentiate.

    Returns
    -------
    Expr

    Raises
    ------
    EquationError
        If `of` is not an expression of the model.
    """
    if not isinstance(of, Expr):
        raise EquationError(f"der({of!r}): only quantities of the model have a time derivative.")
    kinds = {leaf.quantity.kind for leaf in walk(of) if isinstance(leaf, Ref)}
    if kinds == {"parameter"} and not any(isinstance(leaf, Time) for leaf in walk(of)):
        raise EquationError(f"der({of!r}): a parameter is constant; its derivative is zero.")
    return Der(of)


def walk(root: Expr, closed: type[Expr] | None = None) -> Iterator[Expr]:
    """All nodes of an expression, operands before the node (no recursion limit).

    Operands of nodes of the type `closed` are left out.
    """
    stack: list[tuple[Expr, bool]] = [(root, False)]
    seen: set[int] = set()
    while stack:
        node, done = stack.pop()
        if done:
            yield node
        elif id(node) not in seen:
            seen.add(id(node))
            stack.append((node, True))
            if closed is None or not isinstance(node, closed):
                stack.extend((child, False) for child in reversed(node.children()))


_RANK = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3, "**": 4}


def text(root: Expr, name: Callable[[Ref], str] | None = None) -> str:
    """The expression as a user would write it, with names of references from a function."""
    name = name or (lambda ref: ref.name)
    done: dict[int, tuple[str, int]] = {}
    for node in walk(root):
        done[id(node)] = text_of_node(node, [done[id(c)] for c in node.children()], name)
    return done[id(root)][0]


def text_of_node(
    node: Expr, parts: list[tuple[str, int]], name: Callable[[Ref], str]
) -> tuple[str, int]:
    """Text of one node by those of its children, each with how strongly it binds."""
    if isinstance(node, ConstantExpression):
        return f"{node.value:g}", 5 if node.value >= 0 else 3
    if isinstance(node, Time):
        return "time", 5
    if isinstance(node, Ref):
        return name(node), 5
    if isinstance(node, Call) and node.op in _RANK:
        rank = _RANK[node.op]
        if node.op == "neg":
            operand, r = parts[0]
            return f"-{operand}" if r >= rank else f"-({operand})", rank
        (left, l_rank), (right, r_rank) = parts
        left = left if l_rank >= rank else f"({left})"
        right = right if r_rank > rank else f"({right})"
        space = "" if node.op == "**" else " "
        return f"{left}{space}{node.op}{space}{right}", rank
    inner = [p[0] for p in parts]
    if isinstance(node, Der):
        return f"der({inner[0]})", 5
    if isinstance(node, Piecewise):
        kind = "interpolate" if node.pieces.period is None else "periodic_spline"
        return f"{kind}({inner[0]})", 5
    if isinstance(node, Smooth):
        return f"smooth({inner[0]})", 5
    if isinstance(node, Partial):
        return f"d({inner[0]})/d({inner[1]})", 5
    if isinstance(node, Where):
        sign = ">" if node.condition.strict else ">="
        return f"where({inner[0]} {sign} {inner[1]}, {inner[2]}, {inner[3]})", 5
    if isinstance(node, Call):
        return f"{node.op}({', '.join(inner)})", 5
    return getattr(node, "name", "?"), 5
