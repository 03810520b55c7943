/* Words for what went wrong, as in lumped itself. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "lumped.h"

/* Add to a message what still fits. */
static void add(Unit *unit, const char *format, va_list arguments)
{
    size_t count = strlen(unit->message);
    vsnprintf(unit->message + count, sizeof unit->message - count, format, arguments);
}

static void say(Unit *unit, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add(unit, format, arguments);
    va_end(arguments);
}

static void fail(Unit *unit, const char *format, va_list arguments)
{
    snprintf(unit->message, sizeof unit->message, "%s: ", model_name);
    add(unit, format, arguments);
}

bool unit_fail(Unit *unit, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(unit, format, arguments);
    va_end(arguments);
    unit->refused = false;
    return false;
}

/* Of a call that changed nothing: another one may help. */
bool unit_refuse(Unit *unit, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail(unit, format, arguments);
    va_end(arguments);
    unit->refused = true;
    return false;
}

/* Whether a function may be called in the present phase; a unit of the other kind knows no phase in
   which it may. */
bool unit_allowed(Unit *unit, int phases, const char *name)
{
    int phase = unit->phase;
    if (phase & phases) return true;
    return unit_fail(unit, "%s must not be called %s", name,
                     !phases                  ? "in a unit instantiated like this"
                     : phase == INSTANTIATED  ? "before the initialisation"
                     : phase == INITIALIZING  ? "in the initialisation mode"
                     : phase == CONTINUOUS    ? "in the continuous-time mode"
                     : phase == STEPPING      ? "in the step mode"
                     : phase == TERMINATED    ? "after the end of the run or an error"
                                              : "in the event mode");
}

/* Whether an importer gives or wants as many numbers as there are. */
bool unit_sized(Unit *unit, size_t count, size_t wanted)
{
    return count == wanted || unit_fail(unit, "%lu numbers where there are %lu",
                                        (unsigned long)count, (unsigned long)wanted);
}

static const char *word(const Plant *plant, const double *m, int h)
{
    const double *own = m + plant->hold_setting[h];
    if (own[STUCK] > 0.5) return plant->has_gap[h] ? "closed" : "stuck";
    if (own[FORWARD] > 0.5) return plant->has_gap[h] ? "open" : "forward";
    return own[BACKWARD] > 0.5 ? "backward" : "free";
}

static void say_condition(Unit *unit, const double *m, int k)
{
    const Plant *plant = unit->memory.run.plant;
    const double *own = m + plant->condition_setting[k];
    int64_t count = plant->piece_count[k], piece = (int64_t)own[0], width = plant->piece_width[k];
    const double *begins = plant->pieces + plant->first_piece[k] + 1;
    if (!count) {
        say(unit, "%s", condition_texts[2 * k + (own[0] > 0.5)]);
        return;
    }
    if (piece > 0) say(unit, "%s >= %.6g", condition_sides[k], begins[piece * width]);
    if (piece > 0 && piece + 1 < count) say(unit, " and ");
    if (piece + 1 < count) say(unit, "%s < %.6g", condition_sides[k], begins[(piece + 1) * width]);
}

/* What was tried last where no positions fit. */
static bool no_fit(Unit *unit)
{
    const Run *run = &unit->memory.run;
    const Plant *plant = run->plant;
    InstantSearch *at = run->instant;
    int listed = 0;
    int64_t most = 40 + 20 * (plant->holds + plant->conditions + plant->jumps);
    unit_fail(unit, "no set of modes fits at t = %.9g s after %d attempts; changes follow each other "
              "without end. Last tried:", run->t, (int)most);
    model_look(at->x, run->p, run->t, at->m, at->seen->greater);
    for (int h = 0; h < N_HOLDS && listed < 12; h++, listed++)
        say(unit, "\n  %s: %s, speed %.4g, reaction %.6g", change_names[N_CONDITIONS + h],
            word(plant, at->m, h), at->seen->speed[h], at->seen->reaction[h]);
    for (int k = 0; k < N_CONDITIONS && listed < 12; k++, listed++) {
        say(unit, "\n  %s: ", change_names[k]);
        say_condition(unit, at->m, k);
    }
    say(unit, "\nCheck conditions that switch each other, limits of reactions that depend on the "
        "reaction itself, and jumps that make their own condition true again.");
    return false;
}

static bool inside(Unit *unit)
{
    const Run *run = &unit->memory.run;
    const double *gap = run->instant->seen->gap;
    int deepest = -1;
    for (int h = 0; h < N_HOLDS; h++)
        if (run->plant->has_gap[h] && (deepest < 0 || gap[h] < gap[deepest])) deepest = h;
    if (deepest < 0) return false;
    return unit_fail(unit, "%s starts %.6g %s inside the body that it must not enter. Give start "
                     "values that leave a gap, or none.", change_names[N_CONDITIONS + deepest],
                     -gap[deepest], gap_units[deepest]);
}

/* Two settings of one state at one instant. */
static bool set_twice(Unit *unit)
{
    const Run *run = &unit->memory.run;
    const InstantSearch *at = run->instant;
    return unit_fail(unit, "at t = %.9g s two settings of %s meet: %s, and %s. One of them would be "
                     "lost. Write both as one `when`, or conditions of which only one becomes true "
                     "at an instant.", run->t, state_names[at->set_twice],
                     jump_texts[at->set_by[at->set_twice] - 1], jump_texts[at->setting_again]);
}

