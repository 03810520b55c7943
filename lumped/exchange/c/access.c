/* What both versions of the interface share: values by their references, events, saved states. */
#include <string.h>
#include "lumped.h"

/* What goes wrong at a point is told; where an importer searches or integrates, it may try another. */
static bool tried(Unit *unit, bool well)
{
    unit->refused |= !well && (unit->phase & (INSTANTIATED | INITIALIZING | CONTINUOUS));
    return well;
}

/* Settings at the present states, after the start: quantities of linkages follow the states. */
bool unit_close(Unit *unit, double *m)
{
    if (!tried(unit, unit_start(unit))) return false;
    memcpy(m, unit->m, N_SETTINGS * sizeof(double));
    if (!kernel_close(&unit->memory.run, unit->x, unit->t, m)) {
        unit->memory.run.t = unit->t;
        return tried(unit, unit_fault(unit, NOT_CLOSED));
    }
    memcpy(unit->m + N_MODES, m + N_MODES, N_IMPLICIT * sizeof(double));
    return true;
}

bool unit_rates(Unit *unit, double *rates)
{
    double m[N_SETTINGS + 1];
    if (!unit_close(unit, m)) return false;
    model_rates(unit->x, unit->memory.run.p, unit->t, m, rates);
    for (int i = 0; i < N_STATES; i++) {
        if (isfinite(rates[i])) continue;
        unit_enter(unit);
        return tried(unit, unit_fault(unit, NOT_FINITE));
    }
    return true;
}

/* Margins with their tolerances: negative where a position must change. */
static void indicators(const Unit *unit, const double *m, double *z)
{
    double tolerances[N_MARGINS + 1];
    unit_margins(unit, m, z, tolerances);
    for (int i = 0; i < N_MARGINS; i++) z[i] += tolerances[i];
}

bool unit_get(Unit *unit, const uint32_t *references, size_t count, double *values)
{
    double m[N_SETTINGS + 1], rates[N_STATES + 1], outputs[N_OUTPUTS + 1];
    double z[N_MARGINS + 1];
    bool rates_known = false, outputs_known = false, z_known = false;
    bool evaluates = false;
    for (size_t k = 0; k < count; k++) {
        if (references[k] >= END_OF_VALUES)
            return unit_fail(unit, "no variable has the value reference %lu",
                             (unsigned long)references[k]);
        evaluates |= references[k] >= FIRST_STATE;
    }
    if (evaluates && !unit_close(unit, m)) return false;
    for (size_t k = 0; k < count; k++) {
        int r = (int)references[k];
        if (r >= FIRST_INDICATOR) {
            if (!z_known) indicators(unit, m, z);
            z_known = true;
            values[k] = z[r - FIRST_INDICATOR];
        } else if (r >= FIRST_OUTPUT) {
            if (!outputs_known) model_outputs(unit->x, unit->memory.run.p, unit->t, m, outputs);
            outputs_known = true;
            values[k] = outputs[r - FIRST_OUTPUT];
        } else if (r >= FIRST_RATE) {
            if (!rates_known) model_rates(unit->x, unit->memory.run.p, unit->t, m, rates);
            rates_known = true;
            values[k] = rates[r - FIRST_RATE];
        } else if (r >= FIRST_STATE) {
            values[k] = unit->x[r - FIRST_STATE];
        } else {
            values[k] = r ? unit->memory.run.p[r - FIRST_PARAMETER] : unit->t;
        }
    }
    return true;
}

/* Whether a variable can be set to a value now. */
static bool settable(Unit *unit, uint32_t reference, double value)
{
    bool before = unit->phase == INSTANTIATED || unit->phase == INITIALIZING;
    if (reference >= FIRST_PARAMETER && reference < FIRST_STATE) {
        int i = (int)reference - FIRST_PARAMETER;
        if (unit->memory.run.p[i] == value) return true;
        const char *fault = parameter_fault(i, value);
        if (fault)
            return unit_refuse(unit, "%s = %g is out of range: it %s", parameter_names[i], value,
                               fault);
        return before || parameter_tunable[i]
               || unit_fail(unit, "%s is fixed and can be set before the run only",
                            parameter_names[i]);
    }
    if (reference >= FIRST_STATE && reference < FIRST_RATE) {
        int i = (int)reference - FIRST_STATE;
        if ((before && state_settable[i]) || unit->phase == CONTINUOUS)
            return isfinite(value)
                   || unit_refuse(unit, "%s = %g is no finite number", state_names[i], value);
    }
    return unit_fail(unit, "the variable with value reference %lu cannot be set now",
                     (unsigned long)reference);
}

