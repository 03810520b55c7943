"""Runs taken over by lanes and given back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from lumped.code.words import Numbers, flat, kernel, record_at
from lumped.kernel.many_runs.lane_records import STEPPING, WAITING
from lumped.kernel.many_runs.variants import Variants
from lumped.kernel.run import Run

if TYPE_CHECKING:
    Lanes: TypeAlias = Any  # its fields are wide
else:
    from lumped.kernel.many_runs.lane_records import Lanes

_NEVER = 1e300


@kernel
def _copy_in(wide: Numbers, count: int, lanes: int, lane: int, given: Numbers) -> None:
    for i in range(count):
        wide[i * lanes + lane] = given[i]


@kernel
def _copy_out(wide: Numbers, count: int, lanes: int, lane: int, out: Numbers) -> None:
    for i in range(count):
        out[i] = wide[i * lanes + lane]


@kernel
def load_sums(lanes: Lanes, run: Run, k: int) -> None:
    """What functionals have taken from a run so far."""
    own, watch, count = lanes.watch, run.watch, lanes.count
    _copy_in(flat(own.sums), own.integrands, count, k, watch.sums)
    _copy_in(flat(own.best), own.extremes, count, k, watch.best)
    has_more = watch.next_time < watch.times
    flat(lanes.next_look)[k] = watch.time[watch.next_time] if has_more else _NEVER


@kernel
def load(lanes: Lanes, k: int) -> None:
    """Take over a run that is due for a step."""
    variants = record_at(Variants, lanes.slot[k])
    run, plant, count = variants.run, lanes.plant, lanes.count
    n = plant.states
    _copy_in(flat(lanes.p), lanes.parameters, count, k, run.p)
    _copy_in(flat(lanes.m), plant.settings, count, k, run.m)
    _copy_in(flat(lanes.x), n, count, k, run.x)
    _copy_in(flat(lanes.stages), n, count, k, run.stages)
    flat(lanes.t)[k] = run.t
    flat(lanes.end)[k] = run.end
    flat(lanes.h)[k] = run.h
    flat(lanes.was_rejected)[k] = float(run.was_rejected)
    flat(lanes.stiff_steps)[k] = float(run.stiff_steps)
    flat(lanes.patience)[k] = float(run.patience)
    flat(lanes.untried_steps)[k] = float(run.untried_steps)
    flat(lanes.long_enough)[k] = run.long_enough
    flat(lanes.steps)[k] = float(run.steps)
    flat(lanes.rejected)[k] = float(run.rejected)
    flat(lanes.is_on)[k] = 1.0
    load_sums(lanes, run, k)
    lanes.state[k] = STEPPING


@kernel
def _unload(lanes: Lanes, k: int) -> Variants:
    """Give a run back, between two steps."""
    variants = record_at(Variants, lanes.slot[k])
    run, count, n = variants.run, lanes.count, lanes.plant.states
    own = lanes.watch
    _copy_out(flat(lanes.x), n, count, k, run.x)
    _copy_out(flat(lanes.stages), n, count, k, run.stages)
    implicit, place = lanes.plant.implicit, lanes.plant.settings - lanes.plant.implicit
    _copy_out(flat(lanes.m)[place * count :], implicit, count, k, run.m[place:])
    _copy_out(flat(lanes.found), implicit, count, k, run.found)
    run.t, run.h = flat(lanes.t)[k], flat(lanes.h)[k]
    run.was_rejected = int(flat(lanes.was_rejected)[k])
    run.stiff_steps = int(flat(lanes.stiff_steps)[k])
    run.patience = int(flat(lanes.patience)[k])
    run.untried_steps = int(flat(lanes.untried_steps)[k])
    run.steps, run.rejected = int(flat(lanes.steps)[k]), int(flat(lanes.rejected)[k])
    _copy_out(flat(own.sums), own.integrands, count, k, run.watch.sums)
    _copy_out(flat(own.best), own.extremes, count, k, run.watch.best)
    flat(lanes.is_on)[k] = 0.0
    lanes.state[k] = WAITING
    return variants


@kernel
def unload_step(lanes: Lanes, k: int) -> Variants:
    """Give a run back in the middle of an accepted step."""
    variants = _unload(lanes, k)
    run, count, n = variants.run, lanes.count, lanes.plant.states
    own = lanes.watch
    if own.extremes > 0:
        run.watch.may_rise = int(flat(lanes.may_rise)[k])
    if own.integrands > 0:
        run.watch.is_rough = int(flat(lanes.is_rough)[k])
        _copy_out(flat(own.parts), own.integrands, count, k, run.watch.parts)
    _copy_out(flat(lanes.new), n, count, k, run.new)
    run.by_series = lanes.by_series
    if lanes.by_series:
        size = lanes.terms * lanes.row
        _copy_out(flat(lanes.coefficients), size, count, k, run.coefficients)
    else:
        _copy_out(flat(lanes.dense), 7 * n, count, k, run.dense)
    _copy_out(flat(lanes.stages)[12 * n * count :], n, count, k, run.stages[12 * n :])
    run.t_new = flat(lanes.t_new)[k]
    return variants


@kernel
def hand_over(lanes: Lanes, k: int, by: int) -> Variants:
    """Let a run go on alone, by an entry of the time loop."""
    lanes.entry[k] = by
    return _unload(lanes, k)
