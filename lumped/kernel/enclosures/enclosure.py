"""What a quantity does over a part of a step, from its own operations.

States are polynomials of the part of the step in all methods. The operations that a quantity needs
are carried out on Taylor models (see `models`), so one that is linear in the states is exact.
"""

from __future__ import annotations

import math

import casadi as ca

from lumped.code.operations import PARAMETER, RESULT, SETTING, STATE, TIME
from lumped.code.words import Integers, Numbers, kernel
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.enclosures import models
from lumped.kernel.enclosures.model_operations import ROOM, carry_out
from lumped.kernel.enclosures.models import DEGREE, REST, SIZE, TOP
from lumped.kernel.interpret import operate
from lumped.kernel.methods.any_method import polynomial
from lumped.kernel.plant import Function
from lumped.kernel.run import Run


@kernel
def _survey(run: Run, e: Enclosed, function: Function, rows: Integers, count: int) -> None:
    """Note which of some operations give what moves in the present positions, and other values."""
    w, moves, operations = e.models, e.needed, function.operations
    for j in range(count - 1, -1, -1):
        i = rows[j]
        row = operations[4 * i :]
        op, to, a, b = row[0], row[1], row[2], row[3]
        if op == RESULT:
            e.moves[i] = 1
            continue
        if e.moves[i] < 0:
            moving, value = 0, 0.0
            if op == TIME or (op == STATE and not e.is_still):
                moving = 1
            elif op == STATE:
                value = run.x[a]
            elif op == PARAMETER:
                value = run.p[a]
            elif op == SETTING:
                value = run.m[a]
            elif op == ca.OP_CONST:
                value = function.constants[a]
            elif moves[a] + moves[b] == 0:
                value = operate(op, w[a], w[b])
            else:
                is_product = op == ca.OP_MUL or op == ca.OP_IF_ELSE_ZERO
                is_off = is_product and moves[a] == 0 and w[a] == 0.0
                is_off = is_off or (op == ca.OP_MUL and moves[b] == 0 and w[b] == 0.0)
                moving = 0 if is_off else 1
            e.moves[i], e.fixed[i] = moving, value
        w[to], moves[to] = e.fixed[i], e.moves[i]
    for j in range(count):
        row = operations[4 * rows[j] :]
        if row[0] != RESULT:
            moves[row[1]] = 0


@kernel
def select(run: Run, e: Enclosed, function: Function, k: int) -> None:
    """Find the operations that a result of a function needs, the last first, or find them again.

    What does not move in the present positions needs none.
    """
    if e.row_begin[k] < 0 and e.open_count == 1:
        # they are those of all that are open
        e.row_begin[k], e.row_number[k] = e.row_begin[e.results], e.row_number[e.results]
    if e.row_begin[k] < 0:
        _collect(run, e, function, k)
    e.row_first, e.row_count = e.row_begin[k], e.row_number[k]


@kernel
def begin_survey(e: Enclosed, function: Function) -> None:
    """Nothing is known of operations in the present positions, unless it is already."""
    if not e.is_surveyed:
        for i in range(function.count):
            e.moves[i] = -1
        _forget(e)
        e.is_surveyed = 1


@kernel
def select_open(run: Run, e: Enclosed, function: Function, is_same: bool) -> None:
    """Find the operations of all results that are open, unless the same ones were open before."""
    n = e.results
    begin_survey(e, function)
    if not is_same or e.row_begin[n] < 0:
        e.open_count = 0
        for k in range(n):
            e.open_count += e.is_open[k]
        _collect(run, e, function, n)
    e.row_first, e.row_count = e.row_begin[n], e.row_number[n]


@kernel
def _forget(e: Enclosed) -> None:
    """No operations are selected."""
    for k in range(e.results + 1):
        e.row_begin[k] = -1
    e.row_next = 0


@kernel
def _note_needs(e: Enclosed, row: Integers, moves: int) -> None:
    """Note what an operation needs that is needed itself."""
    op, needed = row[0], e.needed
    if op == RESULT:
        needed[row[2]] = 1
        return
    needed[row[1]] = 0
    is_given = op == STATE or op == PARAMETER or op == SETTING or op == TIME or op == ca.OP_CONST
    if moves != 0 and not is_given:
        needed[row[2]] = needed[row[3]] = 1


