"""Stresses of flank and root of a pair of cylindrical gears, and their safety.

Source: ISO 6336-2:1996 and ISO 6336-3:1996, Calculation of load capacity of spur and helical gears,
with one load factor for application, speed and distribution of the load.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, pi
from typing import Any, TypeVar

from lumped.errors import OptionError
from lumped.functionals.functional import Functional
from lumped.language.arithmetic import Arithmetic
from lumped.language.expression import Expr
from lumped.life.gear_pair import GearPair
from lumped.ops import sqrt
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table

Load = TypeVar("Load", float, Functional, Expr)

STEEL = (2.06e11, 0.3)
"""Modulus of elasticity, Pa, and Poisson's ratio."""


def contact_stress(
    pair: GearPair,
    torque: Load,
    *,
    load_factor: float = 1.0,
    pinion: tuple[float, float] = STEEL,
    wheel: tuple[float, float] = STEEL,
) -> Load:
    """Contact stress of the flanks, Pa, to be compared with the strength against pitting.

    ``Z_E Z_H Z_eps Z_beta sqrt(2 K T (u + 1) / (b d^2 u))``

    Parameters
    ----------
    pair : GearPair
        The gears.
    torque : float, Functional or expression
        T of the pinion, N.m, at least 0: a number, one of a run, such as its `equivalent_load`, or
        an expression of its quantities.
    load_factor : float
        K, for what makes the load of the teeth larger than that of the torque.
    pinion, wheel : (float, float)
        Modulus of elasticity, Pa, and Poisson's ratio; default is steel.

    Returns
    -------
    float, Functional or expression
        Of the kind of the torque.
    """
    yielding = sum((1 - nu**2) / modulus for modulus, nu in (pinion, wheel))
    factors = pair.zone_factor * pair.contact_ratio_factor * pair.helix_factor
    size = float(pair.width) * pair.diameters[0] ** 2 * pair.ratio
    square = 2 * load_factor * (pair.ratio + 1) / (size * pi * yielding) * torque
    found: Load = factors * (sqrt(square) if isinstance(square, Arithmetic) else square**0.5)
    return found


def root_stress(
    pair: GearPair, torque: Load, *, form: float, correction: float, load_factor: float = 1.0
) -> Load:
    """Stress in the root of the teeth of one gear, Pa, to be compared with its strength.

    ``2 K T Y_F Y_S Y_eps Y_beta / (b d m)``

    Parameters
    ----------
    pair : GearPair
        The gears.
    torque : float, Functional or expression
        T of the pinion, N.m, also for the root of the wheel; see `contact_stress`.
    form, correction : float
        Y_F and Y_S of the gear, from the charts for its `virtual_teeth`.
    load_factor : float
        K, for what makes the load of the teeth larger than that of the torque.

    Returns
    -------
    float, Functional or expression
        Of the kind of the torque.
    """
    factors = form * correction * pair.root_ratio_factor * pair.root_helix_factor
    size = float(pair.width) * pair.diameters[0] * float(pair.module)
    return 2 * load_factor * factors / size * torque


@checked
def least_module(
    torque: float,
    *,
    teeth: int,
    width: float,
    shape: float,
    strength: float,
    load_factor: float = 1.0,
    helix: float = 0.0,
) -> float:
    """Least module at which the root carries a torque, m.

    ``cbrt(2 K T cos^2 beta Y / (psi z^2 sigma))``

    Parameters
    ----------
    torque : float
        T of the pinion, N.m.
    teeth : int
        z of the pinion.
    width : float
        psi, width of the teeth over the reference diameter of the pinion.
    shape : float
        Y, product of the factors Y_F, Y_S, Y_eps and Y_beta of the gear with the larger one.
    strength : float
        sigma, permitted stress in the root, Pa.
    load_factor : float
        K, for what makes the load of the teeth larger than that of the torque.
    helix : float
        beta, helix angle, rad.

    Returns
    -------
    float

    Raises
    ------
    OptionError
        If a number is not positive.
    """
    if not min(torque, teeth, width, shape, strength, load_factor) > 0:
        raise OptionError("least_module: all numbers but the helix must be positive.")
    load = 2 * load_factor * torque * cos(helix) ** 2 * shape
    return float((load / (width * teeth**2 * strength)) ** (1 / 3))


@dataclass(frozen=True)
class GearStrength:
    """What the teeth of a pair stand.

    Parameters
    ----------
    contact : float
        Strength of the flanks of the weaker gear, Pa.
    root : (float, float)
        Strength of the roots of pinion and wheel, Pa.
    form, correction : (float, float)
        Factors Y_F and Y_S of pinion and wheel, from the charts for their `virtual_teeth`.
    load_factor : float
        K, for what makes the load of the teeth larger than that of the torque.
    """

    contact: float
    root: tuple[float, float]
    form: tuple[float, float]
    correction: tuple[float, float]
    load_factor: float = 1.0


@dataclass(frozen=True)
class GearSafety:
    """Stresses of a pair under a torque, and strengths over them.

    Attributes
    ----------
    torque : float
        Of the pinion, N.m.
    contact_stress : float
        Of the flanks, Pa.
    root_stress : (float, float)
        Of the roots of pinion and wheel, Pa.
    contact, root : float
        Safety of the flanks, and of the weaker root.
    """

    torque: float
    contact_stress: float
    root_stress: tuple[float, float]
    contact: float
    root: float


class GearRating(RichHtml, dict[str, GearSafety]):
    """Safety of a pair of gears by the name of the torque."""

    def __repr__(self) -> str:
        rows = [
            (
                name,
                number(found.torque),
                *(number(stress / 1e6, 4) for stress in (found.contact_stress, *found.root_stress)),
                f"{found.contact:.2f}",
                f"{found.root:.2f}",
            )
            for name, found in self.items()
        ]
        stresses = ("flank, MPa", "roots, MPa", "")
        return table(("torque", "N.m", *stresses, "safety of the flank", "of the root"), rows)


@checked
def rate_gears(
    pair: GearPair, torques: Mapping[str, float], *, strength: GearStrength
) -> GearRating:
    """Safety of a pair of gears under torques, such as the peak of a run and its equivalent.

    Parameters
    ----------
    pair : GearPair
        The gears.
    torques : mapping of str to float
        Torques of the pinion by name, N.m; their signs do not matter.
    strength : GearStrength
        What the teeth stand.

    Returns
    -------
    GearRating

    Raises
    ------
    OptionError
        If a torque is zero.
    """
    found: dict[str, Any] = {}
    for name, given in torques.items():
        torque, factor = abs(float(given)), strength.load_factor
        if not torque > 0:
            raise OptionError(f"rate_gears: torques['{name}'] is zero: nothing loads the teeth.")
        flank = contact_stress(pair, torque, load_factor=factor)
        first, second = (
            root_stress(pair, torque, form=form, correction=correction, load_factor=factor)
            for form, correction in zip(strength.form, strength.correction, strict=True)
        )
        weaker = min(strength.root[0] / first, strength.root[1] / second)
        safety = strength.contact / flank
        found[name] = GearSafety(torque, flank, (first, second), safety, weaker)
    return GearRating(found)
