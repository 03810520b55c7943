/* A model with its state: what the parts of the interface share.

   loop.c is the time loop of lumped, the same in all units, with its records (Run, Plant, ...).
   model.c, made for one model, gives sizes, tables and functions. A margin is negative as soon as
   a condition or hold must change its position. */
#ifndef LUMPED_H
#define LUMPED_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "model.h"

#define SAME 1e-13 /* distance of instants that are one, relative to the size of all times */

enum { MOST_STEPS = 10000000 }; /* of the loop from one communication point to the next */

/* Value references: time, parameters and inputs, states, their derivatives, outputs, indicators. */
enum {
    FIRST_PARAMETER = 1,
    FIRST_STATE = FIRST_PARAMETER + N_PARAMETERS,
    FIRST_RATE = FIRST_STATE + N_STATES,
    FIRST_OUTPUT = FIRST_RATE + N_STATES,
    FIRST_INDICATOR = FIRST_OUTPUT + N_OUTPUTS,
    END_OF_VALUES = FIRST_INDICATOR + N_MARGINS
};

/* States, parameters and the time, by which there are derivatives; rates, outputs and indicators of
   which. */
enum { N_KNOWNS = N_STATES + N_PARAMETERS + 1, N_UNKNOWNS = END_OF_VALUES - FIRST_RATE };

/* PAUSED: in the event mode of co-simulation. TERMINATED: after an error too. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    EVENTS = 4,
    CONTINUOUS = 8,
    STEPPING = 16,
    PAUSED = 32,
    TERMINATED = 64,
    RUNNING = EVENTS | CONTINUOUS | STEPPING | PAUSED,
    EVALUATED = INITIALIZING | RUNNING | TERMINATED
} Phase;

/* An event inside a step at which co-simulation stopped; the point is that before it. The loop has
   gone through the event, or it has to open the segment that begins there. */
typedef enum { NOWHERE, CROSSED, DUE } Halt;

/* At which events co-simulation stops: none, those at communication points, all. */
typedef enum { THROUGH, AT_POINTS, EVERYWHERE } Stops;

/* What happened: how much, and of the first ones the instant, kind (0 condition, 1 hold, 2 function
   of time), number and position after. */
typedef struct {
    int count, most;
    double (*row)[4];
} Events;

/* Everything that a run changes. A saved state is a copy; `model_bind` lets it point to itself. */
typedef struct {
    Phase phase;
    double start, stop, rtol;
    bool stop_known;
    /* the point that importers see: time, states, positions and implicit quantities */
    double t, x[N_STATES + 1], m[N_SETTINGS + 1];
    double given[N_STATES + 1]; /* start values set from outside */
    bool is_given[N_STATES + 1];
    double all[N_ALL_STATES + 1]; /* states at the start, also those that are not used */
    bool struck;                  /* what collides at the start moved them */
    bool started;    /* states follow from the parameters as they are */
    bool inputs_new; /* parameters or inputs were set since positions were found */
    bool settled;    /* events of this instant were handled */
    bool armed[N_MARGINS + 1];  /* margins that were positive since positions were found */
    double bias[N_MARGINS + 1]; /* rounding below zero of margins when they were found */
    /* co-simulation: the loop is ahead of the point, whether functions of time change at the end of
       its segment, and why it could not go on from the point */
    bool is_ahead, is_instant;
    Halt halted;
    int64_t pending;
    int32_t changed[STORM_SIZE]; /* what changed last: holds after conditions */
    int64_t changed_count;
    Events *events; /* where to note them, if anywhere */
    char message[2000];
    bool refused; /* the message is about a call that changed nothing, so the run can go on */
    Memory memory; /* of the loop, with the parameters */
} Unit;

/* faults.c: words for what went wrong; all give false */
bool unit_fail(Unit *unit, const char *format, ...);
bool unit_refuse(Unit *unit, const char *format, ...);
bool unit_fault(Unit *unit, int64_t why);
bool unit_allowed(Unit *unit, int phases, const char *name);
bool unit_sized(Unit *unit, size_t count, size_t wanted);

/* clocks.c: functions of time */
void unit_set_clocks(const Unit *unit, double later, double *m);
double unit_next_instant(const Unit *unit, const double *m, double t, double early);

/* start.c */
void unit_reset(Unit *unit);
void unit_span(Unit *unit, double size);
void unit_enter(Unit *unit);
void unit_tolerance(Unit *unit, double rtol);
bool unit_solve(double *matrix, double *right, int n);
bool unit_start(Unit *unit);

/* events.c */
bool unit_change(Unit *unit, const bool *fired, double early);
bool unit_events_at_start(Unit *unit);
void unit_arm(Unit *unit);
void unit_rearm(Unit *unit);
void unit_fired(const Unit *unit, bool *fired);
void unit_margins(const Unit *unit, const double *m, double *margins, double *tolerances);
double unit_early(double t);

/* steps.c */
bool unit_advance(Unit *unit, double end);
bool unit_step(Unit *unit, double t, double length, Stops stops, bool *event);
bool unit_resume(Unit *unit, bool *moved);
int64_t unit_loop(Unit *unit);

/* access.c */
void unit_experiment(Unit *unit, bool tolerance_defined, double tolerance, double start,
                     bool stop_defined, double stop);
bool unit_update(Unit *unit, bool *moved, double *next);
bool unit_step_completed(Unit *unit, bool *event);
bool unit_watch(Unit *unit, double *z);
bool unit_get(Unit *unit, const uint32_t *references, size_t count, double *values);
bool unit_set(Unit *unit, const uint32_t *references, size_t count, const double *values);
bool unit_close(Unit *unit, double *m);
bool unit_rates(Unit *unit, double *rates);
void unit_copy(const Unit *from, Unit *to);

/* saved.c: states kept by importers */
bool unit_keep(Unit *unit, void **state);
bool unit_take_up(Unit *unit, void *state);
void unit_drop(void **state);
size_t unit_size(void);
bool unit_write(Unit *unit, const void *state, void *bytes, size_t size);
bool unit_read(Unit *unit, const void *bytes, size_t size, void **state);

/* derivatives.c, adjoint.c */
int unit_known(Unit *unit, uint32_t reference);
int unit_unknown(Unit *unit, uint32_t reference);
bool unit_linear(Unit *unit, double *m, double *p);
void unit_start_matrix(Unit *unit, const double *m, double *matrix);
bool unit_forward(Unit *unit, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                  size_t knowns, const double *seed, double *sensitivity);
bool unit_reverse(Unit *unit, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                  size_t knowns, const double *seed, double *sensitivity);

#endif
