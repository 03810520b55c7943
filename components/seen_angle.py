"""The angle under which a pin on a circle is seen from outside.

It is the bounded part of the angle of Cardan joints, elliptical gears and Geneva wheels.
"""

from __future__ import annotations

from lumped.language.expression import Expr, Number, as_expr
from lumped.ops import atan2, cos, sin

__all__ = ["seen_angle"]


def seen_angle(x: Number, e: Number) -> Expr:
    """Angle of a pin on a circle of radius e, seen from the distance 1 of its centre, rad.

    ``atan2(e sin x, 1 - e cos x) = sum(e^n sin(n x) / n)``, between plus and minus ``asin(e)``, in
    any turn.

    Parameters
    ----------
    x : expression
        Angle of the pin on its circle from the line between the centres, rad.
    e : expression
        Radius of the circle over the distance, below 1.

    Returns
    -------
    Expr
    """
    return atan2(as_expr(e) * sin(x), 1 - e * cos(x))
