/* TSMOREAU: explicit steps with set-valued reactions. They are kick, drift and kick of the Stoermer-Verlet method, and
   each kick solves the friction cone cell by cell. Attempts, controllers, records and checkpoints are those of TSBATHE,
   of which this is a method; the type is in bathe.c. */
#include <slipstep/private/slipbathe.h>
#include <slipstep/private/sliploops.h>
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
  Vec *vecs[] = {&ba->moreau.start.f, &ba->moreau.start.p, &ba->moreau.start.p_before, &ba->moreau.start.p_end,
                 &ba->moreau.end.f,   &ba->moreau.end.p,   &ba->moreau.end.p_before,   &ba->moreau.end.p_end,
                 &ba->moreau.push,    &ba->moreau.p_inner, &ba->moreau.p_first,        &ba->moreau.K_before,
                 &ba->moreau.rows};

  PetscFunctionBegin;
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(vecs); i++) PetscCall(VecDestroy(vecs[i]));
  ba->moreau.started = PETSC_FALSE;
  ba->moreau.dt_before = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSMoreauSetUp(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  Vec *reduced[] = {&ba->moreau.start.f, &ba->moreau.start.p, &ba->moreau.start.p_before, &ba->moreau.start.p_end,
                    &ba->moreau.end.f,   &ba->moreau.end.p,   &ba->moreau.end.p_before,   &ba->moreau.end.p_end,
                    &ba->moreau.push,    &ba->moreau.p_inner, &ba->moreau.p_first};

  PetscFunctionBegin;
  if (ba->moreau.K_before) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(ba->con && ba->ops->explicit_ops, PetscObjectComm((PetscObject)ts), PETSC_ERR_SUP,
             "Explicit steps (-ts_type " TSMOREAU ") need a constraint with the operations explicit_ops of "
             "SlipConstraintOps, expected -ts_type " TSBATHE);
  PetscCall(PetscCitationsRegister(citation, &cited));
  for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(reduced); i++) {
    PetscCall(VecDuplicate(ba->r, reduced[i]));
    PetscCall(VecZeroEntries(*reduced[i])); /* it stays 0 without damping */
  }
  PetscCall(VecDuplicate(ts->vec_sol, &ba->moreau.K_before));
  PetscCall(VecDuplicate(ts->vec_sol, &ba->moreau.rows));
  PetscCall(VecSet(ba->x, 1));
  PetscCall(VecSet(ba->moreau.rows, 2)); /* r changes the rows that it enters: by a sum, or for a closed cell to 0 */
  PetscCall((*ba->ops->add_reaction)(ba->con, 1.0, ba->x, ba->moreau.rows, ba->ctx));
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
  if (!ba->moreau.started) PetscCall((*ops->drive)(ba->con, ts->ptime, ba->X0, ba->moreau.start.f, ba->ctx));
  if (undamped)
    PetscCall(VecZeroEntries(ba->moreau.start.p));
  else if (ops->damping)
    PetscCall((*ops->damping)(ba->con, ts->ptime, ba->X0, ba->moreau.start.p, ba->ctx));
  PetscCall(VecCopy(ba->moreau.start.p, ba->moreau.start.p_end));
  ba->moreau.start.h = ba->moreau.start.h_before = 0;
  ba->moreau.started = PETSC_TRUE;
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_START, ts->ptime, ba->X0, ba->moreau.start.p_end));
  PetscCall(TSMoreauDerivative(ts, ts->ptime, ba->X0, ba->r0, ba->K0));
  PetscCall(VecCopy(ba->r0, ba->r));
  ba->k0_known = PETSC_TRUE;
  ba->moreau.dt_before = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Starts explicit steps, which takes two products more than a step has. */
