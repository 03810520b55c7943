"""Functions of a plant in machine code."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping

from lumped.code.emit_llvm import assembly
from lumped.code.emit_taylor import series_assembly
from lumped.code.machine_code import Code, load_code, load_or_compile
from lumped.code.operations import FORMULAS, OWN, Operations
from lumped.code.sources import hash_of_all
from lumped.code.to_llvm import as_llvm


def _source(functions: Mapping[str, Operations], lanes: int = 1) -> str:
    parts = [f"{lanes}"] * (lanes > 1)
    parts += [f"{name} {function.key.hex()}" for name, function in functions.items()]
    return hashlib.sha256("\n".join([hash_of_all(), *parts]).encode()).hexdigest()


def _text(functions: Mapping[str, Operations], lanes: int) -> str:
    parts = [assembly(function, name, lanes) for name, function in functions.items()]
    if lanes > 1:
        parts.append(_own_text(functions, lanes))
    return _declare_once("\n".join(parts), functions.values() if lanes == 1 else ())


def _declare_once(text: str, calling: Iterable[Operations]) -> str:
    """Assembly with each declaration once, also of functions of ours that are called."""
    lines = text.split("\n")
    own = [f"declare double @{name}(double)" for name in _list_own(calling)]
    declared = sorted({line for line in lines if line.startswith("declare")} | {*own})
    return "\n".join([*(line for line in lines if not line.startswith("declare")), *declared])


def _list_own(functions: Iterable[Operations]) -> list[str]:
    """Functions of ours that are called."""
    used = {op for function in functions for op in function.table[:, 0].tolist()}
    formulas = "".join(FORMULAS.get(op, "") for op in used)
    return [name for name in OWN if name in formulas]


def _own_text(functions: Mapping[str, Operations], lanes: int) -> str:
    used = _list_own(functions.values())
    own = {name: OWN[name].widened if lanes > 1 else OWN[name] for name in used}
    return as_llvm(own, lanes, inline=lanes > 1) if own else ""


def compile_functions(functions: Mapping[str, Operations], lanes: int = 1) -> Code:
    """Machine code of functions, by their names, for one number or for several side by side."""
    source, prefix = _source(functions, lanes), "lanes-" if lanes > 1 else ""
    return load_or_compile(
        source,
        lambda: _text(functions, lanes),
        prefix,
        lambda: _own_text(functions, lanes) if lanes == 1 else "",
    )


def load_functions(functions: Mapping[str, Operations]) -> Code | None:
    """Machine code of functions if it was made before, else None."""
    return load_code(_source(functions))


def compile_columns(function: Operations, columns: int, columns_from: int) -> Code:
    """Machine code of a function named ``columns``, for columns side by side (see `emit_llvm`)."""
    return load_or_compile(
        _column_source(function, columns, columns_from),
        lambda: _declare_once(assembly(function, "columns", columns, columns_from), [function]),
        beside=lambda: _own_text({"columns": function}, 1),
    )


def load_columns(function: Operations, columns: int, columns_from: int) -> Code | None:
    """The same if it was made before, else None."""
    return load_code(_column_source(function, columns, columns_from))


def _column_source(function: Operations, columns: int, columns_from: int) -> str:
    parts = [hash_of_all(), f"{columns} {columns_from}", function.key.hex()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def compile_series(function: Operations, order: int, states: int, lanes: int = 1) -> Code:
    """Machine code of a function named ``series`` that gives Taylor coefficients of the states.

    Results of the function are the rates of the states, then what is integrated.

    Raises
    ------
    UnsupportedError
        If what varies goes through an operation without Taylor coefficients.
    """
    parts = [hash_of_all(), f"series {order} {states} {lanes}", function.key.hex()]

    def text() -> str:
        written = series_assembly(function, "series", order, states, lanes)
        used = {name: own for name, own in OWN.items() if f"@{name}(" in written}
        if used:
            own = {name: kernel if lanes == 1 else kernel.widened for name, kernel in used.items()}
            written += "\n" + as_llvm(own, lanes, inline=lanes > 1)
        return _declare_once(written, ())

    source = hashlib.sha256("\n".join(parts).encode()).hexdigest()
    return load_or_compile(source, text, "series-")
