"""How an equilibrium changes with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Unpack

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import tornado
from lumped.points.borders import refuse_kinks
from lumped.points.moved_equilibrium import find_moved_point, places_to
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.by_name import find_place
from lumped.support.display_units import Units, choose_units
from lumped.support.ranking import list_largest, rank_by_size
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table
from lumped.timeloop.results.operating_point import OperatingPoint


@dataclass(frozen=True, eq=False)
class EquilibriumSensitivity(RichHtml):
    """Derivatives of quantities at an equilibrium; ``found["shaft.phi_rel", "load.tau"]`` is one.

    Attributes
    ----------
    point : OperatingPoint
        The equilibrium.
    of, to : tuple of str
        Quantities and parameters.
    values : ndarray, shape (len(of),)
        Quantities.
    derivatives : ndarray, shape (len(of), len(by))
        Their derivatives.
    """

    point: OperatingPoint
    of: tuple[str, ...]
    by: tuple[str, ...]
    values: Real
    derivatives: Real

    @checked
    def __getitem__(self, pair: tuple[Name, Name]) -> float:
        row, column = self._row(pair[0]), self._place(pair[1], self.by)
        return float(self.derivatives[row, column])

    @checked
    def ranked(self, of: Name) -> list[tuple[str, float]]:
        """Parameters and relative sensitivities of a quantity, the largest first.

        Raises
        ------
        OptionError
            If the quantity is zero, to which nothing is relative.
        """
        row, point = self._row(of), self.point
        changes = self.derivatives[row] * point.theta[point.system.places(self.by)]
        return rank_by_size(self.of[row], self.values[row], self.by, changes)

    @checked
    def plot(self, of: Name | None = None, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Tornado of the parameters that matter most.

        Parameters
        ----------
        of : name, optional
            The quantity; default is the first.
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
        row = 0 if of is None else self._row(of)
        name = self.of[row]
        system, choice = self.point.system, choose_units(units, self.of)
        texts = amounts(name, system.quantity(name).unit, self.values[row], digits=4, units=choice)
        title = f"{system.name}: {name} = {' '.join(texts)} at the equilibrium"
        return draw(tornado(self.ranked(name), title, name), **canvas)

    def _row(self, of: Name) -> int:
        return self._place(of, self.of)

    def _place(self, name: Name, known: tuple[str, ...]) -> int:
        return find_place(self.point.system.key(name), known, "was not asked for")

    def __repr__(self) -> str:
        rows = []
        for name, value in zip(self.of[:12], self.values, strict=False):
            text = list_largest((n, v) for n, v in self.ranked(name) if v) if value else ""
            unit = self.point.system.quantity(name).unit
            rows.append((name, *amounts(name, unit, value), text))
        head = f"{self.point.system.name}: equilibrium by {len(self.by)} parameters, relative"
        if self.point.search is not None:
            head += f"; the point was {self.point.search}"
        return f"{head}\n" + table(("quantity", "value", "unit", "largest"), rows)


@checked
def equilibrium_sensitivity(
    point: OperatingPoint, *, of: Iterable[Name], by: Iterable[Name] | None = None
) -> EquilibriumSensitivity:
    """Derivatives of quantities at an equilibrium by parameters.

    By the implicit function theorem on vanishing derivatives, ``f_x dx + f_p dp == 0``. What is
    held stays held: what sticks or is locked stays where it is, and what is closed or on its stop
    stays in contact. Parameters that the equilibrium determined (`free`) follow, so that what was
    given stays as it was given. Where an equilibrium is one of many, such as the speed of a free
    drive, what was given changes as little as it can, then the states do.

    Parameters
    ----------
    point : OperatingPoint
        From `equilibrium`.
    of : iterable of names
        Quantities.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    EquilibriumSensitivity

    Raises
    ------
    OptionError
        If `of` or `by` is empty, the point is no equilibrium, or it determines a parameter of
        `by`.
    UnknownNameError
        If a name does not exist.
    SolverError
        If there is no equilibrium for other parameters, or a derivative has two sides: the point
        is exactly where a law changes its piece, a contact opens or friction begins to slide.
    """
    system = point.system
    names, places = places_to(point, by)
    wanted = [system.key(name) for name in of]
    if not wanted or not names:
        raise OptionError("equilibrium_sensitivity: name at least one quantity and one parameter.")
    moved = find_moved_point(point, places)
    if moved is None:
        raise OptionError(
            f"{system.name}: derivatives of states do not vanish at this point, so it is no "
            "equilibrium. Take one from lumped.equilibrium."
        )
    x, theta, _, _ = system.inputs
    y = system.expressions(wanted)
    slopes = ca.jacobian(y, ca.vertcat(x, theta))
    function = ca.Function("outputs", system.inputs, [y, slopes])

    def values_and_slopes(modes: Real) -> Real:
        parts = function(point.x, point.theta, point.time, modes)
        return np.hstack([part.full() for part in parts])

    refuse_kinks(point, moved, names, values_and_slopes)
    found = values_and_slopes(point.settings)
    derivatives = moved.through(found[:, 1:])
    return EquilibriumSensitivity(point, tuple(wanted), tuple(names), found[:, 0], derivatives)
