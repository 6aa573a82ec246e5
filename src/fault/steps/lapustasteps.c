/* Computes steps of constant slip rates: the state after a step, and its longest length. */
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipadapt.h>

#define MOST_SLIP 0.5 /* slip in a step, over d_c */
/* Change of a stress in time in a step over a sigma, by which a slip rate grows e-fold. Slip alone does not limit steps
   while the load takes a rate from nothing to a rupture: half moves the onset of TPV103 (37 e-folds in 1 s) by 0.1 % */
#define MOST_LOAD 0.5
/* Waves may start a rupture where all cells rest while the largest stress that is still to arrive exceeds the first
   share of the least distance to strength, as waves from several places may add up, and the second share of the largest
   strength, which is the error of the exponentials in their kernels. Only cells count whose strength can still fall by
   the third share of it: others slip only as much as the passing wave makes them, and start nothing. */
#define WAITS_DISTANCE 0.1
#define WAITS_STRENGTH 1e-6
#define WAITS_DROP 0.01
#define FOR_EVER 1e30 /* [s] */

/* SlipDriftOps.drift */
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
  if (fault->kind.coupled && fault->friction.follows) { /* states follow the normal stress in the middle of the step */
    PetscCall(VecAXPY(w1, 0.5 * h, F));
    PetscCall(SlipFaultGetFrictionOf(fault, t + 0.5 * h, w1, &friction));
    PetscCall(VecCopy(w0, w1));
  } else
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

/* Returns the share of d_c that a cell may slip in a step while it is stable, by Lapusta et al. (2000), equations
   15, from a sigma, (b - a) sigma and its stiffness k; at most half. */
static PetscReal Share(PetscReal A, PetscReal weakening, PetscReal stiffness)
{
  const PetscReal root = PetscSqr(stiffness - weakening) / 4 - stiffness * A;

  if (root / PetscSqr(A) > 0)
    return PetscMin(A / PetscMax(stiffness - weakening, PETSC_SMALL * A), (PetscReal)MOST_SLIP);
  return PetscMin(1 - weakening / stiffness, (PetscReal)MOST_SLIP);
}

/* Refuses with waves rl, whose policy for cycles without waves moved events by years, both ways, and for cycles pi,
   whose steps grow by 1.2 at once, less than from one allowed length to the next: they would never grow. */
PetscErrorCode SlipFaultRefuseLearnedWaves(SlipFault fault, TS ts)
{
  PetscReal shortest;
  PetscBool learned, pi;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTRL, &learned));
  PetscCall(SlipElasticGetShortestStep(fault->medium, &shortest));
  PetscCheck(!learned || !(shortest > 0), fault->comm, PETSC_ERR_SUP,
             "-ts_adapt_type rl has no policy for faults with waves: expected lapusta, basic, dsp, pi, heuristic or "
             "none");
  PetscCall(PetscObjectTypeCompare((PetscObject)adapt, TSADAPTPI, &pi));
  PetscCheck(!pi || !(shortest > 0) || !fault->friction.law->always_slides, fault->comm, PETSC_ERR_SUP,
             "-ts_adapt_type pi lengthens steps too little for cycles with waves: expected dsp, basic, heuristic, "
             "lapusta or none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipDriftOps.shortest */
PetscErrorCode SlipFaultShortestStep(TS ts, PetscReal *step, void *ctx)
{
  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipElasticGetShortestStep(((SlipFault)ctx)->medium, step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipControlOps.slip_step. Sticking cells have no rate to limit a step: while any slides steps are the shortest. */
PetscErrorCode SlipFaultSlipStep(TS ts, PetscReal t, Vec w, PetscReal *longest, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  SlipFrictionCells friction;
  PetscReal step = PETSC_MAX_REAL;
  const PetscReal *k, *v;
  Vec stiffness;

  PetscFunctionBegin;
  (void)ts;
  PetscCall(SlipElasticGetDiagonals(fault->medium, &stiffness, NULL));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &friction));
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
  if (fault->friction.law->always_slides)
    step = SlipLoadsLongest(&fault->loads, fault->fields.cell[FIELD_FRICTION_A], friction.stress, t, MOST_LOAD, step);
  PetscCall(VecRestoreArrayRead(fault->balance.rate, &v));
  PetscCall(VecRestoreArrayRead(stiffness, &k));
  PetscCallMPI(MPI_Allreduce(&step, longest, 1, MPIU_REAL, MPIU_MIN, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SlipDriftOps.waits. The stress that waves will still bring is the difference to the stress of the same slip when
   all waves have gone; steady loading meets its impedance for ever. */
PetscErrorCode SlipFaultWaits(TS ts, PetscReal t, Vec w, PetscBool *waits, void *ctx)
{
  SlipFault fault = (SlipFault)ctx;
  const PetscInt c = fault->layout.components;
  PetscReal most[3] = {0, -PETSC_MAX_REAL, 0}, speed, shortest; /* waves, -distance, strength [Pa] */
  const PetscReal *now, *last, *vinf, *stress, *strength;
  SlipFrictionCells cells;
  Vec u, force, later, friction;

  PetscFunctionBegin;
  (void)ts;
  *waits = PETSC_FALSE;
  PetscCall(SlipElasticGetShortestStep(fault->medium, &shortest));
  if (!(shortest > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultLargestSpeed(fault, w, &speed));
  if (speed != 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SlipFaultGetWork(fault, &u));
  PetscCall(SlipFaultGetWork(fault, &force));
  PetscCall(SlipFaultGetWork(fault, &later));
  PetscCall(SlipFaultGetWork(fault, &friction));
  PetscCall(SlipFaultStickingTraction(fault, t, w, friction));
  PetscCall(SlipFaultStrength(fault, t, w, fault->cells));
  PetscCall(SlipFaultGetFrictionOf(fault, t, w, &cells));
  PetscCall(SlipFaultForce(fault, t, w, u, force));
  PetscCall(SlipElasticForce(fault->medium, t + FOR_EVER, u, NULL, later, NULL));
  const SlipArrays arrays[] = {{force, .read = &now},
                               {later, .read = &last},
                               {fault->operators.vinf, .read = &vinf},
                               {friction, .read = &stress},
                               {fault->cells, .read = &strength}};

  PetscCall(SlipArraysGet(5, arrays));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal weight = fault->mesh.weight[i], weakest = weight * SlipFrictionWeakest(&cells, i) * cells.stress[i];
    PetscReal wave[3];

    for (PetscInt k = c * i; k < c * (i + 1); k++)
      wave[k - c * i] = last[k] - now[k] + fault->balance.eta * weight * vinf[k];
    most[0] = PetscMax(most[0], SlipFaultLength(fault, wave) / weight);
    if (strength[i] - weakest > WAITS_DROP * strength[i])
      most[1] = PetscMax(most[1], (SlipFaultLength(fault, stress + c * i) - strength[i]) / weight);
    most[2] = PetscMax(most[2], strength[i] / weight);
  }
  PetscCall(SlipArraysRestore(5, arrays));
  PetscCall(SlipFaultRestoreWork(fault, &friction));
  PetscCall(SlipFaultRestoreWork(fault, &later));
  PetscCall(SlipFaultRestoreWork(fault, &force));
  PetscCall(SlipFaultRestoreWork(fault, &u));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 3, MPIU_REAL, MPIU_MAX, fault->comm));
  *waits = most[0] > PetscMax(WAITS_DISTANCE * -most[1], WAITS_STRENGTH * most[2]) ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
