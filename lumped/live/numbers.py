"""Numbers of a run that the page shows, and how it finds them in what the loop takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.functionals import Functional, highest, lowest
from lumped.language.expression import Call, ConstantExpression, Expr
from lumped.many_runs.watched import Watched


def find_numbers(
    system: System, names: Sequence[str], wanted: Iterable[Functional] | Mapping[str, Functional]
) -> dict[str, Functional]:
    """Those that are wanted, then the highest and lowest values of what is drawn, by their texts.

    Raises
    ------
    OptionError
        If one is named twice.
    """
    found: dict[str, Functional] = {}
    if isinstance(wanted, Mapping):
        found |= wanted
    else:
        for each in wanted:
            if str(each) in found:
                raise OptionError(f"{system.name}: live_page: {each} is named twice.")
            found[str(each)] = each
    for name in names:
        for each in (highest(name), lowest(name)):
            found.setdefault(str(each), each)
    return found


def rules(system: System, watched: Watched) -> list[dict[str, Any]]:
    """Text and unit of each number, and how it follows from what the loop takes."""
    return [
        {
            "text": label,
            "unit": wanted.unit(system),
            "missing": watched.missing(label),
            "places": [watched.place(reading)._asdict() for reading in wanted.readings],
            "formula": _javascript(wanted),
        }
        for label, wanted in watched.of.items()
    ]


def _javascript(functional: Functional) -> str:
    """A functional in JavaScript, of readings ``r[0], r[1], ...``."""
    places = {reading: f"r[{i}]" for i, reading in enumerate(functional.readings)}
    return functional.fold(places.__getitem__, _of_node)


def _of_node(node: Expr, operands: list[str]) -> str:
    if isinstance(node, ConstantExpression):
        return f"({node.value!r})"
    assert isinstance(node, Call)
    if node.op in ("+", "-", "*", "/"):
        return f"({node.op.join(operands)})"
    if node.op == "neg":
        return f"(-{operands[0]})"
    return f"Math.{'pow' if node.op == '**' else node.op}({', '.join(operands)})"
