/* Chooses the default controller of a run, and the tolerance at which a controller satisfies the wanted accuracy. */
#include <slipstep/rooms/slipadapt.h>
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipsys.h>
#include <string.h>

typedef enum {
  KIND_EVENT,
  KIND_RUPTURE,
  KIND_SEQUENCE,
  KIND_HEAVY,
  KIND_INJECTION,
  KIND_TRIGGERED,
  KIND_SMOOTH,
  KINDS
} Kind;

/* Largest tolerance of sequences, and of ruptures under a pore pressure: larger ones lose events of marginal faults. */
#define MARGINAL 0.01
/* Divisor of tolerances with inertia: delays of events add up, and twenty of them should be within the accuracy 1e-2.
   */
#define STOPS 5
/* Likewise where a pore pressure starts ruptures, which the draws of injections do not contain. basic at 1e-3 satisfies
   1e-2 in 45 of 48 pulses of 1.5 s to a day with ramps of 0.1 s to a day, under constant friction and slip weakening,
   and 1.8e-2 in all, by 6340 products (heuristic 43, dsp 37, pi 27); rl takes 14800 for that, by -ts_rtol 1e-3. */
#define PULSES 3

/* Kinds of runs. controller is the default classical one, to which rl hands over: the cheapest at the accuracy 1e-2;
   fine is the same for accuracies finer than 3e-3. */
static const struct {
  const char *name, *meaning;
  const char *policy;      /* the problem of its default policy; "fault", which hands over, where none is made for it */
  const char *by_products; /* with inertia: problem of the policy for explicit or implicit steps; NULL: none */
  const char *controller, *fine; /* a type, and a filter after a colon */
  const char *group;             /* group of a file of tolerances (-fault_tolerances); NULL: none measured */
  PetscReal learned;             /* the finest accuracy for which rl, by the policy, is the default; 0: none */
  PetscReal rtol;                /* for controllers without a row: uncalibrated ones, rl, constant steps */
  PetscReal loosest, tighter;    /* an upper bound of the other tolerances, and their divisor */
} Kinds[KINDS] = {
  [KIND_EVENT] = {"event", "an event from the instability", "fault", "fault_products", "pi:fault_history", "dsp",
                  "event", 1e-3, 1e-3, PETSC_MAX_REAL, 1},
  [KIND_RUPTURE] = {"rupture", "a rupture from a given stress", "rupture", "rupture", "pi", "pi", "rupture", 2e-3, 1e-3,
                    PETSC_MAX_REAL, 1},
  [KIND_SEQUENCE] = {"sequence", "a fault that is loaded or heals", "fault", NULL, "dsp", "dsp", "sequence", 0, 1e-4,
                     MARGINAL, 1},
  [KIND_HEAVY] = {"sequence_inertia", "a fault with inertia that is loaded or heals", "fault", NULL, "dsp", "dsp",
                  "sequence", 0, 1e-4, MARGINAL, STOPS},
  [KIND_INJECTION] = {"injection", "a fault under a pore pressure", "fault", NULL, "basic", "basic", "injection", 0,
                      1e-3, PETSC_MAX_REAL, 1},
  [KIND_TRIGGERED] = {"injection_weakening", "a fault that weakens under a pore pressure", "fault", NULL, "basic",
                      "basic", "injection", 0, 1e-3, MARGINAL, PULSES},
  [KIND_SMOOTH] = {"smooth", "rate-and-state friction", "fault", NULL, "heuristic", "heuristic", NULL, 0, 1e-3,
                   PETSC_MAX_REAL, 1},
};
#define FINE 3e-3
/* Largest damping ratio in the training of fault_products. Beyond it explicit steps are stable for so short a time that
   implicit ones take fewer products (24 x 24 cells of the 3 km fault at 1: 670 instead of 930). */
#define MOST_DAMPED 0.6
/* The finest accuracy that pi satisfies by explicit steps where cells may open, at a seventh of the products */
#define OPENING_LEAST 1e-2

static const char *ControllerAt(PetscInt kind, PetscReal accuracy)
{
  return accuracy < FINE ? Kinds[kind].fine : Kinds[kind].controller;
}

