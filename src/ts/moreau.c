/* TSMOREAU: explicit steps with set-valued reactions. They are kick, drift and kick of the Stoermer-Verlet method, and
   each kick solves the friction cone cell by cell. Attempts, controllers, records and checkpoints are those of TSBATHE,
   of which this is the second method; the type is in bathe.c. */
#include <slipstep/private/sliploops.h>
#include <slipstep/private/slipts.h>
#include <slipstep/private/slipsys.h>
#include <slipstep/rooms/slipsys.h>

static PetscBool cited = PETSC_FALSE;
static const char citation[] = "@incollection{Moreau1988,\n"
                               "  title     = {Unilateral contact and dry friction in finite freedom dynamics},\n"
                               "  author    = {Jean Jacques Moreau},\n"
                               "  booktitle = {Nonsmooth Mechanics and Applications, CISM Courses and Lectures 302},\n"
                               "  pages     = {1--82},\n"
                               "  publisher = {Springer},\n"
                               "  year      = {1988}\n}\n";

PetscErrorCode TSMoreauReset(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec *vecs[] = {&ba->start.f,      &ba->start.p,   &ba->start.p_before, &ba->start.p_end, &ba->end.f,   &ba->end.p,
                 &ba->end.p_before, &ba->end.p_end, &ba->push,           &ba->p_inner,     &ba->p_first, &ba->K_before,
                 &ba->rows};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  ba->start.known = ba->end.known = PETSC_FALSE;
  ba->dt_before = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSMoreauSetUp(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec *reduced[] = {&ba->start.f,      &ba->start.p,   &ba->start.p_before, &ba->start.p_end, &ba->end.f,  &ba->end.p,
                    &ba->end.p_before, &ba->end.p_end, &ba->push,           &ba->p_inner,     &ba->p_first};

  PetscFunctionBegin;
  if (ba->K_before) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(ba->con && ba->ops->explicit_ops, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
             "Explicit steps (-ts_type " TSMOREAU ") need a constraint with the operations explicit_ops of "
             "SlipConstraintOps, expected -ts_type " TSBATHE);
  PetscCall(PetscCitationsRegister(citation, &cited));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(reduced); i++) {
    PetscCall(VecDuplicate(ba->r, reduced[i]));
    PetscCall(VecZeroEntries(*reduced[i])); /* it stays 0 without damping */
  }
  PetscCall(VecDuplicate(ts->vec_sol, &ba->K_before));
  PetscCall(VecDuplicate(ts->vec_sol, &ba->rows));
  PetscCall(VecSet(ba->x, 1));
  PetscCall(VecSet(ba->rows, 2)); /* r changes the rows that it enters: by a sum, or for a closed cell to 0 */
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->rows, ba->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Swaps a and b without a copy. */
static void Exchange(Vec *a, Vec *b)
{
  const Vec kept = *a;

  *a = *b;
  *b = kept;
}

/* Computes the expected damping of the first kick, from that of earlier steps, and its force, f less that damping. */
static PetscErrorCode FirstPush(const SlipMoreauMemory *from, PetscReal weight, Vec first, Vec push)
{
  const Vec x[] = {from->p, from->p_before, from->f, first, push};
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(push, &n));
  PetscCall(SlipLoopRun(SLIP_LOOP_MOREAU_FIRST, n, &weight, x, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the force of the second kick, f - 2 inner + first, and extrapolates the damping to the step's end by share
   from the one before. */
static PetscErrorCode SecondPush(Vec f, Vec inner, Vec first, Vec before, PetscReal share, Vec push, Vec p_end)
{
  const Vec x[] = {f, inner, first, before, push, p_end};
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(push, &n));
  PetscCall(SlipLoopRun(SLIP_LOOP_MOREAU_SECOND, n, &share, x, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSMoreauSettle(TS ts, SlipNode node, PetscReal t, Vec w, Vec p)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (ba->ops->explicit_ops->settle) PetscCall((*ba->ops->explicit_ops->settle)(ba->con, node, t, w, p, ba->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes r and k = A^-1 (F_s + r) of a state after TSMoreauSettle(). */
static PetscErrorCode TSMoreauDerivative(TS ts, PetscReal t, Vec w, Vec r, Vec k)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall((*ba->ops->smooth)(ba->con, t, w, k, ba->ctx));
  PetscCall(SlipConstraintReactionOf(ba->con, t, w, k, r));
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, r, k, ba->ctx));
  PetscCall((*ba->ops->solve_mass)(ba->con, k, k, ba->ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes forces, damping, reaction and derivative of X0 anew. undamped: the damping p of X0 is exactly 0. */
static PetscErrorCode Anew(TS ts, PetscBool undamped)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipExplicitOps *ops = ba->ops->explicit_ops;

  PetscFunctionBegin;
  if (!ba->start.known) PetscCall((*ops->drive)(ba->con, ts->ptime, ba->X0, ba->start.f, ba->ctx));
  if (undamped)
    PetscCall(VecZeroEntries(ba->start.p));
  else if (ops->damping)
    PetscCall((*ops->damping)(ba->con, ts->ptime, ba->X0, ba->start.p, ba->ctx));
  PetscCall(VecCopy(ba->start.p, ba->start.p_end));
  ba->start.h = ba->start.h_before = 0;
  ba->start.known = PETSC_TRUE;
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_START, ts->ptime, ba->X0, ba->start.p_end));
  PetscCall(TSMoreauDerivative(ts, ts->ptime, ba->X0, ba->r0, ba->K0));
  PetscCall(VecCopy(ba->r0, ba->r));
  ba->k0_known = PETSC_TRUE;
  ba->dt_before = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Starts explicit steps, which takes two products more than a step has. */
PetscErrorCode TSMoreauStart(TS ts)
{
  PetscFunctionBegin;
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(Anew(ts, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSMoreauBegin(TS ts, PetscBool unchanged)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipMoreauMemory end;

  PetscFunctionBegin;
  ba->r_given = PETSC_FALSE; /* explicit steps do not use a given reaction */
  if (!(unchanged && ba->end.known && ba->k2_known)) {
    PetscCall(TSMoreauStart(ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  end = ba->start;
  ba->start = ba->end;
  ba->end = end;
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_START, ts->ptime, ba->X0, ba->start.p_end));
  ba->dt_before = ba->k0_known ? ba->last.dt : 0;
  if (ba->k0_known) Exchange(&ba->K0, &ba->K_before);
  Exchange(&ba->K2, &ba->K0);
  PetscCall(VecCopy(ba->r, ba->r0));
  ba->k0_known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
   A dv = h/2 (f0 - e) + impulse of r,   u1 = u0 + h v,   A dv1 = h/2 f1 - (h p - h/2 e) + impulse of r

   where p is the damping of the step's inner rate v, and e the value of it that earlier steps predict. The damping of
   the step is h p, a midpoint rule, for any e and any lengths of steps. The damping of the end is extrapolated.
*/
PetscErrorCode TSMoreauSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec w1, Vec w2, Vec r2, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipMoreauMemory *m = &ba->end;
  const SlipMoreauMemory *from = w0 == ba->X0 ? &ba->start : m;
  const SlipExplicitOps *ops;
  const PetscReal half = 0.5 * h;
  PetscReal weight;
  PetscBool solved = PETSC_TRUE;

  PetscFunctionBegin;
  if (!ba->start.known) PetscCall(TSMoreauStart(ts));
  ops = ba->ops->explicit_ops;
  ba->last.solves++;
  ba->stage_time = t + half;
  PetscCall(TSPreStage(ts, ba->stage_time));
  weight = SlipLagWeight(h, from->h, from->h_before, ba->omega, ba->ratio);
  PetscCall(FirstPush(from, weight, ba->p_first, ba->push));
  PetscCall(VecCopy(w0, w1));
  PetscCall((*ops->kick)(ba->con, t, half, ba->push, w1, &solved, ba->ctx));
  PetscCall((*ops->drift)(ba->con, SLIP_NODE_START, t, half, w1, ba->ctx));
  if (ops->damping) PetscCall((*ops->damping)(ba->con, t + half, w1, ba->p_inner, ba->ctx));
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_INSIDE, t + half, w1, ba->p_inner));
  PetscCall(TSPostStage(ts, ba->stage_time, 0, ba->Y));
  PetscCall(VecCopy(w1, w2));
  PetscCall((*ops->drift)(ba->con, SLIP_NODE_INSIDE, t + half, half, w2, ba->ctx));
  ba->stage_time = t + h;
  PetscCall(TSPreStage(ts, ba->stage_time));
  PetscCall((*ops->drive)(ba->con, t + h, w2, m->f, ba->ctx));
  PetscCall(SecondPush(m->f, ba->p_inner, ba->p_first, from->p, h / (h + from->h), ba->push, m->p_end));
  PetscCall((*ops->kick)(ba->con, t + h, half, ba->push, w2, &solved, ba->ctx));
  PetscCall(TSPostStage(ts, ba->stage_time, 1, ba->Y));
  if (from == m)
    Exchange(&m->p, &m->p_before);
  else
    PetscCall(VecCopy(from->p, m->p_before));
  Exchange(&ba->p_inner, &m->p);
  m->known = PETSC_TRUE;
  m->h_before = from->h;
  m->h = h;
  PetscCallMPI(MPI_Allreduce(&solved, ok, 1, MPIU_BOOL, MPI_LAND, PetscObjectComm((PetscObject)ts)));
  if (*ok) PetscCall(SlipGuardState(w2, ok));
  if (!*ok) { /* as TSAdaptCheckStage() does after a solve */
    ba->last.reason = (PetscInt)SNES_DIVERGED_FUNCTION_DOMAIN;
    PetscCall(TSSetTimeStep(ts, ts->time_step * ts->adapt->scale_solve_failed));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_END, t + h, w2, m->p_end));
  PetscCall(TSMoreauDerivative(ts, t + h, w2, r2, ba->K2));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error. For the rows of x, which follow the trapezoidal rule, it is h^3/12 of the second difference of
   derivatives, and in the first step h/6 of their first difference, which is larger. For the other rows, which follow
   the midpoint rule, it is 2/3 of the difference to the trapezoidal rule: the leading term of displacements' error. */
PetscErrorCode TSMoreauError(TS ts, PetscReal h, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal before = ba->dt_before, share = before > 0 ? h * h / (6 * (h + before)) : h / 6;
  const PetscReal numbers[] = {h, share, before > 0 ? share * h / before : 0};
  const Vec x[] = {ba->K0, ba->K_before, ba->K2, ba->X0, ba->Y[1], ba->rows, e};
  PetscInt n;

  PetscFunctionBegin;
  PetscCall(VecGetLocalSize(e, &n));
  PetscCall(SlipLoopRun(SLIP_LOOP_MOREAU_ERROR, n, numbers, x, NULL));
  PetscCall(TSBatheDropSticking(ts, ba->Y[1], e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the longest step ---- */

/*@
  TSBatheGetLongestStep - gets the longest explicit step that is stable from the current state

  Collective

  Input Parameter:
. ts - of type TSBATHE or TSMOREAU, with a constraint

  Output Parameter:
. h - the step [s]; PETSC_MAX_REAL: any step is stable; 0: the constraint has no explicit steps

  Level: advanced

.seealso: TSMOREAU, TSBatheSetMethod(), SlipConstraintCreate()
@*/
PetscErrorCode TSBatheGetLongestStep(TS ts, PetscReal *h)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *h = 0;
  if (!ba->con || !ba->ops->explicit_ops) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall((*ba->ops->explicit_ops->frequency)(ba->con, ts->ptime, ts->vec_sol, &ba->omega, &ba->ratio, ba->ctx));
  *h = ba->omega > 0 ? SLIP_LAG_MARGIN * SlipLagLimit(ba->ratio, 1) / ba->omega : PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gets the ratio of the cost of an implicit solve to that of an explicit step. ts: of type TSBATHE or TSMOREAU; cost:
   products with stiffness and viscosity and applications of the preconditioner in a solve with the step of
   TSBatheGetLongestStep(), over the products of an explicit step, dimensionless. */
PetscErrorCode TSBatheGetSolveCost(TS ts, PetscReal *cost)
{
  TS_Bathe *ba = NULL;

  PetscFunctionBegin;
  PetscCall(TSBatheGetData(ts, PETSC_TRUE, &ba));
  *cost = SlipMethodSolve(&ba->costs, 1) / ba->costs.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts an explicit step to the longest stable one. *whole is the step before it was cut, also for a corner of the
   loading [s]. A step in which nothing moves is stable at any length: it begins without the damping of earlier steps,
   which has ended, and with the same force. */
PetscErrorCode TSMoreauCut(TS ts, PetscReal *whole)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipProblemOps *problem;
  void *ctx;
  const SlipExplicitOps *ops;
  PetscReal longest, rest = 0;
  PetscBool constant, undamped = PETSC_FALSE;
  PetscMPIInt rank;

  PetscFunctionBegin;
  if (ba->now != TSBATHE_METHOD_EXPLICIT || ba->stabilised) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(TSBatheGetLongestStep(ts, &longest));
  if (ts->time_step <= longest) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSGetSlipProblem(ts, &problem, &ctx));
  if (problem && problem->rest_time) PetscCall((*problem->rest_time)(ts, ts->ptime, ba->X0, &rest, ctx));
  if (rest >= ts->time_step) {
    ops = ba->ops->explicit_ops;
    if (ops->undamped) PetscCall((*ops->undamped)(ba->con, ts->ptime, ba->X0, &undamped, ba->ctx));
    PetscCall(Anew(ts, undamped));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (constant && !ba->bound_told && !rank)
    PetscCall(SlipWarning("a constant step of %.6g s is longer than explicit steps are stable: they are %.6g s long "
                          "(-ts_type %s)",
                          (double)ts->time_step, (double)longest, ((PetscObject)ts)->type_name));
  ba->bound_told = constant;
  *whole = PetscMax(*whole, ts->time_step);
  ts->time_step = longest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints of a run whose last step was explicit ---- */

PetscErrorCode TSMoreauState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool has = ba->end.known, before = ba->k0_known;
  PetscInt method = (PetscInt)TSBATHE_METHOD_EXPLICIT;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "explicit", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(SlipStateGroup(s, "explicit"));
  PetscCall(SlipStateInt(s, "method", 1, &method)); /* files have it, but options decide */
  ba->last.method = TSBATHE_METHOD_EXPLICIT;
  PetscCall(SlipStateReal(s, "dt", 1, &ba->end.h));
  PetscCall(SlipStateReal(s, "dt_before", 1, &ba->end.h_before));
  PetscCall(SlipStateVec(s, "force", ba->end.f));
  PetscCall(SlipStateVec(s, "damping", ba->end.p));
  PetscCall(SlipStateVec(s, "damping_before", ba->end.p_before));
  PetscCall(SlipStateVec(s, "damping_end", ba->end.p_end));
  PetscCall(SlipStateBool(s, "has_start", &before));
  if (before) PetscCall(SlipStateVec(s, "derivative_start", ba->K0));
  ba->k0_known = before;
  ba->end.known = PETSC_TRUE;
  PetscCall(SlipStateGroup(s, "ts"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
