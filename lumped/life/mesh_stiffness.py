"""Stiffness of the teeth of a pair of cylindrical gears, and how it varies over the pitch.

Source: ISO 6336-1:2006, Calculation of load capacity of spur and helical gears, part 1: basic
principles (tooth stiffness by method B), as calculated by KISSsoft 03/2017 for the NREL 5 MW
gearbox (gfsReboucas/Drivetrain).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees, exp, floor, inf, log, pi, sin

from lumped.errors import OptionError
from lumped.life.gear_pair import GearPair
from lumped.life.gear_rating import STEEL
from lumped.numerics.harmonics import Harmonics


@dataclass(frozen=True)
class MeshStiffness:
    """Stiffness of a pair of gears by method B of ISO 6336-1, for loads above 100 N/mm.

    The least flexibility of a pair of teeth is a polynomial of the virtual teeth and the profile
    shifts, fitted for shifts of which the sum is between -0.5 and 2; an internal wheel counts as a
    rack. Contact ratios below 1.2 may make the mesh up to 10 % softer.

    Parameters
    ----------
    pair : GearPair
        The gears.
    dedendum : float
        Of the basic rack over the module.
    web : float
        Thickness of the web over the width of the teeth, counted between 0.2 and 1.2; 1 is a solid
        disc.
    rim : float
        Thickness of the rim over the module, counted from 1 on; matters beside a web.
    moduli : (float, float)
        Of elasticity of pinion and wheel, Pa; default is steel.

    Raises
    ------
    OptionError
        If a number is out of range.
    """

    pair: GearPair
    dedendum: float = 1.25
    web: float = 1.0
    rim: float = 1.0
    moduli: tuple[float, float] = (STEEL[0], STEEL[0])

    def __post_init__(self) -> None:
        numbers = {"dedendum": self.dedendum, "web": self.web, "rim": self.rim}
        for name, value in (numbers | {"moduli": min(self.moduli)}).items():
            if not 0 < value < inf:
                raise OptionError(f"MeshStiffness: {name} = {value:g} is out of range.")
        shift = sum(self.pair.shift)
        if not -0.5 <= shift <= 2:
            raise OptionError(
                f"MeshStiffness: the sum of the profile shifts is {shift:g}; ISO 6336-1 holds from "
                "-0.5 to 2."
            )

    @property
    def flexibility(self) -> float:
        """Least flexibility of a pair of teeth for each width, 1/Pa, before any correction."""
        cosines = cos(self.pair.base_helix) ** 2 * cos(float(self.pair.helix))
        a, b = cosines / self.pair.teeth[0], max(cosines / self.pair.teeth[1], 0.0)
        x, y = self.pair.shift
        pinion = 0.15551 * a - 0.00635 * x - 0.11654 * x * a + 0.00529 * x**2
        wheel = 0.25791 * b - 0.00193 * y - 0.24188 * y * b + 0.00182 * y**2
        return 1e-9 * (0.04723 + pinion + wheel)

    @property
    def single(self) -> float:
        """c', greatest stiffness of a pair of teeth for each width, Pa (1e9 Pa is 1 N/(mm um))."""
        pair, (first, second) = self.pair, self.moduli
        web = min(max(self.web, 0.2), 1.2)
        blank = 1 + log(web) / (5 * exp(max(self.rim, 1.0) / 5))
        rack = (1 + 0.5 * (1.2 - self.dedendum)) * (1 - 0.02 * (20 - degrees(float(pair.pressure))))
        steel = 2 * first * second / (first + second) / STEEL[0]
        return 0.8 * blank * rack * steel * cos(float(pair.helix)) / self.flexibility

    @property
    def mean(self) -> float:
        """c_gamma over the whole width, N/m: ``c' b (0.75 eps_alpha + 0.25)``."""
        return self.single * float(self.pair.width) * (0.75 * self.pair.contact_ratio + 0.25)

    def shares(self, count: int) -> Harmonics:
        """First harmonics over the pitch of the stiffness over its mean, as the lines of contact.

        Parameters
        ----------
        count : int
            Of harmonics.

        Returns
        -------
        Harmonics
        """
        return lines_of_contact(self.pair.contact_ratio, self.pair.overlap_ratio, count)


def lines_of_contact(ratio: float, overlap: float, count: int) -> Harmonics:
    """First harmonics over the pitch of the total length of the lines of contact over its mean.

    A pair of teeth is in contact over `ratio` pitches; along a helix it enters and leaves over
    `overlap` pitches. At the angle zero, without overlap, most pairs are in contact.

    Parameters
    ----------
    ratio, overlap : float
        Transverse contact ratio, at least 1, and overlap ratio.
    count : int
        Of harmonics.

    Returns
    -------
    Harmonics
    """
    q = ratio - floor(ratio)
    found = []
    for k in range(1, count + 1):
        along = pi * k * overlap
        share = 2 * sin(pi * k * q) / (pi * k * ratio) * (sin(along) / along if along else 1.0)
        found.append((float(k), share, 0.0))
    return found
