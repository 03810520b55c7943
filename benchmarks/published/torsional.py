"""Torsional systems and planetary gears with published natural frequencies, Hz."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Spring, SpringDamper


class Train(NamedTuple):
    """A model and its frequencies: as printed, and as recomputed by SciPy from the same data."""

    name: str
    source: str
    model: Callable[[], lp.Component]
    printed: tuple[float, ...]
    digits: float
    recomputed: tuple[float, ...]


def train(J, c, ground=None):
    """Inertias on springs in a row, some of them on springs to the ground."""
    held = {f"hold_{i}": Spring(c=value) for i, value in (ground or {}).items()}

    def joints(m):
        for i, spring in enumerate(m.spring):
            yield from lp.chain(m.body[i], spring, m.body[i + 1])
        for i in ground or {}:
            yield from lp.chain(m.ground, getattr(m, f"hold_{i}"), m.body[i])

    return lp.compose(
        body=[Inertia(J=value) for value in J],
        spring=[Spring(c=value) for value in c],
        **held,
        **({"ground": Fixed()} if held else {}),
        connections=lambda m: list(joints(m)),
    )


def geared():
    """A motor on one of two equal wheels, a rotor on each."""
    return lp.compose(
        motor=Inertia(J=400e-6),
        one=Inertia(J=25e-6),
        two=Inertia(J=25e-6),
        rotor=[Inertia(J=700e-6) for _ in range(2)],
        coupling=Spring(c=1e4),
        shaft=[Spring(c=5e3) for _ in range(2)],
        gear=IdealGear(ratio=-1.0),
        connections=lambda m: [
            *lp.chain(m.motor, m.coupling, m.one, m.gear, m.two, m.shaft[1], m.rotor[1]),
            *lp.chain(m.one, m.shaft[0], m.rotor[0]),
        ],
    )


def ship():
    """Engine and two motors on gears, shafts without mass."""
    shear = 68e9 * np.pi / 32
    return lp.compose(
        engine=Inertia(J=3200.0),
        shaft=Spring(c=shear * 0.2**4 / 2.5),
        wheel=Inertia(J=400.0),
        gear=[IdealGear(ratio=-0.8 / 0.5) for _ in range(2)],
        pinion=[Inertia(J=800.0) for _ in range(2)],
        branch=[Spring(c=shear * 0.25**4 / 3.5) for _ in range(2)],
        motor=[Inertia(J=450.0) for _ in range(2)],
        connections=lambda m: [
            *lp.chain(m.engine, m.shaft, m.wheel),
            *(
                joint
                for i in range(2)
                for joint in lp.chain(m.wheel, m.gear[i], m.pinion[i], m.branch[i], m.motor[i])
            ),
        ],
    )


def wind_turbine():
    """Rotor and generator of NREL's 5 MW turbine, on the slow side."""
    return lp.compose(
        rotor=Inertia(J=38759228.0),
        shaft=SpringDamper(c=867637000.0, d=6215000.0),
        gear=IdealGear(ratio=1 / 97.0),
        generator=Inertia(J=534.116),
        connections=lambda m: lp.chain(m.rotor, m.shaft, m.gear, m.generator),
    )


PER_UNIT = 120 * np.pi
TRAINS = (
    Train(
        "555 MVA Lambton unit",
        "Rogers et al., Power System Oscillations, chapter 8",
        lambda: train(
            (0.248, 0.464, 2.310, 2.384, 1.710),
            [value * PER_UNIT for value in (21.8, 48.4, 75.6, 62.3)],
        ),
        (16.3, 24.1, 30.3, 44.0),
        0.1,
        tuple(w / (2 * np.pi) for w in (101.95657, 151.29909, 190.38994, 276.43849)),
    ),
    Train(
        "IEEE second SSR benchmark, system 1",
        "IEEE Committee, 1985",
        lambda: train(
            [value / 32.174049 for value in (1383, 176204, 310729, 49912)],
            (4.39e6, 97.97e6, 50.12e6),
        ),
        (24.65, 32.39, 51.10),
        0.02,
        (24.6367, 32.3737, 51.1092),
    ),
    Train(
        "five discs",
        "Friswell et al., Dynamics of Rotating Machines, 9.7.1 (openTorsion 88ab7893)",
        lambda: train((3.5e-3, 3.5e-3, 3.5e-3, 0.15, 0.05), (12e3, 12e3, 14e3, 10e3)),
        (81.21, 141.21, 378.95, 536.36),
        0.005,
        (81.2076, 141.2141, 378.9530, 536.3633),
    ),
    Train(
        "three rotors on a gear",
        "Friswell et al., chapter 9",
        geared,
        (425.4, 634.1, 3247.2),
        0.05,
        (425.359, 634.073, 3247.192),
    ),
    Train(
        "ship with two motors",
        "Friswell et al., 9.6.3",
        ship,
        (10.304, 20.479, 24.423),
        0.0005,
        (10.30419, 20.47926, 24.42292),
    ),
    Train(
        "diesel engine on springs",
        "Friswell et al., 9.6",
        lambda: train(
            (90, 140, 140, 140, 140, 90, 350, 500, 22000),
            (2.5e6, 2.5e6, 2.5e6, 2.5e6, 2.5e6, 40e6, 40e6, 3e6),
            {0: 10e6, 5: 10e6},
        ),
        (),
        0.0,
        (
            *(1.547929, 11.926382, 17.923872, 24.448801, 33.714734),
            *(40.184990, 60.315130, 69.240964, 132.804260),
        ),
    ),
    Train(
        "5 MW wind turbine",
        "NREL reference turbine",
        wind_turbine,
        (),
        0.0,
        (2.222662,),
    ),
)


