/* Which controller a run takes that names none, and at which tolerance a controller keeps the accuracy that is wanted. */
#include <slipadapt.h>
#include <slipstep/private/slipfault.h>
#include <string.h>

/* The tolerances at which a controller keeps these accuracies on random faults of a kind */
static const PetscReal Accuracies[] = {1e-1, 3e-2, 1e-2, 3e-3, 1e-3};
enum { ACCURACIES = PETSC_STATIC_ARRAY_LENGTH(Accuracies), CONTROLLERS = 5 };
typedef struct {
  const char *controller; /* its type, and a filter after a colon */
  PetscReal rtol[ACCURACIES];
} Tolerances;

typedef enum { KIND_EVENT, KIND_RUPTURE, KIND_SEQUENCE, KIND_HEAVY, KIND_INJECTION, KIND_SMOOTH, KINDS } Kind;

/* Of sequences: looser tolerances keep 1e-1 on segments, but lose events of faults that hardly weaken enough. */
#define MARGINAL 0.01
/* So much tighter with inertia: what an event is late adds up, and twenty of them are to be within an accuracy of 1e-2. */
#define STOPS 5

/* Kinds of runs. controller is the classical one that is the default and that rl hands over to: the cheapest at the accuracy 1e-2;
   fine likewise, of finer accuracies than 3e-3. The numbers are those of train -train_algorithm tolerances (training/howto/one_dial.md); 0: the
   controller keeps this accuracy at none. */
static const struct {
  const char *name, *meaning;
  const char
    *policy; /* the problem whose default policy it takes; "fault", which hands over, where none is made for it */
  const char *controller, *fine; /* a type, and a filter after a colon */
  PetscReal learned;             /* the finest accuracy at which rl, by the policy, is the default; 0: nowhere */
  PetscReal rtol;                /* of controllers without a row: those that were not calibrated, rl, constant steps */
  Tolerances tolerance[CONTROLLERS];
} Kinds[KINDS] = {
  [KIND_EVENT] = {"event",
                  "an event from the instability",
                  "fault",
                  "pi:fault_history",
                  "dsp",
                  1e-3,
                  1e-3,
                  {{"heuristic", {0.0257, 0.00413, 0.000866, 0.000137, 1.02e-5}},
                   {"pi", {1, 0.0062, 0.000972, 0.00015, 1.16e-5}},
                   {"dsp", {0.0537, 0.00538, 0.000971, 0.00014, 1.12e-5}},
                   {"basic", {0.0343, 0.00534, 0.00102, 0.000196, 1.74e-5}},
                   {"pi:fault_history", {0.0207, 0.00447, 0.000724, 0.000116, 0}}}},
  [KIND_RUPTURE] = {"rupture",
                    "a rupture from a given stress",
                    "rupture",
                    "pi",
                    "pi",
                    2e-3,
                    1e-3,
                    {{"heuristic", {0.173, 0.0582, 0.00985, 0.00172, 0.000483}},
                     {"pi", {1, 0.131, 0.0238, 0.002, 0.000185}},
                     {"dsp", {0.532, 0.0928, 0.0199, 0.0034, 0.000368}},
                     {"basic", {0.178, 0.066, 0.00808, 0.00353, 0.000463}},
                     {"pi:fault_history", {0.0517, 0.00969, 0.00197, 0.000456, 4.87e-5}}}},
  [KIND_SEQUENCE] = {"sequence",
                     "a fault that is loaded or heals",
                     "fault",
                     "dsp",
                     "dsp",
                     0,
                     1e-4,
                     {{"heuristic", {0.00375, 0.00121, 0.000456, 0.000143, 3.56e-05}},
                      {"pi", {MARGINAL, 0.00216, 0.000416, 0.000123, 3.02e-05}},
                      {"dsp", {MARGINAL, 0.00358, 0.000457, 0.00013, 3.41e-05}},
                      {"basic", {0.0063, 0.00152, 0.000617, 0.000189, 4.48e-05}},
                      {"pi:fault_history", {0.00214, 0.000381, 0.000159, 3.21e-05, 1.34e-05}}}},
  [KIND_HEAVY] =
    {"sequence_inertia",
     "a fault with inertia that is loaded or heals",
     "fault",
     "dsp",
     "dsp",
     0,
     1e-4,
     {{"heuristic", {0.00375 / STOPS, 0.00121 / STOPS, 0.000456 / STOPS, 0.000143 / STOPS, 3.56e-05 / STOPS}},
      {"pi", {MARGINAL / STOPS, 0.00216 / STOPS, 0.000416 / STOPS, 0.000123 / STOPS, 3.02e-05 / STOPS}},
      {"dsp", {MARGINAL / STOPS, 0.00358 / STOPS, 0.000457 / STOPS, 0.00013 / STOPS, 3.41e-05 / STOPS}},
      {"basic", {0.0063 / STOPS, 0.00152 / STOPS, 0.000617 / STOPS, 0.000189 / STOPS, 4.48e-05 / STOPS}},
      {"pi:fault_history", {0.00214 / STOPS, 0.000381 / STOPS, 0.000159 / STOPS, 3.21e-05 / STOPS, 1.34e-05 / STOPS}}}},
  [KIND_INJECTION] = {"injection",
                      "a fault under a pore pressure",
                      "injection",
                      "basic",
                      "pi",
                      3e-3,
                      1e-3,
                      {{"heuristic", {1, 0.0219, 0.00293, 0.000263, 6.91e-05}},
                       {"pi", {1, 1, 0.00385, 0.000237, 3.56e-05}},
                       {"dsp", {1, 0.032, 0.00334, 0.000299, 8.8e-05}},
                       {"basic", {1, 0.02, 0.00264, 0.000363, 0.000109}},
                       {"pi:fault_history", {0.837, 0.0115, 0.000365, 3.34e-05, 5.91e-06}}}},
  [KIND_SMOOTH] =
    {"smooth", "rate-and-state friction under bathe", "fault", "heuristic", "heuristic", 0, 1e-3, {{NULL, {0}}}},
};
#define FINE 3e-3

