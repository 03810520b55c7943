/* Functions of the interface 3.0 for what these models do not have: variables of other types,
   clocks. */
#include "fmi3.h"

/* Of functions for what this model does not have. */
static fmi3Status none(fmi3Instance c, size_t count)
{
    return told3(c, count == 0 || unit_fail(UNIT(c), "all variables are Float64, continuous in time"));
}

static fmi3Status missing(fmi3Instance c)
{
    return told3(c, unit_fail(UNIT(c), "this function is not provided"));
}

#define NO_VALUES(type)                                                                            \
    FMI3_Export fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference r[], size_t n,          \
                                  fmi3##type values[], size_t n_values)                            \
    {                                                                                              \
        (void)r, (void)values, (void)n_values;                                                     \
        return none(c, n);                                                                         \
    }                                                                                              \
    FMI3_Export fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference r[], size_t n,          \
                                  const fmi3##type values[], size_t n_values)                      \
    {                                                                                              \
        (void)r, (void)values, (void)n_values;                                                     \
        return none(c, n);                                                                         \
    }

NO_VALUES(Float32)
NO_VALUES(Int8)
NO_VALUES(UInt8)
NO_VALUES(Int16)
NO_VALUES(UInt16)
NO_VALUES(Int32)
NO_VALUES(UInt32)
NO_VALUES(Int64)
NO_VALUES(UInt64)
NO_VALUES(Boolean)
NO_VALUES(String)

FMI3_Export fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                              size_t sizes[], fmi3Binary values[], size_t n_values)
{
    (void)r, (void)sizes, (void)values, (void)n_values;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                              const size_t sizes[], const fmi3Binary values[], size_t n_values)
{
    (void)r, (void)sizes, (void)values, (void)n_values;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                             fmi3Clock values[])
{
    (void)r, (void)values;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                             const fmi3Clock values[])
{
    (void)r, (void)values;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference r, size_t *n)
{
    (void)r, (void)n;
    return missing(c);
}

FMI3_Export fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                            size_t elements[], fmi3ValueReference independents[],
                                            size_t others[], fmi3DependencyKind kinds[], size_t n)
{
    (void)dependent, (void)elements, (void)independents, (void)others, (void)kinds, (void)n;
    return missing(c);
}

FMI3_Export fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return missing(c); }
FMI3_Export fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return missing(c); }
FMI3_Export fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    ONLY_IN(c, INITIALIZING | EVENTS | PAUSED);
    return fmi3OK;
}

/* ---- clocks: there are none --------------------------------------------------------------- */

FMI3_Export fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                       fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)intervals, (void)qualifiers;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                        fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                        fmi3IntervalQualifier qualifiers[])
{
    (void)r, (void)counters, (void)resolutions, (void)qualifiers;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                    fmi3Float64 shifts[])
{
    (void)r, (void)shifts;
    return none(c, n);
}

FMI3_Export fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                     fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)r, (void)counters, (void)resolutions;
    return none(c, n);
}

#define NO_CLOCK_SETTING(name, of_values, others)                                                  \
    FMI3_Export fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference r[], size_t n,          \
                                  of_values)                                                       \
    {                                                                                              \
        (void)r, others;                                                                           \
        return none(c, n);                                                                         \
    }
#define FRACTION const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]

NO_CLOCK_SETTING(IntervalDecimal, const fmi3Float64 values[], (void)values)
NO_CLOCK_SETTING(ShiftDecimal, const fmi3Float64 values[], (void)values)
NO_CLOCK_SETTING(IntervalFraction, FRACTION, ((void)counters, (void)resolutions))
NO_CLOCK_SETTING(ShiftFraction, FRACTION, ((void)counters, (void)resolutions))

FMI3_Export fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 t)
{
    (void)clock, (void)t;
    return missing(c);
}

FMI3_Export fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                         const fmi3Int32 orders[], fmi3Float64 values[],
                                         size_t n_values)
{
    (void)r, (void)n, (void)orders, (void)values, (void)n_values;
    return missing(c);
}
