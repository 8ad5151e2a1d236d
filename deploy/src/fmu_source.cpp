#include "fmu_source.hpp"

#include <string_view>

namespace fricid::deploy {
namespace {

// @ is the name of the model, # the token.
constexpr std::string_view kSource =
    R"(/* @ as an FMU: FMI 3.0, co-simulation. Written by fricid. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#undef FRICID_FLOAT
#include "@_friction.h"

#define EXPORT __attribute__((visibility("default")))

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*LogMessage)(void *environment, fmi3Status status, const char *category,
                           const char *message);

enum { N = @_JOINTS, Z = @_STATES };

/* Variables in the order of their value references. */
typedef struct {
  double q[N], v[N], load[N], temperature[N], tau_f[N];
  @_state state;
  double time;
} Values;

typedef struct {
  Values values;
  LogMessage log;
  void *environment;
} Instance;

static fmi3Status refuse(void *instance, const char *message) {
  const Instance *own = (const Instance *)instance;
  if (own && own->log) own->log(own->environment, fmi3Error, "error", message);
  return fmi3Error;
}

static void start(Values *x) {
  int j;
  memset(x, 0, sizeof *x);
  for (j = 0; j < N; ++j) x->temperature[j] = 293.15;
  @_init(&x->state);
}

static void find_torque(Values *x) {
  @_torque(&x->state, x->q, x->v, x->load, x->temperature, x->tau_f);
}

/* The variable of a value reference; null: there is none. */
static double *variable(Values *x, uint32_t reference) {
  const uint32_t n = (uint32_t)N;
  double *const fields[] = {x->q, x->v, x->load, x->temperature, x->tau_f};
  if (reference == 0u) return &x->time;
  --reference;
  if (reference < 5u * n) return &fields[reference / n][reference % n];
  return reference - 5u * n < (uint32_t)Z ? &x->state.z[reference - 5u * n] : NULL;
}

static bool is_input(uint32_t reference) {
  const uint32_t n = (uint32_t)N;
  return reference > 0u && (reference <= 4u * n || reference > 5u * n);
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT fmi3Status fmi3SetDebugLogging(void *instance, bool on, size_t n, const char *const names[]) {
  (void)instance, (void)on, (void)n, (void)names;
  return fmi3OK;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                         bool visible, bool logging, bool events, bool early,
                                         const uint32_t *intermediate, size_t n_intermediate,
                                         void *environment, LogMessage log, void (*update)(void)) {
  Instance *own;
  (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
  (void)intermediate, (void)n_intermediate, (void)update;
  if (!token || strcmp(token, "#") != 0) {
    if (log) log(environment, fmi3Error, "error", "@: another instantiation token");
    return NULL;
  }
  own = (Instance *)malloc(sizeof *own);
  if (!own) return NULL;
  start(&own->values);
  own->log = log;
  own->environment = environment;
  return own;
}

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token,
                                          const char *resources, bool visible, bool logging,
                                          void *environment, LogMessage log) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging;
  if (log) log(environment, fmi3Error, "error", "@: co-simulation alone");
  return NULL;
}

EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token,
                                               const char *resources, bool visible, bool logging,
                                               void *environment, LogMessage log,
                                               void (*clock)(void), void (*lock)(void),
                                               void (*unlock)(void)) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging;
  (void)clock, (void)lock, (void)unlock;
  if (log) log(environment, fmi3Error, "error", "@: co-simulation alone");
  return NULL;
}

EXPORT void fmi3FreeInstance(void *instance) { free(instance); }

EXPORT fmi3Status fmi3EnterInitializationMode(void *instance, bool has_tolerance, double tolerance,
                                              double from, bool has_stop, double stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  ((Instance *)instance)->values.time = from;
  return fmi3OK;
}

EXPORT fmi3Status fmi3ExitInitializationMode(void *instance) {
  find_torque(&((Instance *)instance)->values);
  return fmi3OK;
}

EXPORT fmi3Status fmi3Terminate(void *instance) {
  (void)instance;
  return fmi3OK;
}

