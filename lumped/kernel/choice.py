"""Explicit or implicit steps, chosen while a run goes on.

Petzold (SIAM Journal on Scientific and Statistical Computing 4 (1983) 136) and LSODA compare the
lengths of the steps that both methods could make; those of explicit steps end where stability does.
Explicit steps tell by two of their stages how far that is (Hairer and Wanner, vol. II, IV.2), but
at rest and in vibrations they are wrong. So they only say when to look at the fastest eigenvalue of
the Jacobian; implicit steps always have it. It says which steps are worth a trial, and the error of
that trial decides.

The eigenvalue is found by power iteration, as Sommeijer, Shampine and Verwer do without a Jacobian
(Journal of Computational and Applied Mathematics 88 (1998) 315): one vector is carried from step to
step, so two products in each are enough. A pair of complex eigenvalues turns it for ever; so three
vectors in a row are fitted by a quadratic equation, whose larger root tells the size.
"""

from __future__ import annotations

import math

from lumped.code.words import Numbers, kernel, largest_of, sqrt
from lumped.kernel.enclosures.forcing import limit_by_forcing
from lumped.kernel.methods.any_method import IMPLICIT_ORDER, LONGER, dense_error, prepare
from lumped.kernel.methods.rates import find_slopes
from lumped.kernel.output import note_turn
from lumped.kernel.run import Run
from lumped.kernel.step_error import SAFETY, is_dense_wanted, is_finite, try_step

NEAR_LIMIT = 2.5
"""Step times eigenvalue above which stability may limit an explicit step; DOP853 is unstable from
6.1 on (Hairer's code)."""
_CALM, _STABLE = 1.0, 5.0
"""The same up to which stability surely limits no explicit step, as by tight tolerances it may from
1.5 on; and up to which these steps are stable, at their end and inside."""
STIFF_AFTER, _SOFT_AFTER = 4, 10
"""Steps in a row that speak for the other method, explicit and implicit ones, before its trial."""
FIRST_PATIENCE, _MOST_PATIENCE, UNTRIED = 8, 256, 500
"""Steps from a failed trial to the next, at first and at most; most steps without any trial."""
_GAIN = 2.25
"""How many times longer than an implicit step the trial of an explicit one is. With 2 the crank
shear comes back too early, with 2.5 vibrations at 1e-4 stay implicit."""
_MUCH = 1.5
"""How many times longer than where a trial failed a step is much longer."""
_SAFE = SAFETY**IMPLICIT_ORDER
"""Error of an implicit step after which the next is no shorter."""
_ROUNDS = 8
"""Rounds of two products with which the iteration begins."""
_GOLDEN = 0.6180339887498949
"""Multiples of it, without their whole parts, are spread evenly."""
_PARALLEL = 1e-13
"""Square of the sine between vectors that rounding alone tells apart."""


@kernel
def note_stiffness(run: Run) -> None:
    """Count the steps in a row that seem near the limit of stability."""
    run.stiff_steps = run.stiff_steps + 1 if run.stiffness > NEAR_LIMIT else 0
    run.patience = max(0, run.patience - 1)
    run.untried_steps += 1


@kernel
def note_softness(run: Run) -> None:
    """Count the implicit steps in a row in whose place longer explicit ones would be stable."""
    _set_fastest(run)
    run.soft_steps = run.soft_steps + 1 if _GAIN * run.h * run.fastest <= _STABLE else 0
    run.patience = max(0, run.patience - 1)


@kernel
def is_trial_due(run: Run, h: float) -> bool:
    """Whether a step by the other method should be tried.

    At rest, rounding hides the limit of stability of explicit steps, so a trial is due after many
    of them in any case. It is also due as soon as steps are much longer than where trials failed.
    """
    if not run.chooses_method:
        return False
    if run.is_implicit:
        return run.soft_steps >= _SOFT_AFTER and run.patience == 0 and run.end - run.t > _GAIN * h
    if run.end - run.t <= LONGER * h:
        return False
    if run.untried_steps >= UNTRIED:
        return True
    is_over = run.patience == 0 or h > run.long_enough
    return run.stiff_steps >= STIFF_AFTER and is_over


