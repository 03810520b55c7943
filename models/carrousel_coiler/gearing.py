"""Coupling, ratios, gears and bearings of the carrousel coiler, (3.14) to (3.54).

The copy has the rules, tables of their factors, two numbers of teeth and the module. It lacks the
curves of form factors and of the coupling's speed, strengths, the distance of the mandrels, all
loads and sizes of bearings. What is assumed instead is marked [A].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import cos, hypot, radians, tan

import lumped as lp
from lumped.functionals import peak
from lumped.life import (
    Bearing,
    Coupling,
    CouplingChoice,
    GearPair,
    GearRating,
    GearStrength,
    LoadSpectrum,
    choose_coupling,
    equivalent_load,
    helix_for_centre,
    least_module,
    load_spectrum,
    mean_speed,
    rate_gears,
)
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler import sizing, turret
from lumped.models.sources import Given

LOAD = "drive.gear.flange_a.tau", "drive.rotor.w"
"""Torque into the gears and speed of the motor shaft."""

MODULE = Given(16e-3, "m", "P", "module of the gears")
TEETH = Given(30, "1", "P", "teeth of the motor pinion")
SEAT_TEETH = (
    Given(23, "1", "P", "least teeth of the gear seat"),
    Given(35, "1", "P", "most teeth of the gear seat"),
)
RATIO_ERROR = Given(0.05, "1", "P", "permitted error of a ratio by whole teeth")
LOAD_FACTOR = Given(1.4, "1", "A", "load factor of the teeth, within the printed 1.2 to 1.6")
WIDTH = Given(0.7, "1", "A", "width over diameter of the pinion, the least of the printed range")
HELIX = Given(radians(12), "rad", "A", "helix angle at first")
FLANK = Given(1300e6, "Pa", "A", "strength of the flanks, case-hardened")
ROOT = Given(400e6, "Pa", "A", "strength of the roots, case-hardened")
FORMS = (
    Given(2.52, "1", "A", "form factor of the pinion"),
    Given(2.40, "1", "A", "form factor of the wheel"),
)
CORRECTIONS = (
    Given(1.625, "1", "A", "stress correction of the pinion"),
    Given(1.67, "1", "A", "stress correction of the wheel"),
)
SAFETIES = (
    Given(1.1, "1", "P", "least safety of hard flanks"),
    Given(1.4, "1", "P", "least safety of the roots of hard teeth"),
)
SERVICE = Given(1.5, "1", "A", "service factor of the coupling")
SIZES = (
    Given(80e3, "N.m", "A", "nominal torque of the small coupling"),
    Given(112e3, "N.m", "A", "nominal torque of the middle coupling"),
    Given(160e3, "N.m", "A", "nominal torque of the large coupling"),
)
COUPLING_SPEED = Given(150.0, "rad/s", "A", "permitted speed of the couplings")
SPAN = Given(0.8, "m", "A", "distance of the pinion's bearings, the pinion in the middle")
BEARING_DATA = {
    "dynamic": Given(2.0e6, "N", "A", "dynamic load rating of a pinion bearing"),
    "static": Given(4.0e6, "N", "A", "static load rating of a pinion bearing"),
    "e": Given(0.33, "1", "A", "limit of axial over radial load of a pinion bearing"),
    "Y_1": Given(2.0, "1", "A", "axial factor of a pinion bearing under small axial load"),
    "Y_2": Given(3.0, "1", "A", "axial factor of a pinion bearing under large axial load"),
    "Y_0": Given(2.0, "1", "A", "axial factor of a pinion bearing at rest"),
}
BEARING = Bearing(**BEARING_DATA)
SHOCK = Given(1.5, "1", "A", "load factor of the bearings, within the printed 1.2 to 1.8")


@dataclass(frozen=True)
class Split:
    """Ratio split between reducer and gear seat, (3.17) to (3.21).

    Attributes
    ----------
    total, seat, reducer : float
        Motor over mandrel, and of both parts.
    """

    total: float
    seat: float

    @property
    def reducer(self) -> float:
        """Of the reducer."""
        return self.total / self.seat


def split_ratio(
    total: float, distance: float = 2 * turret.CIRCLE, wheel: float = turret.CIRCLE
) -> Split:
    """Split a ratio at the gear seat, whose two wheels fill half the distance of the mandrels.

    Half the distance of the mandrels is the one of the axes of both wheels, so the core-shaft
    wheel has the diameter ``distance - wheel``, (3.18), and the seat the ratio
    ``wheel / (distance - wheel)``, (3.19) [I].

    Parameters
    ----------
    total : float
        Greatest speed of the motor over that of the mandrel, (3.17).
    distance, wheel : float
        Distance of the mandrels and diameter of the wheel of a mandrel, m; the source lost its own.
    """
    return Split(total, wheel / (distance - wheel))


def seat_pair() -> GearPair:
    """Wheels of the gear seat: equal, with a helix that fits the circle of the mandrels, (3.32)."""
    teeth = int(2 * turret.CIRCLE * cos(HELIX) / MODULE / 2)
    helix = helix_for_centre((teeth, teeth), module=MODULE, centre=turret.CIRCLE)
    return GearPair((teeth, teeth), MODULE, WIDTH * stage("high").diameters[0], helix=helix)


def equal_seat_teeth() -> float:
    """Teeth of equal wheels that keep a full coil off the empty mandrel beside it."""
    return (coiler.RADIUS + coiler.MANDREL) * cos(HELIX) / (2 * MODULE)


def stage(gear: str) -> GearPair:
    """Pair of the coaxial two-speed reducer, "high" or "low": both have one distance of axes.

    The motor pinion of the high gear has the printed number of teeth. Numbers of teeth have no
    common factor, and the distance is rounded to 10 mm before the helix is corrected, (3.31),
    (3.32).
    """
    total = round(TEETH * (1 + coiler.I_HIGH))
    pinion = TEETH if gear == "high" else round(total / (1 + coiler.I_LOW))
    teeth = int(pinion), int(total - pinion)
    centre = round(MODULE * total / (2 * cos(HELIX)), 2)
    helix = helix_for_centre(teeth, module=MODULE, centre=centre)
    width = WIDTH * MODULE * TEETH / cos(helix)
    return GearPair(teeth, MODULE, width, helix=helix)


def strength() -> GearStrength:
    """What the teeth of the reducer stand."""
    forms, corrections = (tuple(map(float, each)) for each in (FORMS, CORRECTIONS))
    return GearStrength(FLANK, (ROOT, ROOT), forms, corrections, LOAD_FACTOR)  # type: ignore[arg-type]


def loads(run: lp.Trajectory) -> dict[str, float]:
    """Peak and equivalent torque into the gears during a winding run, N.m."""
    wanted = {"peak": peak(LOAD[0]), "equivalent": equivalent_load(LOAD)}
    return {name: run.value(of) for name, of in wanted.items()}


def rate_stage(run: lp.Trajectory, gear: str = "high") -> GearRating:
    """Safety of a pair of the reducer under a winding run in its gear, (3.33) to (3.44)."""
    return rate_gears(stage(gear), loads(run), strength=strength())


def module_of_root(torque: float) -> float:
    """Least module of the motor pinion, m, (3.25), with its first helix angle and Y_beta = 1."""
    pair = stage("high")
    shape = FORMS[0] * CORRECTIONS[0] * pair.root_ratio_factor
    return least_module(
        torque,
        teeth=int(TEETH),
        width=WIDTH,
        shape=shape,
        strength=ROOT / SAFETIES[1],
        load_factor=LOAD_FACTOR,
        helix=HELIX,
    )


def pinion_forces(gear: str = "high") -> tuple[float, float]:
    """Radial and axial force on the worse bearing of the pinion for each N.m of its torque, 1/m."""
    pair = stage(gear)
    helix, radius = float(pair.helix), pair.diameters[0] / 2
    along = 1 / radius
    apart, axial = along * tan(pair.transverse_pressure), along * tan(helix)
    tilt = axial * radius / SPAN
    return hypot(along / 2, apart / 2 + tilt), axial


def bearing_load(gear: str = "high") -> lp.Expr:
    """Equivalent dynamic load of that bearing during a winding run, N, (3.47), (3.48)."""
    torque = coiler.UnderTension().drive.gear.flange_a.tau
    radial, axial = pinion_forces(gear)
    return BEARING.dynamic_load(radial * torque, axial * torque)


def bearing_hours(gear: str = "high") -> lp.functionals.Functional:
    """Life of that bearing if coils are wound for ever, h, (3.45), (3.46), (3.53)."""
    of = bearing_load(gear), LOAD[1]
    return BEARING.hours(SHOCK * equivalent_load(of), speed=mean_speed(LOAD[1]))


def spectrum(run: lp.Trajectory, classes: int = 6) -> LoadSpectrum:
    """How long each level of the torque into the gears lasts."""
    return load_spectrum(run, LOAD, classes=classes)


def coupling() -> CouplingChoice:
    """Gear coupling at the motor, (3.14), (3.15) with K_n = 1: the chart is in a handbook."""
    motor = sizing.choose_motor()
    couplings = [Coupling(f"{size / 1e3:g} kN.m", size, COUPLING_SPEED) for size in SIZES]
    return choose_coupling(couplings, torque=motor.torque, speed=motor.speed, service=SERVICE)


@cache
def coil_run() -> lp.Trajectory:
    """A full coil in high gear."""
    return coiler.winding(grid=4000, rtol=1e-9)
