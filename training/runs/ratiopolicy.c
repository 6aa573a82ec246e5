/* See ratiopolicy.h. */
#include "ratiopolicy.h"
#include "common/random.h"
#include <slipcompat.h>

#define LINEAR 0.4 /* slope of the unit that is the controller at the start */
#define DRAWN 0.3  /* standard deviation of the other units' weights */

PetscErrorCode RatioSetUp(CMAOptions *o)
{
  const RatioNetwork *net = o->problem->cma->network;
  const Problem *problem = o->problem;
  void *family = o->family;

  PetscFunctionBegin;
  *o = *net->defaults;
  o->problem = problem;
  o->family = family;
  o->within = (PetscReal)0.95;
  o->interval = 5;
  o->side = 2; /* there are no meshes, and no generations that are late, but options of these */
  o->late_single = 1;
  o->hidden = net->units;
  o->layers = 1;
  o->activation = SLIP_ACTIVATION_TANH;
  o->low = net->dial[0];
  o->high = net->dial[1];
  o->more = PetscMax(o->more, 2);
  PetscCall(CMARowsSet(o, net->rows, net->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt RatioNumbers(const CMAOptions *o)
{
  return CMACount(o) - o->more;
}

void RatioStart(const CMAOptions *o, double w[])
{
  const RatioNetwork *net = o->problem->cma->network;
  const PetscInt n = o->nobs, units = o->hidden;
  double *bias = w + n * units, *out = bias + units;
  Random random;

  RandomSeed(&random, (uint64_t)o->seed);
  for (PetscInt i = 0; i < (n + 1) * units; ++i) w[i] = DRAWN * RandomNormal(&random);
  for (PetscInt i = 0; i < n; ++i) w[i] = 0;
  for (PetscInt i = 0; i < net->rows; ++i) {
    const PetscInt k = CMAFind(o, net->row[i].name); /* -train_observations may have others */

    if (k >= 0) w[k] = LINEAR * net->row[i].start;
  }
  bias[0] = LINEAR * net->bias;
  out[0] = 1 / LINEAR;
  CMARatioStart(net->rtol, net->power, w + RatioNumbers(o));
}

PetscErrorCode RatioPolicy(const CMAOptions *o, const double w[], SlipPolicy policy)
{
  const RatioNetwork *net = o->problem->cma->network;

  return CMARatioPolicy(o, w + RatioNumbers(o), net->unit, net->dial, policy);
}

void RatioRange(const CMAOptions *o, PetscReal low[], PetscReal high[])
{
  CMADialRange(o, o->problem->cma->network->dial, low, high);
}
