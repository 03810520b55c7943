/* Events: margins that are used up, instants that are reached, and what changes then. */
#include <string.h>
#include "lumped.h"

/* Margins at the present point, and their tolerances. */
void unit_margins(const Unit *unit, const double *m, double *margins, double *tolerances)
{
    double found[2 * N_MARGINS + 1];
    model_margin(unit->x, unit->memory.run.p, unit->t, m, found);
    memcpy(margins, found, N_MARGINS * sizeof(double));
    memcpy(tolerances, found + N_MARGINS, N_MARGINS * sizeof(double));
}

/* Note which margins are clear of zero, so that they count as used up when they come back. */
void unit_arm(Unit *unit)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    if (!N_MARGINS) return;
    unit_margins(unit, unit->m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++) unit->armed[i] |= z[i] > 1e3 * tolerances[i];
}

/* Begin anew after an event. What an importer sees starts above zero, so that a margin that rises
   from zero and falls again within its first step is not overlooked. */
void unit_rearm(Unit *unit)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1];
    memset(unit->armed, 0, sizeof unit->armed);
    if (!N_MARGINS) return;
    unit_margins(unit, unit->m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++)
        unit->bias[i] = z[i] > -1e3 * tolerances[i] ? fmax(-z[i], 0.0) : 0.0;
    unit_arm(unit);
}

/* Margins used up at the present point: below zero, or at zero and falling since they were armed. */
void unit_fired(const Unit *unit, bool *fired)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1], slopes[N_MARGINS + 1];
    double soon = unit_early(unit->t);
    if (!N_MARGINS) return;
    unit_margins(unit, unit->m, z, tolerances);
    model_margin_rate(unit->x, unit->memory.run.p, unit->t, unit->m, slopes);
    for (int i = 0; i < N_MARGINS; i++) {
        bool close = z[i] <= fmax(tolerances[i], -slopes[i] * soon);
        fired[i] = z[i] < -tolerances[i] || (unit->armed[i] && slopes[i] < 0 && close);
    }
}

/* Go through what happens just after the start, such as the first sample of a clock. */
bool unit_events_at_start(Unit *unit)
{
    double z[N_MARGINS + 1], tolerances[N_MARGINS + 1], slopes[N_MARGINS + 1];
    bool any = false, fired[N_MARGINS + 1] = {false};
    const Plant *plant = unit->memory.run.plant;
    if (!N_MARGINS) return true;
    unit_margins(unit, unit->m, z, tolerances);
    model_margin_rate(unit->x, unit->memory.run.p, unit->t, unit->m, slopes);
    for (int i = 0; i < N_MARGINS; i++) {
        bool close = fabs(z[i]) <= tolerances[i] && slopes[i] < 0;
        any |= fired[i] = close && plant->margin_kind[i] == CONDITION;
    }
    return !any || unit_change(unit, fired, SAME * unit->memory.run.span);
}

/* How much early an importer may stop at an event: rounding of its clock. */
double unit_early(double t)
{
    return 2e-12 * fmax(1.0, fabs(t));
}

/* Change what changes at the present instant: functions of time, margins that fired, inputs. */
bool unit_change(Unit *unit, const bool *fired, double early)
{
    Run *run = &unit->memory.run;
    InstantSearch *instant = run->instant;
    bool timed = false;
    unit_enter(unit);
    memcpy(instant->before, run->m, N_SETTINGS * sizeof(double));
    unit_set_clocks(unit, run->t + early, run->m);
    for (int i = 0; i < N_TIMED; i++) {
        int64_t place = run->timed_setting[i];
        timed |= run->m[place] != instant->before[place];
    }
    if (timed && kernel_must_jump(run)) return unit_fault(unit, JUMPS);
    if (unit->inputs_new) {
        const char *fault = bound_fault(run->p);
        if (fault) return unit_fail(unit, "%s", fault);
        kernel_watch_redundancy(run);
    }
    instant->fired_count = 0;
    for (int i = 0; i < N_MARGINS; i++)
        if (fired[i]) instant->fired[instant->fired_count++] = i;
    int64_t why = kernel_find_positions(run);
    if (why != GOES_ON) return unit_fault(unit, why);
    memcpy(unit->x, instant->x, N_STATES * sizeof(double));
    memcpy(unit->m, instant->m, N_SETTINGS * sizeof(double));
    unit_rearm(unit);
    unit->inputs_new = unit->is_ahead = false;
    return true;
}
