"""Torsional systems and planetary gears with published natural frequencies, Hz."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import lumped as lp
from lumped.components import (
    Fixed,
    IdealGear,
    Inertia,
    PlanarPlanetaryStage,
    Spring,
    SpringDamper,
)


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


def planetary(n):
    """Stage of n planets that move in their plane, by the inertias over the square of a radius."""
    alpha, r_s = np.radians(24.6), 0.04
    r_p, r_r, a = r_s / 2, 2 * r_s, 1.5 * r_s / np.cos(alpha)
    bearings = dict.fromkeys(("c_b", "c_sun", "c_carrier", "c_ring"), 1e8)
    stage = PlanarPlanetaryStage(
        **bearings,
        n=n,
        z_s=40,
        z_p=20,
        z_r=80,
        r_s=r_s,
        alpha=alpha,
        m_p=0.66,
        J_p=0.61 * r_p**2,
        c_s=5e8,
        c_r=5e8,
        m_sun=0.4,
        m_carrier=5.43,
        m_ring=2.35,
    )
    return lp.compose(
        stage=stage,
        sun=Inertia(J=0.39 * r_s**2),
        carrier=Inertia(J=6.29 * a**2),
        ring=Inertia(J=3.0 * r_r**2),
        hold=Spring(c=1e9 * r_r**2),
        ground=Fixed(),
        connections=lambda m: [
            lp.connect(m.stage.sun, m.sun.flange_a),
            lp.connect(m.stage.carrier, m.carrier.flange_a),
            *lp.chain(m.stage.ring, m.ring, m.hold, m.ground),
        ],
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
