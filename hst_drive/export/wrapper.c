/* The functions of FMI 2.0 for co-simulation, about one drive.
   Copyright 2026 hst_drive contributors
   SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#define API __attribute__((visibility("default")))
#define FIRST_OUTPUT 100
#define FIRST_PARAMETER 1000

typedef enum { OK, WARNING, DISCARD, ERROR_, FATAL, PENDING } Status;
typedef unsigned int Reference;
typedef void (*Logger)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, Status);
    void *environment;
} Callbacks;

/* What a step changes; a copy of it is a saved state. */
typedef struct {
    double state[STATES], inputs[INPUTS], outputs[OUTPUTS], factors[FACTORS], p[PARAMETERS];
    unsigned long layout[LAYOUT];
} Kept;

typedef struct {
    Kept now;
    Callbacks calls;
    char *name;
} Drive;

static Status say(Drive *drive, const char *text)
{
    if (drive->calls.logger)
        drive->calls.logger(drive->calls.environment, drive->name, ERROR_, "error", "%s", text);
    return ERROR_;
}

static void begin(Drive *drive)
{
    int i;
    memcpy(drive->now.state, FIRST_STATE, sizeof FIRST_STATE);
    memcpy(drive->now.inputs, FIRST_INPUTS, sizeof FIRST_INPUTS);
    memcpy(drive->now.p, BASE, sizeof BASE);
    memcpy(drive->now.layout, FIRST_LAYOUT, sizeof FIRST_LAYOUT);
    for (i = 0; i < FACTORS; i++)
        drive->now.factors[i] = 1.0;
    memset(drive->now.outputs, 0, sizeof drive->now.outputs);
}

/* Move the drive on with its inputs held; its outputs are those at the end. */
static int advance(Drive *drive, double duration)
{
    Kept *now = &drive->now;
    double time[2] = {0.0, duration}, twice[INPUTS][2], ratio[2], angle[2] = {NAN, NAN};
    double p[PARAMETERS], out[2 * OUTPUTS];
    int i;
    for (i = 0; i < INPUTS; i++)
        twice[i][0] = twice[i][1] = now->inputs[i];
    ratio[0] = ratio[1] = viscosity_ratio_at(now->inputs[2]);
    memcpy(p, now->p, sizeof p);
    for (i = 0; i < FACTORS; i++)
        p[FACTOR_OF[i]] *= now->factors[i];
    simulate(time, twice[0], twice[1], twice[2], ratio, twice[3], angle, now->state, p, ON, CELLS,
             now->layout, MAX_STEP, out);
    memcpy(now->outputs, out + OUTPUTS, sizeof now->outputs);
    for (i = 0; i < OUTPUTS; i++)
        if (isnan(now->outputs[i]))
            return 0;
    return 1;
}

static double *place(Drive *drive, Reference reference)
{
    Kept *now = &drive->now;
    if (reference < INPUTS)
        return now->inputs + reference;
    if (reference >= FIRST_OUTPUT && reference < FIRST_OUTPUT + OUTPUTS)
        return now->outputs + (reference - FIRST_OUTPUT);
    if (reference >= FIRST_PARAMETER && reference < FIRST_PARAMETER + FACTORS)
        return now->factors + (reference - FIRST_PARAMETER);
    reference -= FIRST_PARAMETER + FACTORS;
    return reference < PARAMETERS - NUMBERS ? now->p + NUMBERS + reference : NULL;
}

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API Status fmi2SetDebugLogging(void *d, int on, size_t n, const char *const *c) { return OK; }

API void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                          const Callbacks *calls, int visible, int logging)
{
    Drive *drive;
    if (kind != 1 || strcmp(guid, GUID) || !(drive = calloc(1, sizeof *drive)))
        return NULL;
    drive->calls = *calls;
    drive->name = malloc(strlen(name) + 1);
    if (!drive->name) {
        free(drive);
        return NULL;
    }
    strcpy(drive->name, name);
    begin(drive);
    return drive;
}

API void fmi2FreeInstance(Drive *drive)
{
    if (!drive)
        return;
    free(drive->name);
    free(drive);
}

API Status fmi2SetupExperiment(void *d, int t, double tolerance, double s, int e, double stop)
{
    return OK;
}
API Status fmi2EnterInitializationMode(void *d) { return OK; }

