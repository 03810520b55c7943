"""Controllers and other parts from units of FMI, asked at samples."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from lumped import Component, Input, Output, der, param, var
from lumped.components.control.sampled import _Clocked
from lumped.errors import DeclarationError, OptionError, shown
from lumped.language.declared import place_of, values_of
from lumped.language.expression import Expr
from lumped.language.program import Program, question
from lumped.language.switch import Item

if TYPE_CHECKING:
    from lumped.exchange.unit_description import Signal

__all__ = ["from_fmu"]


def from_fmu(
    path: str | Path,
    *,
    kind: Literal["co_simulation", "model_exchange"] | None = None,
    outputs: Iterable[str] = (),
    units: Mapping[str, str] | None = None,
    rtol: float = 1e-10,
    **values: Any,
) -> Component:
    """A component that a unit of FMI 2.0 or 3.0 computes, such as a controller of another tool.

    At ``start_time + k T_s`` the unit goes on by `T_s` with the inputs of the sample before, takes
    the inputs of now, and gives its outputs, which are held until the next sample. Its events are
    dealt with between. The states of a unit for model exchange are integrated by CVode. Values that
    enter and leave are in SI units; what the file defines otherwise is converted. Inputs, outputs
    and parameters have the names of the file; where these are no names in Python, other characters
    become ``_``, so that ``axis.k[1]`` is ``axis_k_1``. Elements of an array are numbered from 1.
    Texts are not exchanged.

    The unit runs in a process of its own. If its binary crashes, the run ends with an error and
    keeps what was computed. Whatever needs equations of all parts, such as derivatives of runs,
    equilibria, periodic motions and exports, is refused.

    Parameters
    ----------
    path : str or Path
        The file, with a binary for this machine.
    kind : {"co_simulation", "model_exchange"}, optional
        How it is run; the first that it has unless given.
    outputs : iterable of str
        Variables, by their names in the file, that are outputs beside those that it calls so.
    units : mapping of str to str
        Units of variables, by their names in the file, where it does not define them.
    rtol : float
        Relative tolerance with which the unit solves its own equations.
    **values
        As for any component: inputs, parameters, and `T_s`, s, which is the step that the file
        asks for unless given.

    Returns
    -------
    Component

    Raises
    ------
    DeclarationError
        If the file is no such unit, has no binary for this machine, has clocks, or does not define
        a unit.
    UnknownNameError
        If it has no such input or parameter.
    OptionError
        If FMPy is not installed, or `rtol` makes no sense.

    Notes
    -----
    Source: Functional Mock-up Interface 2.0.5 and 3.0.2. Needs FMPy (``lumped[fmi]``).
    """
    if not 1e-14 <= rtol < 1:
        raise OptionError(f"from_fmu: rtol = {rtol!r}: it must lie between 1e-14 and 1.")
    given = str(path), kind, tuple(outputs), tuple(sorted((units or {}).items())), rtol
    return _class_of(_Source(*given))(**values)


class _Source:
    """Which unit, and how; equal if the file and all else are the same."""

    def __init__(
        self,
        path: str,
        kind: str | None,
        outputs: tuple[str, ...],
        units: tuple[tuple[str, str], ...],
        rtol: float,
    ) -> None:
        from lumped.exchange.unit_description import describe_unit

        self.unit = describe_unit(path, kind, outputs, dict(units), rtol)
        self.given = str(self.unit.path), kind, outputs, units, rtol
        self._all = *self.given, self.unit.content

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Source) and self._all == other._all

    def __hash__(self) -> int:
        return hash(self._all)


class _Unit(_Clocked):
    """What components of units have.

    Each value of an input, output or parameter has a name of its own. Choices are parameters that
    are fixed in a model, with their names in the file.
    """

    _source: ClassVar[_Source]
    _inputs: ClassVar[Sequence[str]]
    _outputs: ClassVar[Sequence[str]]
    _numbers: ClassVar[Sequence[str]]
    _choices: ClassVar[Mapping[str, str]]

    def equations(self) -> Iterator[Item]:
        for name in self._outputs:
            yield der(getattr(self, _name_held(name))) == 0
            yield getattr(self, name) == getattr(self, _name_held(name))
        fixed = tuple((old, self._check_fixed(new, old)) for new, old in self._choices.items())
        told: list[Expr] = [self.count, self.start_time + self.count * self.T_s]
        told += [getattr(self, name) for name in (*self._numbers, *self._inputs)]
        answers = [getattr(self, _name_held(name)) for name in self._outputs]
        yield from self._count_samples({}, question(_program(self._source, fixed), told, answers))

    def _check_fixed(self, name: str, named: str) -> Any:
        """Value of what is fixed."""
        value, (_, kind, default) = getattr(self, name), self._source.unit.fixed[named]
        if type(value) is not type(default):
            raise DeclarationError(
                f"{self._label()}: {name} = {shown(value)}: the unit takes a value of type {kind}."
            )
        return value

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        return _again, (self._source.given, dict(values_of(self)), place_of(self))


def _again(given: tuple[Any, ...], values: dict[str, Any], place: Any) -> Component:
    """The component in another process."""
    path, kind, outputs, units, rtol = given
    made = from_fmu(path, kind=kind, outputs=outputs, units=dict(units), rtol=rtol, **values)
    object.__setattr__(made, "_place", place)
    return made


@lru_cache(100)
def _program(source: _Source, fixed: tuple[tuple[str, Any], ...]) -> Program:
    from lumped.exchange.imported_unit import UnitProgram

    return UnitProgram(source.unit, dict(fixed))


def _name_held(name: str) -> str:
    return f"held_{name}"


@lru_cache(100)
def _class_of(source: _Source) -> type[_Unit]:
    """The class of components of a unit."""
    unit = source.unit
    names = _Names()
    inputs = [(name, s, i) for s in unit.inputs for i, name in names.of(s)]
    outputs = [(name, s, i) for s in unit.outputs for i, name in names.of(s)]
    numbers = [(name, s, i) for s in unit.parameters for i, name in names.of(s)]
    choices = {names.plain(old): old for old in unit.fixed}
    members: dict[str, Any] = {
        "__doc__": f"{unit.text or unit.name}\n\nA unit of FMI, {unit.path.name}.",
        "__module__": __name__,
        "__annotations__": {new: type(unit.fixed[old][2]) for new, old in choices.items()},
        "T_s": param("s", "sampling time", unit.step, above=0),
        "_source": source,
        "_inputs": [name for name, *_ in inputs],
        "_outputs": [name for name, *_ in outputs],
        "_numbers": [name for name, *_ in numbers],
        "_choices": choices,
    }
    members |= {name: Input(s.unit, s.text or s.name) for name, s, _ in inputs}
    members |= {name: Output(s.unit, s.text or s.name) for name, s, _ in outputs}
    for name, s, i in outputs:
        first = s.start[i] if s.start else 0.0
        members[_name_held(name)] = var(
            s.unit, f"{name} since the last sample", first, state="always"
        )
    for name, s, i in numbers:
        default = s.start[i] if s.start else None
        members[name] = param(s.unit, s.text or s.name, default, min=s.least, max=s.largest)
    members |= {new: unit.fixed[old][2] for new, old in choices.items()}
    return type(_identifier(unit.name), (_Unit,), members)


class _Names:
    """Names of variables in Python, each once."""

    def __init__(self) -> None:
        self._taken = {*dir(_Unit), "symbol"}

    def of(self, signal: Signal) -> list[tuple[int, str]]:
        """Places and names of the values of a signal."""
        if signal.variable[2] == 1:
            return [(0, self.plain(signal.name))]
        return [(i, self.plain(f"{signal.name}_{i + 1}")) for i in range(signal.size)]

    def plain(self, name: str) -> str:
        """A name that no other has."""
        found = _identifier(name)
        while found in self._taken:
            found += "_"
        self._taken |= {found, _name_held(found)}
        return found


def _identifier(name: str) -> str:
    found = re.sub(r"\W+", "_", name).strip("_") or "unit"
    return f"n{found}" if found[0].isdigit() else found
