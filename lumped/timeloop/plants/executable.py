"""A system as a plant that the time loop runs: its functions, tables, and room for a run."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.code.functions import compile_functions, load_functions
from lumped.code.inverses import multiply_by_inverses
from lumped.code.machine_code import Code
from lumped.code.operations import Operations, operations_of
from lumped.code.parameter_parts import prepare_parts
from lumped.compiler.system import System
from lumped.kernel import engine
from lumped.kernel.methods.pivots import pattern_of
from lumped.kernel.plant import Function, Plant
from lumped.kernel.run import Matrix, Pattern, Run
from lumped.support.made_once import made_once
from lumped.timeloop.plants.kept_run import KeptRun, OutputRoom, make_run, remember
from lumped.timeloop.plants.parts import (
    any_direction,
    find_enclosed_sizes,
    operations_of_each,
    parts_of,
    plant_sizes,
    select_enclosed,
    slopes_along,
)
from lumped.timeloop.plants.taylor_series import TaylorSeries
from lumped.timeloop.plants.written_step import WrittenStep

WORTH = 30_000
"""Evaluations of functions that take as long as compiling them."""
_SELDOM = ("leverage", "following", "jacobian", "opened")
"""Functions that explicit steps need at most once in a step, each compiled for itself."""
_LARGE = 30_000
"""Nonzeros of a Jacobian from which on it is found along directions if they are more than the
operations of the rates: a table of it grows faster."""
_KEPT_ROOM = 1_000_000
"""Numbers of output whose room is kept for the next run."""
_KEPT_RUNS = 3
"""Runs of a thread that are over and kept for others with the same options."""
_HALF_SECOND = 100_000_000
"""Operations in about half a second, interpreted."""


class Executable:
    """What runs of a system share; nothing in it depends on parameters or on a run.

    Its functions are interpreted until that took as long as compiling them would, those that each
    stage of a step needs before the others; both give the same bits. What was compiled before is
    taken from the cache.

    Parameters
    ----------
    functions : dict of str to Operations
        Functions of the plant by the names of its fields.
    jacobian : callable
        Gives the Jacobian of the rates and their derivative by time when it is needed.
    sizes : dict of str to int
        States, settings, parameters, and so on (see `lumped.kernel.run`).
    plant : Plant
        With its tables.
    beside : dict of str to Function, optional
        More functions for which what depends on parameters alone is computed once for a run.
    system : System, optional
        Whose Jacobian is found along directions if it is large.

    Attributes
    ----------
    beside : dict of str to Operations
        These functions.
    taylor : TaylorSeries
        For steps by series.
    """

    def __init__(
        self,
        functions: dict[str, Operations],
        jacobian: Callable[[], ca.Function],
        sizes: dict[str, int],
        plant: Plant,
        beside: dict[str, ca.Function] | None = None,
        system: System | None = None,
    ) -> None:
        self.plant, self._jacobian, self._system = plant, jacobian, system
        self._operations: dict[str, Operations] = {}
        self._kept: list[object] = []  # what a run of another thread may still call
        self._interpreted = 0
        self._pattern: Pattern | None = None
        self._own = threading.local()
        none = Function()
        for name, field in Plant.fields.items():
            if field.kind is Function:
                setattr(plant, name, none)
        more = operations_of_each(beside or {})
        more = {name: multiply_by_inverses(operations) for name, operations in more.items()}
        found, parts = prepare_parts({**functions, **more}, sizes["parameters"])
        self.beside = {name: found.pop(name) for name in beside or ()}
        self.sizes = {
            **sizes,
            "prepared": parts.results,
            **find_enclosed_sizes(select_enclosed(found)),
        }
        plant.parameters, plant.prepared = sizes["parameters"], parts.results
        self._prepares = parts.results > 0
        self._written: dict[tuple[int, bytes], WrittenStep] = {}
        self.taylor = TaylorSeries(found["rates"], sizes["states"], sizes["implicit"])
        self._add({**found, "prepare": parts} if parts.results else found)

    def _add(self, found: dict[str, Operations]) -> None:
        """Take functions, in machine code if that was made before."""
        for name, operations in found.items():
            made = Function(
                count=len(operations.table),
                operations=operations.table.ravel(),
                constants=operations.constants,
            )
            self._kept.append(made)
            setattr(self.plant, name, made)
        self._operations |= found
        for group in self._interpreted_groups():
            code = load_functions(group)
            if code is not None:
                self._take(code, group)
        self._note_waiting()

    def _take(self, code: Code, names: Iterable[str]) -> None:
        self._kept.append(code)
        for name in names:
            getattr(self.plant, name).address = code.address(name)
        self._note_waiting()

    def _note_waiting(self) -> None:
        """Note how many operations the next group has that may be compiled."""
        groups = self._interpreted_groups()[:1]
        self._waiting = sum(len(part.table) for group in groups for part in group.values())

    def _interpreted_groups(self) -> list[dict[str, Operations]]:
        """Functions without machine code: those that each stage of a step needs, then others."""
        waiting = {
            name: operations
            for name, operations in self._operations.items()
            if not getattr(self.plant, name).address
        }
        often = {name: waiting[name] for name in waiting if name not in _SELDOM}
        seldom = [{name: waiting[name]} for name in _SELDOM if name in waiting]
        return [group for group in (often, *seldom) if group]

    def compile(self) -> None:
        """Make machine code of all functions now."""
        for group in self._interpreted_groups():
            self._take(compile_functions(group), group)

    def compile_lanes(self, count: int) -> None:
        """Make machine code of what explicit steps need, for several lanes side by side."""
        names = [
            n
            for n in ("rates", "closure", "margin_floor", "forcing", "forcing_range", "leverage")
            if n in self._operations
        ]
        if self.plant.rates.wide_address:
            return
        code = compile_functions({name: self._operations[name] for name in names}, count)
        self._kept.append(code)
        for name in names:
            getattr(self.plant, name).wide_address = code.address(name)

    def written_step(self, lanes: int, integrand: Operations | None = None) -> WrittenStep:
        """The attempt of a step written out, for several lanes side by side."""
        key = lanes, b"" if integrand is None else integrand.key
        found = self._written.get(key)
        if found is None:
            rates = None if self.plant.invariants else self._operations["rates"]
            found = WrittenStep(rates, self.plant.states, lanes, integrand)
        return self._written.setdefault(key, found)

    def account(self, run: Run) -> None:
        """Note what a run interpreted since it was asked last; compile what that is worth."""
        if not run.interpreted:
            return
        self._interpreted += run.interpreted
        run.interpreted = 0
        if self._interpreted > WORTH * self._waiting:
            for group in self._interpreted_groups()[:1]:
                self._take(compile_functions(group), group)
                self._interpreted = 0

    @cached_property
    def attempts(self) -> int:
        """Steps between two visits to Python, about half a second."""
        work = 20 * (self.plant.rates.count + self.plant.states + 1)
        return int(_HALF_SECOND // work) + 1

    def new_run(
        self,
        theta: np.ndarray,
        t: float,
        x: np.ndarray,
        settings: np.ndarray,
        integrands: int = 0,
    ) -> Run:
        """A run at a point, without output, with room for integrals.

        Times count as about one second (see `span`).
        """
        run = self.blank_run(integrands)
        run.t = t
        self.place(run, theta, x, settings)
        return run

    def blank_run(self, integrands: int = 0) -> Run:
        """A run without options, at no point yet; that of one that is over if there are enough."""
        over = self._over
        if len(over) >= _KEPT_RUNS and not integrands:
            run, self._own.room = over.pop(0).begin_again()
            return run
        work = max(operations.work for operations in self._operations.values())
        sizes = {**self.sizes, "work": work, "integrands": integrands}
        run = make_run(sizes, self.plant)
        run.written, run.is_written = self.written_step(1).function, 1
        run.yielding = -1.0
        span(run, 1.0)
        remember(run)
        return run

    def place(self, run: Run, theta: np.ndarray, x: np.ndarray, settings: np.ndarray) -> None:
        """Set parameters, what is computed from them alone, states and settings."""
        run.p[: len(theta)], run.x[:], run.m[:] = theta, x, settings
        if self._prepares:
            engine.call("prepare_parameters", run)

    def room(self, sizes: tuple[int, int, int, int, int, int]) -> OutputRoom:
        """Room for output, that of a run that is over if it has the sizes."""
        room: OutputRoom | None = self._own.__dict__.pop("room", None)
        return room if room is not None and room.sizes == sizes else OutputRoom(sizes)

    @property
    def _over(self) -> list[KeptRun]:
        """Runs of this thread that are over."""
        over: list[KeptRun] = self._own.__dict__.setdefault("over", [])
        return over

    def reuse_run(self, options: object) -> KeptRun | None:
        """A run that is over, at its begin again, if one had these options."""
        over = self._over
        for place in range(len(over) - 1, -1, -1):
            if over[place].options == options:
                kept = over.pop(place)
                kept.begin()
                return kept
        return None

    def take_back(self, kept: KeptRun) -> None:
        """Let another run of this thread have the records of one that is over, and its matrix."""
        self.written_step(1).account(kept.run.steps)
        if kept.room.x.size <= _KEPT_ROOM:
            self._over.append(kept)

    def add_matrix(self, run: Run) -> None:
        """Let a run make implicit steps."""
        if run.has_matrix:
            return
        if self._pattern is None:
            self._pattern = self._find_pattern()
        work = self._operations["jacobian"].work
        if len(run.work) < work:
            run.work = np.zeros(work)
        sizes = {"states": self.plant.states, "nonzeros": self._pattern.nonzeros}
        sizes["entries"] = self._pattern.entries
        run.matrix, run.has_matrix = Matrix(sizes, pattern=self._pattern), 1

    def _find_pattern(self) -> Pattern:
        """The pattern of the Jacobian, whose function is taken."""
        system, colour = self._system, None
        if system is not None:
            sparsity = ca.jacobian_sparsity(system.rates, system.inputs[0])
            if sparsity.nnz() > max(_LARGE, self.plant.rates.count):
                colour = np.array(sparsity.uni_coloring().T.row(), dtype=np.int64)
                self._add({"jacobian": slopes_along(system)})
        if colour is None:
            function = self._jacobian()
            sparsity = function.sparsity_out(0)
            self._add({"jacobian": operations_of(function, full=False)})
        rows, columns = (np.array(v, dtype=int) for v in sparsity.get_triplet())
        return pattern_of(rows, columns, self.plant.states, colour)

    def evaluate(
        self, name: str, x: np.ndarray, theta: np.ndarray, t: float, settings: np.ndarray
    ) -> np.ndarray:
        """Results of a function at a point, one after the other."""
        run = self.at(theta, t, x, settings)
        found = np.zeros(self._operations[name].results)
        engine.call("value", run, getattr(self.plant, name), found)
        return found

    def at(self, theta: np.ndarray, t: float, x: np.ndarray, settings: np.ndarray) -> Run:
        """The same run each time, of this thread, at another point."""
        run: Run | None = getattr(self._own, "run", None)
        if run is None:
            run = self._own.run = self.new_run(theta, t, x, settings)
        self.place(run, theta, x, settings)
        run.t, run.yielding = t, -1.0
        return run


def span(run: Run, size: float) -> None:
    """Tell the size of the times of a run, s.

    What happens within 1e-12 of it happens at once; a bounce that would last less than 1e-10 of it
    is left out.
    """
    run.span, run.soon, run.shortest = size, 1e-12 * size, 1e-10 * size
    run.longest = np.inf


@made_once
def executable(system: System) -> Executable:
    """The system, ready to be run."""
    functions, sizes, fields = parts_of(system)
    return Executable(functions, lambda: system.jacobian, sizes, Plant(**fields), system=system)


def smooth_executable(
    inputs: list[ca.SX],
    functions: dict[str, ca.Function],
    jacobian: Callable[[], ca.Function],
    implicit: int,
    beside: dict[str, ca.Function] | None = None,
) -> Executable:
    """Any differential equations without conditions and holds, ready to be run.

    Parameters
    ----------
    inputs : list of SX
        States, parameters, time, settings.
    functions : dict of str to Function
        Rates of the states, and the closure if there are implicit quantities.
    jacobian : callable
        Gives their Jacobian and derivative by time when it is needed.
    implicit : int
        Number of implicit quantities.
    beside : dict of str to Function, optional
        As for `Executable`.
    """
    x, p, _, m = inputs
    sizes = {name: 0 for name, field in Plant.fields.items() if field.kind == "int"}
    sizes |= {"states": x.numel(), "parameters": p.numel(), "settings": m.numel()}
    sizes |= {"implicit": implicit, "jump_values": 0}
    plant = Plant(**plant_sizes(sizes), any_direction=any_direction(implicit))
    return Executable(operations_of_each(functions), jacobian, sizes, plant, beside)


def evaluate_at(
    system: System, name: str, x: np.ndarray, theta: np.ndarray, t: float, settings: np.ndarray
) -> np.ndarray:
    """Results of a function of a system ("rates", "look", "margin") at a point."""
    return executable(system).evaluate(name, x, theta, t, settings)
