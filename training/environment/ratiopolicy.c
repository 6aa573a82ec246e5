/* See ratiopolicy.h. */
#include "ratiopolicy.h"
#include "common/random.h"
#include <slipcompat.h>

#define LINEAR 0.4      /* slope of the unit that is the elementary controller */
#define SAFETY (-0.046) /* log10 of its safety factor */
#define DRAWN 0.3       /* standard deviation of the other units' weights */
#define POWER 1         /* of the dial in the tolerance */

PetscErrorCode RatioSetUp(PetscInt rows, const RatioRow row[], PetscInt units, CMAOptions *o)
{
  const char *names[CMA_MAX_OBS + 1] = {NULL};

  PetscFunctionBegin;
  o->hidden = units;
  o->layers = 1;
  o->activation = SLIP_ACTIVATION_TANH;
  o->more = 2;
  for (PetscInt i = 0; i < rows; ++i) names[i] = row[i].name;
  PetscCall(CMAObservationsSet(o, names));
  for (PetscInt i = 0; i < rows; ++i) {
    o->scale[i] = (PetscReal)row[i].scale;
    o->offset[i] = (PetscReal)row[i].offset;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void RatioStart(const CMAOptions *o, const RatioRow row[], double rtol, double w[])
{
  const PetscInt n = o->nobs, units = o->hidden;
  double *bias = w + n * units, *out = bias + units;
  Random random;

  RandomSeed(&random, (uint64_t)o->seed);
  for (PetscInt i = 0; i < (n + 1) * units; ++i) w[i] = DRAWN * RandomNormal(&random);
  for (PetscInt i = 0; i < n; ++i) w[i] = LINEAR * row[i].start;
  bias[0] = LINEAR * SAFETY;
  out[0] = 1 / LINEAR;
  CMARatioStart(rtol, POWER, out + units + 1);
}
