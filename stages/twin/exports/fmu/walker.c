/* The planar walker on penalty ground as a Functional Mock-up Unit: FMI 3.0, model exchange. Made by bipedstudy.

   All numbers stand in v: time; the state, q then its rates; the state's rates; what is discrete: steps, and each leg's
   status; pushes; parameters that are fixed, then those that may be tuned; outputs; event indicators. Their places,
   units and meanings are those of modelDescription.xml. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/*@sizes@*/
#define NQ ((DERIVATIVE - STATE) / 2)

#define FMI3(name) Status fmi3##name
/* Functions that have nothing to do, and those of what a walker has not. */
#define READY(name) FMI3(name)() { return OK; }
#define NO(name) FMI3(name)() { return ERROR; }

typedef enum { OK, WARNING, DISCARD, ERROR } Status;
/* Status of a leg: the ground does not act on its foot; it does, and the foot has not landed yet; it has. */
enum { OUT, AWAITED, LANDED };

typedef struct {
    double v[COUNT];
    double above[2], air[2], swing[2], ahead, upright; /* of feet and hip, in scales of the walker */
    bool located; /* whether an event has just been */
} Walker;

static const double STARTS[COUNT] = {/*@starts@*/};
static const double NOMINALS[2 * NQ] = {/*@nominals@*/};

