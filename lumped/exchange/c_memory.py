"""The memory of a run in C: the records of the time loop with all that they point to."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lumped.code.operations import Operations
from lumped.code.records import Field, Record
from lumped.kernel.cycles import Count
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.instant_search import InstantSearch
from lumped.kernel.plant import Function, Plant
from lumped.kernel.roots import Bracket
from lumped.kernel.run import Matrix, Pattern, Run, RunOutput
from lumped.kernel.watch import Watch

_ROWS = _PIECES = 8
"""Room for rows and pieces: the loop returns as soon as one row is recorded."""

_OF_WATCH = ("enclosed_extremes", "enclosed_loads")
_RECORDS: dict[str, type[Record]] = {
    "run": Run,
    "instant": InstantSearch,
    **{name: f.kind for name, f in InstantSearch.fields.items() if isinstance(f.kind, type)},
    "output": RunOutput,
    "enclosed_margins": Enclosed,
    "enclosed_rates": Enclosed,
    "bracket": Bracket,
    **dict.fromkeys(_OF_WATCH, Enclosed),
    "matrix": Matrix,
    "pattern": Pattern,
    "plant": Plant,
    "watch": Watch,
    "count": Count,
}
_UNWATCHED = dict.fromkeys(Watch.lengths() | Count.lengths(), 0)
"""Lengths where no functionals are collected."""
_FUNCTIONS = [f.name for kind in (Plant, Watch) for f in kind.fields.values() if f.kind is Function]
_OUTPUT = {
    "t": "rows",
    "x": "rows * states",
    "implicit": "rows * implicit",
    "piece_row": "pieces",
    "piece_settings": "pieces * modes",
    "change": "4 * changes",
    "change_time": "2 * changes",
    "grid": "3",
}
_SEGMENTS = {"edges": "3", "timed_values": "2 * timed"}


class Memory:
    """One block for a run; as all lengths are known, it is no more than a struct.

    Parameters
    ----------
    sizes : mapping of str to int
        What the lengths of fields are made of.
    values : mapping of str to mapping of str to int or ndarray
        For some records what their fields hold: numbers, and tables that do not change.
    functions : iterable of str
        Functions of the plant and of functionals that there are.
    enclosed : mapping of str to Operations
        Those whose operations are read, as they are enclosed.
    watch : Watch, optional
        What functionals take from a run; what it holds besides zeros does not change.
    """

    def __init__(
        self,
        sizes: Mapping[str, int],
        values: Mapping[str, Mapping[str, int | np.ndarray]],
        functions: list[str],
        enclosed: Mapping[str, Operations],
        watch: Watch | None = None,
    ) -> None:
        changes = sizes["conditions"] + sizes["holds"] + 1
        modes = sizes["settings"] - sizes["implicit"]
        more = {"rows": _ROWS, "pieces": _PIECES, "changes": changes, "modes": modes}
        watched = {} if watch is None else _lengths(watch) | _lengths(watch.count)
        self._sizes = {**_UNWATCHED, **sizes, **watched, **more, "work": 1, "prepared": 0}
        self._counts = {"numbers": 0, "integers": 0}
        self._functions = functions
        self.tables: list[str] = []
        self._lines: list[str] = []
        given = dict(values)
        if watch is not None:
            given |= {"watch": _find_held(watch), "count": _find_held(watch.count)}
            given["enclosed_extremes"] = {"results": watch.extremes}
            given["enclosed_loads"] = {"results": watch.loads}
        for name, kind in _RECORDS.items():
            if watch is not None or name not in _OF_WATCH:
                for field in kind.fields.values():
                    self._field(name, field, given.get(name, {}))
        for name, operations in enclosed.items():
            self._operations(name, operations)
        limits = {"most_rows": _ROWS, "most_pieces": _PIECES, "most_changes": changes}
        self._lines += [f"    memory->output.{name} = {n};" for name, n in limits.items()]

    def _field(self, record: str, field: Field, values: Mapping[str, int | np.ndarray]) -> None:
        place, name = f"memory->{record}.{field.name}", field.name
        if isinstance(field.kind, type):
            if field.kind is Function and record not in ("plant", "watch"):
                return
            if field.kind is Function:
                self._lines.append(f"    {place} = &memory->functions[FUNCTION_{name}];")
            else:
                self._lines.append(f"    {place} = &memory->{name};")
        elif name in values:
            self._give(record, field, values[name])
        elif field.kind in ("numbers", "ints"):
            given = _OUTPUT if record == "output" else _SEGMENTS if record == "run" else {}
            length = field.length or given.get(name, "")
            if length:
                block = "numbers" if field.kind == "numbers" else "integers"
                first = self._counts[block]
                self._lines.append(f"    {place} = memory->{block} + {first};")
                self._counts[block] += int(eval(length, {"max": max}, self._sizes))

    def _operations(self, name: str, operations: Operations) -> None:
        place = f"memory->functions[FUNCTION_{name}]"
        held = {"operations": operations.table.ravel(), "constants": operations.constants}
        for field, value in held.items():
            kind = "int64_t" if field == "operations" else "double"
            self._table(kind, f"{name}_{field}", value)
            self._lines.append(f"    {place}.{field} = ({kind} *){name}_{field};")
        self._lines.append(f"    {place}.count = {len(operations.table)};")

    def _table(self, kind: str, symbol: str, value: np.ndarray) -> None:
        listed = ", ".join(repr(v) for v in [*value.tolist(), 0])
        listed = listed.replace("inf", "INFINITY").replace("nan", "NAN")
        self.tables.append(f"static const {kind} {symbol}[] = {{{listed}}};")

    def _give(self, record: str, field: Field, value: int | np.ndarray) -> None:
        place = f"memory->{record}.{field.name}"
        if isinstance(value, np.ndarray) and not value.any():
            block = "numbers" if field.kind == "numbers" else "integers"
            self._lines.append(f"    {place} = memory->{block} + {self._counts[block]};")
            self._counts[block] += len(value)
        elif isinstance(value, np.ndarray):
            kind, symbol = "double" if field.kind == "numbers" else "int64_t", field.name
            self._table(kind, f"{record}_{symbol}", value)
            self._lines.append(f"    {place} = ({kind} *){record}_{symbol};")
        else:
            self._lines.append(f"    {place} = {value};")

    @property
    def declaration(self) -> str:
        """The struct."""
        records = [f"    {kind.__name__} {name};" for name, kind in _RECORDS.items()]
        listed = ",\n".join(f"    FUNCTION_{name}" for name in _FUNCTIONS)
        head = "/* A run with all that it points to; a copy is whole as soon as it is bound. */"
        return "\n".join(
            [
                f"enum {{\n{listed}\n}};\n",
                head,
                "typedef struct {",
                *records,
                f"    Function functions[{len(_FUNCTIONS)}];",
                f"    double numbers[{max(self._counts['numbers'], 1)}];",
                f"    int64_t integers[{max(self._counts['integers'], 1)}];",
                "} Memory;\n",
                "void model_bind(Memory *memory);\n",
            ]
        )

    @property
    def definition(self) -> str:
        """The function that lets all point to where it is."""
        addresses = [
            f"    memory->functions[FUNCTION_{name}].address = (int64_t)(intptr_t)model_{name};"
            for name in self._functions
        ]
        head = ["void model_bind(Memory *memory)", "{"]
        return "\n".join([*self.tables, "", *head, *self._lines, *addresses, "}\n"])


def _lengths(record: Record) -> dict[str, int]:
    """Sizes of the arrays of a record that it knows itself."""
    return {name: getattr(record, name) for name in record.lengths() if name in record.fields}


def _find_held(record: Record) -> dict[str, int | np.ndarray]:
    """Counts, tables, and arrays whose length only the record knows."""
    found: dict[str, int | np.ndarray] = {}
    for field in record.fields.values():
        value = getattr(record, field.name)
        if isinstance(value, np.ndarray):
            if value.any() or not field.length:
                found[field.name] = value
        elif isinstance(value, int) and value:
            found[field.name] = value
    return found
