/* Checkpoints of TSBATHE and its TS: all that they carry from one accepted step to the next.
   The reaction is stored only for the output, which is written after the checkpoint: each step begins with the static
   balance of the state. Stages, the derivative of the start and the doubled solutions, which each step computes, are
   not stored, and neither are the vectors of the SNES, which starts from the state. */
#include <slipstep/private/slipbathe.h>
#include <slipstep/private/slipstate.h>

PetscErrorCode SlipStateAttempt(SlipState s, SlipAttempt *a)
{
  PetscFunctionBegin;
  PetscCall(SlipStateInt(s, "attempt_step", 1, &a->step));
  PetscCall(SlipStateReal(s, "attempt_time", 1, &a->time));
  PetscCall(SlipStateReal(s, "attempt_dt", 1, &a->dt));
  PetscCall(SlipStateBool(s, "attempt_converged", &a->converged));
  PetscCall(SlipStateBool(s, "attempt_accepted", &a->accepted));
  PetscCall(SlipStateReal(s, "attempt_error", 1, &a->error));
  PetscCall(SlipStateReal(s, "attempt_residual", 1, &a->residual));
  PetscCall(SlipStateInt(s, "attempt_solves", 1, &a->solves));
  PetscCall(SlipStateInt(s, "attempt_newton", 1, &a->newton));
  PetscCall(SlipStateInt(s, "attempt_linear", 1, &a->linear));
  PetscCall(SlipStateInt(s, "attempt_reason", 1, &a->reason));
  PetscCall(SlipStateProducts(s, "attempt_products", &a->products));
  PetscCall(SlipStateReal(s, "attempt_wall", 1, &a->wall));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads the origin of time, which only a checkpoint of a run with a moved origin has. */
static PetscErrorCode SlipStateOrigin(SlipState s, TS ts)
{
  const SlipClock *clock;
  PetscReal origin;
  PetscBool has;

  PetscFunctionBegin;
  PetscCall(SlipClockGet(ts, &clock));
  origin = clock->origin;
  has = origin > 0 ? PETSC_TRUE : PETSC_FALSE;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "long_history", &has));
  if (!has) origin = 0;
  if (has) {
    PetscCall(SlipStateGroup(s, "long_history"));
    PetscCall(SlipStateReal(s, "origin", 1, &origin));
    PetscCall(SlipStateGroup(s, "ts"));
  }
  if (SlipStateIsLoading(s) && origin != clock->origin) PetscCall(SlipClockSet(ts, origin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads what every TS has. */
static PetscErrorCode SlipStateAny(SlipState s, TS ts)
{
  PetscFunctionBegin;
  PetscCall(SlipStateGroup(s, "ts"));
  PetscCall(SlipStateReal(s, "time", 1, &ts->ptime));
  PetscCall(SlipStateReal(s, "time_before", 1, &ts->ptime_prev));
  PetscCall(SlipStateReal(s, "dt", 1, &ts->time_step));
  PetscCall(SlipStateInt(s, "step", 1, &ts->steps));
  PetscCall(SlipStateInt(s, "rejections", 1, &ts->reject));
  PetscCall(SlipStateInt(s, "snes_iterations", 1, &ts->snes_its));
  PetscCall(SlipStateInt(s, "ksp_iterations", 1, &ts->ksp_its));
  PetscCall(SlipStateInt(s, "snes_failures", 1, &ts->num_snes_failures));
  PetscCall(SlipStateBool(s, "begins_anew", &ts->steprestart));
  PetscCall(SlipStateOrigin(s, ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the end of the last step, which interpolation to the final time has replaced in vec_sol. */
static Vec SlipStateEnd(TS ts)
{
  const PetscBool beyond =
    ts->exact_final_time == TS_EXACTFINALTIME_INTERPOLATE && ts->ptime > ts->max_time ? PETSC_TRUE : PETSC_FALSE;

  return beyond ? ((TS_Bathe *)ts->data)->Y[1] : ts->vec_sol;
}

/* Writes or reads the start of the last step and a state inside it, from which the final time is interpolated. */
static PetscErrorCode SlipStateInterpolation(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool interpolates = ts->exact_final_time == TS_EXACTFINALTIME_INTERPOLATE ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipStateBool(s, "interpolates", &interpolates));
  if (!interpolates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateReal(s, "share", 1, &ba->share));
  PetscCall(SlipStateVec(s, "start", ba->X0));
  PetscCall(SlipStateVec(s, "inner", ba->Wm));
  if (SlipStateIsLoading(s)) PetscCall(VecCopy(ts->vec_sol, ba->Y[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads the length of constant steps, which only a run in which they are shorter at present has. */
static PetscErrorCode SlipStateConstant(SlipState s, SlipConstant *steps)
{
  PetscBool has = steps->asked > 0 ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "constant_steps", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipStateGroup(s, "constant_steps"));
  PetscCall(SlipStateReal(s, "dt", 1, &steps->asked));
  PetscCall(SlipStateGroup(s, "ts"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes or reads the state of a TS between two steps; the solution must be set. TSADAMS has a part of its own, and
   the problem has that of PETSc's TSRK. Collective. */
PetscErrorCode SlipStateTS(SlipState s, TS ts)
{
  TS_Bathe *ba;
  PetscObjectId id;
  PetscObjectState state;
  PetscBool unchanged, known;

  PetscFunctionBegin;
  PetscCall(TSSetUp(ts));
  PetscCall(TSBatheGetData(ts, PETSC_FALSE, &ba));
  if (!ba) {
    PetscCall(SlipStateAny(s, ts));
    PetscCall(SlipStateVec(s, "solution", ts->vec_sol));
    PetscCall(SlipStateObject(s, "integrator", (PetscObject)ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectGetId((PetscObject)ts->vec_sol, &id));
  PetscCall(PetscObjectStateGet((PetscObject)ts->vec_sol, &state));
  unchanged =
    (id == ba->sol_id && state == ba->sol_state) || SlipStateEnd(ts) != ts->vec_sol ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(SlipStateAny(s, ts));
  PetscCall(SlipStateVec(s, "solution", SlipStateIsLoading(s) ? ts->vec_sol : SlipStateEnd(ts)));
  PetscCall(SlipStateInt(s, "attempts", 1, &ba->totals.attempts));
  PetscCall(SlipStateInt(s, "accepted", 1, &ba->totals.accepted));
  PetscCall(SlipStateInt(s, "solves", 1, &ba->totals.solves));
  PetscCall(SlipStateInt(s, "explicit_attempts", 1, &ba->totals.explicits));
  PetscCall(SlipStateInt(s, "newton", 1, &ba->totals.newton));
  PetscCall(SlipStateInt(s, "linear", 1, &ba->totals.linear));
  PetscCall(SlipStateInt(s, "failures", 1, &ba->failures.row));
  PetscCall(SlipStateReal(s, "barrier", 1, &ba->failures.barrier));
  PetscCall(SlipStateReal(s, "error_share", 1, &ba->stages.error_share));
  PetscCall(SlipStateReal(s, "error_share_dt", 1, &ba->stages.error_dt));
  PetscCall(SlipStateInt(s, "towards_barrier", 1, &ba->failures.towards));
  PetscCall(SlipStateConstant(s, &ba->failures.constant));
  PetscCall(SlipStateAttempt(s, &ba->last));
  if (ba->con) PetscCall(SlipStateVec(s, "reaction", ba->r));
  known = ba->k2_known && ba->last.accepted ? PETSC_TRUE : PETSC_FALSE; /* otherwise it is that of a rejected attempt */
  PetscCall(SlipStateBool(s, "derivative_known", &known));
  if (SlipStateIsLoading(s)) ba->k2_known = known;
  if (known) PetscCall(SlipStateVec(s, "derivative", ba->K2));
  PetscCall(SlipStateInterpolation(s, ts));
  if (SlipStateIsLoading(s)) {
    ba->was = &TSBatheImplicit; /* unless the next two functions read otherwise */
    ba->last.method = TSBATHE_METHOD_IMPLICIT;
  }
  PetscCall(TSMoreauState(s, ts));
  PetscCall(TSBatheMethodState(s, ts));
  PetscCall(SlipStateBool(s, "unchanged", &unchanged)); /* by others since the last step */
  if (!SlipStateIsLoading(s)) PetscFunctionReturn(PETSC_SUCCESS);
  (void)SlipProductsRow(&ba->totals.cost);
  ba->r_given = PETSC_FALSE;
  ts->steprollback = PETSC_FALSE;
  PetscCall(PetscObjectStateGet((PetscObject)ts->vec_sol, &state));
  ba->sol_id = unchanged ? id : 0;
  ba->sol_state = state;
  PetscFunctionReturn(PETSC_SUCCESS);
}
