"""The functions of a system as machine code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import casadi as ca

from lumped.kernel import code_cache
from lumped.kernel.emit_llvm import assembly
from lumped.kernel.loop import loop
from lumped.kernel.machine_code import Code, built
from lumped.kernel.start import begin, doubt
from lumped.kernel.translate import translated

__all__ = ["compiled_functions", "time_loop"]


def compiled_functions(
    inputs: Sequence[ca.SX], functions: Mapping[str, ca.Function], dense: bool = True
) -> Code:
    """Machine code of functions of the same four inputs.

    Parameters
    ----------
    inputs : sequence of SX
        States, parameters, time, settings.
    functions : mapping of str to Function
        Name under which each is found, and what it is.
    dense : bool
        Whether results of one column are written with their zeros; else as they are.

    Raises
    ------
    UnsupportedError
        If one cannot be had.
    """
    full = dict(functions)
    if dense:
        full = {name: _dense(inputs, function) for name, function in functions.items()}
    source = "\n".join(f"{name} {function.serialize()}" for name, function in full.items())

    def text() -> str:
        parts = [assembly(function, name) for name, function in full.items()]
        lines = "\n".join(parts).split("\n")
        declared = sorted({line for line in lines if line.startswith("declare")})
        return "\n".join([*(line for line in lines if not line.startswith("declare")), *declared])

    return built(code_cache.own() + source, list(full), text)


def _dense(inputs: Sequence[ca.SX], function: ca.Function) -> ca.Function:
    found = function.call(list(inputs))
    columns = [ca.densify(r) if r.columns() == 1 else r for r in found]
    return ca.Function(function.name(), list(inputs), columns)


@cache
def time_loop() -> Code:
    """Machine code of what a run does: the functions "loop", "begin" and "doubt"."""
    functions = {"loop": loop, "begin": begin, "doubt": doubt}
    return built(
        code_cache.own(), list(functions), lambda: translated(functions), code_cache.loop_name()
    )
