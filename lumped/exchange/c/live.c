/* A run of a page in a browser: parameters in, curves, functionals and events out. */
#include "lumped.h"
#include "shown.h"

#define EXPORT(name) __attribute__((export_name(#name)))

enum { MOST_EVENTS = 1000, COLUMNS = 1 + N_SHOWN };

static Unit unit;
static double rows[N_ROWS * COLUMNS], taken[N_TAKEN + 1], noted[MOST_EVENTS][4];
static double found[N_SHOWN + 1];
static Events events;

EXPORT(parameters) double *parameters(void) { return unit.memory.run.p; }
EXPORT(rows) double *live_rows(void) { return rows; }
EXPORT(taken) double *live_taken(void) { return taken; }
EXPORT(noted) double *live_noted(void) { return &noted[0][0]; }
EXPORT(event_count) int event_count(void) { return events.count; }
EXPORT(noted_count) int noted_count(void) { return events.count < events.most ? events.count : events.most; }
EXPORT(message) const char *message(void) { return unit.message; }
EXPORT(reached) double reached(void) { return unit.t; }

/* Before parameters are set. */
EXPORT(reset) void reset(void)
{
    unit_reset(&unit);
    events = (Events){0, MOST_EVENTS, noted};
    unit.events = &events;
}

EXPORT(set) int set(int parameter, double value)
{
    uint32_t reference = (uint32_t)(FIRST_PARAMETER + parameter);
    return unit_set(&unit, &reference, 1, &value);
}

static bool record(double *row)
{
    row[0] = unit.t;
    if (!unit_get(&unit, shown_references, N_SHOWN, found)) return false;
    for (int i = 0; i < N_SHOWN; i++) row[1 + i] = found[i];
    return true;
}

/* Make the run; gives the number of rows that were reached, all of them if it is whole. */
EXPORT(run) int run(double begin, double end)
{
    int k = 0, intervals = N_ROWS - 1;
    unit_experiment(&unit, false, 0.0, begin, true, end);
    unit.phase = INITIALIZING;
    if (!unit_start(&unit)) return 0;
    unit.phase = STEPPING;
    if (!record(rows)) return 0;
    for (k = 1; k <= intervals; k++) {
        double t = k == intervals ? end : begin + k * ((end - begin) / intervals);
        if (!unit_advance(&unit, t) || !record(rows + k * COLUMNS)) return k;
    }
    kernel_take(&unit.memory.run, taken);
    return k;
}
