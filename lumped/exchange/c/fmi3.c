/* Functional Mock-up Interface 3.0: model exchange and co-simulation. */
#include <stdlib.h>
#include <string.h>
#include "fmi3.h"

fmi3Status told3(fmi3Instance c, bool well)
{
    Instance *instance = c;
    if (well) return fmi3OK;
    fmi3Status status = instance->unit.refused ? fmi3Discard : fmi3Error;
    if (status == fmi3Error) instance->unit.phase = TERMINATED;
    if (instance->log) instance->log(instance->environment, status, "error", instance->unit.message);
    return status;
}

static fmi3Instance instance_of(fmi3String token, bool exchange, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback log)
{
    if (!token || strcmp(token, model_token) != 0) {
        if (log)
            log(environment, fmi3Error, "error",
                "the instantiation token is not that of the model description");
        return NULL;
    }
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->environment = environment;
    instance->log = log;
    instance->exchange = exchange;
    unit_reset(&instance->unit);
    return instance;
}

FMI3_Export const char *fmi3GetVersion(void) { return "3.0"; }

FMI3_Export fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n,
                                    const fmi3String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi3OK;
}

FMI3_Export fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                               fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return instance_of(token, true, environment, log);
}

FMI3_Export fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean event_mode_used, fmi3Boolean early_return_allowed,
    const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback intermediate)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    (void)required, (void)n, (void)intermediate;
    Instance *instance = instance_of(token, false, environment, log);
    if (!instance) return NULL;
    instance->returns_early = early_return_allowed;
    instance->event_mode = event_mode_used;
    return instance;
}

FMI3_Export fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)environment, (void)log, (void)clock, (void)lock, (void)unlock;
    return NULL;
}

FMI3_Export void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

FMI3_Export fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined,
                                            fmi3Float64 tolerance, fmi3Float64 start,
                                            fmi3Boolean stop_defined, fmi3Float64 stop)
{
    ONLY_IN(c, INSTANTIATED);
    unit_experiment(UNIT(c), tolerance_defined, tolerance, start, stop_defined, stop);
    UNIT(c)->phase = INITIALIZING;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    ONLY_IN(c, INITIALIZING);
    Instance *instance = c;
    bool has_events = instance->exchange || instance->event_mode;
    bool well = unit_start(UNIT(c)) && (!has_events || unit_events_at_start(UNIT(c)));
    UNIT(c)->phase = instance->exchange ? EVENTS : instance->event_mode ? PAUSED : STEPPING;
    return told3(c, well);
}

FMI3_Export fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    ONLY_IN(c, CONTINUOUS | (((Instance *)c)->event_mode ? STEPPING : 0));
    UNIT(c)->phase = ((Instance *)c)->exchange ? EVENTS : PAUSED;
    UNIT(c)->settled = false;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3Terminate(fmi3Instance c)
{
    ONLY_IN(c, RUNNING);
    UNIT(c)->phase = TERMINATED;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3Reset(fmi3Instance c)
{
    unit_reset(UNIT(c));
    return fmi3OK;
}

/* ---- values ------------------------------------------------------------------------------- */

FMI3_Export fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                               fmi3Float64 values[], size_t n_values)
{
    return told3(c, unit_sized(UNIT(c), n_values, n) && unit_get(UNIT(c), r, n, values));
}

FMI3_Export fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                               const fmi3Float64 values[], size_t n_values)
{
    ONLY_IN(c, INSTANTIATED | INITIALIZING | RUNNING);
    return told3(c, unit_sized(UNIT(c), n_values, n) && unit_set(UNIT(c), r, n, values));
}

FMI3_Export fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return told3(c, unit_keep(UNIT(c), state));
}

FMI3_Export fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return told3(c, unit_take_up(UNIT(c), state));
}

FMI3_Export fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    unit_drop(state);
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c, (void)state;
    *size = unit_size();
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[],
                                      size_t size)
{
    return told3(c, unit_write(UNIT(c), state, bytes, size));
}

FMI3_Export fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                        fmi3FMUState *state)
{
    return told3(c, unit_read(UNIT(c), bytes, size, state));
}

