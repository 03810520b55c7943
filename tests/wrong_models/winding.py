"""Coils and their strip."""

import lumped as lp
from lumped.components import Coil, Speed, Strip, StripPath, translation
from lumped.errors import ParameterError

from . import Table
from .parts import build

wrong = Table("Winding")


def coiler(*, strip=None, path=None, **given):
    """A coil on a mandrel that is driven, with its strip or the path of it."""
    values = {"r": 0.3, "R_max": 1.0, "h": 2e-3, "b": 1.2, "rho": 7850.0} | given
    line = strip or path

    def connections(m):
        yield lp.connect(m.drive.flange, m.coil.flange)
        if path:
            yield lp.connect(m.coil.strip, m.path.strip)
            yield lp.connect(m.coil.tangent, m.path.tangent)
            yield lp.connect(m.coil.R, m.path.R)
            yield lp.connect(m.path.line, m.pull.flange)
        elif strip:
            yield from lp.chain(m.pull.flange, m.strip, m.coil.strip)
        else:
            yield lp.connect(m.coil.strip, m.pull.flange)

    parts = {"path" if path else "strip": line} if line else {}
    build(
        connections,
        drive=Speed(w=10.0),
        coil=Coil(**values),
        pull=translation.Speed(v=0.0) if strip else translation.Force(f=-5e4),
        **parts,
    )


@wrong(ParameterError, "coil.h = -0.001 m", "thickness of the strip", "at least 0")
def strip_of_negative_thickness():
    """The thickness of a strip is negative."""
    coiler(h=-1e-3)


@wrong(ParameterError, "coil.R_max = 0.2 m", "radius of a full coil", "coil.r = 0.3 m")
def full_coil_smaller_than_its_mandrel():
    """A full coil is smaller than its mandrel."""
    coiler(R_max=0.2)


@wrong(ParameterError, "coil.fill = 95", "at most 1")
def fill_in_percent():
    """The fill of a coil is given in percent."""
    coiler(fill=95.0)


@wrong(ParameterError, "strip.c = 0 N/m (stiffness)", "greater than 0")
def strip_without_stiffness():
    """An elastic strip has no stiffness."""
    coiler(strip=Strip(c=0.0))


@wrong(ParameterError, "path.d = 1 m", "greater than path.r_t = 1.25 m")
def roll_inside_the_turret():
    """The roll before a turret stands inside the circle of its coils."""
    coiler(path=StripPath(r_t=1.25, d=1.0))
