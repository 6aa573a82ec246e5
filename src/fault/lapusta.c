/* Steps of constant slip rates: what a state is after one, and how long it may be. */
#include <slipstep/private/slipfault.h>
#include <slipadapt.h>

#define MOST_SLIP 0.5 /* of a step, over d_c */

/* SlipProblemOps.drift */
PetscErrorCode SlipFaultDrift(TS ts, PetscReal h, Vec w0, Vec F, Vec w1, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const PetscInt c = fault->layout.components;
  SlipFrictionCells friction;
  const PetscReal *f, *vinf;
  PetscReal *a, *speed, *work, t;
  Vec rate;

  PetscFunctionBegin;
  PetscCall(TSGetTime(ts, &t));
  PetscCall(VecCopy(w0, w1));
  PetscCall(SlipFaultGetFriction(fault, t + 0.5 * h, &friction));
  PetscCall(SlipFaultGetWork(fault, &rate));
  PetscCall(PetscMalloc1(fault->layout.states * fault->mesh.n + 1, &work));
  const SlipArrays arrays[] = {{F, .read = &f}, {fault->operators.vinf, .read = &vinf}};

  PetscCall(SlipArraysGet(2, arrays));
  PetscCall(VecGetArray(w1, &a));
  PetscCall(VecGetArrayWrite(rate, &speed));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    PetscReal v[3];

    for (PetscInt k = 0; k < c; k++) {
      const PetscReal relative = f[SlipFaultDisplacementAt(fault, i) + k];

      a[SlipFaultDisplacementAt(fault, i) + k] += h * relative;
      v[k] = relative + vinf[c * i + k];
    }
    speed[i] = SlipFaultLength(fault, v);
  }
  SlipFrictionStateDrift(&friction, fault->mesh.n, h, speed, fault->layout.block, a + fault->layout.state, work);
  PetscCall(VecRestoreArrayWrite(rate, &speed));
  PetscCall(VecRestoreArray(w1, &a));
  PetscCall(SlipArraysRestore(2, arrays));
  PetscCall(PetscFree(work));
  PetscCall(SlipFaultRestoreWork(fault, &rate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The share of d_c that a cell may slip in a step while it is stable, of Lapusta et al. (2000), equations 15: a sigma,
   (b - a) sigma and its stiffness k; half where others weaken */
static PetscReal Share(PetscReal A, PetscReal weakening, PetscReal stiffness)
{
  const PetscReal root = PetscSqr(stiffness - weakening) / 4 - stiffness * A;

  if (root / PetscSqr(A) > 0)
    return PetscMin(A / PetscMax(stiffness - weakening, PETSC_SMALL * A), (PetscReal)MOST_SLIP);
  return PetscMin(1 - weakening / stiffness, (PetscReal)MOST_SLIP);
}

/* The policy for cycles was trained without waves: with them its dial moves events by years, to and fro. */
PetscErrorCode SlipFaultRefuseLearnedWaves(SlipFault fault, TS ts)
{
  PetscReal shortest;
  PetscBool learned;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  PetscCall(SlipElasticGetShortestStep(fault->medium, &shortest));
  PetscCheck(!learned || !(shortest > 0), fault->comm, PETSC_ERR_SUP,
             "-ts_adapt_type rl has no policy for faults with waves: expected lapusta, basic, dsp, pi, heuristic or "
             "none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipProblemOps.shortest */
PetscErrorCode SlipFaultShortestStep(TS ts, PetscReal *step, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipElasticGetShortestStep(((SlipFault)ctx)->medium, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipProblemOps.slip_step. Cells that stick have no rate to go by: while any slides steps are the shortest. */
PetscErrorCode SlipFaultSlipStep(TS ts, PetscReal t, Vec w, PetscReal *longest, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  PetscReal step = PETSC_MAX_REAL;
  const PetscReal *k, *v;
  Vec stiffness;

  PetscFunctionBegin;
  (void)ts, (void)w;
  PetscCall(SlipElasticGetDiagonals(fault->medium, &stiffness, NULL));
  PetscCall(SlipFaultGetFriction(fault, t, &friction));
  PetscCall(VecGetArrayRead(stiffness, &k));
  PetscCall(VecGetArrayRead(fault->balance.rate, &v));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal speed = SlipFaultLength(fault, v + fault->layout.components * i),
                    slip = fault->fields.cell[FIELD_FRICTION_SLIP][i], sigma = friction.stress[i];
    PetscReal share = 0;

    if (speed == 0) continue;
    if (fault->friction.law->always_slides)
      share = Share(fault->fields.cell[FIELD_FRICTION_A][i] * sigma,
                    (fault->fields.cell[FIELD_FRICTION_B][i] - fault->fields.cell[FIELD_FRICTION_A][i]) * sigma,
                    SlipFaultLargest(fault, k, i) / fault->mesh.weight[i] * slip);
    step = PetscMin(step, share * slip / speed);
  }
  PetscCall(VecRestoreArrayRead(fault->balance.rate, &v));
  PetscCall(VecRestoreArrayRead(stiffness, &k));
  PetscCallMPI(MPI_Allreduce(&step, longest, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
