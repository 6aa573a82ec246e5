/* TSBATHE as a PETSc TS type: creation, options, view, interpolation. The step is in bathestep.c, its stages in
   bathestage.c. */
#include <slipstep/private/slipbathe.h>
#include <slipstep/rooms/slipsys.h>

/* PETSc's defaults of -ts_max_snes_failures, by which the first failed stage ends a run, and of -ts_max_reject */
#define PETSC_FAILURES 1
#define PETSC_REJECTIONS 10

static PetscBool cited = PETSC_FALSE;
static const char citation[] =
  "@article{Bathe2005,\n"
  "  title   = {On a composite implicit time integration procedure for nonlinear dynamics},\n"
  "  author  = {Klaus-J\\\"urgen Bathe and Mirza M. Irfan Baig},\n"
  "  journal = {Computers \\& Structures},\n"
  "  volume  = {83},\n"
  "  pages   = {2513--2524},\n"
  "  year    = {2005}\n}\n";

const char *const TSBatheMethods[] = {"implicit", "explicit", "auto", "TSBatheMethod", "TSBATHE_METHOD_", NULL};
const char *const TSBatheReactionTypes[] = {"trapezoidal", "implicit", "TSBatheReactionType", "TSBATHE_REACTION_",
                                            NULL};
const char *const TSBatheFirstStages[] = {"trapezoidal", "backward", "TSBatheFirstStage", "TSBATHE_STAGE_", NULL};
const char *const TSBatheErrors[] = {"embedded", "doubling", "none", "TSBatheError", "TSBATHE_ERROR_", NULL};

