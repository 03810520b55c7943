/* What both versions of the interface share: values by their references, events. */
#include <string.h>
#include "lumped.h"

/* Modes and quantities of linkages at the present states. */
static bool closed_at(Run *run, double *m)
{
    memcpy(m, run->m, sizeof run->m);
    if (!close_guesses(run, run->x, run->t, m)) return false;
    memcpy(run->m + N_MODES, m + N_MODES, N_GUESSES * sizeof(double));
    return true;
}

bool rates_of(Run *run, double *rates)
{
    double m[N_MODES + N_GUESSES + 1];
    if (!ensure_started(run) || !closed_at(run, m)) return false;
    model_rates(run->x, run->p, &run->t, m, rates);
    return true;
}

bool get_values(Run *run, const uint32_t *references, size_t count, double *values)
{
    double m[N_MODES + N_GUESSES + 1], rates[N_STATES + 1], outputs[N_OUTPUTS + 1];
    double z[N_MARGINS + 1];
    bool rates_known = false, outputs_known = false, z_known = false;
    if (!ensure_started(run) || !closed_at(run, m)) return false;
    for (size_t k = 0; k < count; k++) {
        int r = (int)references[k];
        if (references[k] >= END_OF_VALUES)
            return fail(run, "no variable has the value reference %u", references[k]);
        if (r >= FIRST_INDICATOR) {
            if (!z_known) indicators(run, run->x, run->t, m, z);
            z_known = true;
            values[k] = z[r - FIRST_INDICATOR];
        } else if (r >= FIRST_OUTPUT) {
            if (!outputs_known) model_outputs(run->x, run->p, &run->t, m, outputs);
            outputs_known = true;
            values[k] = outputs[r - FIRST_OUTPUT];
        } else if (r >= FIRST_RATE) {
            if (!rates_known) model_rates(run->x, run->p, &run->t, m, rates);
            rates_known = true;
            values[k] = rates[r - FIRST_RATE];
        } else if (r >= FIRST_STATE) {
            values[k] = run->x[r - FIRST_STATE];
        } else {
            values[k] = r ? run->p[r - FIRST_PARAMETER] : run->t;
        }
    }
    return true;
}

/* Parameters and inputs; states only before the run. */
bool set_values(Run *run, const uint32_t *references, size_t count, const double *values)
{
    bool before = run->phase == INSTANTIATED || run->phase == INITIALIZING;
    for (size_t k = 0; k < count; k++) {
        int r = (int)references[k];
        if (references[k] >= FIRST_PARAMETER && references[k] < FIRST_STATE) {
            int i = r - FIRST_PARAMETER;
            if (run->p[i] == values[k]) continue;
            if (parameter_fault(i, values[k]))
                return fail(run, "%s = %g is out of range: it %s", parameter_names[i], values[k],
                            parameter_fault(i, values[k]));
            if (!before && !parameter_tunable[i])
                return fail(run, "%s is fixed and can be set before the run only",
                            parameter_names[i]);
            run->p[i] = values[k];
            run->inputs_new = true;
            if (before) run->started = false;
        } else if (before && references[k] >= FIRST_STATE && references[k] < FIRST_RATE
                   && state_settable[r - FIRST_STATE]) {
            run->given[r - FIRST_STATE] = values[k];
            run->is_given[r - FIRST_STATE] = true;
            run->started = false;
        } else {
            return fail(run, "the variable with value reference %d cannot be set now", r);
        }
    }
    return true;
}

/* What an importer tells about the run. */
void experiment(Run *run, bool tolerance_defined, double tolerance, double start, bool stop_defined,
                double stop)
{
    run->start = run->t = start;
    if (tolerance_defined && tolerance > 0) run->rtol = tolerance;
    if (stop_defined && stop > start) run->span = stop - start;
    run->started = false;
}

/* Handle the events of an instant, once; whether states jumped, and the next instant. */
bool update(Run *run, bool *moved, double *next)
{
    double x[N_STATES + 1];
    bool fired[N_MARGINS + 1] = {false}, well = true;
    memcpy(x, run->x, sizeof x);
    if (!run->settled || run->inputs_new) {
        fired_now(run, fired);
        well = change(run, fired, early_by(run->t));
        run->settled = true;
    }
    *moved = memcmp(x, run->x, N_STATES * sizeof(double)) != 0;
    *next = next_instant(run, early_by(run->t));
    return well;
}

/* A step of the importer is accepted; whether it must handle an event. */
bool step_completed(Run *run, bool *event)
{
    double z[N_MARGINS + 1];
    *event = false;
    if (!fit_to_lead(run) || !watch(run, z)) return false;
    for (int i = 0; i < N_MARGINS; i++) *event |= z[i] < 0;
    return true;
}

/* Event indicators, and margins that are clear of zero noted. */
bool watch(Run *run, double *z)
{
    double m[N_MODES + N_GUESSES + 1];
    if (!ensure_started(run) || !closed_at(run, m)) return false;
    indicators(run, run->x, run->t, m, z);
    for (int i = 0; i < N_MARGINS; i++) {
        z[i] += run->bias[i];
        /* bodies that meet nearly where they met before lose no height from bounce to bounce */
        if (margin_kind[i] == SLIDE && hold_has_gap[margin_number[i]]) z[i] -= 0.99 * CONTACT;
    }
    arm(run);
    return true;
}
