"""The constant load that tires a part as much as the varying load of a run.

Source: ISO 281:2007, Rolling bearings, Dynamic load ratings and rating life (exponents 3 and 10/3);
ISO 6336-6:2019, Calculation of load capacity of gears, part 6 (the same mean for tooth stresses,
with the exponent of the S-N curve).
"""

from __future__ import annotations

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.flattening.tree import key_of
from lumped.functionals.functional import Functional
from lumped.functionals.of_runs import integral, mean
from lumped.functionals.readings import Between
from lumped.language.formula import Formula
from lumped.support.arguments import checked

ROLLER = 10 / 3
"""Exponent of the life of roller bearings; balls have 3."""


@checked
def equivalent_load(
    of: tuple[Name, Name], *, exponent: float = ROLLER, between: Between | None = None
) -> Functional:
    """Constant load that does the damage of a run in the same number of revolutions.

    ``(integral |load|^p |w| dt / integral |w| dt)^(1/p)``: each level of load counts with the
    revolutions that it lasts.

    Parameters
    ----------
    of : (name, name)
        Load, such as a force on a bearing or a torque, and speed of the shaft.
    exponent : float
        p: 10/3 for roller bearings, 3 for ball bearings; for teeth the slope of their S-N curve.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional

    Raises
    ------
    OptionError
        If the exponent is not positive.
    """
    check_exponent(exponent, "equivalent_load")
    load, speed = map(key_of, of)
    weighted = Formula.made(lambda y, w: abs(y) ** exponent * abs(w), load, speed)
    turned = Formula.made(abs, speed)
    level = integral(weighted, between=between) / integral(turned, between=between)
    return (level ** (1 / exponent)).called(f"equivalent_load({load}, {speed})")


@checked
def mean_speed(of: Name, *, between: Between | None = None) -> Functional:
    """Mean size of a speed over time: the constant speed of the same number of revolutions.

    Parameters
    ----------
    of : name or expression
        Speed of the shaft.
    between : (float, float), optional
        Two instants, s; default is the whole run.

    Returns
    -------
    Functional
    """
    speed = key_of(of)
    return mean(Formula.made(abs, speed), between=between).called(f"mean_speed({speed})")


def check_exponent(exponent: float, what: str) -> None:
    """Refuse an exponent of a life that is not positive.

    Raises
    ------
    OptionError
    """
    if not exponent > 0:
        raise OptionError(f"{what}: exponent = {exponent:g} must be positive.")
