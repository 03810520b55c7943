/* States at the start, from parameters and from what was set. */
#include <string.h>
#include "lumped.h"

enum { MOST_ITERATIONS = 50, MOST_POSITIONS = 30 };

#define ROUNDING 1e-10 /* change of a state, relative to its size, that is no jump */

/* Tell the size of all times, s; what happens at once is relative to it. */
void unit_span(Unit *unit, double size)
{
    Run *run = &unit->memory.run;
    run->span = size;
    run->soon = 1e-12 * size;
    run->shortest = 1e-10 * size;
}

void unit_tolerance(Unit *unit, double rtol)
{
    Run *run = &unit->memory.run;
    run->rtol = unit->rtol = rtol;
    for (int i = 0; i < N_STATES; i++) run->atol[i] = fmax(rtol * 1e-3, 1e-12) * state_nominal[i];
}

void unit_reset(Unit *unit)
{
    Run *run = &unit->memory.run;
    memset(unit, 0, sizeof *unit);
    model_bind(&unit->memory);
    memcpy(run->p, parameter_starts, N_PARAMETERS * sizeof(double));
    unit->phase = INSTANTIATED;
    unit_tolerance(unit, DEFAULT_TOLERANCE);
    unit->stop = 1.0;
    run->chooses_method = MAY_CHOOSE;
    run->is_implicit = IS_IMPLICIT;
    run->has_matrix = MAY_CHOOSE || IS_IMPLICIT;
    run->longest = INFINITY;
    run->yielding = -1.0;
    run->pause = INT64_MAX;
    run->max_steps = INT64_MAX;
    run->waits = run->output->is_on_grid = 1;
}

/* Let the loop stand at the point that importers see. */
void unit_enter(Unit *unit)
{
    Run *run = &unit->memory.run;
    run->t = unit->t;
    memcpy(run->x, unit->x, N_STATES * sizeof(double));
    memcpy(run->m, unit->m, N_SETTINGS * sizeof(double));
    unit->pending = GOES_ON;
}

/* Solve matrix * step = right in place by elimination with row pivots. */
bool unit_solve(double *matrix, double *right, int n)
{
    for (int j = 0; j < n; j++) {
        int pivot = j;
        for (int i = j + 1; i < n; i++)
            if (fabs(matrix[i + n * j]) > fabs(matrix[pivot + n * j])) pivot = i;
        if (!(fabs(matrix[pivot + n * j]) > 0)) return false;
        for (int k = 0; k < n; k++) {
            double held = matrix[j + n * k];
            matrix[j + n * k] = matrix[pivot + n * k];
            matrix[pivot + n * k] = held;
        }
        double held = right[j];
        right[j] = right[pivot];
        right[pivot] = held;
        for (int i = j + 1; i < n; i++) {
            double factor = matrix[i + n * j] / matrix[j + n * j];
            for (int k = j; k < n; k++) matrix[i + n * k] -= factor * matrix[j + n * k];
            right[i] -= factor * right[j];
        }
    }
    for (int j = n - 1; j >= 0; j--) {
        for (int k = j + 1; k < n; k++) right[j] -= matrix[j + n * k] * right[k];
        right[j] /= matrix[j + n * j];
    }
    return true;
}

static void used_states(Unit *unit, const double *all)
{
    for (int i = 0; i < N_STATES; i++) unit->x[i] = all[state_place[i]];
}

static bool closed(Unit *unit)
{
    Run *run = &unit->memory.run;
    return kernel_close(run, unit->x, unit->t, unit->m) || unit_fault(unit, NOT_CLOSED);
}

/* Meet start values of quantities that are no states, and initial equations. */
static bool meet_targets(Unit *unit, double *all)
{
    double found[N_TARGETS + N_SOLVED * N_SOLVED + 1], *jacobian = found + N_TARGETS;
    double right[N_SOLVED + 1];
    for (int round = 0; round < MOST_ITERATIONS; round++) {
        double worst = 0.0, moved = 0.0;
        used_states(unit, all);
        if (!closed(unit)) return false;
        model_targets(all, unit->memory.run.p, unit->t, unit->m, found);
        for (int i = 0; i < N_TARGETS; i++)
            worst = isfinite(found[i]) ? fmax(worst, fabs(found[i])) : INFINITY;
        if (worst <= 1e-9) return true; /* relative to what is wanted where that is above one */
        if (!isfinite(worst)) break;
        for (int i = 0; i < N_SOLVED; i++) right[i] = found[solved_row[i]];
        if (!unit_solve(jacobian, right, N_SOLVED)) break;
        for (int i = 0; i < N_SOLVED; i++) {
            double *state = &all[solved_state[i]];
            *state -= right[i];
            moved = fmax(moved, fabs(right[i]) / (1 + fabs(*state)));
        }
        if (moved <= 1e-14 && worst <= 1e-6) return true; /* rounding of terms that cancel */
    }
    return unit_fail(unit, "the start values cannot be met with these parameters");
}

