/* An importer: runs of a unit for co-simulation, the best time of several. */
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <time.h>
#include "fmi3Functions.h"

#define FUNCTION(name) name##TYPE *name##_ = (name##TYPE *)dlsym(library, #name)

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of the best of some runs; the last values stay in `values`. */
double runs(const char *path, const char *token, double end, double rtol, int points, int rounds,
            const fmi3ValueReference *references, int count, double *values)
{
    void *library = dlopen(path, RTLD_NOW);
    FUNCTION(fmi3InstantiateCoSimulation);
    FUNCTION(fmi3EnterInitializationMode);
    FUNCTION(fmi3ExitInitializationMode);
    FUNCTION(fmi3DoStep);
    FUNCTION(fmi3GetFloat64);
    FUNCTION(fmi3Reset);
    FUNCTION(fmi3FreeInstance);
    fmi3Instance unit = fmi3InstantiateCoSimulation_("one", token, "", false, false, false, false,
                                                     NULL, 0, NULL, NULL, NULL);
    double best = 1e300, step = end / points, last;
    bool event, ended, early;
    for (int round = 0; unit && round < rounds; round++) {
        fmi3Reset_(unit);
        double begin = now();
        fmi3EnterInitializationMode_(unit, true, rtol, 0.0, true, end);
        fmi3ExitInitializationMode_(unit);
        for (int k = 0; k < points; k++) {
            fmi3DoStep_(unit, k * step, (k + 1) * step - k * step, true, &event, &ended, &early,
                        &last);
            fmi3GetFloat64_(unit, references, (size_t)count, values, (size_t)count);
        }
        double seconds = now() - begin;
        best = seconds < best ? seconds : best;
    }
    if (unit) fmi3FreeInstance_(unit);
    dlclose(library);
    return best;
}
