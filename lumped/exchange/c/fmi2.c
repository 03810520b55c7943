/* Functional Mock-up Interface 2.0: model exchange and co-simulation. */
#include <stdlib.h>
#include <string.h>
#include "lumped.h"
#include "fmi2Functions.h"

typedef struct {
    Unit unit;
    fmi2CallbackFunctions callbacks;
    char *name;
    fmi2Type type;
} Instance;

#define UNIT(c) (&((Instance *)(c))->unit)

static fmi2Status told(fmi2Component c, bool well)
{
    Instance *instance = c;
    if (well) return fmi2OK;
    fmi2Status status = instance->unit.refused ? fmi2Discard : fmi2Error;
    if (status == fmi2Error) instance->unit.phase = TERMINATED;
    for (char *p = instance->unit.message; *p; p++) /* loggers take it for a format */
        if (*p == '%') *p = ' ';
    if (instance->callbacks.logger) /* not by "%s": many importers read no further arguments */
        instance->callbacks.logger(instance->callbacks.componentEnvironment, instance->name, status,
                                   "error", instance->unit.message);
    return status;
}

#define ONLY_IN(c, phases)                                                                         \
    if (!unit_allowed(UNIT(c), phases, __func__)) return told(c, false)

/* Of functions for model exchange in phases that co-simulation has too. */
#define ONLY_EXCHANGE(c, phases)                                                                   \
    ONLY_IN(c, ((Instance *)c)->type == fmi2ModelExchange ? (phases) : 0)

#define ONLY_AFTER_STEPS(c)                                                                        \
    ONLY_IN(c, ((Instance *)c)->type == fmi2CoSimulation ? STEPPING | TERMINATED : 0)

/* Of functions for what this model does not have. */
static fmi2Status none(fmi2Component c, size_t count)
{
    return told(c, count == 0 || unit_fail(UNIT(c), "all variables are real, continuous in time"));
}

FMI2_Export const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_Export const char *fmi2GetVersion(void) { return "2.0"; }

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                                    const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                   fmi2String resources, const fmi2CallbackFunctions *functions,
                                   fmi2Boolean visible, fmi2Boolean logging)
{
    (void)resources, (void)visible, (void)logging;
    if (!guid || strcmp(guid, model_token) != 0) {
        if (functions && functions->logger)
            functions->logger(functions->componentEnvironment, name, fmi2Error, "error",
                              "the GUID is not that of the model description");
        return NULL;
    }
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    if (functions) instance->callbacks = *functions;
    instance->name = calloc(name ? strlen(name) + 1 : 1, 1);
    if (instance->name && name) strcpy(instance->name, name);
    instance->type = type;
    unit_reset(&instance->unit);
    return instance;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c)
{
    if (c) free(((Instance *)c)->name);
    free(c);
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined,
                                    fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
                                    fmi2Real stop)
{
    ONLY_IN(c, INSTANTIATED);
    unit_experiment(UNIT(c), tolerance_defined, tolerance, start, stop_defined, stop);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ONLY_IN(c, INSTANTIATED);
    UNIT(c)->phase = INITIALIZING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ONLY_IN(c, INITIALIZING);
    bool exchange = ((Instance *)c)->type == fmi2ModelExchange;
    bool well = unit_start(UNIT(c)) && (!exchange || unit_events_at_start(UNIT(c)));
    UNIT(c)->phase = exchange ? EVENTS : STEPPING;
    return told(c, well);
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component c)
{
    ONLY_IN(c, RUNNING);
    UNIT(c)->phase = TERMINATED;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Reset(fmi2Component c)
{
    unit_reset(UNIT(c));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[])
{
    ONLY_IN(c, EVALUATED);
    return told(c, unit_get(UNIT(c), r, n, v));
}

FMI2_Export fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                            const fmi2Real v[])
{
    ONLY_IN(c, INSTANTIATED | INITIALIZING | RUNNING);
    return told(c, unit_set(UNIT(c), r, n, v));
}

#define NO_VALUES(name, type)                                                                      \
    FMI2_Export fmi2Status fmi2Get##name(fmi2Component c, const fmi2ValueReference r[], size_t n,         \
                                  type v[])                                                        \
    {                                                                                              \
        (void)r, (void)v;                                                                          \
        return none(c, n);                                                                         \
    }                                                                                              \
    FMI2_Export fmi2Status fmi2Set##name(fmi2Component c, const fmi2ValueReference r[], size_t n,         \
                                  const type v[])                                                  \
    {                                                                                              \
        (void)r, (void)v;                                                                          \
        return none(c, n);                                                                         \
    }

