"""Natural modes of a system, all of them or those nearest to a frequency."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.numerics.eigen import eigenpairs
from lumped.numerics.eigen_near import eigenpairs_near
from lumped.points.linearise import finite, moving
from lumped.points.moved_equilibrium import select_still
from lumped.points.start import point_or_start
from lumped.support.arguments import checked
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.modes import Modes

_SMALL = 200
"""States of one connected part up to which all its modes are computed, though some are wanted."""


@checked
def modes(
    system: System,
    *,
    at: OperatingPoint | None = None,
    parameters: Changes | None = None,
    near: float | None = None,
    count: int | None = None,
) -> Modes:
    """Natural frequencies, damping ratios and mode shapes.

    What sticks at the operating point counts as rigid: a drive whose brake holds vibrates against
    the brake. What is open there transmits nothing. The first line of what is printed says what is
    open, closed, stuck, sliding or released.

    Parameters
    ----------
    system : System
        From `assemble`.
    at : OperatingPoint, optional
        Where to linearise; default is the start point.
    parameters : mapping of name to float, optional
        Parameters to change, if `at` is not given.
    near : float, optional
        Frequency, Hz, for large drives: only the `count` oscillating modes whose eigenvalues are
        nearest to ``2j pi near``; damping moves them away. Connected parts of more than 200 states
        are solved by sparse iteration: rigid-body modes only with 0, decays as they are met, and
        modes that repeat may be missed.
    count : int, optional
        How many modes, with `near`.

    Returns
    -------
    Modes

    Raises
    ------
    OptionError
        If options contradict each other.
    SolverError
        If the linearisation is not finite, or the sparse iteration does not converge.
    """
    if (near is None) != (count is None):
        raise OptionError("modes: `near` and `count` go together, such as near=0.0, count=20.")
    if near is not None and near < 0:
        raise OptionError(f"modes: near = {near:g} Hz must not be negative.")
    if count is not None and count < 1:
        raise OptionError(f"modes: count = {count} must be at least 1.")
    point = finite(point_or_start("modes", system, at, parameters))
    matrix = scipy.sparse.csr_array(point.system.state_matrix(point.inputs))
    return modes_of(point, matrix, near, count)


def modes_of(
    point: OperatingPoint,
    matrix: scipy.sparse.csr_array,
    near: float | None = None,
    count: int | None = None,
    *,
    is_mean: bool = False,
) -> Modes:
    """Modes of a state matrix (see `modes`), shape (n, n), at a point or of a mean."""
    system = point.system
    if not np.isfinite(matrix.data).all():
        raise SolverError(
            f"{system.name}: the linearisation is not finite at the operating point:\n{point!r}"
        )
    matrix.eliminate_zeros()
    n = matrix.shape[0]
    label = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1]
    members = np.flatnonzero(moving(system, point))
    members = members[np.argsort(label[members], kind="stable")]
    values, vectors = [np.zeros(0, dtype=complex)], [np.zeros((0, n), dtype=complex)]
    for own in np.split(members, np.flatnonzero(np.diff(label[members])) + 1):
        if not len(own):
            continue
        block = matrix[own][:, own]
        if near is None or count is None or len(own) <= _SMALL:
            found, shapes = eigenpairs(block.toarray())
        else:
            found, shapes = eigenpairs_near(block, 2 * np.pi * near, count)
        kept = found.imag >= 0
        values.append(found[kept])
        vectors.append(np.zeros((int(kept.sum()), n), dtype=complex))
        vectors[-1][:, own] = shapes[kept]
    value, vector = np.concatenate(values), np.concatenate(vectors)
    upper, real = np.flatnonzero(value.imag > 0), np.flatnonzero((value.imag == 0) & (value != 0))
    order = upper[np.argsort(np.abs(value[upper]), kind="stable")]
    if near is not None:
        distance = np.abs(value[order] - 2j * np.pi * near)
        order = order[np.sort(np.argsort(distance, kind="stable")[:count])]
    slowest = real[np.argsort(value[real].real, kind="stable")]
    return Modes(
        system,
        value[order],
        vector[order].T,
        select_still(point, vector[value == 0].real.T),
        value[slowest].real,
        vector[slowest].T,
        point,
        near,
        matrix if is_mean else None,
    )
