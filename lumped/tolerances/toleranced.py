"""Distributions from a table of tolerances."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from lumped.compiler.structure import Name
from lumped.ensembles.laws import Amount, Distribution, Law, Normal, Parameter, Triangular, Uniform
from lumped.errors import OptionError, shown
from lumped.flattening.tree import key_of
from lumped.support.arguments import checked

Kind = Literal["normal", "uniform", "triangular"]
_COLUMNS = ("name", "nominal", "tolerance", "distribution")
_SIGMAS = 3.0
"""Standard deviations of a normal distribution in a tolerance."""


@dataclass(frozen=True)
class Toleranced(Distribution):
    """About a nominal value, within a tolerance on both sides."""

    nominal: Amount | None
    tolerance: Amount
    kind: Kind

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        middle = of.nominal if self.nominal is None else of.value("nominal", self.nominal)
        assert middle is not None  # only factors have none
        width = self._share(of, middle)
        if width is None:
            width = of.width("tolerance", self.tolerance)
        if self.kind == "normal":
            return Normal(middle, width / _SIGMAS).law(of)
        if self.kind == "uniform":
            return Uniform(middle - width, middle + width).law(of)
        return Triangular(middle - width, middle, middle + width).law(of)

    def _share(self, of: Parameter, middle: float) -> float | None:
        """A tolerance in per cent of the nominal value."""
        if not (isinstance(self.tolerance, str) and self.tolerance.strip().endswith("%")):
            return None
        share = Parameter(of.name, "1", None).width(
            "tolerance in %", self.tolerance.strip().removesuffix("%").strip()
        )
        if not middle:
            of.refuse("a tolerance in % of a nominal value of zero is none. Give it with a unit.")
        return abs(middle) * share / 100


@checked
def toleranced(table: str | Path | Mapping[Name, Any]) -> dict[str, Distribution]:
    """Distributions of parameters from a table of nominal values and tolerances.

    Parameters
    ----------
    table : str, Path or mapping
        File of comma-separated values with the columns name, nominal, tolerance and distribution;
        or a mapping of name to (nominal, tolerance, distribution). Nominal values and tolerances
        are numbers in SI units or have a unit, such as ``70 kN.m/rad``; without a nominal value
        (an empty field, or None) it is that of the model. A tolerance counts to both sides and may
        be in % of the nominal value. Distributions are ``normal``, of which the tolerance is three
        standard deviations, so that 0.27 % lie outside, ``uniform`` and ``triangular``, of which
        it is the half width.

    Returns
    -------
    dict of str to Distribution
        For `over` of an ensemble or a scatter, which refuse what does not fit the parameter.

    Raises
    ------
    OptionError
        If a column or the file is missing, a name stands twice, or a distribution is none of these.
    """
    found: dict[str, Distribution] = {}
    for where, name, nominal, tolerance, kind in _rows(table):
        if name in found:
            raise OptionError(f"{where}: {name} stands twice. Give one tolerance.")
        if kind not in get_args(Kind):
            known = ", ".join(get_args(Kind))
            raise OptionError(f"{where}: {name} has the distribution {shown(kind)}; take {known}.")
        if tolerance in (None, ""):
            raise OptionError(f"{where}: {name} has no tolerance. Give it, or leave out the row.")
        found[name] = Toleranced(nominal, tolerance, kind)
    if not found:
        raise OptionError("toleranced: the table is empty; give a row for each parameter.")
    return found


def _rows(table: str | Path | Mapping[Name, Any]) -> list[tuple[str, str, Any, Any, Any]]:
    """Where each row stands, name, nominal value, tolerance and distribution."""
    if isinstance(table, Mapping):
        found = []
        for name, row in table.items():
            if not (isinstance(row, tuple | list) and len(row) == 3):
                raise OptionError(
                    f"toleranced: {key_of(name)} = {shown(row)}: (nominal, tolerance, "
                    "distribution) is needed."
                )
            found.append(("toleranced", key_of(name), *row))
        return found
    try:
        with Path(table).open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            missing = [name for name in _COLUMNS if name not in (reader.fieldnames or ())]
            if missing:
                raise OptionError(
                    f"toleranced: {table} has no column {missing[0]}; {', '.join(_COLUMNS)} are "
                    "needed, in the first line."
                )
            return [
                (f"toleranced: {table}, line {reader.line_num}", *_cells(row)) for row in reader
            ]
    except OSError as error:
        raise OptionError(f"toleranced: {table} cannot be read: {error.strerror}.") from None


def _cells(row: Mapping[str, str | None]) -> tuple[str, Any, Any, Any]:
    """Fields of a row; numbers without a unit are numbers."""
    name, *amounts, kind = ((row[column] or "").strip() for column in _COLUMNS)
    nominal, tolerance = (_number(text) for text in amounts)
    return name, None if nominal == "" else nominal, tolerance, kind


def _number(text: str) -> Amount:
    try:
        return float(text)
    except ValueError:
        return text
