/* The exact motion of a machine as an FMU 3.0, for co-simulation and model exchange. SPDX-License-Identifier: MIT
 *
 * The same file for all machines; motion_table.h holds the machine: polynomials in the crank angle, which is
 * start_angle + speed x time. Nothing is integrated, so there are no states, and steps may be of any size.
 * C99 with the standard library alone; the few names of the FMI standard that it takes are declared here.
 */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "motion_table.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* -- names of the standard -------------------------------------------------------------------------------------- */

enum { FMI_OK = 0, FMI_ERROR = 3 };

typedef uint32_t Reference; /* to the value of a variable */
typedef void (*LogMessage)(void *environment, int status, const char *category, const char *message);

/* References: these, then of each column its value, its first and its second derivative by time. */
enum { TIME, SPEED, START_ANGLE, CRANK_ANGLE, FIRST_COLUMN };

#define QUANTITIES 3
/* An angle this close to a knot counts as the knot, so that rounding cannot choose the side; conrod's width. */
#define BREAK_WIDTH 1e-9 /* [rad] */
#define LARGEST_ANGLE 1e9 /* [rad], of a machine that turns: beyond, rounding of the angle would be seen */
/* 2 pi in two parts [rad], the first of 26 bits, so that its product with whole turns is exact. */
#define TURN_HIGH 6.283185362815857
#define TURN_LOW -5.5636270456668466e-08

typedef struct {
    double time;        /* [s] */
    double speed;       /* [rad/s] */
    double start_angle; /* [rad] */
    bool started;       /* after initialization, when parameters are fixed */
    void *environment;
    LogMessage log;
} Instance;

/* -- the motion -------------------------------------------------------------------------------------------------- */

static int failed(const Instance *instance, const char *format, ...) {
    char message[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    if (instance->log) instance->log(instance->environment, FMI_ERROR, "logStatusError", message);
    return FMI_ERROR;
}

/* floor(), which elsewhere needs a library of its own. */
static double whole_part(double value) {
    const double cut = (double)(int64_t)value;
    return cut > value ? cut - 1.0 : cut;
}

/* Where the crank is: the interval of the table (at a knot the one that the crank turns into), and whole periods. */
typedef struct {
    double offset; /* [rad], from the middle of the interval */
    double periods;
    int interval;
} Place;

static double crank_angle(const Instance *instance) {
    return instance->start_angle + instance->speed * instance->time;
}

static bool located(const Instance *instance, Place *place) {
    const double angle = crank_angle(instance);
    const double first = TURNS ? -LARGEST_ANGLE : knots[0], last = TURNS ? LARGEST_ANGLE : knots[INTERVALS];
    if (!(angle >= first - BREAK_WIDTH && angle <= last + BREAK_WIDTH)) {
        failed(instance, "crank angle %.9g rad is out of range, %.9g to %.9g rad", angle, first, last);
        return false;
    }
    place->periods = TURNS ? whole_part(angle / (TURNS * (TURN_HIGH + TURN_LOW))) : 0.0;
    const double within = (angle - place->periods * TURNS * TURN_HIGH) - place->periods * TURNS * TURN_LOW;
    const double seen = within + (instance->speed < 0.0 ? -BREAK_WIDTH : BREAK_WIDTH);
    int low = 0, high = INTERVALS;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (seen < knots[middle]) high = middle;
        else low = middle;
    }
    place->interval = low;
    place->offset = within - 0.5 * (knots[low] + knots[low + 1]);
    return true;
}

/* A column's value (quantity 0), rate (1) or acceleration (2), by Horner's rule and the chain rule. */
static double column_value(const Place *place, int column, int quantity, double speed) {
    const double *coefficient = coefficients[place->interval][column];
    double value = 0.0, rate = 0.0, second = 0.0;
    for (int k = ORDER; k >= 0; k--) {
        second = second * place->offset + rate;
        rate = rate * place->offset + value;
        value = value * place->offset + coefficient[k];
    }
    if (quantity == 0) return value + place->periods * gains[column];
    return quantity == 1 ? rate * speed : 2.0 * second * speed * speed;
}