/* x of a x = b in the place of b; a is symmetric, and its lower half is given. */
static void solve(double a[NQ][NQ], double b[NQ]) {
    for (int j = 0; j < NQ; j++)
        for (int i = j + 1; i < NQ; i++) {
            const double share = a[i][j] / a[j][j];
            for (int k = i; k < NQ; k++) a[k][i] -= share * a[k][j];
            b[i] -= share * b[j];
        }
    for (int i = NQ - 1; i >= 0; i--) {
        for (int k = i + 1; k < NQ; k++) b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

/* A number that falls to zero when the leg's status changes. The ground ceases to act on a foot once it is in the air
   behind the other and swings forward, and acts again once it is in the air ahead: then it is awaited until it lands.
   A hair's breadth behind, or what has just come ahead would be behind again by round-off. */
static double leaving(const Walker *w, int leg) {
    return fmax(w->air[leg] + fmax(-w->above[leg], leg ? -w->ahead : w->ahead), -w->swing[leg]);
}

static double guard(const Walker *w, int leg) {
    if (w->v[STATUS + leg] == OUT) return fmax(w->air[leg] - w->above[leg], leg ? w->ahead : -w->ahead);
    return w->v[STATUS + leg] == AWAITED ? fmin(w->above[leg], leaving(w, leg)) : leaving(w, leg);
}

static void change(Walker *w, int leg) {
    double *status = &w->v[STATUS + leg];
    const bool lands = *status == AWAITED && w->above[leg] < leaving(w, leg);
    *status = *status == OUT ? AWAITED : lands ? LANDED : OUT;
    w->v[STEPS] += lands;
}

static void evaluate(Walker *w) {
    double *v = w->v, a[NQ][NQ], b[NQ];
    const double acts_0 = v[STATUS] != OUT, acts_1 = v[STATUS + 1] != OUT;
/*@names@*/
/*@ground@*/
/*@motion@*/
    solve(a, b);
/*@felt@*/
    memcpy(v + DERIVATIVE, v + STATE + NQ, sizeof b);
    memcpy(v + DERIVATIVE + NQ, b, sizeof b);
    for (int leg = 0; leg < 2; leg++) {
        v[INDICATOR + leg] = guard(w, leg);
        v[INDICATOR + 2 + leg] = v[STATUS + leg] == OUT ? -1.0 : -w->above[leg];
    }
    v[INDICATOR + 4] = w->upright;
    for (int i = INDICATOR; i < COUNT; i++) v[i] += copysign(-ROUND_OFF, v[i]); /* none rests at zero */
}

const char *fmi3GetVersion(void) { return "3.0"; }
void fmi3FreeInstance(Walker *w) { free(w); }
FMI3(EnterEventMode)(Walker *w) { return w->located = true, OK; }
FMI3(CompletedIntegratorStep)(Walker *w, bool kept, bool *event, bool *ends) { return *event = *ends = false, OK; }
FMI3(Reset)(Walker *w) { return memcpy(w->v, STARTS, sizeof STARTS), w->located = false, OK; }

Walker *fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logs,
                                     void *environment, void *log) {
    Walker *w = strcmp(token, TOKEN) ? NULL : malloc(sizeof *w);
    if (w) fmi3Reset(w);
    return w;
}

FMI3(EnterInitializationMode)(Walker *w, bool limited, double tolerance, double start, bool ends, double stop) {
    return w->v[0] = start, OK;
}

/* Legs change whose guard has fallen. Nearer to zero than round-off is a guard of the event just located. */
FMI3(UpdateDiscreteStates)(Walker *w, bool *again, bool *terminate, bool *nominals, bool *states, bool *timed,
                          double *next) {
    evaluate(w);
    for (bool changed = true; changed; w->located = false) {
        changed = false;
        for (int leg = 0; leg < 2; leg++)
            if (guard(w, leg) <= (w->located ? 0.0 : ROUND_OFF)) change(w, leg), changed = true;
    }
    *terminate = w->upright <= 0.0;
    return *again = *nominals = *states = *timed = false, OK;
}

FMI3(GetFloat64)(Walker *w, const uint32_t places[], size_t count, double values[], size_t size) {
    evaluate(w);
    for (size_t i = 0; i < count; i++) {
        if (places[i] >= COUNT) return ERROR;
        values[i] = w->v[places[i]];
    }
    return OK;
}

FMI3(SetFloat64)(Walker *w, const uint32_t places[], size_t count, const double values[], size_t size) {
    for (size_t i = 0; i < count; i++) {
        if (places[i] < STATE || places[i] >= OUTPUT || (places[i] >= DERIVATIVE && places[i] < STEPS)) return ERROR;
        w->v[places[i]] = values[i];
    }
    return OK;
}

static Status some(Walker *w, double to[], size_t count, size_t from, size_t end) {
    evaluate(w);
    if (count == end - from) memcpy(to, w->v + from, count * sizeof *to);
    return count == end - from ? OK : ERROR;
}

FMI3(GetContinuousStates)(Walker *w, double x[], size_t count) { return some(w, x, count, STATE, DERIVATIVE); }
FMI3(GetContinuousStateDerivatives)(Walker *w, double x[], size_t count) { return some(w, x, count, DERIVATIVE, STEPS); }
FMI3(GetEventIndicators)(Walker *w, double z[], size_t count) { return some(w, z, count, INDICATOR, COUNT); }
FMI3(SetTime)(Walker *w, double time) { return w->v[0] = time, OK; }
FMI3(SetContinuousStates)(Walker *w, const double x[], size_t count) {
    return count == 2 * NQ ? memcpy(w->v + STATE, x, sizeof NOMINALS), OK : ERROR;
}
FMI3(GetNominalsOfContinuousStates)(Walker *w, double x[], size_t count) {
    return count == 2 * NQ ? memcpy(x, NOMINALS, sizeof NOMINALS), OK : ERROR;
}
FMI3(GetNumberOfEventIndicators)(Walker *w, size_t *count) { return *count = COUNT - INDICATOR, OK; }
FMI3(GetNumberOfContinuousStates)(Walker *w, size_t *count) { return *count = 2 * NQ, OK; }

READY(SetDebugLogging) READY(ExitInitializationMode) READY(EnterContinuousTimeMode) READY(Terminate)
void *fmi3InstantiateCoSimulation() { return NULL; } void *fmi3InstantiateScheduledExecution() { return NULL; }
NO(GetFloat32) NO(GetInt8) NO(GetUInt8) NO(GetInt16) NO(GetUInt16) NO(GetInt32) NO(GetUInt32) NO(GetInt64)
NO(GetUInt64) NO(GetBoolean) NO(GetString) NO(GetBinary) NO(GetClock) NO(SetFloat32) NO(SetInt8) NO(SetUInt8)
NO(SetInt16) NO(SetUInt16) NO(SetInt32) NO(SetUInt32) NO(SetInt64) NO(SetUInt64) NO(SetBoolean) NO(SetString)
NO(SetBinary) NO(SetClock) NO(GetNumberOfVariableDependencies) NO(GetVariableDependencies) NO(GetFMUState)
NO(SetFMUState) NO(FreeFMUState) NO(SerializedFMUStateSize) NO(SerializeFMUState) NO(DeserializeFMUState)
NO(GetDirectionalDerivative) NO(GetAdjointDerivative) NO(EnterConfigurationMode) NO(ExitConfigurationMode)
NO(GetIntervalDecimal) NO(GetIntervalFraction) NO(GetShiftDecimal) NO(GetShiftFraction) NO(SetIntervalDecimal)
NO(SetIntervalFraction) NO(SetShiftDecimal) NO(SetShiftFraction) NO(EvaluateDiscreteStates) NO(EnterStepMode)
NO(GetOutputDerivatives) NO(DoStep) NO(ActivateModelPartition)