static PetscErrorCode TSMoreauStart(TS ts)
{
  PetscFunctionBegin;
  if (((TS_Bathe *)ts->data)->moreau.started) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(Anew(ts, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSMoreauBegin(TS ts, PetscBool unchanged)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipMoreauMemory end;

  PetscFunctionBegin;
  ba->r_given = PETSC_FALSE; /* explicit steps do not use a given reaction */
  if (!(unchanged && ba->was == &TSBatheMoreau && ba->k2_known)) {
    PetscCall(TSMoreauStart(ts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  end = ba->moreau.start;
  ba->moreau.start = ba->moreau.end;
  ba->moreau.end = end;
  ba->moreau.started = PETSC_TRUE;
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_START, ts->ptime, ba->X0, ba->moreau.start.p_end));
  ba->moreau.dt_before = ba->k0_known ? ba->last.dt : 0;
  if (ba->k0_known) Exchange(&ba->K0, &ba->moreau.K_before);
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
static PetscErrorCode TSMoreauSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                      PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  SlipMoreauMemory *m = &ba->moreau.end;
  const SlipMoreauMemory *from = w0 == ba->X0 ? &ba->moreau.start : m;
  const SlipExplicitOps *ops = ba->ops->explicit_ops;
  const PetscReal half = 0.5 * h;
  PetscReal weight;
  PetscBool solved = PETSC_TRUE;

  PetscFunctionBegin;
  (void)r0, (void)residual;
  PetscCall(TSPreStage(ts, t + half));
  weight = SlipLagWeight(h, from->h, from->h_before, ba->moreau.omega, ba->moreau.ratio);
  PetscCall(FirstPush(from, weight, ba->moreau.p_first, ba->moreau.push));
  PetscCall(VecCopy(w0, w1));
  PetscCall((*ops->kick)(ba->con, t, half, ba->moreau.push, w1, &solved, ba->ctx));
  PetscCall((*ops->drift)(ba->con, SLIP_NODE_START, t, half, w1, ba->ctx));
  if (ops->damping) PetscCall((*ops->damping)(ba->con, t + half, w1, ba->moreau.p_inner, ba->ctx));
  PetscCall(TSMoreauSettle(ts, SLIP_NODE_INSIDE, t + half, w1, ba->moreau.p_inner));
  PetscCall(TSPostStage(ts, t + half, 0, ba->Y));
  PetscCall(VecCopy(w1, w2));
  PetscCall((*ops->drift)(ba->con, SLIP_NODE_INSIDE, t + half, half, w2, ba->ctx));
  PetscCall(TSPreStage(ts, t + h));
  PetscCall((*ops->drive)(ba->con, t + h, w2, m->f, ba->ctx));
  PetscCall(
    SecondPush(m->f, ba->moreau.p_inner, ba->moreau.p_first, from->p, h / (h + from->h), ba->moreau.push, m->p_end));
  PetscCall((*ops->kick)(ba->con, t + h, half, ba->moreau.push, w2, &solved, ba->ctx));
  PetscCall(TSPostStage(ts, t + h, 1, ba->Y));
  if (from == m)
    Exchange(&m->p, &m->p_before);
  else
    PetscCall(VecCopy(from->p, m->p_before));
  Exchange(&ba->moreau.p_inner, &m->p);
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
  ba->share = 0.5;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Estimates the error. For the rows of x, which follow the trapezoidal rule, it is h^3/12 of the second difference of
   derivatives, and in the first step h/6 of their first difference, which is larger. For the other rows, which follow
   the midpoint rule, it is 2/3 of the difference to the trapezoidal rule: the leading term of displacements' error. */
static PetscErrorCode TSMoreauError(TS ts, PetscReal h, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscReal before = ba->moreau.dt_before, share = before > 0 ? h * h / (6 * (h + before)) : h / 6;
  const PetscReal numbers[] = {h, share, before > 0 ? share * h / before : 0};
  const Vec x[] = {ba->K0, ba->moreau.K_before, ba->K2, ba->X0, ba->Y[1], ba->moreau.rows, e};
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
  PetscCall((*ba->ops->explicit_ops->frequency)(ba->con, ts->ptime, ts->vec_sol, &ba->moreau.omega, &ba->moreau.ratio,
                                                ba->ctx));
  *h = ba->moreau.omega > 0 ? SLIP_LAG_MARGIN * SlipLagLimit(ba->moreau.ratio, 1) / ba->moreau.omega : PETSC_MAX_REAL;
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
  *cost = SlipMethodSolve(&ba->moreau.costs, 1) / ba->moreau.costs.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts an explicit step to the longest stable one. *whole is the step before it was cut, also for a corner of the
   loading [s]. A step in which nothing moves is stable at any length: it begins without the damping of earlier steps,
   which has ended, and with the same force. */
static PetscErrorCode TSMoreauCut(TS ts, PetscReal *whole)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const SlipExplicitOps *ops;
  PetscReal longest, rest = 0;
  PetscBool constant, undamped = PETSC_FALSE;
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(TSBatheGetLongestStep(ts, &longest));
  if (ts->time_step <= longest) PetscFunctionReturn(PETSC_SUCCESS);
  SlipProblemTry(ts, control.rest_time, ts->ptime, ba->X0, &rest);
  if (rest >= ts->time_step) {
    ops = ba->ops->explicit_ops;
    if (ops->undamped) PetscCall((*ops->undamped)(ba->con, ts->ptime, ba->X0, &undamped, ba->ctx));
    PetscCall(Anew(ts, undamped));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectTypeCompare((PetscObject)ts->adapt, TSADAPTNONE, &constant));
  PetscCallMPI(MPI_Comm_rank(PetscObjectComm((PetscObject)ts), &rank));
  if (constant && !ba->moreau.bound_told && !rank)
    PetscCall(SlipWarning("a constant step of %.6g s is longer than explicit steps are stable: they are %.6g s long "
                          "(-ts_type %s)",
                          (double)ts->time_step, (double)longest, ((PetscObject)ts)->type_name));
  ba->moreau.bound_told = constant;
  *whole = PetscMax(*whole, ts->time_step);
  ts->time_step = longest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the choice of a method ---- */

/* Finds whether explicit steps advance by fewer products. Constant steps and those of a history are explicit where they
   are stable. */
static PetscErrorCode TSMoreauPays(TS ts, PetscBool *pays)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  TSMoreau *m = &ba->moreau;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(TSBatheGetLongestStep(ts, &m->longest));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)ts->adapt, &given, TSADAPTNONE, TSADAPTHISTORY, ""));
  if (given)
    *pays = ts->time_step <= m->longest ? PETSC_TRUE : PETSC_FALSE;
  else
    *pays =
      SlipMethodIsExplicit(&m->costs, ts->time_step, m->longest, ba->was == &TSBatheMoreau ? PETSC_FALSE : PETSC_TRUE);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void TSMoreauLearn(TS ts, PetscReal products)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  if (ba->last.solves)
    SlipMethodLearn(&ba->moreau.costs, ba->was == &TSBatheMoreau ? PETSC_TRUE : PETSC_FALSE, ba->last.dt,
                    ba->moreau.longest, products / (PetscReal)ba->last.solves);
}

/* The midpoint rule */
static void TSMoreauWeights(const TS_Bathe *ba, PetscReal weight[3])
{
  (void)ba;
  weight[0] = weight[2] = 0;
  weight[1] = 1;
}

const TSBatheMethodOps TSBatheMoreau = {.method = TSBATHE_METHOD_EXPLICIT,
                                        .hermite = PETSC_TRUE,
                                        .begin = TSMoreauBegin,
                                        .limit = TSMoreauCut,
                                        .start = TSMoreauStart,
                                        .substep = TSMoreauSubstep,
                                        .error = TSMoreauError,
                                        .weights = TSMoreauWeights,
                                        .pays = TSMoreauPays,
                                        .learn = TSMoreauLearn};

/* ---- checkpoints of a run whose last step was explicit ---- */

PetscErrorCode TSMoreauState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool has = ba->was == &TSBatheMoreau ? PETSC_TRUE : PETSC_FALSE, before = ba->k0_known;
  PetscInt method = (PetscInt)TSBATHE_METHOD_EXPLICIT;

  PetscFunctionBegin;
  if (SlipStateIsLoading(s)) PetscCall(SlipStateHas(s, "explicit", &has));
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TSMoreauSetUp(ts));
  PetscCall(SlipStateGroup(s, "explicit"));
  PetscCall(SlipStateInt(s, "method", 1, &method)); /* files have it, but options decide */
  ba->was = &TSBatheMoreau;
  ba->last.method = TSBATHE_METHOD_EXPLICIT;
  PetscCall(SlipStateReal(s, "dt", 1, &ba->moreau.end.h));
  PetscCall(SlipStateReal(s, "dt_before", 1, &ba->moreau.end.h_before));
  PetscCall(SlipStateVec(s, "force", ba->moreau.end.f));
  PetscCall(SlipStateVec(s, "damping", ba->moreau.end.p));
  PetscCall(SlipStateVec(s, "damping_before", ba->moreau.end.p_before));
  PetscCall(SlipStateVec(s, "damping_end", ba->moreau.end.p_end));
  PetscCall(SlipStateBool(s, "has_start", &before));
  if (before) PetscCall(SlipStateVec(s, "derivative_start", ba->K0));
  ba->k0_known = before;
  PetscCall(SlipStateGroup(s, "ts"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
