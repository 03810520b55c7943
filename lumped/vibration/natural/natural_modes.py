"""All natural frequencies up to a limit of a drive with laws that depend on the frequency."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.numerics.bracketed_roots import find_bracketed_roots
from lumped.points.linearise import finite
from lumped.points.situation import situation
from lumped.points.start import point_or_start
from lumped.support.arguments import checked
from lumped.support.arrays import Integer, Real
from lumped.support.ranking import list_largest
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.validity import refuse_point_outside
from lumped.vibration.natural.find_modes import modes_of
from lumped.vibration.natural.modes import Modes
from lumped.vibration.rotating.masses import mechanical_states

_WIDTH = 1e-14
"""Relative width of the bracket of a natural frequency."""
_STEP = 1e-3
"""Relative change of the frequency for the slope of the laws; its error is of order four."""


@dataclass(frozen=True, eq=False)
class NaturalModes(RichHtml):
    """Modes without damping, each with all laws at its own frequency, ascending.

    Attributes
    ----------
    system : System
        What vibrates.
    up_to : float
        Frequency up to which all modes were found, Hz.
    modes : tuple of Modes
        One for each natural frequency; it has this oscillating mode alone.
    hertz : ndarray, shape (k,)
        Natural frequencies without damping, Hz.
    damping : ndarray, shape (k,)
        Damping ratios, to the first order of the damping.
    rigid : int
        Number of rigid-body modes.
    point : OperatingPoint
        Where the system was linearised.
    """

    system: System
    up_to: float
    modes: tuple[Modes, ...]
    hertz: Real
    damping: Real
    rigid: int
    point: OperatingPoint

    @checked
    def shape(self, name: Name) -> Real:
        """Amplitudes of a quantity in all modes, shape (k,), scaled as by `Modes.shape`.

        Raises
        ------
        UnknownNameError
            If there is no such quantity.
        """
        return np.array([float(np.real(mode.shape(name)[0])) for mode in self.modes])

    def __repr__(self) -> str:
        head = (
            f"{self.system.name}: {len(self.hertz)} oscillating modes up to {self.up_to:g} Hz, "
            f"none missed, and {self.rigid} rigid-body modes; without damping, laws at the "
            f"frequency of each mode{situation(self.point)}"
        )
        rows = []
        for i, mode in enumerate(self.modes):
            shapes = ((name, float(np.real(mode.shape(name)[0]))) for name in mode.angles)
            text = list_largest(shapes, "{} {:+.3f}", 3)
            rows.append((str(i + 1), number(self.hertz[i], 9), number(self.damping[i], 4), text))
        columns = ("mode", "natural frequency, Hz", "damping ratio", "shape")
        return f"{head}\n" + (table(columns, rows) if rows else "none")


@checked
def natural_modes(
    system: System,
    *,
    up_to: float,
    at: OperatingPoint | None = None,
    parameters: Changes | None = None,
) -> NaturalModes:
    """All modes up to a frequency, where stiffness or inertia depends on the frequency.

    With laws held at w, the drive without damping has the natural frequencies ``w_i(w)``; its own
    are the solutions of ``w_i(w) = w``. After Wittrick and Williams, the number of natural
    frequencies below w is that of the ``w_i(w)`` below w: the number of negative eigenvalues of
    the dynamic stiffness, as no law has a pole up to there. So each lies in a known bracket and
    none is missed, wherever the dynamic stiffness falls as w rises, as it does for shafts that are
    continuous.

    Dampers, controls and electrical circuits are left out of frequencies and shapes; the damping
    ratios count dampers and loss factors to the first order.

    Source: Wittrick, Williams: A general algorithm for computing natural frequencies of elastic
    structures, Quarterly Journal of Mechanics and Applied Mathematics 24 (1971) 263.

    Parameters
    ----------
    system : System
        From `assemble`.
    up_to : float
        Highest frequency, Hz.
    at : OperatingPoint, optional
        Where to linearise; default is the start point.
    parameters : mapping of name to float, optional
        Parameters to change, if `at` is not given.

    Returns
    -------
    NaturalModes

    Raises
    ------
    OptionError
        If the frequency is not above zero, or no law depends on the frequency.
    SolverError
        If equations of a component do not hold up to this frequency, or the point is unstable
        without damping.
    """
    if not up_to > 0:
        raise OptionError(f"natural_modes: up_to = {up_to:g} Hz must be above zero.")
    if not system.structure.parameters.vibrating:
        raise OptionError(
            f"{system.name}: no law of the drive depends on the frequency, so lumped.modes gives "
            "its natural frequencies."
        )
    point = finite(point_or_start("natural_modes", system, at, parameters))
    limit = 2 * np.pi * up_to
    drive = _Frozen(point)
    refuse_point_outside(drive.point(limit), f"at {up_to:.6g} Hz")
    begin, end = drive.modes(0.0), drive.modes(limit)
    if len(begin.decays):
        raise SolverError(
            f"{system.name}: without damping a disturbance grows as exp({begin.decays[-1]:.4g} t), "
            "so the operating point is unstable. Take a stable one."
        )
    below = np.abs(end.eigenvalues)
    count = int((below <= limit).sum())
    known: dict[float, Real] = {}

    def missing(which: Integer, w: Real) -> Real:
        for value in w:
            if value not in known:
                known[value] = np.abs(drive.modes(value).eigenvalues)
        return np.array([known[value][k] - value for k, value in zip(which, w, strict=True)])

    w = find_bracketed_roots(
        missing,
        np.zeros(count),
        np.full(count, limit),
        np.abs(begin.eigenvalues)[:count],
        np.minimum(below[:count] - limit, 0.0),
        _WIDTH * below[:count],
    )
    own = [drive.modes(value) for value in w]
    found = tuple(
        replace(modes, eigenvalues=modes.eigenvalues[[k]], vectors=modes.vectors[:, [k]])
        for k, modes in enumerate(own)
    )
    damping = np.array([drive.damping(mode, value) for mode, value in zip(found, w, strict=True)])
    hertz = w / (2 * np.pi)
    return NaturalModes(point.system, up_to, found, hertz, damping, begin.rigid, point)


class _Frozen:
    """A drive about a point, with laws held at a frequency."""

    def __init__(self, point: OperatingPoint) -> None:
        self._point = point
        self._positions, self._speeds = (
            scipy.sparse.diags_array(np.isin(np.arange(len(point.x)), own).astype(float))
            for own in mechanical_states(point.system)
        )

    def point(self, w: float) -> OperatingPoint:
        """The operating point with laws at a frequency, rad/s; as stated at zero."""
        theta = self._point.theta.copy()
        if w:
            theta[self._point.system.structure.parameters.vibrating] = w
        return replace(self._point, theta=theta)

    def modes(self, w: float) -> Modes:
        """Modes without damping."""
        point = self.point(w)
        return modes_of(point, self._matrices(point)[0], is_mean=True)

    def damping(self, mode: Modes, w: float) -> float:
        """Damping ratio of a natural mode.

        With ``A(w) x = j w x`` and the left eigenvector y a small change D of A moves w by
        ``y^H D x / (j - y^H A'(w) x)``, ``y^H x = 1``; its imaginary part is the decay.
        """
        x, y = mode.vectors[:, 0], mode.left_vectors[:, 0].conj()
        slope = 0.0j
        for shares, weight in ((1, 2 / 3), (2, -1 / 12)):
            for sign in (1, -1):
                matrix = self._matrices(self.point(w * (1 + sign * shares * _STEP)))[0]
                slope += sign * weight * (y @ (matrix @ x)) / (w * _STEP)
        lossy = self._matrices(mode.point)[1]
        return float(((y @ (lossy @ x)) / (1j - slope)).imag / w) + 0.0

    def _matrices(
        self, point: OperatingPoint
    ) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
        """State matrix without damping, and what damping adds to it."""
        A, P, S = point.system.state_matrix(point.inputs), self._positions, self._speeds
        parts = (P @ A @ S + S @ A @ P, S @ A @ S)
        first, second = (scipy.sparse.csr_array(part) for part in parts)
        return first, second
