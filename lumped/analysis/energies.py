"""Where the energy of a mode is: elastic and kinetic shares of components."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumped.analysis.modes import Modes
from lumped.errors import OptionError
from lumped.table import number, table

__all__ = ["ModalEnergies", "modal_energies"]

Real = NDArray[np.float64]

_WORK = {("rad", "N.m"), ("m", "N")}
"""Units of potential and flow of a port whose product is work."""
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class ModalEnergies:
    """Shares of components in the energies of the oscillating modes.

    Attributes
    ----------
    modes : Modes
        Whose energies they are.
    components : tuple of str
        Paths of the components that store energy.
    elastic, kinetic : ndarray, shape (k, len(components))
        Shares in the elastic and the kinetic energy; each sums to 1 in every mode.
    """

    modes: Modes
    components: tuple[str, ...]
    elastic: Real
    kinetic: Real

    def ranked(self, mode: int) -> tuple[list[tuple[str, float]], list[tuple[str, float]]]:
        """Components and shares in the elastic, then the kinetic energy, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        if not 0 <= mode < len(self.elastic):
            raise OptionError(f"energies: mode {mode} of {len(self.elastic)}; modes count from 0.")
        found = []
        for shares in (self.elastic[mode], self.kinetic[mode]):
            order = [i for i in np.argsort(-shares, kind="stable").tolist() if shares[i] > 0]
            found.append([(self.components[i], float(shares[i])) for i in order])
        return found[0], found[1]

    def __repr__(self) -> str:
        rows = []
        for i, hertz in enumerate(self.modes.hertz[:30]):
            texts = ["; ".join(f"{n} {100 * v:.1f} %" for n, v in x[:4]) for x in self.ranked(i)]
            rows.append((str(i + 1), number(hertz, 9), *texts))
        head = ("mode", "natural frequency, Hz", "elastic energy", "kinetic energy")
        return f"{self.modes.system.name}\n" + table(head, rows)


def modal_energies(modes: Modes) -> ModalEnergies:
    """Shares of components in the elastic and kinetic energy of each oscillating mode.

    The sum of flow times potential over the ports of a component, with amplitudes,
    ``re(sum(f conj(q))) / 2``, is its greatest elastic energy less its greatest kinetic energy:
    ``c abs(q_rel)**2 / 2`` for a spring and ``-w**2 J abs(q)**2 / 2`` for an inertia. Over a whole
    drive it vanishes (virial theorem; Goldstein, Classical Mechanics, sec. 3.4), so a component is
    elastic where it is positive, and kinetic where it is negative. A component that stores both
    counts with their difference. With damping the shares are those of the same amplitudes, exact
    to the square of the damping ratio; dampers then have shares of that size.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`.

    Raises
    ------
    OptionError
        If there is no oscillating mode.
    UnknownNameError
        If a flange was left out of the system by ``outputs=``.
    """
    system = modes.system
    if not len(modes.eigenvalues):
        raise OptionError(f"{system.name}: no oscillating mode has energy.")
    tree = system._tree
    owners: list[int] = []
    unknowns: list[int] = []
    for number_, node in enumerate(tree.nodes):
        quantities = node.layout.quantities
        for i in range(0, 2 * len(node.layout.ports), 2):
            if (quantities[i].unit, quantities[i + 1].unit) in _WORK:
                owners.append(number_)
                unknowns.append(node.first_unknown + i)
    potentials, flows = (
        modes._of_unknowns([u + k for u in unknowns], modes.vectors, modes.eigenvalues)
        for k in (0, 1)
    )
    whole = np.zeros((len(tree.nodes), len(modes.eigenvalues)))
    np.add.at(whole, owners, (flows * potentials.conj()).real)
    sums = whole.copy()
    for number_, node in enumerate(tree.nodes):
        if node.parent >= 0:  # what parts store is theirs
            sums[node.parent] -= whole[number_]
    size = np.abs(sums).max(axis=0)
    sums[np.abs(sums) <= _ROUNDING * size] = 0.0  # gears, supports, composites
    elastic, kinetic = np.maximum(sums, 0.0), np.maximum(-sums, 0.0)
    used = np.flatnonzero(sums.any(axis=1))
    return ModalEnergies(
        modes,
        tuple(tree.nodes[i].path for i in used.tolist()),
        (elastic[used] / elastic.sum(axis=0)).T,
        (kinetic[used] / kinetic.sum(axis=0)).T,
    )
