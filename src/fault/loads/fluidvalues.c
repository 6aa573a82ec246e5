/* What is asked of the pore fluid of fluid.c at a time: pressure, volumes, permeability and flow, wells. */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>
#include <slipstep/private/slipfaultwells.h>

/* Computes a place and the pressure of the fluid there, p [n]. Collective. */
static PetscErrorCode PlaceAt(SlipFault fault, PetscReal t, SlipFluidPlace *place, PetscReal p[])
{
  const PetscReal *w = place->weight;

  PetscFunctionBegin;
  PetscCall(SlipFluidReach(fault, t, place));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    p[i] = w[0] * place->from->pressure[i];
    if (place->to) p[i] += w[1] * place->middle[i] + w[2] * place->to->pressure[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFluidPressureAt(SlipFault fault, PetscReal t, PetscReal p[])
{
  SlipFluidPlace place;

  PetscFunctionBegin;
  PetscCall(PlaceAt(fault, t, &place, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidPressure(SlipFault fault, PetscReal t, PetscReal p[])
{
  PetscReal *own = fault->fluid.work[FLUID_WORK_OWN];

  PetscFunctionBegin;
  PetscCall(SlipFluidPressureAt(fault, t, own));
  for (PetscInt i = 0; i < fault->mesh.n; i++) p[i] += own[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidVolumes(SlipFault fault, PetscReal t, PetscReal volume[], PetscReal *stored)
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidPlace place;
  PetscReal sum = 0;

  PetscFunctionBegin;
  PetscCall(PlaceAt(fault, t, &place, f->work[FLUID_WORK_OWN]));
  for (int k = 0; k < FLUID_NUM_VOLUMES; k++) {
    volume[k] = place.weight[0] * place.from->volume[k];
    if (place.to) volume[k] += place.weight[1] * place.between[k] + place.weight[2] * place.to->volume[k];
  }
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    sum += f->storage[i] * (f->work[FLUID_WORK_OWN][i] - fault->fields.cell[FIELD_FLUID_PRESSURE][i]);
  PetscCallMPI(MPI_Allreduce(&sum, stored, 1, MPIU_REAL, MPIU_SUM, fault->comm));
  *stored += volume[FLUID_PORES];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets work[FLUID_WORK_ALONG] to the permeability at t, and work[FLUID_WORK_OWN] to the pressure. */
static PetscErrorCode PermeabilityAt(SlipFault fault, PetscReal t)
{
  SlipFaultFluid *f = &fault->fluid;
  SlipFluidPlace place;

  PetscFunctionBegin;
  PetscCall(PlaceAt(fault, t, &place, f->work[FLUID_WORK_OWN]));
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    f->work[FLUID_WORK_STATE][i] =
      (1 - place.share) * place.from->state[i] + (place.to ? place.share * place.to->state[i] : 0);
  PetscCall(SlipFluidPermeability(fault, &f->path[0], t, f->work[FLUID_WORK_STATE], f->work[FLUID_WORK_OWN],
                                  f->work[FLUID_WORK_ALONG]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidFlow(SlipFault fault, PetscReal t, PetscReal permeability[], PetscReal flux[])
{
  SlipFaultFluid *f = &fault->fluid;
  const SlipDiffusion own = f->diffusion;
  const PetscReal moment = 1e-6 * f->first; /* so short that pressures stay, while those of sides follow from them */

  PetscFunctionBegin;
  PetscCall(PermeabilityAt(fault, t));
  if (permeability) PetscCall(PetscArraycpy(permeability, f->work[FLUID_WORK_ALONG], fault->mesh.n));
  if (!flux) PetscFunctionReturn(PETSC_SUCCESS);
  if (!f->shown) PetscCall(SlipDiffusionCreate(&fault->mesh, SlipFaultPrefix(fault), &f->shown));
  f->diffusion = f->shown;
  PetscCall(PetscArraycpy(f->work[FLUID_WORK_LEAK], f->leak, fault->mesh.n)); /* which counts for little in a moment */
  PetscCall(SlipFluidSetOperator(fault, t));
  f->diffusion = own;
  for (PetscInt i = 0; i < fault->mesh.n; i++)
    f->work[FLUID_WORK_RIGHT][i] = f->storage[i] * f->work[FLUID_WORK_OWN][i];
  PetscCall(SlipDiffusionSolve(f->shown, moment, f->work[FLUID_WORK_RIGHT], f->work[FLUID_WORK_OWN]));
  PetscCall(SlipDiffusionFlow(f->shown, NULL, flux));
  for (PetscInt i = 0; i < 2 * fault->mesh.n; i++) flux[i] /= fault->fields.cell[FIELD_APERTURE][i / 2];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SlipFaultFluidWells(SlipFault fault, PetscReal t, PetscReal rate[], PetscReal pressure[])
{
  SlipFaultFluid *f = &fault->fluid;
  const PetscInt n = fault->loads.nwells;

  PetscFunctionBegin;
  PetscCall(PermeabilityAt(fault, t));
  PetscCall(PetscArrayzero(rate, n));
  PetscCall(PetscArrayzero(pressure, n));
  for (PetscInt k = 0; k < n; k++) {
    const SlipFaultWell *well = &fault->loads.wells[k];
    const PetscReal value = SlipFaultWellValue(well, t);
    const PetscBool holds = well->pressure && SlipFaultWellHolds(well, t) ? PETSC_TRUE : PETSC_FALSE;

    for (PetscInt j = 0; j < well->ncells; j++) {
      const PetscInt i = well->cell[j];
      const PetscReal index = f->index[k] * f->unit[i] * f->work[FLUID_WORK_ALONG][i], p = f->work[FLUID_WORK_OWN][i];

      pressure[k] += well->share[j] * p;
      if (holds) {
        rate[k] += index * (value - p);
        pressure[k] = value;
      } else if (!well->pressure) {
        rate[k] += well->share[j] * value;
        if (index > 0) pressure[k] += value / index;
      }
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, rate, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, pressure, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, fault->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal SlipFaultFluidScale(SlipFault fault, PetscReal t)
{
  const SlipFluidPath *path = &fault->fluid.path[0];

  (void)t;
  return path->stepped ? (path->to.time - path->from.time) / 4 : fault->fluid.first;
}
