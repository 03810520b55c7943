"""Natural frequencies, damping ratios and mode shapes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Unpack

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, UnknownNameError
from lumped.plots.draw import Canvas, draw
from lumped.points.situation import one_sided, situation
from lumped.points.start_values import relative_positions
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Integer, Real
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.support.made_once import made_once
from lumped.support.text_table import number
from lumped.vibration.natural.eigenpairs import (
    Accuracy,
    Eigenpairs,
    count_lost_eigenvalues,
    find_accuracy,
)
from lumped.vibration.pictures import mode_shapes_picture

_MOST_DRAWN = 16


@dataclass(frozen=True, eq=False)
class Modes(Eigenpairs):
    """Modes of a linearised system, sorted by natural frequency.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (k,)
        One of each conjugate pair of the oscillating modes, 1/s.
    decays : ndarray, shape (r,)
        Real eigenvalues other than those of rigid-body modes, ascending, 1/s; positive ones grow.
    vectors, decay_vectors : ndarray of complex, shapes (n, k) and (n, r)
        Their eigenvectors in the states, in columns.
    point : OperatingPoint
        Where the system was linearised.
    near : float or None
        Frequency to which the modes are nearest, Hz, if only some were asked for.
    mean : csr_array or None
        State matrix, if it is a mean over turns and not that of the point.
    turning : ndarray or None
        By what each state grows with the angle of the shaft over these turns, shape (n,).
    """

    @property
    def rigid_names(self) -> tuple[str, ...]:
        """What turns or moves together in each rigid-body mode, or the play that opens in it."""
        names = self.angles
        shapes = self._rigid_positions / _find_scale(self._rigid_positions)
        relative = np.isin(self.system.structure.states, relative_positions(self.system))
        found = []
        for column, raw in zip(shapes.T, self.rigid_vectors.T, strict=True):
            together = [n for n, v in zip(names, column, strict=True) if abs(v) > 1e-6]
            none = ""
            if not together:  # what only keeps its value: a play, an integral of control, a count
                kept = np.flatnonzero(np.abs(raw) > 1e-6 * np.abs(raw).max())
                together = [self.system.state_names[i] for i in kept]
                none = "" if relative[kept].any() else "no body, "
            more = f", ... {len(together) - 6} more" if len(together) > 6 else ""
            found.append(none + ", ".join(together[:6]) + more)
        return tuple(found)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Residuals and conditions of the oscillating modes."""
        return find_accuracy(self)

    @cached_property
    def lost(self) -> int:
        """Eigenvalues that are not zero, but below the rounding of the highest.

        They count among the rigid-body modes, beside stiffnesses that differ by a factor of some
        1e26. Not looked at where only some modes were asked for, and above 500 states.
        """
        return count_lost_eigenvalues(self)

    @property
    def angles(self) -> list[str]:
        """Names of all angles and positions that move by themselves, in order of declaration."""
        return [self.system.structure.node_name(node) for node in self._position_nodes]

    @checked
    def shape(self, name: Name) -> Real | Complex:
        """Amplitudes of a quantity in all oscillating modes, shape (k,).

        Each mode is scaled so that the largest angle (position) of a body is 1. Real if the
        system is undamped, else complex (its argument is the phase).

        Raises
        ------
        UnknownNameError
            If there is no such quantity.
        """
        values = self._amplitudes(name, self.vectors, self.eigenvalues) / _find_scale(
            self._positions
        )
        real = np.abs(values.imag) <= 1e-9 * np.maximum(np.abs(values), 1e-12)
        return values.real if (self.damping == 0).all() and real.all() else values

    @checked
    def rigid_shape(self, name: Name) -> Real:
        """Relative speeds (or angles) of a quantity in all rigid-body modes."""
        raw = self._amplitudes(name, self.rigid_vectors, np.zeros(self.rigid))
        return (raw / _find_scale(self._rigid_positions)).real

    def _amplitudes(self, name: Name, vectors: Complex | Real, values: Complex | Real) -> Complex:
        unknown = self.system.structure.tree.unknown(name)
        found: Complex = self._of_unknowns([unknown], vectors, values)[0]
        return found

    def _of_unknowns(
        self, unknowns: list[int], vectors: Complex | Real, values: Complex | Real
    ) -> Complex:
        """Unscaled amplitudes of unknowns, by number, shape (len(unknowns), len(values))."""
        slopes, depths = self._slopes_of(unknowns, speeds_first=bool(np.any(values)))
        return integrate_rates(slopes @ vectors, depths, values)

    def _of_positions(self, vectors: Complex | Real, values: Complex | Real) -> Complex:
        """Amplitudes of all angles and positions of ports; where there are none, of the states."""
        nodes = self._position_nodes
        if not nodes:
            return np.abs(vectors).astype(complex)
        # an angle that the states give has no speed in a rigid-body mode
        found = self._lowest(nodes, speeds_first=bool(np.any(values)))
        rows = [row for row in found if row is not None]
        return integrate_rates(self._by_states(rows) @ vectors, np.subtract(rows, nodes), values)

    def _slopes_of(
        self, unknowns: list[int], *, speeds_first: bool = True
    ) -> tuple[scipy.sparse.csr_array, Integer]:
        """Slopes of unknowns by the states, or of their lowest derivatives, and orders of these."""
        alive, rows, found = self._find_rows(unknowns, speeds_first=speeds_first)
        depths = np.zeros(len(unknowns), dtype=int)
        depths[alive] = found
        signs = self.system.structure.reduced.aliases.signs[np.array(unknowns)[alive]]
        spread = scipy.sparse.csr_array(
            (signs.astype(float), (alive, np.arange(len(alive)))),
            shape=(len(unknowns), len(alive)),
        )
        return scipy.sparse.csr_array(spread @ self._by_states(rows)), depths

    def _find_rows(
        self, unknowns: list[int], *, speeds_first: bool = True
    ) -> tuple[list[int], list[int], list[int]]:
        """Places of unknowns that move, nodes that the system computes, orders of derivatives."""
        structure = self.system.structure
        nodes = [structure.reduced.node(unknown) for unknown in unknowns]
        alive = [i for i, node in enumerate(nodes) if node is not None]
        wanted = [node for node in nodes if node is not None]
        rows, depths = list[int](), list[int]()
        for i, node, row in zip(alive, wanted, self._lowest(wanted, speeds_first), strict=True):
            if row is None:
                name = structure.tree.unknown_name(unknowns[i])
                raise UnknownNameError(f"'{name}' was left out of the system.")
            rows.append(row)
            depths.append(row - node)
        return alive, rows, depths

    def _by_states(self, nodes: list[int]) -> scipy.sparse.csr_array:
        """Derivatives of nodes by the states, shape (len(nodes), n)."""
        point = self.point
        slopes = _slopes(self.system, tuple(nodes))
        found = slopes(*point.inputs)
        return scipy.sparse.csr_array(found.sparse())

    def _lowest(self, nodes: list[int], speeds_first: bool = True) -> list[int | None]:
        """For each node itself, or the lowest derivative of it that the system computes."""
        result: list[int | None] = [None] * len(nodes)
        states = set(self.system.structure.states)
        # an angle may be the sum of all torsions before it
        ahead = [
            i
            for i, node in enumerate(nodes)
            if speeds_first
            and node in self._port_nodes
            and node not in states
            and self._has_rate(node)
        ]
        usable = self.system.structure.available([nodes[i] + 1 for i in ahead], cyclic=False)
        for i, fits in zip(ahead, usable, strict=True):
            if fits:
                result[i] = nodes[i] + 1
        waiting, depth = [i for i, found in enumerate(result) if found is None], 0
        while waiting:
            trial = [nodes[i] + depth for i in waiting]
            usable = self.system.structure.available(trial, cyclic=False)
            left = []
            for i, node, fits in zip(waiting, trial, usable, strict=True):
                if fits:
                    result[i] = node
                elif self._has_rate(node):
                    left.append(i)
            waiting, depth = left, depth + 1
        return result

    @cached_property
    def _positions(self) -> Complex:
        """Amplitudes of all angles and positions of ports in the oscillating modes."""
        return self._of_positions(self.vectors, self.eigenvalues)

    @cached_property
    def _position_nodes(self) -> list[int]:
        members = self.system.structure.members
        nodes = sorted(self._port_nodes, key=lambda n: members.get(n, n))
        return [n for n, low in zip(nodes, self._lowest(nodes), strict=True) if low is not None]

    def _has_rate(self, node: int) -> bool:
        number_, order = self.system.structure.reduced.class_and_order(node)
        return bool(order < self.system.structure.reduced.highest[number_])

    @cached_property
    def _port_nodes(self) -> set[int]:
        """Angles and positions of ports; where there are none, other potentials."""
        system, reduced = self.system, self.system.structure.reduced
        found: set[int] = set()
        others: set[int] = set()
        for node in system.structure.tree.instances:
            for i, quantity in enumerate(node.layout.quantities):
                n = reduced.node(node.first_unknown + i)
                if quantity.kind == "potential" and n is not None:
                    (found if quantity.unit in ("rad", "m") else others).add(n)
        return found or others

    @cached_property
    def _scale(self) -> Complex:
        return _find_scale(self._positions)

    @cached_property
    def _rigid_positions(self) -> Complex:
        """Amplitudes of all angles and positions of ports in the rigid-body modes."""
        return self._of_positions(self.rigid_vectors, np.zeros(self.rigid))

    @checked
    def plot(
        self,
        names: Iterable[Name] | None = None,
        *,
        modes: Iterable[int] | None = None,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Amplitudes along the drive, one panel for each mode.

        Of more than 16 modes the lowest are drawn, and a note says so.

        Parameters
        ----------
        names : iterable of names or references, optional
            Quantities in the order along the drive; default is all angles and positions in the
            order of their declaration.
        modes : iterable of int, optional
            Numbers of the modes to draw, from 0; default is all.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If there is no oscillating mode, none of a number, or no quantity is named.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        name, every = self.system.name, len(self.hertz)
        if not every:
            raise OptionError(f"{name}: no oscillating mode to draw.")
        drawn = list(range(min(every, _MOST_DRAWN))) if modes is None else list(modes)
        for mode in drawn:
            self.check_mode(mode, name)
        if not drawn:
            raise OptionError(f"{name}: modes = []: give the number of at least one mode.")
        wanted = self.angles if names is None else [self.system.key(n) for n in names]
        if not wanted:
            raise OptionError(f"{name}: name at least one quantity to draw.")
        note = ""
        if modes is None and len(drawn) < every:
            note = f"the {len(drawn)} lowest of {every} modes; modes= chooses others"
        frequency = frequency_unit(choose_units(units, ("frequency", *self.system.names())))
        captions = [
            f"{frequency.value(self.hertz[k]):.4g} {frequency.unit}, damping ratio "
            f"{self.damping[k]:.3g}"
            for k in drawn
        ]
        shapes = np.array([self.shape(name)[drawn] for name in wanted])
        return draw(mode_shapes_picture(name, wanted, shapes, captions, note), **canvas)

    def __repr__(self) -> str:
        frequency = frequency_unit()
        names, scaled = self.angles, self._positions / self._scale
        head = (
            f"{self.system.name}: {len(self.hertz)} oscillating and {self.rigid} rigid-body modes"
            f", {(self.decays < 0).sum()} decays{situation(self.point)}"
        )
        if side := one_sided(self.point):
            head += f"\n{side}"
        if self.near is not None:
            head += f"; only those near {frequency.value(self.near):g} {frequency.unit}"
        if len(self.hertz):
            head += f"\n{self.accuracy}"
        if self.lost:
            head += (
                f"\nnote: {self.lost} eigenvalues that are not zero are below the rounding of the "
                "highest, and count among the rigid-body modes; analyse the soft parts alone"
            )
        rows = []
        for z, shape in zip(self.damping[:30], scaled.T, strict=False):
            order = np.argsort(-np.abs(shape))[:3].tolist() if names else []
            parts = [f"{names[j]} {_format_amplitude(shape[j])}" for j in order]
            rows.append((number(z, 4), "; ".join(parts)))
        lines = [head]
        if rows:
            lines.append(self.list_modes(("damping ratio", "shape"), rows))
        for what, values in (
            ("decays", self.decays[self.decays < 0]),
            ("unstable: grows", self.decays[self.decays > 0]),
        ):
            if len(values):
                listed = ", ".join(number(value, 4) for value in values[:10])
                lines.append(f"{what}, 1/s: {listed}{', ...' if len(values) > 10 else ''}")
        lines += [f"rigid body: {name}" for name in self.rigid_names]
        return "\n".join(lines)


def integrate_rates(rates: Any, depths: Any, values: Complex | Real) -> Complex:
    """Amplitudes of quantities from those of derivatives of some order; a rate stays at zero.

    Those of derivatives may be lost.
    """
    depths, inverse = np.asarray(depths), 1 / np.where(values == 0, 1.0, values)
    found: Complex = rates.astype(complex, copy=False)
    for depth in np.unique(depths[depths != 0]).tolist():
        np.multiply(found, inverse**depth, out=found, where=(depths == depth)[:, None])
    return found


def _find_scale(amplitudes: Complex) -> Complex:
    """The largest amplitude of each mode, shape (k,); 1 where there is none."""
    count = amplitudes.shape[1]
    if not amplitudes.size:
        return np.ones(count, dtype=complex)
    scale = amplitudes[np.abs(amplitudes).argmax(axis=0), np.arange(count)]
    return np.where(np.abs(scale) > 0, scale, 1.0)


def _format_amplitude(value: complex) -> str:
    if abs(value.imag) <= 1e-6 * abs(value):
        return f"{round(value.real, 3) + 0.0:+.3f}"
    return f"{abs(value):.3f} at {np.degrees(np.angle(value)):.0f} deg"


@made_once
def _slopes(system: System, nodes: tuple[int, ...]) -> ca.Function:
    """Derivatives of nodes by the states."""
    slope = ca.jacobian(system.structure.values.of(list(nodes)), system.inputs[0])
    return ca.Function("C", system.inputs, [slope])
