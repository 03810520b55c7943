/* What the parts of the interface 3.0 share. */
#ifndef LUMPED_FMI3_H
#define LUMPED_FMI3_H

#include "lumped.h"
#include "fmi3Functions.h"

typedef struct {
    Unit unit;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    bool exchange;
    /* of co-simulation: whether it may stop at events, and whether the importer handles them */
    bool returns_early, event_mode;
} Instance;

#define UNIT(c) (&((Instance *)(c))->unit)

fmi3Status told3(fmi3Instance c, bool well);

#define ONLY_IN(c, phases)                                                                         \
    if (!unit_allowed(UNIT(c), phases, __func__)) return told3(c, false)

/* Of functions for model exchange in phases that co-simulation has too. */
#define ONLY_EXCHANGE(c, phases) ONLY_IN(c, ((Instance *)c)->exchange ? (phases) : 0)

#endif
