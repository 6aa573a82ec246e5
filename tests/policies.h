/* The smallest policy that tests steer by. */
#pragma once
#include "unit.h"

/* y = tanh(weight name + bias), between steps of 1e-2 T* and longest [T*] in geometric proportion. */
static inline SlipPolicy PolicyOfOne(const char name[], PetscReal weight, PetscReal bias, PetscReal longest)
{
  const PetscReal one = 1, zero = 0;
  SlipPolicy p;

  ok(SlipPolicyCreate(PETSC_COMM_SELF, &p));
  ok(SlipPolicySetObservations(p, 1, &name, &one, &zero));
  ok(SlipPolicyAddLayer(p, 1, 1, &weight, &bias, SLIP_ACTIVATION_LINEAR));
  ok(SlipPolicySetAction(p, -1, 1, 1e-2, "T*", longest, "T*", PETSC_TRUE));
  return p;
}
