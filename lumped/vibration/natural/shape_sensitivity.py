"""How mode shapes change with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.points.linearise import moving
from lumped.points.moved_equilibrium import find_moved_point, still_point
from lumped.support.arguments import checked
from lumped.support.arrays import Complex
from lumped.support.by_name import find_place
from lumped.support.ranking import list_largest
from lumped.support.rich_html import RichHtml
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.natural.matrix_slopes import Along
from lumped.vibration.natural.modes import Modes


@dataclass(frozen=True, eq=False)
class ShapeSensitivity(RichHtml):
    """Derivatives of `Modes.shape`; ``found["b.phi", "shaft.c"]`` has one for each mode.

    Attributes
    ----------
    modes : Modes
        What was derived.
    of, to : tuple of str
        Quantities and parameters.
    derivatives : ndarray of complex, shape (k, len(of), len(by))
        Derivatives of amplitudes, the largest angle (position) of the mode being 1; nan where an
        eigenvalue repeats.
    moving : bool
        The operating point is an equilibrium that moves with the parameters. If False, it is held.
    residual : float
        Largest relative residual of the equations solved for the derivatives.
    """

    modes: Modes
    of: tuple[str, ...]
    by: tuple[str, ...]
    derivatives: Complex
    moving: bool
    residual: float

    def __getitem__(self, pair: tuple[Name, Name]) -> Complex:
        row, column = (
            find_place(self.modes.system.key(name), known, "was not asked for")
            for name, known in zip(pair, (self.of, self.by), strict=True)
        )
        return self.derivatives[:, row, column]

    def __repr__(self) -> str:
        varied = self.modes.point.theta[self.modes.system.places(self.by)]
        names = [f"{of} by {by}" for of in self.of for by in self.by]
        rows = []
        for slopes in self.derivatives[:12]:
            change = slopes * varied
            text = "repeated: no derivatives"
            if np.isfinite(change).all():
                text = list_largest(zip(names, np.abs(change).flat, strict=True), "{} {:.4f}")
            rows.append((text,))
        head = (
            f"{self.modes.system.name}: size of the change of amplitudes for a relative change of "
            f"parameters; residual {self.residual:.1e}"
        )
        return f"{head}\n" + self.modes.list_modes(("largest",), rows)


@checked
def shape_sensitivity(
    modes: Modes, *, of: Iterable[Name], by: Iterable[Name] | None = None
) -> ShapeSensitivity:
    """Exact derivatives of mode shapes by parameters.

    The derivative of an eigenvector solves ``(A - l) dx - x dl == -dA x`` with ``y^H dx == 0``
    (bordered form of Nelson, AIAA Journal 14, 1976). In each mode the angle or position that is
    the largest stays 1.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`.
    of : iterable of names
        Quantities, such as angles, speeds and torques.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    ShapeSensitivity

    Raises
    ------
    OptionError
        If `of` is empty, there is no oscillating mode, or no angle or position by which shapes
        are scaled.
    UnknownNameError
        If a name does not exist.
    SolverError
        If a derivative is not finite.
    """
    system, point = modes.system, modes.point
    wanted = tuple(system.key(name) for name in of)
    if not wanted:
        raise OptionError("shape_sensitivity: name at least one quantity in `of`.")
    if not (len(modes.eigenvalues) and modes.angles):
        raise OptionError(f"{system.name}: no oscillating mode of an angle or position to derive.")
    slopes = eigen_sensitivity(modes, by=by)
    places = system.places(slopes.by)
    moved = find_moved_point(point, places) if slopes.moving else None
    moved = moved or still_point(point, places)
    unknowns = [system.structure.tree.unknown(name) for name in wanted]
    alive, rows, orders = modes._find_rows(unknowns)
    largest = np.abs(modes._positions).argmax(axis=0)
    references = [modes._position_nodes[i] for i in largest]
    for reference, row in zip(references, modes._lowest(references), strict=True):
        assert row is not None  # as for all positions of modes
        rows.append(row)
        orders.append(row - reference)
    depth = np.array(orders)
    outputs = ca.vertcat(system.rates, system.structure.values.of(rows))
    C = ca.Function("C", system.inputs, [ca.jacobian(outputs, system.inputs[0])])(*point.inputs)
    C = scipy.sparse.csr_array(C.sparse())[len(point.x) :]
    along = Along(point, outputs, moved)
    matrix = scipy.sparse.csc_array(system.state_matrix(point.inputs)).astype(complex)
    left, mobile = modes.left_vectors, moving(system, point)
    signs = system.structure.reduced.aliases.signs[np.array(unknowns)[alive]][:, None]
    values = np.zeros((len(modes.eigenvalues), len(wanted), len(places)), dtype=complex)
    worst = 0.0
    for k, value in enumerate(modes.eigenvalues):
        if k in slopes.repeated:
            values[k] = np.nan
            continue
        x = modes.vectors[:, k]
        change = along(x)
        own = modes.own_part(x)
        own = own[mobile[own]]
        dx = np.zeros((len(x), len(places)), dtype=complex)
        dx[own], missed = _derive_eigenvector(
            matrix[own][:, own], value, x[own], left[own, k], change[own]
        )
        worst = max(worst, missed)
        power = value ** depth[:, None]
        a = (C @ x)[:, None] / power
        da = (change[len(x) :] + C @ dx) / power
        da -= depth[:, None] * a * slopes.eigenvalues[k] / value
        s, ds = a[len(alive) + k], da[len(alive) + k]
        here = slice(len(alive))
        values[k, alive] = signs * (da[here] / s - a[here] * ds / s**2)
    return ShapeSensitivity(modes, wanted, slopes.by, values, slopes.moving, worst)


def _derive_eigenvector(
    block: scipy.sparse.csc_array, value: complex, x: Complex, y: Complex, change: Complex
) -> tuple[Complex, float]:
    """Derivatives of an eigenvector, and the relative residual of their equations."""
    n = len(x)
    full = scipy.sparse.csc_array(
        scipy.sparse.block_array(
            [[block - value * scipy.sparse.eye_array(n), -x[:, None]], [y.conj()[None, :], None]]
        )
    )
    right = np.vstack([-change, np.zeros((1, change.shape[1]))])
    found = scipy.sparse.linalg.splu(full).solve(right)
    size = np.abs(full) @ np.abs(found) + np.abs(right)
    missed = np.abs(full @ found - right) / np.where(size > 0, size, 1.0)
    return found[:n], float(missed.max(initial=0.0))
