/* Derivatives of a weighted sum of rates, outputs and event indicators. */
#include <string.h>
#include "lumped.h"

/* Derivatives by all states become those by start values, parameters and the time. */
static bool back_to_start(Unit *unit, const double *m, double *found)
{
    double p[N_PARAMETERS + N_ALL_STATES + N_SOLVED + 1] = {0}, more[N_KNOWNS];
    double matrix[N_SOLVED * N_SOLVED + 1], *weights = p + N_PARAMETERS;
    double *factors = weights + N_ALL_STATES;
    memcpy(p, unit->memory.run.p, N_PARAMETERS * sizeof(double));
    for (int i = 0; i < N_STATES; i++) weights[state_place[i]] = found[i];
    for (int i = 0; i < N_SOLVED; i++) factors[i] = -weights[solved_state[i]];
    unit_start_matrix(unit, m, matrix);
    for (int i = 0; i < N_SOLVED; i++)
        for (int j = 0; j < i; j++) {
            double held = matrix[i + N_SOLVED * j];
            matrix[i + N_SOLVED * j] = matrix[j + N_SOLVED * i];
            matrix[j + N_SOLVED * i] = held;
        }
    if (!unit_solve(matrix, factors, N_SOLVED))
        return unit_refuse(unit, "the start values have no derivatives here");
    model_start_reverse(unit->all, p, unit->t, m, more);
    memset(found, 0, N_STATES * sizeof(double));
    for (int i = 0; i < N_KNOWNS; i++) found[i] += more[i];
    return true;
}

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
    if (unit->phase == INITIALIZING && !back_to_start(unit, m, found)) return false;
    for (size_t k = 0; k < knowns; k++) {
        int place = unit_known(unit, known[k]);
        if (place < 0) return false;
        sensitivity[k] = found[place];
        if (!isfinite(sensitivity[k]))
            return unit_refuse(unit, "the derivative by the variable with value reference %lu is not "
                               "finite here", (unsigned long)known[k]);
    }
    return true;
}
