/* TSBATHE's explicit steps without inertia: an attempt is a step of TSRKC where that costs less than a solve.

   For a solution that relaxes at a rate R, a step h takes sqrt(1 + 1.54 h R) stages, each a right-hand side; the cost
   of an implicit solve follows from preconditioning and friction for any step. The choice is made by counts and not by
   times, so that results do not depend on chance. */
#include <slipstep/private/slipbathe.h>

/* Processor time relative to a product by transforms, where cells take most of the time (measured with loaded faults of
   8 x 4 to 48 x 24 cells and injections of 24 x 24 and 48 x 48; a limit of half or twice as many stages costs at most
   10 %): of a stage, a linear iteration (product and preconditioner), and a Newton iteration with its direct solve */
#define STAGE 3
#define LINEAR 2
#define NEWTON 14
/* Weight of the last solve in the moving mean of their cost, and the assumed cost before the first solve, in stages */
#define NEW 0.25
#define SOLVE 12
/* Right-hand sides of a step besides those of its stages */
#define STEP 2

static PetscErrorCode TSStabilisedExists(TS ts, PetscBool *exists)
{
  const TS_Bathe *ba = (const TS_Bathe *)ts->data;
  const SlipProblemOps *p;
  void *ctx;

  PetscFunctionBegin;
  PetscCall(TSGetSlipProblem(ts, &p, &ctx));
  *exists = ba->con && p && p->sides.side && p->sides.middle && p->sides.error && p->sides.reaction &&
                p->steps.finish && p->steps.relaxation && ba->estimate.type == TSBATHE_ERROR_EMBEDDED
              ? PETSC_TRUE
              : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TSStabilisedReset(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  for (int k = 0; k < 3; k++) PetscCall(VecDestroy(&ba->stabilised.cheb[k]));
  ba->stabilised.k0_sides = PETSC_FALSE;
  ba->stabilised.implicit = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStabilisedPays(TS ts, PetscBool *pays)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal stages;

  PetscFunctionBegin;
  SlipProblemTry(ts, steps.relaxation, ts->vec_sol, &ba->stabilised.rate);
  ba->stabilised.rate *= SLIP_RATE_MARGIN;
  stages = SlipRKCStages(ts->time_step * ba->stabilised.rate);
  *pays = ba->stabilised.rate > 0 && stages <= SLIP_RKC_MOST &&
              stages + STEP <= (ba->stabilised.implicit > 0 ? ba->stabilised.implicit : SOLVE)
            ? PETSC_TRUE
            : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Side(TS ts, PetscReal t, Vec w, Vec f)
{
  PetscFunctionBegin;
  SlipProblemTry(ts, sides.side, t, w, f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets K0 where an attempt by another method has set its own. */
static PetscErrorCode TSStabilisedStart(TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  if (!ba->stabilised.k0_sides) PetscCall(Side(ts, ts->ptime, ba->X0, ba->K0));
  ba->stabilised.k0_sides = ba->k0_known = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStabilisedBegin(TS ts, PetscBool unchanged)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(TSBatheStartReaction(ts, unchanged));
  ba->stabilised.k0_sides = unchanged && ba->k2_known && ba->stabilised.k2_sides ? PETSC_TRUE : PETSC_FALSE;
  if (ba->stabilised.k0_sides) PetscCall(VecCopy(ba->K2, ba->K0));
  PetscCall(TSStabilisedStart(ts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStabilisedSubstep(TS ts, PetscReal t, PetscReal h, Vec w0, Vec r0, Vec w1, Vec w2, Vec r2,
                                          PetscReal *residual, PetscBool *ok)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  const PetscInt stages = PetscMin((PetscInt)SlipRKCStages(h * ba->stabilised.rate), SLIP_RKC_MOST);

  PetscFunctionBegin;
  (void)r0, (void)residual;
  for (int k = 0; k < 3; k++)
    if (!ba->stabilised.cheb[k]) PetscCall(VecDuplicate(ts->vec_sol, &ba->stabilised.cheb[k]));
  if (w0 != ba->X0) PetscCall(Side(ts, t, w0, ba->K1));
  PetscCall(SlipChebyshevStages(ts, Side, t, h, stages, w0, w0 == ba->X0 ? ba->K0 : ba->K1, ba->stabilised.cheb,
                                ba->stabilised.cheb[2]));
  PetscCall(VecCopy(ba->stabilised.cheb[1], w2));
  PetscCall(SlipGuardState(w2, ok));
  if (!*ok) {
    ba->last.reason = (PetscInt)SNES_DIVERGED_FUNCTION_DOMAIN;
    PetscCall(TSSetTimeStep(ts, ts->time_step * ts->adapt->scale_solve_failed));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Side(ts, t + h, w2, ba->K2));
  ba->stabilised.k2_sides = PETSC_TRUE;
  SlipProblemTry(ts, steps.finish, t + h, w2);
  SlipProblemTry(ts, sides.reaction, t + h, w2, r2);
  SlipProblemTry(ts, sides.middle, h, w0, w2, w0 == ba->X0 ? ba->K0 : ba->K1, ba->K2, w1);
  PetscCall(TSPostStage(ts, t + h, 1, ba->Y));
  ba->share = 0.5;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStabilisedError(TS ts, PetscReal h, Vec e)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  PetscCall(SlipChebyshevError(h, ba->X0, ba->Y[1], ba->K0, ba->K2, e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TSStabilisedNorm(TS ts, PetscReal *norm)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;

  PetscFunctionBegin;
  SlipProblemTry(ts, sides.error, ba->estimate.E, ba->X0, ba->Y[1], norm);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Updates the mean cost of solves from iterations. Counts of products would depend on observers, whose products the
   medium caches. */
static void TSStabilisedLearn(TS ts, PetscReal products)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscReal solve;

  (void)products;
  if (ba->was == &TSBatheStabilised || !ba->last.solves) return;
  solve =
    (LINEAR * (PetscReal)ba->last.linear + NEWTON * (PetscReal)ba->last.newton) / (STAGE * (PetscReal)ba->last.solves);
  ba->stabilised.implicit =
    ba->stabilised.implicit > 0 ? ba->stabilised.implicit + (PetscReal)NEW * (solve - ba->stabilised.implicit) : solve;
}

const TSBatheMethodOps TSBatheStabilised = {.method = TSBATHE_METHOD_EXPLICIT,
                                            .hermite = PETSC_TRUE,
                                            .begin = TSStabilisedBegin,
                                            .start = TSStabilisedStart,
                                            .substep = TSStabilisedSubstep,
                                            .error = TSStabilisedError,
                                            .norm = TSStabilisedNorm,
                                            .exists = TSStabilisedExists,
                                            .pays = TSStabilisedPays,
                                            .learn = TSStabilisedLearn};

/* Writes or reads the choice of the method in a checkpoint, inside the group of TSBatheMethodState(). */
PetscErrorCode TSStabilisedState(SlipState s, TS ts)
{
  TS_Bathe *ba = (TS_Bathe *)ts->data;
  PetscBool is_explicit = ba->last.method == TSBATHE_METHOD_EXPLICIT ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(SlipStateReal(s, "solve", 1, &ba->stabilised.implicit));
  PetscCall(SlipStateBool(s, "last_is_explicit", &is_explicit));
  PetscCall(SlipStateBool(s, "derivative_is_side", &ba->stabilised.k2_sides));
  if (SlipStateIsLoading(s) && is_explicit && ba->was == &TSBatheImplicit) {
    ba->was = &TSBatheStabilised;
    ba->last.method = TSBATHE_METHOD_EXPLICIT;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