static const char *ControllerAt(PetscInt kind, PetscReal accuracy)
{
  return accuracy < FINE ? Kinds[kind].fine : Kinds[kind].controller;
}

/* Logarithms between two columns; negative: beyond the last one that the controller keeps, by the slope before it */
static PetscReal Interpolate(const Tolerances *row, PetscReal accuracy)
{
  PetscInt k = 0;
  PetscReal share, rtol;

  while (k + 2 < ACCURACIES && row->rtol[k + 2] > 0 && accuracy < Accuracies[k + 1]) k++;
  share = PetscLogReal(accuracy / Accuracies[k]) / PetscLogReal(Accuracies[k + 1] / Accuracies[k]);
  rtol = row->rtol[k] * PetscPowReal(row->rtol[k + 1] / row->rtol[k], share);
  return share > 1 ? -rtol : rtol;
}

/* 0: the table has no such controller. Without its filter a type counts as it is by default. */
static PetscReal Tolerance(PetscInt kind, const char controller[], PetscReal accuracy)
{
  const Tolerances *row = Kinds[kind].tolerance;
  const size_t type = strcspn(controller, ":");

  for (PetscInt i = 0; i < CONTROLLERS && row[i].controller; i++)
    if (!strcmp(row[i].controller, controller)) return Interpolate(&row[i], accuracy);
  for (PetscInt i = 0; i < CONTROLLERS && row[i].controller; i++)
    if (strlen(row[i].controller) == type && !strncmp(row[i].controller, controller, type))
      return Interpolate(&row[i], accuracy);
  return 0;
}

