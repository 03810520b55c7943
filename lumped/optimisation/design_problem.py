"""The programme of one design problem: states at collocation points, functionals as terms."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.functionals import Functional
from lumped.functionals.functional import watching
from lumped.numerics.nlp import Programme, Rows, Solution
from lumped.optimisation.design import Bounds, Key, Optimum, bounds_of, find_varied
from lumped.optimisation.discretisation import (
    Repeating,
    along,
    collocate,
    dt_of,
    refuse_moving_instants,
    run_at,
    smooth,
)
from lumped.optimisation.terms import Term, TermMaker, measure_functional, number_of, refuse_side
from lumped.simulation.simulate import simulate_led
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_RTOL = 1e-10
"""Of the run of a solution."""
_LEAST = 1e-3
"""Size of a functional, over that at the start, below which its error is relative to the start."""


class DesignProblem:
    """The programme of one design problem, solved for any weights.

    Parameters
    ----------
    run, vary
        As for `optimise`.
    weights : mapping of Functional or parameter name to float
        What may be minimised; a negative weight asks for a functional that can be made large.
    bounds : mapping of Functional to (low, high)
    """

    def __init__(
        self,
        run: Trajectory,
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[Functional | str, float],
        bounds: Mapping[Functional, Bounds],
        intervals: int = 50,
        repeats: Repeating | None = None,
    ) -> None:
        self.run, self.system = run, run.system
        smooth(run)
        self.programme = Programme(self.system.name)
        if intervals < 1:
            raise OptionError(f"intervals = {intervals}: at least one is needed.")
        self.names, box, scale = find_varied(self.system, vary, run.theta)
        parts = [self.programme.unknown(r[0], k, *r[1:]) for r, k in zip(box, scale, strict=True)]
        self.u = ca.vertcat(*parts)
        self.places = self.system.places(self.names)
        theta = ca.SX(ca.DM(run.theta))
        theta[self.places] = self.u
        refuse_moving_instants(self.system, self.places)
        if self.system.structure.states:
            self.course = collocate(self.programme, run, theta, self.places, intervals, repeats)
        else:
            self.course = along(run, theta)
        self.terms: dict[Functional | str, Term] = {}
        self.value_rows: dict[Functional | str, Rows] = {}
        self.functionals = self._functionals([*weights, *bounds])
        for key in weights:
            if isinstance(key, str):
                place = self.system.places([key])[0]
                size = abs(float(run.theta[place])) or 1.0
                self.terms[key] = Term(theta[place], size, 0)
        for key, term_ in self.terms.items():
            given = (None, None) if isinstance(key, str) else bounds.get(key, (None, None))
            low, high = bounds_of(str(key), given)
            refuse_side(str(key), term_, weights.get(key, 0.0), low, high)
            if isinstance(key, str):
                unit = self.system.parameter_unit(key)
            else:
                unit = key.unit(self.system)
            self.value_rows[key] = self.programme.constrain(
                str(key), term_.value, low, high, scale=term_.scale, unit=unit, given=True
            )
        self.keys = list(weights)
        w = ca.SX.sym("weights", len(self.keys))
        value = ca.dot(w, ca.vertcat(*(self.terms[k].value for k in self.keys)))
        self._check_effect()
        self.programme.ready(value, w)

    def _functionals(self, keys: list[Functional | str]) -> list[Functional]:
        """Terms of all functionals, their quantities evaluated together."""
        found = list(dict.fromkeys(k for k in keys if isinstance(k, Functional)))
        for functional in found:
            if watching(self.system, [functional]) is not self.system:
                raise OptionError(
                    f"optimise: {functional} has kinks, which the equations of a run do not "
                    "follow. Give the system and until=, which simulates each design, or write "
                    "lumped.ops.smooth around what has them."
                )
        if found:
            names = tuple(dict.fromkeys(name for f in found for name in f.names))
            given = self.course.quantities(names), self.run.table(names)
            for functional in found:
                maker = TermMaker(self.programme, self.course, functional, names, *given)
                self.terms[functional] = maker.term()
        return found

    def _check_effect(self) -> None:
        """Refuse parameters on which nothing depends, and an objective that none reaches."""
        g = ca.vertcat(*self.programme.constraints)
        symbols = ca.vertcat(*(ca.symvar(self.u[i])[0] for i in range(self.u.numel())))
        columns = set(ca.jacobian_sparsity(g, symbols).get_triplet()[1])
        idle = [name for i, name in enumerate(self.names) if i not in columns]
        if idle:
            meant = ", ".join(dict.fromkeys(row.label for row in self.programme.rows if row.given))
            raise OptionError(
                f"optimise: {', '.join(idle)} has no effect on {meant}. Leave it out of `vary`, "
                "or name a quantity that depends on it."
            )
        w = ca.vertcat(*self.programme.unknowns)
        own = [row for row in self.programme.rows if not row.given]
        kept = [i for row in own for i in range(row.first, row.first + row.count)]
        g = g[kept] if kept else ca.SX(0, 1)
        links = scipy.sparse.csr_array(ca.DM(ca.jacobian_sparsity(g, w), 1).sparse())
        label = scipy.sparse.csgraph.connected_components(links.T @ links)[1]
        reached = set(label[: self.u.numel()].tolist())
        for key in self.keys:
            used = ca.jacobian_sparsity(self.terms[key].value, w).get_triplet()[1]
            if not reached & {int(label[i]) for i in used}:
                raise OptionError(
                    f"optimise: {key} does not depend on {', '.join(self.names)}. Vary something "
                    "else, or minimise something else."
                )

    def solve(
        self,
        weights: list[float],
        *,
        limits: Mapping[Functional, float] | None = None,
        begin: np.ndarray | None = None,
    ) -> Solution:
        """Least weighted sum, with upper bounds of functionals besides."""
        box = self.programme.limits.copy()
        for key, high in (limits or {}).items():
            row = self.value_rows[key]
            box[row.first, 1] = min(box[row.first, 1], high / row.scale)
        size = sum(abs(w) * self.terms[k].scale for k, w in zip(self.keys, weights, strict=True))
        return self.programme.solve([w / size for w in weights], begin=begin, limits=box)

    def optimum(self, solution: Solution, weights: Mapping[Functional | str, float]) -> Optimum:
        """What a solution means, with the run made anew."""
        outputs = [self.u, self.course.t, self.course.x]
        found = ca.Function("found", [self.programme.w], [ca.SX(v) for v in outputs])(solution.w)
        u, t = (np.asarray(v).ravel() for v in found[:2])
        theta = self.run.theta.copy()
        theta[self.places] = u
        self.system.check_parameters(theta)
        parameters = dict(zip(self.names, u.tolist(), strict=True))
        settings = self.course.settings
        if self.system.structure.states:
            # an ordinary run from the states found, with as many output times as there are nodes
            x = np.asarray(found[2])[:, 0]
            point = OperatingPoint(self.system, 0.0, x, theta, settings[0])
            grid = len(t) - 1
            run = simulate_led(self.system, until=float(t[-1]), start=point, grid=grid, rtol=_RTOL)
            true = [run.value(functional) for functional in self.functionals]
            told = true
        else:
            run = run_at(self.run, theta)
            true = [measure_functional(f, run) for f in self.functionals]
            told = [number_of(f, f.names, run.table(f.names), dt_of(run)) for f in self.functionals]
        values: dict[Key, float] = dict(zip(self.functionals, told, strict=True))
        error = 0.0
        promised = self.read_functionals(solution)
        for f, number in zip(self.functionals, true, strict=True):
            # an epigraph variable that nothing presses down says nothing
            if not self.terms[f].side or weights.get(f):
                size = max(abs(number), _LEAST * self.terms[f].scale)
                error = max(error, abs(promised[f] - number) / size)
        whole = 0.0
        for key, weight in weights.items():
            value = theta[self.system.places([key])[0]] if isinstance(key, str) else values[key]
            whole += weight * float(value)
        starts = self.run.theta[self.places].tolist()
        return Optimum(
            run,
            parameters,
            dict(zip(self.names, starts, strict=True)),
            whole,
            values,
            self._active(solution),
            float(error),
            solution,
        )

    def read_functionals(self, solution: Solution) -> dict[Functional, float]:
        """Functionals as the programme has them."""
        terms = ca.vertcat(ca.SX(0, 1), *(self.terms[f].value for f in self.functionals))
        said = np.asarray(ca.Function("said", [self.programme.w], [terms])(solution.w)).ravel()
        return dict(zip(self.functionals, said.tolist(), strict=True))

    def _active(self, solution: Solution) -> tuple[str, ...]:
        """Names of bounds and constraints that press."""
        found = []
        box = self.programme.box
        for first, name in enumerate(self.names):
            low, high = np.abs(solution.w[first] - box[first, 1:]) <= 1e-6
            if (low or high) and abs(solution.bounds[first]) > 1e-8:
                found.append(f"{name} at its {'lower' if low else 'upper'} bound")
        found += self.programme.list_active(solution)
        return tuple(dict.fromkeys(found))