static PetscErrorCode TSReset_Bathe(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec *vecs[] = {&ba->X0,
                 &ba->Y[0],
                 &ba->Y[1],
                 &ba->K0,
                 &ba->K1,
                 &ba->K2,
                 &ba->Wm,
                 &ba->parts.Wfull,
                 &ba->parts.Wmid,
                 &ba->stages.base,
                 &ba->stages.affine,
                 &ba->stages.Xdot,
                 &ba->estimate.E,
                 &ba->r0,
                 &ba->stages.r1,
                 &ba->x,
                 &ba->parts.rmid,
                 &ba->stages.Fs};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  PetscCall(TSMoreauReset(ts));
  PetscCall(TSStabilisedReset(ts));
  ba->k0_known = ba->k2_known = PETSC_FALSE;
  ba->sol_id = 0;
  ba->was = &TSBatheImplicit;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSDestroy_Bathe(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(TSReset_Bathe(ts));
  PetscCall(TSBatheMonitorCancel(ts));
  PetscCall(VecDestroy(&ba->r));
  if (ba->con && ts->snes) PetscCall(SNESSetSlipConstraint(ts->snes, NULL)); /* another type cannot use it */
  PetscCall(SlipConstraintDestroy(&ba->con));
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", NULL));
  if (ba->failures.lifted && ts->max_snes_failures == SLIP_UNLIMITED) ts->max_snes_failures = PETSC_FAILURES;
  if (ba->failures.rejections && ts->max_reject == SLIP_UNLIMITED) ts->max_reject = PETSC_REJECTIONS;
  PetscCall(PetscFree(ts->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once of options that have no effect because of another choice. */
static PetscErrorCode TSBatheWarnOfIdle(TS ts)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  const PetscBool backward = ba->stages.first == TSBATHE_STAGE_BACKWARD ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool stages = ba->choice.method != TSBATHE_METHOD_EXPLICIT ? PETSC_TRUE : PETSC_FALSE;
  static struct {
    const char *option;
    PetscBool told;
  } row[] = {{"-ts_bathe_gamma", PETSC_FALSE},
             {"-ts_bathe_reaction", PETSC_FALSE},
             {"-ts_bathe_order", PETSC_FALSE},
             {"-ts_adapt_dt_max", PETSC_FALSE}};
  const char *why[] = {backward ? "-ts_bathe_first_stage is backward, which halves the step" : NULL,
                       !ba->con   ? "the problem has no set-valued reaction"
                       : backward ? "-ts_bathe_first_stage is backward, which has only one treatment of it"
                                  : NULL,
                       ba->estimate.type != TSBATHE_ERROR_DOUBLING ? "it is for -ts_bathe_error doubling" : NULL, NULL};
  PetscMPIInt rank;
  PetscBool constant;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  if (!stages) why[0] = why[1] = "explicit steps (-ts_type " TSMOREAU ") have no stages";
  if (constant) why[3] = "steps are constant (-ts_adapt_type none)";
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(row) && !rank; i++) {
    PetscBool given;

    if (!why[i] || row[i].told) continue;
    PetscCall(PetscOptionsHasName(((PetscObject)ts)->options, ((PetscObject)ts)->prefix, row[i].option, &given));
    if (!given) continue;
    row[i].told = PETSC_TRUE;
    PetscCall(SlipWarning("-%s%s has no effect: %s", ((PetscObject)ts)->prefix ? ((PetscObject)ts)->prefix : "",
                          row[i].option + 1, why[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSSetUp_Bathe(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec *full[] = {&ba->X0, &ba->Y[0], &ba->Y[1], &ba->K0, &ba->K1, &ba->K2, &ba->Wm, &ba->stages.base, &ba->estimate.E};
  TSIFunction ifunction;
  PetscBool ours;
  SNES snes;
  DM dm;

  PetscFunctionBegin;
  PetscCall(PetscCitationsRegister(citation, &cited));
  if (!ba->stages.first_set && !ba->con) {
    PetscCall(TSGetDM(ts, &dm));
    PetscCall(DMTSGetIFunction(dm, &ifunction, NULL));
    PetscCall(TSBatheSetFirstStage(ts, ifunction ? TSBATHE_STAGE_BACKWARD : TSBATHE_STAGE_TRAPEZOIDAL));
    ba->stages.first_set = PETSC_FALSE;
  }
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(full); i++)
    if (!*full[i]) PetscCall(VecDuplicate(ts->vec_sol, full[i]));
  if (ba->con) {
    if (!ba->stages.Fs) PetscCall(VecDuplicate(ts->vec_sol, &ba->stages.Fs));
    if (!ba->r0) PetscCall(VecDuplicate(ba->r, &ba->r0));
    if (!ba->stages.r1) PetscCall(VecDuplicate(ba->r, &ba->stages.r1));
    if (!ba->x) PetscCall(VecDuplicate(ba->r, &ba->x));
  } else {
    if (!ba->stages.affine) PetscCall(VecDuplicate(ts->vec_sol, &ba->stages.affine));
    if (!ba->stages.Xdot) PetscCall(VecDuplicate(ts->vec_sol, &ba->stages.Xdot));
  }
  PetscCall(TSGetAdapt(ts, &ts->adapt));
  PetscCall(TSAdaptCandidatesClear(ts->adapt));
  PetscCall(TSBatheWarnOfIdle(ts));
  PetscCall(TSGetSNES(ts, &snes));
  if (ba->con) {
    PetscCall(PetscObjectTypeCompareAny((PetscObject)snes, &ours, SNESSEMISMOOTH, SNESPROJECTION, ""));
    PetscCheck(ours, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
               "-%ssnes_type %s cannot solve a set-valued reaction: use semismooth or projection",
               ((PetscObject)snes)->prefix ? ((PetscObject)snes)->prefix : "", ((PetscObject)snes)->type_name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSSetFromOptions_Bathe(TS ts, SlipOptionItems PetscOptionsObject)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool flg;
  PetscReal gamma = ba->stages.gamma, stage_error = ba->stages.allowed;
  PetscInt order = ba->estimate.order;
  TSBatheReactionType reaction = ba->stages.reaction;
  TSBatheFirstStage first = ba->stages.first;
  TSBatheError error = ba->estimate.type;
  TSBatheMethod method = ba->choice.method;
  PetscBool moreau;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)ts, TSMOREAU, &moreau));
  PetscOptionsHeadBegin(PetscOptionsObject, "Bathe composite integrator options");
  if (!moreau) {
    PetscCall(PetscOptionsEnum(
      "-ts_bathe_method",
      "How steps are computed: implicit (default), explicit, or auto, each as takes fewer products (default of single "
      "events and ruptures with inertia under rl)",
      "TSBatheSetMethod", TSBatheMethods, (PetscEnum)method, (PetscEnum *)&method, &flg));
    if (flg) PetscCall(TSBatheSetMethod(ts, method));
  }
  PetscCall(PetscOptionsReal("-ts_bathe_gamma", "Split of the step, dimensionless in (0, 1): 0.5 is Bathe's",
                             "TSBatheSetGamma", gamma, &gamma, &flg));
  if (flg) PetscCall(TSBatheSetGamma(ts, gamma));
  PetscCall(PetscOptionsEnum(
    "-ts_bathe_first_stage",
    "Rule of stage 1: trapezoidal, or backward (default of faults that are loaded or heal, and of a problem by "
    "TSSetIFunction())",
    "TSBatheSetFirstStage", TSBatheFirstStages, (PetscEnum)first, (PetscEnum *)&first, &flg));
  if (flg) PetscCall(TSBatheSetFirstStage(ts, first));
  PetscCall(PetscOptionsEnum(
    "-ts_bathe_reaction",
    "Reaction in stage 1: trapezoidal (second order, default) or implicit (first order, published)",
    "TSBatheSetReactionType", TSBatheReactionTypes, (PetscEnum)reaction, (PetscEnum *)&reaction, &flg));
  if (flg) PetscCall(TSBatheSetReactionType(ts, reaction));
  PetscCall(PetscOptionsEnum("-ts_bathe_error", "Error estimate: embedded (default), doubling or none",
                             "TSBatheSetError", TSBatheErrors, (PetscEnum)error, (PetscEnum *)&error, &flg));
  if (flg) PetscCall(TSBatheSetError(ts, error));
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)ts), ((PetscObject)ts)->options,
                                   ((PetscObject)ts)->prefix, "-ts_bathe_order"));
  PetscCall(PetscOptionsInt("-ts_bathe_order",
                            "Order p >= 1 assumed by doubling's 1/(2^p - 1) (default 1, as published)",
                            "TSBatheSetDoublingOrder", order, &order, &flg));
  if (flg) PetscCall(TSBatheSetDoublingOrder(ts, order));
  PetscCall(SlipCheckIntegerOption(PetscObjectComm((PetscObject)ts), ((PetscObject)ts)->options,
                                   ((PetscObject)ts)->prefix, "-ts_bathe_max_failures"));
  PetscCall(PetscOptionsInt("-ts_bathe_max_failures",
                            "Attempts >= 1 in a row that may fail to converge before the run stops (default 50)", "",
                            ba->failures.most, &ba->failures.most, NULL));
  PetscCheck(ba->failures.most >= 1, PetscObjectComm((PetscObject)ts), PETSC_ERR_ARG_OUTOFRANGE,
             "-ts_bathe_max_failures is %" PetscInt_FMT ", expected at least 1", ba->failures.most);
  PetscCall(PetscOptionsReal("-ts_bathe_stage_error",
                             "What inexact solves of stages may add to the local error of a step, over that, in [0, 1) "
                             "(default 0.1); 0: to -snes_rtol",
                             "TSBatheSetStageError", stage_error, &stage_error, &flg));
  if (flg) PetscCall(TSBatheSetStageError(ts, stage_error));
  PetscOptionsHeadEnd();
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSView_Bathe(TS ts, PetscViewer viewer)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool ascii;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  if (ba->choice.method == TSBATHE_METHOD_AUTO)
    PetscCall(PetscViewerASCIIPrintf(
      viewer, "  explicit or implicit, as takes fewer products; explicit attempts=%" PetscInt_FMT "\n",
      ba->totals.explicits));
  if (ba->choice.method == TSBATHE_METHOD_EXPLICIT)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  explicit, error estimate %s\n", TSBatheErrors[ba->estimate.type]));
  else if (ba->stages.first == TSBATHE_STAGE_BACKWARD)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  both stages backward, error estimate %s, reaction %s\n",
                                     TSBatheErrors[ba->estimate.type], ba->con ? "implicit" : "absent"));
  else
    PetscCall(PetscViewerASCIIPrintf(viewer, "  gamma=%g, error estimate %s, reaction %s\n", (double)ba->stages.gamma,
                                     TSBatheErrors[ba->estimate.type],
                                     ba->con ? TSBatheReactionTypes[ba->stages.reaction] : "absent"));
  if (ba->estimate.type == TSBATHE_ERROR_DOUBLING)
    PetscCall(PetscViewerASCIIPrintf(viewer, "  order assumed by doubling=%" PetscInt_FMT "\n", ba->estimate.order));
  PetscCall(PetscViewerASCIIPrintf(viewer,
                                   "  attempts=%" PetscInt_FMT ", accepted=%" PetscInt_FMT
                                   ", Bathe solves=%" PetscInt_FMT ", failures in a row allowed=%" PetscInt_FMT "\n",
                                   ba->totals.attempts, ba->totals.accepted, ba->totals.solves, ba->failures.most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Interpolates by the cubic through the step's start, an inner state and its end, with the end's derivative. It is of
   fourth order locally and needs no derivative at the start. */
static PetscErrorCode TSInterpolate_Bathe(TS ts, PetscReal t, Vec w)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal h = ts->ptime - ts->ptime_prev, s, e, c = ba->share;
  PetscScalar weight[4];
  Vec vecs[4];

  PetscFunctionBegin;
  switch (ba->status) {
  case TS_STEP_INCOMPLETE:
  case TS_STEP_PENDING:
    h = ts->time_step;
    s = (t - ts->ptime) / h;
    break;
  default:
    s = (t - ts->ptime_prev) / h;
    break;
  }
  if (ba->was->hermite && ba->last.solves == 1) { /* Hermite's cubic */
    vecs[0] = ba->X0;
    weight[0] = (1 + 2 * s) * PetscSqr(1 - s);
    vecs[1] = ba->Y[1];
    weight[1] = 1 - weight[0];
    vecs[2] = ba->K0;
    weight[2] = h * s * PetscSqr(1 - s);
    vecs[3] = ba->K2;
    weight[3] = h * s * s * (s - 1);
    PetscCall(VecZeroEntries(w));
    PetscCall(VecMAXPY(w, 4, weight, vecs));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /* p(s) = w2 + (s-1) h k2 + (s-1)^2 (A + B s), A and B from p(0) = w0 and p(c) = wm */
  e = PetscSqr(s - 1.0);
  vecs[0] = ba->X0;
  weight[0] = e * (1.0 - s / c);
  vecs[1] = ba->Wm;
  weight[1] = e * s / (c * PetscSqr(1.0 - c));
  vecs[2] = ba->Y[1];
  weight[2] = 1.0 - weight[0] - weight[1];
  vecs[3] = ba->K2;
  weight[3] = h * (s - 1.0 + e * (1.0 + s / c * (1.0 / (1.0 - c) - 1.0)));
  PetscCall(VecZeroEntries(w));
  PetscCall(VecMAXPY(w, 4, weight, vecs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSEvaluateWLTE_Bathe(TS ts, NormType wnormtype, PetscInt *order, PetscReal *wlte)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (order)
    *order =
      ba->estimate.type == TSBATHE_ERROR_DOUBLING ? ba->estimate.order + 1 : 3; /* the power of h in the estimate */
  *wlte = ba->last.error;
  if (ba->last.error >= 0.0 && wnormtype != NORM_2) PetscCall(TSBatheErrorNorm(ts, wnormtype, wlte));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSGetStages_Bathe(TS ts, PetscInt *n, Vec **Y)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (n) *n = 2;
  if (Y) *Y = ba->Y;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the stability function of the trapezoidal or backward rule and the three-point backward formula. */
static PetscErrorCode TSComputeLinearStability_Bathe(TS ts, PetscReal xr, PetscReal xi, PetscReal *yr, PetscReal *yi)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipBathe c = ba->stages.c;
  PetscReal b = c.theta[1], g = c.theta[0], nr, ni, dr, di, d2, wr, wi;

  PetscFunctionBegin;
  nr = 1.0, ni = 0.0;
  if (ba->stages.first == TSBATHE_STAGE_TRAPEZOIDAL) nr += g * xr, ni += g * xi;
  dr = 1.0 - g * xr, di = -g * xi, d2 = dr * dr + di * di;
  wr = c.a1 * (nr * dr + ni * di) / d2 - c.a0, wi = c.a1 * (ni * dr - nr * di) / d2;
  dr = 1.0 - b * xr, di = -b * xi, d2 = dr * dr + di * di;
  *yr = (wr * dr + wi * di) / d2;
  *yi = (wi * dr - wr * di) / d2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSBATHE - "bathe": implicit composite integrator, the trapezoidal rule to t + gamma h and the three-point backward
  formula from there to t + h

  Options Database Keys:
+ -ts_bathe_method <implicit,explicit,auto>  - method of steps, TSBatheSetMethod()
. -ts_bathe_gamma <0.5>                      - split of the step, dimensionless
. -ts_bathe_first_stage <trapezoidal,backward> - rule of stage 1
. -ts_bathe_reaction <trapezoidal,implicit>  - treatment of a set-valued reaction in stage 1
. -ts_bathe_error <embedded,doubling,none>   - error estimate
. -ts_bathe_order <1>                        - order p assumed by doubling
. -ts_bathe_stage_error <0.1>                - error that inexact solves of stages may add, over a step's error
- -ts_bathe_max_failures <50>                - attempts in a row that may fail to converge

  Level: beginner

  Notes:
  The method is of second order and L-stable for gamma in (0, 1). Without a constraint it integrates any
  TSSetRHSFunction() or TSSetIFunction() problem, also differential-algebraic ones of index 1. With a constraint
  (TSBatheSetConstraint()) SNESSEMISMOOTH or SNESPROJECTION solves stages for the constraint's reduced unknowns. Both
  stages are backward where there is an IFunction: the trapezoidal one is for an IFunction A w' + f(t, w) with a
  constant A (TSBatheSetFirstStage()).

  A stage that does not converge does not end the run: the attempt is repeated with the step that the controller
  chooses, or that of PETSc's -ts_adapt_scale_solve_failed, until -ts_bathe_max_failures attempts in a row have failed.
  PETSc's defaults of one failed solve in a run and ten rejections of a step are lifted; -ts_max_snes_failures,
  -ts_max_reject and their functions with other numbers hold. The latter counts the attempts that the controller
  rejects. Constant steps (TSADAPTNONE) become shorter then, with a warning, and grow back to their length.

  Stages of a constraint whose operator is affine are solved as accurately as the error of the step needs
  (TSBatheSetStageError()); the first step after a start, steps without an estimate and those under -snes_rtol are
  solved to rounding.

  The embedded estimate is zero in the rate rows of cells that stick at the end of the step: their rate is exact
  there, and their jump in acceleration is no error of the method. Their displacement and slip rows keep it.

  The embedded estimate costs no solve. It needs w' at the start, which a problem given by TSSetIFunction() alone does
  not determine, so doubling estimates the first step after a start or TSRestartStep().

  There is no doubling, and the solution is the single step h, if the controller needs no error
  ("TSAdaptNeedsError_C"), and with -ts_adapt_type none or history unless -ts_bathe_error doubling is given. That
  changes neither the order of the method nor any decision, because such a controller does not use the error.

  References:
+ * - K. J. Bathe, M. M. I. Baig, On a composite implicit time integration procedure for nonlinear dynamics,
      Comput. Struct. 83, 2005.
. * - R. E. Bank et al., Transient simulation of silicon devices and circuits, IEEE Trans. CAD 4, 1985.
- * - M. E. Hosea, L. F. Shampine, Analysis and implementation of TR-BDF2, Appl. Numer. Math. 20, 1996.

.seealso: TSBatheSetConstraint(), TSBatheSetError(), TSBatheSetReactionType(), TSMOREAU, TSTHETA, TSALPHA2
M*/
PetscErrorCode TSCreate_Bathe(TS ts)
{
  TS_Bathe *ba;

  PetscFunctionBegin;
  PetscCall(PetscNew(&ba));
  ts->data = ba;
  ba->stages.gamma = 0.5;
  SlipBatheSetUp(ba->stages.gamma, &ba->stages.c);
  ba->estimate.order = 1;
  ba->failures.most = 50;
  ba->stages.allowed = 0.1;
  SlipMethodSetUp(&ba->moreau.costs);
  ba->now = ba->was = &TSBatheImplicit;
  ba->share = 0.5;
  ba->status = TS_STEP_COMPLETE;
  ts->ops->reset = TSReset_Bathe;
  ts->ops->destroy = TSDestroy_Bathe;
  ts->ops->view = TSView_Bathe;
  ts->ops->setup = TSSetUp_Bathe;
  ts->ops->setfromoptions = TSSetFromOptions_Bathe;
  ts->default_adapt_type = TSADAPTNONE;
  ts->usessnes = PETSC_TRUE;
  /* given options are read later */
  ba->failures.lifted = ts->max_snes_failures == PETSC_FAILURES ? PETSC_TRUE : PETSC_FALSE;
  ba->failures.rejections = ts->max_reject == PETSC_REJECTIONS ? PETSC_TRUE : PETSC_FALSE;
  if (ba->failures.lifted) ts->max_snes_failures = SLIP_UNLIMITED;
  if (ba->failures.rejections) ts->max_reject = SLIP_UNLIMITED;
  PetscCall(PetscObjectComposeFunction((PetscObject)ts, "TSBatheGetLastAttempt_C", TSBatheGetLastAttempt));
  PetscCall(PetscObjectQuery((PetscObject)ts, TSBATHE_CONSTRAINT, (PetscObject *)&ba->con));
  if (ba->con) { /* the TS had it as the other type, TSBatheSetConstraint() */
    PetscCall(PetscObjectReference((PetscObject)ba->con));
    PetscCall(SlipConstraintGetOps(ba->con, &ba->ops));
    PetscCall(SlipConstraintGetContext(ba->con, &ba->ctx));
    PetscCall(SlipConstraintCreateReduced(ba->con, &ba->r));
    if (ts->snes) PetscCall(SNESSetSlipConstraint(ts->snes, ba->con));
  }
  ts->ops->step = TSStep_Bathe;
  ts->ops->evaluatewlte = TSEvaluateWLTE_Bathe;
  ts->ops->rollback = TSRollBack_Bathe;
  ts->ops->interpolate = TSInterpolate_Bathe;
  ts->ops->getstages = TSGetStages_Bathe;
  ts->ops->linearstability = TSComputeLinearStability_Bathe;
  ts->ops->snesfunction = SNESTSFormFunction_Bathe;
  ts->ops->snesjacobian = SNESTSFormJacobian_Bathe;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
  TSMOREAU - "moreau": explicit integrator of systems with set-valued reactions

  Options Database Keys:
+ -ts_bathe_error <embedded,doubling,none> - error estimate
- -ts_bathe_max_failures <50>              - attempts in a row that may fail before the run stops

  Level: beginner

  Notes:
  In A dw/dt = F_s + r the rates x advance half a step with the forces of the start, the other rows a step with these
  rates, and the rates the second half with the forces of the end. This is the Stoermer-Verlet method of second order,
  which finds the reaction in both halves cell by cell. Sticking cells have x = 0 exactly. A step costs one product with
  the stiffness and one with the viscosity, whose damping is that of the step's inner rate: the first half extrapolates
  it from the last two steps. There is no nonlinear solve.

  The constraint (TSBatheSetConstraint()) needs explicit_ops of SlipConstraintOps; faults with inertia and small systems
  have them. Steps of any controller are cut to what is stable, TSBatheGetLongestStep(). All other functions and options
  are those of TSBATHE, whose method TSBATHE_METHOD_EXPLICIT this is.

  References:
+ * - J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, Nonsmooth Mechanics and
      Applications, CISM Courses and Lectures 302, 1988.
. * - M. Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Eng. 177, 1999.
- * - F.-E. Fekak, M. Brun, A. Gravouil, B. Depale, A new heterogeneous asynchronous explicit-implicit time integrator
      for nonsmooth dynamics, Comput. Mech. 60, 2017: CD-Lagrange.

.seealso: TSBATHE, TSBatheSetConstraint(), TSBatheSetMethod(), TSBatheGetLongestStep()
M*/
PetscErrorCode TSCreate_Moreau(TS ts)
{
  PetscFunctionBegin;
  PetscCall(TSCreate_Bathe(ts));
  PetscCall(TSBatheSetMethod(ts, TSBATHE_METHOD_EXPLICIT));
  ts->ops->linearstability = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
