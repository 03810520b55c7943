/* Derivatives of rates, outputs and event indicators by states, inputs and parameters, at the present
   point and in the present positions. Before the run states follow from start values, inputs and
   parameters. */
#include <string.h>
#include "lumped.h"

/* The place of a known variable in a direction, or a negative number. */
int unit_known(Unit *unit, uint32_t reference)
{
    bool before = unit->phase == INITIALIZING;
    if (reference == 0) return N_STATES + N_PARAMETERS;
    if (reference >= FIRST_RATE) {
        unit_fail(unit, "no derivatives by the variable with value reference %lu: it is neither a "
                  "state nor an input, a parameter or the time", (unsigned long)reference);
        return -1;
    }
    int state = (int)reference - FIRST_STATE, parameter = (int)reference - FIRST_PARAMETER;
    if (state >= 0 && (!before || state_settable[state])) return state;
    if (state >= 0) {
        unit_fail(unit, "no derivatives by the start of %s: it follows from others",
                  state_names[state]);
        return -1;
    }
    if (before || parameter_tunable[parameter]) return N_STATES + parameter;
    unit_fail(unit, "no derivatives by %s: it is fixed", parameter_names[parameter]);
    return -1;
}

/* The place of an unknown variable among rates, outputs and event indicators, beyond their end for
   states. */
int unit_unknown(Unit *unit, uint32_t reference)
{
    if (reference >= FIRST_RATE && reference < END_OF_VALUES) return (int)reference - FIRST_RATE;
    if (reference >= FIRST_STATE && reference < FIRST_RATE)
        return N_UNKNOWNS + (int)reference - FIRST_STATE;
    unit_fail(unit, "no derivatives of the variable with value reference %lu: it is neither an "
              "output nor a state, its derivative or an event indicator", (unsigned long)reference);
    return -1;
}

/* Settings and parameters at the present point; factors follow the parameters. */
bool unit_linear(Unit *unit, double *m, double *p)
{
    if (!unit_close(unit, m)) return false;
    if (unit->phase == INITIALIZING && unit->struck)
        return unit_refuse(unit, "what collides at the start lets states jump, so there are no "
                           "derivatives of the start");
    memcpy(p, unit->memory.run.p, N_PARAMETERS * sizeof(double));
    return true;
}

/* The matrix of the states that start values of other quantities determine. */
void unit_start_matrix(Unit *unit, const double *m, double *matrix)
{
    double found[N_TARGETS + N_SOLVED * N_SOLVED + 1];
    model_targets(unit->all, unit->memory.run.p, unit->t, m, found);
    memcpy(matrix, found + N_TARGETS, N_SOLVED * N_SOLVED * sizeof(double));
}

/* A direction of start values, parameters and the time becomes one of all states. */
static bool along_start(Unit *unit, const double *m, double *p)
{
    double found[N_ALL_STATES + N_SOLVED + 1], matrix[N_SOLVED * N_SOLVED + 1];
    double *missed = found + N_ALL_STATES;
    model_start_forward(unit->all, p, unit->t, m, found);
    unit_start_matrix(unit, m, matrix);
    if (!unit_solve(matrix, missed, N_SOLVED))
        return unit_refuse(unit, "the start values have no derivatives here");
    for (int i = 0; i < N_SOLVED; i++) found[solved_state[i]] -= missed[i];
    for (int i = 0; i < N_STATES; i++) p[N_PARAMETERS + i] = found[state_place[i]];
    return true;
}

/* Derivatives of unknown variables along a direction. */
bool unit_forward(Unit *unit, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                  size_t knowns, const double *seed, double *sensitivity)
{
    double m[N_SETTINGS + 1], p[N_PARAMETERS + N_KNOWNS] = {0}, found[N_UNKNOWNS + 1];
    double *direction = p + N_PARAMETERS;
    if (!unit_linear(unit, m, p)) return false;
    for (size_t k = 0; k < knowns; k++) {
        int place = unit_known(unit, known[k]);
        if (place < 0) return false;
        direction[place] += seed[k];
    }
    if (unit->phase == INITIALIZING && !along_start(unit, m, p)) return false;
    model_forward(unit->x, p, unit->t, m, found);
    for (size_t k = 0; k < unknowns; k++) {
        int place = unit_unknown(unit, unknown[k]);
        if (place < 0) return false;
        sensitivity[k] = place < N_UNKNOWNS ? found[place] : direction[place - N_UNKNOWNS];
        if (!isfinite(sensitivity[k]))
            return unit_refuse(unit, "the derivative of the variable with value reference %lu is not "
                               "finite here", (unsigned long)unknown[k]);
    }
    return true;
}