/* Parameters and inputs; states before the run, and where the importer integrates. Either all are
   set or none. */
bool unit_set(Unit *unit, const uint32_t *references, size_t count, const double *values)
{
    bool before = unit->phase == INSTANTIATED || unit->phase == INITIALIZING;
    for (size_t k = 0; k < count; k++)
        if (!settable(unit, references[k], values[k])) return false;
    for (size_t k = 0; k < count; k++) {
        int parameter = (int)references[k] - FIRST_PARAMETER, i = (int)references[k] - FIRST_STATE;
        if (i < 0 && unit->memory.run.p[parameter] == values[k]) continue;
        if (i < 0) {
            unit->memory.run.p[parameter] = values[k];
            unit->inputs_new = true;
        } else if (before) {
            unit->given[i] = values[k];
            unit->is_given[i] = true;
        } else {
            unit->x[i] = values[k];
        }
        if (before) unit->started = false;
    }
    return true;
}

/* What an importer tells about the run. */
void unit_experiment(Unit *unit, bool tolerance_defined, double tolerance, double start, bool stop_defined,
                double stop)
{
    unit->start = unit->t = start;
    if (tolerance_defined && tolerance > 0) unit_tolerance(unit, fmax(tolerance, 1e-13));
    unit->stop_known = stop_defined && stop > start;
    unit->stop = unit->stop_known ? stop : start + 1.0;
    unit->started = false;
}

/* Handle the events of an instant, once; whether states jumped, and the next instant. */
bool unit_update(Unit *unit, bool *moved, double *next)
{
    double x[N_STATES + 1];
    bool fired[N_MARGINS + 1] = {false}, well = true;
    memcpy(x, unit->x, sizeof x);
    if (!unit->settled || unit->inputs_new) {
        unit_fired(unit, fired);
        well = unit_change(unit, fired, unit_early(unit->t));
        unit->settled = true;
    }
    *moved = memcmp(x, unit->x, N_STATES * sizeof(double)) != 0;
    *next = unit_next_instant(unit, unit->m, unit->t, unit_early(unit->t));
    return well;
}

/* A step of the importer is accepted; whether it must handle an event. */
bool unit_step_completed(Unit *unit, bool *event)
{
    double z[N_MARGINS + 1];
    *event = false;
    Run *run = &unit->memory.run;
    run->t = unit->t;
    memcpy(run->x, unit->x, N_STATES * sizeof(double));
    memcpy(run->m, unit->m, N_SETTINGS * sizeof(double));
    if (kernel_is_unfit(run)) return unit_fault(unit, UNFIT);
    if (!unit_watch(unit, z)) return false;
    for (int i = 0; i < N_MARGINS; i++) *event |= z[i] < 0;
    return true;
}

/* Event indicators, and margins that are clear of zero noted. */
bool unit_watch(Unit *unit, double *z)
{
    const Plant *plant = unit->memory.run.plant;
    double m[N_SETTINGS + 1];
    if (!unit_close(unit, m)) return false;
    indicators(unit, m, z);
    for (int i = 0; i < N_MARGINS; i++) {
        z[i] += unit->bias[i];
        /* bodies that meet nearly where they met before lose no height from bounce to bounce */
        if (plant->margin_kind[i] == SLIDE && plant->has_gap[plant->margin_number[i]]) z[i] -= 0.99 * CONTACT;
    }
    unit_arm(unit);
    return true;
}

/* Save a state, or take it up again. */
void unit_copy(const Unit *from, Unit *to)
{
    memcpy(to, from, sizeof *to);
    model_bind(&to->memory);
}
