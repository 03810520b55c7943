"""Energy and losses of bodies, springs, dampers and play."""

import itertools
from collections.abc import Iterator

import numpy as np
from library_rigs import COUPLING, TWISTS
from power_terms import Energy, Motion, Power, turning

import lumped as lp
from lumped.components import Inertia, contact, impact, translation
from lumped.components import compliance as rotation
from lumped.components.bearings import windage
from lumped.components.couplings import (
    elastic_coupling,
    maxwell_coupling,
    pendulum,
    torsional_dampers,
)
from lumped.components.shafts import continuous, element, sections, shaft
from lumped.numerics.maxwell_fit import maxwell_fit


def elastic(at: Motion) -> complex:
    return at.p["c"] * (at.rel(at.q) - at.p["phi_rel0"]) ** 2 / 2


def kinetic(mass: str) -> Energy:
    return lambda at: at.p[mass] * at.v["flange_a"] ** 2 / 2


def viscous(at: Motion) -> float:
    return at.p["d"] * at.rel(at.v) ** 2


def dragged_disc(at: Motion) -> float:
    w = np.hypot(turning(at), 1e-4)
    Re = w * at.p["R"] ** 2 / at.p["nu"]
    C_M = max(2 * 0.616 * np.pi / Re**0.5, 0.146 / Re**0.2)
    return C_M * at.p["rho"] * at.p["R"] ** 5 * w / 2 * turning(at) ** 2


def dragged_gear(at: Motion) -> float:
    d, b, m = (1e3 * at.p[name] for name in "dbm")
    v = turning(at) * at.p["d"] / 2
    return 1.37e-9 * d**1.6 * b**0.52 * m**0.69 * v * np.hypot(v, 1e-4) ** 0.9 * turning(at)


def lossy(at: Motion) -> float:
    return at.p["c"] * at.p["eta"] / at.p["w_loss"] * at.rel(at.v) ** 2


def by_rows(free_length: str | None, rows: tuple[tuple[float, float], ...] = TWISTS) -> Energy:
    """Energy of a spring by rows: the trapezoids under the lines from no stretch to this one."""

    def energy(at: Motion) -> complex:
        x = at.rel(at.q) - (at.p[free_length] if free_length else 0.0)
        places, forces = np.transpose(rows)
        slopes = np.diff(forces) / np.diff(places)

        def force(y: complex) -> complex:
            i = np.clip(np.searchsorted(places, y.real) - 1, 0, len(slopes) - 1)
            return forces[i] + slopes[i] * (y - places[i])

        way = 1 if x.real > 0 else -1
        inner = [p for p in places if 0 < way * p < way * x.real]
        points = [0.0, *sorted(inner, key=abs), x]
        pairs = itertools.pairwise(points)
        return sum((force(a + 0j) + force(b + 0j)) / 2 * (b - a) for a, b in pairs)

    return energy


def squeezed(x: complex, half: float) -> complex:
    """How far a twist is beyond half the play."""
    return x - np.sign(x.real) * half if abs(x.real) > half else 0.0


def play_energy(at: Motion) -> complex:
    return at.p["c"] * squeezed(at.rel(at.q) - at.p["phi_rel0"], at.p["b"] / 2) ** 2 / 2


def play_heat(at: Motion) -> float:
    """Damping is at most as strong as the spring, in both directions."""
    elastic = at.p["c"] * squeezed(at.rel(at.q) - at.p["phi_rel0"], at.p["b"] / 2)
    return np.clip(at.p["d"] * at.rel(at.v), -abs(elastic), abs(elastic)) * at.rel(at.v)


def gap_energy(at: Motion) -> complex:
    short = at.p["s_rel0"] - at.rel(at.q)
    return at.p["c"] * short**2 / 2 if short.real > 0 else 0.0


def gap_heat(at: Motion) -> float:
    elastic = at.p["c"] * max(0.0, at.p["s_rel0"] - at.rel(at.q))
    return np.clip(at.p["d"] * at.rel(at.v), -elastic, elastic) * at.rel(at.v)


def carried(at: Motion) -> complex:
    """Energy of a body that moves with the flange while the command says so."""
    return at.p["J"] * at.v["flange"] ** 2 / 2 if at.p["u"] > 0.5 else 0.0


