"""Points inside recorded steps at which a quantity may be highest, or turns.

Quantities are enclosed as while a run goes on, so that nothing between two looks is missed.
"""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.kernel.enclosures.extremes import raise_all, rises
from lumped.kernel.enclosures.turning import feed_inner
from lumped.kernel.methods.any_method import set_all_ranges
from lumped.kernel.recorded_steps.course import Course, interpolate_step
from lumped.kernel.run import DONE, GIVEN_UP, Run


@kernel
def list_points(run: Run, course: Course) -> int:
    """List points inside all steps, as the watch of the run asks for."""
    watch = run.watch
    watch.listed = 0
    for k in range(course.steps):
        if course.is_step[k]:
            if not interpolate_step(run, course, k):
                return GIVEN_UP
            watch.place = k
            # settings of steps differ
            watch.enclosed_extremes.is_surveyed = watch.enclosed_loads.is_surveyed = 0
            if watch.extremes > 0:
                set_all_ranges(run)
                if rises(run) > 0.5:
                    raise_all(run, 0, run.t, run.t_new)
            if watch.loads > 0:
                feed_inner(run, 1.0)
    return DONE
