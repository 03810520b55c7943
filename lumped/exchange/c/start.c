/* States at the start, from parameters and from what was set. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "lumped.h"

enum { MOST_ITERATIONS = 50, MOST_CLOSING = 20, MOST_POSITIONS = 30 };

bool fail(Run *run, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int count = snprintf(run->message, sizeof run->message, "%s: ", model_name);
    vsnprintf(run->message + count, sizeof run->message - (size_t)count, format, arguments);
    va_end(arguments);
    for (char *c = run->message; *c; c++) /* loggers take it for a format */
        if (*c == '%') *c = ' ';
    return false;
}

void reset(Run *run)
{
    memset(run, 0, sizeof *run);
    memcpy(run->p, parameter_starts, N_PARAMETERS * sizeof(double));
    run->span = 1.0;
    run->rtol = DEFAULT_TOLERANCE;
    run->phase = INSTANTIATED;
}

/* Quantities of closed linkages in m, by Newton's method from where they are. */
bool close_guesses(Run *run, const double *x, double t, double *m)
{
    double step[N_GUESSES + 1], *guess = m + N_MODES;
    if (!N_GUESSES) return true;
    for (int round = 0; round < MOST_CLOSING; round++) {
        double found[N_GUESSES + 1], size = 0.0, last = 0.0;
        model_closure(x, run->p, &t, m, found, step);
        for (int i = 0; i < N_GUESSES; i++) {
            guess[i] = found[i];
            size = fmax(size, fabs(found[i]));
            last = isfinite(found[i]) ? fmax(last, fabs(step[i])) : INFINITY;
        }
        if (last <= 1e-12 * (1 + size)) return true;
        if (!isfinite(last)) break;
    }
    return fail(run, "a closed linkage cannot be closed at t = %.9g s; check its lengths, and take "
                "shorter steps", t);
}

/* Solve matrix * step = right in place by elimination with row pivots. */
static bool solve(double *matrix, double *right, int n)
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

static void used_states(const double *all, double *x)
{
    for (int i = 0; i < N_STATES; i++) x[i] = all[state_place[i]];
}

/* Meet start values of quantities that are no states, and initial equations. */
static bool meet_targets(Run *run, double *all)
{
    double miss[N_TARGETS + 1], jacobian[N_SOLVED * N_SOLVED + 1], right[N_SOLVED + 1];
    double x[N_STATES + 1], time = run->t;
    for (int round = 0; round < MOST_ITERATIONS; round++) {
        double worst = 0.0, moved = 0.0;
        used_states(all, x);
        if (!close_guesses(run, x, run->t, run->m)) return false;
        model_targets(all, run->p, &time, run->m, miss, jacobian);
        for (int i = 0; i < N_TARGETS; i++)
            worst = isfinite(miss[i]) ? fmax(worst, fabs(miss[i])) : INFINITY;
        if (worst <= 1e-9) return true; /* relative to what is wanted where that is above one */
        if (!isfinite(worst)) break;
        for (int i = 0; i < N_SOLVED; i++) right[i] = miss[solved_row[i]];
        if (!solve(jacobian, right, N_SOLVED)) break;
        for (int i = 0; i < N_SOLVED; i++) {
            double *state = &all[solved_state[i]];
            *state -= right[i];
            moved = fmax(moved, fabs(right[i]) / (1 + fabs(*state)));
        }
        if (moved <= 1e-14 && worst <= 1e-6) return true; /* rounding of terms that cancel */
    }
    return fail(run, "the start values cannot be met with these parameters");
}

/* Modes of functions of time at the start; all others are zero. */
static void timed_modes(Run *run)
{
    memset(run->m, 0, N_MODES * sizeof(double));
    set_clocks(run, nextafter(run->t, INFINITY));
}

/* Whether conditions and holds are where they were. */
static bool same_positions(const double *now, const double *before)
{
    for (int i = 0; i < N_MODES; i++)
        if ((now[i] != 0) != (before[i] != 0)) return false;
    for (int k = 0; k < N_RELATIONS; k++)
        if (now[relation_mode[k]] != before[relation_mode[k]]) return false;
    return true;
}

/* Meet them in the positions of conditions and holds that follow from it. */
static bool meet_in_positions(Run *run, double *all)
{
    double first[N_ALL_STATES + 1], before[N_MODES + 1];
    memcpy(first, all, N_ALL_STATES * sizeof(double));
    used_states(all, run->x);
    if (!close_guesses(run, run->x, run->t, run->m)) return false;
    if (!HAS_SWITCHING) return meet_targets(run, all);
    if (!positions(run)) timed_modes(run);
    for (int round = 0; round < MOST_POSITIONS; round++) {
        memcpy(before, run->m, N_MODES * sizeof(double));
        if (!meet_targets(run, all)) {
            memcpy(all, first, N_ALL_STATES * sizeof(double));
            if (!meet_targets(run, all)) return false;
        }
        used_states(all, run->x);
        timed_modes(run);
        if (!positions(run)) return false;
        if (same_positions(run->m, before)) return true;
    }
    return fail(run, "the start values cannot hold in the positions of conditions, friction and "
                "contacts that follow from them");
}

/* Make states at the start follow from parameters and what was set, if they do not yet. */
bool ensure_started(Run *run)
{
    double all[N_ALL_STATES + 1];
    if (run->started) return true;
    const char *fault = bound_fault(run->p);
    if (fault) return fail(run, "%s", fault);
    run->t = run->start;
    run->yielding = run->independent = -1;
    timed_modes(run);
    memcpy(run->m + N_MODES, guess_starts, N_GUESSES * sizeof(double));
    model_start(run->p, all);
    for (int i = 0; i < N_STATES; i++)
        if (run->is_given[i]) all[state_place[i]] = run->given[i];
    if (N_TARGETS && !meet_in_positions(run, all)) return false;
    timed_modes(run);
    used_states(all, run->x);
    if (!close_guesses(run, run->x, run->t, run->m)) return false;
    if (HAS_SWITCHING && !settle_start(run)) return false;
    if (!close_guesses(run, run->x, run->t, run->m)) return false;
    run->next_step = 0.0;
    run->inputs_new = false;
    run->started = run->settled = true;
    rearm(run);
    return true;
}
