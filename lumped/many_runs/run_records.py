"""Records for runs of variants: what the loop needs of a system, what varies, functionals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.code.functions import compile_functions
from lumped.code.operations import Operations, operations_of
from lumped.code.records import address
from lumped.compiler.system import System
from lumped.errors import LumpedError
from lumped.functionals import Functional
from lumped.kernel import engine
from lumped.kernel.clocks import Clocks
from lumped.kernel.many_runs.lane_records import Lanes, LaneWatch
from lumped.kernel.many_runs.variants import Variants
from lumped.kernel.plant import Function
from lumped.kernel.run import Run, RunOutput
from lumped.many_runs.watched import KINDS, Watched
from lumped.points.direct_start import DirectStart, direct_start
from lumped.points.start import by_name, run_start
from lumped.points.start_values import read_start_values
from lumped.points.targets import TOLERANCE
from lumped.timeloop.clocks import find_moved_clocks, modes_at
from lumped.timeloop.instants import Instants, instants
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.executable import executable, span
from lumped.timeloop.plants.kept_run import place_of, remember
from lumped.timeloop.plants.taylor_series import TaylorSeries
from lumped.timeloop.plants.written_step import WrittenStep
from lumped.timeloop.programs import programs_of
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import scale
from lumped.timeloop.run_options import RunPlan
from lumped.timeloop.settings import just_after

_EVER = 1 << 60
_LOOKS = 4000
"""Steps of a run without states."""
_MOST_STATES = 500
"""States up to which the stages of all lanes stay near the processor."""


class RunRecords:
    """Makes the records that runs of variants need; threads share it.

    Parameters
    ----------
    system : System
    names : sequence of str
        Parameters that vary.
    theta : ndarray
        All parameters.
    of : mapping of str to functional
        What is wanted.
    options : RunPlan
    """

    def __init__(
        self,
        system: System,
        names: Sequence[str],
        theta: np.ndarray,
        of: Mapping[str, Functional],
        options: RunPlan,
    ) -> None:
        self.system, self.names, self.theta, self.options = system, tuple(names), theta, options
        self.places = np.array(system.places(names), dtype=np.int64)
        self.watched = Watched(system, of, options.begin, options.until)
        self._code = executable(system)
        self._code.compile()
        changed: dict[int, float] = {}
        self._start: DirectStart | None = None
        if not (isinstance(options.start, OperatingPoint) or options.free):
            changed = read_start_values(system, by_name(options.start))
            self._start = direct_start(system, tuple(changed))
        self._start_values = np.array(list(changed.values()), dtype=float)
        functions = dict(self.watched.functions)
        if self._start is not None:
            functions["start"] = operations_of(_with_inputs(system, self._start, len(changed)))
        varied = system.inputs[1][self.places.tolist()]
        self._moved = find_moved_clocks(system, varied)
        self.are_instants_same = self._moved.are_plain and not options.free
        if self._moved.numbers:
            functions["at"] = operations_of(self._moved.function)
        self._functions, self._nothing = self._compile(functions), Function()
        self._first_instants = self._instants(theta)
        if options.method == "taylor":
            self._taylor.order(options.rtol)  # refused before there are threads
        if self.has_lanes:
            self._code.compile_lanes(engine.LANES)
            if options.method == "taylor":
                self._taylor.compile_lanes(options.rtol, engine.LANES)
            engine.lanes()
            self._compile_watch()

    def _compile(self, operations: Mapping[str, Operations]) -> dict[str, Function]:
        if not operations:
            return {}
        self._machine_code = compile_functions(operations)
        return {
            name: Function(
                address=self._machine_code.address(name),
                count=len(operations[name].table),
                operations=operations[name].table.ravel(),
                constants=operations[name].constants,
            )
            for name in operations
        }

    def _compile_watch(self) -> None:
        """Machine code of what is looked at inside steps, for several lanes side by side."""
        names = [n for n in self._functions if n in ("integrand", "height")]
        if not names:
            return
        operations = {name: self.watched.functions[name] for name in names}
        self._wide_code = compile_functions(operations, engine.LANES)
        for name in names:
            self._functions[name].wide_address = self._wide_code.address(name)

    def _instants(self, theta: np.ndarray) -> Instants:
        options, moved = self.options, frozenset(self._moved.numbers)
        return instants(self.system, theta, options.begin, options.until, moved)

    def new_run(self) -> Variants:
        """Records for the runs of one lane."""
        options, plant = self.options, self._code.plant
        n = plant.states
        settings = np.zeros(self.system.inputs[3].numel())
        run = self._code.new_run(
            self.theta, options.begin, np.zeros(n), settings, self.watched.integrands
        )
        span(run, scale(options.begin, options.until))
        run.rtol, run.max_steps, run.pause = options.rtol, options.max_steps, _EVER
        run.atol[:] = run.least_atol[:] = options.relative_atol * nominals(self.system)
        run.chooses_method = options.method in ("steps", "taylor")
        if not n:
            run.longest = (options.until - options.begin) / _LOOKS
        run.output = _no_output()
        run.watches = 1
        run.watch = self.watched.record()
        for name in (*KINDS, "height", "kink"):
            setattr(run.watch, name, self._functions.get(name, self._nothing))
        if options.method != "taylor":
            run.written, run.is_written = self.written_step(1).function, 1
        self._set_instants(run, self._first_instants)
        if options.method == "implicit" and n:
            self._code.add_matrix(run)
            run.is_implicit = 1
        if options.method == "taylor" and n:
            self._taylor.add_to(run, options.rtol)
        run.t = options.begin
        sizes = {"states": n, "settings": plant.settings}
        variants = Variants(
            sizes,
            run=run,
            clocks=self._clocks(run),
            columns=len(self.names),
            place=self.places,
            parameters=len(self.theta),
            nominal=self.theta.copy(),
            start_values=self._start_values,
            tolerated=TOLERANCE,
            begins=bool(self.system.switching),
            first_time=options.begin,
            first_settings=self._first_settings(self.theta),
            width=self.watched.width,
        )
        if self._start is not None:
            count = sum(self._start.function.numel_out(i) for i in range(3))
            variants.start, variants.start_count = self._functions["start"], count
            variants.found_start = np.zeros(count)
        remember(run)
        return variants

    def new_lanes(self, slots: Sequence[Variants]) -> Lanes:
        """Records for several runs side by side."""
        plant, run = self._code.plant, slots[0].run
        watch = run.watch
        sizes = {"lanes": len(slots), "states": plant.states, "settings": plant.settings}
        sizes |= {"margins": plant.margins, "levers": plant.levers, "integrands": watch.integrands}
        sizes |= {"parameters": plant.parameters, "prepared": plant.prepared}
        sizes |= {"forcings": plant.forcings, "implicit": plant.implicit}
        sizes |= {"extremes": watch.extremes, "terms": run.terms, "row": run.row}
        own = LaneWatch(sizes, integrands=watch.integrands, extremes=watch.extremes)
        own.loads = watch.loads
        own.integrand, own.height = watch.integrand, watch.height
        own.begin[:], own.end[:] = watch.begin, watch.end
        lanes = Lanes(
            sizes,
            plant=plant,
            watch=own,
            count=len(slots),
            parameters=plant.parameters + plant.prepared,
            looks_inside=plant.margins > 0 or watch.loads > 0,
            watches=1,
            max_steps=float(run.max_steps),
            by_series=run.order > 0,
        )
        for name in ("chooses_method", "rtol", "longest", "order", "terms", "row", "caution"):
            setattr(lanes, name, getattr(run, name))
        if run.order:
            lanes.series = run.series
        for name in ("until_steps_of", "attempt_of", "crossing_of", "look_of", "end_of"):
            setattr(lanes, name, engine.entry_address(name))
        lanes.slot[:] = [address(slot) for slot in slots]
        lanes.atol[:] = np.repeat(run.atol, len(slots))
        if not run.order:
            lanes.written, lanes.is_written = self.written_step(len(slots)).function, 1
        return lanes

    def written_step(self, lanes: int) -> WrittenStep:
        """An attempt of a step with what is integrated over it."""
        return self._code.written_step(lanes, self.watched.functions.get("integrand"))

    def account(self, attempts: int) -> None:
        """Note attempts of steps; compile what that is worth."""
        if self.options.method not in ("taylor", "implicit"):
            self.written_step(engine.LANES if self.has_lanes else 1).account(attempts)

    @cached_property
    def _taylor(self) -> TaylorSeries:
        """Series of the states, and of what is integrated if that does well."""
        integrand = self.watched.functions.get("integrand")
        found = self._code.taylor
        return found if integrand is None else found.with_integrals(integrand)

    @cached_property
    def has_lanes(self) -> bool:
        """Whether runs go side by side; the model decides, so it is the same every time."""
        plant = self._code.plant
        fits = 0 < plant.states <= _MOST_STATES and not programs_of(self.system)
        return fits and self.options.method != "implicit" and engine.is_compiled()

    def _set_instants(self, run: Run, found: Instants) -> None:
        edges = np.array([self.options.begin, *found.times.tolist(), self.options.until])
        run.segments, run.edges = len(edges) - 1, edges
        run.timed = len(found.places)
        run.timed_setting = np.ascontiguousarray(found.places, dtype=np.int64)
        run.timed_values = np.ascontiguousarray(found.modes).ravel()

    def _clocks(self, run: Run) -> Clocks:
        """The record of clocks that move with what varies."""
        moved, options, still = self._moved, self.options, self._first_instants
        sizes = {"clocks": len(moved.numbers), "still": len(still.times), "timed": run.timed}
        size = scale(options.begin, options.until)
        found = Clocks(
            sizes,
            count=len(moved.numbers),
            at=self._functions.get("at", self._nothing),
            begin=options.begin,
            end=options.until,
            first=just_after(options.begin),
            apart=1e-13 * size,
            beyond=options.until + 1e-9 * max(options.until - options.begin, 1e-300),
            still=len(still.times),
            still_time=np.append(still.times, np.inf),
            still_values=np.ascontiguousarray(still.modes).ravel(),
        )
        columns = still.places.tolist()
        for k, (mode, is_strict) in enumerate(moved.relations):
            found.setting[k], found.is_strict[k] = mode, is_strict
            found.column[k] = columns.index(mode)
        return found

    def _first_settings(self, theta: np.ndarray) -> np.ndarray:
        settings = np.zeros(self._code.plant.settings)
        modes = modes_at(self.system, theta, just_after(self.options.begin))
        settings[: len(modes)] = modes
        return settings

    def set_instants(self, variants: Variants, values: np.ndarray) -> None:
        """Set the instants of a variant that has its own."""
        theta, run = self.theta.copy(), variants.run
        theta[self.places] = values
        run.memory[:] = run.memory_at_first
        self._set_instants(run, self._instants(theta))
        variants.first_settings = self._first_settings(theta)
        remember(run)

    @property
    def is_start_direct(self) -> bool:
        """Whether the loop finds the start itself."""
        return self._start is not None

    def find_start(self, values: np.ndarray) -> np.ndarray:
        """The start of a variant, given or found by a search, as `Variants` have it."""
        theta = dict(zip(self.system.parameters, self.theta.tolist(), strict=True))
        theta |= dict(zip(self.names, values.tolist(), strict=True))
        plant = self._code.plant
        none = np.full(1 + plant.states + plant.settings + len(self.theta), -1.0)
        try:
            point = run_start(self.system, self.options._replace(parameters=theta))
        except LumpedError:
            return none
        if point.system is not self.system:
            return none
        first = point.before or point  # before what collides there
        return np.hstack([bool(point.collisions), first.x, first.settings, point.theta])

    def add_matrix(self, run: Run) -> None:
        """Let a run make implicit steps, this one and those after it."""
        self._code.add_matrix(run)
        for name in ("matrix", "has_matrix", "work"):
            place = place_of(run, name)
            run.memory_at_first[place] = run.memory[place]


def _with_inputs(system: System, form: DirectStart, count: int) -> ca.Function:
    """States at the start as a function of start values, parameters and time."""
    _, p, t, m = system.inputs
    values = ca.SX.sym("values", count)
    results = form.function(p, t, values)
    return ca.Function("start", [values, p, t, m], list(results))


def _no_output() -> RunOutput:
    """Room for no points at all."""
    none = np.zeros(8)
    return RunOutput(
        t=none,
        x=none,
        implicit=none,
        most_rows=8,
        piece_row=np.zeros(1, dtype=np.int64),
        piece_settings=none,
        most_pieces=1,
        change=np.zeros(1, dtype=np.int64),
        change_time=none,
        most_changes=_EVER,
        grid=none,
        is_on_grid=1,
        is_short=1,
    )
