"""A step by any method: its attempt, its error, and what it gives inside.

Each method is a module beside this one. The time loop calls the functions here and names no method;
only steps that are recorded and carried backwards do. An explicit step may be one of several runs
side by side.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.methods import dop853, rodas5p, taylor
from lumped.kernel.methods.invariants import meet_invariants
from lumped.kernel.run import Run

IMPLICIT_ORDER, NODES = rodas5p.ORDER, dop853.NODES
IMPLICIT_NODES = (rodas5p.NODES[2], rodas5p.NODES[1])
"""Inner nodes of an implicit step at which it has stages, and those of an explicit one."""
LONGER = rodas5p.LONGER
"""Length of an implicit step over that of an explicit one from which it pays."""
_UNKNOWN = 2.0
"""Error of integrals that are not computed."""


@kernel
def prepare(run: Run) -> None:
    """Find what a step needs before its length is chosen; some methods choose the length, too."""
    if run.order > 0 and not run.is_implicit:
        taylor.expand(run)


@kernel
def prepare_step(run: Run) -> float:
    """Prepare explicit steps whose length follows; gives it, or zero where there are none."""
    return taylor.length(run)


@kernel
def attempt_explicit(run: Run, h: float) -> float:
    """States and derivatives at the end of an explicit step; gives their error."""
    return taylor.step(run, h) if run.by_series else dop853.step(run, h)


@kernel
def attempt(run: Run, h: float) -> float:
    """States and derivatives at the end of a step; gives their error."""
    return rodas5p.step(run, h) if run.is_implicit else attempt_explicit(run, h)


@kernel
def explicit_dense_error(run: Run, h: float) -> float:
    """Compute the interpolation in an explicit step; gives its error."""
    if run.by_series:
        return 0.0
    dop853.dense_output(run, h)
    return dop853.dense_error(run, h)


@kernel
def dense_error(run: Run, h: float) -> float:
    """Compute the interpolation in the step; gives its error relative to the tolerance."""
    if run.is_implicit:
        rodas5p.dense_output(run)
        return rodas5p.dense_error(run, h)
    return explicit_dense_error(run, h)


@kernel
def inside_explicit(run: Run, part: float, out: Numbers) -> None:
    """States at a part of an explicit step."""
    if run.by_series:
        taylor.interpolate(run, part, out)
    else:
        dop853.interpolate(run, part, out)


@kernel
def inside(run: Run, part: float, out: Numbers) -> None:
    """States at a part of the step, with invariants as they are there."""
    if run.is_implicit:
        rodas5p.interpolate(run, part, out)
    else:
        inside_explicit(run, part, out)
    if run.plant.invariants > 0:
        meet_invariants(run, out, run.t + part * (run.t_new - run.t))


@kernel
def polynomial(run: Run, i: int) -> int:
    """Coefficients of a state by powers of the part of the step; gives the degree."""
    if run.is_implicit:
        return rodas5p.polynomial(run, i)
    if run.by_series:
        return taylor.polynomial(run, i)
    return dop853.polynomial(run, i)


@kernel
def set_ranges(run: Run) -> None:
    """Ranges of states and time in an explicit step."""
    n = run.plant.states
    if run.by_series:
        taylor.set_ranges(run)
    else:
        dop853.set_ranges(run.x, run.ranges, run.dense, n, 1.0)
    run.ranges[2 * n], run.ranges[2 * n + 1] = run.t, run.t_new


@kernel
def set_all_ranges(run: Run) -> None:
    """Ranges of states and time in a step of any kind."""
    n = run.plant.states
    if run.is_implicit:
        rodas5p.set_ranges(run)
        run.ranges[2 * n], run.ranges[2 * n + 1] = run.t, run.t_new
    else:
        set_ranges(run)


@kernel
def set_rough_ranges(run: Run) -> None:
    """Ranges of states and time in an explicit step before its interpolation is known."""
    n = run.plant.states
    if run.by_series:
        set_ranges(run)
    else:
        dop853.set_rough_ranges(run.x, run.new, run.ranges, run.stages, n, run.t_new - run.t)
        run.ranges[2 * n], run.ranges[2 * n + 1] = run.t, run.t_new


@kernel
def set_early_ranges(run: Run) -> None:
    """Ranges of states and time in a step before its error inside is known."""
    if run.is_implicit:
        rodas5p.dense_output(run)
        set_all_ranges(run)
    else:
        set_rough_ranges(run)


@kernel
def integrals(run: Run, h: float) -> float:
    """Integrals over an explicit step; gives their error relative to the tolerance."""
    if run.by_series:
        if run.row > run.plant.states:
            return taylor.integrals(run, h)
        return _UNKNOWN
    return dop853.integrals_by_stages(run, h)
