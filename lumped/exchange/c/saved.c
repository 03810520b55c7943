/* States that importers keep, and their bytes; these begin with the token of the model. */
#include <stdlib.h>
#include <string.h>
#include "lumped.h"

static bool made(Unit *unit, void **state)
{
    if (!*state) *state = malloc(sizeof(Unit));
    return *state || unit_refuse(unit, "no memory for a state");
}

bool unit_keep(Unit *unit, void **state)
{
    if (!made(unit, state)) return false;
    unit_copy(unit, *state);
    return true;
}

bool unit_take_up(Unit *unit, void *state)
{
    if (!state) return unit_fail(unit, "there is no state to take up");
    unit_copy(state, unit);
    return true;
}

void unit_drop(void **state)
{
    if (!state) return;
    free(*state);
    *state = NULL;
}

size_t unit_size(void)
{
    return strlen(model_token) + sizeof(Unit);
}

bool unit_write(Unit *unit, const void *state, void *bytes, size_t size)
{
    if (!state || size < unit_size()) return unit_fail(unit, "no state, or too few bytes for it");
    memcpy(bytes, model_token, strlen(model_token));
    memcpy((char *)bytes + strlen(model_token), state, sizeof(Unit));
    return true;
}

bool unit_read(Unit *unit, const void *bytes, size_t size, void **state)
{
    size_t head = strlen(model_token);
    if (size != unit_size() || memcmp(bytes, model_token, head) != 0)
        return unit_fail(unit, "these are not the bytes of a state of this model");
    if (!made(unit, state)) return false;
    memcpy(*state, (const char *)bytes + head, sizeof(Unit));
    model_bind(&((Unit *)*state)->memory);
    return true;
}