/*@C
  SlipFaultFindTolerance - the relative tolerance at which a controller keeps an accuracy in 95 % of random faults

  Not collective

  Input Parameters:
+ kind       - of a run: "event" (from the instability), "rupture" (from a given stress), "sequence" (loaded, or healing),
               "sequence_inertia", "injection" (a pore pressure alone) or "smooth" (rate-and-state friction under TSBATHE)
. controller - as `SlipAdaptSetController()` takes it
- accuracy   - relative error of the run, as of -fault_accuracy, dimensionless

  Output Parameter:
. rtol - the tolerance, dimensionless; 0: none is known for this controller, or it keeps the accuracy at none

  Level: intermediate

  Errors: PETSC_ERR_ARG_UNKNOWN_TYPE for another kind

.seealso: SlipFaultConfigureTS()
@*/
PetscErrorCode SlipFaultFindTolerance(const char kind[], const char controller[], PetscReal accuracy, PetscReal *rtol)
{
  PetscInt k = 0;

  PetscFunctionBegin;
  while (k < KINDS && strcmp(Kinds[k].name, kind)) k++;
  PetscCheck(
    k < KINDS, PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE,
    "there is no kind of runs \"%s\", expected event, rupture, sequence, sequence_inertia, injection or smooth", kind);
  *rtol = PetscMax(Tolerance(k, controller, accuracy), 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a run ---- */

static PetscReal Accuracy(SlipFault fault)
{
  const PetscReal given = fault->options.value[FAULT_ACCURACY];

  return PetscIsNanReal(given) ? (PetscReal)SLIP_FAULT_ACCURACY : given;
}

void SlipFaultChooseSteps(SlipFault fault, PetscBool is_explicit)
{
  const PetscBool smooth = fault->friction.law->always_slides;
  const PetscInt kind = smooth                  ? KIND_SMOOTH
                        : fault->kind.sequence  ? (fault->kind.inertia ? KIND_HEAVY : KIND_SEQUENCE)
                        : fault->loads.pressed  ? KIND_INJECTION
                        : fault->critical.known ? KIND_EVENT
                                                : KIND_RUPTURE;

  fault->steps = (SlipFaultSteps){.kind = kind, .policy = Kinds[kind].policy};
  fault->problem.controller = is_explicit ? NULL : ControllerAt(kind, Accuracy(fault)); /* NULL: the integrator's */
}

/* Whether one of the options of the TS begins like this. Nobody has read them yet, and they are checked later: asking for one by name
   would count as reading. */
static PetscErrorCode Names(TS ts, const char beginning[], PetscBool *names)
{
  char option[128], *all, *found;
  const char *prefix;

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%s%s", prefix ? prefix : "", beginning));
  PetscCall(PetscOptionsGetAll(((PetscObject)ts)->options, &all));
  PetscCall(PetscStrstr(all, option, &found));
  *names = found ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -ts_adapt_type NAME means the type as it is by itself, also where it is the default with a filter. */
static PetscErrorCode NamesType(TS ts, PetscBool *names)
{
  return Names(ts, "ts_adapt_type ", names);
}

/* What policies were trained on and held out with: slip weakening, and under a pore pressure friction that stays as well */
static PetscBool IsTrainedLaw(PetscInt kind, const char law[])
{
  if (!strcmp(law, "exponential_slip_weakening") || !strcmp(law, "linear_slip_weakening")) return PETSC_TRUE;
  return kind == KIND_INJECTION && !strcmp(law, "constant") ? PETSC_TRUE : PETSC_FALSE;
}

/* Whether an option names a controller or a tolerance, or is one of the classical controller that would be the default */
static PetscErrorCode NamesClassical(SlipFault fault, TS ts, PetscBool *names)
{
  const char *controller = fault->problem.controller;
  char own[64];
  const char *const beginnings[] = {"ts_adapt_type ", "ts_rtol ", "ts_adapt_safety ", own};

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(own, sizeof(own), "ts_adapt_%.*s_", (int)strcspn(controller, ":"), controller));
  *names = PETSC_FALSE;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(beginnings) && !*names; i++)
    PetscCall(Names(ts, beginnings[i], names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether rl is the default: where it has won, its policy is there, and no option speaks to a classical controller */
static PetscErrorCode IsLearned(SlipFault fault, TS ts, PetscBool *learned)
{
  const PetscInt kind = fault->steps.kind;
  char file[PETSC_MAX_PATH_LEN];
  PetscBool named;

  PetscFunctionBegin;
  *learned = Kinds[kind].learned > 0 && Accuracy(fault) >= Kinds[kind].learned ? PETSC_TRUE : PETSC_FALSE;
  if (kind == KIND_EVENT && fault->kind.driven) *learned = PETSC_FALSE; /* without inertia */
  if (!IsTrainedLaw(kind, fault->friction.law->name)) *learned = PETSC_FALSE;
  PetscCall(NamesClassical(fault, ts, &named));
  if (named) *learned = PETSC_FALSE;
  if (*learned) PetscCall(SlipPolicyFindDefault(fault->comm, Kinds[kind].policy, file, sizeof(file), learned));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -fault_velocity_scale, once the policy is known; names NULL: there is none */
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
  if (given && !seen && !rank && fault->options.speaks)
    PetscCall(
      SlipWarning("-%sfault_velocity_scale has no effect: it is for -ts_adapt_type rl with a policy that observes "
                  "velocity",
                  prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of the fault that nothing of the chosen steps follows, before a run */
static PetscErrorCode WarnOfIdle(SlipFault fault, TS ts)
{
  const PetscBool is_explicit = fault->problem.any_integrator;
  const char *prefix = SlipFaultPrefix(fault);
  PetscBool learned, constant, rtol;
  PetscMPIInt rank;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(fault->comm, &rank));
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTNONE, &constant));
  rtol = !is_explicit && fault->steps.given ? PETSC_TRUE : PETSC_FALSE;
  if (learned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WarnOfVelocity(fault, 0, NULL));
  if (!PetscIsNanReal(fault->options.value[FAULT_ACCURACY]) && (constant || rtol || is_explicit) && !rank &&
      fault->options.speaks)
    PetscCall(SlipWarning("-%sfault_accuracy has no effect on the steps: %s", prefix,
                          constant ? "they are constant (-ts_adapt_type none)"
                          : rtol   ? "-ts_rtol has their tolerance"
                                   : "give -ts_rtol, which sets the tolerance of explicit steps without a policy"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Set(SlipFault fault, TS ts, const char controller[], PetscReal accuracy)
{
  SlipFaultSteps *steps = &fault->steps;

  PetscFunctionBegin;
  steps->rtol = Tolerance(steps->kind, controller, accuracy);
  steps->accuracy = steps->rtol > 0 ? accuracy : 0;
  steps->rtol = steps->rtol == 0 ? Kinds[steps->kind].rtol : PetscAbsReal(steps->rtol);
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, steps->rtol, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The default controller and its tolerance */
PetscErrorCode SlipFaultConfigureSteps(SlipFault fault, TS ts)
{
  const char *controller = fault->problem.controller;
  char type[64];
  PetscBool named;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(type, controller, sizeof(type)));
  PetscCall(NamesType(ts, &named));
  if (named) type[strcspn(type, ":")] = 0;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptSetController(adapt, type));
  PetscCall(IsLearned(fault, ts, &fault->steps.learned));
  if (fault->steps.learned) PetscCall(TSAdaptSetType(adapt, TSADAPTRL));
  PetscCall(Set(fault, ts, type, Accuracy(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A policy that is only the default gives way to a tolerance that the user has set. */
static PetscErrorCode GiveWay(SlipFault fault, TSAdapt adapt)
{
  char controller[64];
  PetscBool rl, chosen;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLIsChosen(adapt, &chosen));
  if (chosen) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
  PetscCall(PetscStrcmp(controller, TSADAPTRL, &rl));
  if (rl) PetscCall(SlipAdaptSetController(adapt, fault->problem.controller));
  fault->steps.learned = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipProblemOps.begin: the controller is known now. A tolerance that neither the fault nor a policy has set is the user's, as is
   that of -ts_rtol. */
PetscErrorCode SlipFaultBeginSteps(TS ts, PetscBool chosen, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFaultSteps *steps = &fault->steps;
  const char *prefix;
  char controller[64];
  PetscReal rtol, dial;
  PetscBool option;
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
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, prefix, "-ts_rtol", &option));
  steps->given = option || rtol != steps->rtol ? PETSC_TRUE : PETSC_FALSE;
  steps->user_rtol = rtol;
  steps->accuracy = 0;
  PetscCall(TSGetAdapt(ts, &adapt));
  if (steps->given && steps->learned) PetscCall(GiveWay(fault, adapt));
  PetscCall(TSAdaptRLSetDefaultAccuracy(adapt, Accuracy(fault)));
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  if (dial > 0) fault->problem.controller = ControllerAt(steps->kind, dial); /* that rl hands over to */
  if (steps->given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipAdaptGetController(adapt, controller, sizeof(controller)));
  PetscCall(Set(fault, ts, controller, Accuracy(fault)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipProblemOps.hand_over */
PetscErrorCode SlipFaultHandOverSteps(TS ts, TSAdapt heir, PetscReal accuracy, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64];

  PetscFunctionBegin;
  PetscCall(SlipAdaptGetController(heir, controller, sizeof(controller)));
  if (steps->given)
    PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, NULL, steps->user_rtol, NULL));
  else
    PetscCall(Set(fault, ts, controller, accuracy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what is said of it ---- */

/* The controller whose tolerance counts: under rl its heir. empty: none */
static PetscErrorCode InCharge(TS ts, char controller[], size_t len)
{
  PetscBool learned, handed;
  TSAdaptType heir;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipAdaptGetController(adapt, controller, len));
  PetscCall(PetscStrcmp(controller, TSADAPTRL, &learned));
  if (!learned) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLGetHandover(adapt, &handed, NULL));
  if (handed) PetscCall(TSAdaptRLGetHeir(adapt, &heir));
  PetscCall(PetscStrncpy(controller, handed ? heir : "", len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the dial of a policy, what tolerances of classical controllers are of their accuracy at 1e-2, about */
#define OF_DIAL 0.3

/* The relative error of a step, by the tolerance, or under a policy by its dial. 0: steps are given */
PetscErrorCode SlipFaultStepsError(SlipFault fault, TS ts, PetscReal *relative)
{
  char controller[64];
  PetscReal dial = 0;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, relative, NULL));
  PetscCall(InCharge(ts, controller, sizeof(controller)));
  if (!strcmp(controller, TSADAPTNONE) || !strcmp(controller, TSADAPTHISTORY)) *relative = 0;
  if (controller[0] || fault->problem.any_integrator) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  if (dial > 0) *relative = OF_DIAL * dial;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* rl that somebody asked for, and the file of the policy that was named */
static PetscErrorCode ReportNamedPolicy(SlipFault fault, TSAdapt adapt)
{
  const char *file = NULL;
  char at[48] = "";
  SlipPolicy policy;
  PetscReal dial;

  PetscFunctionBegin;
  PetscCall(TSAdaptRLGetPolicy(adapt, &policy));
  if (policy) PetscCall(SlipPolicyGetFile(policy, &file));
  if (!file || !file[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
  if (dial > 0) (void)snprintf(at, sizeof(at), " at the accuracy %g", (double)dial);
  PetscCall(PetscPrintf(fault->comm, "%-24s -ts_adapt_type rl%s, policy %s\n", "steps:", at, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Before the run: what follows from the accuracy, and may be chosen otherwise */
PetscErrorCode SlipFaultReportSteps(SlipFault fault, TS ts)
{
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64], *filter;
  PetscReal dial;
  TSAdapt adapt;
  PetscBool bathe, named, constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (!bathe || !fault->problem.begin) {
    PetscCall(WarnOfIdle(fault, ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SlipFaultBeginSteps(ts, PETSC_FALSE, fault));
  PetscCall(WarnOfIdle(fault, ts));
  PetscCall(TSGetAdapt(ts, &adapt));
  if (!steps->learned) PetscCall(ReportNamedPolicy(fault, adapt));
  if (steps->learned) {
    PetscCall(TSAdaptRLGetAccuracy(adapt, &dial));
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

/* After it: /result has rtol, and accuracy where it follows one */
PetscErrorCode SlipFaultStepsResult(SlipFault fault, TS ts, SlipOutput run)
{
  const SlipFaultSteps *steps = &fault->steps;
  char controller[64], label[80], unit[96] = "";
  PetscReal rtol;
  PetscBool bathe, constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSBATHE, &bathe));
  if (!bathe || !fault->problem.begin) PetscFunctionReturn(PETSC_SUCCESS);
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
