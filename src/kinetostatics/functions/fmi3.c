
typedef void *fmi3Instance;
typedef uint32_t fmi3ValueReference;
typedef const char *fmi3String;

FMI fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, bool visible, bool logging, bool events, bool early,
    const fmi3ValueReference intermediate[], size_t count, void *environment, void *log, void *update)
{ return instantiate(token); }

FMI fmi3Instance fmi3InstantiateModelExchange(
    fmi3String name, fmi3String token, fmi3String resources, bool visible, bool logging, void *environment, void *log)
{ return NULL; }

FMI fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, bool visible, bool logging, void *environment, void *log,
    void *update, void *lock, void *unlock)
{ return NULL; }

FMI fmi3Status fmi3EnterInitializationMode(
    fmi3Instance r, bool has_tolerance, double tolerance, double time, bool has_end, double end)
{
    ((robot *)r)->time = time;
    return fmi3OK;
}

FMI fmi3Status fmi3DoStep(
    fmi3Instance instance, double time, double step, bool is_final, bool *event, bool *terminate, bool *early, double *last)
{
    robot *r = instance;
    r->time = time + step;
    compute(r);
    *event = *terminate = *early = false;
    *last = r->time;
    return fmi3OK;
}

FMI fmi3Status fmi3GetFloat64(fmi3Instance r, const fmi3ValueReference refs[], size_t n, double values[], size_t size)
{ return n <= size && get(r, refs, n, values) ? fmi3OK : fmi3Error; }

FMI fmi3Status fmi3SetFloat64(fmi3Instance r, const fmi3ValueReference refs[], size_t n, const double values[], size_t size)
{ return n <= size && set(r, refs, n, values) ? fmi3OK : fmi3Error; }

FMI fmi3Status fmi3GetInt32(fmi3Instance r, const fmi3ValueReference refs[], size_t n, int32_t values[], size_t size)
{ return n <= size && get_status(r, refs, n, values) ? fmi3OK : fmi3Error; }

/* Other functions of the standard: modes without meaning here, and types of variables that do not exist. */
MODE(fmi3EnterEventMode) MODE(fmi3EnterConfigurationMode) MODE(fmi3ExitConfigurationMode)
MODE(fmi3EvaluateDiscreteStates) MODE(fmi3EnterStepMode)

#define VALUES(name) \
    FMI fmi3Status name(fmi3Instance r, const fmi3ValueReference refs[], size_t n, void *values, size_t size) \
    { return n ? fmi3Error : fmi3OK; }
#define CLOCKS(name) \
    FMI fmi3Status name(fmi3Instance r, const fmi3ValueReference refs[], size_t n, void *first, void *second, void *third) \
    { return n ? fmi3Error : fmi3OK; }
VALUES(fmi3GetFloat32) VALUES(fmi3GetInt8) VALUES(fmi3GetUInt8) VALUES(fmi3GetInt16) VALUES(fmi3GetUInt16) VALUES(fmi3GetUInt32)
VALUES(fmi3GetInt64) VALUES(fmi3GetUInt64) VALUES(fmi3GetBoolean) VALUES(fmi3GetString) VALUES(fmi3SetFloat32)
VALUES(fmi3SetInt8) VALUES(fmi3SetUInt8) VALUES(fmi3SetInt16) VALUES(fmi3SetUInt16) VALUES(fmi3SetInt32) VALUES(fmi3SetUInt32)
VALUES(fmi3SetInt64) VALUES(fmi3SetUInt64) VALUES(fmi3SetBoolean) VALUES(fmi3SetString)
CLOCKS(fmi3GetBinary) CLOCKS(fmi3SetBinary) CLOCKS(fmi3GetClock) CLOCKS(fmi3SetClock) CLOCKS(fmi3GetIntervalDecimal)
CLOCKS(fmi3GetIntervalFraction) CLOCKS(fmi3GetShiftDecimal) CLOCKS(fmi3GetShiftFraction) CLOCKS(fmi3SetIntervalDecimal)
CLOCKS(fmi3SetIntervalFraction) CLOCKS(fmi3SetShiftDecimal) CLOCKS(fmi3SetShiftFraction) CLOCKS(fmi3GetOutputDerivatives)

FMI fmi3Status fmi3UpdateDiscreteStates(
    fmi3Instance r, bool *again, bool *terminate, bool *nominals, bool *values, bool *defined, double *next)
{
    *again = *terminate = *nominals = *values = *defined = false;
    return fmi3OK;
}

FMI fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance r, fmi3ValueReference ref, size_t *n) { return fmi3Error; }

FMI fmi3Status fmi3GetVariableDependencies(
    fmi3Instance r, fmi3ValueReference ref, size_t a[], fmi3ValueReference b[], size_t c[], void *kinds, size_t n)
{ return fmi3Error; }

#define DERIVATIVE(name) \
    FMI fmi3Status name(fmi3Instance r, const fmi3ValueReference a[], size_t n, const fmi3ValueReference b[], size_t m, \
        const double seed[], size_t ns, double result[], size_t nr) \
    { return fmi3Error; }
DERIVATIVE(fmi3GetDirectionalDerivative) DERIVATIVE(fmi3GetAdjointDerivative)

/* Functions of other kinds of simulation, which must exist. */
MODE(fmi3EnterContinuousTimeMode)

FMI fmi3Status fmi3CompletedIntegratorStep(fmi3Instance r, bool final, bool *event, bool *terminate) { return fmi3Error; }

FMI fmi3Status fmi3ActivateModelPartition(fmi3Instance r, fmi3ValueReference clock, double time) { return fmi3Error; }

FMI fmi3Status fmi3SetTime(fmi3Instance r, double time) { return fmi3Error; }

#define NUMBERS(name) FMI fmi3Status name(fmi3Instance r, double a[], size_t n) { return fmi3Error; }
#define COUNT(name) FMI fmi3Status name(fmi3Instance r, size_t *n) { *n = 0; return fmi3OK; }
NUMBERS(fmi3SetContinuousStates) NUMBERS(fmi3GetContinuousStateDerivatives) NUMBERS(fmi3GetEventIndicators)
NUMBERS(fmi3GetContinuousStates) NUMBERS(fmi3GetNominalsOfContinuousStates)
COUNT(fmi3GetNumberOfEventIndicators) COUNT(fmi3GetNumberOfContinuousStates)
