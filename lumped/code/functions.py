"""Functions of a plant in machine code."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from lumped.code.emit_llvm import assembly
from lumped.code.emit_taylor import series_assembly
from lumped.code.machine_code import Code, load_code, load_or_compile
from lumped.code.operations import OWN, Operations
from lumped.code.sources import hash_of_all
from lumped.code.to_llvm import as_llvm


def _source(*parts: str) -> str:
    return "\n".join([hash_of_all(), *parts])


def _compile(source: str, prefix: str, lanes: int, write: Callable[[], str]) -> Code:
    """Machine code of what is written, with the functions of ours that it calls.

    What is not optimised has them beside it: they are in any case.
    """

    def write_modules() -> tuple[str, ...]:
        text = write()
        used = {name: kernel for name, kernel in OWN.items() if f"@{name}(" in text}
        if not used:
            return (_declare_once(text),)
        if lanes > 1:
            used = {name: kernel.widened for name, kernel in used.items()}
        own = as_llvm(used, lanes, inline=lanes > 1)
        if prefix:
            return (_declare_once(f"{text}\n{own}"),)
        called = "\n".join(f"declare double @{name}(double)" for name in used)
        return _declare_once(f"{text}\n{called}"), own

    return load_or_compile(source, write_modules, prefix)


def _declare_once(text: str) -> str:
    """Assembly with each declaration once."""
    lines = text.split("\n")
    declared = sorted({line for line in lines if line.startswith("declare")})
    return "\n".join([*(line for line in lines if not line.startswith("declare")), *declared])


def _source_of(functions: Mapping[str, Operations], lanes: int = 1) -> str:
    return _source(f"{lanes}", *(f"{name} {f.key.hex()}" for name, f in functions.items()))


def compile_functions(functions: Mapping[str, Operations], lanes: int = 1) -> Code:
    """Machine code of functions, by their names, for one number or for several side by side."""

    def write() -> str:
        return "\n".join(assembly(function, name, lanes) for name, function in functions.items())

    return _compile(_source_of(functions, lanes), "lanes-" if lanes > 1 else "", lanes, write)


def load_functions(functions: Mapping[str, Operations]) -> Code | None:
    """Machine code of functions if it was made before, else None."""
    return load_code(_source_of(functions))


def compile_written(key: str, write: Callable[[], Operations], lanes: int) -> Code:
    """Machine code of a function named ``step`` that is written when it is needed."""
    source = _source(f"step {lanes}", key)
    return _compile(source, "", lanes, lambda: assembly(write(), "step", lanes, in_one=True))


def load_written(key: str, lanes: int) -> Code | None:
    """The same if it was made before, else None."""
    return load_code(_source(f"step {lanes}", key))


class Columns(NamedTuple):
    """Columns of the last states of a function, in which it is linear (see `emit_llvm`).

    Attributes
    ----------
    width : int
        How many.
    begin : int
        The first of these states.
    halved : int
        The first of the results of which only the first half of the columns is given.
    """

    width: int
    begin: int
    halved: int


def _source_of_columns(function: Operations, columns: Columns) -> str:
    return _source(" ".join(map(str, columns)), function.key.hex())


def compile_columns(function: Operations, columns: Columns) -> Code:
    """Machine code of a function named ``columns``, for columns side by side."""
    source = _source_of_columns(function, columns)
    return _compile(source, "", 1, lambda: assembly(function, "columns", *columns))


def load_columns(function: Operations, columns: Columns) -> Code | None:
    """The same if it was made before, else None."""
    return load_code(_source_of_columns(function, columns))


def compile_series(function: Operations, order: int, states: int, lanes: int = 1) -> Code:
    """Machine code of a function named ``series`` that gives Taylor coefficients of the states.

    Results of the function are the rates of the states, then what is integrated.

    Raises
    ------
    UnsupportedError
        If what varies goes through an operation without Taylor coefficients.
    """
    source = _source(f"series {order} {states} {lanes}", function.key.hex())
    return _compile(
        source, "series-", lanes, lambda: series_assembly(function, "series", order, states, lanes)
    )
