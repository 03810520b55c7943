"""What decides a change at the instants where a run stops: margins, clocks, and their slopes."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.gradients.legs import SmoothParts
from lumped.support.made_once import made_once
from lumped.timeloop.clocks import Clock, clocks
from lumped.timeloop.plants.many_points import ManyPoints


class InstantValues(NamedTuple):
    """Numbers at one instant.

    Attributes
    ----------
    margins, tolerances, margin_rates, bends : ndarray, shape (k,)
        Margins, how well they are known, and their first and second derivatives by time.
    rates : ndarray, shape (n,)
        Derivatives of the states.
    places, fast : ndarray, shape (c,)
        Arguments of functions of time that change their piece, and their derivatives by time.
    slopes : ndarray
        Nonzero derivatives of margins and arguments by states and parameters.
    """

    margins: np.ndarray
    tolerances: np.ndarray
    margin_rates: np.ndarray
    bends: np.ndarray
    rates: np.ndarray
    places: np.ndarray
    fast: np.ndarray
    slopes: np.ndarray


class InstantLooks:
    """The numbers that decide changes of one system, by one function.

    Attributes
    ----------
    clocks : list of Clock
        Functions of time that change their piece.
    """

    def __init__(self, system: System) -> None:
        self.clocks: list[Clock] = [clock for clock in clocks(system) if clock.moves]
        x, p, t, _ = system.inputs
        margins, tolerances = map(system.structure.in_states, system.switching.margins)
        places = ca.vertcat(ca.SX(0, 1), *(c.condition.argument for c in self.clocks))
        forward, along = ca.vertcat(x, t), ca.vertcat(system.rates, 1)
        margin_rates = ca.jtimes(margins, forward, along)
        bends = ca.jtimes(margin_rates, forward, along)
        slopes = ca.jacobian(ca.vertcat(margins, places), ca.vertcat(x, p))
        parts = [margins, tolerances, margin_rates, bends, system.rates, places]
        parts = [*map(ca.densify, (*parts, ca.jacobian(places, t)))]
        parts.append(ca.sparsity_cast(slopes, ca.Sparsity.dense(slopes.nnz(), 1)))
        ends = np.cumsum([0, *(part.numel() for part in parts)]).tolist()
        self._parts = [slice(*pair) for pair in itertools.pairwise(ends)]
        rows, columns = (np.array(v, dtype=int) for v in slopes.sparsity().get_triplet())
        order = np.argsort(rows, kind="stable")
        borders = np.searchsorted(rows[order], np.arange(slopes.shape[0] + 1)).tolist()
        self._own = [order[a:b] for a, b in itertools.pairwise(borders)]
        self._columns, self._width, self._count = columns, slopes.shape[1], margins.numel()
        self._function = ManyPoints(ca.Function("looks", system.inputs, [ca.vertcat(*parts)]))

    def along(
        self, x: np.ndarray, theta: np.ndarray, t: np.ndarray, settings: np.ndarray
    ) -> list[InstantValues]:
        """Numbers at points of a run."""
        found = self._function(x, theta, t, settings)
        return [InstantValues(*(row[part] for part in self._parts)) for row in found]

    def at(self, x: np.ndarray, theta: np.ndarray, t: float, settings: np.ndarray) -> InstantValues:
        """Numbers at one point."""
        return self.along(x[None, :], theta, np.array([t]), settings[None, :])[0]

    def margin_slopes(self, values: InstantValues, margin: int) -> np.ndarray:
        """Derivatives of a margin by states and parameters, shape (n + p,)."""
        found = np.zeros(self._width)
        own = self._own[margin]
        found[self._columns[own]] = values.slopes[own]
        return found

    def clock_slopes(self, values: InstantValues, clock: int) -> np.ndarray:
        """Derivatives of the argument of a function of time, shape (n + p,)."""
        return self.margin_slopes(values, self._count + clock)


@made_once
def looks_of(system: System) -> InstantLooks:
    """The function for a system."""
    return InstantLooks(system)


@made_once
def rates_along(system: System) -> ManyPoints:
    """Derivatives of the states at points of a run."""
    return ManyPoints(system.rhs)


@made_once
def _margins(system: System) -> ManyPoints:
    found = ca.densify(system.margins(*system.inputs)[0])
    return ManyPoints(ca.Function("margins", system.inputs, [found]))


def margin_sizes(course: SmoothParts) -> np.ndarray:
    """Greatest size of each margin in each smooth part of a run, shape (legs, margins)."""
    function = _margins(course.run.system)
    found = np.zeros((len(course.legs), function.results))
    if not function.results:
        return found
    for part, span in course.stretches():
        sizes = np.abs(function(span.x, span.theta, span.t, span.m))
        largest = np.maximum.reduceat(sizes, part.places, axis=0)
        np.maximum.at(found, [number for number, _, _ in part.legs], largest)
    return found
