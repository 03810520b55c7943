/* Derivatives of a weighted sum of rates and outputs. */
#include "lumped.h"

bool unit_reverse(Unit *unit, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                  size_t knowns, const double *seed, double *sensitivity)
{
    double m[N_SETTINGS + 1], p[N_PARAMETERS + N_UNKNOWNS + N_STATES + 1] = {0};
    double found[N_KNOWNS], *weights = p + N_PARAMETERS;
    if (!unit_linear(unit, m, p)) return false;
    for (size_t k = 0; k < unknowns; k++) {
        int place = unit_unknown(unit, unknown[k]);
        if (place < 0) return false;
        weights[place] += seed[k];
    }
    model_reverse(unit->x, p, unit->t, m, found);
    for (int i = 0; i < N_STATES; i++) found[i] += weights[N_UNKNOWNS + i];
    for (size_t k = 0; k < knowns; k++) {
        int place = unit_known(unit, known[k]);
        if (place < 0) return false;
        sensitivity[k] = found[place];
        if (!isfinite(sensitivity[k]))
            return unit_fail(unit, "the derivative by the variable with value reference %u is not "
                             "finite here", known[k]);
    }
    return true;
}