static bool jumps(Unit *unit)
{
    const double *old = unit->memory.run.followed_before, *new = unit->memory.run.followed_after;
    for (int i = 0; i < N_FOLLOWERS; i++)
        if (fabs(new[i] - old[i]) > MOST_JUMP * fmax(1.0, fabs(old[i])))
            return unit_fail(
                unit, "%s would have to jump from %.6g to %.6g at t = %g s, because a prescribed "
                "motion jumps or has a kink there that a body or damper must follow. Prescribe a "
                "smoother motion (no jump of the angle or position, for bodies none of the speed "
                "either, behind a spring none of acceleration and jerk), or put a spring without "
                "damper in between.", follower_names[i], old[i] + 0.0, new[i] + 0.0,
                unit->memory.run.t);
    return false;
}

static bool storm(Unit *unit)
{
    const Run *run = &unit->memory.run;
    const char *last = "";
    unit_fail(unit, "%d changes of mode within %.2g s before t = %.9g s, in ", (int)STORM_SIZE,
              STORM_WITHIN * run->span, run->t);
    for (int listed = 0; listed < 6; listed++) { /* names in their order, each once */
        const char *next = NULL;
        for (int64_t i = 0; i < STORM_SIZE && i < unit->changed_count; i++) {
            const char *name = change_names[unit->changed[i]];
            if (strcmp(name, last) > 0 && (!next || strcmp(name, next) < 0)) next = name;
        }
        if (!next) break;
        say(unit, "%s%s", listed ? ", " : "", next);
        last = next;
    }
    say(unit, ". Conditions that switch each other: dry friction and contacts that can rest need "
        "lumped.hold, which finds a standstill; a condition on a speed cannot.");
    return false;
}

/* The first derivative that is not a finite number; -1 if all are. */
static int not_finite(const double *rates)
{
    for (int i = 0; i < N_STATES; i++)
        if (!isfinite(rates[i])) return i;
    return -1;
}

static bool say_not_finite(Unit *unit, int bad)
{
    const Run *run = &unit->memory.run;
    unit_fail(unit, "the derivative of %s is not a finite number at t = %g s, where ",
              state_names[bad], run->t);
    for (int i = 0; i < N_STATES && i < 8; i++)
        say(unit, "%s%s = %.6g", i ? ", " : "", state_names[i], run->x[i]);
    say(unit, ". A division by zero or a function outside its range; check the parameters and start "
        "values that enter it.");
    return false;
}

/* Why steps became too small: what the present point tells, and one just ahead. */
static bool shrinking(Unit *unit)
{
    const Run *run = &unit->memory.run;
    double rates[N_STATES + 1], x[N_STATES + 1], beyond[N_STATES + 1];
    double ahead = 1e-9 * fmax(1.0, fabs(run->t)), largest = -1.0;
    int worst = 0;
    if (!N_STATES)
        return unit_fail(unit, "a linkage or implicit equation could not be followed beyond t = "
                         "%.9g s. Take shorter communication steps, or check its range.", run->t);
    model_rates(run->x, run->p, run->t, run->m, rates);
    for (int i = 0; i < N_STATES; i++) {
        double size = fabs(rates[i]) / (run->atol[i] + run->rtol * fabs(run->x[i]));
        if (size > largest) {
            largest = size;
            worst = i;
        }
        x[i] = run->x[i] + ahead * rates[i];
    }
    model_rates(x, run->p, run->t + ahead, run->m, beyond);
    int bad = not_finite(rates);
    if (bad < 0) bad = not_finite(beyond);
    if (bad >= 0) return say_not_finite(unit, bad);
    return unit_fail(unit, "the step size shrank to nothing at t = %.9g s; the fastest state there "
                     "is %s = %.6g with derivative %.6g. A quantity runs to infinity or leaves the "
                     "range of a function.", run->t, state_names[worst], run->x[worst],
                     rates[worst]);
}

/* A state that hardly leads what depends on it. */
static bool unfit(Unit *unit)
{
    const Run *run = &unit->memory.run;
    int i = 0;
    while (i < N_LEVERS - 1 && fabs(run->ratio[i]) <= 1.0) i++;
    return unit_fail(unit, "at t = %.9g s %s; this exchange format cannot change states, so the run "
                     "ends here", run->t, lever_names[i]);
}

/* Why the loop could not go on. */
bool unit_fault(Unit *unit, int64_t why)
{
    const Run *run = &unit->memory.run;
    double rates[N_STATES + 1];
    switch (why) {
    case UNFIT: return unfit(unit);
    case STORM: return storm(unit);
    case NO_FIT: return no_fit(unit);
    case SET_TWICE: return set_twice(unit);
    case JUMPS: return jumps(unit);
    case INSIDE: return inside(unit);
    case GIVEN_UP: return shrinking(unit);
    case NOT_CLOSED:
        return unit_fail(unit, "no values of %s meet their equations at t = %g s, so a linkage "
                         "cannot be closed. Check its lengths, and give start values near the "
                         "position that is meant.", implicit_names, run->t);
    case NOT_FINITE:
        model_rates(run->x, run->p, run->t, run->m, rates);
        if (not_finite(rates) >= 0) return say_not_finite(unit, not_finite(rates));
        break;
    case TOO_MANY:
        return unit_fail(unit, "more than %d steps before t = %g s; stopped at t = %.9g s with steps "
                         "of %.2g s. Loosen the tolerance%s.", MOST_STEPS, run->end, run->t, run->h,
                         run->is_implicit ? "" : ", or export with method='implicit'");
    default: break;
    }
    return unit_fail(unit, "the run cannot go on from t = %.9g s", run->t);
}