/* -- instances --------------------------------------------------------------------------------------------------- */

static void reset(Instance *instance) {
    instance->time = 0.0;
    instance->speed = DEFAULT_SPEED;
    instance->start_angle = 0.0;
    instance->started = false;
}

static void *instantiated(const char *token, void *environment, LogMessage log) {
    Instance stillborn = {0}, *instance;
    stillborn.environment = environment;
    stillborn.log = log;
    if (!token || strcmp(token, INSTANTIATION_TOKEN) != 0) {
        failed(&stillborn, "the instantiation token is not that of this FMU, %s", INSTANTIATION_TOKEN);
        return NULL;
    }
    instance = malloc(sizeof *instance);
    if (!instance) return NULL;
    *instance = stillborn;
    reset(instance);
    return instance;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible,
                                          bool logging, void *environment, LogMessage log) {
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiated(token, environment, log);
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                         bool logging, bool event_mode, bool early_return,
                                         const Reference intermediate[], size_t count, void *environment,
                                         LogMessage log, void *update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early_return;
    (void)intermediate, (void)count, (void)update;
    return instantiated(token, environment, log);
}

EXPORT void fmi3FreeInstance(void *instance) { free(instance); }

EXPORT int fmi3Reset(void *instance) {
    reset(instance);
    return FMI_OK;
}

EXPORT int fmi3EnterInitializationMode(Instance *instance, bool tolerance_defined, double tolerance, double start,
                                       bool stop_defined, double stop) {
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    instance->time = start;
    return FMI_OK;
}

EXPORT int fmi3ExitInitializationMode(Instance *instance) {
    instance->started = true;
    return FMI_OK;
}

/* -- variables --------------------------------------------------------------------------------------------------- */

EXPORT int fmi3GetFloat64(Instance *instance, const Reference references[], size_t count, double values[],
                          size_t value_count) {
    Place place;
    bool known = false;
    if (count != value_count) return failed(instance, "as many values as variables are asked for");
    for (size_t k = 0; k < count; k++) {
        const Reference at = references[k];
        if (at == TIME) values[k] = instance->time;
        else if (at == SPEED) values[k] = instance->speed;
        else if (at == START_ANGLE) values[k] = instance->start_angle;
        else if (at == CRANK_ANGLE) values[k] = crank_angle(instance);
        else if (at >= FIRST_COLUMN + QUANTITIES * COLUMNS)
            return failed(instance, "there is no variable %u", (unsigned)at);
        else {
            const int output = (int)(at - FIRST_COLUMN);
            if (!known && !(known = located(instance, &place))) return FMI_ERROR;
            values[k] = column_value(&place, output / QUANTITIES, output % QUANTITIES, instance->speed);
        }
    }
    return FMI_OK;
}

EXPORT int fmi3SetFloat64(Instance *instance, const Reference references[], size_t count, const double values[],
                          size_t value_count) {
    if (count != value_count) return failed(instance, "as many values as variables are asked for");
    for (size_t k = 0; k < count; k++) {
        double *parameter = references[k] == SPEED         ? &instance->speed
                            : references[k] == START_ANGLE ? &instance->start_angle
                                                           : NULL;
        if (!parameter) return failed(instance, "variable %u is no parameter", (unsigned)references[k]);
        if (instance->started) return failed(instance, "parameters are fixed after initialization");
        if (!isfinite(values[k])) return failed(instance, "a parameter of %g is no finite number", values[k]);
        *parameter = values[k];
    }
    return FMI_OK;
}

/* -- time -------------------------------------------------------------------------------------------------------- */

EXPORT int fmi3SetTime(Instance *instance, double time) {
    instance->time = time;
    return FMI_OK;
}

EXPORT int fmi3DoStep(Instance *instance, double time, double step, bool no_return, bool *event, bool *terminate,
                      bool *early, double *reached) {
    Place place;
    (void)no_return;
    instance->time = time + step;
    *event = *terminate = *early = false;
    *reached = instance->time;
    return located(instance, &place) ? FMI_OK : FMI_ERROR;
}

