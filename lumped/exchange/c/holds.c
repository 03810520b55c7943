/* Holds of a system at one instant: what decides modes, redundant holds, impacts. */
#include <stdlib.h>
#include <string.h>
#include "holds.h"

static const double YIELDING = 1e-9; /* of redundant holds, relative to what they hold */

void look_with(const Run *run, const double *m, Look *look)
{
    double row[2 * N_RELATIONS + 7 * N_HOLDS + N_JUMP_VALUES + N_STATES + 1], *next = row;
    model_look(run->x, run->p, &run->t, m, row);
    double *parts[] = {look->greater, look->less, look->v, look->a, look->reaction, look->upper,
                       look->lower, look->gap, look->restitution, look->values, look->rates};
    for (int k = 0; k < 11; k++) {
        int count = k < 2 ? N_RELATIONS : k < 9 ? N_HOLDS : k == 9 ? N_JUMP_VALUES : N_STATES;
        memcpy(parts[k], next, (size_t)count * sizeof(double));
        next += count;
    }
    for (int h = 0; h < N_HOLDS; h++) {
        if (!hold_has_upper[h]) look->upper[h] = INFINITY;
        if (!hold_has_lower[h]) look->lower[h] = -INFINITY;
    }
}

void copy_modes(double *to, const double *from)
{
    memcpy(to, from, (N_MODES + N_GUESSES) * sizeof(double));
}

bool is(const double *m, int h, int part)
{
    return m[hold_modes[h] + part] > 0.5;
}

void put(double *m, int h, int part)
{
    for (int i = 0; i < 3; i++) m[hold_modes[h] + i] = 0.0;
    if (part != FREE) m[hold_modes[h] + part] = 1.0;
}

bool acts(const double *m, int h)
{
    return is(m, h, STUCK) || is(m, h, FORWARD) || is(m, h, BACKWARD);
}

static bool impulsive(int h)
{
    return !(hold_has_upper[h] && hold_has_lower[h]);
}

/* Speeds that may be rounding of the states that they depend on. */
static double rounding(const Run *run, int h)
{
    double size = 0.0;
    for (int k = hold_uses_begin[h]; k < hold_uses_begin[h + 1]; k++)
        size = fmax(size, fabs(run->x[hold_uses[k]]));
    return 1e-9 * (1.0 + size);
}

/* Speeds that count as zero: where they are states, only zero does. */
double standstill(const Run *run, int h)
{
    return hold_state[h] >= 0 ? 0.0 : rounding(run, h);
}

void stop(Run *run, int h)
{
    if (hold_state[h] >= 0) run->x[hold_state[h]] = 0.0;
}

/* ---- redundant holds yield a little ------------------------------------------------------- */

/* Whether these cannot be given any accelerations that one likes if they stick. */
static bool redundant(const Run *run, const double *m, const bool *stuck)
{
    double trial[N_MODES + N_GUESSES + 1], wanted[N_HOLDS + 1];
    Look rest, push;
    uint32_t random = 4;
    copy_modes(trial, m);
    for (int h = 0; h < N_HOLDS; h++)
        if (stuck[h]) put(trial, h, STUCK);
    look_with(run, trial, &rest);
    for (int h = 0; h < N_HOLDS; h++) {
        random = random * 1664525u + 1013904223u; /* Numerical Recipes, any numbers do */
        wanted[h] = trial[hold_modes[h] + DEMAND] = 0.5 + random / 4294967296.0;
    }
    look_with(run, trial, &push);
    for (int h = 0; h < N_HOLDS; h++)
        if (stuck[h] && !(fabs(push.a[h] - rest.a[h] - wanted[h]) < 1e-6
                          && isfinite(push.reaction[h] - rest.reaction[h])))
            return true;
    return false;
}

