"""Where the energy of a mode is, what damps it, and where it stands still."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.ranking import list_largest, rank
from lumped.support.rich_html import RichHtml
from lumped.vibration.natural.modes import Modes, integrate_rates

_WORK = {("rad", "N.m"), ("m", "N")}
"""Units of potential and flow of a port whose product is work."""
_ROUNDING = 1e-9
_ROUNDLESS = 1e-13
_TOGETHER = 64
"""Modes of which amplitudes at all ports are held at once."""


@dataclass(frozen=True)
class Node:
    """A place that stands still in a mode, or moves least if the mode is damped.

    Attributes
    ----------
    component : str
        Path of the elastic component in which it lies.
    fraction : float
        How far along the component, from its first flange (0) to its second (1).
    amplitude : float
        What is left of the motion there; the largest of the mode is 1.
    """

    component: str
    fraction: float
    amplitude: float


@dataclass(frozen=True, eq=False)
class ModalEnergies(RichHtml):
    """Shares of components in the energies of the oscillating modes.

    Attributes
    ----------
    modes : Modes
        Whose energies they are.
    components : tuple of str
        Paths of the components that store energy or dissipate it.
    elastic, kinetic : ndarray, shape (k, len(components))
        Shares in the elastic and the kinetic energy; each sums to 1 in every mode, and to 0 in a
        mode of currents alone.
    damping : ndarray, shape (k, len(components))
        Contributions to the damping ratio, which is their sum; negative where a component feeds
        the vibration.
    """

    modes: Modes
    components: tuple[str, ...]
    elastic: Real
    kinetic: Real
    damping: Real

    @checked
    def nodes(self, mode: int) -> tuple[Node, ...]:
        """Nodes of a mode, in order of the components' declaration.

        Each lies in an elastic component of two flanges, along which the motion changes linearly.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        modes, found, ends = self.modes, [], dict[str, list[str]]()
        modes.check_mode(mode, "energies")
        tree = modes.system.structure.tree
        for owner, unknown in mechanical_ports(modes.system, _WORK):
            ends.setdefault(tree.instances[owner].path, []).append(tree.unknown_name(unknown))
        for path, share in zip(self.components, self.elastic[mode], strict=True):
            if not share > 0 or len(ends[path]) != 2:
                continue
            a, b = (complex(modes.shape(end)[mode]) for end in ends[path])
            way = b - a
            fraction = -(way.conjugate() * a).real / abs(way) ** 2 if way else -1.0
            if 0 < fraction < 1:
                found.append(Node(path, fraction, abs(a + fraction * way)))
        return tuple(found)

    @checked
    def ranked(self, mode: int) -> tuple[list[tuple[str, float]], list[tuple[str, float]]]:
        """Components and shares in the elastic, then the kinetic energy, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        self.modes.check_mode(mode, "energies")
        elastic, kinetic = (
            [(name, share) for name, share in rank(self.components, shares[mode]) if share > 0]
            for shares in (self.elastic, self.kinetic)
        )
        return elastic, kinetic

    def __repr__(self) -> str:
        rows = []
        for i, damping in enumerate(self.damping[:30]):
            texts = [
                list_largest([(name, 100 * share) for name, share in shares], "{} {:.1f} %")
                for shares in self.ranked(i)
            ]
            losses = [(n, v) for n, v in zip(self.components, damping, strict=True) if v]
            rows.append((*texts, list_largest(losses, "{} {:.3g}") or "none"))
        head = ("elastic energy", "kinetic energy", "damping ratio")
        moves = self.kinetic.any(axis=1)
        gaps = np.abs(self.damping.sum(axis=1) - self.modes.damping)
        missed = gaps[moves].max(initial=0.0)
        text = f"{self.modes.system.name}: {self.modes.accuracy}; "
        text += f"contributions miss the damping ratio by {missed:.1e}\n"
        return text + self.modes.list_modes(head, rows)


def mechanical_ports(system: System, units: Collection[tuple[str, str]]) -> list[tuple[int, int]]:
    """Numbers of components, and of the angles or positions at their ports.

    Parameters
    ----------
    units : collection of (str, str)
        Those of potential and flow.
    """
    found = []
    for number, node in enumerate(system.structure.tree.instances):
        quantities = node.layout.quantities
        for i in range(0, 2 * len(node.layout.ports), 2):
            if (quantities[i].unit, quantities[i + 1].unit) in units:
                found.append((number, node.first_unknown + i))
    return found


@checked
def modal_energies(modes: Modes) -> ModalEnergies:
    """Shares of components in the elastic and kinetic energy of each oscillating mode.

    The sum of flow times potential over the ports of a component, with amplitudes,
    ``z = sum(f conj(q))``, is ``k + l d + l^2 m`` at the eigenvalue ``l``, with ``k`` twice its
    greatest elastic energy, ``m`` that of the kinetic energy over the speed squared, and ``d`` its
    loss: ``c abs(q_rel)^2``, ``J abs(q)^2`` and ``d abs(q_rel)^2`` for spring, inertia and damper.
    Over a whole drive z vanishes, so that ``sum(k) == abs(l)^2 sum(m)`` and the damping ratio is
    ``sum(d) / (2 abs(l) sum(m))``, exactly (Goldstein, Classical Mechanics, sec. 3.4, for the
    undamped case). A component is elastic where z allows it without a mass, else kinetic; one that
    stores both energies counts with their difference.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`.

    Returns
    -------
    ModalEnergies

    Raises
    ------
    OptionError
        If there is no oscillating mode, or the modes are those of a mean over turns.
    UnknownNameError
        If a flange was left out of the system by ``of=``.
    """
    modes.refuse_mean("modal_energies")
    system = modes.system
    if not len(modes.eigenvalues):
        raise OptionError(f"{system.name}: no oscillating mode has energy.")
    tree, sums = system.structure.tree, _sum_work(modes)
    sizes = np.abs(sums)
    size = sizes.max(axis=0)
    sums[sizes <= _ROUNDING * size] = 0.0  # gears, supports, composites
    values, angular = modes.eigenvalues, np.abs(modes.eigenvalues)
    loss = sums.imag / values.imag
    elastic = sums.real - values.real * loss
    elastic[np.abs(elastic) <= _ROUNDING * size] = 0.0
    kinetic = np.maximum(-elastic, 0.0)
    loss -= 2 * values.real / angular**2 * kinetic
    loss[np.abs(loss * angular) <= _ROUNDLESS * size] = 0.0
    elastic = np.maximum(elastic, 0.0)
    used = np.flatnonzero((elastic + kinetic + np.abs(loss)).any(axis=1))
    # currents alone oscillate in a mode without mechanical energy, which has no shares
    moves = (elastic.sum(axis=0) > 0) & (kinetic.sum(axis=0) > 0)
    all_elastic, all_kinetic = (np.where(moves, e.sum(axis=0), np.inf) for e in (elastic, kinetic))
    return ModalEnergies(
        modes,
        tuple(tree.instances[i].path for i in used.tolist()),
        (elastic[used] / all_elastic).T,
        (kinetic[used] / all_kinetic).T,
        (loss[used] * angular / (2 * all_kinetic)).T,
    )


def _sum_work(modes: Modes) -> Complex:
    """Sum of flow times potential over the ports of each component, shape (components, k).

    What parts store is theirs, and not that of what encloses them.
    """
    instances = modes.system.structure.tree.instances
    ports = mechanical_ports(modes.system, _WORK)
    owners = np.array([number for number, _ in ports], dtype=int)
    parents = np.array([instances[owner].parent for owner in owners.tolist()], dtype=int)
    inner = np.flatnonzero(parents >= 0)
    shares = np.append(np.ones(len(owners)), -np.ones(len(inner)))
    places = np.append(owners, parents[inner]), np.append(np.arange(len(owners)), inner)
    of_ports = scipy.sparse.csr_array((shares, places), (len(instances), len(owners)))
    potential, flow = (modes._slopes_of([unknown + k for _, unknown in ports]) for k in (0, 1))
    found = np.empty((len(instances), len(modes.eigenvalues)), dtype=complex)
    for first in range(0, found.shape[1], _TOGETHER):
        own = slice(first, first + _TOGETHER)
        potentials, flows = (
            integrate_rates(slopes @ modes.vectors[:, own], depths, modes.eigenvalues[own])
            for slopes, depths in (potential, flow)
        )
        found[:, own] = of_ports @ (flows * potentials.conj())
    return found


@dataclass(frozen=True, eq=False)
class Participation(RichHtml):
    """Participation factors of the oscillating modes.

    Attributes
    ----------
    modes : Modes
        Whose factors they are.
    factors : ndarray of complex, shape (k, n)
        In the order of ``modes.system.state_names``; each row sums to 1.
    """

    modes: Modes
    factors: Complex

    @checked
    def ranked(self, mode: int) -> list[tuple[str, float]]:
        """States and magnitudes of their factors in a mode, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        self.modes.check_mode(mode, "participation")
        ranked = rank(self.modes.system.state_names, np.abs(self.factors[mode]))
        return [(name, size) for name, size in ranked if size > 1e-12]

    def __repr__(self) -> str:
        rows = [
            (list_largest(self.ranked(i), "{} {:.3f}", 5),)
            for i in range(min(len(self.factors), 30))
        ]
        head = f"{self.modes.system.name}: {self.modes.accuracy}\n"
        return head + self.modes.list_modes(("participation",), rows)


@checked
def participation(modes: Modes) -> Participation:
    """Participation factors ``conj(y_i) x_i`` of states in modes.

    ``x`` and ``y`` are right and left eigenvectors with ``y^H x == 1``; the factors do not depend
    on units (Perez-Arriaga, Verghese and Schweppe, IEEE Trans. Power Apparatus and Systems 101,
    1982). They say where a mode is seen and acted upon at once: which states of motor and control
    belong to it as well as which torsions and speeds. A factor is also the derivative of the
    eigenvalue by the diagonal entry of the state matrix.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`; eigenvalues that repeat in one connected drive have no factors of
        their own (nan or large numbers).

    Returns
    -------
    Participation

    Raises
    ------
    OptionError
        If there is no oscillating mode.
    """
    if not len(modes.eigenvalues):
        raise OptionError(f"{modes.system.name}: no oscillating mode.")
    return Participation(modes, (modes.left_vectors.conj() * modes.vectors).T)
