/* Derivatives of rates and outputs by states, inputs and parameters, at the present point and in
   the present positions. */
#include <string.h>
#include "lumped.h"

/* The place of a known variable in a direction, or a negative number. */
int unit_known(Unit *unit, uint32_t reference)
{
    if (reference == 0) return N_STATES + N_PARAMETERS;
    if (reference >= FIRST_STATE && reference < FIRST_RATE) return (int)reference - FIRST_STATE;
    if (reference >= FIRST_STATE) {
        unit_fail(unit, "no derivatives by the variable with value reference %u: it is neither a "
                  "state nor an input, a parameter or the time", reference);
        return -1;
    }
    int parameter = (int)reference - FIRST_PARAMETER;
    if (parameter_tunable[parameter]) return N_STATES + parameter;
    unit_fail(unit, "no derivatives by %s: it is fixed", parameter_names[parameter]);
    return -1;
}

/* The place of an unknown variable among rates and outputs, beyond their end for states. */
int unit_unknown(Unit *unit, uint32_t reference)
{
    int r = (int)reference;
    if (reference >= FIRST_RATE && reference < FIRST_INDICATOR) return r - FIRST_RATE;
    if (reference >= FIRST_STATE && reference < FIRST_RATE) return N_UNKNOWNS + r - FIRST_STATE;
    unit_fail(unit, "no derivatives of the variable with value reference %u: it is neither an "
              "output nor a state or its derivative", reference);
    return -1;
}

/* Settings and parameters at the present point; factors follow the parameters. */
bool unit_linear(Unit *unit, double *m, double *p)
{
    if (unit->phase == INSTANTIATED || unit->phase == INITIALIZING)
        return unit_fail(unit, "derivatives can be had after the initialisation");
    if (!unit_close(unit, m)) return false;
    memcpy(p, unit->memory.run.p, N_PARAMETERS * sizeof(double));
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
    model_forward(unit->x, p, unit->t, m, found);
    for (size_t k = 0; k < unknowns; k++) {
        int place = unit_unknown(unit, unknown[k]);
        if (place < 0) return false;
        sensitivity[k] = place < N_UNKNOWNS ? found[place] : direction[place - N_UNKNOWNS];
        if (!isfinite(sensitivity[k]))
            return unit_fail(unit, "the derivative of the variable with value reference %u is not "
                             "finite here", unknown[k]);
    }
    return true;
}
