"""Models and tables that the tests of shafts share."""

import csv
from pathlib import Path

from rows import in_a_row

import lumped as lp
from lumped.components import Disc, Fixed, Hollow, Keyed, Shaft, Solid, Splined, Taper, Torque

DATA = Path(__file__).parents[2] / "data" / "torsional" / "05_shaft_sections"
G, RHO = 80e9, 7850.0


def rows(name):
    with (DATA / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def metres(row, name):
    return float(row[f"{name}_mm"]) / 1e3


def section(row, **more):
    """The section of a row of sections.csv."""
    kind, L = row["kind"], metres(row, "length")
    sizes = {"L": L, **more}
    if row["bore_mm"]:
        sizes["bore"] = metres(row, "bore")
    if kind == "solid":
        return Solid(d=metres(row, "d1"), **sizes)
    if kind == "hollow":
        return Hollow(d=metres(row, "d1"), **sizes)
    if kind.startswith("taper"):
        return Taper(d_a=metres(row, "d1"), d_b=metres(row, "d2"), **sizes)
    if kind.startswith("keyed"):
        return Keyed(d=metres(row, "d1"), t=metres(row, "keyway_depth"), **sizes)
    if kind.startswith("flange"):
        return Disc(d=metres(row, "d1"), **sizes)
    assert kind == "spline"
    return Splined(d=metres(row, "d1"), d_root=metres(row, "d2"), **sizes)


def held(*parts, tau=0.0, **given):
    """A shaft that is held at flange a and loaded at flange b."""
    return in_a_row(wall=Fixed(), shaft=Shaft(sections=list(parts), **given), load=Torque(tau=tau))


def free(*parts, **given):
    """A shaft with open ends."""
    return lp.compose(shaft=Shaft(sections=list(parts), **given))
