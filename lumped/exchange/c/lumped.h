/* A model with its state: what the parts of the runtime share.

   model.h, made for one model, gives sizes, tables and functions. Conditions, holds and jumps are
   those of lumped: a condition has one mode, a hold five (stuck, forward, backward, compliance,
   demanded acceleration). A margin is negative as soon as a mode must change. */
#ifndef LUMPED_H
#define LUMPED_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "model.h"

#define CONTACT 1e-13 /* gap of bodies that touch */

/* Value references: time, parameters and inputs, states, their derivatives, outputs, indicators. */
enum {
    FIRST_PARAMETER = 1,
    FIRST_STATE = FIRST_PARAMETER + N_PARAMETERS,
    FIRST_RATE = FIRST_STATE + N_STATES,
    FIRST_OUTPUT = FIRST_RATE + N_STATES,
    FIRST_INDICATOR = FIRST_OUTPUT + N_OUTPUTS,
    END_OF_VALUES = FIRST_INDICATOR + N_MARGINS
};

typedef enum { INSTANTIATED, INITIALIZING, EVENTS, CONTINUOUS, STEPPING, TERMINATED } Phase;

/* Everything that a run changes; no pointers, so a copy is a saved state. */
typedef struct {
    Phase phase;
    double t, start, span, rtol;
    double x[N_STATES + 1], p[N_PARAMETERS + 1];
    double m[N_MODES + N_GUESSES + 1]; /* modes, then implicit quantities */
    double given[N_STATES + 1];        /* start values set from outside */
    bool is_given[N_STATES + 1];
    bool started;     /* states follow from the parameters as they are */
    bool inputs_new;  /* parameters or inputs were set since the last settling */
    bool settled;     /* events of this instant were handled */
    bool armed[N_MARGINS + 1];  /* margins that were positive since the last settling */
    double bias[N_MARGINS + 1]; /* rounding below zero of margins at the last settling */
    /* while modes settle */
    bool was_stuck[N_HOLDS + 1], halted[N_HOLDS + 1], moved;
    bool calm;        /* nothing collides: only positions are asked for */
    double yielding;  /* compliance of redundant holds, negative if not known */
    int independent;  /* whether all holds are, negative if not known */
    double next_step; /* that the integrator would make, zero if not known */
    char message[800];
} Run;

/* start.c */
bool fail(Run *run, const char *format, ...);
void reset(Run *run);
bool ensure_started(Run *run);
bool close_guesses(Run *run, const double *x, double t, double *m);

/* pieces.c */
bool outside(const Run *run, int k, double run_of, double slack);
void turn(Run *run, int k, double run_of);
void look_up(Run *run, int k, double greater, double less, double slack);
void set_clocks(Run *run, double later);
double next_instant(const Run *run, double early);

/* settle.c: false with a message if no modes fit */
bool settle_start(Run *run);
bool positions(Run *run);
bool settle(Run *run, const double *before, const bool *fired);

/* events.c */
bool change(Run *run, const bool *fired, double early);
void arm(Run *run);
void rearm(Run *run);
void fired_now(Run *run, bool *fired);
void indicators(const Run *run, const double *x, double t, const double *m, double *z);
double early_by(double t);
bool fit_to_lead(Run *run);

/* integrate.c */
bool advance(Run *run, double end);

/* access.c */
void experiment(Run *run, bool tolerance_defined, double tolerance, double start, bool stop_defined,
                double stop);
bool update(Run *run, bool *moved, double *next);
bool step_completed(Run *run, bool *event);
bool watch(Run *run, double *z);
bool get_values(Run *run, const uint32_t *references, size_t count, double *values);
bool set_values(Run *run, const uint32_t *references, size_t count, const double *values);
bool rates_of(Run *run, double *rates);


/* functions that the shared library shows */
#if defined(_WIN32)
#define SHOWN __declspec(dllexport)
#elif defined(__GNUC__)
#define SHOWN __attribute__((visibility("default")))
#else
#define SHOWN
#endif
#define FMI2 SHOWN
#define FMI3 SHOWN

#endif
