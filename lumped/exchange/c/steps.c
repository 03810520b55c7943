/* Co-simulation: the loop goes its own steps, at most one ahead of the point that importers see. */
#include <string.h>
#include "lumped.h"

enum { STEPS_IN_RUN = 1000, FOLLOWED = 16, LOOKS = 4000 };

#define NEAR 1e-9 /* distance of times of an importer and the unit, relative to their size */

static void note(Events *events, double t, const int64_t *change)
{
    if (!events || events->count++ >= events->most) return;
    double *row = events->row[events->count - 1];
    row[0] = t;
    row[1] = (double)change[0];
    row[2] = (double)change[1];
    row[3] = (double)change[3];
}

/* Let the loop go on until it returns; notes what changed, and the positions of the point. */
int64_t unit_loop(Unit *unit)
{
    Run *run = &unit->memory.run;
    RunOutput *output = run->output;
    int64_t why = kernel_loop(run);
    for (int64_t i = 0; i < output->changes; i++) {
        const int64_t *change = output->change + 4 * i;
        int32_t which = (int32_t)(change[0] ? N_CONDITIONS + change[1] : change[1]);
        unit->changed[unit->changed_count++ % STORM_SIZE] = which;
        note(unit->events, output->change_time[2 * i], change);
    }
    for (int64_t k = 0; k < output->pieces; k++) /* pieces that began before the last row */
        if (output->piece_row[k] < output->grid_size)
            memcpy(unit->m, output->piece_settings + k * N_MODES, N_MODES * sizeof(double));
    output->changes = output->pieces = 0;
    return why;
}

/* The same, but only to the begin of a piece. */
static int64_t go_to_piece(Unit *unit)
{
    RunOutput *output = unit->memory.run.output;
    int64_t room = output->most_pieces;
    output->most_pieces = 1;
    int64_t why = unit_loop(unit);
    output->most_pieces = room;
    return why;
}

/* Open a segment where the loop stands; it ends where functions of time change, or at the stop. */
static void open(Unit *unit, int64_t phase)
{
    Run *run = &unit->memory.run;
    double m[N_SETTINGS + 1], early = SAME * run->span;
    memcpy(m, run->m, N_SETTINGS * sizeof(double));
    unit_set_clocks(unit, run->t + early, m);
    for (int i = 0; i < N_TIMED; i++) run->timed_values[N_TIMED + i] = m[run->timed_setting[i]];
    for (int k = 0; k < N_CLOCKS && phase == BEGIN_SEGMENT; k++) {
        int64_t was = (int64_t)run->m[clock_setting[k]], now = (int64_t)m[clock_setting[k]];
        if (was != now) note(unit->events, run->t, (int64_t[]){2, k, was, now});
    }
    double instant = unit_next_instant(unit, m, run->t, early);
    unit->is_instant = instant <= unit->stop + early;
    run->end = unit->is_instant && instant < unit->stop - early ? instant : unit->stop;
    run->segment = 1;
    run->segments = 2;
    run->edges[1] = run->t;
    run->edges[2] = run->end;
    run->phase = phase;
}

/* A later stop, if the run goes on beyond it. */
static void extend(Unit *unit, double end)
{
    unit->stop = fmax(end, unit->start + 2 * (unit->stop - unit->start));
    unit_span(unit, fmax(fabs(unit->start), fabs(unit->stop)));
}

/* Begin to step at the point that importers see. */
static void set_out(Unit *unit, double end)
{
    Run *run = &unit->memory.run;
    if (!unit->stop_known) {
        unit->stop = unit->t + STEPS_IN_RUN * (end - unit->t);
        unit->stop_known = true;
        unit_span(unit, fmax(fabs(unit->start), fabs(unit->stop)));
    }
    if (!N_STATES) { /* only functions of time, looked at in short pieces */
        if (N_IMPLICIT) run->longest = (end - unit->t) / FOLLOWED;
        if (N_MARGINS) run->longest = fmin(run->longest, (unit->stop - unit->start) / LOOKS);
    }
    unit_enter(unit);
    open(unit, RESTART);
    unit->is_ahead = true;
}

/* Take the point where the loop stands. */
static void take(Unit *unit)
{
    memcpy(unit->x, unit->memory.run.x, N_STATES * sizeof(double));
    memcpy(unit->m, unit->memory.run.m, N_SETTINGS * sizeof(double));
}

/* Stop before an event. */
static bool halt(Unit *unit, Halt kind, const double *x, const double *m)
{
    memcpy(unit->x, x, N_STATES * sizeof(double));
    memcpy(unit->m, m, N_SETTINGS * sizeof(double));
    unit->t = unit->memory.run.t;
    unit->halted = kind;
    return true;
}

/* Go on to a time; if the unit stops at events, not beyond the first one after the present time. An
   event just beyond the end is one at the end, so the loop is sent a little further then. */
