"""Words of LLVM assembly."""

from __future__ import annotations

import struct

TYPES = {"int": "i64", "float": "double", "bool": "i1", "void": "void"}
INTEGER = {"+": "add", "-": "sub", "*": "mul", "/": "sdiv", "%": "srem"}
NUMBER = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
ORDER = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}
INTRINSIC = {
    **{name: name for name in ("sqrt", "fabs", "pow", "copysign")},
    "fmin": "minnum",
    "fmax": "maxnum",
}


def literal(value: float) -> str:
    """A number in LLVM assembly, to the last digit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
