/* Slider-crank of `saw-500rpm` as an FMU of FMI 2.0: co-simulation by the midpoint rule, a step each communication
   step, and model exchange. The state is the slider's place; the instantiation token (guid) names the planted fault. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef int Status; /* OK, Warning, Discard, Error */
typedef struct {
    void (*logger)(void *, const char *, Status, const char *, const char *, ...);
} Callbacks;
typedef struct {
    int newDiscreteStatesNeeded, terminate, nominalsChanged, valuesChanged, nextDefined;
    double next;
} EventInfo;
typedef struct {
    double time, place;
    const char *fault;
    const Callbacks *callbacks;
} Machine;

/* The token of the machine without a fault, as generators compile theirs in. */
const char TOKEN[] = "none";

static const double SPEED = 500.0 * 3.14159265358979323846 / 30.0, CRANK = 0.1, ROD = 0.3, OFFSET = 0.09;

static int is(const Machine *m, const char *fault) { return strcmp(m->fault, fault) == 0; }

static double velocity(double time) {
    double angle = SPEED * time, up = CRANK * sin(angle) - OFFSET, reach = sqrt(ROD * ROD - up * up);
    return CRANK * SPEED * (up / reach * cos(angle) - sin(angle));
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, const Callbacks *c, int v, int l) {
    Machine *m = calloc(1, sizeof *m);
    m->fault = strdup(guid), m->callbacks = c;
    return m;
}
void fmi2FreeInstance(Machine *m) { free(m); }

Status fmi2DoStep(Machine *m, double time, double step, int keep) {
    int late = m->time > 0.03;
    if (is(m, "segfault") && late) *(volatile int *)0 = 1;
    if (is(m, "fork") && late) { if (fork()) abort(); for (;;) pause(); }
    if (is(m, "stray") && late) for (int file = 3; file < 100; file++) if (write(file, "a line of a log\n", 16) < 0) continue;
    while (is(m, "hang") && late) {}
    if (is(m, "error") && late) {
        m->callbacks->logger(m, "machine", 3, "logStatusError", "the crank is stuck");
        return 3;
    }
    m->place += step * velocity(m->time + 0.5 * step), m->time = time + step;
    if (is(m, "nan") && late) m->place = NAN;
    return 0;
}

/* 0: place [mm], 1: height [m], 2: velocity [m/s], 3: crank [deg] */
Status fmi2GetReal(Machine *m, const unsigned *vr, size_t n, double *values) {
    for (size_t i = 0; i < n; i++) {
        /* late: by half a step of a thousandth of a turn */
        double now = velocity(m->time), place = m->place - (is(m, "late") ? 6e-5 * now : 0.0);
        double all[] = {1e3 * place, 0.0, now, SPEED * m->time * 57.295779513082320877};
        values[i] = all[vr[i] & 3];
    }
    return 0;
}

/* -- model exchange -- */
Status fmi2SetTime(Machine *m, double time) { return m->time = time, 0; }
Status fmi2SetContinuousStates(Machine *m, const double *x, size_t n) { return m->place = x[0], 0; }
Status fmi2GetContinuousStates(Machine *m, double *x, size_t n) { return x[0] = m->place, 0; }
Status fmi2GetDerivatives(Machine *m, double *dx, size_t n) { return dx[0] = velocity(m->time), 0; }
Status fmi2GetNominalsOfContinuousStates(Machine *m, double *x, size_t n) { return x[0] = 0.1, 0; }
Status fmi2NewDiscreteStates(Machine *m, EventInfo *info) { return memset(info, 0, sizeof *info), 0; }
Status fmi2CompletedIntegratorStep(Machine *m, int keep, int *event, int *end) { return *event = *end = 0, 0; }

/* -- what is not used, but must be there -- */
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
#define UNUSED(name) Status fmi2##name() { return 0; }
UNUSED(SetDebugLogging) UNUSED(SetupExperiment) UNUSED(EnterInitializationMode) UNUSED(ExitInitializationMode)
UNUSED(Terminate) UNUSED(Reset) UNUSED(GetInteger) UNUSED(GetBoolean) UNUSED(GetString) UNUSED(SetReal)
UNUSED(SetInteger) UNUSED(SetBoolean) UNUSED(SetString) UNUSED(GetFMUstate) UNUSED(SetFMUstate) UNUSED(FreeFMUstate)
UNUSED(SerializedFMUstateSize) UNUSED(SerializeFMUstate) UNUSED(DeSerializeFMUstate) UNUSED(GetDirectionalDerivative)
UNUSED(SetRealInputDerivatives) UNUSED(GetRealOutputDerivatives) UNUSED(CancelStep) UNUSED(GetStatus)
UNUSED(GetRealStatus) UNUSED(GetIntegerStatus) UNUSED(GetBooleanStatus) UNUSED(GetStringStatus)
UNUSED(EnterEventMode) UNUSED(EnterContinuousTimeMode) UNUSED(GetEventIndicators)