/* Settings of functions of time at the start; all other positions are zero. */
static void timed_modes(Unit *unit)
{
    memset(unit->m, 0, N_MODES * sizeof(double));
    unit_set_clocks(unit, nextafter(unit->t, INFINITY), unit->m);
}

/* Positions of conditions and holds before anything collides; states stay as they are. */
static bool positions(Unit *unit)
{
    Run *run = &unit->memory.run;
    unit_enter(unit);
    int64_t why = kernel_calm_positions(run);
    if (why != GOES_ON) return unit_fault(unit, why);
    memcpy(unit->m, run->instant->m, N_SETTINGS * sizeof(double));
    return true;
}

/* Whether conditions and holds are where they were. */
static bool same_positions(const Unit *unit, const double *before)
{
    const Plant *plant = unit->memory.run.plant;
    for (int i = 0; i < N_MODES; i++)
        if ((unit->m[i] != 0) != (before[i] != 0)) return false;
    for (int k = 0; k < N_CONDITIONS; k++)
        if (unit->m[plant->condition_setting[k]] != before[plant->condition_setting[k]])
            return false;
    return true;
}

/* Meet them in the positions of conditions and holds that follow from it. */
static bool meet_in_positions(Unit *unit, double *all)
{
    double first[N_ALL_STATES + 1], before[N_MODES + 1];
    memcpy(first, all, N_ALL_STATES * sizeof(double));
    used_states(unit, all);
    if (!closed(unit)) return false;
    if (!HAS_SWITCHING) return meet_targets(unit, all);
    if (!positions(unit)) timed_modes(unit);
    for (int round = 0; round < MOST_POSITIONS; round++) {
        memcpy(before, unit->m, N_MODES * sizeof(double));
        if (!meet_targets(unit, all)) {
            memcpy(all, first, N_ALL_STATES * sizeof(double));
            if (!meet_targets(unit, all)) return false;
        }
        used_states(unit, all);
        timed_modes(unit);
        if (!positions(unit)) return false;
        if (same_positions(unit, before)) return true;
    }
    return unit_fail(unit, "the start values cannot hold in the positions of conditions, friction "
                     "and contacts that follow from them");
}

/* Positions at the start, and what collides there; then the loop's first look at them. */
static bool settle(Unit *unit)
{
    Run *run = &unit->memory.run;
    unit_enter(unit);
    if (run->watches) kernel_begin_watch(run);
    if (HAS_SWITCHING) {
        int64_t why = kernel_begin(run);
        if (why != GOES_ON) return unit_fault(unit, why);
        if (run->watches) kernel_note_collisions(run);
        memcpy(run->x, run->instant->x, N_STATES * sizeof(double));
        memcpy(run->m, run->instant->m, N_SETTINGS * sizeof(double));
    }
    unit_span(unit, fmax(fabs(unit->start), fabs(unit->stop)));
    kernel_watch_redundancy(run);
    for (int i = 0; i < N_TIMED; i++) run->timed_values[i] = run->m[run->timed_setting[i]];
    run->segment = 0;
    run->segments = 1;
    run->edges[0] = run->edges[1] = unit->t;
    run->phase = BEGIN_SEGMENT;
    int64_t why = unit_loop(unit);
    if (why != DONE) return unit_fault(unit, why);
    memcpy(unit->x, run->x, N_STATES * sizeof(double));
    memcpy(unit->m, run->m, N_SETTINGS * sizeof(double));
    return true;
}

/* Make states at the start follow from parameters and what was set, if they do not yet. */
bool unit_start(Unit *unit)
{
    Run *run = &unit->memory.run;
    double *all = unit->all;
    if (unit->started) return true;
    const char *fault = bound_fault(run->p);
    if (fault) return unit_fail(unit, "%s", fault);
    unit->t = unit->start;
    unit_span(unit, 1.0);
    timed_modes(unit);
    memcpy(unit->m + N_MODES, implicit_starts, N_IMPLICIT * sizeof(double));
    model_start(NULL, run->p, unit->t, unit->m, all);
    for (int i = 0; i < N_STATES; i++)
        if (unit->is_given[i]) all[state_place[i]] = unit->given[i];
    if (N_TARGETS && !meet_in_positions(unit, all)) return false;
    timed_modes(unit);
    used_states(unit, all);
    if (!settle(unit)) return false;
    unit->struck = false;
    for (int i = 0; i < N_STATES; i++) {
        double moved = fabs(unit->x[i] - all[state_place[i]]);
        unit->struck |= moved > ROUNDING * (fabs(unit->x[i]) + state_nominal[i]);
    }
    unit->inputs_new = unit->is_ahead = false;
    unit->started = unit->settled = true;
    unit_rearm(unit);
    return true;
}