@kernel
def _collect(run: Run, e: Enclosed, function: Function, k: int) -> None:
    """Note the operations that a result needs; of all that are open for the number beyond them."""
    n, needed, operations = e.results, e.needed, function.operations
    if e.row_next > 3 * function.count:
        _forget(e)
    rows, found, is_known = e.rows[e.row_next :], 0, True
    for i in range(function.count - 1, -1, -1):
        row = operations[4 * i :]
        to = row[1]
        if row[0] == RESULT:
            is_used = to < n and (to == k or (k == n and e.is_open[to] != 0))
        else:
            is_used = needed[to] != 0
        if is_used:
            _note_needs(e, row, e.moves[i])
            is_known = is_known and e.moves[i] >= 0
            rows[found] = i
            found += 1
    count = found
    if not is_known:
        _survey(run, e, function, rows, found)
        count = 0
        for j in range(found):
            i = rows[j]
            row = operations[4 * i :]
            if row[0] == RESULT or needed[row[1]] != 0:
                _note_needs(e, row, e.moves[i])
                rows[count] = i
                count += 1
    e.row_begin[k], e.row_number[k] = e.row_next, count
    e.row_next += count


@kernel
def _state(run: Run, i: int, begin: float, width: float, out: Numbers) -> None:
    """The model of a state over a part of the step."""
    q, last = run.powers, polynomial(run, i)
    half, size = 0.5 * width, 1.0
    middle = begin + half
    for k in range(last):
        for j in range(last - 1, k - 1, -1):
            q[j] += middle * q[j + 1]
    rest = 0.0
    for j in range(last + 1):
        if j <= TOP:
            out[j] = q[j] * size
        else:
            rest += abs(q[j] * size)
        size = size * half
    out[REST], out[DEGREE] = rest, float(min(last, TOP))


@kernel
def set_ranges_in(run: Run, begin: float, width: float) -> None:
    """Ranges of states and time in a part of the step."""
    n, model, length = run.plant.states, run.part_model, run.t_new - run.t
    for i in range(n):
        _state(run, i, begin, width, model)
        run.ranges[i] = models.lowest(model, run.bernstein)
        run.ranges[n + i] = models.highest(model, run.bernstein)
    run.ranges[2 * n] = run.t + begin * length
    run.ranges[2 * n + 1] = run.t + (begin + width) * length


@kernel
def enclose(run: Run, e: Enclosed, function: Function, begin: float, width: float) -> None:
    """The models of the selected results of a function over a part of the step, in `model`."""
    w, length, operations = e.models, run.t_new - run.t, function.operations
    out = w[0:]
    room, work = w[SIZE:], w[SIZE * ROOM :]
    rows = e.rows[e.row_first :]
    for i in range(e.row_count - 1, -1, -1):
        row = operations[4 * rows[i] :]
        op, to, a, b = row[0], row[1], row[2], row[3]
        if e.moves[rows[i]] == 0:
            models.set_fixed(work[SIZE * to :], e.fixed[rows[i]])
        elif op == STATE:
            _state(run, a, begin, width, work[SIZE * to :])
        elif op == TIME:
            time = work[SIZE * to :]
            models.set_fixed(time, run.t + (begin + 0.5 * width) * length)
            time[1], time[DEGREE] = 0.5 * width * length, 1.0
        elif op == RESULT:
            models.copy(work[SIZE * a :], e.model[SIZE * to :])
        else:
            first, second, made = work[SIZE * a :], work[SIZE * b :], work[SIZE * to :]
            if to == a or to == b:
                carry_out(op, first, second, out, room)
                models.copy(out, made)
            else:
                carry_out(op, first, second, made, room)


@kernel
def value_at(e: Enclosed, function: Function, x: Numbers, t: float) -> float:
    """The selected result of a function at a point, with the bits of the whole function."""
    w, operations, rows = e.models, function.operations, e.rows[e.row_first :]
    for i in range(e.row_count - 1, -1, -1):
        row = operations[4 * rows[i] :]
        op, to, a, b = row[0], row[1], row[2], row[3]
        if e.moves[rows[i]] == 0:
            w[to] = e.fixed[rows[i]]
        elif op == STATE:
            w[to] = x[a]
        elif op == TIME:
            w[to] = t
        elif op == RESULT:
            return w[a]
        else:
            w[to] = operate(op, w[a], w[b])
    return math.nan
