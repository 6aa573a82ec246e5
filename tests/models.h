/* What tests of the small models share. */
#pragma once
#include "unit.h"
#include <slipstep/rooms/slipmodels.h>

#define CIRCUIT_N 3 /* states */

/* One of the model's own observations in the state w at time 0 */
static inline PetscReal ObserveModel(SlipModel model, const PetscReal w[], const char name[])
{
  const PetscInt row = SlipModelFindObservation(model, name);
  const SlipModelObservation *o = &model->ops->observations[row];

  assert_true(row >= 0);
  return (*o->value)(model, 0, w, o->k);
}
