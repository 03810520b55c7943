"""Geometry of a pair of cylindrical gears, and the factors of its stresses that follow from it.

Sources: ISO 21771:2007, Gears, cylindrical involute gears and gear pairs (geometry, signs of an
internal gear); ISO 6336-2:1996 and ISO 6336-3:1996, Calculation of load capacity of spur and
helical gears, part 2: pitting, part 3: bending strength (factors of geometry); Stock Drive Products
/ Sterling Instrument, Elements of metric gear technology, (5-6), (5-7) (interference of an internal
gear).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import acos, asin, atan, copysign, cos, degrees, inf, pi, sin, sqrt, tan

import scipy

from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.units import plain


@dataclass(frozen=True)
class GearPair:
    """Pair of cylindrical gears, the pinion first.

    Parameters
    ----------
    teeth : (int, int)
        Of pinion and wheel; those of an internal wheel are negative, as in ISO 21771, and so are
        its diameters.
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
    distance : float or str, optional
        Of the axes, m, or with a unit; without it the one at which the teeth have no backlash.
    tips : (float or str, float or str), optional
        Diameters of the tip circles, m, or with a unit, for tips that are shortened.

    Raises
    ------
    OptionError
        If a number is out of range, or the teeth do not mesh: tips that are pointed or within the
        base circle, or reach beyond the other's base circle (an undercut pinion); a distance at
        which they jam; a contact ratio below 1; an internal wheel with too few teeth.
    """

    teeth: tuple[int, int]
    module: float | str
    width: float | str
    helix: float | str = 0.0
    pressure: float | str = pi / 9
    shift: tuple[float, float] = (0.0, 0.0)
    addendum: float = 1.0
    distance: float | str | None = None
    tips: tuple[float | str, float | str] | None = None

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
        if min(self.teeth[0], abs(self.teeth[1])) < 5:
            raise OptionError(f"GearPair: teeth = {self.teeth}: at least 5 are needed.")
        if 0 < -self.teeth[1] <= self.teeth[0]:
            raise OptionError(
                f"GearPair: teeth = {self.teeth}: an internal wheel has more than its pinion."
            )
        check_meshing(self)

    @property
    def internal(self) -> bool:
        """Whether the wheel is internal."""
        return self.teeth[1] < 0

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
    def tight_pressure(self) -> float:
        """Pressure angle of the working circles without backlash, rad; shifts change it."""
        alpha, shift = self.transverse_pressure, sum(self.shift)
        if not shift:
            return alpha
        wanted = involute(alpha) + 2 * shift / sum(self.teeth) * tan(self._pressure)
        return float(
            scipy.optimize.brentq(lambda x: involute(x) - wanted, 1e-3, pi / 3, xtol=1e-15)
        )

    @cached_property
    def working_pressure(self) -> float:
        """Pressure angle of the working circles, rad."""
        if self.distance is None:
            return self.tight_pressure
        return acos(abs(sum(self.base_diameters)) / 2 / self.centre)

    @property
    def backlash(self) -> float:
        """Along the line of action in the transverse section, m, from the distance of the axes."""
        return sum(self.base_diameters) * (
            involute(self.working_pressure) - involute(self.tight_pressure)
        )

    @property
    def diameters(self) -> tuple[float, float]:
        """Of the reference circles, m."""
        each = self._module / cos(self._helix)
        return self.teeth[0] * each, self.teeth[1] * each

    @property
    def base_diameters(self) -> tuple[float, float]:
        """Of the base circles, m."""
        share = cos(self.transverse_pressure)
        return self.diameters[0] * share, self.diameters[1] * share

    @cached_property
    def tip_diameters(self) -> tuple[float, float]:
        """Of the tip circles, m; without `tips` they are not shortened."""
        (a, b), (x, y) = self.diameters, self.shift
        if self.tips is not None:
            first, second = (plain(tip, "m", "GearPair: tips =", OptionError) for tip in self.tips)
            return first, copysign(second, b)
        height = 2 * self._module
        return a + height * (self.addendum + x), b + height * (self.addendum + y)

    @cached_property
    def tip_pressures(self) -> tuple[float, float]:
        """Pressure angles of the tip circles, rad."""
        first, second = (
            acos(base / tip)
            for base, tip in zip(self.base_diameters, self.tip_diameters, strict=True)
        )
        return first, second

    @property
    def tip_widths(self) -> tuple[float, float]:
        """Thickness of the teeth at the tips, along the circles in the transverse section, m."""
        begin, slope = involute(self.transverse_pressure), tan(self._pressure)
        first, second = (
            tip * ((pi / 2 + 2 * x * slope) / z + begin - involute(pressure))
            for tip, x, z, pressure in zip(
                self.tip_diameters, self.shift, self.teeth, self.tip_pressures, strict=True
            )
        )
        return first, second

    @cached_property
    def centre(self) -> float:
        """Distance of the axes, m; without shifts ``m (z1 + z2) / (2 cos beta)``."""
        if self.distance is not None:
            return plain(self.distance, "m", "GearPair: distance =", OptionError)
        return abs(sum(self.base_diameters)) / 2 / cos(self.tight_pressure)

    @property
    def virtual_teeth(self) -> tuple[float, float]:
        """Teeth of the spur gears like the normal section, ``z / cos^3 beta``."""
        cube = cos(self._helix) ** 3
        return self.teeth[0] / cube, self.teeth[1] / cube

    @cached_property
    def contact_ratio(self) -> float:
        """Pairs of teeth in contact in the transverse section, eps_alpha."""
        working = tan(self.working_pressure)
        each = zip(self.teeth, self.tip_pressures, strict=True)
        return sum(z * (tan(tip) - working) for z, tip in each) / (2 * pi)

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


def involute(angle: float) -> float:
    """Involute function, ``tan(angle) - angle``, rad."""
    return tan(angle) - angle


def check_meshing(pair: GearPair) -> None:
    """Refuse teeth that do not mesh."""
    bases, tips, teeth = pair.base_diameters, pair.tip_diameters, pair.teeth
    if not abs(sum(bases)) / 2 < pair.centre < inf:
        raise OptionError(
            f"GearPair: distance = {pair.centre:g} m: the base circles need more than "
            f"{abs(sum(bases)) / 2:g} m."
        )
    for name, base, tip in zip(("pinion", "wheel"), bases, tips, strict=True):
        if not 0 < base / tip < 1:
            raise OptionError(
                f"GearPair: the tip circle of the {name}, {abs(tip):g} m, lies within its base "
                f"circle, {abs(base):g} m; give tips."
            )
    for name, width in zip(("pinion", "wheel"), pair.tip_widths, strict=True):
        if width <= 0:
            raise OptionError(
                f"GearPair: the teeth of the {name} end in a point below their tip circle "
                f"(thickness {width:g} m); give tips, or a smaller shift."
            )
    if pair.backlash < -1e-9 * pair.centre:
        raise OptionError(
            f"GearPair: distance = {pair.centre:g} m: the teeth jam by {-pair.backlash:g} m. "
            f"Without backlash it is {abs(sum(bases)) / 2 / cos(pair.tight_pressure):g} m."
        )
    working = tan(pair.working_pressure)
    ahead = [z * (tan(tip) - working) for z, tip in zip(teeth, pair.tip_pressures, strict=True)]
    for name, z, reach in zip(("pinion", "wheel"), teeth, reversed(ahead), strict=True):
        if 0 < z * working < reach:
            raise OptionError(
                f"GearPair: the other tips reach beyond the base circle of the {name}, whose teeth "
                "are undercut there; give it a larger shift, or tips."
            )
    if pair.contact_ratio < 1:
        raise OptionError(
            f"GearPair: the contact ratio is {pair.contact_ratio:.4g}; at least 1 is needed."
        )
    if pair.internal and _tips_collide(pair):
        raise OptionError(
            f"GearPair: teeth = {teeth}: the internal wheel has too few teeth, its tips meet those "
            "of the pinion outside of the line of action; give tips, or more teeth."
        )


def _tips_collide(pair: GearPair) -> bool:
    """Whether the path of a tip of the pinion cuts the teeth of an internal wheel."""
    (r, R), a = (abs(tip) / 2 for tip in pair.tip_diameters), pair.centre
    if a + r <= R:
        return False
    turn = acos((R**2 - r**2 - a**2) / (2 * a * r))
    wheel = acos((a**2 + R**2 - r**2) / (2 * a * R))
    first, second = (involute(tip) for tip in pair.tip_pressures)
    working = involute(pair.working_pressure)
    return (turn + first - working) / -pair.ratio + working - second < wheel


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
