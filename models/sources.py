"""Numbers of a machine's source, each with its unit, origin and meaning."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules

from lumped.models import MARKS


class Given(float):
    """A number together with its description in a report.

    It counts as a plain float; results of computing with it are plain floats.

    Parameters
    ----------
    value : float
        The number.
    unit : str
        Its unit.
    mark : {"P", "R", "I", "A"}
        Its origin, see `lumped.models.MARKS`.
    text : str
        Its meaning, and its symbol in the source if it has one there.

    Raises
    ------
    KeyError
        If there is no such mark.
    """

    unit: str
    mark: str
    text: str

    def __new__(cls, value: float, unit: str, mark: str, text: str) -> Given:
        MARKS[mark]
        found = super().__new__(cls, value)
        found.unit, found.mark, found.text = unit, mark, text
        return found

    def __getnewargs__(self) -> tuple[float, str, str, str]:  # type: ignore[override]
        return float(self), self.unit, self.mark, self.text


def constants(machine: str) -> list[Given]:
    """Numbers declared in the modules of a machine, each once, the printed ones first.

    Parameters
    ----------
    machine : str
        Name of the machine.

    Returns
    -------
    list of Given
    """
    found: dict[int, Given] = {}
    package = import_module(f"lumped.models.{machine}")
    names = sorted(module.name for module in iter_modules(package.__path__))
    for module in (package, *(import_module(f"{package.__name__}.{name}") for name in names)):
        for number in _numbers(vars(module).values()):
            found.setdefault(id(number), number)
    return sorted(found.values(), key=lambda number: list(MARKS).index(number.mark))


def _numbers(values: Iterable[object]) -> Iterator[Given]:
    for value in values:
        if isinstance(value, Given):
            yield value
        elif isinstance(value, Mapping):
            yield from _numbers(value.values())
        elif isinstance(value, tuple | list):
            yield from _numbers(value)
