"""Measured curves that are laid over a run."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.support.units import converted

__all__ = ["Measured", "measured"]


@dataclass(frozen=True, eq=False)
class Measured:
    """Curves over time, in SI units.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Instants, s.
    curves : dict of str to ndarray of shape (n,)
        Quantities.
    """

    t: np.ndarray
    curves: dict[str, np.ndarray]


def measured(system: System, path: str, held: bytes) -> Measured:
    """Curves in the content of a csv file.

    Its first line has names and units, ``time [s], shaft.tau [kN.m]``; the time stands first, and
    the others are quantities of the system. A unit in brackets may be left out where it is 1.

    Raises
    ------
    OptionError
        If the file is no such table.
    UnknownNameError
        If a column is no quantity of the system.
    UnitError
        If a unit is of another dimension than its quantity.
    """
    if not path.lower().endswith(".csv"):
        raise OptionError(f"{path}: measured curves are read from files that end in .csv.")
    try:
        heads, *rows = csv.reader(io.StringIO(held.decode("utf-8-sig"), newline=""))
        table = np.array([row for row in rows if row], dtype=float).reshape(-1, len(heads))
    except ValueError as fault:
        raise OptionError(
            f"{path}: a line of names and lines of as many numbers, with commas between them, are "
            f"needed ({fault})."
        ) from None
    if len(table) < 2 or len(heads) < 2:
        raise OptionError(f"{path}: at least one quantity and two instants are needed.")
    if not np.isfinite(table).all():
        raise OptionError(f"{path}: every value must be finite.")
    first, *names = [head.rpartition(" [")[0] or head for head in map(str.strip, heads)]
    if first not in ("time", "t"):
        raise OptionError(f"{path}: the first column is '{first}'; the time [s] must stand there.")
    units = [head.strip().rpartition(" [")[2].removesuffix("]") for head in heads]
    t = _in_unit(table[:, 0], units[0] if heads[0].strip() != first else "s", "s", f"{path}: time")
    if not (np.diff(t) > 0).all() or t[0] < 0:
        raise OptionError(f"{path}: times must increase, from 0 s or later.")
    curves = {}
    for name, unit, head, column in zip(names, units[1:], heads[1:], table.T[1:], strict=True):
        wanted = system.quantity(name).unit
        given = unit if head.strip() != name else "1"
        key = system.key(name)
        if key in curves:
            raise OptionError(f"{path}: {key} stands there twice.")
        curves[key] = _in_unit(column, given, wanted, f"{path}: {name}")
    return Measured(t, curves)


def _in_unit(values: np.ndarray, given: str, wanted: str, what: str) -> np.ndarray:
    if given == wanted:
        return values
    zero, one = (converted(f"{size} {given}", wanted, what) for size in (0.0, 1.0))
    return zero + (one - zero) * values
