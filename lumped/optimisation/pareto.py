"""What one objective costs in terms of another: the Pareto front of two functionals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lumped.compiler.system import Name
from lumped.errors import OptimisationError, OptionError
from lumped.optimisation.collocated_course import repeating
from lumped.optimisation.design import Bounds, Optimum
from lumped.optimisation.design_problem import DesignProblem
from lumped.simulation.functionals import Designed
from lumped.support.arguments import checked
from lumped.support.progress import Progress
from lumped.support.text_table import number, table
from lumped.timeloop.result import Trajectory

__all__ = ["Front", "pareto"]

_AGREE = 1e-5
"""Difference of the ends, relative to the start, below which both aims agree."""
_SLACK = 1e-7
"""How much of the range of one functional is given up so that the other has room at an end."""


@dataclass(frozen=True, eq=False)
class Front:
    """Designs of which none is better in both functionals.

    Attributes
    ----------
    functionals : tuple of Designed
        The two.
    designs : tuple of Optimum
        From the least of the first to the least of the second; one alone if both are least in it.
    """

    functionals: tuple[Designed, Designed]
    designs: tuple[Optimum, ...]

    @property
    def values(self) -> np.ndarray:
        """Values of both, shape (count, 2)."""
        return np.array([[d.values[f] for f in self.functionals] for d in self.designs])

    def __repr__(self) -> str:
        names = list(self.designs[0].parameters)
        head = (*(str(f) for f in self.functionals), *names, "iterations", "residual")
        rows = [
            (
                *(number(v, 7) for v in values),
                *(number(design.parameters[name], 7) for name in names),
                str(design.solution.iterations),
                f"{design.solution.residual:.0e}",
            )
            for values, design in zip(self.values, self.designs, strict=True)
        ]
        text = table(head, rows)
        return text if len(rows) > 1 else f"both are least in one design\n{text}"


@checked
def pareto(
    run: Trajectory,
    *,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: tuple[Designed, Designed],
    subject_to: Mapping[Designed | str, Bounds] | None = None,
    count: int = 20,
    intervals: int = 50,
    periodic: bool = False,
) -> Front:
    """Pareto front of two functionals.

    The least first functional for equal steps of a bound on the second, which also finds the parts
    of a front that are not convex. Each search begins at the design before, or, where it then
    fails, at the least second.

    Parameters
    ----------
    run, vary, subject_to, intervals, periodic
        As for `optimise`.
    minimise : (Designed, Designed)
        The two.
    count : int
        Number of designs. Where both functionals are least in one design, that alone is the front.

    Returns
    -------
    Front

    Raises
    ------
    OptionError, UnknownNameError, OptimisationError
        As for `optimise`; if there are not two functionals, or fewer than two designs.

    Notes
    -----
    Miettinen, Nonlinear Multiobjective Optimization, 1999, section 3.2.
    """
    first, second = functionals = tuple(minimise)
    if not (isinstance(first, Designed) and isinstance(second, Designed) and first != second):
        raise OptionError(f"pareto: minimise = {minimise!r}; give two different functionals.")
    if count < 2:
        raise OptionError(f"pareto: count = {count}; a front has at least two designs.")
    repeats = repeating(run) if periodic and run.system.structure.states else None
    problem = DesignProblem(
        run, vary, dict.fromkeys(functionals, 1.0), subject_to or {}, intervals, repeats
    )

    def best(weights: tuple[float, float], begin: Optimum | None, **limits: float) -> Optimum:
        bounds = {
            f: limits[k]
            for f, k in zip(functionals, ("first", "second"), strict=True)
            if k in limits
        }
        solution = problem.solve(
            list(weights), limits=bounds, begin=None if begin is None else begin.solution.w
        )
        return problem.optimum(solution, dict(zip(functionals, weights, strict=True)))

    sizes = [problem.terms[f].scale for f in functionals]
    alone = best((1.0, 0.0), None), best((0.0, 1.0), None)
    # bounds are of the programme, whose functionals are those of a run only to `error`
    least = [problem.promised(d.solution)[f] for d, f in zip(alone, functionals, strict=True)]
    # among designs with the least of one, those with the least of the other
    ends = (
        best((0.0, 1.0), alone[0], first=least[0] + _SLACK * sizes[0]),
        best((1.0, 0.0), alone[1], second=least[1] + _SLACK * sizes[1]),
    )
    both = [[problem.promised(end.solution)[f] for f in functionals] for end in ends]
    apart = np.abs(np.subtract(both[0], both[1])) / sizes
    if (apart <= _AGREE).any():  # what is least for one is least for the other
        return Front((first, second), (ends[0],))
    designs = [ends[0]]
    with Progress(f"{run.system.name}: designs", count) as progress:
        for bound in np.linspace(both[0][1], both[1][1], count)[1:-1]:
            try:
                found = best((1.0, 0.0), designs[-1], second=float(bound))
            except OptimisationError:  # the other end meets the bound
                found = best((1.0, 0.0), ends[1], second=float(bound))
            designs.append(found)
            progress.at(len(designs))
    return Front((first, second), (*designs, ends[1]))
