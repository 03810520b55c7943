"""Points at which equations of components do not hold any more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError, told_by
from lumped.language.formula import Formula
from lumped.language.validity import Range, borders
from lumped.support.made_once import made_once
from lumped.support.text_table import number
from lumped.timeloop.plants.many_points import quantity_along
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_ROUNDING = 1e-9
"""Share of a range by which a value may lie outside; of one without scale, of the values."""


@dataclass(frozen=True)
class HeldRange:
    """A range of a component of a system.

    Attributes
    ----------
    path, label : str
        The component.
    formula : Formula
        What must lie in the range.
    range : Range
        As the component gave it.
    """

    path: str
    label: str
    formula: Formula
    range: Range

    def outside(self, values: np.ndarray) -> np.ndarray:
        """Which values lie outside, or are no numbers."""
        low, high = self.range.low, self.range.high
        ends = max(abs(end) for end in (low, high, 0.0) if np.isfinite(end))
        slack = _ROUNDING * (ends or np.abs(values[np.isfinite(values)]).max(initial=0.0))
        return ~((values >= low - slack) & (values <= high + slack))

    def make_error(
        self, value: float, where: str, partial: Trajectory | None = None
    ) -> SolverError:
        """The error that a value lies outside."""
        low, high, unit = self.range.low, self.range.high, self.range.unit
        return SolverError(
            f"{self.label}: {self.range.name} = {number(value, 6)} {unit} {where} lies outside "
            f"{number(low, 6)} to {number(high, 6)} {unit}, for which its equations hold. "
            f"{self.range.advice}.",
            partial,
        )


@made_once
def ranges(system: System) -> tuple[HeldRange, ...]:
    """Where the equations of all components hold, as far as their quantities were not left out."""
    found = []
    for node in system.structure.tree.instances:
        with told_by(node.label, "valid()"):
            for each in node.ranges():
                found.append(HeldRange(node.path, node.label, Formula.of(each.expression), each))
    return tuple(found)


def refuse_point_outside(point: OperatingPoint, where: str) -> None:
    """Stop where equations do not hold at an operating point.

    Raises
    ------
    SolverError
    """
    for held in ranges(point.system):
        value = point[held.formula]
        if held.outside(np.array([value]))[0]:
            raise held.make_error(value, where)


def refuse_run_outside(run: Trajectory) -> None:
    """Stop where a run went on with equations that do not hold.

    It looks at all output times, and at the instants at which a range was left between them.

    Raises
    ------
    SolverError
        Its `partial` is the run.
    """
    for held in ranges(run.system):
        of_pieces = [
            quantity_along(piece.system, held.formula, run.theta, piece.t, piece.x, piece.settings)
            for piece in run.pieces
        ]
        values = np.concatenate(of_pieces)
        for k in np.flatnonzero(held.outside(values))[:1].tolist():
            t = np.concatenate([piece.t for piece in run.pieces])[k]
            raise held.make_error(float(values[k]), f"at t = {t:.6g} s", run)
        for border, value, way in zip(
            borders([held.range]),
            (held.range.high, held.range.low),
            (np.inf, -np.inf),
            strict=True,
        ):
            for event in run.events:
                is_own = event.component == (held.path or held.label)
                if is_own and event.after == repr(border.condition):
                    beyond = float(np.nextafter(value, way))
                    raise held.make_error(beyond, f"passed at t = {event.time:.6g} s", run)
