"""Whether a step sees what acts by the time alone.

A pulse between the nodes of a step leaves no trace in its stages, and none in its error. So the
parts of the rates that follow the time alone are enclosed over the step before it is made. Where
they may leave what nodes of the step tell of them, the rates are enclosed with the states as they
are, over ever smaller parts; a step in which they stay beyond that, by more than the tolerance, is
shortened.
"""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.kernel.enclosures.enclosure import enclose, select_open
from lumped.kernel.enclosures.models import SIZE, highest, lowest
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import IMPLICIT_NODES, NODES
from lumped.kernel.run import Run

_SHARE = 0.25
"""Part of the span at the nodes by which bounds may be wider."""
_FINEST = 1.0 / 32.0
"""Part of a step that is not divided."""
_SHORTER = 0.25
"""Of a step whose first part is to blame."""
_BRIEFEST = 1e-8
"""Step, relative to the size of all times, that is not shortened: nothing briefer is looked for, as
roots at zero would be without end."""


@kernel
def is_clear(run: Run, h: float, first: float, second: float) -> float:
    """1 if bounds of what follows the time alone are those that nodes of a step tell, else 0."""
    n, low, high, force = run.plant.forcings, run.force_low, run.force_high, run.force
    evaluate(run.plant.forcing, run, run.x, run.t, run.m, force)
    for i in range(n):
        low[i] = high[i] = force[i]
    for j in range(1, 4):
        part = first if j == 1 else second if j == 2 else 1.0
        t = run.t + part * h
        evaluate(run.plant.forcing, run, run.x, t, run.m, force)
        for i in range(n):
            low[i], high[i] = min(low[i], force[i]), max(high[i], force[i])
    # the ends of the step take the place of the states
    run.ranges[0], run.ranges[1] = run.t, run.t + h
    evaluate(run.plant.forcing_range, run, run.ranges, run.t, run.m, run.force_range)
    clear = 1.0 + h * 0.0
    for i in range(n):
        room = _SHARE * (high[i] - low[i]) + run.rtol * max(abs(low[i]), abs(high[i]))
        clear = clear if run.force_range[i] >= low[i] - room else 0.0
        clear = clear if run.force_range[n + i] <= high[i] + room else 0.0
    return clear


@kernel
def _set_rates(run: Run, h: float, first: float, second: float) -> None:
    """Least and greatest rates at the nodes of a step, with the states as they are."""
    n, rates = run.plant.states, run.argument
    for j in range(4):
        part = 0.0 if j == 0 else first if j == 1 else second if j == 2 else 1.0
        t = run.t + part * h
        evaluate(run.plant.rates, run, run.x, t, run.m, rates)
        for i in range(n):
            run.rate_low[i] = min(run.rate_low[i], rates[i]) if j > 0 else rates[i]
            run.rate_high[i] = max(run.rate_high[i], rates[i]) if j > 0 else rates[i]


@kernel
def _is_seen(run: Run, begin: float, width: float, h: float) -> bool:
    """Whether rates in a part of the step are those at its nodes, but for the tolerance."""
    e = run.enclosed_rates
    enclose(run, e, run.plant.rates, begin, width)
    for i in range(run.plant.states):
        model = e.model[SIZE * i :]
        least, most = lowest(model, run.bernstein), highest(model, run.bernstein)
        beyond = max(run.rate_low[i] - least, most - run.rate_high[i])
        beyond -= _SHARE * (run.rate_high[i] - run.rate_low[i])
        if not h * width * beyond <= run.atol[i] + run.rtol * abs(run.x[i]):
            return False
    return True


@kernel
def _first_unseen(run: Run, h: float) -> float:
    """Part of the step at which something begins that its nodes do not tell of; 1 if nothing."""
    begin, width = 0.0, 1.0
    while begin < 1.0:
        if _is_seen(run, begin, width, h):
            begin += width
            # the next part is as long as halving from the whole step makes it
            while width < 1.0 and _is_even(begin / width):
                width *= 2.0
        elif width <= _FINEST:
            return begin
        else:
            width *= 0.5
    return 1.0


@kernel
def _is_even(number: float) -> bool:
    return 2.0 * float(int(0.5 * number)) == number


@kernel
def limit_by_forcing(run: Run, h: float) -> float:
    """A step no longer than a given one in which nothing that acts by the time alone is missed."""
    plant, e = run.plant, run.enclosed_rates
    first, second = NODES[0], NODES[1]
    if run.is_implicit:
        first, second = IMPLICIT_NODES[0], IMPLICIT_NODES[1]
    while h > _BRIEFEST * run.span:
        if is_clear(run, h, first, second) > 0.5:
            break
        run.t_new = run.t + h
        e.is_surveyed = 0
        for i in range(plant.states):
            e.is_open[i] = 1
        select_open(run, e, plant.rates, False)
        _set_rates(run, h, first, second)
        part = _first_unseen(run, h)
        if part >= 1.0:
            break
        h *= max(part, _SHORTER) if part > 0.0 else _SHORTER
    return h