EXPORT fmi3Status fmi3Reset(void *instance) {
  start(&((Instance *)instance)->values);
  return fmi3OK;
}

EXPORT fmi3Status fmi3GetFloat64(void *instance, const uint32_t *references, size_t n,
                                 double *values, size_t n_values) {
  Values *const x = &((Instance *)instance)->values;
  size_t i;
  if (n_values != n) return refuse(instance, "@: every variable is one number");
  find_torque(x);
  for (i = 0; i < n; ++i) {
    const double *const from = variable(x, references[i]);
    if (!from) return refuse(instance, "@: no variable has this value reference");
    values[i] = *from;
  }
  return fmi3OK;
}

EXPORT fmi3Status fmi3SetFloat64(void *instance, const uint32_t *references, size_t n,
                                 const double *values, size_t n_values) {
  Values *const x = &((Instance *)instance)->values;
  size_t i;
  if (n_values != n) return refuse(instance, "@: every variable is one number");
  for (i = 0; i < n; ++i) {
    double *const to = variable(x, references[i]);
    if (!to || !is_input(references[i]))
      return refuse(instance, "@: no input or state has this value reference");
    *to = values[i];
  }
  return fmi3OK;
}

EXPORT fmi3Status fmi3DoStep(void *instance, double time, double dt, bool no_return, bool *event,
                             bool *terminate, bool *early, double *last) {
  Values *const x = &((Instance *)instance)->values;
  (void)no_return;
  @_step(&x->state, x->q, x->v, x->load, x->temperature, dt);
  x->time = time + dt;
  *event = *terminate = *early = false;
  *last = x->time;
  return fmi3OK;
}

EXPORT fmi3Status fmi3GetFMUState(void *instance, void **state) {
  if (!*state) *state = malloc(sizeof(Values));
  if (!*state) return refuse(instance, "@: no memory");
  *(Values *)*state = ((const Instance *)instance)->values;
  return fmi3OK;
}

EXPORT fmi3Status fmi3SetFMUState(void *instance, void *state) {
  ((Instance *)instance)->values = *(const Values *)state;
  return fmi3OK;
}

EXPORT fmi3Status fmi3FreeFMUState(void *instance, void **state) {
  (void)instance;
  free(*state);
  *state = NULL;
  return fmi3OK;
}

EXPORT fmi3Status fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size) {
  (void)instance, (void)state;
  *size = sizeof(Values);
  return fmi3OK;
}

EXPORT fmi3Status fmi3SerializeFMUState(void *instance, void *state, uint8_t *bytes, size_t size) {
  if (size != sizeof(Values)) return refuse(instance, "@: a state of another size");
  memcpy(bytes, state, size);
  return fmi3OK;
}

EXPORT fmi3Status fmi3DeserializeFMUState(void *instance, const uint8_t *bytes, size_t size,
                                          void **state) {
  if (size != sizeof(Values)) return refuse(instance, "@: a state of another size");
  if (!*state) *state = malloc(size);
  if (!*state) return refuse(instance, "@: no memory");
  memcpy(*state, bytes, size);
  return fmi3OK;
}

