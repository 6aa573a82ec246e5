/* Computes steps of constant slip rates: the state after a step, and its length. */
#include <slipstep/private/slipfault.h>
#include <slipstep/rooms/slipadapt.h>

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

/* Refuses controllers that do not suit steps of constant rates: rl, whose policy for cycles without waves moved events
   by years, both ways; and where cells always slide pi, whose steps grow by 1.2 at once, less than from one allowed
   length to the next, so that they would never grow, and lapusta, which knows no errors. */
PetscErrorCode SlipFaultRefuseControllers(SlipFault fault, TS ts)
{
  static const char *const type[] = {TSADAPTRL, TSADAPTPI, TSADAPTLAPUSTA};
  const PetscBool slides = fault->friction.law->always_slides;
  PetscReal shortest;
  PetscBool is, waves;
  TSAdapt adapt;

  PetscFunctionBegin;
  PetscCall(TSGetAdapt(ts, &adapt));
  PetscCall(SlipElasticGetShortestStep(fault->medium, &shortest));
  waves = shortest > 0 ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool refused[] = {waves, (PetscBool)(waves && slides), slides};

  for (int k = 0; k < 3; k++) {
    PetscCall(PetscObjectTypeCompare((PetscObject)adapt, type[k], &is));
    PetscCheck(!is || !refused[k], fault->comm, PETSC_ERR_SUP,
               "-ts_adapt_type %s does not suit %s: expected %sbasic, dsp, heuristic or none", type[k],
               slides ? "steps of constant rates of friction that always slides" : "faults with waves",
               slides ? "" : "lapusta, ");
  }
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

/* SlipControlOps.slip_step, where cells stick, which have no rate to limit a step: while any slides steps are the
   shortest. */
PetscErrorCode SlipFaultSlipStep(TS ts, PetscReal t, Vec w, PetscReal *longest, void *ctx)
{
  PetscReal speed;

  PetscFunctionBegin;
  (void)ts, (void)t, (void)w;
  PetscCall(VecNorm(((SlipFault)ctx)->balance.rate, NORM_INFINITY, &speed));
  *longest = speed > 0 ? 0 : PETSC_MAX_REAL;
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
