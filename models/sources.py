"""Numbers of a machine's source, with the marks that say how they are known."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["Constant", "constants"]

_MARK = re.compile(r"\[([PRIA])\]")


class Constant(NamedTuple):
    """A marked number.

    Attributes
    ----------
    name : str
        Name in the module, with the key if it stands in a table.
    value : float
        Its value.
    unit, mark, text : str
        Unit; "P" printed, "R" restored, "I" inferred or "A" assumed; what it is.
    """

    name: str
    value: float
    unit: str
    mark: str
    text: str


def constants(machine: str) -> list[Constant]:
    """Marked numbers in the modules of a machine, as its comments say.

    Parameters
    ----------
    machine : str
        Name of the machine.
    """
    found: list[Constant] = []
    for file in sorted(Path(__file__).parent.glob(f"{machine}*.py")):
        module = import_module(f"lumped.models.{file.stem}")
        found += _marked(file.read_text(encoding="utf-8"), vars(module))
    return found


def _marked(source: str, values: dict[str, Any]) -> Iterator[Constant]:
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    comments = {t.start[0]: t.string for t in tokens if t.type == tokenize.COMMENT}
    for node in ast.parse(source).body:
        if not isinstance(node, ast.Assign):
            continue
        comment = comments.get(node.lineno) or comments.get(node.end_lineno or 0) or ""
        mark = _MARK.search(comment)
        if mark is None:
            continue
        words = _MARK.sub("", comment.lstrip("# ")).strip(" ,").split(maxsplit=1)
        unit, text = [*words, "", ""][:2]
        for target in ast.walk(node.targets[0]):
            if isinstance(target, ast.Name):
                for name, value in _numbers(target.id, values[target.id]):
                    yield Constant(name, value, unit, mark[1], text.strip(" ,"))


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f"{name}[{key!r}]", inner)
    else:
        try:
            yield name, float(value)
        except (TypeError, ValueError):
            return
