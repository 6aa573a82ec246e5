/* Gives TSBATHE right-hand sides of explicit steps for friction that sticks without inertia. Slip rates are a function
   of displacement and state (balance.c); the component v of a state follows from the others. */
#include <slipstep/private/slipfault.h>

/* Least slip rate that counts, over that at which friction holds a cell that exceeds its strength by rounding
   (SLIP_FRICTION_HOLD). Slower cells start and stop in turn in explicit steps, where implicit ones continue. */
#define MOVES 1e3

static PetscErrorCode Rate(TS ts, Vec w, PetscReal *rate, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  PetscBool moves = PETSC_FALSE;
  const PetscReal *a;

  PetscFunctionBegin;
  *rate = 0;
  PetscCall(SlipFaultGetFriction(fault, 0, &friction)); /* the stress of the start suffices */
  PetscCall(VecGetArrayRead(w, &a));
  for (PetscInt i = 0; i < fault->mesh.n && !moves; i++)
    if (fault->balance.eta * SlipFaultSpeed(fault, a, i) > MOVES * SLIP_FRICTION_HOLD * friction.stress[i])
      moves = PETSC_TRUE;
  PetscCall(VecRestoreArrayRead(w, &a));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  if (moves) PetscCall(SlipFaultRelaxation(ts, w, rate, ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Side(TS ts, PetscReal t, Vec w, Vec f, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipElasticForget(((SlipFault)ctx)->medium)); /* stored products of solves contain their rounding */
  PetscCall(SlipFaultRates((SlipFault)ctx, t, w, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes Hermite's cubic, and from its slope the slip rates with which Simpson's rule gives the slip. A cell whose
   slope opposes its slip starts or stops within the step, and rests there. */
static PetscErrorCode Middle(TS ts, PetscReal h, Vec w0, Vec w2, Vec f0, Vec f2, Vec w1, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const PetscInt c = fault->layout.components;
  const PetscReal *from, *to, *first, *last, *vinf;
  PetscReal *a;
  const SlipArrays arrays[] = {{w0, .read = &from},
                               {w2, .read = &to},
                               {f0, .read = &first},
                               {f2, .read = &last},
                               {fault->operators.vinf, .read = &vinf},
                               {w1, .write = &a}};

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipArraysGet(6, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscInt v = SlipFaultRateAt(fault, i), u = SlipFaultDisplacementAt(fault, i), s = SlipFaultStateAt(fault, i);
    PetscReal way = 0;

    for (PetscInt k = 0; k < c; k++) {
      const PetscReal rise = to[u + k] - from[u + k], loading = vinf[c * i + k];

      a[u + k] = from[u + k] + 0.5 * rise + 0.125 * h * (first[u + k] - last[u + k]);
      a[v + k] = loading + 1.5 * rise / h - 0.25 * (first[u + k] + last[u + k]);
      way += a[v + k] * (rise + h * loading);
    }
    for (PetscInt k = 0; k < c && !(way > 0); k++) a[v + k] = 0;
    for (PetscInt k = s; k < s + fault->layout.states; k++)
      a[k] = 0.5 * (from[k] + to[k]) + 0.125 * h * (first[k] - last[k]);
  }
  PetscCall(SlipArraysRestore(6, arrays));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How much larger the estimated error of a step may be, and in how many steps an error of its slip may decay. With
   these, segments of 100 drawn sequences have the errors of implicit steps (dials -problem sequence). */
static const PetscReal beside = 2, steps = 5;

static PetscErrorCode Error(TS ts, Vec e, Vec w0, Vec w1, PetscReal *E, void *ctx)
{
  PetscReal rtol, h;

  PetscFunctionBegin;
  PetscCall(TSGetTolerances(ts, NULL, NULL, &rtol, NULL));
  PetscCall(TSGetTimeStep(ts, &h));
  PetscCall(SlipFaultStickingErrorNorm((SlipFault)ctx, beside * rtol, steps * h, e, w0, w1, E));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reaction(TS ts, PetscReal t, Vec w, Vec r, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipFaultStickingTraction((SlipFault)ctx, t, w, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Attaches the functions to a fault whose TS is TSBATHE. */
PetscErrorCode SlipFaultSidesAttach(SlipFault fault)
{
  SlipProblemOps *problem = &fault->problem;
  const SlipFrictionLaw *law = fault->friction.law;
  PetscBool rests;

  PetscFunctionBegin;
  PetscCall(SlipElasticRests(fault->medium, &rests));
  if (fault->kind.inertia || !(fault->balance.eta > 0) || SlipFaultOpens(fault) || law->always_slides || law->by_rate ||
      !rests)
    PetscFunctionReturn(PETSC_SUCCESS);
  problem->sides.side = Side;
  problem->sides.middle = Middle;
  problem->sides.error = Error;
  problem->sides.reaction = Reaction;
  problem->steps.finish = SlipFaultFinishStep;
  problem->steps.relaxation = Rate;
  PetscFunctionReturn(PETSC_SUCCESS);
}
