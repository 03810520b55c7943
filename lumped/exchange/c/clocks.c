/* Functions of time: a unit does not know all their instants before a run, only the next one. */
#include <string.h>
#include "lumped.h"

/* The last of a table's pieces that begins at or before a place; the first has no begin. */
static int piece_at(int k, double place)
{
    int low = 0, high = clock_count[k];
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (clock_rows[clock_first[k] + middle * clock_width[k] + 1] <= place) low = middle;
        else high = middle;
    }
    return low;
}

/* Where a piece begins; pieces of a period are counted on. */
static double begin_of(int k, double number)
{
    double cycle = floor(number / clock_count[k]);
    int piece = (int)(number - cycle * clock_count[k]);
    double begin = clock_rows[clock_first[k] + piece * clock_width[k] + 1];
    return clock_period[k] > 0 ? begin + cycle * clock_period[k] : begin;
}

static void set_clock(int k, double place, double *m)
{
    double *own = m + clock_setting[k], number;
    int width = clock_width[k], count = clock_count[k];
    if (!count) {
        own[0] = clock_strict[k] ? place > 0 : place >= 0;
        return;
    }
    if (clock_period[k] > 0) {
        double cycle = floor((place - clock_rows[clock_first[k] + 1]) / clock_period[k]);
        number = cycle * count + piece_at(k, place - cycle * clock_period[k]);
        number += place >= begin_of(k, number + 1); /* rounding may name the neighbour */
        number -= place < begin_of(k, number);
    } else {
        number = piece_at(k, place);
    }
    int piece = (int)(number - floor(number / count) * count);
    memcpy(own, clock_rows + clock_first[k] + piece * width, (size_t)width * sizeof(double));
    own[0] = number;
    own[1] = begin_of(k, number);
}

/* Places of all functions of time at the time zero, and their slopes. */
static void courses(const Unit *unit, const double *m, double *found)
{
    model_clocks(unit->x, unit->memory.run.p, 0.0, m, found);
}

/* Settings of functions of time, as they are at a time. */
void unit_set_clocks(const Unit *unit, double later, double *m)
{
    double found[2 * N_CLOCKS + 1], *slope = found + N_CLOCKS;
    for (int round = 0; round < CLOCK_LEVELS; round++) { /* one may need others */
        courses(unit, m, found);
        for (int k = 0; k < N_CLOCKS; k++) set_clock(k, found[k] + slope[k] * later, m);
    }
}

/* The next instant at which a function of time changes. */
double unit_next_instant(const Unit *unit, const double *m, double t, double early)
{
    double found[2 * N_CLOCKS + 1], *slope = found + N_CLOCKS, next = INFINITY;
    if (!N_CLOCKS) return next;
    courses(unit, m, found);
    for (int k = 0; k < N_CLOCKS; k++) {
        double border = 0.0, number = m[clock_setting[k]] + (slope[k] > 0);
        bool ends = clock_count[k] && !(clock_period[k] > 0);
        if (slope[k] == 0.0 || (ends && (number < 1 || number > clock_count[k] - 1))) continue;
        if (clock_count[k]) border = begin_of(k, number);
        double instant = (border - found[k]) / slope[k];
        if (instant > t + early) next = fmin(next, instant);
    }
    return next;
}