@kernel
def _is_accurate(run: Run, h: float) -> bool:
    """Whether a step of the present method is accurate and misses nothing that acts by the time."""
    if run.plant.forcings > 0 and limit_by_forcing(run, h) < h:
        return False
    prepare(run)
    run.t_new = run.t + h
    error = try_step(run, h)
    if run.is_implicit:
        return error <= _SAFE and is_finite(run)
    if not (error <= 1.0 and is_finite(run)):
        return False
    return not is_dense_wanted(run) or dense_error(run, h) <= 1.0


@kernel
def _is_explicit_better(run: Run, h: float) -> bool:
    """Whether a longer explicit step is accurate."""
    run.is_implicit = 0
    return _is_accurate(run, _GAIN * h)


@kernel
def _is_implicit_better(run: Run, h: float) -> bool:
    """Whether stability may limit explicit steps, and one of three times the length is accurate."""
    find_slopes(run)
    _begin_fastest(run)
    run.long_enough = max(run.long_enough, max(_MUCH * h, _CALM / max(run.fastest, 1e-300)))
    if h * run.fastest <= _CALM:
        return False
    run.is_implicit = 1
    return _is_accurate(run, LONGER * h)


@kernel
def choose_method(run: Run, h: float) -> float:
    """Turn to the other method if a step of it is better; gives the length of the next step.

    If not, the next trial waits twice as long.
    """
    was_implicit = run.is_implicit
    pays = _is_explicit_better(run, h) if was_implicit else _is_implicit_better(run, h)
    run.stiff_steps = run.soft_steps = run.untried_steps = 0
    if pays:
        note_turn(run)
        run.patience, run.next_patience, run.long_enough = 0, FIRST_PATIENCE, 0.0
    else:
        run.is_implicit = was_implicit
        run.patience = run.next_patience
        run.next_patience = min(2 * run.next_patience, _MOST_PATIENCE)
    if run.is_implicit:
        run.by_series = 0
    if not pays:
        return h
    return _GAIN * h if was_implicit else LONGER * h


@kernel
def _begin_fastest(run: Run) -> None:
    """Estimate the size anew, from a vector that has something of every motion."""
    for i in range(run.plant.states):
        part = _GOLDEN * float(i + 1)
        run.fast[i] = run.atol[i] * (part - float(int(part)) - 0.5)
    for _ in range(_ROUNDS):
        _go_on(run)


@kernel
def _set_fastest(run: Run) -> None:
    """Follow the size to the Jacobian of the present step."""
    if largest_of(run.plant.states, run.fast) > 0.0:
        _go_on(run)
    else:
        _begin_fastest(run)


@kernel
def _product(run: Run, v: Numbers, out: Numbers) -> None:
    """The Jacobian times a vector."""
    matrix, pattern = run.matrix, run.matrix.pattern
    for i in range(run.plant.states):
        out[i] = 0.0
    for e in range(pattern.nonzeros):
        out[pattern.row[e]] += matrix.slopes[e] * v[pattern.column[e]]


@kernel
def _go_on(run: Run) -> None:
    """Two products more; where nothing is left of the vector, all eigenvalues are zero."""
    n, v, once, twice = run.plant.states, run.fast, run.matrix.right, run.matrix.size
    _product(run, v, once)
    _product(run, once, twice)
    s00 = s01 = s11 = s02 = s12 = s22 = 0.0
    for i in range(n):
        weight = 1.0 / run.atol[i]
        a, b, c = v[i] * weight, once[i] * weight, twice[i] * weight
        s00 += a * a
        s01 += a * b
        s11 += b * b
        s02 += a * c
        s12 += b * c
        s22 += c * c
    size = sqrt(s22)
    is_left = size > 0.0 and size < math.inf
    for i in range(n):
        v[i] = twice[i] / size if is_left else 0.0
    if not is_left:
        run.fastest = 0.0 if size == 0.0 else math.inf
        return
    area = s00 * s11 - s01 * s01
    if area <= _PARALLEL * s00 * s11:
        run.fastest = sqrt(s22 / s11)
        return
    # the second vector is nearly -p times the first less q times the one before
    p, q = (s01 * s02 - s00 * s12) / area, (s01 * s12 - s11 * s02) / area
    bend = p * p - 4.0 * q
    run.fastest = sqrt(q) if bend < 0.0 else 0.5 * (abs(p) + sqrt(bend))