def element_energy(at: Motion) -> complex:
    moving = at.p["J_a"] * at.v["flange_a"] ** 2 + at.p["J_b"] * at.v["flange_b"] ** 2
    return (at.p["c"] * at.rel(at.q) ** 2 + moving) / 2


def bar(at: Motion) -> tuple[complex, complex]:
    """Complex stiffness and shares of inertia at the ends of a bar that vibrates."""
    c = at.p["c"] * (1 + 1j * at.p["eta"])
    z = at.p["w"] * np.sqrt((at.p["J_a"] + at.p["J_b"]) / c)
    return c * z / np.sin(z), np.tan(z / 2) / (z / 2)


def bar_energy(at: Motion) -> complex:
    c, share = (part.real for part in bar(at))
    moving = at.p["J_a"] * at.v["flange_a"] ** 2 + at.p["J_b"] * at.v["flange_b"] ** 2
    return (c * at.rel(at.q) ** 2 + share * moving) / 2


def bar_heat(at: Motion) -> float:
    c, share = (part.imag for part in bar(at))
    moving = at.p["J_a"] * at.v["flange_a"] ** 2 + at.p["J_b"] * at.v["flange_b"] ** 2
    return c / at.p["w_loss"] * at.rel(at.v) ** 2 - at.p["w"] * share * moving


def shaft_heat(at: Motion) -> float:
    """Two solid sections of diameter 1 m, 2 m and 1 m long."""
    between = at.x["sections[0].elements[0].w_b"]
    slips = between - at.v["flange_a"], at.v["flange_b"] - between
    c = at.p["G"] * np.pi / 32 * np.array([1 / 2.0, 1.0])
    return at.p["eta"] / at.p["w_loss"] * float(c @ np.square(slips))


def cylinder_energy(at: Motion) -> complex:
    moving = at.p["J"] * (at.v["flange_a"] ** 2 + at.v["flange_b"] ** 2) / 2
    return (at.p["c"] * at.rel(at.q) ** 2 + moving) / 2


def cone_energy(at: Motion) -> complex:
    """The inertia stands at the ends so that its centre is kept."""
    x, weight = np.polynomial.legendre.leggauss(8)
    x = (1 + x) / 2
    density = weight * ((at.p["d_a"] + (at.p["d_b"] - at.p["d_a"]) * x) ** 4 - at.p["bore"] ** 4)
    share = density @ x / density.sum()
    moving = (1 - share) * at.v["flange_a"] ** 2 + share * at.v["flange_b"] ** 2
    return (at.p["c"] * at.rel(at.q) ** 2 + at.p["J"] * moving) / 2


def shaft_energy(at: Motion) -> complex:
    """Two solid sections of diameter 1 m, 2 m and 1 m long."""
    between = at.x["sections[0].elements[0].w_b"]
    energy, per_metre = 0.0, np.pi / 32
    ends = (at.v["flange_a"], between, at.v["flange_b"])
    for i, L in enumerate((2.0, 1.0)):
        twist = at.x[f"sections[{i}].elements[0].phi_rel"]
        J = at.p["rho"] * per_metre * L
        energy += (
            at.p["G"] * per_metre / L * twist**2 + J * (ends[i] ** 2 + ends[i + 1] ** 2) / 2
        ) / 2
    return energy


BOTH_WAYS = (*((-x, -tau) for x, tau in reversed(COUPLING[1:])), *COUPLING)


def rubber_heat(at: Motion) -> float:
    places, torques = np.transpose(BOTH_WAYS)
    i = np.clip(np.searchsorted(places, at.rel(at.q)) - 1, 0, len(places) - 2)
    c = at.p["size"] * np.diff(torques)[i] / np.diff(places)[i]
    return at.p["psi"] * c / (2 * np.pi * at.p["w_loss"]) * at.rel(at.v) ** 2


def branch_energy(at: Motion) -> complex:
    """The branch of a coupling of 3 N.m/rad."""
    return at.p["share"] * 3.0 * (at.rel(at.q) - at.x["phi_d"]) ** 2 / 2


def branch_heat(at: Motion) -> float:
    return 2 * branch_energy(at).real / at.p["t_relax"]