NO_VALUES(Integer, fmi2Integer)
NO_VALUES(Boolean, fmi2Boolean)
NO_VALUES(String, fmi2String)

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return told(c, unit_keep(UNIT(c), state));
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return told(c, unit_take_up(UNIT(c), state));
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    unit_drop(state);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = unit_size();
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                      size_t size)
{
    return told(c, unit_write(UNIT(c), state, bytes, size));
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                        fmi2FMUstate *state)
{
    return told(c, unit_read(UNIT(c), bytes, size, state));
}

FMI2_Export fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                             size_t unknowns, const fmi2ValueReference known[],
                                             size_t knowns, const fmi2Real seed[],
                                             fmi2Real sensitivity[])
{
    ONLY_IN(c, EVALUATED);
    return told(c, unit_forward(UNIT(c), unknown, unknowns, known, knowns, seed, sensitivity));
}

/* ---- model exchange ----------------------------------------------------------------------- */

FMI2_Export fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ONLY_IN(c, EVENTS | CONTINUOUS);
    UNIT(c)->phase = EVENTS;
    UNIT(c)->settled = false;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    ONLY_IN(c, EVENTS);
    bool moved, well = unit_update(UNIT(c), &moved, &info->nextEventTime);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = !well;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = moved;
    info->nextEventTimeDefined = isfinite(info->nextEventTime);
    return told(c, well);
}

FMI2_Export fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ONLY_IN(c, EVENTS);
    UNIT(c)->phase = CONTINUOUS;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_prior,
                                            fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
{
    ONLY_IN(c, CONTINUOUS);
    bool event, well = unit_step_completed(UNIT(c), &event);
    (void)no_set_prior;
    *enter_event_mode = event;
    *terminate = !well;
    return told(c, well);
}

FMI2_Export fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t)
{
    ONLY_IN(c, EVENTS | CONTINUOUS);
    UNIT(c)->t = t;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    ONLY_IN(c, CONTINUOUS);
    if (!unit_sized(UNIT(c), n, N_STATES)) return told(c, false);
    memcpy(UNIT(c)->x, x, n * sizeof(double));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    return told(c, unit_sized(UNIT(c), n, N_STATES) && unit_rates(UNIT(c), rates));
}

FMI2_Export fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    return told(c, unit_sized(UNIT(c), n, N_MARGINS) && unit_watch(UNIT(c), z));
}

FMI2_Export fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    ONLY_EXCHANGE(c, EVALUATED);
    if (!unit_sized(UNIT(c), n, N_STATES) || !unit_start(UNIT(c))) return told(c, false);
    memcpy(x, UNIT(c)->x, n * sizeof(double));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n)
{
    ONLY_EXCHANGE(c, INSTANTIATED | EVALUATED);
    if (!unit_sized(UNIT(c), n, N_STATES)) return told(c, false);
    memcpy(nominals, state_nominal, n * sizeof(double));
    return fmi2OK;
}

/* ---- co-simulation ------------------------------------------------------------------------ */

FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real step, fmi2Boolean no_set_prior)
{
    ONLY_IN(c, STEPPING);
    (void)no_set_prior;
    return told(c, unit_step(UNIT(c), t, step, THROUGH, NULL));
}

FMI2_Export fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                            const fmi2Integer order[], const fmi2Real v[])
{
    (void)r, (void)order, (void)v;
    return told(c, n == 0 || unit_fail(UNIT(c), "inputs are constant within a step"));
}

FMI2_Export fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[],
                                             size_t n, const fmi2Integer order[], fmi2Real v[])
{
    (void)r, (void)order, (void)v;
    return told(c, n == 0 || unit_fail(UNIT(c), "derivatives of outputs are not provided"));
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component c)
{
    return told(c, unit_fail(UNIT(c), "a step is over when its function returns"));
}

FMI2_Export fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    ONLY_AFTER_STEPS(c);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = UNIT(c)->t;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    ONLY_AFTER_STEPS(c);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

#define NO_STATUS(name, type)                                                                      \
    FMI2_Export fmi2Status fmi2Get##name(fmi2Component c, const fmi2StatusKind kind, type *value)         \
    {                                                                                              \
        ONLY_AFTER_STEPS(c);                                                                       \
        (void)kind, (void)value;                                                                   \
        return fmi2Discard;                                                                        \
    }

NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)
