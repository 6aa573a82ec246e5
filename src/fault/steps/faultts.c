/* Formulates the fault as a problem of a TS. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfeatures.h>
#include <slipstep/private/slipts.h>
#include <string.h>

#define SLIP_FAULT_MAX_TIME 30.0 /* [s] */
/* First step over T*: the instability grows from a relative excess of 1e-5, so anything well below T* is safe. */
#define SLIP_FAULT_FIRST_STEP 0.01

static PetscErrorCode Find_Fault(TS ts, const char name[], PetscInt *row, void *ctx)
{
  PetscInt component;

  PetscFunctionBegin;
  (void)ts;
  (void)ctx;
  *row = SlipObservationFind(name, &component);
  if (*row >= 0 && !SlipObservations[*row].fault) *row = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Observe_Fault(TS ts, PetscReal t, PetscInt n, const PetscInt row[], PetscReal value[], void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscBool estimates = PETSC_FALSE, state = PETSC_FALSE, method = PETSC_FALSE;
  Vec w, error, derivative;

  PetscFunctionBegin;
  PetscCall(TSGetSolution(ts, &w));
  for (PetscInt i = 0; i < n; i++) {
    if (SlipObservations[row[i]].reads & SLIP_READS_ESTIMATES) estimates = PETSC_TRUE;
    if (SlipObservations[row[i]].reads & SLIP_READS_METHOD) method = PETSC_TRUE;
    if (!(SlipObservations[row[i]].reads & SLIP_READS_STIFFNESS)) state = PETSC_TRUE;
  }
  if (estimates) {
    PetscCall(TSBatheGetEstimates(ts, &error, NULL, &derivative));
    PetscCall(SlipFaultKeepEstimates(fault, w, error, derivative));
  }
  if (method && fault->kind.inertia) {
    PetscCall(TSBatheGetLongestStep(ts, &fault->known.step_limit));
    PetscCall(TSBatheGetSolveCost(ts, &fault->known.solve_cost));
  }
  if (state && fault->problem.steps.any_integrator) PetscCall(SlipFaultObservedState(fault, ts, t, w, &w));
  PetscCall(SlipFaultObserve(fault, t, w, n, row, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TimeScale_Fault(TS ts, PetscReal *tstar, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  *tstar = ((SlipFault)ctx)->operators.tstar;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Name_Fault(TS ts, const char **name, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  TSBatheMethod method = TSBATHE_METHOD_IMPLICIT;
  PetscBool bathe;

  PetscFunctionBegin;
  PetscCall(TSBatheIs(ts, &bathe));
  if (bathe) PetscCall(TSBatheGetMethod(ts, &method));
  *name = fault->problem.steps.any_integrator && fault->friction.law->always_slides ? "ode" : fault->steps.policy;
  if (method != TSBATHE_METHOD_IMPLICIT && !strcmp(*name, "fault")) *name = "fault_products";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives a reason where policies whose steps are shares of T* are unsuitable. They were trained for single events, but
   loading has no end, and its steps last years. */
static PetscErrorCode Untrained_Fault(TS ts, const char **why, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)ts;
  *why = NULL;
  if (fault->kind.driven) *why = "the fault is loaded or heals or has no inertia, which no policy was trained for";
  if (!fault->kind.driven && !fault->critical.known)
    *why = "the fault does not start from its instability, whose scales the policy needs (-fault_initial)";
  if (SlipFaultPressureFollows(fault)) *why = "slip changes the pore pressure";
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Stop_Fault(TS ts, PetscReal share, Vec w0, Vec wm, Vec w1, Vec k0, PetscReal *stop, void *ctx)
{
  const Vec state[] = {w0, wm, w1};
  PetscReal rtol, h;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetTimeStep(ts, &h));
  PetscCall(SlipFaultStop((SlipFault)ctx, h, rtol, share, state, k0, stop));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Error_Fault(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx)
{
  PetscReal rtol, t, h;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetTimeStep(ts, &h));
  PetscCall(SlipFaultErrorNorm((SlipFault)ctx, rtol, t + h, h, e, w0, w1, E));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Origin_Fault(TS ts, PetscReal origin, PetscReal by, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;

  PetscFunctionBegin;
  (void)ts;
  fault->loads.origin = origin;
  fault->balance.time -= by;
  for (int node = 0; node < SLIP_NUM_NODES; node++) fault->settled.time[node] -= by;
  SlipFaultZoneOrigin(fault, by);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Error_Sticking(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx)
{
  PetscReal rtol;

  PetscFunctionBegin;
  *E = 0;
  if (((SlipFault)ctx)->balance.resting) PetscFunctionReturn(PETSC_SUCCESS); /* a step of rest is exact */
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(SlipFaultStickingErrorNorm((SlipFault)ctx, rtol, 0, e, w0, w1, E));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a medium or shear zones with memory ---- */

/* Friction of a state from which shear zones go on, and a fluid whose permeability follows normal stress */
static PetscErrorCode ZoneFriction(SlipFault fault, PetscReal t, Vec w, SlipFrictionCells *friction)
{
  PetscFunctionBegin;
  friction->stress = NULL;
  if (fault->zone.on || (fault->fluid.stressed && fault->kind.coupled))
    PetscCall(SlipFaultGetFrictionOf(fault, t, w, friction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Accept_Fault(TS ts, PetscReal t, Vec w, PetscBool first, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  Vec u;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  if (first) SlipFaultZoneForget(fault);
  PetscCall(ZoneFriction(fault, t, w, &friction)); /* by the medium's history of the step before */
  PetscCall(SlipFaultZoneAccept(fault, t, w, &friction));
  PetscCall(SlipFaultFluidAccept(fault, t, w, first, fault->kind.coupled ? friction.stress : NULL));
  PetscCall(SlipElasticAccept(fault->medium, t, u, first));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Advance_Fault(TS ts, PetscReal t, Vec w, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  Vec u;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetDisplacement(fault, w, u));
  PetscCall(ZoneFriction(fault, t, w, &friction));
  PetscCall(SlipFaultZoneAdvance(fault, t, w, &friction));
  PetscCall(SlipFaultFluidAdvance(fault, t, w, fault->kind.coupled ? friction.stress : NULL));
  PetscCall(SlipElasticAdvance(fault->medium, t, u));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RollBack_Fault(TS ts, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultZoneRollBack((SlipFault)ctx));
  PetscCall(SlipFaultFluidRollBack((SlipFault)ctx));
  PetscCall(SlipElasticRollBack(((SlipFault)ctx)->medium));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HistoryError_Fault(TS ts, PetscReal t, Vec w, PetscReal *E, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal rtol, fluid;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(SlipFaultFluidError(fault, rtol, t, w, &fluid));
  *E = 0;
  /* explicit steps: the rate of w is that of the start, and the last right-hand side was at its end */
  if (fault->zone.presses)
    PetscCall(
      SlipFaultZoneError(fault, rtol, t, w, fault->problem.steps.any_integrator ? fault->balance.rate : NULL, E));
  *E = PetscMax(*E, fluid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TSPreStep. PETSc does not call it again for a step that an event searches. PETSc's own types do not use
   SlipProblemOps. */
static PetscErrorCode BeforeStep(TS ts)
{
  const SlipProblemOps *problem;
  PetscBool ours;
  PetscInt step;
  PetscReal t;
  void *fault;
  Vec w;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &problem, &fault));
  PetscCall(SlipFaultLimitStep((SlipFault)fault, ts));
  if (problem->steps.any_integrator && !((SlipFault)fault)->friction.law->always_slides)
    PetscCall(SlipFaultBeginRest((SlipFault)fault, ts));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts, &ours, TSADAMS, TSBATHE, TSMOREAU, TSRKC, TSLAPUSTA, ""));
  if (!ours && problem->steps.any_integrator && !((SlipFault)fault)->friction.law->always_slides)
    PetscCall(SlipMeetRelaxation(ts));
  if (ours || problem->steps.any_integrator)
    PetscCall(SlipMeetCornerBefore(ts, ours, &((SlipFault)fault)->corner_passed));
  if (ours || !problem->history.accept) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!((SlipFault)fault)->fluid.follows, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
             "-ts_type %s does not see the error of a pressure that slip changes by the normal stress of "
             "-fault_permeability_law %s: expected adams, bathe or rkc",
             ((PetscObject)ts)->type_name, ((SlipFault)fault)->options.text[FAULT_PERMEABILITY_LAW]);
  PetscCall(TSGetStepNumber(ts, &step));
  PetscCall(TSGetTime(ts, &t));
  PetscCall(TSGetSolution(ts, &w));
  PetscCall((*problem->history.accept)(ts, t, w, step == 0 ? PETSC_TRUE : PETSC_FALSE, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const SlipProblemOps FaultProblem = {.control = {.name = Name_Fault,
                                                        .time_scale = TimeScale_Fault,
                                                        .untrained = Untrained_Fault,
                                                        .rest_time = SlipFaultRestTime,
                                                        .measures = PETSC_TRUE},
                                            .history = {.origin = Origin_Fault},
                                            .observations = {.find = Find_Fault, .observe = Observe_Fault}};
/* Computes dw/dt = A^-1 F_s(w), the smooth part, for integrators that do not handle the constraint. */
static PetscErrorCode SlipFaultRHS(TS ts, PetscReal t, Vec w, Vec F, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  PetscReal *a;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultSmooth(fault, t, w, F));
  PetscCall(VecGetArray(F, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    for (PetscInt k = SlipFaultRateAt(fault, i); k < SlipFaultDisplacementAt(fault, i); k++)
      a[k] /= fault->operators.mass * fault->mesh.weight[i];
  PetscCall(VecRestoreArray(F, &a));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultSetTolerances(SlipFault fault, TS ts)
{
  Vec atol;
  PetscReal *a, rate;

  PetscFunctionBegin;
  PetscCall(SlipFaultGetReal(fault, "rate_tolerance", &rate));
  PetscCall(SlipFaultCreateState(fault, &atol));
  PetscCall(VecGetArray(atol, &a));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    for (PetscInt k = 0; k < fault->layout.components; k++) {
      a[SlipFaultRateAt(fault, i) + k] = rate;
      a[SlipFaultDisplacementAt(fault, i) + k] = SLIP_FAULT_ATOL;
    }
    for (PetscInt k = 0; k < fault->layout.states; k++) a[SlipFaultStateAt(fault, i) + k] = SLIP_FAULT_ATOL;
  }
  PetscCall(VecRestoreArray(atol, &a));
  PetscCall(TSSetTolerances(ts, PETSC_DEFAULT, atol, PETSC_DEFAULT, NULL));
  PetscCall(VecDestroy(&atol));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ConfigureBathe(SlipFault fault, TS ts)
{
  /* Friction of 1e8 Pa balances slip rates of 1e-9 m/s, of which radiation damping makes 1e-3 Pa */
  const PetscReal driven = 1e-13;
  const PetscReal smooth = 1e-11; /* relative to 1e7 Pa; a sigma, the effect of ln v, is some 1e5 Pa */
  PetscBool ours;
  PetscReal step;
  SNES snes;
  KSP ksp;
  PC pc;

  PetscFunctionBegin;
  PetscCall(SlipFaultConstraintCreate(fault));
  PetscCall(TSSetProblemType(ts, TS_NONLINEAR));
  PetscCall(TSBatheIs(ts, &ours));
  if (!ours) PetscCall(TSSetType(ts, TSBATHE)); /* -ts_type may change it to TSMOREAU later */
  PetscCall(TSSetRHSFunction(ts, NULL, SlipFaultRHS, fault));
  PetscCall(TSBatheSetConstraint(ts, fault->stage.con));
  PetscCall(TSGetSNES(ts, &snes));
  if (fault->kind.driven) {
    PetscCall(TSBatheSetFirstStage(ts, TSBATHE_STAGE_BACKWARD));
    PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, driven, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  }
  PetscCall(SlipFaultSetTolerances(fault, ts));
  PetscCall(SlipFaultConfigureSteps(fault, ts));
  PetscCall(TSSetTimeStep(ts, SLIP_FAULT_FIRST_STEP * fault->operators.tstar));
  if (!fault->friction.law->always_slides) PetscFunctionReturn(PETSC_SUCCESS);
  /* With a smooth law the Jacobian's diagonal varies by decades from cell to cell: the force must be small in all cells
     alike, and the diagonal is most of the Jacobian in sufficiently exact steps. */
  PetscCall(SNESSetTolerances(snes, PETSC_DEFAULT, smooth, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetNormType(ksp, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(SlipFaultFirstStep(fault, &step));
  PetscCall(TSSetTimeStep(ts, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the problem is explicit, as friction without inertia under radiation damping may be: smooth friction
   unless options select TSBATHE or TSMOREAU, some ruptures by default, and other sticking friction where options select
   TSRKC, TSRK or TSADAMS. Other faults refuse such a type here, before an error about a missing constraint. */
static PetscErrorCode IsExplicit(SlipFault fault, TS ts, PetscBool *is)
{
  const PetscBool balanced = !fault->kind.inertia && fault->balance.eta > 0 && !SlipFaultOpens(fault);
  char type[64] = "";
  const char *prefix;
  void (*create)(void) = NULL;
  PetscBool asked, moreau;

  PetscFunctionBegin;
  PetscCall(TSGetOptionsPrefix(ts, &prefix));
  PetscCall(PetscOptionsGetString(((PetscObject)ts)->options, prefix, "-ts_type", type, sizeof(type), NULL));
  if (type[0]) PetscCall(PetscFunctionListFind(TSList, type, &create));
  PetscCheck(!type[0] || create, fault->comm, PETSC_ERR_ARG_UNKNOWN_TYPE, "there is no type \"%s\" of TS (-%sts_type)",
             type, prefix ? prefix : "");
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSMOREAU, &moreau));
  moreau = moreau || !strcmp(type, TSMOREAU) ? PETSC_TRUE : PETSC_FALSE;
  asked = !strcmp(type, TSRK) || !strcmp(type, TSADAMS) || !strcmp(type, TSRKC) || !strcmp(type, TSLAPUSTA);
  *is = balanced &&
        (asked || fault->kind.waves || (fault->friction.law->always_slides && strcmp(type, TSBATHE) && !moreau));
  if (balanced && !type[0] && !*is) PetscCall(SlipFaultExplicitIsDefault(fault, ts, is));
  if (!asked || *is) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSSetType(ts, type));
  PetscCall(SlipFaultCheckFeatures(fault, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SlipFaultAttach(SlipFault fault, TS ts, PetscBool is_explicit)
{
  SlipProblemOps *problem = &fault->problem;
  PetscBool remembers;

  PetscFunctionBegin;
  PetscCall(SlipElasticRemembers(fault->medium, &remembers));
  if (fault->zone.on || fault->fluid.on) remembers = PETSC_TRUE;
  if (SlipFaultPressureFollows(fault)) problem->history.error = HistoryError_Fault;
  if (remembers) {
    problem->history.accept = Accept_Fault;
    problem->history.advance = Advance_Fault;
    problem->history.rollback = RollBack_Fault;
  }
  if (remembers || is_explicit || SlipLoadsChange(&fault->loads)) PetscCall(TSSetPreStep(ts, BeforeStep));
  problem->steps.any_integrator = is_explicit;
  fault->corner_passed = PETSC_FALSE;
  problem->steps.finish = is_explicit ? SlipFaultFinishStep : NULL;
  problem->steps.relaxation = is_explicit ? SlipFaultRelaxation : NULL;
  problem->drifts.drift = is_explicit ? SlipFaultDrift : NULL;
  problem->control.slip_step = is_explicit ? SlipFaultSlipStep : NULL;
  problem->drifts.shortest = is_explicit ? SlipFaultShortestStep : NULL;
  problem->drifts.waits = is_explicit && !fault->friction.law->always_slides ? SlipFaultWaits : NULL;
  problem->steps.begin = is_explicit ? NULL : SlipFaultBeginSteps;
  problem->control.hand_over = is_explicit ? NULL : SlipFaultHandOverSteps;
  if (fault->kind.driven) { /* a driven fault rests for years between events */
    problem->steps.corner = SlipFaultNextCorner;
    problem->steps.rest =
      fault->friction.law->nstates || fault->zone.presses ? NULL : SlipFaultRest; /* they evolve at rest */
    problem->steps.error = !is_explicit ? Error_Fault : fault->friction.law->always_slides ? NULL : Error_Sticking;
    if (fault->kind.inertia && !fault->friction.law->by_rate) problem->steps.stop = Stop_Fault;
  }
  if (!is_explicit) PetscCall(SlipFaultSidesAttach(fault));
  PetscCall(PetscObjectCompose((PetscObject)ts, "SlipFault", (PetscObject)fault));
  PetscCall(TSSetSlipProblem(ts, problem, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  SlipFaultConfigureTS - makes a TS integrate the fault

  Collective; after SlipFaultSetUp(), before TSSetFromOptions().

  Input Parameters:
+ fault - the fault; the TS keeps a reference
- ts    - the TS

  Notes:
  The function sets the type bathe with the fault's friction as its constraint, the smooth right-hand side, a vector of
  absolute tolerances (1e-10 m for u and s, 1e-10 m/T* for v unless -fault_rate_tolerance sets it), max time 30 s
  (-ts_max_time), exact final time matchstep (-ts_exact_final_time), unlimited rejections and failed solves, first step
  0.01 T* (-ts_dt), and the functions that controllers call (TSSetSlipProblem()).

  The controller (-ts_adapt_type) is TSADAPTRL from the instability (with inertia), from another start and under a pore
  pressure, with slip weakening, where its policy exists, was trained for -fault_accuracy, and no tolerance is given
  (-ts_rtol, TSSetTolerances(), -fault_tolerances, options of pi and dsp). With inertia, from the instability and from a
  given stress, its steps are explicit or implicit, whichever needs fewer products (-ts_bathe_method auto); from the
  instability it uses the policy fault_products.h5. This does not apply where -ts_bathe_method or TSBatheSetMethod()
  selects a method, the damping ratio is above 0.6, an option of implicit steps is given (-ts_bathe_gamma,
  -ts_bathe_first_stage, -ts_bathe_reaction, -ts_bathe_stage_error), another error than that of the history is bounded,
  or the named policy was trained on implicit steps. Cells that may open use pi, with inertia by such steps down to the
  accuracy 1e-2. Other faults use pi with the filter fault_history from the instability, pi from another start, basic
  under a pore pressure, heuristic with smooth friction, and dsp where the fault is loaded or heals.

  TSSolve() sets the relative tolerance when it begins, for the controller of the run, unless -ts_rtol is given or
  TSSetTolerances() was called after this function. It is the tolerance at which the controller satisfies
  -fault_accuracy, 1e-2 by default (see SlipFaultFindTolerance()), or that of the file of -fault_tolerances. With smooth
  friction and for other controllers it is 1e-3, and 1e-4 for a fault that is loaded or heals. -fault_accuracy is also
  the accuracy of TSADAPTRL, unless that has its own.

  With smooth friction (rate_and_state), no inertia and radiation damping the fault is an explicit problem instead: u
  and the state are integrated, a right-hand side costs one product with K, and v is set to that of the balance after
  each step. The type is TSADAMS under TSADAPTPI, or with a pore pressure under TSADAPTDSP. Under loading, rtol
  satisfies -fault_accuracy, 1e-2 by default, for the times of events, over the recurrence, in 95 % of drawn faults; it
  is 1e-3 under a pore pressure, with waves, and where an option names another type or controller. 1e-3 means errors of
  1e-3 d_c in u and 1e-3 in ln theta of the worst cell (SlipAdaptSetNorm()). The first step is 0.01 of the time in which
  the fastest cell slips its d_c. With -ts_type bathe among the options, and with inertia, the type is bathe, with
  errors relative to d_c and the slip rate.

  Friction that sticks is an explicit problem, too, without inertia, with radiation damping and without opening: the
  slip rate of a cell follows from its stress, 0 where friction holds it. A rupture due to weakening with slip, from a
  given stress that nothing changes, is one by default, by TSRKC, unless the TS has the type TSBATHE already, or an
  option names a type, a controller, tolerances (-fault_tolerances) or the check of -fault_check_error, or belongs to
  TSBATHE, its SNES, KSP or PC. Other runs are where the options name -ts_type rkc, rk or adams. With TSRKC and TSADAMS
  -fault_accuracy sets the tolerance of such a rupture. Otherwise it is 1e-2 for TSRKC and 1e-3 for the others. Errors
  are those of the worst cell over d_c or the largest displacement; in such a rupture over d_c, or a tenth of the
  largest displacement while that is less. Rest is skipped, as with bathe, and steps end at corners of the loading.
  While any cell slips they are seconds to minutes, so that they are faster for events of seconds, and slower for slip
  of days or years. Where stress changes in time, classical controllers of TSBATHE therefore choose these steps or
  implicit ones by cost (-ts_bathe_method auto, the default there).

  With -ts_type moreau, or where the TS has that type already, a fault with inertia takes explicit steps, and friction
  is solved cell by cell; without inertia this is an error.

  Errors: PETSC_ERR_ORDER before SlipFaultSetUp(); PETSC_ERR_FILE_OPEN or PETSC_ERR_FILE_UNEXPECTED, naming file and
  dataset, where the file of tolerances is needed and missing, damaged or of another version

  Level: beginner

.seealso: SlipFaultFindTolerance(), SlipFaultCreateState(), SlipFaultSetInitialState(), SlipAdaptSetNorm(), TSADAMS,
  TSRKC, TSBATHE, TSMOREAU
@*/
PetscErrorCode SlipFaultConfigureTS(SlipFault fault, TS ts)
{
  PetscBool is_explicit;

  PetscFunctionBegin;
  SlipFaultCheckSetUp(fault, 1);
  PetscValidHeaderSpecific(ts, TS_CLASSID, 2);
  PetscCall(IsExplicit(fault, ts, &is_explicit));
  fault->problem = FaultProblem;
  SlipFaultChooseSteps(fault, is_explicit);
  if (is_explicit)
    PetscCall(SlipFaultExplicitConfigure(fault, ts));
  else
    PetscCall(ConfigureBathe(fault, ts));
  PetscCall(TSSetMaxTime(ts, SLIP_FAULT_MAX_TIME));
  PetscCall(TSSetMaxSteps(ts, PETSC_MAX_INT));
  PetscCall(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  PetscCall(TSSetMaxSNESFailures(ts, SLIP_UNLIMITED));
  PetscCall(TSSetMaxStepRejections(ts, SLIP_UNLIMITED));
  PetscCall(SlipFaultAttach(fault, ts, is_explicit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
