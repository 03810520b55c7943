"""What is added to the adjoint at ends of recorded steps, and how it crosses changes of states."""

from __future__ import annotations

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, kernel
from lumped.kernel.recorded_steps.course import Sweep
from lumped.kernel.run import Run


class Stops(Record):
    """Pulses at ends of steps, and jumps between one step and the next, in the order of time.

    A jump makes of the states ``S x + P p`` and comes at an instant that moves; matrices are sums
    of entries, those of one jump after the other.

    Attributes
    ----------
    pulses, next_pulse : int
        How many there are, and the next one.
    pulse_end, pulse_column : Integers
        End of a step at which each is added, and to which result.
    pulse : Numbers
        Derivatives of the results by all states, integrals among them.
    jumps, next_jump : int
        How many there are, and the next one.
    jump_step : Integers
        Number of the missing step whose place each takes.
    first_entry, first_parameter_entry : Integers
        First entries of each in S and P, and those after the last.
    row, column, entry : Integers, Integers, Numbers
        Entries of S.
    parameter_row, parameter_column, parameter_entry : Integers, Integers, Numbers
        Entries of P.
    states : int
        How many there are without integrals.
    drift : Numbers
        What a later instant adds to the states.
    instant : Numbers
        Derivatives of the instants by states and parameters.
    late : Numbers
        Derivatives of the results by the instants themselves.
    """

    pulses: int
    next_pulse: int
    pulse_end: Integers
    pulse_column: Integers
    pulse: Numbers
    jumps: int
    next_jump: int
    jump_step: Integers
    first_entry: Integers
    first_parameter_entry: Integers
    row: Integers
    column: Integers
    entry: Numbers
    parameter_row: Integers
    parameter_column: Integers
    parameter_entry: Numbers
    states: int
    drift: Numbers
    instant: Numbers
    late: Numbers


@kernel
def begin_stops(stops: Stops) -> None:
    """Begin with the last ones."""
    stops.next_pulse = stops.pulses - 1
    stops.next_jump = stops.jumps - 1


@kernel
def add_pulses(run: Run, sweep: Sweep, stops: Stops, end: int) -> None:
    """Add derivatives of results by the states at an end of a step."""
    n, i = run.plant.states, stops.next_pulse
    while i >= 0 and stops.pulse_end[i] == end:
        for k in range(n):
            sweep.adjoint[k * sweep.columns + stops.pulse_column[i]] += stops.pulse[i * n + k]
        i -= 1
    stops.next_pulse = i


@kernel
def _cross_one(sweep: Sweep, stops: Stops, jump: int, result: int) -> None:
    """Carry the adjoint of one result back over one jump."""
    n, columns, p = stops.states, sweep.columns, sweep.parameters
    weight = stops.late[jump * sweep.results + result]
    for i in range(n):
        weight += stops.drift[jump * n + i] * sweep.adjoint[i * columns + result]
        sweep.before[i * columns + result] = 0.0
    for k in range(stops.first_entry[jump], stops.first_entry[jump + 1]):
        adjoint = sweep.adjoint[stops.row[k] * columns + result]
        sweep.before[stops.column[k] * columns + result] += stops.entry[k] * adjoint
    for k in range(stops.first_parameter_entry[jump], stops.first_parameter_entry[jump + 1]):
        adjoint = sweep.adjoint[stops.parameter_row[k] * columns + result]
        to = stops.parameter_column[k] * sweep.results + result
        sweep.by_parameters[to] += stops.parameter_entry[k] * adjoint
    own = stops.instant[jump * (n + p) :]
    for i in range(n):
        place = i * columns + result
        sweep.adjoint[place] = sweep.before[place] + own[i] * weight
    for i in range(p):
        sweep.by_parameters[i * sweep.results + result] += own[n + i] * weight


@kernel
def cross(sweep: Sweep, stops: Stops, step: int) -> None:
    """Carry the adjoint back over the jumps that take the place of a step."""
    i = stops.next_jump
    while i >= 0 and stops.jump_step[i] == step:
        for result in range(sweep.results):
            _cross_one(sweep, stops, i, result)
        i -= 1
    stops.next_jump = i
