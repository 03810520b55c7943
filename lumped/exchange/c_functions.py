"""Functions of CasADi as plain C functions."""

from __future__ import annotations

import re
from collections.abc import Sequence

import casadi as ca

__all__ = ["CFunction", "c_text"]

_HELPERS = re.compile(
    r"^(#ifndef casadi_(inf|nan)|casadi_real casadi_).*?(?=^/\* Configuration)",
    re.MULTILINE | re.DOTALL,
)
_BODY = re.compile(
    r"/\* (\w+):.*?\*/\nstatic int casadi_f\d+\(.*?\) \{\n(.*?)  return 0;\n\}\n", re.DOTALL
)


class CFunction:
    """A function of the model in C.

    Parameters
    ----------
    name : str
        Its name in C.
    inputs : sequence of SX
        Columns of symbols.
    results : sequence of SX
        Expressions; zeros are written out.
    arguments, outputs : sequence of str
        Names of both in C.
    """

    def __init__(
        self,
        name: str,
        inputs: Sequence[ca.SX],
        results: Sequence[ca.SX],
        arguments: Sequence[str],
        outputs: Sequence[str],
    ) -> None:
        self.name, self.arguments, self.outputs = name, tuple(arguments), tuple(outputs)
        dense = [ca.densify(r) for r in results]
        self.function = ca.Function(name, list(inputs), dense)

    @property
    def declaration(self) -> str:
        """Prototype without the semicolon."""
        given = [f"const double *{a}" for a in self.arguments]
        return f"void {self.name}({', '.join([*given, *(f'double *{o}' for o in self.outputs)])})"


def c_text(functions: Sequence[CFunction]) -> str:
    """C text of functions, without null tests and without what describes them to CasADi.

    The tests make as many branches as there are operations, which compilers take very long for.
    """
    generator = ca.CodeGenerator("model.c", {"casadi_int": "int"})
    for function in functions:
        generator.add(function.function)
    text = generator.dump()
    bodies = dict(_BODY.findall(text))
    parts = ["#include <math.h>", _helpers(text)]
    for function in functions:
        parts.append(_definition(function, bodies[function.name]))
    return "\n\n".join(parts) + "\n"


def _helpers(text: str) -> str:
    """Small functions and constants that CasADi's text uses."""
    found = _HELPERS.search(text)
    if found is None:
        return ""
    plain = found.group().replace("casadi_real casadi_", "static double casadi_")
    return plain.replace("casadi_real", "double").strip()


def _definition(function: CFunction, body: str) -> str:
    body = body.replace("casadi_real", "double")
    for i, name in enumerate(function.arguments):
        body = re.sub(rf"arg\[{i}\]\? arg\[{i}\]\[(\d+)\] : 0", rf"{name}[\1]", body)
    for i, name in enumerate(function.outputs):
        body = re.sub(rf"if \(res\[{i}\]!=0\) res\[{i}\]\[(\d+)\]=", rf"{name}[\1] = ", body)
    unused = ", ".join(f"(void){name}" for name in (*function.arguments, *function.outputs))
    return f"{function.declaration}\n{{\n  {unused};\n{body}}}"
