/* Conditions and pieces of tables: what they say, how they change, and when functions of time do. */
#include <string.h>
#include "lumped.h"

static void enter(double *mode, int first, int width, int piece)
{
    memcpy(mode, piece_rows + first + piece * width, (size_t)width * sizeof(double));
}

/* The last of a table's pieces that begins at or before a place; the first has no begin. */
static int piece_at(int first, int width, int count, double place)
{
    int low = 0, high = count;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (piece_rows[first + middle * width + 1] <= place) low = middle;
        else high = middle;
    }
    return low;
}

/* Whether a condition does not say what its sides say, which differ by `run_of`. */
bool outside(const Run *run, int k, double run_of, double slack)
{
    const double *m = run->m + relation_mode[k];
    if (relation_count[k]) return m[2] + run_of * (m[3] + m[4] * run_of) < -slack;
    return m[0] > 0.5 ? run_of < -slack : run_of > slack;
}

/* Change a condition: to its contrary, or to the next piece. */
void turn(Run *run, int k, double run_of)
{
    double *m = run->m + relation_mode[k];
    int piece = (int)m[0];
    if (!relation_count[k]) {
        m[0] = 1.0 - m[0];
        return;
    }
    piece += m[3] < 0 || m[4] * run_of < -0.5 ? 1 : -1;
    if (piece < 0) piece = 0;
    if (piece > relation_count[k] - 1) piece = relation_count[k] - 1;
    enter(m, relation_first[k], relation_width[k], piece);
}

/* Set a condition by its sides; equal sides do not hold. */
void look_up(Run *run, int k, double greater, double less, double slack)
{
    double *m = run->m + relation_mode[k];
    if (!relation_count[k]) m[0] = greater - less > slack;
    else enter(m, relation_first[k], relation_width[k],
               piece_at(relation_first[k], relation_width[k], relation_count[k], greater));
}

/* Where a piece of a function of time begins; pieces of a period are counted on. */
static double begin_of(int k, double number)
{
    double cycle = floor(number / clock_count[k]);
    int piece = (int)(number - cycle * clock_count[k]);
    double begin = piece_rows[clock_first[k] + piece * clock_width[k] + 1];
    return clock_period[k] > 0 ? begin + cycle * clock_period[k] : begin;
}

static void set_clock(Run *run, int k, double place)
{
    double *m = run->m + clock_mode[k], cycle = 0.0;
    int first = clock_first[k], count = clock_count[k], piece;
    if (!count) {
        m[0] = clock_strict[k] ? place > 0 : place >= 0;
        return;
    }
    if (clock_period[k] > 0) cycle = floor((place - piece_rows[first + 1]) / clock_period[k]);
    piece = piece_at(first, clock_width[k], count, place - cycle * clock_period[k]);
    enter(m, first, clock_width[k], piece);
    m[0] = cycle * count + piece;
    m[1] = begin_of(k, m[0]);
}

/* Modes of functions of time, as they are from a little later on. */
void set_clocks(Run *run, double later)
{
    double zero = 0.0, place[N_CLOCKS + 1], slope[N_CLOCKS + 1];
    for (int round = 0; round < CLOCK_LEVELS; round++) { /* one may need others */
        model_clocks(&zero, run->p, run->m, place, slope);
        for (int k = 0; k < N_CLOCKS; k++) set_clock(run, k, place[k] + slope[k] * later);
    }
}

/* The next instant at which a function of time changes. */
double next_instant(const Run *run, double early)
{
    double zero = 0.0, place[N_CLOCKS + 1], slope[N_CLOCKS + 1], next = INFINITY;
    if (!N_CLOCKS) return next;
    model_clocks(&zero, run->p, run->m, place, slope);
    for (int k = 0; k < N_CLOCKS; k++) {
        double border = 0.0, number = run->m[clock_mode[k]] + (slope[k] > 0);
        bool ends = clock_count[k] && !(clock_period[k] > 0);
        if (slope[k] == 0.0 || (ends && (number < 1 || number > clock_count[k] - 1))) continue;
        if (clock_count[k]) border = begin_of(k, number);
        double instant = (border - place[k]) / slope[k];
        if (instant > run->t + early) next = fmin(next, instant);
    }
    return next;
}
