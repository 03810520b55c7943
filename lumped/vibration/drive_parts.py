"""Which components of a drive are inertias, shafts and gears, as its modes show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError
from lumped.vibration.modes import Modes

__all__ = ["DriveParts", "drive_parts"]

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_FITS = 1e-6
"""Share of a torque that may remain unexplained, and below which a share is none."""
_STILL = 1e-11
"""Share of the largest amplitude below which a flange stands still."""


@dataclass(frozen=True, eq=False)
class DriveParts:
    """Parts of a drive by the paths of components; nodes are angles that are equal up to sign.

    Attributes
    ----------
    inertias : dict of str to (node, J)
        Moment of inertia, kg.m2.
    shafts : dict of str to (node a, node b, c)
        Stiffness, N.m/rad; None stands for the ground.
    gears : list of (path, node a, node b, ratio)
        Angle b is ratio times angle a.
    other : list of str
        Parts that transmit torque and are none of these, dampers apart.
    """

    inertias: dict[str, tuple[int, float]]
    shafts: dict[str, tuple[int | None, int | None, float]]
    gears: list[tuple[str, int, int, float]]
    other: list[str]


@dataclass(frozen=True, eq=False)
class _Flanges:
    """Amplitudes at the flanges of a component in all modes, shapes (flanges, k).

    A node is None where the flange stands still.
    """

    nodes: list[int | None]
    angles: Complex
    torques: Complex


def drive_parts(modes: Modes) -> DriveParts:
    """Inertias, shafts and gears of a drive.

    Parameters
    ----------
    modes : Modes
        Of the drive.

    Returns
    -------
    DriveParts

    Raises
    ------
    OptionError
        If there is no oscillating mode.
    """
    if not len(modes.eigenvalues):
        raise OptionError(f"{modes.system.name}: no oscillating mode, so that nothing vibrates.")
    values = np.append(modes.eigenvalues, modes.decays)  # decays tell as much as oscillations
    found = DriveParts({}, {}, [], [])
    for path, flanges in _loaded(modes, values):
        turning = [node for node in flanges.nodes if node is not None]
        total = flanges.torques.sum(axis=0)
        if len(turning) == len(flanges.nodes) and len(set(turning)) == 1:
            _on_one_shaft(found, path, turning[0], flanges.angles[0], total, values)
        elif len(flanges.nodes) == 2 and _share(total, flanges.torques) < _FITS:
            _between_shafts(found, path, flanges, values)
        else:
            _gear(found, path, flanges)
    return found


def _loaded(modes: Modes, values: Complex) -> Iterator[tuple[str, _Flanges]]:
    """Components without parts that transmit torque; each mode is scaled to a largest torque 1."""
    tree, reduced = modes.system.structure.tree, modes.system.structure.reduced
    unknowns: list[int] = []
    owners: list[int] = []
    for number, node in enumerate(tree.instances):
        quantities = node.layout.quantities
        for k in range(0, 0 if node.children else 2 * len(node.layout.ports), 2):
            if (quantities[k].unit, quantities[k + 1].unit) == ("rad", "N.m"):
                unknowns.append(node.first_unknown + k)
                owners.append(number)
    vectors = np.hstack([modes.vectors, modes.decay_vectors])
    angles, torques = (
        modes._of_unknowns([u + k for u in unknowns], vectors, values)
        * reduced.aliases.signs[unknowns][:, None]
        for k in (0, 1)
    )
    largest = np.abs(torques).max(axis=0)
    largest[largest == 0] = np.inf  # currents alone
    angles, torques = angles / largest, torques / largest
    moves = (np.abs(angles) > _STILL * np.abs(angles).max(axis=0)).any(axis=1)
    nodes = [reduced.node(u) if m else None for u, m in zip(unknowns, moves, strict=True)]
    for rows in np.split(np.arange(len(owners)), np.flatnonzero(np.diff(owners)) + 1):
        if (np.abs(torques[rows]) > _STILL).any() and moves[rows].any():
            own = [nodes[row] for row in rows]
            yield tree.instances[owners[rows[0]]].path, _Flanges(own, angles[rows], torques[rows])


def _on_one_shaft(
    found: DriveParts, path: str, node: int, angle: Complex, torque: Complex, values: Complex
) -> None:
    """An inertia, or a stiffness against the ground, with or without damping."""
    if _share(torque, torque) == 0:
        return
    terms = values**2 * angle, values * angle, angle
    (J, _), missed = _fit(torque, *terms[:2])
    if missed < _FITS and J > 0:
        if _share(J * terms[0], torque) > _FITS:
            found.inertias[path] = node, J
        return
    (c, _), missed = _fit(torque, terms[2], terms[1])
    if missed < _FITS and c > 0:
        found.shafts[path] = node, None, c
    else:
        found.other.append(path)


def _between_shafts(found: DriveParts, path: str, flanges: _Flanges, values: Complex) -> None:
    """A shaft, or a damper."""
    twist = flanges.angles[1] - flanges.angles[0]
    torque = flanges.torques[1]
    (c, _), missed = _fit(torque, twist, values * twist)
    if missed > _FITS:
        found.other.append(path)
    elif _share(c * twist, torque) > _FITS:
        found.shafts[path] = flanges.nodes[0], flanges.nodes[1], c


def _gear(found: DriveParts, path: str, flanges: _Flanges) -> None:
    """Flanges that turn in fixed ratios and pass all power on."""
    turning = [i for i, node in enumerate(flanges.nodes) if node is not None]
    first, *others = turning
    own = flanges.angles[first]
    power = flanges.torques[first].copy()
    gears: list[tuple[str, int, int, float]] = []
    for i in others:
        (ratio,), missed = _fit(flanges.angles[i], own)
        power += ratio * flanges.torques[i]
        a, b = flanges.nodes[first], flanges.nodes[i]
        assert a is not None
        assert b is not None
        gears.append((path, a, b, ratio))
        if missed > _FITS:
            found.other.append(path)
            return
    if gears and _share(power, flanges.torques[first]) < _FITS:
        found.gears.extend(gears)
    else:
        found.other.append(path)


def _fit(wanted: Complex, *terms: Complex) -> tuple[list[float], float]:
    """Real factors of terms whose sum is nearest to what is wanted, and the share missed."""
    matrix = np.column_stack([np.append(term.real, term.imag) for term in terms])
    size = np.linalg.norm(matrix, axis=0)
    scaled = matrix / np.where(size > 0, size, 1.0)
    right = np.append(wanted.real, wanted.imag)
    factors = np.linalg.lstsq(scaled, right)[0]
    missed = np.linalg.norm(scaled @ factors - right) / max(np.linalg.norm(right), 1e-300)
    return (factors / np.where(size > 0, size, 1.0)).tolist(), float(missed)


def _share(part: Complex, whole: Complex) -> float:
    return float(np.linalg.norm(part) / max(np.linalg.norm(whole), 1e-300))
