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

#endif
