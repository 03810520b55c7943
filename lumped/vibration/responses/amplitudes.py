"""Amplitudes by the linearised equations at each frequency."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.numerics.singular_factors import factors_of
from lumped.points.linearise import Matrices
from lumped.support.arrays import Complex, Real
from lumped.support.made_once import made_once
from lumped.timeloop.results.operating_point import OperatingPoint


class Held:
    """A, B, C and D at the frequency of a vibration, with what sticks held at zero.

    Parameters
    ----------
    point : OperatingPoint
        Where the system was linearised.
    matrices : Matrices
        There.
    """

    def __init__(self, point: OperatingPoint, matrices: Matrices) -> None:
        self._point, self._made = point, matrices
        self._latest: tuple[object, list[scipy.sparse.csc_array]] = None, []

    def theta(self, hertz: float) -> Real:
        """Parameters at a frequency, Hz."""
        return self._made.theta(2 * np.pi * hertz if hertz else None)

    def at(self, hertz: float) -> list[scipy.sparse.csc_array]:
        """The matrices at a frequency, Hz; at zero laws hold at the frequencies that are stated."""
        found, point = self._made.at(2 * np.pi * hertz if hertz else None), self._point
        if found is not self._latest[0]:
            inputs = (point.x, self.theta(hertz), point.time, point.settings)
            A = point.system.state_matrix(inputs)
            self._latest = found, [*_hold_sticking(point.system, point, A, found[1]), *found[2:]]
        return self._latest[1]


def _hold_sticking(
    system: System, point: OperatingPoint, A: scipy.sparse.csc_array, B: scipy.sparse.csc_array
) -> list[scipy.sparse.csc_array]:
    """A and B in which speeds that stick, and what they hold, stay zero, also at 0 Hz."""
    still = np.isin(system.structure.states, system.switching.find_held(point.settings))
    pattern = scipy.sparse.csr_array(abs(A))
    driven = np.asarray(abs(B).sum(axis=1)).ravel() > 0
    while (more := ~(still | driven | (pattern @ ~still > 0))).any():
        still |= more
    held = still.astype(float)
    free = scipy.sparse.diags_array(1 - held)
    return [
        scipy.sparse.csc_array(free @ A - scipy.sparse.diags_array(held)),
        scipy.sparse.csc_array(free @ B),
    ]


def solve_responses(matrices: Held, hertz: ArrayLike, system: System) -> Complex:
    """Responses, shape (frequencies, outputs, inputs)."""
    found = []
    for f in np.asarray(hertz, dtype=float):
        A, B, C, D = matrices.at(f)
        response = D.toarray().astype(complex)
        if A.shape[0]:
            factors = factors_of(shift_matrix(A, f))
            response += np.inf if factors is None else C @ factors.solve(B.toarray() + 0j)
        if not np.isfinite(response).all():
            why = "what moves freely drifts away" if f == 0 else "an undamped mode resonates there"
            raise SolverError(
                f"{system.name}: no finite response at {f:.9g} Hz: {why}. "
                "Leave this frequency out, or add damping."
            )
        found.append(response)
    return np.array(found)


def shift_matrix(A: scipy.sparse.csc_array, hertz: float) -> scipy.sparse.csc_array:
    """``j w - A``."""
    unit = scipy.sparse.eye_array(A.shape[0], format="csc")
    return scipy.sparse.csc_array(2j * np.pi * hertz * unit - A)


@made_once
def needing_rates(system: System) -> frozenset[int]:
    """Places of the parameters that stand in equations of which the time derivative is used."""
    reduced = system.structure.reduced
    incidence, differentiations = reduced.incidence, reduced.differentiations
    touched: set[int] = set()
    for group, e, instances, first in incidence.blocks:
        rows = instances[differentiations[first : first + len(instances)] > 0]
        symbols = ca.vertcat(ca.SX(0, 1), *group.template.parameters.values())
        if len(rows) and symbols.numel():
            present = ca.which_depends(group.template.residual(e).expression, symbols)
            touched.update(group.parameters[rows][:, np.array(present, dtype=bool)].ravel())
    p = system.structure.parameters
    values = p.values[sorted(int(i) for i in touched)] if touched else ca.SX(0, 1)
    return frozenset(ca.jacobian_sparsity(values, p.theta).get_triplet()[1])


def refuse_rates(system: System, inputs: tuple[str, ...]) -> None:
    """Refuse inputs that stand in equations of which the model uses the time derivative."""
    for name, place in zip(inputs, system.places(inputs), strict=True):
        if place in needing_rates(system):
            raise OptionError(
                f"{system.name}: the response to {name} would need its rate of change, but the "
                "model holds parameters constant. Let a torque or force vary instead, or prescribe "
                "the motion by a component with its acceleration as input and der(w) == a."
            )