/* How much acceleration a unit of force gives at most where a constraint acts. */
static double softest(const Run *run, const double *m)
{
    double alone[N_MODES + N_GUESSES + 1], found = 0.0;
    Look rest, push;
    copy_modes(alone, m);
    for (int h = 0; h < N_HOLDS; h++) {
        put(alone, h, FREE);
        alone[hold_modes[h] + COMPLIANCE] = 0.0;
    }
    for (int h = 0; h < N_HOLDS; h++) {
        put(alone, h, STUCK);
        look_with(run, alone, &rest);
        alone[hold_modes[h] + DEMAND] = 1.0;
        look_with(run, alone, &push);
        alone[hold_modes[h] + DEMAND] = 0.0;
        put(alone, h, FREE);
        double force = fabs(push.reaction[h] - rest.reaction[h]);
        if (isfinite(force) && force > 0) found = fmax(found, 1.0 / force);
    }
    return found > 0 ? found : 1.0;
}

/* Let redundant holds among those that stick in m yield; the stronger one carries more. */
void share(Run *run, double *m)
{
    bool stuck[N_HOLDS + 1], all[N_HOLDS + 1], any = false;
    double reach[N_HOLDS + 1], largest = 0.0;
    Look look;
    for (int h = 0; h < N_HOLDS; h++) {
        m[hold_modes[h] + COMPLIANCE] = 0.0;
        stuck[h] = is(m, h, STUCK);
        any |= stuck[h];
        all[h] = true;
    }
    if (!any) return;
    /* what is independent remains so if some of it lets go */
    if (run->independent < 0) run->independent = !redundant(run, m, all);
    if (run->independent || !redundant(run, m, stuck)) return;
    if (run->yielding < 0) run->yielding = YIELDING * softest(run, m);
    for (int h = 0; h < N_HOLDS; h++) m[hold_modes[h] + COMPLIANCE] = run->yielding;
    look_with(run, m, &look);
    for (int h = 0; h < N_HOLDS; h++) {
        reach[h] = fmin(fabs(look.upper[h]), fabs(look.lower[h]));
        if (isfinite(reach[h])) largest = fmax(largest, reach[h]);
    }
    for (int h = 0; h < N_HOLDS; h++) {
        double weight = isfinite(reach[h]) && reach[h] > 0 ? largest / reach[h] : 1.0;
        m[hold_modes[h] + COMPLIANCE] *= fmin(weight, 1e3);
    }
}

/* ---- impacts ------------------------------------------------------------------------------ */

/* Impulses of what closes and of all constraints without limit that hold; members take part.

   The jump of all speeds is what the accelerations would be if the closing constraints demanded
   the change of their speed in unit time, without any other force (Routh, Dynamics of a System of
   Rigid Bodies, ch. VIII). */
static void strike(Run *run, const Look *look, const bool *closing, const double *bounce, bool pull,
                   bool *members)
{
    double wanted[N_HOLDS + 1], trial[N_MODES + N_GUESSES + 1], size[N_HOLDS + 1];
    double impulse[N_HOLDS + 1];
    Look rest, push;
    for (int h = 0; h < N_HOLDS; h++) {
        members[h] = closing[h] || (is(run->m, h, STUCK) && impulsive(h));
        wanted[h] = closing[h] ? -(1.0 + bounce[h]) * look->v[h] : 0.0;
    }
    for (int round = 0; round < 2 * N_HOLDS + 2; round++) {
        double largest = 0.0;
        int worst = -1, closer = -1;
        copy_modes(trial, run->m);
        for (int h = 0; h < N_HOLDS; h++) put(trial, h, members[h] ? STUCK : FREE);
        share(run, trial);
        look_with(run, trial, &rest);
        for (int h = 0; h < N_HOLDS; h++)
            if (members[h]) trial[hold_modes[h] + DEMAND] = wanted[h];
        look_with(run, trial, &push);
        for (int h = 0; h < N_HOLDS; h++) {
            impulse[h] = push.reaction[h] - rest.reaction[h];
            size[h] = fabs(impulse[h]);
            if (size[h] > largest) largest = size[h];
        }
        for (int h = 0; h < N_HOLDS; h++) {
            bool pushing = hold_has_upper[h] && !hold_has_lower[h] && impulse[h] > 0;
            bool pulling = hold_has_lower[h] && !hold_has_upper[h] && impulse[h] < 0;
            double speed = look->v[h] + push.a[h] - rest.a[h];
            bool touching = hold_has_gap[h] && is(run->m, h, FORWARD) && look->gap[h] <= CONTACT;
            if ((pushing || pulling) && members[h] && size[h] > 1e-12 * largest
                && (worst < 0 || size[h] > size[worst]))
                worst = h;
            if (touching && !members[h] && speed < -1e-12 && closer < 0) closer = h;
        }
        if (worst >= 0 && !pull) {
            members[worst] = false;
        } else if (closer >= 0) { /* it did not approach, so there is nothing that would bounce */
            members[closer] = true;
            wanted[closer] = -look->v[closer];
        } else {
            break;
        }
    }
    for (int i = 0; i < N_STATES; i++) run->x[i] += push.rates[i] - rest.rates[i];
    run->moved = true;
}

