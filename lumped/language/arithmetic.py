"""Operators of expressions of quantities, and of what sums up a run."""

from __future__ import annotations

from typing import Any, Generic, Self, TypeVar

from lumped.errors import EquationError

T = TypeVar("T")


class Arithmetic(Generic[T]):
    """Operators ``+ - * / **``, for expressions of quantities and of what sums up a run."""

    __slots__ = ()

    @classmethod
    def operand(cls, value: object) -> T:
        """An operand from one or a number."""
        raise NotImplementedError

    @classmethod
    def apply(cls, op: str, operands: tuple[object, ...]) -> T:
        """An operator or function applied to operands."""
        raise NotImplementedError

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **_: Any) -> Any:
        """Let operators of numpy numbers use those of this class; refuse numpy's functions."""
        operator = _UFUNCS.get(ufunc.__name__)
        if operator is None or len(inputs) != 2:
            raise EquationError(
                f"numpy.{ufunc.__name__} cannot be applied to '{self}': it is a symbol. Use the "
                "functions of lumped.ops (sin, cos, atan2, sqrt, ...)."
            )
        return getattr(self.operand(inputs[0]), operator)(inputs[1])

    def __add__(self, other: T | float) -> T:
        return self.apply("+", (self, other))

    def __radd__(self, other: T | float) -> T:
        return self.apply("+", (other, self))

    def __sub__(self, other: T | float) -> T:
        return self.apply("-", (self, other))

    def __rsub__(self, other: T | float) -> T:
        return self.apply("-", (other, self))

    def __mul__(self, other: T | float) -> T:
        return self.apply("*", (self, other))

    def __rmul__(self, other: T | float) -> T:
        return self.apply("*", (other, self))

    def __truediv__(self, other: T | float) -> T:
        return self.apply("/", (self, other))

    def __rtruediv__(self, other: T | float) -> T:
        return self.apply("/", (other, self))

    def __pow__(self, other: T | float) -> T:
        return self.apply("**", (self, other))

    def __rpow__(self, other: T | float) -> T:
        return self.apply("**", (other, self))

    def __neg__(self) -> T:
        return self.apply("neg", (self,))

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> T:
        return self.apply("abs", (self,))


_UFUNCS = {
    "add": "__add__",
    "subtract": "__sub__",
    "multiply": "__mul__",
    "divide": "__truediv__",
    "power": "__pow__",
    "equal": "__eq__",
    "greater": "__gt__",
    "greater_equal": "__ge__",
    "less": "__lt__",
    "less_equal": "__le__",
}
