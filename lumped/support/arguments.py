"""Checks of the arguments of public functions against their annotations."""

from __future__ import annotations

import builtins
import inspect
import math
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import wraps
from typing import (
    Any,
    ForwardRef,
    Literal,
    ParamSpec,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numpy.typing import ArrayLike

from lumped.errors import OptionError, nearest, shown
from lumped.support.units import has_unit

P = ParamSpec("P")
R = TypeVar("R")

_FROM = {
    "Functional": "one of lumped.functionals, such as lumped.functionals.peak('shaft.tau')",
    "Compare": "a relation such as lumped.time >= 0.5",
    "Component": "a component or model",
    "Connection": "a connection, from lumped.connect or lumped.chain",
    "Equation": "an equation a == b",
    "Expr": "an expression",
    "Curve": "an S-N curve from lumped.life.SNCurve",
    "FrequencyResponse": "a response from lumped.frequency_response",
    "MeanStress": "a rule such as lumped.life.goodman('700 MPa')",
    "Modes": "modes from lumped.modes",
    "OrderResponse": "a response from lumped.vibration.order_response",
    "OperatingPoint": "an operating point from lumped.equilibrium or lumped.start_point",
    "Path": "a path",
    "Port": "a port",
    "PeriodicOrbit": "an orbit from lumped.periodic",
    "Condition": "a condition such as peak('shaft.tau') <= 300",
    "SNCurve": "an S-N curve from lumped.life.SNCurve",
    "System": "a system from lumped.assemble",
    "Trajectory": "a run from lumped.simulate",
}
"""Texts for errors: each kind of argument, and how to make it."""


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """A function that refuses arguments that do not fit its annotations.

    Numbers must be finite, a list of names must not be a text, a system not a model, and an
    operating point must belong to the system beside it. The function itself checks values of
    mappings, as they may have units. Types imported for type checkers only are compared by name.
    The signature shows each of ``**options: Unpack[Options]`` with its default, which the class of
    the options holds as ``name: Annotated[type, default]``.

    Raises
    ------
    OptionError
        When called with an unknown, missing or wrong argument, which the text names.
    """
    signature = _with_options(function)
    name = function.__qualname__.removesuffix(".__init__").replace(".__getitem__", "[]")
    several = [k for k, p in signature.parameters.items() if p.kind is p.VAR_POSITIONAL]
    known = [p for p in signature.parameters if p != "self"]
    plain = [k for k, p in signature.parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD]
    required = {k for k, p in signature.parameters.items() if p.default is p.empty}
    kinds = {p.kind for p in signature.parameters.values()}
    is_simple = kinds <= {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
    places = set(signature.parameters)
    only_several = several[0] if [*places] == several else ""
    hints: dict[str, Any] = {}
    is_sure: dict[str, Callable[[Any], bool]] = {}
    points: list[str] = []

    def check(given: dict[str, Any]) -> None:
        for key, value in given.items():
            if key in several:
                if not all(map(is_sure[key], value)):
                    given[key] = tuple(
                        _fitting(name, f"{key}[{i}]", v, hints[key]) for i, v in enumerate(value)
                    )
            elif key in hints and not is_sure[key](value):
                given[key] = _fitting(name, key, value, hints[key])
        _refuse_other_system(name, given, points)

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        if not hints and known:
            hints.update(_hints(function, signature))
            is_sure.update({key: _sure(hint) for key, hint in hints.items()})
            points.extend(key for key, hint in hints.items() if "OperatingPoint" in str(hint))
        if is_simple and len(args) <= len(plain) and kwargs.keys() <= places:
            # the same as below where nothing is wrong, in a tenth of the time
            given: dict[str, Any] = {**dict(zip(plain, args, strict=False)), **kwargs}
            if len(given) == len(args) + len(kwargs) and required <= given.keys():
                check(given)
                return function(**given)  # type: ignore[call-arg]
        if only_several and not kwargs:
            given = {only_several: args}
            check(given)
            return function(*given[only_several])  # type: ignore[call-arg]
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError as fault:
            unknown = [key for key in kwargs if key not in known]
            text = f"{fault}."
            if unknown:
                text = f"no option '{unknown[0]}'. {nearest(unknown[0], known)}"
            elif is_simple and len(args) > len(plain):
                ways = ", ".join(f"{key}=..." for key in known if key in required - {*plain})
                first = ", ".join(f"`{key}`" for key in plain if key != "self") or "none"
                text = (
                    f"by position only {first}, the others by name ({ways or known[-1] + '=...'})."
                )
            raise OptionError(f"{name}: {text}") from None
        check(bound.arguments)
        return function(*bound.args, **bound.kwargs)

    call.__signature__ = signature  # type: ignore[attr-defined]
    return call


def _with_options(function: Callable[..., Any]) -> inspect.Signature:
    """The signature of a function, with each of its options."""
    signature, parameters = inspect.signature(function), list[inspect.Parameter]()
    for p in signature.parameters.values():
        if p.kind is not p.VAR_KEYWORD or not str(p.annotation).startswith("Unpack["):
            parameters.append(p)
            continue
        options = function.__globals__[p.annotation[len("Unpack[") : -1]]
        for name, annotation in get_type_hints(options, include_extras=True).items():
            kind, default = get_args(annotation)
            parameters.append(
                inspect.Parameter(name, p.KEYWORD_ONLY, default=default, annotation=kind)
            )
    return signature.replace(parameters=parameters)


def _hints(function: Callable[..., Any], signature: inspect.Signature) -> dict[str, Any]:
    """Types of the arguments that can be checked."""
    names = _Names(vars(builtins) | function.__globals__)
    return {
        key: eval(p.annotation, {}, names) if isinstance(p.annotation, str) else p.annotation
        for key, p in signature.parameters.items()
        if p.kind is not p.VAR_KEYWORD and p.annotation is not p.empty
    }


def _sure(hint: Any) -> Callable[[Any], bool]:
    """Whether a value fits, found at once for what is given most; False if it must be looked at."""
    kinds = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    plain = {kind for kind in kinds if isinstance(kind, type) and kind is not np.ndarray}
    of_lumped = tuple(
        kind
        for kind in plain
        if kind.__module__.startswith("lumped.") and not getattr(kind, "_is_protocol", False)
    )
    if hint is ArrayLike:  # names texts and truth values too
        plain = {float}
    if float in plain:
        plain.add(int)
    texts = {text for kind in kinds if get_origin(kind) is Literal for text in get_args(kind)}
    members = {get_origin(kind): _sure(get_args(kind)[0]) for kind in kinds if get_args(kind)}
    of_list = members.get(Sequence, members.get(Iterable))
    values = [get_args(kind)[1] for kind in kinds if get_origin(kind) is Mapping]
    of_keys = members[Mapping] if values and not any(map(_is_looked_at, values)) else None

    def is_sure(value: Any) -> bool:
        kind = type(value)
        if kind is float:
            return float in plain and math.isfinite(value)
        if kind in plain:
            return True
        if isinstance(value, of_lumped):
            plain.add(kind)
            return True
        if kind is str:
            return value in texts
        of_each = of_keys if kind is dict else of_list if kind is list else None
        return of_each is not None and all(map(of_each, value))

    return is_sure


class _Names(dict[str, Any]):
    """Names of a module; one that only type checkers import is a class that holds its name."""

    def __missing__(self, key: str) -> Any:
        return type(key, (_Absent,), {})


class _Absent:
    """Base of classes that stand for others of the same name."""


def _fitting(function: str, key: str, value: Any, hint: Any) -> Any:
    """The value, iterators made lists.

    Raises
    ------
    OptionError
        If it does not fit.
    """
    if isinstance(value, Iterator):
        value = list(value)
    if _fits(value, hint):
        if isinstance(value, Mapping):
            _check_members(function, key, value, hint)
        return value
    raise OptionError(
        f"{function}: {key} = {shown(value)}: {_words(hint)} is needed.{_hint(value, hint)}"
    )


def _check_members(function: str, key: str, given: Mapping[Any, Any], hint: Any) -> None:
    """Refuse members that are no list or function in a mapping of such; numbers may have units.

    Raises
    ------
    OptionError
        With the key of the member.
    """
    for kind in (hint, *get_args(hint)):
        if get_origin(kind) is not Mapping:
            continue
        wanted = get_args(kind)[1]
        if _is_looked_at(wanted):
            for name, value in given.items():
                _fitting(function, f"{key}[{shown(name)}]", value, wanted)


def _is_looked_at(kind: Any) -> bool:
    """Whether members of a mapping are lists, functions, or of a class of lumped or a picture."""
    if kind is ArrayLike:
        return True
    several = {get_origin(one) for one in (kind, *get_args(kind))} & {Sequence, Callable}
    if several or not isinstance(kind, type):
        return bool(several)
    return issubclass(kind, _Absent) or kind.__module__.startswith("lumped.")


def _refuse_other_system(function: str, given: dict[str, Any], points: list[str]) -> None:
    """Refuse an operating point of another system, among the arguments that may be points.

    Raises
    ------
    OptionError
        If a point belongs to another system.
    """
    for key in points:
        value = given.get(key)
        if (
            value is not None
            and type(value).__name__ == "OperatingPoint"
            and "system" in given
            and value.system.structure.flat is not given["system"].structure.flat
        ):
            raise OptionError(
                f"{function}: {key} belongs to another system. Make the operating point with the "
                "system that is given."
            )


def _fits(value: Any, hint: Any) -> bool:
    if hint is Any:
        return True
    if hint is None or isinstance(hint, type | ForwardRef):
        return _is_a(value, hint)
    if hint is ArrayLike:
        return _numbers(value)
    origin, kinds = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        if float in kinds and str in kinds and has_unit(value):
            return True
        return any(_fits(value, one) for one in kinds)
    if origin is Literal:
        return (isinstance(value, str) or _is_a(value, int)) and value in kinds
    if origin in (Iterable, Sequence, tuple, list):
        return _fit_all(value, kinds)
    if origin is Mapping:
        return isinstance(value, Mapping) and all(_fits(k, kinds[0]) for k in value)
    return callable(value) if origin is Callable else True


def _is_a(value: Any, hint: Any) -> bool:
    """Whether a value is of a class, and finite if it is a number."""
    if hint is None or hint is type(None):
        return value is None
    if hint is float:
        return _real(value) and math.isfinite(value)
    if hint is int:
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    if hint is bool:
        return isinstance(value, bool | np.bool_)
    if hint is np.ndarray:
        return isinstance(value, np.ndarray) and _numbers(value)
    if isinstance(hint, ForwardRef) or issubclass(hint, _Absent):
        return _name_class(hint) in [cls.__name__ for cls in type(value).__mro__]
    if getattr(hint, "_is_protocol", False):
        return all(hasattr(value, name) for name in dir(hint) if not name.startswith("_"))
    return isinstance(value, hint)


def _real(value: Any) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def _fit_all(value: Any, kinds: tuple[Any, ...]) -> bool:
    """Whether all members of a list are of a kind."""
    if isinstance(value, str | bytes | Mapping):
        return False
    if isinstance(value, np.ndarray) and float in (kinds[0], *get_args(kinds[0])):
        return _numbers(value)
    try:
        members = list(value)
    except Exception:  # a foreign type may raise anything
        return False
    if len(kinds) > 1 and kinds[1] is not Ellipsis:
        return len(members) == len(kinds) and all(map(_fits, members, kinds))
    if str in (kinds[0], *get_args(kinds[0])) and all(type(member) is str for member in members):
        return True
    return all(_fits(member, kinds[0]) for member in members)


def _numbers(value: Any) -> bool:
    """Whether a value consists of finite numbers."""
    try:
        found = np.asarray(value)
    except (TypeError, ValueError):
        return False
    return found.dtype.kind in "iuf" and bool(np.isfinite(found).all())


def _words(hint: Any) -> str:
    """Text of the kind of argument that is needed."""
    origin, kinds = get_origin(hint), get_args(hint)
    if hint is ArrayLike or hint is np.ndarray:
        return "a list of finite numbers"
    if origin in (Union, types.UnionType):
        if _names(hint):
            return "a name such as 'motor.w'"
        parts = dict.fromkeys(_words(one) for one in kinds if one is not type(None))
        return " or ".join(parts)
    if origin is Literal:
        return f"one of {', '.join(map(repr, kinds))}"
    if origin in (Iterable, Sequence, tuple, list):
        if len(kinds) > 1 and kinds[1] is not Ellipsis:
            return f"a row of {len(kinds)}, each {_words(kinds[0])},"
        if get_origin(kinds[0]) is tuple and set(get_args(kinds[0])) <= {float, float | str}:
            return f"rows of {len(get_args(kinds[0]))} numbers"
        if kinds[0] is float:
            return "a list of finite numbers"
        return "a list of names" if _names(kinds[0]) else f"a list, each {_words(kinds[0])},"
    if origin is Mapping:
        return "a dictionary with names as keys, such as {'rotor.w': 100.0},"
    if origin is Callable:
        return "a function"
    simple = {float: "a finite number", int: "a whole number", bool: "True or False", str: "a text"}
    if hint in simple:
        return simple[hint]
    return _FROM.get(_name_class(hint), f"a {_name_class(hint)}")


def _name_class(hint: Any) -> str:
    """Name of a class, or of a class that does not exist yet."""
    return str(getattr(hint, "__forward_arg__", getattr(hint, "__name__", hint)))


def _names(hint: Any) -> bool:
    """Whether an annotation stands for names of quantities."""
    return hint is str or {_name_class(kind) for kind in get_args(hint)} == {
        "str",
        "Expr",
    }


def _hint(value: Any, hint: Any) -> str:
    """Text of the likely remedy."""
    kinds = [hint, *get_args(hint)]
    if any(getattr(kind, "__name__", "") == "System" for kind in kinds):
        if hasattr(type(value), "initial_equations"):
            return " This is a model: assemble it first, system = lumped.assemble(model)."
        if hasattr(value, "system"):
            return " Its system is its attribute `system`."
    if inspect.isclass(value):
        return " Write it with parentheses."
    lists = [kind for kind in kinds if get_origin(kind) in (Iterable, Sequence)]
    if any(_fits(value, get_args(kind)[0]) for kind in lists):
        return f" Write [{shown(value)}]."
    return ""
