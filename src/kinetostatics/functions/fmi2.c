
typedef const unsigned Refs[];

FMI const char *fmi2GetTypesPlatform(void) { return "default"; }

FMI void *fmi2Instantiate(
    const char *name, int type, const char *token, const char *resources, const void *functions, int visible, int logging)
{ return type == 1 ? instantiate(token) : NULL; /* 1: co-simulation */ }

FMI fmi2Status fmi2SetupExperiment(void *r, int has_tolerance, double tolerance, double time, int has_end, double end)
{
    ((robot *)r)->time = time;
    return fmi2OK;
}

FMI fmi2Status fmi2DoStep(void *r, double time, double step, int is_final)
{
    ((robot *)r)->time = time + step;
    compute(r);
    return fmi2OK;
}

FMI fmi2Status fmi2GetReal(void *r, Refs refs, size_t n, double values[]) { return get(r, refs, n, values) ? fmi2OK : fmi2Error; }
FMI fmi2Status fmi2SetReal(void *r, Refs refs, size_t n, const double values[])
{ return set(r, refs, n, values) ? fmi2OK : fmi2Error; }
FMI fmi2Status fmi2GetInteger(void *r, Refs refs, size_t n, int values[])
{ return get_status(r, refs, n, values) ? fmi2OK : fmi2Error; }

/* Other functions of the standard: modes without meaning here, and what the model does not have. */
#define VALUES(name) FMI fmi2Status name(void *r, Refs refs, size_t n, void *values) { return n ? fmi2Error : fmi2OK; }
#define ORDERS(name) \
    FMI fmi2Status name(void *r, Refs refs, size_t n, const int orders[], void *values) { return n ? fmi2Error : fmi2OK; }
#define ASKED(name) FMI fmi2Status name(void *r, int kind, void *value) { return fmi2Discard; }
MODE(fmi2EnterInitializationMode) MODE(fmi2CancelStep)
VALUES(fmi2GetBoolean) VALUES(fmi2GetString) VALUES(fmi2SetInteger) VALUES(fmi2SetBoolean) VALUES(fmi2SetString)
ORDERS(fmi2SetRealInputDerivatives) ORDERS(fmi2GetRealOutputDerivatives)
ASKED(fmi2GetStatus) ASKED(fmi2GetRealStatus) ASKED(fmi2GetIntegerStatus) ASKED(fmi2GetBooleanStatus) ASKED(fmi2GetStringStatus)

FMI fmi2Status fmi2GetDirectionalDerivative(void *r, Refs a, size_t n, Refs b, size_t m, const double seed[], double result[])
{ return fmi2Error; }