/* Reads the tolerances of a kind. Collective. file "": the library's */
static PetscErrorCode ReadTolerances(MPI_Comm comm, const char prefix[], const char file[], PetscInt kind,
                                     SlipFaultTolerances *t)
{
  PetscFunctionBegin;
  if (Kinds[kind].group) PetscCall(SlipFaultTolerancesRead(comm, prefix, file, Kinds[kind].group, t));
  for (PetscInt c = 0; c < t->controllers; c++)
    for (PetscInt a = 0; a < t->accuracies; a++)
      t->row[c].rtol[a] = PetscMin(t->row[c].rtol[a], Kinds[kind].loosest) / Kinds[kind].tighter;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the relative tolerance at which a controller satisfies an accuracy in 95 % of faults. kind: kind of run:
   "event" (from the instability), "rupture" (from a given stress), "sequence" (loaded, or healing), "sequence_inertia",
   "injection" (a pore pressure alone), "injection_weakening" (where friction weakens) or "smooth" (rate-and-state
   friction under TSBATHE); controller: as in SlipAdaptSetController(); accuracy: relative error of the run, as in
   -fault_accuracy, dimensionless; rtol: the tolerance, dimensionless; 0: the file has none for this controller, or it
   satisfies the accuracy at none. Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another kind; PETSC_ERR_FILE_OPEN or
   PETSC_ERR_FILE_UNEXPECTED for a file that is missing or damaged. */
PetscErrorCode SlipFaultFindTolerance(const char kind[], const char controller[], PetscReal accuracy, PetscReal *rtol)
{
  SlipFaultTolerances t = {0};
  PetscInt k = 0;

  PetscFunctionBegin;
  while (k < KINDS && strcmp(Kinds[k].name, kind)) k++;
  PetscCheck(k < KINDS, PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE,
             "there is no kind of runs \"%s\", expected event, rupture, sequence, sequence_inertia, injection, "
             "injection_weakening or smooth",
             kind);
  PetscCall(ReadTolerances(PETSC_COMM_SELF, NULL, "", k, &t));
  *rtol = PetscMax(SlipFaultTolerancesFind(&t, controller, accuracy), 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

static Kind KindOf(SlipFault fault)
{
  return fault->friction.law->always_slides ? KIND_SMOOTH
         : fault->kind.sequence             ? (fault->kind.inertia ? KIND_HEAVY : KIND_SEQUENCE)
         : fault->loads.pressed             ? (fault->resolution.weakens ? KIND_TRIGGERED : KIND_INJECTION)
         : fault->critical.known            ? KIND_EVENT
                                            : KIND_RUPTURE;
}

void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit)
{
  const PetscInt kind = KindOf(fault);

  if (kind != fault->steps.kind) fault->steps.tolerances.controllers = 0;
  /* Tolerances that were read stay, as a fault may run many times. */
  fault->steps = (SlipFaultSteps){.kind = kind, .policy = Kinds[kind].policy, .tolerances = fault->steps.tolerances};
  fault->problem.control.controller =
    is_explicit ? NULL : ControllerAt(kind, SlipFaultAccuracy(fault)); /* NULL: the integrator's */
}

/* Finds whether an option of the TS is given, before TSSetFromOptions() reads it. */
static PetscErrorCode Names(TS ts, const char option[], PetscBool *names)
{
  const char *prefix;

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(SlipHasOption(((PetscObject)ts)->options, prefix, option, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether -ts_adapt_type is given. NAME alone means the type without a filter, also where the default has one. */
static PetscErrorCode NamesType(TS ts, PetscBool *names)
{
  return Names(ts, "ts_adapt_type", names);
}

/* Returns whether policies were trained and tested with this law. */
static PetscBool IsTrainedLaw(const char law[])
{
  return !strcmp(law, "exponential_slip_weakening") || !strcmp(law, "linear_slip_weakening") ? PETSC_TRUE : PETSC_FALSE;
}

/* Finds whether an option names a controller or tolerances, or belongs to the default classical controller. */
static PetscErrorCode NamesClassical(SlipFault fault, TS ts, const char controller[], PetscBool *names)
{
  static const char *const common[] = {"ts_adapt_type", "ts_rtol", "ts_adapt_safety"};
  static const char *const texts[] = {"ts_adapt_pi_filter", "ts_adapt_dsp_filter", "ts_adapt_dsp_pid"};
  const size_t ntexts = PETSC_STATIC_ARRAY_LENGTH(texts);
  const char *name;
  char own[64];

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(own, sizeof(own), "ts_adapt_%.*s_", (int)strcspn(controller, ":"), controller));
  *names = fault->options.text[FAULT_TOLERANCES][0] ? PETSC_TRUE : PETSC_FALSE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(common) && !*names; i++) PetscCall(Names(ts, common[i], names));
  for (size_t i = 0; !*names && (name = i < ntexts ? texts[i] : SlipNumberOption(i - ntexts)); i++)
    if (!strncmp(name, own, strlen(own))) PetscCall(Names(ts, name, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether rl is the default: it was the best, its policy exists, and no option sets a classical controller. */
static PetscErrorCode IsLearned(SlipFault fault, TS ts, PetscBool *learned)
{
  const PetscInt kind = fault->steps.kind;
  char file[PETSC_MAX_PATH_LEN];
  PetscBool named;

  PetscFunctionBegin;
  *learned = Kinds[kind].learned > 0 && SlipFaultAccuracy(fault) >= Kinds[kind].learned ? PETSC_TRUE : PETSC_FALSE;
  if (kind == KIND_EVENT && fault->kind.driven) *learned = PETSC_FALSE; /* without inertia */
  if (SlipFaultOpens(fault)) *learned = PETSC_FALSE; /* policies exceed the accuracy on half of these, pi on none */
  if (SlipFaultPressureFollows(fault)) *learned = PETSC_FALSE; /* no policy was trained for it */
  if (!IsTrainedLaw(fault->friction.law->name)) *learned = PETSC_FALSE;
  PetscCall(NamesClassical(fault, ts, fault->problem.control.controller, &named));
  if (named) *learned = PETSC_FALSE;
  if (*learned) PetscCall(SlipPolicyFindDefault(fault->comm, Kinds[kind].policy, file, sizeof(file), learned));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns that -fault_velocity_scale is unused, when the policy is chosen; names NULL: there is no policy. */
static PetscErrorCode WarnOfVelocity(SlipFault fault, PetscInt n, const char *const names[])
{
  const char *prefix = SlipFaultPrefix(fault);
  PetscBool given, seen = PETSC_FALSE;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  for (PetscInt i = 0; i < n && !seen; i++) PetscCall(PetscStrcmp(names[i], "velocity", &seen));
  PetscCall(
    PetscOptionsHasName(((PetscObject)fault)->options, ((PetscObject)fault)->prefix, "-fault_velocity_scale", &given));
  if (given && !seen && !rank && fault->options.reports)
    PetscCall(
      SlipWarning("-%sfault_velocity_scale has no effect: it is for -ts_adapt_type rl with a policy that observes "
                  "velocity",
                  prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns before a run of options of the fault that the chosen steps do not use. */
static PetscErrorCode WarnOfIdle(SlipFault fault, TS ts)
{
  const PetscBool is_explicit = fault->problem.steps.any_integrator;
  const char *prefix = SlipFaultPrefix(fault);
  const char *why;
  PetscBool learned, constant, rtol;
  PetscMPIInt rank;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  rtol = !is_explicit && fault->steps.given ? PETSC_TRUE : PETSC_FALSE;
  if (learned && SlipLoadsChange(&fault->loads) && !rank && fault->options.reports)
    PetscCall(
      SlipWarning("policies for -ts_adapt_type rl know pore pressures that rise slowly: under other loads errors were "
                  "up to 50 times -%sfault_accuracy. Expected the default, -ts_adapt_type %s",
                  prefix, is_explicit ? TSADAPTDSP : TSADAPTBASIC));
  if (learned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WarnOfVelocity(fault, 0, NULL));
  if (rank || !fault->options.reports) PetscFunctionReturn(PETSC_SUCCESS);
  why = constant      ? "they are constant (-ts_adapt_type none)"
        : rtol        ? "-ts_rtol has their tolerance"
        : is_explicit ? "give -ts_rtol, which sets the tolerance of explicit steps"
                      : NULL;
  if (why && !PetscIsNanReal(fault->options.value[FAULT_ACCURACY]))
    PetscCall(SlipWarning("-%sfault_accuracy has no effect on the steps: %s", prefix, why));
  if (!why && fault->steps.accuracy == 0) why = "it has no tolerance of this controller at this accuracy";
  if (why && fault->options.text[FAULT_TOLERANCES][0])
    PetscCall(SlipWarning("-%sfault_tolerances %s has no effect on the steps: %s", prefix,
                          fault->options.text[FAULT_TOLERANCES], why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the tolerances once. */
static PetscErrorCode ReadOwnTolerances(SlipFault fault)
{
  SlipFaultSteps *steps = &fault->steps;

  PetscFunctionBegin;
  if (!steps->tolerances.controllers)
    PetscCall(ReadTolerances(fault->comm, ((PetscObject)fault)->prefix, fault->options.text[FAULT_TOLERANCES],
                             steps->kind, &steps->tolerances));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether events follow each other, or fluid is injected: there is no estimate of the steps themselves. */
static PetscBool HasToleranceError(SlipFault fault)
{
  return (PetscBool)(fault->steps.kind >= KIND_SEQUENCE && fault->steps.kind <= KIND_TRIGGERED);
}

/* Gets for such runs the accuracy that the controller satisfied at this tolerance in 97 % of the faults of the
   calibration. 0: unknown, as where no file was read at the start */
PetscErrorCode SlipFaultToleranceError(SlipFault fault, TS ts, PetscReal *error)
{
  char controller[64];
  PetscReal rtol;
  TSAdapt adapt;

  PetscFunctionBegin;
  *error = 0;
  if (!HasToleranceError(fault) || SlipFaultPressureFollows(fault)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  *error = SlipFaultTolerancesAccuracy(&fault->steps.tolerances, controller, rtol);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Set(SlipFault fault, TS ts, const char controller[], PetscReal accuracy)
{
  SlipFaultSteps *steps = &fault->steps;

  PetscFunctionBegin;
  PetscCall(ReadOwnTolerances(fault));
  steps->rtol = SlipFaultTolerancesFind(&steps->tolerances, controller, accuracy);
  steps->accuracy = steps->rtol > 0 ? accuracy : 0;
  steps->rtol = steps->rtol == 0 ? Kinds[steps->kind].rtol : PetscAbsReal(steps->rtol);
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, steps->rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the default controller and its tolerance. */
PetscErrorCode SlipFaultConfigureSteps(SlipFault fault, TS ts)
{
  const char *controller = fault->problem.control.controller;
  char type[64], file[PETSC_MAX_PATH_LEN];
  PetscBool named, found;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(type, controller, sizeof(type)));
  PetscCall(NamesType(ts, &named));
  if (named) type[strcspn(type, ":")] = 0;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptSetController(adapt, type));
  PetscCall(IsLearned(fault, ts, &fault->steps.learned));
  if (fault->steps.learned) PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  PetscCall(Names(ts, "ts_rtol", &named));
  if (!named)
    PetscCall(Set(fault, ts, type, SlipFaultAccuracy(fault)));
  else if (HasToleranceError(fault) && !fault->options.text[FAULT_TOLERANCES][0]) { /* a tolerance needs no file */
    PetscCall(SlipPolicyFindDefault(fault->comm, "tolerances", file, sizeof(file), &found));
    if (found) PetscCall(ReadOwnTolerances(fault));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the policy was trained with explicit steps, or with ruptures whose steps were limited like those. */
static PetscErrorCode LearnsByProducts(SlipFault fault, TSAdapt adapt, PetscBool *learns)
{
  const char *problem = Kinds[fault->steps.kind].by_products, *measure, *trained = NULL;
  char file[PETSC_MAX_PATH_LEN];
  SlipPolicy policy;
  PetscBool actor;

  PetscFunctionBegin;
  *learns = PETSC_FALSE;
  PetscCall(TSAdaptRLGetMeasure(adapt, &measure));
  PetscCall(TSAdaptRLHasActor(adapt, &actor));
  PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (actor || !measure || strcmp(measure, "history") || !IsTrainedLaw(fault->friction.law->name))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!policy) {
    PetscCall(SlipPolicyFindDefault(fault->comm, problem, file, sizeof(file), learns));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipPolicyGetAttribute(policy, "problem", &trained));
  *learns = trained && !strcmp(trained, problem) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses how steps are computed unless the user does: explicit or implicit, whichever costs less, where errors were
   measured to satisfy the accuracy: with inertia for single events, without it where stress changes in time, under
   classical controllers. Else steps are implicit, as in the training of other policies and the measured tolerances. */
static PetscErrorCode ChooseMethod(SlipFault fault, TS ts, TSAdapt adapt)
{
  const Kind kind = (Kind)fault->steps.kind;
  static const char *const options[] = {"ts_bathe_gamma", "ts_bathe_first_stage", "ts_bathe_reaction",
                                        "ts_bathe_stage_error"}; /* of implicit steps only */
  char controller[64];
  PetscBool fewer = PETSC_FALSE, stages = PETSC_FALSE;

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(options) && !stages; i++) PetscCall(Names(ts, options[i], &stages));
  PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
  if (!stages && Kinds[kind].by_products && fault->kind.inertia && !(kind == KIND_EVENT && fault->kind.driven) &&
      fault->options.value[FAULT_DAMPING_RATIO] <= MOST_DAMPED) {
    if (SlipFaultOpens(fault))
      fewer = !strcmp(controller, "pi") && !fault->steps.given && SlipFaultAccuracy(fault) >= OPENING_LEAST
                ? PETSC_TRUE
                : PETSC_FALSE;
    else if (!strcmp(controller, TSADAPTRL))
      PetscCall(LearnsByProducts(fault, adapt, &fewer));
  }
  if (fault->problem.sides.side && (fault->kind.sequence || fault->loads.pressed) && !fault->device.device &&
      strcmp(controller, TSADAPTRL) && strcmp(controller, TSADAPTNONE) && strcmp(controller, TSADAPTHISTORY))
    fewer = PETSC_TRUE;
  PetscCall(TSBatheSetDefaultMethod(ts, fewer ? TSBATHE_METHOD_AUTO : TSBATHE_METHOD_IMPLICIT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipStepOps.begin: uses the controller of the run. A tolerance that neither the fault nor a policy has set is the
   user's, as is that of -ts_rtol. */
PetscErrorCode SlipFaultBeginSteps(TS ts, PetscBool chosen, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultSteps *steps = &fault->steps;
  char controller[64];
  PetscReal rtol, dial;
  PetscBool option, named = PETSC_FALSE;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  if (chosen) {
    const char *const *names;
    SlipPolicy policy;
    PetscInt n;

    if (!steps->given) steps->rtol = rtol;
    PetscCall(TSGetAdapt(ts, &adapt));
    PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
    if (policy) PetscCall(SlipPolicyGetObservations(policy, &n, &names));
    if (policy) PetscCall(WarnOfVelocity(fault, n, names));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipElasticForget(fault->medium));
  PetscCall(Names(ts, "ts_rtol", &option));
  steps->given = option || rtol != steps->rtol ? PETSC_TRUE : PETSC_FALSE;
  steps->user_rtol = rtol;
  steps->accuracy = 0;
  PetscCall(TSGetAdapt(ts, &adapt));
  if (steps->given && steps->learned) PetscCall(TSAdaptRLIsChosen(adapt, &named));
  if (steps->given && steps->learned && !named) { /* a policy that is only the default gives way to a given tolerance */
    PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
    if (!strcmp(controller, TSADAPTRL)) PetscCall(SlipAdaptSetController(adapt, fault->problem.control.controller));
    steps->learned = PETSC_FALSE;
  }
  PetscCall(TSAdaptRLSetDefaultAccuracy(adapt, SlipFaultAccuracy(fault)));
  PetscCall(ChooseMethod(fault, ts, adapt));
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  if (dial > 0) fault->problem.control.controller = ControllerAt(steps->kind, dial); /* rl hands over to it */
  if (steps->given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
  PetscCall(Set(fault, ts, controller, SlipFaultAccuracy(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipControlOps.hand_over */
PetscErrorCode SlipFaultHandOverSteps(TS ts, TSAdapt fallback, PetscReal accuracy, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64];

  PetscFunctionBegin;
  PetscCall(TSBatheSetDefaultMethod(ts, TSBATHE_METHOD_IMPLICIT));
  PetscCall(SlipAdaptGetController(fallback, controller, sizeof(controller)));
  if (steps->given)
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, steps->user_rtol, NULL));
  else
    PetscCall(Set(fault, ts, controller, accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what a run reports of its steps ---- */

/* Gets the controller that uses the tolerance: rl's fallback after it has handed over. It is empty for rl itself. */
static PetscErrorCode InCharge(TS ts, char controller[], size_t len)
{
  PetscBool learned, handed;
  TSAdaptType fallback;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptGetController(adapt, controller, len));
  PetscCall(PetscStrcmp(controller, TSADAPTRL, &learned));
  if (!learned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLGetHandover(adapt, &handed, NULL));
  if (handed) PetscCall(TSAdaptRLGetFallback(adapt, &fallback));
  PetscCall(PetscStrncpy(controller, handed ? fallback : "", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tolerances over the accuracy, for classical controllers at 1e-2, about: stands in for the tolerance under a policy */
#define OF_DIAL 0.3

/* Gets the relative error of a step, from the tolerance, or under a policy from its accuracy. 0: steps are given */
PetscErrorCode SlipFaultStepsError(SlipFault fault, TS ts, PetscReal *relative)
{
  char controller[64];
  PetscReal dial = 0;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, relative, NULL));
  PetscCall(InCharge(ts, controller, sizeof(controller)));
  if (!strcmp(controller, TSADAPTNONE) || !strcmp(controller, TSADAPTHISTORY)) *relative = 0;
  if (controller[0] || fault->problem.steps.any_integrator) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  if (dial > 0) *relative = OF_DIAL * dial;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints before the run what follows from the accuracy, and may be chosen otherwise. */
PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts)
{
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64], at[48] = "", *filter;
  const char *file = NULL;
  SlipPolicy policy;
  PetscReal dial = 0;
  TSAdapt adapt;
  PetscBool bathe, named, constant, follows;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCall(SlipFaultRefuseControllers(fault, ts));
  if (!bathe || !fault->problem.steps.begin) {
    PetscCall(SlipFaultExplicitFollows(fault, ts, &follows));
    if (follows)
      PetscCall(PetscPrintf(fault->comm, "%-24s -ts_type %s -ts_rtol %.3g, which keep -%sfault_accuracy %g, for %s\n",
                            "steps:", ((PetscObject)ts)->type_name, (double)steps->rtol, SlipFaultPrefix(fault),
                            (double)steps->accuracy, Kinds[steps->kind].meaning));
    else
      PetscCall(WarnOfIdle(fault, ts));
    PetscCall(SlipFaultWarnOfSlowSlip(fault, ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultBeginSteps(ts, PETSC_FALSE, fault));
  PetscCall(WarnOfIdle(fault, ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (!steps->learned && policy) PetscCall(SlipPolicyGetFile(policy, &file));
  if (file && file[0]) { /* the user chose rl */
    if (dial > 0) (void)snprintf(at, sizeof(at), " at the accuracy %g", (double)dial);
    PetscCall(PetscPrintf(fault->comm, "%-24s -ts_adapt_type rl%s, policy %s\n", "steps:", at, file));
  }
  if (steps->learned) {
    PetscCall(PetscPrintf(fault->comm, "%-24s -ts_adapt_type rl at the accuracy %g, for %s\n", "steps:", (double)dial,
                          Kinds[steps->kind].meaning));
  }
  PetscCall(InCharge(ts, controller, sizeof(controller)));
  PetscCall(NamesType(ts, &named));
  PetscCall(PetscStrcmp(controller, TSADAPTNONE, &constant));
  if ((steps->given && named) || constant || !controller[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrchr(controller, ':', &filter));
  if (filter) *filter++ = 0;
  PetscCall(PetscPrintf(fault->comm, "%-24s -ts_adapt_type %s", "steps:", controller));
  if (filter) PetscCall(PetscPrintf(fault->comm, " -ts_adapt_pi_filter %s", filter));
  if (!steps->given) PetscCall(PetscPrintf(fault->comm, " -ts_rtol %.3g", (double)steps->rtol));
  if (steps->accuracy > 0)
    PetscCall(
      PetscPrintf(fault->comm, ", which keep -%sfault_accuracy %g", SlipFaultPrefix(fault), (double)steps->accuracy));
  PetscCall(PetscPrintf(fault->comm, ", for %s\n", Kinds[steps->kind].meaning));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After the run, adds rtol to /result, and accuracy if rtol follows one. */
PetscErrorCode SlipFaultStepsResult(SlipFault fault, TS ts, SlipOutput run)
{
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64], label[80], unit[96] = "";
  PetscReal rtol;
  PetscBool bathe, constant, follows;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  PetscCall(SlipFaultExplicitFollows(fault, ts, &follows));
  if (!(bathe && fault->problem.steps.begin) && !follows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(InCharge(ts, controller, sizeof(controller)));
  PetscCall(PetscStrcmp(controller, TSADAPTNONE, &constant));
  if (!controller[0] || constant) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(PetscSNPrintf(label, sizeof(label), "tolerance of %s", controller));
  if (steps->accuracy > 0)
    PetscCall(PetscSNPrintf(unit, sizeof(unit), "for an accuracy of %g", (double)steps->accuracy));
  PetscCall(SlipOutputAddResult(run, "rtol", label, unit, rtol));
  if (steps->accuracy > 0) PetscCall(SlipOutputAddResult(run, "accuracy", NULL, NULL, steps->accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}
