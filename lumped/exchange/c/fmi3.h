/* What the parts of the interface 3.0 share. */
#ifndef LUMPED_FMI3_H
#define LUMPED_FMI3_H

#include "lumped.h"
#ifndef fmi3Functions_h
#include "fmi3_types.h"
#endif

typedef struct {
    Run run;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    bool exchange;
} Instance;

#define RUN(c) (&((Instance *)(c))->run)

fmi3Status told3(fmi3Instance c, bool well);

#endif
