/* The search for modes that fit at one instant: conditions, jumps of states, holds, impacts. */
#include <stdlib.h>
#include <string.h>
#include "holds.h"

static const double EXCESS = 1e-10;   /* relative excess of a limit that is still rounding */
static const double EQUAL = 1e-12;    /* relative difference of sides that count as equal */
static const double INSIDE_BY = 1e-9; /* how deep bodies may start inside each other */
enum { PATIENCE = 6 };                /* rounds in which all wrong modes change although they
                                         have not become fewer */

/* Which wrong modes change: all while that helps, then the first alone until there are fewer than
   ever (Judice and Pires, Computers and Operations Research 21 (1994) 587; Murty's rule). */
typedef struct {
    int fewest, left;
} Wrong;

static int to_change(Wrong *wrong, int count)
{
    if (count < wrong->fewest) {
        wrong->fewest = count;
        wrong->left = PATIENCE;
    } else if (wrong->left) {
        wrong->left--;
    } else {
        return 1;
    }
    return count;
}

/* Change what an event says changes. */
static void flip(Run *run, const bool *fired, bool *exempt)
{
    Look look;
    bool seen = false;
    for (int i = 0; i < N_MARGINS; i++) {
        int n = margin_number[i];
        if (!fired[i]) continue;
        switch (margin_kind[i]) {
        case RELATION:
            if (!seen && relation_count[n]) look_with(run, run->m, &look);
            seen |= relation_count[n] > 0;
            turn(run, n, seen ? look.greater[n] - look.less[n] : 0.0);
            exempt[n] = true;
            break;
        case SLIDE:
            run->halted[n] = true;
            if (!hold_has_gap[n]) put(run->m, n, STUCK);
            break;
        default:
            put(run->m, n, margin_kind[i] == UPPER ? FORWARD : BACKWARD);
        }
    }
}

static double slack_of(const Look *look, int k)
{
    return EQUAL * (fabs(look->greater[k]) + fabs(look->less[k])) + 1e-13;
}

/* Turn conditions round that do not say what their sides say. */
static bool relations(Run *run, const Look *look, bool *exempt, Wrong *patience)
{
    int wrong[N_RELATIONS + 1], count = 0;
    for (int k = 0; k < N_RELATIONS; k++) {
        double g = look->greater[k] - look->less[k], slack = slack_of(look, k);
        bool on = run->m[relation_mode[k]] > 0.5;
        bool equal = g == 0.0 && on == relation_strict[k] && !exempt[k] && !relation_count[k];
        if (outside(run, k, g, slack) || equal) wrong[count++] = k;
        if (equal) exempt[k] = true;
    }
    if (!count) return false;
    count = to_change(patience, count);
    for (int i = 0; i < count; i++)
        turn(run, wrong[i], look->greater[wrong[i]] - look->less[wrong[i]]);
    return true;
}

/* Change states where conditions have become true. */
static bool jumps(Run *run, const Look *look, bool *edge)
{
    bool rising = false;
    for (int k = 0; k < N_JUMPS; k++) {
        bool now = run->m[jump_mode[k]] > 0.5;
        if (now && !edge[k]) {
            rising = true;
            for (int i = jump_begin[k]; i < jump_begin[k + 1]; i++) {
                if (jump_state[i] < 0) continue;
                run->x[jump_state[i]] = jump_sign[i] * look->values[i];
                run->moved = true;
            }
        }
        edge[k] = now;
    }
    return rising;
}

/* Engage and release holds; what engages gets the mode that follows from speed and gap alone. */
static bool engage(Run *run, const Look *look)
{
    bool any = false;
    for (int h = 0; h < N_HOLDS; h++) {
        bool engaged = hold_engaged[h] < 0 || run->m[hold_engaged[h]] > 0.5;
        if (engaged == acts(run->m, h)) continue;
        any = true;
        put(run->m, h, FREE);
        if (!engaged) {
            run->halted[h] = false;
            continue;
        }
        double least = standstill(run, h), v = look->v[h];
        bool still = fabs(v) <= least, touching = look->gap[h] <= CONTACT && v <= least;
        int part = STUCK;
        if (hold_has_gap[h] ? !(touching && still) : !still && v > 0 && hold_has_forward[h])
            part = FORWARD;
        else if (!hold_has_gap[h] && !still && v < 0 && hold_has_backward[h])
            part = BACKWARD;
        put(run->m, h, part);
    }
    return any;
}

