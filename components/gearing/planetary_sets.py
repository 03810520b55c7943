"""Compound, Ravigneaux and Simpson sets without inertia and without loss.

Source: Willis, Principles of Mechanism (1841) (speeds relative to the carrier); Benford and
Leising, The lever analogy, SAE 810102 (1981) (Ravigneaux and Simpson sets of transmissions).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, lossless
from lumped.components.gearing.planetary_teeth import (
    equal_angles,
    refuse_assembly,
    refuse_collision,
    refuse_counts,
    refuse_long_planets,
    refuse_mesh,
    refuse_neighbours,
    stepped_places,
)

__all__ = ["CompoundPlanetary", "Ravigneaux", "Simpson"]


class CompoundPlanetary(Component):
    """Planetary set with stepped planets: ``w_sun - w_c = -ratio (w_ring - w_c)``.

    ``ratio = z_1 z_r / (z_s z_2)``: each planet has `z_1` teeth in mesh with the sun and `z_2` with
    the ring. Both meshes have one centre distance, ``z_r - z_2 = module_ratio (z_s + z_1)`` with
    the module at the sun over that at the ring; with shifted gears give ``profile_shift=True``. The
    torques follow from virtual work, ``tau_ring = ratio tau_sun``. An open ring is free.
    """

    symbol = "planetary"
    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    z_s: int = 0
    z_1: int = 0
    z_2: int = 0
    z_r: int = 0
    n: int = 3
    module_ratio: float = 1.0
    profile_shift: bool = False

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        sun, carrier, ring, k = self.sun, self.carrier, self.ring, self._ratio()
        yield lossless(carrier.phi == (sun.phi + k * ring.phi) / (1 + k), sun, carrier, ring)

    def _ratio(self) -> float:
        refuse_counts(self, ("z_s", "z_1", "z_2", "z_r", "n"))
        reach = self.z_s + self.z_1
        if not self.profile_shift:
            formula = "z_2 + module_ratio (z_s + z_1)"
            refuse_mesh(self, "z_r", formula, self.z_2 + self.module_ratio * reach)
        places = stepped_places(self.z_s, self.z_1, self.z_2, self.z_r)
        refuse_assembly(self, "(z_s z_2 + z_r z_1) / (n gcd(z_1, z_2))", places)
        angles = equal_angles(self.n)
        refuse_neighbours(self, angles, reach, self.z_1, "planets at the sun")
        reach_2 = self.module_ratio * reach
        refuse_neighbours(self, angles, reach_2, self.z_2, "planets at the ring")
        return self.z_1 * self.z_r / (self.z_s * self.z_2)


class Ravigneaux(Component):
    """Ravigneaux set: ``w_s - w_c = k_1 (w_r - w_c)`` and ``w_l - w_c = -k_2 (w_r - w_c)``.

    s is the small sun, l the large one, r the ring and c the carrier. Short planets mesh with the
    small sun and with long planets, and these with the large sun and the ring: ``k_1 = z_r /
    z_small``, ``k_2 = z_r / z_large``. Two of its four speeds are free. The torques follow from
    virtual work, ``tau_ring = k_2 tau_large - k_1 tau_small``. The teeth of the planets tell
    whether the wheels mesh and have room; with shifted gears give ``profile_shift=True``. An open
    flange is free.
    """

    symbol = "planetary"
    small_sun = Flange(free=True)
    large_sun = Flange(free=True)
    carrier = Flange(free=True)
    ring = Flange(free=True)
    z_small: int = 0
    z_large: int = 0
    z_short: int = 0
    z_long: int = 0
    z_r: int = 0
    n: int = 3
    profile_shift: bool = False

    def equations(self) -> Iterator[Equation]:
        self._refuse()
        small, large, carrier, ring = self.small_sun, self.large_sun, self.carrier, self.ring
        k_1, k_2 = self.z_r / self.z_small, self.z_r / self.z_large
        yield small.phi - carrier.phi == k_1 * (ring.phi - carrier.phi)
        yield large.phi - carrier.phi == -k_2 * (ring.phi - carrier.phi)
        yield ring.tau == k_2 * large.tau - k_1 * small.tau
        yield carrier.tau == (k_1 - 1) * small.tau - (k_2 + 1) * large.tau

    def _refuse(self) -> None:
        refuse_counts(self, ("z_small", "z_large", "z_short", "z_long", "z_r", "n"))
        short, long = self.z_small + self.z_short, self.z_large + self.z_long
        if not self.profile_shift:
            refuse_mesh(self, "z_r", "z_large + 2 z_long", self.z_large + 2 * self.z_long)
        refuse_assembly(self, "(z_large + z_r) / n", self.z_large + self.z_r)
        refuse_assembly(self, "(z_r - z_small) / n", self.z_r - self.z_small)
        angles = equal_angles(self.n)
        refuse_neighbours(self, angles, short, self.z_short, "short planets")
        refuse_neighbours(self, angles, long, self.z_long, "long planets")
        both = self.z_small + self.z_long + 4
        refuse_collision(self, "small sun and long planets", long / 2, both / 2)
        refuse_long_planets(self, short, long, self.z_short, self.z_long)


class Simpson(Component):
    """Simpson set: ``(1 + k_1) w_o = w_sun + k_1 w_ring`` and ``(1 + k_2) w_c = w_sun + k_2 w_o``.

    Two planetary sets with one sun: the first has the flange `ring`, ``k_1 = z_r1 / z_s``, the
    second the flange `carrier`, ``k_2 = z_r2 / z_s``; the carrier of the first and the ring of the
    second are the flange `output`. Two of its four speeds are free. The torques follow from virtual
    work, ``tau_sun = tau_ring / k_1 - tau_carrier / (1 + k_2)``. With shifted gears give
    ``profile_shift=True``. An open flange is free.
    """

    symbol = "planetary"
    sun = Flange(free=True)
    ring = Flange(free=True)
    carrier = Flange(free=True)
    output = Flange(free=True)
    z_s: int = 0
    z_p1: int = 0
    z_r1: int = 0
    z_p2: int = 0
    z_r2: int = 0
    n: int = 3
    profile_shift: bool = False

    def equations(self) -> Iterator[Equation]:
        self._refuse()
        sun, ring, carrier, output = self.sun, self.ring, self.carrier, self.output
        k_1, k_2 = self.z_r1 / self.z_s, self.z_r2 / self.z_s
        first, second = ring.tau / k_1, -carrier.tau / (1 + k_2)
        yield (1 + k_1) * output.phi == sun.phi + k_1 * ring.phi
        yield (1 + k_2) * carrier.phi == sun.phi + k_2 * output.phi
        yield sun.tau == first + second
        yield output.tau == k_2 * second - (1 + k_1) * first

    def _refuse(self) -> None:
        refuse_counts(self, ("z_s", "z_p1", "z_r1", "z_p2", "z_r2", "n"))
        for i, planet, ring in ((1, self.z_p1, self.z_r1), (2, self.z_p2, self.z_r2)):
            if not self.profile_shift:
                refuse_mesh(self, f"z_r{i}", f"z_s + 2 z_p{i}", self.z_s + 2 * planet)
            refuse_assembly(self, f"(z_s + z_r{i}) / n", self.z_s + ring)
            what = f"planets of set {i}"
            refuse_neighbours(self, equal_angles(self.n), self.z_s + planet, planet, what)