API Status fmi2ExitInitializationMode(Drive *drive)
{
    Kept first = drive->now;
    int found = advance(drive, 1e-9);
    memcpy(drive->now.state, first.state, sizeof first.state);
    return found ? OK : say(drive, "the drive has no start with these parameters");
}

API Status fmi2Terminate(void *d) { return OK; }
API Status fmi2Reset(Drive *drive) { begin(drive); return OK; }

API Status fmi2GetReal(Drive *drive, const Reference *which, size_t count, double *values)
{
    size_t i;
    for (i = 0; i < count; i++) {
        double *found = place(drive, which[i]);
        if (!found)
            return say(drive, "asked for a variable that the model has not");
        values[i] = *found;
    }
    return OK;
}

API Status fmi2SetReal(Drive *drive, const Reference *which, size_t count, const double *values)
{
    size_t i;
    for (i = 0; i < count; i++) {
        double *found = place(drive, which[i]);
        if (!found || (which[i] >= FIRST_OUTPUT && which[i] < FIRST_PARAMETER))
            return say(drive, "told a variable that is no input and no parameter");
        if (!isfinite(values[i]))
            return say(drive, "told a value that is no number");
        *found = values[i];
    }
    return OK;
}

API Status fmi2DoStep(Drive *drive, double now, double step, int no_return)
{
    if (!(step > 0.0))
        return say(drive, "a step must take time");
    return advance(drive, step) ? OK : say(drive, "the drive left all bounds");
}

API Status fmi2GetFMUstate(Drive *drive, void **state)
{
    if (!*state && !(*state = malloc(sizeof(Kept))))
        return ERROR_;
    memcpy(*state, &drive->now, sizeof(Kept));
    return OK;
}
API Status fmi2SetFMUstate(Drive *drive, void *state)
{
    memcpy(&drive->now, state, sizeof(Kept));
    return OK;
}
API Status fmi2FreeFMUstate(void *d, void **state) { free(*state); *state = NULL; return OK; }
API Status fmi2SerializedFMUstateSize(void *d, void *s, size_t *n) { *n = sizeof(Kept); return OK; }
API Status fmi2SerializeFMUstate(void *d, void *state, char *bytes, size_t n)
{
    return n < sizeof(Kept) ? ERROR_ : (memcpy(bytes, state, sizeof(Kept)), OK);
}
API Status fmi2DeSerializeFMUstate(void *d, const char *bytes, size_t n, void **state)
{
    if (n < sizeof(Kept) || (!*state && !(*state = malloc(sizeof(Kept)))))
        return ERROR_;
    memcpy(*state, bytes, sizeof(Kept));
    return OK;
}

/* The model has real variables alone, and no derivatives. */
#define NONE(name, kind) API Status name(void *d, const Reference *r, size_t n, kind *v) \
    { return n ? ERROR_ : OK; }
NONE(fmi2GetInteger, int)
NONE(fmi2SetInteger, const int)
NONE(fmi2GetBoolean, int)
NONE(fmi2SetBoolean, const int)
NONE(fmi2GetString, const char *)
NONE(fmi2SetString, const char *const)
API Status fmi2SetRealInputDerivatives(void *d, const Reference *r, size_t n, const int *o,
                                       const double *v) { return ERROR_; }
API Status fmi2GetRealOutputDerivatives(void *d, const Reference *r, size_t n, const int *o,
                                        double *v) { return ERROR_; }
API Status fmi2GetDirectionalDerivative(void *d, const Reference *u, size_t n, const Reference *k,
                                        size_t m, const double *dk, double *du) { return ERROR_; }
API Status fmi2CancelStep(void *d) { return ERROR_; }
API Status fmi2GetStatus(void *d, int kind, Status *v) { return DISCARD; }
API Status fmi2GetRealStatus(void *d, int kind, double *v) { return DISCARD; }
API Status fmi2GetIntegerStatus(void *d, int kind, int *v) { return DISCARD; }
API Status fmi2GetBooleanStatus(void *d, int kind, int *v) { return DISCARD; }
API Status fmi2GetStringStatus(void *d, int kind, const char **v) { return DISCARD; }
