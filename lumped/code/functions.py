"""Functions of a plant in machine code."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from lumped.code import code_cache
from lumped.code.emit_llvm import assembly
from lumped.code.machine_code import Code, built, kept
from lumped.code.operations import Operations

__all__ = ["compiled_functions", "known_functions"]


def _source(functions: Mapping[str, Operations], lanes: int = 1) -> str:
    parts = [f"{lanes}"] * (lanes > 1)
    parts += [f"{name} {function.key.hex()}" for name, function in functions.items()]
    return hashlib.sha256("\n".join([code_cache.own(), *parts]).encode()).hexdigest()


def _text(functions: Mapping[str, Operations], lanes: int = 1) -> str:
    parts = [assembly(function, name, lanes) for name, function in functions.items()]
    lines = "\n".join(parts).split("\n")
    declared = sorted({line for line in lines if line.startswith("declare")})
    return "\n".join([*(line for line in lines if not line.startswith("declare")), *declared])


def compiled_functions(functions: Mapping[str, Operations], lanes: int = 1) -> Code:
    """Machine code of functions, by their names, for one number or for several side by side."""
    source = _source(functions, lanes)
    return built(source, list(functions), lambda: _text(functions, lanes))


def known_functions(functions: Mapping[str, Operations]) -> Code | None:
    """Machine code of functions if it was made before, else None."""
    return kept(_source(functions), list(functions))