class Wheel(lp.Component):
    """Carrier, ring, sun or planet: places x, y and the way u of its pitch circle."""

    px = lp.LinearFlange(free=True)
    py = lp.LinearFlange(free=True)
    pu = lp.LinearFlange(free=True)
    m: lp.Param = lp.param("kg", "")
    J: lp.Param = lp.param("kg", "moment of inertia over the square of the radius")
    bearing: lp.Param = lp.param("N/m", "", 0.0)
    held: lp.Param = lp.param("N/m", "stiffness against turning", 0.0)
    x: lp.Var = lp.var("m", "")
    y: lp.Var = lp.var("m", "")
    u: lp.Var = lp.var("m", "")

    def equations(self):
        for flange, place, mass, stiffness in (
            (self.px, self.x, self.m, self.bearing),
            (self.py, self.y, self.m, self.bearing),
            (self.pu, self.u, self.J, self.held),
        ):
            yield flange.s == place
            yield mass * lp.der(lp.der(place)) == flange.f - stiffness * place


class Link(lp.Component):
    """A spring over a combination of places of two wheels, a mesh or a bearing."""

    ax = lp.LinearFlange()
    ay = lp.LinearFlange()
    au = lp.LinearFlange()
    bx = lp.LinearFlange()
    by = lp.LinearFlange()
    bu = lp.LinearFlange()
    c: lp.Param = lp.param("N/m", "")
    ways: tuple[float, ...] = ()
    force: lp.Var = lp.var("N", "")

    def equations(self):
        flanges = self.ax, self.ay, self.au, self.bx, self.by, self.bu
        ways = [(flange, float(w)) for flange, w in zip(flanges, self.ways, strict=True)]
        yield self.force == self.c * sum(flange.s * w for flange, w in ways if w)
        for flange, w in ways:
            yield flange.f == w * self.force


ANGLE = np.radians(24.6)


def planetary(n):
    """Planets that move in their plane: carrier, ring and sun with meshes and bearings."""
    s, c, links = np.sin(ANGLE), np.cos(ANGLE), []
    for k in range(n):
        psi = 2 * np.pi * k / n
        inner, outer = psi - ANGLE, psi + ANGLE
        links += [
            ("sun", k, 5e8, (-np.sin(inner), np.cos(inner), 1.0, -s, -c, 1.0)),
            ("ring", k, 5e8, (-np.sin(outer), np.cos(outer), 1.0, s, -c, -1.0)),
            ("carrier", k, 1e8, (np.cos(psi), np.sin(psi), 0.0, -1.0, 0.0, 0.0)),
            ("carrier", k, 1e8, (-np.sin(psi), np.cos(psi), 1.0, 0.0, -1.0, 0.0)),
        ]

    def joints(m):
        for link, (name, k, _, _) in zip(m.link, links, strict=True):
            for way in "xyu":
                yield lp.connect(getattr(link, f"a{way}"), getattr(getattr(m, name), f"p{way}"))
                yield lp.connect(getattr(link, f"b{way}"), getattr(m.planet[k], f"p{way}"))

    return lp.compose(
        carrier=Wheel(m=5.43, J=6.29, bearing=1e8),
        ring=Wheel(m=2.35, J=3.00, bearing=1e8, held=1e9),
        sun=Wheel(m=0.4, J=0.39, bearing=1e8),
        planet=[Wheel(m=0.66, J=0.61) for _ in range(n)],
        link=[Link(c=stiffness, ways=ways) for _, _, stiffness, ways in links],
        connections=lambda m: list(joints(m)),
    )


PLANETS = {
    3: (
        (1475.7, 1930.3, 2658.3, 7462.8, 11775.3),
        (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9),
        (),
    ),
    4: (
        (1536.5, 1970.6, 2625.7, 7773.6, 13071.1),
        (727.3, 1091.2, 1892.8, 2342.5, 7189.9, 10437.6),
        (1808.2, 5963.8, 6981.7),
    ),
    5: (
        (1567.4, 2006.1, 2614.8, 8065.4, 14253.1),
        (710.0, 1072.0, 1888.1, 2425.3, 7382.4, 11172.3),
        (1808.2, 5963.8, 6981.7),
    ),
    6: (
        (1580.5, 2032.7, 2624.3, 8342.7, 15346.1),
        (692.9, 1049.2, 1884.7, 2513.8, 7567.2, 11861.7),
        (1808.2, 5963.8, 6981.7),
    ),
}
"""Lin, Parker, J. Vib. Acoust. 121 (1999) 316: rotational modes beside the rigid one, pairs of
translational modes, and modes of n - 3 times the planets."""


def list_planetary(n: int) -> list[float]:
    """All of them but the rigid mode, those that repeat as often as they do."""
    rotational, pairs, planets = PLANETS[n]
    return [*rotational, *np.repeat(pairs, 2), *np.repeat(planets, n - 3)]


def hertz_of(model: lp.Component) -> np.ndarray:
    """Frequencies in rising order; a rigid motion of many places at once is one of rounding."""
    found = np.sort(lp.modes(lp.assemble(model)).hertz)
    return found[found > 1e-6 * found[-1]]