def in_branches(at: Motion) -> Iterator[tuple[complex, float]]:
    """Energy and relaxation time of the branches of a coupling that is fitted to a catalogue."""
    for i, (share, time) in enumerate(maxwell_fit(0.5, 0.8, (1.0, 1.4), 2).branches):
        yield share * 3.0 * (at.rel(at.q) - at.x[f"branches[{i}].phi_d"]) ** 2 / 2, time


def maxwell_energy(at: Motion) -> complex:
    """Two branches beside half of the stiffness."""
    return 1.5 * at.rel(at.q) ** 2 / 2 + sum(energy for energy, _ in in_branches(at))


def maxwell_heat(at: Motion) -> float:
    return sum(2 * energy.real / time for energy, time in in_branches(at))


def swinging(at: Motion) -> complex:
    """Energy of a mass by its velocity along the arm of the carrier and across it."""
    a, w = at.x["phi_rel"], at.v["flange"]
    turning = w + at.x["w_rel"]
    along = -at.p["r"] * np.sin(a) * turning
    across = at.p["R"] * w + at.p["r"] * np.cos(a) * turning
    return at.p["m"] * (along**2 + across**2) / 2


def ring(at: Motion) -> complex:
    return at.p["J_ring"] * at.x["w"] ** 2 / 2


def sprung_ring(at: Motion) -> complex:
    return ring(at) + at.p["c"] * at.x["phi_rel"] ** 2 / 2


def dragged(at: Motion) -> float:
    return at.p["d"] * (at.v["flange"] - at.x["w"]) ** 2


def dragged_by_rubber(at: Motion) -> float:
    return at.p["c"] * at.p["eta"] / at.p["w_loss"] * (at.v["flange"] - at.x["w"]) ** 2


STORED: dict[type[lp.Component], Energy] = {
    Inertia: kinetic("J"),
    **dict.fromkeys(
        (sections.Disc, sections.Hollow, sections.Keyed, sections.Solid, sections.Splined),
        cylinder_energy,
    ),
    element.ShaftElement: element_energy,
    continuous.ContinuousElement: bar_energy,
    sections.Taper: cone_energy,
    shaft.Shaft: shaft_energy,
    contact.ElastoBacklash: play_energy,
    elastic_coupling.ElasticCoupling: lambda at: at.p["size"] * by_rows(None, BOTH_WAYS)(at),
    impact.PickUp: carried,
    maxwell_coupling.MaxwellBranch: branch_energy,
    maxwell_coupling.MaxwellCoupling: maxwell_energy,
    pendulum.CentrifugalPendulum: swinging,
    torsional_dampers.TunedDamper: sprung_ring,
    torsional_dampers.TunedLossDamper: sprung_ring,
    torsional_dampers.ViscousDamper: ring,
    rotation.NonlinearSpring: by_rows("phi_rel0"),
    rotation.Spring: elastic,
    rotation.LossSpring: elastic,
    rotation.SpringDamper: elastic,
    translation.ElastoGap: gap_energy,
    translation.MassWithLength: kinetic("m"),
    translation.MassWithStops: kinetic("m"),
    translation.MassWithStopAndFriction: kinetic("m"),
}


DISSIPATED: dict[type[lp.Component], Power] = {
    **dict.fromkeys(
        (
            *(sections.Disc, sections.Hollow, sections.Keyed),
            *(sections.Solid, sections.Splined, sections.Taper),
        ),
        lossy,
    ),
    continuous.ContinuousElement: bar_heat,
    windage.DiscWindage: dragged_disc,
    windage.GearWindage: dragged_gear,
    shaft.Shaft: shaft_heat,
    contact.ElastoBacklash: play_heat,
    elastic_coupling.ElasticCoupling: rubber_heat,
    maxwell_coupling.MaxwellBranch: branch_heat,
    maxwell_coupling.MaxwellCoupling: maxwell_heat,
    pendulum.CentrifugalPendulum: lambda at: at.p["d"] * at.x["w_rel"] ** 2,
    rotation.Damper: viscous,
    rotation.LossSpring: lossy,
    rotation.SpringDamper: viscous,
    torsional_dampers.TunedDamper: dragged,
    torsional_dampers.TunedLossDamper: dragged_by_rubber,
    torsional_dampers.ViscousDamper: dragged,
    translation.ElastoGap: gap_heat,
}
