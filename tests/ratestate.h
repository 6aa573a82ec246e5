/* Rate-and-state friction of cells, which tests of it share */
#pragma once
#include "unit.h"
#include <slipstep/rooms/slipcore.h>
#include <math.h>

#define EPS PETSC_MACHINE_EPSILON
#define CUTOFF 1e-8 /* V_c of the composite law [m/s] */

static inline const SlipFrictionLaw *Law(void)
{
  const SlipFrictionLaw *law;

  ok(SlipFrictionFind("rate_and_state", &law));
  assert_non_null(law);
  return law;
}

static inline SlipFrictionCells Cells(const PetscReal a[], const PetscReal b[], const PetscReal f0[],
                                      const PetscReal slip[])
{
  return (SlipFrictionCells){.law = Law(),
                             .a = a,
                             .b = b,
                             .reference = f0,
                             .slip = slip,
                             .residual = f0,
                             .drop = f0,
                             .rate = f0,
                             .reference_rate = 1e-6,
                             .cutoff_rate = CUTOFF};
}