/* Let go what is overloaded, hold what would turn back. */
static bool rebalance(Run *run, const Look *look, Wrong *patience)
{
    int wrong[N_HOLDS + 1], count = 0, next[N_HOLDS + 1];
    double calm = 0.0, soon = 1e-12 * run->span, coarse = 1.0;
    for (int i = 0; i < N_STATES; i++) calm = fmax(calm, fabs(look->rates[i]));
    calm = 1e-9 * (1.0 + calm);
    for (int h = 0; h < N_HOLDS; h++)
        if (run->m[hold_modes[h] + COMPLIANCE] != 0) coarse = 1e4;
    for (int h = 0; h < N_HOLDS; h++) {
        bool stuck = is(run->m, h, STUCK), forward = is(run->m, h, FORWARD);
        bool backward = is(run->m, h, BACKWARD), gap = hold_has_gap[h];
        double v = look->v[h], a = look->a[h], reaction = look->reaction[h];
        bool at_rest = fabs(v) <= standstill(run, h) || run->halted[h];
        double slack = coarse * (EXCESS * fabs(reaction) + 1e-13);
        bool over = stuck && reaction > look->upper[h] + slack + EXCESS * fabs(look->upper[h]);
        bool under = stuck && reaction < look->lower[h] - slack - EXCESS * fabs(look->lower[h]);
        bool onward = v > 0, freed = over || under;
        if (run->moved && stuck && !at_rest)
            freed |= onward ? hold_has_forward[h] : hold_has_backward[h];
        bool ending = fabs(v) <= fabs(a) * soon && !gap
                      && ((forward && v > 0 && a < 0) || (backward && v < 0 && a > 0));
        bool contact = !gap || look->gap[h] <= CONTACT;
        bool back = (forward && contact && ((at_rest && a < -calm) || ending))
                    || (backward && ((at_rest && a > calm) || ending));
        bool turned = !gap && !at_rest && ((forward && v < 0) || (backward && onward));
        if (!(freed || back || turned)) continue;
        bool ahead = over || under ? over : onward;
        next[count] = back ? STUCK : ahead ? FORWARD : BACKWARD;
        wrong[count++] = h;
    }
    if (!count) return false;
    count = to_change(patience, count);
    for (int i = 0; i < count; i++) {
        put(run->m, wrong[i], next[i]);
        if (next[i] == STUCK) run->halted[wrong[i]] = true;
    }
    return true;
}

/* Change modes and states until everything fits. */
static bool fit(Run *run, const double *before, bool *exempt)
{
    int most = 40 + 20 * (N_HOLDS + N_RELATIONS + N_JUMPS);
    Wrong relations_wrong = {1 << 30, PATIENCE}, holds_wrong = {1 << 30, PATIENCE};
    bool edge[N_JUMPS + 1];
    Look look;
    for (int k = 0; k < N_JUMPS; k++) edge[k] = before[jump_mode[k]] > 0.5;
    for (int round = 0; round < most; round++) {
        share(run, run->m);
        look_with(run, run->m, &look);
        if (relations(run, &look, exempt, &relations_wrong) || jumps(run, &look, edge)
            || engage(run, &look))
            continue;
        if ((!run->calm && collide(run, &look)) || rebalance(run, &look, &holds_wrong)) continue;
        if (!run->calm) halt(run, &look);
        return true;
    }
    return fail(run, "no set of modes fits at t = %.9g s; changes follow each other without end",
                run->t);
}

/* Modes and states just after an instant; fired tells which margins are used up. */
bool settle(Run *run, const double *before, const bool *fired)
{
    bool exempt[N_RELATIONS + 1] = {false};
    run->moved = false;
    for (int h = 0; h < N_HOLDS; h++) {
        run->halted[h] = false;
        run->was_stuck[h] = is(before, h, STUCK);
        if (run->was_stuck[h]) stop(run, h); /* integration leaves rounding there */
    }
    flip(run, fired, exempt);
    return fit(run, before, exempt);
}

/* Conditions at the start, as their sides say. */
static void conditions(Run *run, Look *look)
{
    for (int round = 0; round < 3; round++) {
        look_with(run, run->m, look);
        for (int k = 0; k < N_RELATIONS; k++) /* not an instant after the start already */
            look_up(run, k, look->greater[k], look->less[k], slack_of(look, k));
    }
}

/* Modes at the start before anything collides; states stay as they are. */
bool positions(Run *run)
{
    double before[N_MODES + N_GUESSES + 1], x[N_STATES + 1];
    bool none[N_MARGINS + 1] = {false};
    Look look;
    memcpy(x, run->x, N_STATES * sizeof(double));
    conditions(run, &look);
    copy_modes(before, run->m);
    run->calm = true;
    bool well = settle(run, before, none);
    run->calm = false;
    memcpy(run->x, x, N_STATES * sizeof(double));
    return well;
}

/* Modes at the start, and what collides there at once. */
bool settle_start(Run *run)
{
    double before[N_MODES + N_GUESSES + 1];
    bool none[N_MARGINS + 1] = {false};
    Look look;
    conditions(run, &look);
    for (int h = 0; h < N_HOLDS; h++)
        if (hold_has_gap[h] && look.gap[h] < -INSIDE_BY)
            return fail(run, "%s starts %g inside the body that it must not enter; give start "
                        "values that leave a gap", hold_names[h], -look.gap[h]);
    copy_modes(before, run->m);
    return settle(run, before, none);
}
