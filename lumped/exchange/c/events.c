/* Events: margins that are used up, instants that are reached, and what changes then. */
#include <string.h>
#include "lumped.h"

static const double MOST_LEVERAGE = 1e3;
/* ratio of a dependent motion to the state that leads it from which on the state is unfit */

/* Margins with their tolerances: negative where a mode must change. */
void indicators(const Run *run, const double *x, double t, const double *m, double *z)
{
    double tolerances[N_MARGINS + 1];
    model_margins(x, run->p, &t, m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++) z[i] += tolerances[i];
}

/* Note which margins are clear of zero, so that they count as used up when they come back. */
void arm(Run *run)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    if (!N_MARGINS) return;
    model_margins(run->x, run->p, &run->t, run->m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++) run->armed[i] |= z[i] > 1e3 * tolerances[i];
}

/* Begin anew after an event. What an importer sees starts above zero, so that a margin that rises
   from zero and falls again within its first step is not overlooked. */
void rearm(Run *run)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    memset(run->armed, 0, sizeof run->armed);
    if (!N_MARGINS) return;
    model_margins(run->x, run->p, &run->t, run->m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++)
        run->bias[i] = z[i] > -1e3 * tolerances[i] ? fmax(-z[i], 0.0) : 0.0;
    arm(run);
}

/* Margins used up at the present point: below zero, or at zero and falling since they were armed. */
void fired_now(Run *run, bool *fired)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1], slopes[N_MARGINS + 1];
    if (!N_MARGINS) return;
    model_margins(run->x, run->p, &run->t, run->m, z, tolerances);
    model_margin_rates(run->x, run->p, &run->t, run->m, slopes);
    double soon = early_by(run->t);
    for (int i = 0; i < N_MARGINS; i++) {
        bool close = z[i] <= fmax(tolerances[i], -slopes[i] * soon);
        fired[i] = z[i] < -tolerances[i] || (run->armed[i] && slopes[i] < 0 && close);
    }
}

/* How much early an importer may stop at an event: rounding of its clock. */
double early_by(double t)
{
    return 2e-12 * fmax(1.0, fabs(t));
}

/* Refuse positions and speeds that bodies would have to follow at a jump. */
static bool followed(Run *run, const double *before)
{
    double old[N_FOLLOWERS + 1], new[N_FOLLOWERS + 1];
    if (!N_FOLLOWERS) return true;
    model_followers(run->x, run->p, &run->t, before, old);
    model_followers(run->x, run->p, &run->t, run->m, new);
    for (int i = 0; i < N_FOLLOWERS; i++)
        if (fabs(new[i] - old[i]) > 1e-9 * fmax(1.0, fabs(old[i])))
            return fail(run, "%s would have to jump from %g to %g at t = %g s, because a prescribed "
                        "motion jumps or has a kink there", follower_names[i], old[i], new[i],
                        run->t);
    return true;
}

/* Change what changes at the present instant: functions of time, modes that fired, inputs. */
bool change(Run *run, const bool *fired, double early)
{
    double before[N_MODES + N_GUESSES + 1];
    bool timed = false;
    memcpy(before, run->m, sizeof before);
    if (run->inputs_new) {
        const char *fault = bound_fault(run->p);
        if (fault) return fail(run, "%s", fault);
        run->yielding = run->independent = -1;
    }
    set_clocks(run, run->t + early);
    for (int k = 0; k < N_CLOCKS; k++) timed |= run->m[clock_mode[k]] != before[clock_mode[k]];
    if (timed && !followed(run, before)) return false;
    if (!close_guesses(run, run->x, run->t, run->m)) return false;
    if (HAS_SWITCHING && !settle(run, before, fired)) return false;
    if (!close_guesses(run, run->x, run->t, run->m)) return false;
    rearm(run);
    run->inputs_new = false;
    run->next_step = 0.0;
    return true;
}

/* Refuse to go on where a state hardly leads what depends on it, as near a dead centre. */
bool fit_to_lead(Run *run)
{
    double ratios[N_LEVERS + 1];
    if (!N_LEVERS) return true;
    model_levers(run->x, run->p, &run->t, run->m, ratios);
    for (int i = 0; i < N_LEVERS; i++)
        if (!(fabs(ratios[i]) <= MOST_LEVERAGE))
            return fail(run, "at t = %.9g s %s; this exchange format cannot change states, so the "
                        "run ends here", run->t, lever_names[i]);
    return true;
}