/* What the standard asks for and friction has none of. */
#define NONE(name, ...)                            \
  EXPORT fmi3Status name(void *instance, __VA_ARGS__) { \
    return refuse(instance, "@: " #name " is not supported"); \
  }
#define NONE_ALONE(name)                       \
  EXPORT fmi3Status name(void *instance) {     \
    return refuse(instance, "@: " #name " is not supported"); \
  }
#define REFERENCES const uint32_t *r, size_t n
#define SILENT _Pragma("GCC diagnostic ignored \"-Wunused-parameter\"")
SILENT
#define NO_TYPE(kind, type)                                     \
  NONE(fmi3Get##kind, REFERENCES, type *values, size_t m)       \
  NONE(fmi3Set##kind, REFERENCES, const type *values, size_t m)
NO_TYPE(Float32, float)
NO_TYPE(Int8, int8_t)
NO_TYPE(UInt8, uint8_t)
NO_TYPE(Int16, int16_t)
NO_TYPE(UInt16, uint16_t)
NO_TYPE(Int32, int32_t)
NO_TYPE(UInt32, uint32_t)
NO_TYPE(Int64, int64_t)
NO_TYPE(UInt64, uint64_t)
NO_TYPE(Boolean, bool)
NO_TYPE(String, char *)
NONE(fmi3GetBinary, REFERENCES, size_t *sizes, const uint8_t **values, size_t m)
NONE(fmi3SetBinary, REFERENCES, const size_t *sizes, const uint8_t *const *values, size_t m)
NONE(fmi3GetClock, REFERENCES, bool *values)
NONE(fmi3SetClock, REFERENCES, const bool *values)
NONE(fmi3GetNumberOfVariableDependencies, uint32_t r, size_t *n)
NONE(fmi3GetVariableDependencies, uint32_t r, size_t *i, uint32_t *known, size_t *k, int *kinds,
     size_t n)
NONE(fmi3GetDirectionalDerivative, REFERENCES, const uint32_t *known, size_t k, const double *seed,
     size_t n_seed, double *values, size_t m)
NONE(fmi3GetAdjointDerivative, REFERENCES, const uint32_t *known, size_t k, const double *seed,
     size_t n_seed, double *values, size_t m)
NONE_ALONE(fmi3EnterEventMode)
NONE_ALONE(fmi3EnterStepMode)
NONE_ALONE(fmi3EnterConfigurationMode)
NONE_ALONE(fmi3ExitConfigurationMode)
NONE_ALONE(fmi3EvaluateDiscreteStates)
NONE_ALONE(fmi3EnterContinuousTimeMode)
NONE(fmi3GetIntervalDecimal, REFERENCES, double *intervals, int *qualifiers)
NONE(fmi3GetIntervalFraction, REFERENCES, uint64_t *counters, uint64_t *resolutions,
     int *qualifiers)
NONE(fmi3GetShiftDecimal, REFERENCES, double *shifts)
NONE(fmi3GetShiftFraction, REFERENCES, uint64_t *counters, uint64_t *resolutions)
NONE(fmi3SetIntervalDecimal, REFERENCES, const double *intervals)
NONE(fmi3SetIntervalFraction, REFERENCES, const uint64_t *counters, const uint64_t *resolutions)
NONE(fmi3SetShiftDecimal, REFERENCES, const double *shifts)
NONE(fmi3SetShiftFraction, REFERENCES, const uint64_t *counters, const uint64_t *resolutions)
NONE(fmi3UpdateDiscreteStates, bool *update, bool *terminate, bool *nominals, bool *states,
     bool *event, double *time)
NONE(fmi3CompletedIntegratorStep, bool no_return, bool *event, bool *terminate)
NONE(fmi3SetTime, double time)
NONE(fmi3SetContinuousStates, const double *x, size_t n)
NONE(fmi3GetContinuousStateDerivatives, double *x, size_t n)
NONE(fmi3GetEventIndicators, double *x, size_t n)
NONE(fmi3GetContinuousStates, double *x, size_t n)
NONE(fmi3GetNominalsOfContinuousStates, double *x, size_t n)
NONE(fmi3GetNumberOfEventIndicators, size_t *n)
NONE(fmi3GetNumberOfContinuousStates, size_t *n)
NONE(fmi3GetOutputDerivatives, REFERENCES, const int32_t *orders, double *values, size_t m)
NONE(fmi3ActivateModelPartition, uint32_t clock, double time)
)";

}  // namespace

std::string fmu_source(const std::string& name, const std::string& token) {
  std::string text;
  for (std::size_t i = 0; i < kSource.size(); ++i) {
    const char c = kSource[i];
    if (c == '@')
      text += name;
    else if (c == '#' && i > 0 && kSource[i - 1] == '"' && kSource[i + 1] == '"')
      text += token;
    else
      text += c;
  }
  return text;
}

}  // namespace fricid::deploy
