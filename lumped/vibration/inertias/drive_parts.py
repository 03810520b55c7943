"""Which components of a drive are inertias, shafts and gears, by what they do to small motions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.support.arrays import Real
from lumped.vibration.inertias.own_inertias import HeavyShaft, heavy_shafts, mean_inertias
from lumped.vibration.natural.energies import mechanical_ports
from lumped.vibration.natural.modes import Modes

_FITS = 1e-6
"""Share of a torque that may remain unexplained, and below which a share is none."""


@dataclass(frozen=True, eq=False)
class DriveParts:
    """Parts of a drive by the paths of components; nodes are angles that are equal up to sign.

    Attributes
    ----------
    inertias : dict of str to (node, J)
        Moment of inertia, kg.m2; those of a shaft by the names of its flanges.
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
    """Slopes by the states of what acts at the flanges of a component, shapes (flanges, states).

    Attributes
    ----------
    nodes : list of (int or None)
        Angle of each flange; None where it stands still.
    repeats : bool
        The torques depend on the angle of a steady rotation; after its turns they are the same.
    speeds, accelerations : ndarray
        Of the flanges.
    torques, rates : ndarray
        Torques and their derivatives.
    """

    nodes: list[int | None]
    repeats: bool
    speeds: Real
    accelerations: Real
    torques: Real
    rates: Real


def drive_parts(modes: Modes) -> DriveParts:
    """Inertias, shafts and gears of a drive, linearised at the point of its modes.

    Of modes of a mean over turns, inertias are means over the turns, too. The mean stiffness of a
    torque that depends on the angle of the shaft, as that of a propeller's blades, is none: the
    torque is the same after the turns.

    Raises
    ------
    UnknownNameError
        If a flange was left out of the system by ``of=``.
    """
    found = DriveParts({}, {}, [], [])
    heavy = heavy_shafts(modes.system, modes.point)
    means = {} if modes.mean is None else mean_inertias(modes.system, modes.point)
    for path, flanges in _find_loaded_parts(modes):
        turning = [node for node in flanges.nodes if node is not None]
        total = flanges.torques.sum(axis=0)
        if path in heavy:
            _with_ends(found, path, heavy[path], flanges)
        elif path in means and turning:
            found.inertias[path] = turning[0], means[path]
        elif len(turning) == len(flanges.nodes) and len(set(turning)) == 1:
            _on_one_shaft(found, path, turning[0], flanges)
        elif gears := _gears(path, flanges):
            found.gears.extend(gears)
        elif len(flanges.nodes) == 2 and _share(total, flanges.torques) < _FITS:
            _between_shafts(found, path, flanges)
        else:
            found.other.append(path)
    return found


def _find_loaded_parts(modes: Modes) -> Iterator[tuple[str, _Flanges]]:
    """Components without parts of their own that transmit torque."""
    tree, reduced = modes.system.structure.tree, modes.system.structure.reduced
    ports = [
        (owner, unknown)
        for owner, unknown in mechanical_ports(modes.system, {("rad", "N.m")})
        if not tree.instances[owner].children
    ]
    owners, unknowns = [owner for owner, _ in ports], [unknown for _, unknown in ports]
    A = scipy.sparse.csr_array(modes.system.state_matrix(modes.point.inputs))
    angles, depths = modes._slopes_of(unknowns)
    once = angles @ A
    rising = scipy.sparse.diags_array((depths > 0).astype(float))
    speeds = rising @ angles + (once - rising @ once)
    torques = modes._slopes_of([unknown + 1 for unknown in unknowns])[0]
    signs = scipy.sparse.diags_array(reduced.aliases.signs[unknowns].astype(float))
    every = [
        scipy.sparse.csr_array(signs @ each) for each in (speeds, speeds @ A, torques, torques @ A)
    ]
    turning = np.zeros(A.shape[0]) if modes.turning is None else modes.turning
    growth, sizes = torques @ turning, abs(torques) @ np.abs(turning)
    for rows in np.split(np.arange(len(owners)), np.flatnonzero(np.diff(owners)) + 1):
        own = [each[rows] for each in every]
        columns = np.unique(np.concatenate([each.indices for each in own]))
        numbers = [each[:, columns].toarray() for each in own]
        if not (numbers[2].any() and numbers[0].any()):
            continue
        nodes = [
            reduced.node(unknowns[row]) if speed.any() else None
            for row, speed in zip(rows.tolist(), numbers[0], strict=True)
        ]
        repeats = bool((np.abs(growth[rows]) > _FITS * sizes[rows]).any())
        path = tree.instances[owners[rows[0]]].path
        yield path, _Flanges(nodes, repeats, *numbers)


def _on_one_shaft(found: DriveParts, path: str, node: int, flanges: _Flanges) -> None:
    """An inertia, or a damper."""
    speed, acceleration = flanges.speeds[0], flanges.accelerations[0]
    torque = flanges.torques.sum(axis=0)
    if _share(torque, flanges.torques) < _FITS:
        return
    (J, _), missed = _fit_terms(torque, acceleration, speed)
    if missed < _FITS and _share(J * acceleration, torque) < _FITS:
        return
    if missed < _FITS and J > 0:
        found.inertias[path] = node, J
    else:
        found.other.append(path)


def _between_shafts(found: DriveParts, path: str, flanges: _Flanges) -> None:
    """A shaft, or a damper."""
    slip = flanges.speeds[1] - flanges.speeds[0]
    more = flanges.accelerations[1] - flanges.accelerations[0]
    (c, _), missed = _fit_terms(flanges.rates[1], slip, more)
    if missed < _FITS and (flanges.repeats or _share(c * slip, flanges.rates[1]) < _FITS):
        return
    if missed < _FITS and c > 0:
        found.shafts[path] = flanges.nodes[0], flanges.nodes[1], c
    else:
        found.other.append(path)


def _with_ends(found: DriveParts, path: str, shaft: HeavyShaft, flanges: _Flanges) -> None:
    """A shaft with an inertia at each flange; that at rest with the ground has none."""
    a, b = flanges.nodes
    found.shafts[path] = a, b, shaft.c
    for node, name, J in zip((a, b), shaft.flanges, shaft.J, strict=True):
        if node is not None:
            found.inertias[f"{path}.{name}"] = node, J


def _gears(path: str, flanges: _Flanges) -> list[tuple[str, int, int, float]]:
    """Links between flanges that turn in fixed ratios and pass all power on, if they all do."""
    (first, a), *others = [(i, node) for i, node in enumerate(flanges.nodes) if node is not None]
    power = flanges.torques[first].copy()
    found = []
    for i, b in others:
        (ratio,), missed = _fit_terms(flanges.speeds[i], flanges.speeds[first])
        if missed > _FITS:
            return []
        power += ratio * flanges.torques[i]
        found.append((path, a, b, ratio))
    return found if _share(power, flanges.torques[first]) < _FITS else []


def _fit_terms(wanted: Real, *terms: Real) -> tuple[list[float], float]:
    """Factors of terms whose sum is nearest to what is wanted, and the share missed."""
    matrix = np.column_stack(terms)
    size = np.linalg.norm(matrix, axis=0)
    size[size == 0] = 1.0
    factors = np.linalg.lstsq(matrix / size, wanted)[0]
    own = factors / size
    return own.tolist(), _share(matrix @ own - wanted, wanted)


def _share(part: Real, whole: Real) -> float:
    return float(np.linalg.norm(part)) / max(float(np.linalg.norm(whole)), 1e-300)
