/* FMI MAJOR.0 co-simulation of ROBOT.h. Written by kinetostatics. */
#include "ROBOT.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
#ifdef _WIN32
#define FMI __declspec(dllexport)
#else
#define FMI
#endif

/* Value references: 0 time, 1 ... inputs, then outputs and status, in the order of the structures of ROBOT.h. */
enum { INPUT_COUNT = INPUTS, OUTPUT_COUNT = OUTPUTS };

typedef struct {
    ROBOT_state state;
    ROBOT_input input;
    ROBOT_output output;
    double time;
    int32_t status;
    bool is_new; /* inputs have changed since the outputs were computed */
} robot;

static void compute(robot *r)
{
    if (r->is_new) r->status = ROBOT_evaluate(&r->input, &r->state, &r->output);
    r->is_new = false;
}

static const double START[INPUT_COUNT] = {VALUES_AT_START};

static void start(robot *r)
{
    memset(r, 0, sizeof *r);
    ROBOT_start(&r->state);
    memcpy(&r->input, START, sizeof START);
    r->is_new = true;
}

static robot *instantiate(const char *token)
{
    robot *r = token && strcmp(token, "TOKEN") == 0 ? malloc(sizeof *r) : NULL;
    if (r) start(r);
    return r;
}

/* The values of variables; returns whether all references are valid. */
static bool get(robot *r, const uint32_t refs[], size_t n, double values[])
{
    size_t k;
    compute(r);
    for (k = 0; k < n; ++k) {
        const uint32_t ref = refs[k];
        if (ref > INPUT_COUNT + OUTPUT_COUNT) return false;
        values[k] = ref == 0 ? r->time : ref <= INPUT_COUNT ? ((const double *)&r->input)[ref - 1]
                                                            : ((const double *)&r->output)[ref - 1 - INPUT_COUNT];
    }
    return true;
}

/* Set inputs; returns whether all references are valid. */
static bool set(robot *r, const uint32_t refs[], size_t n, const double values[])
{
    size_t k;
    for (k = 0; k < n; ++k) {
        if (refs[k] < 1 || refs[k] > INPUT_COUNT) return false;
        ((double *)&r->input)[refs[k] - 1] = values[k];
        r->is_new = true;
    }
    return true;
}

static bool get_status(robot *r, const uint32_t refs[], size_t n, int32_t values[])
{
    compute(r);
    if (n == 1) values[0] = r->status;
    return n == 0 || (n == 1 && refs[0] == INPUT_COUNT + OUTPUT_COUNT + 1);
}

/* Copy a state to memory that is allocated if *copy is null; returns whether there was enough. */
static bool keep(const void *from, void **copy)
{
    if (!*copy) *copy = malloc(sizeof(robot));
    if (*copy) memcpy(*copy, from, sizeof(robot));
    return *copy != NULL;
}

typedef enum { fmiMAJOROK, fmiMAJORWarning, fmiMAJORDiscard, fmiMAJORError, fmiMAJORFatal } fmiMAJORStatus;

FMI const char *fmiMAJORGetVersion(void) { return "MAJOR.0"; }

FMI void fmiMAJORFreeInstance(void *r) { free(r); }

FMI fmiMAJORStatus fmiMAJORReset(void *r)
{
    start(r);
    return fmiMAJOROK;
}

FMI fmiMAJORStatus fmiMAJORGetSTATE(void *r, void **copy) { return keep(r, copy) ? fmiMAJOROK : fmiMAJORError; }

FMI fmiMAJORStatus fmiMAJORSetSTATE(void *r, void *copy) { return keep(copy, &r) ? fmiMAJOROK : fmiMAJORError; }

FMI fmiMAJORStatus fmiMAJORFreeSTATE(void *r, void **copy)
{
    free(*copy);
    *copy = NULL;
    return fmiMAJOROK;
}

FMI fmiMAJORStatus fmiMAJORSerializedSTATESize(void *r, void *copy, size_t *size)
{
    *size = sizeof(robot);
    return fmiMAJOROK;
}

FMI fmiMAJORStatus fmiMAJORSerializeSTATE(void *r, void *copy, void *bytes, size_t size)
{
    if (size != sizeof(robot)) return fmiMAJORError;
    memcpy(bytes, copy, size);
    return fmiMAJOROK;
}

FMI fmiMAJORStatus fmiMAJORDESERIALIZE(void *r, const void *bytes, size_t size, void **copy)
{ return size == sizeof(robot) && keep(bytes, copy) ? fmiMAJOROK : fmiMAJORError; }

FMI fmiMAJORStatus fmiMAJORSetDebugLogging(void *r, BOOLEAN on, size_t n, const char *const categories[]) { return fmiMAJOROK; }

/* Modes without meaning here. */
#define MODE(name) FMI fmiMAJORStatus name(void *r) { return fmiMAJOROK; }
MODE(fmiMAJORExitInitializationMode) MODE(fmiMAJORTerminate)
