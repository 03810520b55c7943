"""Measured curves that are laid over a run."""

from __future__ import annotations

import csv
import io
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.exchange.uff import read_uff
from lumped.support.units import convert_value

Column = tuple[str, str, np.ndarray]
"""Name, unit and values."""


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


def read_measured(system: System, path: str, held: bytes) -> Measured:
    """Curves in the content of a csv file or of a universal file.

    The first line of a csv file has names and units, ``time [s], shaft.tau [kN.m]``; the time
    stands first, and the others are quantities of the system. A unit in brackets may be left out
    where it is 1. In a universal file the first identification line is the name.

    Raises
    ------
    OptionError
        If the file is no such table, or its curves have not the same instants.
    UnknownNameError
        If a column is no quantity of the system.
    UnitError
        If a unit is of another dimension than its quantity.
    """
    ending = path.lower().rpartition(".")[2]
    if ending == "csv":
        t, columns = _of_csv(path, held)
    elif ending in ("uff", "unv"):
        t, columns = _of_uff(path, held)
    else:
        raise OptionError(
            f"{path}: measured curves are read from files that end in .csv, .uff or .unv."
        )
    if not (np.diff(t) > 0).all() or t[0] < 0:
        raise OptionError(f"{path}: times must increase, from 0 s or later.")
    curves = {}
    for name, given, values in columns:
        key = system.key(name)
        if key in curves:
            raise OptionError(f"{path}: {key} stands there twice.")
        curves[key] = _in_unit(values, given, system.quantity(name).unit, f"{path}: {name}")
    return Measured(t, curves)


def _of_uff(path: str, held: bytes) -> tuple[np.ndarray, list[Column]]:
    """Instants, and the curves over time."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / Path(path).name
        file.write_bytes(held)
        found = [curve for curve in read_uff(file).curves if curve.kind == "time"]
    if not found:
        raise OptionError(f"{path}: it has no curve over time (data set 58, time response).")
    t = found[0].x
    for curve in found[1:]:
        if not np.array_equal(curve.x, t):
            raise OptionError(
                f"{path}: {curve.name} has other instants than {found[0].name}; they must be equal."
            )
    return t, [(curve.name, curve.unit, curve.y) for curve in found]


def _of_csv(path: str, held: bytes) -> tuple[np.ndarray, list[Column]]:
    """Instants, and the columns beside them."""
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
    columns: list[Column] = []
    usual = ["s", *["1"] * (len(heads) - 1)]
    for head, own, values in zip(heads, usual, table.T, strict=True):
        name, mark, unit = head.strip().rpartition(" [")
        columns.append((name, unit.removesuffix("]"), values) if mark else (unit, own, values))
    (first, unit, t), *others = columns
    if first not in ("time", "t"):
        raise OptionError(f"{path}: the first column is '{first}'; the time [s] must stand there.")
    return _in_unit(t, unit, "s", f"{path}: time"), others


def _in_unit(values: np.ndarray, given: str, wanted: str, what: str) -> np.ndarray:
    if given == wanted:
        return values
    zero, one = (convert_value(f"{size} {given}", wanted, what) for size in (0.0, 1.0))
    return zero + (one - zero) * values
