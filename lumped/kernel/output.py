"""Records of a run: points at wanted times or at steps, and both ends of each smooth piece."""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.methods.any_method import inside
from lumped.kernel.observe import observe_event
from lumped.kernel.run import Run, RunOutput

_SAME = 1e-13
"""Distance, relative to the size of all times, below which two times count as equal."""


@kernel
def has_room(output: RunOutput) -> bool:
    """Whether there is room for all wanted times that are left and a few rows more."""
    if output.most_turns > 0 and output.turns >= output.most_turns:
        return False
    return output.most_rows - output.rows >= output.grid_size - output.grid_next + 4


@kernel
def add_row(run: Run, t: float) -> Numbers:
    """Add a row; gives the place of its states."""
    output, plant = run.output, run.plant
    row, ng = output.rows, plant.implicit
    output.t[row] = t
    copy_numbers(ng, run.m[plant.settings - ng :], output.implicit[row * ng :])
    output.rows = row + 1
    return output.x[row * plant.states :]


@kernel
def record_edge(run: Run) -> None:
    """Record an end of a smooth piece; wanted times that coincide with it are left out."""
    output = run.output
    if not output.has_both_sides:
        return
    copy_numbers(run.plant.states, run.x, add_row(run, run.t))
    if output.is_on_grid:
        latest = run.t + _SAME * run.span
        while output.grid_next < output.grid_size and output.grid[output.grid_next] <= latest:
            output.grid_next += 1


@kernel
def record(run: Run, end: float, is_crossed: bool) -> None:
    """Record the wanted points of a step up to a time."""
    output = run.output
    if not output.is_on_grid:
        if not is_crossed or run.t_new < end:
            copy_numbers(run.plant.states, run.new, add_row(run, run.t_new))
        return
    k = output.grid_next
    while k < output.grid_size and output.grid[k] < end:
        part = (output.grid[k] - run.t) / (run.t_new - run.t)
        inside(run, part, add_row(run, output.grid[k]))
        k += 1
    output.grid_next = k


@kernel
def begin_piece(run: Run) -> None:
    """Begin a new smooth piece."""
    output, count = run.output, run.plant.settings - run.plant.implicit
    if output.is_short:
        return
    k = output.pieces
    output.piece_row[k] = output.rows
    copy_numbers(count, run.m, output.piece_settings[k * count :])
    output.pieces = k + 1
    record_edge(run)


@kernel
def note_change(
    run: Run, kind: int, number: int, was: int, now: int, loss: float, delay: float
) -> None:
    """Note that a condition (0) or hold (1) changed its position, now or after a delay."""
    output = run.output
    if run.watches:
        observe_event(run, kind, number, now, loss, delay)
    if output.is_short:
        return
    change, when = output.change[4 * output.changes :], output.change_time[2 * output.changes :]
    change[0], change[1], change[2], change[3] = kind, number, was, now
    when[0], when[1] = run.t + delay, loss
    output.changes += 1


@kernel
def note_turn(run: Run) -> None:
    """Note that the method changes with the present step."""
    output = run.output
    if output.most_turns > 0:
        output.turn[output.turns] = run.t
        output.turns += 1
