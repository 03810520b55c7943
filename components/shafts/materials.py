"""Materials of shafts by name."""

from __future__ import annotations

from typing import NamedTuple

from lumped.errors import UnknownNameError, nearest

__all__ = ["MATERIALS", "Material", "material_of_name"]


class Material(NamedTuple):
    """What torsion needs to know of a material."""

    G: float  # shear modulus, Pa
    rho: float  # density, kg/m3


MATERIALS = {
    "steel": Material(80e9, 7850.0),
    "cast iron": Material(45e9, 7200.0),
    "aluminium": Material(26e9, 2700.0),
    "titanium": Material(44e9, 4500.0),
}
"""Typical values; for others give `G` and `rho`.

Source: Pt Tensor, Typical material mechanical properties in engineering (web page). They lie in
the ranges of Gere, Mechanics of Materials, 5th ed., app. H (steels 75 to 80 GPa, cast iron 32 to
69, aluminium alloys 26 to 28, titanium alloys 39 to 44), as quoted by ah-engr.com. Cast iron varies
most.
"""


def material_of_name(name: str, owner: str) -> Material:
    """A material by its name.

    Parameters
    ----------
    name : str
        One of `MATERIALS`.
    owner : str
        Whose material it is, for texts.

    Raises
    ------
    UnknownNameError
        If there is none of this name; the text lists the nearest.
    """
    if name not in MATERIALS:
        raise UnknownNameError(
            f"{owner}: material = {name!r} is not known. {nearest(str(name), MATERIALS)} For "
            "another one give G and rho."
        )
    return MATERIALS[name]
