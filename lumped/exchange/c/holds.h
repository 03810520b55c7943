/* Holds: their modes, what decides these, impacts. */
#ifndef HOLDS_H
#define HOLDS_H

#include "lumped.h"

enum { FREE = -1, STUCK, FORWARD, BACKWARD, COMPLIANCE, DEMAND };

/* All that decides modes at one point. */
typedef struct {
    double greater[N_RELATIONS + 1], less[N_RELATIONS + 1];
    double v[N_HOLDS + 1], a[N_HOLDS + 1], reaction[N_HOLDS + 1], upper[N_HOLDS + 1];
    double lower[N_HOLDS + 1], gap[N_HOLDS + 1], restitution[N_HOLDS + 1];
    double values[N_JUMP_VALUES + 1], rates[N_STATES + 1];
} Look;

void look_with(const Run *run, const double *m, Look *look);
void copy_modes(double *to, const double *from);

bool is(const double *m, int h, int part);
bool acts(const double *m, int h);
void put(double *m, int h, int part);
double standstill(const Run *run, int h);
void stop(Run *run, int h);

void share(Run *run, double *m);
bool collide(Run *run, const Look *look);
void halt(Run *run, const Look *look);

#endif