static fmi3Status derivative(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                             const fmi3ValueReference knowns[], size_t n_knowns,
                             const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                             size_t n_sensitivity, bool reverse, const char *name)
{
    size_t given = reverse ? n_unknowns : n_knowns, wanted = reverse ? n_knowns : n_unknowns;
    if (!unit_allowed(UNIT(c), EVALUATED, name)) return told3(c, false);
    if (n_seed != given || n_sensitivity != wanted)
        return told3(c, unit_fail(UNIT(c), "%u factors for %u variables, room for %u derivatives "
                                  "of %u", (unsigned)n_seed, (unsigned)given,
                                  (unsigned)n_sensitivity, (unsigned)wanted));
    return told3(c, (reverse ? unit_reverse : unit_forward)(UNIT(c), unknowns, n_unknowns, knowns,
                                                            n_knowns, seed, sensitivity));
}

#define DERIVATIVE(name, reverse)                                                                  \
    FMI3_Export fmi3Status fmi3Get##name##Derivative(                                              \
        fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,                    \
        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],              \
        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity)                            \
    {                                                                                              \
        return derivative(c, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, sensitivity,    \
                          n_sensitivity, reverse, __func__);                                       \
    }

DERIVATIVE(Directional, false)
DERIVATIVE(Adjoint, true)

/* ---- model exchange ----------------------------------------------------------------------- */

FMI3_Export fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needs_update,
                                         fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                                         fmi3Boolean *values_changed, fmi3Boolean *next_defined,
                                         fmi3Float64 *next)
{
    ONLY_IN(c, EVENTS | PAUSED);
    bool well = true;
    if (((Instance *)c)->exchange) {
        well = unit_update(UNIT(c), values_changed, next);
    } else {
        well = unit_resume(UNIT(c), values_changed);
        *next = INFINITY; /* steps find their events themselves */
    }
    *needs_update = *nominals_changed = false;
    *terminate = !well;
    *next_defined = isfinite(*next);
    return told3(c, well);
}

FMI3_Export fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    ONLY_IN(c, EVENTS);
    UNIT(c)->phase = CONTINUOUS;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set_prior,
                                            fmi3Boolean *enter_event_mode, fmi3Boolean *terminate)
{
    ONLY_IN(c, CONTINUOUS);
    bool well = unit_step_completed(UNIT(c), enter_event_mode);
    (void)no_set_prior;
    *terminate = !well;
    return told3(c, well);
}

FMI3_Export fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t)
{
    ONLY_IN(c, CONTINUOUS);
    UNIT(c)->t = t;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n)
{
    ONLY_IN(c, CONTINUOUS);
    if (!unit_sized(UNIT(c), n, N_STATES)) return told3(c, false);
    memcpy(UNIT(c)->x, x, n * sizeof(double));
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 rates[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    return told3(c, unit_sized(UNIT(c), n, N_STATES) && unit_rates(UNIT(c), rates));
}

FMI3_Export fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    return told3(c, unit_sized(UNIT(c), n, N_MARGINS) && unit_watch(UNIT(c), z));
}

FMI3_Export fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    if (!unit_sized(UNIT(c), n, N_STATES) || !unit_start(UNIT(c))) return told3(c, false);
    memcpy(x, UNIT(c)->x, n * sizeof(double));
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    if (!unit_sized(UNIT(c), n, N_STATES)) return told3(c, false);
    memcpy(nominals, state_nominal, n * sizeof(double));
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n)
{
    ONLY_EXCHANGE(c, INSTANTIATED | EVALUATED);
    *n = N_MARGINS;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n)
{
    ONLY_EXCHANGE(c, INSTANTIATED | EVALUATED);
    *n = N_STATES;
    return fmi3OK;
}

/* ---- co-simulation ------------------------------------------------------------------------ */

FMI3_Export fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    ONLY_IN(c, PAUSED);
    UNIT(c)->phase = STEPPING;
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 step,
                           fmi3Boolean no_set_prior, fmi3Boolean *event_needed,
                           fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    ONLY_IN(c, STEPPING);
    const Instance *instance = c;
    Stops stops = instance->returns_early ? EVERYWHERE : instance->event_mode ? AT_POINTS : THROUGH;
    bool moved, event = false, well = unit_step(UNIT(c), t, step, stops, &event);
    (void)no_set_prior;
    *event_needed = event && instance->event_mode;
    *early = event && UNIT(c)->t < t + step;
    if (event && !instance->event_mode) well = unit_resume(UNIT(c), &moved);
    *terminate = !well;
    *reached = UNIT(c)->t;
    return told3(c, well);
}
