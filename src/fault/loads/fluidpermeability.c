/* The permeability of the cells along a path of the pore fluid (fluid.c), by the laws of core/permeability.c */
#include <slipstep/private/slipfault.h>
#include <slipstep/private/slipfaultfluid.h>

static SlipPermeability Law(SlipFault fault, PetscInt i)
{
  const PetscReal *value = fault->options.value, healing = value[FAULT_PERMEABILITY_HEALING_TIME];

  return (SlipPermeability){.start = fault->fields.cell[FIELD_PERMEABILITY][i],
                            .maximum = fault->fields.cell[FIELD_PERMEABILITY_MAXIMUM][i],
                            .slip = value[FAULT_PERMEABILITY_SLIP],
                            .healing = healing > 0 ? 1 / healing : 0,
                            .stress = value[FAULT_PERMEABILITY_STRESS],
                            .normal = fault->fields.cell[FIELD_NORMAL_STRESS][i],
                            .ctx = fault->fluid.law->ctx};
}

/* Slip of cell i in this time since the history [m] */
static PetscReal Slip(const SlipFluidDrive *drive, PetscInt i, PetscReal time)
{
  return PetscMax((drive->speed[i] + drive->curve[i] * time) * time, 0);
}

/* Sets k* at the first stage of a step of the path, `own` after its start, and at its end, `other` later. */
void SlipFluidEvolve(SlipFault fault, SlipFluidPath *path, PetscReal own, PetscReal other, PetscReal stage[])
{
  const SlipFaultFluid *f = &fault->fluid;
  const PetscReal time = path->from.time - path->start;

  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const SlipPermeability c = Law(fault, i);
    const PetscReal slip[] = {Slip(&path->drive, i, time), Slip(&path->drive, i, time + own),
                              Slip(&path->drive, i, time + own + other)};

    stage[i] = path->to.state[i] = path->from.state[i];
    if (!f->law->evolve) continue;
    stage[i] = SlipPermeabilityEvolve(f->law, &c, path->from.state[i], PetscMax(slip[1] - slip[0], 0), own);
    path->to.state[i] = SlipPermeabilityEvolve(f->law, &c, stage[i], PetscMax(slip[2] - slip[1], 0), other);
  }
}

/* Computes the normal stress at t [n] [Pa] without any slip and without this fluid; it may be negative. */
PetscErrorCode SlipFluidHold(SlipFault fault, PetscReal t, PetscReal stress[])
{
  PetscFunctionBegin;
  PetscCall((*fault->fluid.given)(&fault->loads, t, stress));
  SlipLoadsAddTerms(&fault->loads, t, PETSC_FALSE, NULL, NULL, stress);
  for (PetscInt i = 0; i < fault->mesh.n; i++) stress[i] = fault->fields.cell[FIELD_NORMAL_STRESS][i] - stress[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the permeability of the cells at t from their k* and the pressure. Collective. */
PetscErrorCode SlipFluidPermeability(SlipFault fault, const SlipFluidPath *path, PetscReal t, const PetscReal state[],
                                     const PetscReal pressure[], PetscReal k[])
{
  SlipFaultFluid *f = &fault->fluid;
  const SlipFluidDrive *drive = &path->drive;
  PetscReal *hold = f->work[FLUID_WORK_HOLD];

  PetscFunctionBegin;
  if (f->stressed) PetscCall(SlipFluidHold(fault, t, hold));
  for (PetscInt i = 0; i < fault->mesh.n; i++) {
    const SlipPermeability c = Law(fault, i);
    const PetscReal stress =
      f->stressed ? hold[i] + drive->extra[i] + drive->extra_rate[i] * (t - path->start) - pressure[i] : 0;

    k[i] = SlipPermeabilityValue(f->law, &c, state[i], PetscMax(stress, 0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