static bool reach(Unit *unit, double end, Stops stops, bool *event)
{
    Run *run = &unit->memory.run;
    RunOutput *output = run->output;
    if (run->phase == BEGIN_SEGMENT) { /* the last step ended at the stop */
        extend(unit, end);
        open(unit, RESTART);
    }
    double same = SAME * run->span, begin = unit->t + same;
    /* where it sets out is wanted too, as it is in a run that begins there */
    int64_t point = run->phase == RESTART && run->t == unit->t;
    output->grid[0] = unit->t;
    output->grid[point] = end;
    output->grid[point + 1] = end + same;
    output->grid_next = output->rows = 0;
    output->grid_size = point + 1 + (stops != THROUGH && end != unit->stop);
    run->max_steps = run->steps + run->rejected + MOST_STEPS;
    memcpy(unit->m, run->m, N_MODES * sizeof(double));
    for (;;) {
        int64_t why = stops == THROUGH ? unit_loop(unit) : go_to_piece(unit);
        if (stops != THROUGH && run->t > begin && output->rows < output->grid_size) {
            bool crossed = why == FULL && run->phase == RESTART;
            bool is_at_end = fabs(run->t - end) <= same;
            *event = (crossed || (why == DONE && unit->is_instant))
                     && (is_at_end || stops == EVERYWHERE);
            if (*event && crossed) halt(unit, CROSSED, run->inner, run->instant->before);
            else if (*event) halt(unit, DUE, run->x, run->m);
            if (*event && is_at_end) unit->t = end;
            if (*event) return true;
        }
        if (output->rows == output->grid_size) {
            int64_t last = point;
            const double *implicit = output->implicit + last * N_IMPLICIT;
            memcpy(unit->x, output->x + last * N_STATES, N_STATES * sizeof(double));
            memcpy(unit->m + N_MODES, implicit, N_IMPLICIT * sizeof(double));
            return true;
        }
        if (why == FULL) continue;
        if (why == DONE && unit->is_instant) {
            open(unit, BEGIN_SEGMENT);
        } else if (why == DONE && end > unit->stop) {
            extend(unit, end);
            open(unit, RESTART);
        } else if (why == DONE) {
            take(unit);
            return true;
        } else if (run->t == end) { /* only what follows cannot be done */
            unit->pending = why;
            take(unit);
            return true;
        } else {
            return unit_fault(unit, why);
        }
    }
}

/* Go through an event at which a step stopped; the point is that after it. */
static bool pass(Unit *unit)
{
    if (unit->halted == DUE) {
        open(unit, BEGIN_SEGMENT);
        int64_t why = go_to_piece(unit);
        if (why != FULL) return unit_fault(unit, why);
    }
    take(unit);
    unit->halted = NOWHERE;
    return true;
}

/* Go through what else happens at the same instant. */
static bool pass_others(Unit *unit)
{
    Run *run = &unit->memory.run;
    RunOutput *output = run->output;
    double late = unit->t + SAME * run->span;
    while (late < unit->stop) {
        output->grid[0] = late;
        output->grid_next = output->rows = 0;
        output->grid_size = 1;
        int64_t why = go_to_piece(unit);
        if (output->rows) break;
        if (why == FULL && run->phase == RESTART) unit->halted = CROSSED;
        else if (why == DONE) unit->halted = DUE;
        else if (why != FULL) unit->pending = why; /* only what follows cannot be done */
        if (unit->pending != GOES_ON) break;
        if (unit->halted != NOWHERE && !pass(unit)) return false;
    }
    return true;
}

/* Go through the event at which a step stopped, with the inputs of that instant. */
static bool pass_with_inputs(Unit *unit)
{
    const InstantSearch *instant = unit->memory.run.instant;
    bool fired[N_MARGINS + 1] = {false};
    unit_fired(unit, fired);
    if (unit->halted == CROSSED)
        for (int64_t i = 0; i < instant->fired_count; i++) fired[instant->fired[i]] = true;
    unit->halted = NOWHERE;
    return unit_change(unit, fired, SAME * unit->memory.run.span);
}

/* Go through the event at which a step stopped, and heed inputs; whether states jumped. */
bool unit_resume(Unit *unit, bool *moved)
{
    double x[N_STATES + 1];
    memcpy(x, unit->x, sizeof x);
    bool well = true;
    if (unit->inputs_new) well = pass_with_inputs(unit);
    else if (unit->halted != NOWHERE) well = pass(unit) && pass_others(unit);
    *moved = memcmp(x, unit->x, N_STATES * sizeof(double)) != 0;
    return well;
}

static bool advance(Unit *unit, double end, Stops stops, bool *event)
{
    bool moved;
    if ((unit->halted != NOWHERE || unit->inputs_new) && !unit_resume(unit, &moved)) return false;
    if (end <= unit->t) return true;
    if (!unit->is_ahead) set_out(unit, end);
    if (unit->pending != GOES_ON) return unit_fault(unit, unit->pending);
    if (fabs(end - unit->stop) <= SAME * unit->memory.run.span) end = unit->stop;
    if (!reach(unit, end, stops, event)) return false;
    if (unit->halted == NOWHERE) unit->t = end;
    unit_arm(unit);
    return true;
}

/* Advance to a time, through all events on the way. */
bool unit_advance(Unit *unit, double end)
{
    return advance(unit, end, THROUGH, NULL);
}

/* Make a step of an importer, or only up to an event at which the unit stops. */
bool unit_step(Unit *unit, double t, double length, Stops stops, bool *event)
{
    if (!unit_start(unit)) return false;
    if (!(length > 0) || !isfinite(t + length))
        return unit_fail(unit, "a step of %g s from t = %.9g s: it must be longer than 0, and finite",
                         length, t);
    if (!(fabs(t - unit->t) <= NEAR * fmax(unit->memory.run.span, fabs(t))))
        return unit_fail(unit, "a step cannot begin at t = %.9g s, as the last one ended at %.9g s; "
                         "to repeat a step, keep a state and set it back", t, unit->t);
    return advance(unit, t + length, stops, event);
}