/* Whether a bounce would be over at once, or is lower than an importer can resolve. */
static bool rests(const Run *run, int h, const Look *after)
{
    double trial[N_MODES + N_GUESSES + 1];
    Look look;
    copy_modes(trial, run->m);
    put(trial, h, FORWARD);
    look_with(run, trial, &look);
    double v = after->v[h], pull = -look.a[h];
    bool low = run->phase == EVENTS && v * v <= 2 * pull * CONTACT;
    return pull > 0 && (2 * v <= pull * 1e-10 * run->span || low);
}

/* Let constraints without limit that close at a speed do so; whether there were any. */
bool collide(Run *run, const Look *look)
{
    bool closing[N_HOLDS + 1], taken[N_HOLDS + 1], only[N_HOLDS + 1], ignored[N_HOLDS + 1];
    double bounce[N_HOLDS + 1];
    bool any = false;
    Look after;
    for (int h = 0; h < N_HOLDS; h++) {
        double still = standstill(run, h), v = look->v[h];
        bool near = !hold_has_gap[h] || look->gap[h] <= CONTACT || run->halted[h];
        bool approaching = (v < -still && !hold_has_backward[h] && near)
                           || (v > still && !hold_has_forward[h]);
        approaching = approaching && (!run->halted[h] || hold_has_gap[h]);
        if (!run->moved && is(run->m, h, STUCK) && run->was_stuck[h]) approaching = false;
        closing[h] = acts(run->m, h) && impulsive(h) && approaching;
        bounce[h] = closing[h] ? look->restitution[h] : 0.0;
        any |= closing[h];
    }
    if (!any) return false;
    strike(run, look, closing, bounce, false, taken);
    look_with(run, run->m, &after);
    for (int h = 0; h < N_HOLDS; h++) {
        if (!(closing[h] && taken[h] && bounce[h] != 0) || !rests(run, h, &after)) continue;
        bounce[h] = 0.0;
        memset(only, 0, sizeof only);
        only[h] = true;
        strike(run, &after, only, bounce, true, ignored);
    }
    for (int h = 0; h < N_HOLDS; h++) {
        if (!closing[h]) continue;
        bool resting = taken[h] && bounce[h] == 0;
        run->halted[h] = false;
        if (resting) stop(run, h);
        /* what is not taken others pull away */
        put(run->m, h, resting ? STUCK : taken[h] || hold_has_upper[h] ? FORWARD : BACKWARD);
    }
    return true;
}

/* Bring the speed of what sticks to exactly zero. */
void halt(Run *run, const Look *look)
{
    bool stuck[N_HOLDS + 1], ignored[N_HOLDS + 1], turning = false;
    double bounce[N_HOLDS + 1] = {0};
    for (int h = 0; h < N_HOLDS; h++) {
        stuck[h] = is(run->m, h, STUCK);
        turning |= stuck[h] && look->v[h] != 0.0;
    }
    if (turning) strike(run, look, stuck, bounce, true, ignored);
    for (int h = 0; h < N_HOLDS; h++)
        if (stuck[h] || (run->halted[h] && !hold_has_gap[h])) stop(run, h);
}
