"""Functions of a plant in machine code."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from lumped.code import code_cache
from lumped.code.emit_llvm import assembly
from lumped.code.machine_code import Code, built, kept
from lumped.code.operations import Operations

__all__ = ["compiled_functions", "known_functions"]


def _source(functions: Mapping[str, Operations]) -> str:
    parts = [f"{name} {function.key.hex()}" for name, function in functions.items()]
    return hashlib.sha256("\n".join([code_cache.own(), *parts]).encode()).hexdigest()


def _text(functions: Mapping[str, Operations]) -> str:
    parts = [assembly(function, name) for name, function in functions.items()]
    lines = "\n".join(parts).split("\n")
    declared = sorted({line for line in lines if line.startswith("declare")})
    return "\n".join([*(line for line in lines if not line.startswith("declare")), *declared])


def compiled_functions(functions: Mapping[str, Operations]) -> Code:
    """Machine code of functions, by their names."""
    return built(_source(functions), list(functions), lambda: _text(functions))


def known_functions(functions: Mapping[str, Operations]) -> Code | None:
    """Machine code of functions if it was made before, else None."""
    return kept(_source(functions), list(functions))
