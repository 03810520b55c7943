"""The language of the time loop as LLVM assembly (see `translate`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lumped.code.llvm_function import LlvmFunction
from lumped.code.translate import write_all


def as_llvm(
    functions: Mapping[str, Callable[..., object]],
    lanes: int = 1,
    counterparts: Mapping[Any, Any] | None = None,
    *,
    inline: bool = False,
) -> str:
    """LLVM assembly of functions and all that they call; they are visible under these symbols.

    Parameters
    ----------
    functions : mapping of str to kernel
    lanes : int
        Number of lanes of wide numbers.
    counterparts : mapping, optional
        What stands for a class of records or a kernel where numbers are wide.
    inline : bool
        Whether all of them are always written out where they are called.
    """
    kernels: Any = list(functions.values())
    own = dict(counterparts or {})
    kind = type("_Sized", (LlvmFunction,), {"lanes": lanes, "counterparts": own, "inline": inline})
    found: list[LlvmFunction] = write_all(kernels, lambda k: kind(k, k in kernels))
    declared = sorted({line for function in found for line in function.declared})
    text = "\n".join([*(function.text for function in found), *declared])
    for symbol, kernel in zip(functions, kernels, strict=True):
        text = text.replace(f'@"{kernel.name}"', f"@{symbol}")
    return text
