"""Quantities of a component, declared once: unit, text, range, start and nominal value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import eq, ge, gt, le, lt
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Never, Self, overload

import numpy as np

from lumped.errors import DeclarationError
from lumped.language.expression import Expr, Number, Ref
from lumped.language.value_types import Value
from lumped.support.arguments import checked

StateWish = Literal["always", "prefer", "default", "avoid", "never"]
Limit = float | Expr | Callable[[Any], Number]
"""Lower end of a range; a function gives it for a component."""

Default = Number | Callable[[Any], Number | None]
"""Value of a parameter that is not given; a function gives it, or None, for a component."""


_LARGEST = 1e100
"""No quantity is larger in SI units; squares of it do not overflow."""


def beyond(value: float) -> str | None:
    """Why a number cannot be the value of any quantity, or None if it can."""
    if value != value or value in (float("inf"), float("-inf")):
        return "must be a finite number"
    if abs(value) > _LARGEST:
        return f"must be smaller than {_LARGEST:g}, so that its powers are finite"
    if 0 < abs(value) < 1 / _LARGEST:
        return f"must be zero or larger than {1 / _LARGEST:g}, so that one over it is finite"
    return None


def within(values: np.ndarray) -> bool:
    """Whether all numbers can be values of quantities (see `beyond`)."""
    size = np.abs(values)
    return bool(((size <= _LARGEST) & ((size >= 1 / _LARGEST) | (size == 0))).all())


class Quantity:
    """Declaration of a quantity.

    Attributes
    ----------
    unit : str
        SI unit, for example ``"N.m/rad"``; ``"1"`` without unit.
    text : str
        Meaning, in words.
    kind : {"parameter", "variable", "potential", "flow", "input", "output"}
        Its role.
    """

    kind = "variable"
    wish: StateWish = "default"
    start: Number = 0.0
    nominal: float = 1.0

    @checked
    def __init__(self, unit: str, text: str) -> None:
        self.unit = unit
        self.text = text
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name


class Bound(NamedTuple):
    """One end of a range, or zero where a parameter must not be zero.

    Attributes
    ----------
    words : str
        What a value must be, before the limit.
    sign : str
        The comparison with the limit that holds out of the range, in Python and in C.
    limit : float
    """

    words: str
    sign: str
    limit: float = 0.0

    def __str__(self) -> str:
        return "must not be zero" if self == NONZERO else f"must be {self.words} {self.limit:g}"

    @property
    def nearest(self) -> float:
        """The first number in the range."""
        inwards = {"<=": np.inf, ">=": -np.inf}.get(self.sign, self.limit)
        return float(np.nextafter(self.limit, inwards))


AT_LEAST, GREATER = Bound("at least", "<"), Bound("greater than", "<=")
AT_MOST, LESS = Bound("at most", ">"), Bound("less than", ">=")
NONZERO = Bound("not", "==")
_HOLDS = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq}


def _ends(bounds: list[Bound]) -> tuple[float, float]:
    """The least and the greatest number in a range."""
    least = (b.nearest for b in bounds if b.sign in ("<", "<="))
    most = (b.nearest for b in bounds if b.sign in (">", ">="))
    return max(least, default=-np.inf), min(most, default=np.inf)


class _Declared(Quantity):
    """A quantity that is an expression in an instance and itself in its class."""

    @overload
    def __get__(self, obj: None, owner: type) -> Self: ...
    @overload
    def __get__(self, obj: object, owner: type) -> Expr: ...
    def __get__(self, obj: Any, owner: type) -> Self | Expr:
        return self if obj is None else Ref(obj, self.name, self)

    if TYPE_CHECKING:  # its value is what constructors take; nothing can be assigned

        def __set__(self, obj: Never, value: Value) -> None: ...


@dataclass(eq=False, repr=False)
class Param(_Declared, Expr):
    """A parameter; in a class body it stands for itself in expressions that bind parts.

    Attributes
    ----------
    unit, text, default, min, max, above, below, nonzero, vibrates, amplitude_of
        As given to `param`.
    bounds : list of Bound
        The range, where its ends are numbers.
    lower : Bound
        What the value less `exceeds` must be.
    exceeds : expression or callable or None
        Lower end that is no number.
    least, most : float
        Ends of the range, which belong to it.
    """

    kind = "parameter"

    unit: str
    text: str
    default: Default | None
    min: Limit | None
    max: float | None
    above: Limit | None
    below: float | None
    nonzero: bool
    vibrates: bool
    amplitude_of: str

    def __post_init__(self) -> None:
        super().__init__(self.unit, self.text)
        self.exceeds: Limit | None = None
        self.lower = AT_LEAST
        if isinstance(self.min, Expr) or callable(self.min):
            self.exceeds, self.min = self.min, None
        if isinstance(self.above, Expr) or callable(self.above):
            self.exceeds, self.above, self.lower = self.above, None, GREATER
        ends = {AT_LEAST: self.min, GREATER: self.above, AT_MOST: self.max, LESS: self.below}
        found = [(bound, end) for bound, end in ends.items() if end is not None]
        self.bounds = [bound._replace(limit=float(end)) for bound, end in found]
        self.least, self.most = _ends(self.bounds)
        self.bounds += [NONZERO] * self.nonzero

    def fault(self, value: float) -> str | None:
        """Why `value` is out of range, or None if it is not."""
        broken = (str(b) for b in self.bounds if _HOLDS[b.sign](value, b.limit))
        return beyond(value) or next(broken, None)


class Var(_Declared):
    """An unknown of a component.

    Attributes
    ----------
    unit, text, start, nominal
        As given to `var`.
    wish : str
        Its `state` there.
    is_declared : bool
        Whether a start value was stated.
    """

    def __init__(
        self, unit: str, text: str, start: Number | None, nominal: float, state: StateWish
    ) -> None:
        super().__init__(unit, text)
        if not nominal > 0:
            raise DeclarationError(f"nominal value {nominal} of '{text}' must be positive.")
        self.start, self.is_declared = 0.0 if start is None else start, start is not None
        self.nominal = nominal
        self.wish = state


class Input(_Declared):
    """A signal that a component needs from outside: connected, or given to the instance.

    A signal connects like a port and occurs in equations like a quantity.

    Parameters
    ----------
    unit, text : str
        SI unit and meaning.
    min : float, optional
        Least value that may be given as a number.
    """

    kind = "input"

    @checked
    def __init__(self, unit: str, text: str, *, min: float | None = None) -> None:
        super().__init__(unit, text)
        self.min = min


class Output(_Declared):
    """A signal that a component determines.

    Parameters
    ----------
    unit, text : str
        SI unit and meaning.
    """

    kind = "output"

    if TYPE_CHECKING:

        def __set__(self, obj: Never, value: Never) -> None: ...  # type: ignore[override]


@checked
def param(
    unit: str,
    text: str,
    default: Default | None = None,
    *,
    min: Limit | None = None,
    max: float | None = None,
    above: Limit | None = None,
    below: float | None = None,
    nonzero: bool = False,
    vibrates: bool = False,
    amplitude_of: str = "",
) -> Param:
    """Declare a parameter.

    Parameters
    ----------
    unit, text : str
        SI unit and meaning.
    default : float, expression or function, optional
        Value if none is given; without it the parameter must be given. A function gives it for a
        component, where it depends on a structural choice or on what is beside the component.
    min, max : float, optional
        Range with its ends.
    above, below : float, optional
        Range without its ends. One of `min` and `above` may also be an expression of other
        parameters of the component, or a function that gives it for a component, where it depends
        on a structural choice.
    nonzero : bool
        Refuse zero.
    vibrates : bool
        It is the angular frequency of a vibration, rad/s, at which a law holds, such as that of a
        material whose loss depends on the frequency. Runs take its value; responses to a vibration
        of another frequency put that in its place.
    amplitude_of : str
        It is the amplitude, at which a law holds, with which this quantity of the component
        vibrates, such as its torque. Runs take its value; an order response finds it.

    Returns
    -------
    Param
    """
    return Param(unit, text, default, min, max, above, below, nonzero, vibrates, amplitude_of)


@checked
def var(
    unit: str,
    text: str,
    start: Number | None = None,
    *,
    nominal: float = 1.0,
    state: StateWish = "default",
) -> Var:
    """Declare an unknown.

    Parameters
    ----------
    unit, text : str
        SI unit and meaning.
    start : float or expression, optional
        Default value at the start, used if nothing else determines it; a value given to the
        instance must hold exactly. Zero if not stated, which yields to what others state.
    nominal : float
        Typical magnitude, in `unit`.
    state : {"always", "prefer", "default", "avoid", "never"}
        Preference for this quantity as a state of the reduced system.

    Returns
    -------
    Var
    """
    return Var(unit, text, start, nominal, state)
