/* What leaks from a fault into the rock, of the pore fluid of fluid.c: at a rate per pressure, and by Carter's law,
     v = c p/sqrt(t - onset),
   which is that of a half-space of rock whose border has the pressure p since the onset, c = sqrt(k_r S_r/(pi eta)).

   Howard, G. C. and Fast, C. R., 1957, Optimum fluid characteristics for fracture extension (with an appendix by
   Carter, R. D.), Drilling and Production Practice, API, 261-270. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>

/* Sets what leaks into the rock per pressure in stage k of a step of length h from t on [m^3/(Pa s)]. By Carter's law
   it falls as 1/sqrt(time since the onset): both stages together are right where the pressure is linear in time. */
void SlipFluidLeak(SlipFault fault, PetscReal t, PetscReal h, int k, const PetscReal onset[])
{
  const SlipFaultFluid *f = &fault->fluid;
  const PetscReal g = SLIP_FLUID_GAMMA;

  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal carter = fault->fields.cell[FIELD_CARTER_LEAKOFF][i], since = t - onset[i];
    PetscReal mean = 0;

    f->work[FLUID_WORK_LEAK][i] = f->leak[i];
    if (carter == 0 || since + h <= 0) continue;
    if (since > 1000 * h)
      mean = 1 / PetscSqrtReal(since + h / 2);
    else {
      const PetscReal begin = PetscSqrtReal(PetscMax(since, 0)), end = PetscSqrtReal(since + h);
      const PetscReal whole = 2 * (end - begin) / h; /* mean of the rate, and of its product with (time - t)/h */
      const PetscReal first = (2 * (end * end * end - begin * begin * begin) / 3 - 2 * since * (end - begin)) / (h * h);

      mean = (whole - first) / ((1 - g) * (1 - g));
      if (k) mean = (first - g * (1 - g) * mean) / g;
    }
    f->work[FLUID_WORK_LEAK][i] += carter * fault->mesh.weight[i] * fault->mesh.area * mean;
  }
}

/* Finds the cells that fluid which leaks by Carter's law has reached in a step of length h; any: there is one. */
PetscErrorCode SlipFluidReached(SlipFault fault, const SlipFluidNode *from, PetscReal h, SlipFluidNode *to,
                                PetscBool *any)
{
  PetscFunctionBegin;
  *any = PETSC_FALSE;
  if (!fault->fluid.leaks) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const PetscReal level = fault->fields.cell[FIELD_FLUID_PRESSURE][i] + fault->options.value[FAULT_CARTER_PRESSURE];

    if (to->onset[i] < PETSC_MAX_REAL || !(to->pressure[i] > level)) continue;
    to->onset[i] =
      from->time + h * PetscMax(level - from->pressure[i], 0) / (to->pressure[i] - PetscMin(from->pressure[i], level));
    if (fault->fields.cell[FIELD_CARTER_LEAKOFF][i] > 0) *any = PETSC_TRUE;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPIU_BOOL, MPI_LOR, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
