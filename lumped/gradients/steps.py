"""Steps of a run as native code: made again, looked into, and differentiated backwards."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import casadi as ca
import numpy as np

from lumped.code.functions import Columns
from lumped.code.operations import Operations, operations_of
from lumped.code.records import Record
from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.spans import Back, Carried, Jump, Pulse, Span
from lumped.kernel import engine
from lumped.kernel.enclosures.curves import POINT
from lumped.kernel.plant import Function
from lumped.kernel.recorded_steps.course import LOOKS, Course, Sweep
from lumped.kernel.recorded_steps.stops_back import Stops
from lumped.kernel.recorded_steps.sweep_back import LEAST
from lumped.kernel.run import GIVEN_UP, Run
from lumped.kernel.watch import Watch
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Shared, made_once
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.executable import Executable, smooth_executable
from lumped.timeloop.plants.many_points import CountedFunction, ManyPoints
from lumped.timeloop.programs import refuse_programs

FRACTIONS = tuple(i / LOOKS for i in range(1, LOOKS + 1))
"""Of each step, at which it is looked into."""

_STAGES = 13
"""Evaluations of the rates in a step, at most."""

_WIDTHS = (2, 4, 6, 8)
"""Columns that are carried back side by side."""


class Steps(Shared):
    """Steps of one system with integrals of some products, and the same backwards.

    Parameters
    ----------
    system : System
        From `assemble`.
    products : tuple of tuple of str
        Factors of what is integrated.
    """

    def __init__(self, system: System, products: tuple[tuple[str, ...], ...]) -> None:
        super().__init__()
        self.system = system
        self.integrands = ca.vertcat(ca.SX(0, 1), *map(system.product, products))
        x, self._p, self._t, self._m = system.inputs
        self.states, self.integrals = x.numel(), self.integrands.numel()
        self._all = self.states + self.integrals
        self._z = ca.vertcat(x, ca.SX.sym("integrals", self.integrals))
        self._rates = ca.densify(ca.cse(ca.vertcat(system.rates, self.integrands)))
        self._nominal = np.concatenate([nominals(system), np.zeros(self.integrals)])
        self._atol = np.where(self._nominal > 0, 1e-12 * self._nominal, 1.0)

    @property
    @made_once
    def _integrated(self) -> ca.Function:
        return ca.Function("integrated", self.system.inputs, [ca.densify(self.integrands)])

    @property
    @made_once
    def integrated(self) -> ArrayFunction:
        """What is integrated, at one point: (x, p, t, m)."""
        return ArrayFunction(self._integrated)

    @property
    @made_once
    def integrated_along(self) -> ManyPoints:
        """What is integrated, at points of a run."""
        return ManyPoints(self._integrated)

    @property
    @made_once
    def code(self) -> Executable:
        """The steps, ready to be made."""
        inputs = [self._z, self._p, self._t, self._m]
        functions = {"rates": ca.Function("rates", inputs, [self._rates])}

        def jacobian() -> ca.Function:
            by_t = ca.densify(ca.jacobian(self._rates, self._t))
            return ca.Function("jacobian", inputs, [ca.jacobian(self._rates, self._z), by_t])

        return smooth_executable(inputs, functions, jacobian, 0, {"pullback": self._pullback()})

    def _pullback(self) -> ca.Function:
        """Weighted rates, by states and parameters: (states and weights, p, t, m)."""
        weights = ca.SX.sym("weights", self._all)
        both = ca.vertcat(self._z, self._p)
        found = ca.densify(ca.jtimes(self._rates, both, weights, True))
        inputs = [ca.vertcat(self._z, weights), self._p, self._t, self._m]
        return ca.Function("pullback", inputs, [found[self._order]])

    @property
    @made_once
    def _order(self) -> list[int]:
        """States and parameters as rates depend on them, the first rate first.

        Results that share weights are computed one after the other then, and little is kept in
        memory between them.
        """
        both = ca.vertcat(self._z, self._p)
        rows, columns = ca.jacobian_sparsity(self._rates, both).get_triplet()
        first = np.full(both.numel(), self._all)
        np.minimum.at(first, columns, rows)
        found: list[int] = np.argsort(first, kind="stable").tolist()
        return found

    @property
    @made_once
    def _bent(self) -> Operations:
        """Weighted derivatives of the rates along increments and time, by states and parameters."""
        weights, along = ca.SX.sym("weights", self._all), ca.SX.sym("along", self._all + 1)
        change = ca.jtimes(self._rates, ca.vertcat(self._z, self._t), along)
        both = ca.vertcat(self._z, self._p)
        found = ca.densify(ca.jtimes(change, both, weights, True))
        inputs = [ca.vertcat(self._z, along, weights), self._p, self._t, self._m]
        return operations_of(ca.Function("bent", inputs, [found[self._order]]))

    @made_once
    def _columns(self, name: str, width: int) -> CountedFunction:
        """A function of so many columns."""
        begin = 2 * self._all + 1 if name == "bent" else self._all
        function = self._bent if name == "bent" else self.code.beside["pullback"]
        in_place = function.with_results_at(self._order)
        return CountedFunction(in_place, Columns(width, begin, self._all))

    def _run(self, span: Span, work: int, implicit: bool) -> Run:
        """A run of this thread that stands at the begin of some steps."""
        begin = np.concatenate([span.x[0], np.zeros(self.integrals)])
        run = self.code.at(span.theta, float(span.t[0]), begin, span.m[0])
        run.rtol = 1.0
        run.atol[:] = self._atol
        if implicit:
            self.code.add_matrix(run)
        if len(run.work) < work:
            run.work = np.zeros(work)
        return run

    def _course(self, span: Span) -> Course:
        return Course(
            steps=len(span.t) - 1,
            states=self.states,
            settings=span.m.shape[1],
            integrals=self.integrals,
            t=np.ascontiguousarray(span.t, dtype=float),
            x=np.ascontiguousarray(span.x, dtype=float).ravel(),
            m=np.ascontiguousarray(span.m, dtype=float).ravel(),
            is_step=span.is_step,
            is_implicit=span.is_implicit.astype(np.int64),
        )

    def _call(self, entry: str, run: Run, *given: Record) -> None:
        """Call an entry for recorded steps.

        Raises
        ------
        SolverError
            If the equations of an implicit step cannot be solved.
        """
        if engine.call(entry, run, *given) == GIVEN_UP:
            raise SolverError(
                f"{self.system.name}: the equations of an implicit step near t = {run.t:.9g} s "
                "cannot be solved, which its derivatives need. Tighten rtol, or take "
                "method='explicit'.",
                None,
            )
        self.code.account(run)

    def replay(self, span: Span, is_given: np.ndarray) -> np.ndarray:
        """States at all ends of steps, shape (k + 1, n), from those that are given."""
        run = self._run(span, 0, span.needs_matrix)
        course = self._course(span)
        course.x = course.x.copy()  # it may be that of a run
        course.is_given = is_given.astype(np.int64)
        self._call("replay_steps", run, course)
        return course.x.reshape(span.x.shape)

    def evaluate_inside(self, span: Span, function: CountedFunction, width: int) -> np.ndarray:
        """Results of a function inside steps, shape (k, LOOKS, width); zero where there is none."""
        steps = len(span.t) - 1
        run = self._run(span, function.work, span.needs_matrix)
        course = self._course(span)
        course.width, course.found = width, np.zeros(steps * LOOKS * width)
        self._call("evaluate_inside", run, function.for_more(steps * LOOKS), course)
        return course.found.reshape(steps, LOOKS, width)

    def list_points(
        self, span: Span, watch: Watch, functions: Mapping[str, CountedFunction], rtol: float
    ) -> np.ndarray:
        """Points inside steps that a watch lists, shape (k, 3): number of the step, part, value.

        Without room for any, what the watch asks for is taken from the steps.

        Parameters
        ----------
        functions : mapping of str to CountedFunction
            Functions by the fields of the watch.
        """
        steps = len(span.t) - 1
        work = max(function.work for function in functions.values())
        run, course = self._run(span, work, span.needs_matrix), self._course(span)
        run.rtol, run.watch = rtol, watch
        for name, function in functions.items():
            setattr(watch, name, function.for_more(steps))
        is_complete = False
        while not is_complete:
            watch.list = np.zeros(max(POINT * watch.lists, 1))
            self._call("list_points", run, course)
            is_complete = watch.listed <= watch.lists
            watch.lists = max(watch.lists, watch.listed)
        return watch.list[: POINT * watch.listed].reshape(-1, POINT)

    def back(
        self,
        span: Span,
        later: Carried,
        pulses: Sequence[Pulse] = (),
        jumps: Sequence[Jump] = (),
    ) -> Back:
        """Carry back the derivatives at the end; `pulses` and `jumps` are in the order of time."""
        count = later.adjoint.shape[1]
        most = _WIDTHS[-1] // 2
        found = []
        for k in range(0, max(count, 1), most):
            own = slice(k, k + most)
            some = [p._replace(column=p.column - k) for p in pulses if k <= p.column < k + most]
            stops = self._stops(some, [j._replace(late=j.late[own]) for j in jumps])
            found.append(self._back(span, Carried(*(v[:, own] for v in later)), stops))
        if len(found) == 1:
            return found[0]
        every = (
            np.concatenate(v, axis=1)
            for v in zip(*((*some.carried, some.errors) for some in found), strict=True)
        )
        *carried, errors = every
        return found[0]._replace(carried=Carried(*carried), errors=errors)

    def _stops(self, pulses: Sequence[Pulse], jumps: Sequence[Jump]) -> Stops:
        """Pulses and jumps as the kernel takes them."""
        stops = Stops(pulses=len(pulses), jumps=len(jumps), states=self.states)
        stops.pulse_end = np.array([p.end for p in pulses], dtype=np.int64)
        stops.pulse_column = np.array([p.column for p in pulses], dtype=np.int64)
        stops.pulse = _one_after_the_other(p.slopes for p in pulses)
        stops.jump_step = np.array([j.step for j in jumps], dtype=np.int64)
        changes = [j.change for j in jumps]
        matrices = {"": [c.states for c in changes], "parameter_": [c.parameters for c in changes]}
        for name, own in matrices.items():
            firsts = np.cumsum([0, *(len(entries.rows) for entries in own)])
            setattr(stops, f"first_{name}entry", firsts.astype(np.int64))
            for i, (what, kind) in enumerate((("row", int), ("column", int), ("entry", float))):
                setattr(stops, name + what, _one_after_the_other((e[:3][i] for e in own), kind))
        stops.drift = _one_after_the_other(c.drift for c in changes)
        stops.instant = _one_after_the_other(c.instant for c in changes)
        stops.late = _one_after_the_other(j.late for j in jumps)
        return stops

    def relative(self, largest: np.ndarray, lost: np.ndarray) -> np.ndarray:
        """Errors relative to the derivatives of each result by the states, shape (k,)."""
        own = self._nominal > 0
        nominal = self._nominal[own, None]
        with np.errstate(invalid="ignore", over="ignore"):
            most = (largest[own] * nominal).max(axis=0, initial=0.0)
            size = np.maximum(largest[own], LEAST * most / nominal)
            parts = np.divide(lost[own], size, out=np.zeros_like(size), where=size != 0)
            found: np.ndarray = np.sqrt((parts**2).sum(axis=0) / max(own.sum(), 1))
        return found

    def _back(self, span: Span, later: Carried, stops: Stops) -> Back:
        """The same for a few results."""
        count, steps = later.adjoint.shape[1], len(span.t) - 1
        n, p = self._all, self._p.numel()
        width = next(w for w in _WIDTHS if w >= 2 * count) if count else 0
        results = width // 2
        implicit = span.needs_matrix
        sweep = Sweep(
            {"states": n, "parameters": p, "columns": width, "results": results},
            results=results,
            columns=width,
            parameters=p,
        )
        work, none = 0, Function()
        for name in ("pullback", "bent"):
            if width and (implicit or name == "pullback"):
                function = self._columns(name, width)
                work = max(work, function.work)
                setattr(sweep, name, function.for_more(_STAGES * steps))
            else:
                setattr(sweep, name, none)
        run = self._run(span, work, implicit)
        shapes = {"adjoint": (n, width), "by_parameters": (p, results)}
        shapes |= {"largest": (n, width), "errors": (n, width)}
        carried = [getattr(sweep, v).reshape(shape)[:, :count] for v, shape in shapes.items()]
        for own, given in zip(carried, later, strict=True):
            own[:] = given
        sweep.weight[:] = self._nominal
        course = self._course(span)
        course.errors = np.zeros(steps * results)
        course.parts = np.zeros(steps * self.integrals)
        course.part_errors = np.zeros(steps * self.integrals)
        self._call("sweep_steps", run, sweep, course, stops)
        each = (steps, self.integrals)
        sums = course.parts.reshape(each), course.part_errors.reshape(each)
        errors = course.errors.reshape(steps, results)[:, :count]
        return Back(Carried(*(own.copy() for own in carried)), errors, *sums)


@made_once
def steps_of(system: System, products: tuple[tuple[str, ...], ...]) -> Steps:
    """Steps of a system."""
    refuse_programs(system, "a derivative of a run")
    return Steps(system, products)


def _one_after_the_other(parts: Iterable[np.ndarray], kind: type = float) -> np.ndarray:
    """Arrays in one; never empty."""
    return np.concatenate([*parts, np.zeros(1, kind)], dtype=kind)
