"""The wrong models of all kinds, and the page docs/errors.md that shows their answers."""

import re
from functools import cache
from pathlib import Path

import pytest

from lumped.errors import LumpedError

from .connections import ports, signals
from .electric_drives import drives
from .friction import contact, friction, losses
from .mechanisms import cranks, mechanisms, winding
from .names import names, values
from .own_components import laws
from .runs import equilibria, runs, starts
from .shafts import couplings, shafts
from .supports import loops, loose, twice

CATALOGUE = Path(__file__).parents[2] / "docs" / "errors.md"

# In the order of the page.
KINDS = (
    twice,
    loops,
    loose,
    values,
    mechanisms,
    winding,
    shafts,
    losses,
    names,
    ports,
    signals,
    friction,
    drives,
    laws,
    starts,
    equilibria,
    runs,
    contact,
    cranks,
    couplings,
)
CASES = [case for kind in KINDS for case in kind.cases]

INTRODUCTION = """\
# Errors

<!-- Written by `python -m tests.wrong_models`. Do not edit. -->

Errors raised for invalid models, kind by kind. Every error is a `lumped.errors.LumpedError`.

How to read a text:

* The first line says what is wrong, and in which model.
* Paths lead from the top of the model to the part: `line.second.twist.c` is the stiffness of
  `twist`, in `second`, in `line`; `discs[1]` and `brakes["left"]` are held in a list and a
  dictionary. The class follows in brackets.
* Equations are shown as written, with full names, and where they are: *in* a part, or *at* the
  ports that a connection joins.
* Where equations and unknowns do not fit, there are always both: equations that determine something
  too often, and something that nothing determines. "Left after joining what is equal" counts the
  equations that remain when quantities that are simply equal have become one.
* The last line says what is likely meant, and what to do. Only it is a guess.

A part that is connected to nothing, or has all its ends in one place, is no error: the model is
computed, and a `lumped.errors.ModelWarning` names the part. Python's `warnings` turns it off, or
into an error.

Long numbers are rounded here.
"""
LONG = re.compile(r"-?\d+(\.\d{4,}(e[+-]\d+)?|(\.\d+)?e-\d+)")


@cache
def answer(case):
    """The error that a case raises."""
    with pytest.raises(LumpedError) as caught:
        case.make()
    return caught.value


def rounded(number):
    """A long number to three digits, and zero where it is rounding."""
    value = float(number[0])
    return f"{value:.3g}" if abs(value) > 1e-12 else "0"


def catalogue():
    """The text of docs/errors.md."""
    lines = [INTRODUCTION]
    for kind in KINDS:
        lines.append(f"## {kind.kind}\n")
        for case in kind.cases:
            error = answer(case)
            text = LONG.sub(rounded, f"{type(error).__name__}: {error}")
            lines.append(f"{case.mistake}\n\n```text\n{text}\n```\n")
    return "\n".join(lines)
