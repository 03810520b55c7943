"""Inertias and stiffnesses of a drive, each on its own shaft and referred to one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.display_units import Units
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import list_names, number, table
from lumped.vibration.inertias.drive_parts import DriveParts, drive_parts
from lumped.vibration.inertias.holzer import (
    ElasticPart,
    Holzer,
    InertialPart,
    Part,
    head_sizes,
    in_columns,
    measure,
)
from lumped.vibration.natural.modes import Modes

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class MassElastic(RichHtml):
    """Inertias and stiffnesses of a drive, in the order from its free ends to its last inertia.

    Attributes
    ----------
    name, shaft : str
        The model, and the angle of the reference shaft.
    parts : tuple of InertialPart or ElasticPart
        A branch precedes the inertia that it joins.
    left_out : tuple of str
        Parts that transmit torque and are neither, such as a differential, a machine whose torque
        lags, or a crank, and parts that no ratio joins to the reference shaft.
    """

    name: str
    shaft: str
    parts: tuple[Part, ...]
    left_out: tuple[str, ...]

    @property
    def inertias(self) -> tuple[InertialPart, ...]:
        """The inertias alone."""
        return tuple(part for part in self.parts if isinstance(part, InertialPart))

    @property
    def shafts(self) -> tuple[ElasticPart, ...]:
        """The stiffnesses alone."""
        return tuple(part for part in self.parts if isinstance(part, ElasticPart))

    @property
    def hertz(self) -> Real:
        """Natural frequencies without damping, ascending, Hz."""
        return self._solved[0] / (2 * np.pi)

    @checked
    def holzer(self, mode: int) -> Holzer:
        """Angles and torques of all parts in a mode without damping.

        Parameters
        ----------
        mode : int
            Number of the mode by natural frequency, from 0.

        Returns
        -------
        Holzer

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        w, angles, roots = self._solved
        if not 0 <= mode < len(w):
            raise OptionError(f"{self.name}: there is no mode {mode}; {len(w)} modes count from 0.")
        found, rest, shaft = [], np.zeros(len(angles)), 0
        for part in self.parts:
            if isinstance(part, InertialPart):
                theta = angles[part.station, mode]
                torque = part.referred * w[mode] ** 2 * theta
                rest[part.station] += torque
            else:
                torque = np.sqrt(part.referred) * roots[shaft, mode]
                theta, shaft = torque / part.referred, shaft + 1
                for station, sign in zip(part.stations, (1.0, -1.0), strict=True):
                    if station >= 0:
                        rest[station] += sign * torque
            found.append((theta, torque))
        turned, torques = np.array(found).T
        ratio = np.array([part.ratio for part in self.parts])
        last = self.inertias[-1]
        return Holzer(
            self.name,
            self.shaft,
            self.parts,
            mode,
            float(w[mode] / (2 * np.pi)),
            turned * ratio,
            torques / ratio,
            float(rest[last.station] / last.ratio),
            {station: float(angles[station, mode]) for station in self._stations},
            float(np.abs(rest).max() / np.abs(torques).max()),
        )

    @property
    def _stations(self) -> list[int]:
        """Stations in the order of the parts; one without an inertia comes with its shaft."""
        heavy = {part.station for part in self.inertias}
        found: dict[int, None] = {}
        for part in self.parts:
            if isinstance(part, InertialPart):
                found[part.station] = None
            else:
                found.update((end, None) for end in part.stations if end not in heavy | {-1})
        return list(found)

    @cached_property
    def _solved(self) -> tuple[Real, Real, Real]:
        """Angular frequencies, referred angles, and torques over the roots of stiffnesses.

        Shapes (k,), (stations, k) and (shafts, k). Singular values of ``C^(1/2) B M^(-1/2)`` have
        the relative error of a frequency; the eigenvalues of ``M^-1 K`` have that of its square.
        """
        inertias, shafts = self.inertias, self.shafts
        count = 1 + max(max(part.stations) for part in shafts)
        M = np.zeros(count)
        np.add.at(M, [part.station for part in inertias], [part.referred for part in inertias])
        G = np.zeros((len(shafts), count))
        for row, part in zip(G, shafts, strict=True):
            for station, sign in zip(part.stations, (-1.0, 1.0), strict=True):
                if station >= 0:
                    row[station] += sign * np.sqrt(part.referred)
        heavy, light = M > 0, M <= 0
        base = scipy.linalg.orth(G[:, light]) if light.any() else np.zeros((len(shafts), 0))
        root = np.sqrt(M[heavy])
        scaled = (G[:, heavy] - base @ (base.T @ G[:, heavy])) / root
        U, s, V = np.linalg.svd(scaled, full_matrices=False)
        kept = np.flatnonzero(s > 1e-13 * s.max())[::-1]
        angles = np.zeros((count, len(kept)))
        angles[heavy] = V[kept].T / root[:, None]
        if light.any():
            angles[light] = -np.linalg.lstsq(G[:, light], G[:, heavy] @ angles[heavy])[0]
        scale = angles[np.abs(angles).argmax(axis=0), np.arange(len(kept))]
        return s[kept], angles / scale, U[:, kept] * s[kept] / scale

    def __repr__(self) -> str:
        head = f"{self.name}: {len(self.inertias)} inertias and {len(self.shafts)} stiffnesses, "
        head += f"referred to {self.shaft}"
        if self.left_out:
            head += f"\nleft out: {list_names(self.left_out)}"
        return f"{head}\n" + table(*self.list_parts())

    def list_parts(self, units: Units = None) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Heads and rows of a table of all parts, on their own shafts and referred to one."""
        rows = []
        for part in self.parts:
            own, shown = measure(part, units)
            texts = (number(shown.value(size)) for size in (own, part.referred))
            rows.append((part.name, number(part.ratio), *in_columns(part, texts)))
        return ("part", "ratio", *head_sizes(units), "J referred", "c referred"), rows


@checked
def mass_elastic(modes: Modes, *, shaft: Name) -> MassElastic:
    """Inertias and stiffnesses of a drive with branches and gears, referred to one of its shafts.

    Components are known by what they do to small motions about the operating point of the modes: an
    inertia transmits ``J der(w)``, a shaft ``der(tau) = c w_rel``, a gear passes all power on in a
    fixed ratio; dampers drop out, and so does the damping of the others. A law that is not linear
    counts with its slope there.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`.
    shaft : name
        Angle of the reference shaft, rad.

    Returns
    -------
    MassElastic

    Raises
    ------
    OptionError
        If the drive has no inertia or no stiffness, or no ratio joins its shafts.
    """
    name = modes.system.key(shaft)
    found = drive_parts(modes)
    ratios = _ratios(modes, found, shaft)
    station = _stations(found, ratios)
    left = list(found.other)
    inertias, shafts = [], []
    for path, (node, J) in found.inertias.items():
        if node in ratios:
            inertias.append(InertialPart(path, ratios[node], J, station[node]))
        else:
            left.append(path)
    for path, (a, b, c) in found.shafts.items():
        ends = [end for end in (a, b) if end is not None]
        if ends[0] in ratios:
            joined = tuple(-1 if end is None else station[end] for end in (a, b))
            shafts.append(ElasticPart(path, ratios[ends[0]], c, (joined[0], joined[1])))
        else:
            left.append(path)
    if not inertias or not shafts:
        raise OptionError(
            f"{modes.system.name}: no inertia and no shaft vibrate together with {name}; name the "
            "angle of a shaft of the drive."
        )
    return MassElastic(modes.system.name, name, tuple(_in_order(inertias, shafts)), tuple(left))


def _ratios(modes: Modes, found: DriveParts, shaft: Name) -> dict[int, float]:
    """Ratio of each angle to the reference, by its node; those that are not joined are missing."""
    import networkx as nx

    tree, reduced = modes.system.structure.tree, modes.system.structure.reduced
    unknown = tree.unknown(shaft)
    begin = reduced.node(unknown)
    if begin is None:
        raise OptionError(f"{modes.system.name}: {shaft} was left out of the system.")
    joints = nx.MultiDiGraph()
    joints.add_node(begin)
    links = [(a, b, ratio, path) for path, a, b, ratio in found.gears]
    links += [
        (a, b, 1.0, path)
        for path, (a, b, _) in found.shafts.items()
        if a is not None and b is not None
    ]
    for a, b, ratio, path in links:
        joints.add_edge(a, b, path, ratio=ratio)
        joints.add_edge(b, a, path, ratio=1 / ratio)
    ratios = {begin: float(reduced.aliases.signs[unknown])}
    for a, b in nx.dfs_edges(joints, begin):
        ratios[b] = ratios[a] * next(iter(joints[a][b].values()))["ratio"]
    for a, b, path, ratio in joints.edges(keys=True, data="ratio"):
        if a in ratios and abs(ratios[b] - ratios[a] * ratio) > _ROUNDING * abs(ratios[b]):
            raise OptionError(
                f"{modes.system.name}: {path} closes a loop of shafts whose ratios do not agree "
                f"({ratios[b]:.9g} and {ratios[a] * ratio:.9g}), so that nothing can be referred "
                f"to {shaft}."
            )
    return ratios


def _stations(found: DriveParts, ratios: dict[int, float]) -> dict[int, int]:
    """Number of the station of each node; gears join nodes."""
    import networkx as nx

    rigid = nx.Graph([(a, b) for _, a, b, _ in found.gears if a in ratios])
    rigid.add_nodes_from(ratios)
    groups = enumerate(nx.connected_components(rigid))
    return {node: number for number, group in groups for node in group}


def _in_order(inertias: list[InertialPart], shafts: list[ElasticPart]) -> Iterator[Part]:
    """Parts from the free ends to the last inertia, a branch before the inertia that it joins."""
    import networkx as nx

    at: dict[int, list[InertialPart]] = {}
    for each in inertias:
        at.setdefault(each.station, []).append(each)
    root, joined = inertias[-1].station, nx.Graph()
    joined.add_node(root)
    for shaft in shafts:
        joined.add_edges_from((end, shaft) for end in shaft.stations if end >= 0)
    for node in nx.dfs_postorder_nodes(joined, root):
        yield from [node] if isinstance(node, ElasticPart) else at.get(node, ())