EXPORT int fmi3UpdateDiscreteStates(Instance *instance, bool *again, bool *terminate, bool *nominals, bool *values,
                                    bool *next_defined, double *next) {
    (void)instance;
    *again = *terminate = *nominals = *values = *next_defined = false;
    *next = 0.0;
    return FMI_OK;
}

EXPORT int fmi3CompletedIntegratorStep(Instance *instance, bool no_return, bool *event, bool *terminate) {
    (void)instance, (void)no_return;
    *event = *terminate = false;
    return FMI_OK;
}

/* -- what has nothing to do, and what there is none of ------------------------------------------------------------ */

/* The arguments are not looked at: the caller clears them away on every platform that FMI names. */
#define NOTHING_TO_DO(name) EXPORT int name(void *instance) { (void)instance; return FMI_OK; }
#define NONE(name) EXPORT int name(void *instance, size_t *count) { (void)instance; *count = 0; return FMI_OK; }
#define UNSUPPORTED(name) EXPORT int name(void *instance) { return failed(instance, #name " is not supported"); }
#define UNSUPPORTED_TYPE(type) UNSUPPORTED(fmi3Get##type) UNSUPPORTED(fmi3Set##type)

NOTHING_TO_DO(fmi3SetDebugLogging) NOTHING_TO_DO(fmi3Terminate) NOTHING_TO_DO(fmi3EvaluateDiscreteStates)
NOTHING_TO_DO(fmi3EnterEventMode) NOTHING_TO_DO(fmi3EnterStepMode) NOTHING_TO_DO(fmi3EnterContinuousTimeMode)
NOTHING_TO_DO(fmi3GetContinuousStates) NOTHING_TO_DO(fmi3SetContinuousStates)
NOTHING_TO_DO(fmi3GetContinuousStateDerivatives) NOTHING_TO_DO(fmi3GetNominalsOfContinuousStates)
NOTHING_TO_DO(fmi3GetEventIndicators)
NONE(fmi3GetNumberOfContinuousStates)
NONE(fmi3GetNumberOfEventIndicators)
UNSUPPORTED_TYPE(Float32) UNSUPPORTED_TYPE(Int8) UNSUPPORTED_TYPE(UInt8) UNSUPPORTED_TYPE(Int16)
UNSUPPORTED_TYPE(UInt16) UNSUPPORTED_TYPE(Int32) UNSUPPORTED_TYPE(UInt32) UNSUPPORTED_TYPE(Int64)
UNSUPPORTED_TYPE(UInt64) UNSUPPORTED_TYPE(Boolean) UNSUPPORTED_TYPE(String) UNSUPPORTED_TYPE(Binary)
UNSUPPORTED_TYPE(Clock) UNSUPPORTED_TYPE(IntervalDecimal) UNSUPPORTED_TYPE(IntervalFraction)
UNSUPPORTED_TYPE(ShiftDecimal) UNSUPPORTED_TYPE(ShiftFraction)
UNSUPPORTED(fmi3GetNumberOfVariableDependencies)
UNSUPPORTED(fmi3GetVariableDependencies)
UNSUPPORTED(fmi3GetFMUState)
UNSUPPORTED(fmi3SetFMUState)
UNSUPPORTED(fmi3FreeFMUState)
UNSUPPORTED(fmi3SerializedFMUStateSize)
UNSUPPORTED(fmi3SerializeFMUState)
UNSUPPORTED(fmi3DeserializeFMUState)
UNSUPPORTED(fmi3GetDirectionalDerivative)
UNSUPPORTED(fmi3GetAdjointDerivative)
UNSUPPORTED(fmi3EnterConfigurationMode)
UNSUPPORTED(fmi3ExitConfigurationMode)
UNSUPPORTED(fmi3GetOutputDerivatives)
UNSUPPORTED(fmi3ActivateModelPartition)

EXPORT void *fmi3InstantiateScheduledExecution(const char *name) {
    (void)name;
    return NULL;
}
