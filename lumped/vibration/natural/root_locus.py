"""How eigenvalues wander when a parameter changes, each followed by its shape."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.plots.draw import Canvas, draw
from lumped.points.situation import situation
from lumped.points.start import point_at, start_point
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean, Complex, Integer, Real
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.spectrum import Spectrum
from lumped.vibration.pictures import root_locus_picture

_ALIKE = 0.7
"""Overlap of shapes from which two eigenvalues are the same mode."""
_HALVINGS = 12
_Spectra = tuple[Complex, Complex, Complex]
"""Eigenvalues, left and right eigenvectors."""


@dataclass(frozen=True, eq=False)
class RootLocus(Spectrum, RichHtml):
    """Eigenvalues over a parameter.

    Attributes
    ----------
    system : System
        What was analysed.
    parameter : str
        What was varied.
    values : ndarray, shape (k,)
        Its values.
    eigenvalues : ndarray of complex, shape (k, n)
        All eigenvalues, 1/s; each column follows one mode.
    evaluations : int
        How often eigenvalues were computed.
    doubtful : tuple of (float, float)
        Intervals of the parameter in which shapes changed too fast to be followed: a pair that
        becomes two real ones, or two modes that exchange their shapes.
    situations : tuple of str
        What is open, closed, stuck, sliding or released at the operating points, in words.
    """

    system: System
    parameter: str
    values: Real
    eigenvalues: Complex
    evaluations: int
    doubtful: tuple[tuple[float, float], ...]
    situations: tuple[str, ...] = ()

    @property
    def unstable(self) -> Boolean:
        """Where some eigenvalue has a positive real part, beyond rounding, shape (k,)."""
        size = np.abs(self.eigenvalues).max(axis=1)
        found: Boolean = self.eigenvalues.real.max(axis=1) > 1e-9 * size
        return found

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Root locus in the complex plane; a circle marks the first value, a dot the last.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        system = self.system
        choice = choose_units(
            units, ("frequency", *system.names(), *system.structure.parameters.names)
        )
        unit, ends = system.parameter_unit(self.parameter), self.values[[0, -1]]
        first, last, unit = amounts(self.parameter, unit, *ends, units=choice)
        title = f"{system.name}: {self.parameter} from {first} (circle) to {last} (dot)"
        title += f", {unit}" if unit not in ("", "1") else ""
        picture = root_locus_picture(title, self.eigenvalues, frequency_unit(choice))
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        head = (
            f"{self.system.name}: {self.eigenvalues.shape[1]} eigenvalues over {self.parameter} = "
            f"{self.values[0]:g} to {self.values[-1]:g}; {self.evaluations} evaluations"
            f"{', or'.join(self.situations)}"
        )
        for begin, end in self.doubtful[:6]:
            head += f"\nnot followed for certain: {begin:.6g} to {end:.6g}"
        first, last = self.eigenvalues[0], self.eigenvalues[-1]
        upper = np.flatnonzero((first.imag > 0) | (last.imag > 0))
        frequency = frequency_unit()
        hertz, damping = frequency.value(self.hertz), self.damping
        cells = ((hertz[0], 6), (damping[0], 4), (hertz[-1], 6), (damping[-1], 4))
        rows = [
            [number(values[i], digits) for values, digits in cells]
            for i in upper[np.argsort(np.abs(first[upper]))][:20]
        ]
        columns = (f"{end}, {frequency.unit}" for end in ("first", "last"))
        return f"{head}\n" + table([x for c in columns for x in (c, "damping ratio")], rows)


@checked
def root_locus(
    system: System,
    *,
    along: Mapping[Name, ArrayLike],
    at: Callable[[float], OperatingPoint] | None = None,
) -> RootLocus:
    """Eigenvalues of the linearised drive over a parameter, each mode followed by its shape.

    Two eigenvalues at neighbouring values belong together if the left eigenvector of one goes with
    the right eigenvector of the other, ``abs(y_i^H x_j) abs(y_j^H x_i)``, which does not depend on
    units and is 1 for the same shape. Where this does not decide, the interval is halved.

    Parameters
    ----------
    system : System
        From `assemble`.
    along : mapping of name to array_like, shape (k,)
        What varies. Its values ascend or descend.
    at : callable, optional
        Gives the operating point for a value, such as
        ``lambda c: equilibrium(system, {"shaft.c": c})``; default is the start point.

    Returns
    -------
    RootLocus

    Raises
    ------
    OptionError
        If there are fewer than two values, or they do not rise or fall.
    ParameterError
        If a value is out of range.
    SolverError
        If the linearisation is not finite.
    """
    if len(along) != 1:
        raise OptionError(f"root_locus: along = {dict(along)}: one parameter and its values.")
    ((parameter, values),) = along.items()
    name = system.key(parameter)
    grid = np.asarray(values, dtype=float).ravel()
    steps = np.diff(grid)
    if len(grid) < 2 or not ((steps > 0).all() or (steps < 0).all()):
        raise OptionError(
            f"root_locus: give at least two values of {name}, ascending or descending."
        )
    system.places([name])
    situations: dict[str, None] = {}
    used = ~np.isin(system.structure.states, list(system.structure.cyclic))
    count = 0

    def spectrum(value: float) -> _Spectra:
        nonlocal count
        count += 1
        if at:
            point = point_at("root_locus", system, at, value)
        else:
            point = start_point(system, parameters={name: value})
        situations[situation(point)] = None
        matrix = system.state_matrix(point.inputs).toarray()[used][:, used]
        if not np.isfinite(matrix).all():
            raise SolverError(
                f"{system.name}: the linearisation at {name} = {value:g} is not finite."
            )
        balanced, transform = scipy.linalg.matrix_balance(matrix)
        found, left, right = scipy.linalg.eig(balanced, left=True, right=True)
        scale = np.einsum("ij,ij->j", left.conj(), right)
        with np.errstate(divide="ignore", invalid="ignore"):
            return found, np.linalg.solve(transform.T, left / scale.conj()), transform @ right

    doubtful: list[tuple[float, float]] = []

    def in_order(found: _Spectra, order: Integer) -> _Spectra:
        return found[0][order], found[1][:, order], found[2][:, order]

    def follow_order(
        a: float, before: _Spectra, b: float, after: _Spectra, depth: int = 0
    ) -> _Spectra:
        """`after` in the order of `before`."""
        order, sure = _match_eigenvalues(before, after)
        middle = (a + b) / 2
        if sure or depth == _HALVINGS:
            if not sure:
                doubtful.append((a, b))
            return in_order(after, order)
        between = follow_order(a, before, middle, spectrum(middle), depth + 1)
        return follow_order(middle, between, b, after, depth + 1)

    present = spectrum(float(grid[0]))
    present = in_order(present, np.lexsort((present[0].imag, np.abs(present[0]))))
    rows = [present[0]]
    for a, b in zip(grid[:-1].tolist(), grid[1:].tolist(), strict=True):
        present = follow_order(a, present, b, spectrum(b))
        rows.append(present[0])
    return RootLocus(system, name, grid, np.array(rows), count, tuple(doubtful), tuple(situations))


def _match_eigenvalues(before: _Spectra, after: _Spectra) -> tuple[Integer, bool]:
    """Which eigenvalue of `after` belongs to each of `before`, and whether that is sure."""
    with np.errstate(invalid="ignore", over="ignore"):
        alike = np.abs(before[1].conj().T @ after[2]) * np.abs(after[1].conj().T @ before[2]).T
    alike = np.nan_to_num(alike, nan=0.0, posinf=0.0)
    scale = max(np.abs(before[0]).max(initial=0.0), 1e-300)
    distance = np.abs(before[0][:, None] - after[0][None, :]) / scale
    rows, columns = scipy.optimize.linear_sum_assignment(
        np.minimum(alike, 1.0) - 1e-3 * distance, maximize=True
    )
    order = columns[np.argsort(rows)]
    kept = alike[np.arange(len(order)), order]
    # eigenvalues that did not move need no shape: rigid-body modes, repeated ones
    still = distance[np.arange(len(order)), order] < 1e-9
    return order, bool(((kept > _ALIKE) | still).all())
