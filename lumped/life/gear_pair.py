"""Geometry of a pair of cylindrical gears, and the factors of its stresses that follow from it.

Source: ISO 6336-2:1996 and ISO 6336-3:1996, Calculation of load capacity of spur and helical gears,
part 2: pitting, part 3: bending strength (factors of geometry).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import acos, asin, atan, cos, degrees, floor, inf, pi, sin, sqrt, tan

import scipy

from lumped.errors import OptionError
from lumped.numerics.harmonic_sums import Harmonics
from lumped.support.arguments import checked
from lumped.support.units import plain


@dataclass(frozen=True)
class GearPair:
    """Pair of external cylindrical gears, the pinion first.

    Parameters
    ----------
    teeth : (int, int)
        Of pinion and wheel.
    module : float or str
        In the normal section, m, or with a unit, such as ``"16 mm"``.
    width : float or str
        Common width of the teeth, m, or with a unit.
    helix : float or str
        Helix angle, rad, or with a unit, such as ``"12 deg"``.
    pressure : float or str
        Pressure angle in the normal section, rad, or with a unit.
    shift : (float, float)
        Profile shifts of pinion and wheel over the module.
    addendum : float
        Height of the tooth above the reference circle over the module, without the shift.
    """

    teeth: tuple[int, int]
    module: float | str
    width: float | str
    helix: float | str = 0.0
    pressure: float | str = pi / 9
    shift: tuple[float, float] = (0.0, 0.0)
    addendum: float = 1.0

    def __post_init__(self) -> None:
        for name, unit, low, high in (
            ("module", "m", 0.0, inf),
            ("width", "m", 0.0, inf),
            ("helix", "rad", -1e-300, pi / 4),
            ("pressure", "rad", 0.0, pi / 4),
        ):
            value = plain(getattr(self, name), unit, f"GearPair: {name} =", OptionError)
            if not low < value < high:
                raise OptionError(f"GearPair: {name} = {value:g} {unit} is out of range.")
            object.__setattr__(self, name, value)
        if min(self.teeth) < 5:
            raise OptionError(f"GearPair: teeth = {self.teeth}: at least 5 are needed.")

    @property
    def ratio(self) -> float:
        """Teeth of the wheel over those of the pinion."""
        return self.teeth[1] / self.teeth[0]

    @cached_property
    def transverse_pressure(self) -> float:
        """Pressure angle in the transverse section, rad."""
        return atan(tan(self._pressure) / cos(self._helix))

    @cached_property
    def base_helix(self) -> float:
        """Helix angle on the base cylinder, rad."""
        return asin(sin(self._helix) * cos(self._pressure))

    @cached_property
    def working_pressure(self) -> float:
        """Pressure angle of the working circles, rad; profile shifts change it."""
        alpha, shift = self.transverse_pressure, sum(self.shift)
        if not shift:
            return alpha
        wanted = tan(alpha) - alpha + 2 * shift / sum(self.teeth) * tan(self._pressure)
        return float(scipy.optimize.brentq(lambda x: tan(x) - x - wanted, 1e-3, pi / 3, xtol=1e-15))

    @property
    def diameters(self) -> tuple[float, float]:
        """Of the reference circles, m."""
        each = self._module / cos(self._helix)
        return self.teeth[0] * each, self.teeth[1] * each

    @property
    def tip_diameters(self) -> tuple[float, float]:
        """Of the tip circles, m; tips are not shortened."""
        (a, b), (x, y) = self.diameters, self.shift
        height = 2 * self._module
        return a + height * (self.addendum + x), b + height * (self.addendum + y)

    @property
    def centre(self) -> float:
        """Distance of the axes, m; without shifts ``m (z1 + z2) / (2 cos beta)``."""
        plainly = sum(self.diameters) / 2
        return plainly * cos(self.transverse_pressure) / cos(self.working_pressure)

    @property
    def virtual_teeth(self) -> tuple[float, float]:
        """Teeth of the spur gears like the normal section, ``z / cos^3 beta``."""
        cube = cos(self._helix) ** 3
        return self.teeth[0] / cube, self.teeth[1] / cube

    @cached_property
    def contact_ratio(self) -> float:
        """Pairs of teeth in contact in the transverse section, eps_alpha."""
        base = cos(self.transverse_pressure)
        working = tan(self.working_pressure)
        total = 0.0
        for z, d, tip in zip(self.teeth, self.diameters, self.tip_diameters, strict=True):
            total += z * (tan(acos(d * base / tip)) - working)
        return total / (2 * pi)

    @property
    def overlap_ratio(self) -> float:
        """Of the helix over the width, eps_beta: ``b sin beta / (pi m)``."""
        return float(self.width) * sin(self._helix) / (pi * self._module)

    @property
    def zone_factor(self) -> float:
        """Z_H: curvature of the flanks at the pitch point."""
        alpha, working = self.transverse_pressure, self.working_pressure
        return sqrt(2 * cos(self.base_helix) * cos(working) / sin(working)) / cos(alpha)

    @property
    def contact_ratio_factor(self) -> float:
        """Z_eps: share of several pairs of teeth in the contact stress."""
        alpha, beta = self.contact_ratio, min(self.overlap_ratio, 1.0)
        return sqrt((4 - alpha) / 3 * (1 - beta) + beta / alpha)

    @property
    def helix_factor(self) -> float:
        """Z_beta: helix in the contact stress, ``sqrt(cos beta)``."""
        return sqrt(cos(self._helix))

    @property
    def root_ratio_factor(self) -> float:
        """Y_eps: share of several pairs of teeth in the root stress."""
        return 0.25 + 0.75 * cos(self.base_helix) ** 2 / self.contact_ratio

    @property
    def root_helix_factor(self) -> float:
        """Y_beta: helix in the root stress, ``1 - eps_beta beta / 120 deg``, at least 0.75."""
        angle = min(degrees(self._helix), 30.0)
        return max(1 - min(self.overlap_ratio, 1.0) * angle / 120, 0.75)

    @property
    def _helix(self) -> float:
        return float(self.helix)

    @property
    def _pressure(self) -> float:
        return float(self.pressure)

    @property
    def _module(self) -> float:
        return float(self.module)


@checked
def helix_for_centre(teeth: tuple[int, int], *, module: float, centre: float) -> float:
    """Helix angle at which a pair without profile shifts has a distance of its axes, rad.

    ``acos(m (z1 + z2) / (2 a))``: for the distance rounded up from that of another angle.

    Parameters
    ----------
    teeth : (int, int)
        Of pinion and wheel.
    module : float
        In the normal section, m.
    centre : float
        Distance of the axes, m.

    Returns
    -------
    float

    Raises
    ------
    OptionError
        If spur gears are already farther apart.
    """
    share = module * sum(teeth) / (2 * centre) if centre > 0 else inf
    if not 0 < share <= 1:
        raise OptionError(
            f"helix_for_centre: {centre:g} m: spur gears are {module * sum(teeth) / 2:g} m apart."
        )
    return acos(share)


def lines_of_contact(ratio: float, overlap: float, count: int) -> Harmonics:
    """First harmonics over the pitch of the total length of the lines of contact over its mean.

    A pair of teeth is in contact over `ratio` pitches; along a helix it enters and leaves over
    `overlap` pitches. The length is greatest at the angle zero.

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
